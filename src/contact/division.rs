//! Where the bulk ends and the local contact begins.
//!
//! With c = sum of 2 (1 - nu²) / (pi E), a strip of the length l and the line load w, the local contact
//! h(w) = c w (ln(2 L / b) + 1/2) and the strip's own entry A_ii of the bulk matrix act as one: the model stays
//! the same when L becomes L' and A_ii becomes A_ii - c ln(L' / L) / l. But the law of local contact rises
//! only up to b = 2 L, and near a tip edge, where the kernel that spreads the load is narrow, L is smaller
//! than the contacts of high loads and of the flat flanks of internal pairs are wide. So as much as possible is
//! moved from the bulk to the local contact: as long as the bulk matrix stays positive definite, the
//! problem stays convex with one solution.

use super::cholesky::Cholesky;

/// Reference length that is aimed at, in normal modules: contacts up to half a module wide stay within the law.
pub const WANTED_LENGTH: f64 = 0.15;

/// Parts of the wanted length that are tried, in this order. What is already longer stays, so that a shorter
/// one moves less, and in the end only next to the edges.
const PARTS: [f64; 6] = [1.0, 0.8, 0.65, 0.5, 0.35, 0.2];

/// Part of c / l that has to be left in the bulk matrix.
const MARGIN: f64 = 0.02;

/// Moves displacement from the diagonal of `bulk` (row by row, m/N) to the local contact, whose reference
/// lengths `lengths` (m; of every strip, per gear) grow to `wanted` (m) or as near to it as the bulk matrix
/// stays positive definite. `c` is that of each gear, 1/Pa, `strip` the length of each strip along its
/// contact line, m.
pub fn divide(
    bulk: &mut [f64],
    lengths: &mut [Vec<f64>; 2],
    c: [f64; 2],
    strip: &[f64],
    wanted: f64,
) {
    let n = strip.len();
    let mut factor = Cholesky::default();
    for length in PARTS.map(|part| part * wanted) {
        let grown = |gear: usize, i: usize| (length / lengths[gear][i]).ln().max(0.0);
        let moved: Vec<f64> = (0..n)
            .map(|i| (c[0] * grown(0, i) + c[1] * grown(1, i)) / strip[i])
            .collect();
        if moved.iter().all(|m| *m == 0.0) {
            return;
        }
        let left = |i: usize, j: usize| {
            let taken = if i == j {
                moved[i] + MARGIN * (c[0] + c[1]) / strip[i]
            } else {
                0.0
            };
            bulk[i * n + j] - taken
        };
        if factor.factor(n, left).is_ok() {
            for (i, moved) in moved.into_iter().enumerate() {
                bulk[i * n + i] -= moved;
            }
            for known in lengths.iter_mut().flatten() {
                *known = known.max(length);
            }
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const C: [f64; 2] = [3e-12, 2e-12];

    #[test]
    fn what_the_bulk_gives_away_the_local_contact_takes() {
        let strip = [1e-3, 2e-3];
        let mut bulk = vec![3e-8, 1e-8, 1e-8, 2e-8];
        let mut lengths = [vec![0.1e-3, 0.3e-3], vec![0.05e-3, 0.9e-3]];
        let (before, old) = (bulk.clone(), lengths.clone());
        divide(&mut bulk, &mut lengths, C, &strip, 0.4e-3);
        assert_relative_eq!(lengths[0][0], 0.4e-3, max_relative = 1e-14);
        assert_relative_eq!(lengths[1][0], 0.4e-3, max_relative = 1e-14);
        assert_eq!(lengths[1][1], 0.9e-3, "already longer than wanted");
        for i in 0..2 {
            let logs: f64 = (0..2)
                .map(|g| C[g] * (lengths[g][i] / old[g][i]).ln())
                .sum();
            let taken = before[i * 3] - bulk[i * 3];
            assert_relative_eq!(taken, logs / strip[i], max_relative = 1e-12);
        }
        assert_eq!((bulk[1], bulk[2]), (1e-8, 1e-8));
    }

    #[test]
    fn no_more_is_moved_than_the_bulk_can_give() {
        let strip = [1e-3];
        let mut lengths = [vec![0.1e-3], vec![0.1e-3]];
        // The whole length, ln 4, would take 6.9e-9; half of it fits.
        let mut bulk = vec![4e-9];
        divide(&mut bulk, &mut lengths, C, &strip, 0.4e-3);
        assert_relative_eq!(bulk[0], 4e-9 - 5e-9 * 2f64.ln(), max_relative = 1e-12);
        assert_relative_eq!(lengths[0][0], 0.2e-3, max_relative = 1e-12);

        let mut lengths = [vec![0.1e-3], vec![0.1e-3]];
        let mut bulk = vec![1e-10];
        divide(&mut bulk, &mut lengths, C, &strip, 0.4e-3);
        assert_eq!((bulk[0], lengths[0][0]), (1e-10, 0.1e-3));
    }
}
