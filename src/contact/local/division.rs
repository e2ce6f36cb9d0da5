//! Where the bulk ends and the local contact begins.
//!
//! With c = sum of 2 (1 - nu²) / (pi E), a strip of the length l and the line load w, the local contact
//! h(w) = c w (ln(2 L / b) + 1/2) and the strip's own entry A_ii of the bulk matrix act as one: the model stays
//! the same when L becomes L' and A_ii becomes A_ii - c ln(L' / L) / l. But the law of local contact rises
//! only up to b = 2 L, and near a tip edge, where the kernel that spreads the load is narrow, L is smaller
//! than the contacts of high loads and of the flat flanks of internal pairs are wide. So L' is made as long as the
//! contacts of the pair's loads ask for.
//!
//! A load that changes from strip to strip faster than the elements resolve, or within the width of contact,
//! leaves the bulk nothing to give away: there the discretisation gives way. What is taken off the bulk is
//! then not D = c ln(L' / L) / l alone but theta D + (1 - theta) S' D S, S the mean of the line load over
//! neighbours on the same contact line, weighted with their lengths. For loads that are smooth along the
//! line this is D, and the sum of bulk and local contact as before; for rough ones a part of the local law's D
//! remains, the compliance that the elements lack there. theta is the largest that leaves the bulk matrix
//! positive definite; like its eigenvalues it follows the mesh position without jumps.

use super::constants::{INDEFINITE, SHARE_OF_A_LINE};
use crate::contact::cholesky::Cholesky;

/// Halvings in the search for the share that the bulk matrix can give: the rest of 1e-6 is below the tolerance of
/// the contact solve.
const BISECTIONS: usize = 20;

/// A strip on its contact line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Number of the contact line.
    pub line: i32,
    /// Middle of the strip along its contact line, m.
    pub at: f64,
    /// Length along the contact line, m.
    pub length: f64,
}

/// Moves displacement from `bulk` (row by row, m/N) to the local contact, whose reference lengths
/// `lengths` (m; of every strip, per gear) grow to `wanted` (m), or as near to it as the bulk matrix can give.
/// Strips of one contact line stand together in `pieces`. `c` is that of each gear, 1/Pa; `smoothing` (m)
/// the distance along the line up to which strips share a mean line load.
pub fn divide(
    bulk: &mut [f64],
    lengths: &mut [Vec<f64>; 2],
    c: [f64; 2],
    pieces: &[Piece],
    wanted: f64,
    smoothing: f64,
) {
    let n = pieces.len();
    let mut share = vec![0.0; n];
    let mut moved = vec![0.0; n * n];
    let mut begin = 0;
    for line in pieces.chunk_by(|a, b| a.line == b.line) {
        let range = begin..begin + line.len();
        begin = range.end;
        // c ln(L' / L) of both gears.
        let taken: Vec<f64> = range
            .clone()
            .map(|i| (0..2).map(|g| c[g] * growth(lengths[g][i], wanted)).sum())
            .collect();
        // Displacements of the line under an even load, times that load: in the bulk, and to be moved.
        let even: f64 = range
            .clone()
            .flat_map(|i| range.clone().map(move |j| (i, j)))
            .map(|(i, j)| pieces[i].length * bulk[i * n + j] * pieces[j].length)
            .sum();
        let asked: f64 = taken.iter().zip(line).map(|(t, p)| t * p.length).sum();
        if asked <= 0.0 {
            continue;
        }
        let part = (SHARE_OF_A_LINE * even / asked).clamp(0.0, 1.0);
        share[range.clone()].fill(part);
        for (q, at) in line.iter().enumerate() {
            // Smooth, so that little of a load that alternates from strip to strip is left.
            let weight = |p: &Piece| {
                let t = (p.at - at.at) / smoothing;
                (1.0 - t * t).max(0.0).powi(2)
            };
            let weights: Vec<f64> = line
                .iter()
                .enumerate()
                .map(|(k, p)| if k == q { 1.0 } else { weight(p) })
                .collect();
            let sum: f64 = weights.iter().zip(line).map(|(w, p)| w * p.length).sum();
            let scale = part * taken[q] * at.length / (sum * sum);
            for (i, a) in range.clone().zip(&weights) {
                for (j, b) in range.clone().zip(&weights) {
                    moved[i * n + j] += scale * a * b;
                }
            }
        }
    }
    if share.iter().all(|s| *s == 0.0) {
        return;
    }
    let alone: Vec<f64> = (0..n)
        .map(|i| {
            let taken: f64 = (0..2).map(|g| c[g] * growth(lengths[g][i], wanted)).sum();
            share[i] * taken / pieces[i].length
        })
        .collect();
    // What is taken off the entry (i, j), all of it or a part, theta of it from the diagonal.
    let off = |i: usize, j: usize, all: f64, theta: f64| {
        let diagonal = if i == j { theta * alone[i] } else { 0.0 };
        all * (diagonal + (1.0 - theta) * moved[i * n + j])
    };
    let mut factor = Cholesky::default();
    let mut is_left = |all: f64, theta: f64| {
        let left = |i: usize, j: usize| {
            let tolerance = if i == j {
                INDEFINITE * (c[0] + c[1]) / pieces[i].length
            } else {
                0.0
            };
            bulk[i * n + j] - off(i, j, all, theta) + tolerance
        };
        factor.factor(n, left).is_ok()
    };
    let (all, theta) = if is_left(1.0, 1.0) {
        (1.0, 1.0)
    } else if is_left(1.0, 0.0) {
        (1.0, largest(|theta| is_left(1.0, theta)))
    } else {
        (largest(|all| is_left(all, 0.0)), 0.0)
    };
    for i in 0..n {
        for j in 0..n {
            bulk[i * n + j] -= off(i, j, all, theta);
        }
    }
    for known in lengths {
        for (length, share) in known.iter_mut().zip(&share) {
            *length *= (all * share * growth(*length, wanted)).exp();
        }
    }
}

/// The largest number in [0, 1], 0 at least, that is `allowed`, if all below it are and 1 is not.
fn largest(mut allowed: impl FnMut(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if allowed(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// ln(wanted / length), zero where the length is longer.
fn growth(length: f64, wanted: f64) -> f64 {
    (wanted / length).ln().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const C: [f64; 2] = [3e-12, 2e-12];

    fn piece(line: i32, at: f64, length: f64) -> Piece {
        Piece { line, at, length }
    }

    #[test]
    fn what_the_bulk_gives_away_the_local_contact_takes() {
        let strips = [piece(0, 0.0, 1e-3), piece(1, 0.0, 2e-3)];
        let mut bulk = vec![3e-8, 1e-8, 1e-8, 2e-8];
        let mut lengths = [vec![0.1e-3, 0.3e-3], vec![0.05e-3, 0.9e-3]];
        let (before, old) = (bulk.clone(), lengths.clone());
        divide(&mut bulk, &mut lengths, C, &strips, 0.4e-3, 1e-3);
        assert_relative_eq!(lengths[0][0], 0.4e-3, max_relative = 1e-14);
        assert_relative_eq!(lengths[1][0], 0.4e-3, max_relative = 1e-14);
        assert_eq!(lengths[1][1], 0.9e-3, "already longer than wanted");
        for (i, strip) in strips.iter().enumerate() {
            let logs: f64 = (0..2)
                .map(|g| C[g] * (lengths[g][i] / old[g][i]).ln())
                .sum();
            let taken = before[i * 3] - bulk[i * 3];
            assert_relative_eq!(taken, logs / strip.length, max_relative = 1e-12);
        }
        assert_eq!((bulk[1], bulk[2]), (1e-8, 1e-8));
    }

    #[test]
    fn an_even_load_on_a_line_gives_way_as_before_however_finely_it_is_cut() {
        for count in [4_usize, 40] {
            let length = 8e-3 / count as f64;
            let strips: Vec<Piece> = (0..count)
                .map(|i| piece(0, (i as f64 + 0.5) * length, length))
                .collect();
            // Much alike all over: no room for a matrix that is diagonal.
            let mut bulk: Vec<f64> = (0..count * count)
                .map(|at| {
                    5e-8 * (-(strips[at / count].at - strips[at % count].at).abs() / 4e-3).exp()
                })
                .collect();
            let mut lengths = [vec![0.05e-3; count], vec![0.1e-3; count]];
            let energy = |bulk: &[f64]| 1e-6 * bulk.iter().sum::<f64>() * length * length;
            let before = energy(&bulk);
            divide(&mut bulk, &mut lengths, C, &strips, 0.2e-3, 1.5e-3);
            let gained = 1e-6
                * 8e-3
                * (C[0] * (lengths[0][0] / 0.05e-3).ln() + C[1] * (lengths[1][0] / 0.1e-3).ln());
            assert!(lengths[0][0] > 0.15e-3, "{}", lengths[0][0]);
            assert_relative_eq!(before - energy(&bulk), gained, max_relative = 2e-2);
        }
    }

    #[test]
    fn no_more_is_moved_than_a_short_line_can_give() {
        let strips = [piece(0, 0.0, 1e-3)];
        let mut lengths = [vec![0.1e-3], vec![0.1e-3]];
        // ln 4 would take 6.9e-9; half of what there is goes.
        let mut bulk = vec![4e-9];
        divide(&mut bulk, &mut lengths, C, &strips, 0.4e-3, 1e-3);
        assert_relative_eq!(bulk[0], 2e-9, max_relative = 1e-12);
        let moved = 5e-9 * (lengths[0][0] / 0.1e-3).ln();
        assert_relative_eq!(moved, 2e-9, max_relative = 1e-12);
    }
}
