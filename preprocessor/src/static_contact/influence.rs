//! How segments deflect under each other's forces, and where the bulk ends and the local contact begins.
//!
//! With c = sum of 2 (1 - nu²) / (pi E), a segment of the length l and the line load w, the local contact
//! h(w) = c w (ln(2 L / b) + 1/2) and the segment's own entry A_ii of the bulk matrix act as one: the model stays
//! the same when L becomes L' and A_ii becomes A_ii - c ln(L' / L) / l. But the law of local contact rises
//! only up to b = 2 L, and near a tip edge, where the kernel that spreads the load is narrow, L is smaller
//! than the contacts of high loads and of the flat flanks of internal pairs are wide. So L' is made as long as the
//! contacts of the pair's loads ask for.
//!
//! A load that changes from segment to segment faster than the elements resolve, or within the width of contact,
//! leaves the bulk nothing to be taken off: there the discretisation is what yields. What is taken off the bulk is
//! then not D = c ln(L' / L) / l alone but theta D + (1 - theta) S' D S, S the mean of the line load over
//! neighbours on the same contact line, weighted with their lengths. For loads that are smooth along the
//! line this is D, and the sum of bulk and local contact as before; for rough ones a part of the local law's D
//! remains, the compliance that the elements lack there. theta is the largest that leaves the bulk matrix
//! positive definite; like its eigenvalues it follows the mesh position without jumps.

use nalgebra::{DMatrix, DVector};

use super::motion::{Beside, OfGear, Piece};
use crate::compliance::{BeyondModel, ToothCompliance};
use gearmesh::contact::{Candidate, ContactLines, Influence, Segment};
use gearmesh::root::bracket;

/// Range over which a load is smoothed along the contact line, over the layers of the elements: elements
/// know no load that alternates within a layer. Measured: least at which the bulk stays positive definite at all levels.
const SMOOTHING_OVER_LAYER: f64 = 1.5;

/// The same over the reference length L. A half-space under a line load of the wavelength 2 l deflects
/// by c (ln(2 l / (pi L)) - 0.577): nothing is left at l = 2.8 L.
const SMOOTHING_OVER_REFERENCE: f64 = 3.0;

/// Largest part of the displacement of a whole contact line under an even load that the local contact takes
/// over: the law of a line contact does not hold for lines shorter than their contact is wide.
const SHARE_OF_A_LINE: f64 = 0.5;

/// How far the bulk matrix may be from positive definite, over c / l, of which local contact adds ln(4/3) at least: rounding makes
/// the matrix of segments much shorter than the elements indefinite.
const INDEFINITE: f64 = 2e-5;

/// Halvings in the search for the share that the bulk matrix can give: to 1e-6.
const BISECTIONS: usize = 20;

/// Influence of `candidates` of `lines`, which the gears see as `seen`, with their elastic models `compliance`.
///
/// # Errors
/// [`BeyondModel`] for segments on teeth farther apart than the models go.
pub fn influence(
    lines: &ContactLines<'_>,
    compliance: [&dyn ToothCompliance; 2],
    candidates: &[Candidate],
    seen: &[[Segment; 2]],
) -> Result<Influence, BeyondModel> {
    let (numbers, reference) = (&lines.section.numbers, lines.setup.reference_length);
    let n = candidates.len();
    let gears = lines.setup.geometry.gears.each_ref();
    let c = gears.map(|gear| 2.0 * gear.plane_compliance() / std::f64::consts::PI);
    let pieces = candidates.iter().map(|candidate| Piece {
        line: candidate.tooth_pair,
        at: candidate.middle() / numbers.cos_beta_b,
        length: candidate.length(numbers.cos_beta_b),
    });
    let pieces: Vec<Piece> = pieces.collect();
    let bent = lines.setup.settings.bent_teeth;
    let mut beside = bent.then(|| Beside::new(lines, candidates, seen, &pieces));
    let mut bulk = DMatrix::zeros(n, n);
    let mut lengths = [Vec::new(), Vec::new()];
    for (gear, model) in compliance.into_iter().enumerate() {
        let segments: Vec<Segment> = seen.iter().map(|both| both[gear]).collect();
        let of_gear = OfGear {
            gear,
            model,
            lengths: model.reference_lengths(&segments),
            segments,
            // The models know forces along the normal of their own flank; at a tip edge they act along that of its mate. What
            // turns the body and bends the tooth is the component along the circumference, by the arm that of the force along
            // the own normal; measured: within a tenth of what the direction does to the transmission error.
            arms: candidates.iter().map(|c| c.arms[gear]).collect(),
            plane_compliance: c[gear],
        };
        bulk += match &mut beside {
            Some(beside) => beside.add(&of_gear)?,
            None => of_gear.bulk()?,
        };
        lengths[gear] = of_gear.lengths;
    }
    bulk.fill_upper_triangle_with_lower_triangle();
    let motion = beside.map(|beside| beside.motion(&bulk, lines.setup));
    let layers = compliance.map(|model| model.lengthwise_resolution() / numbers.cos_beta_b);
    let thickest = SMOOTHING_OVER_LAYER * layers[0].max(layers[1]);
    let smoothing = thickest.max(SMOOTHING_OVER_REFERENCE * reference);
    let mut influence = Influence {
        bulk,
        lengths,
        motion,
    };
    divide(&mut influence, c, &pieces, reference, smoothing);
    Ok(influence)
}

/// Moves displacement from the bulk matrix to the local contact, whose reference lengths grow to `reference` (m), or as near to
/// it as the bulk matrix can give. Segments of one line follow each other in `pieces`, and share a mean line load up to the
/// distance `smoothing` (m). `c` is that of each gear, 1/Pa.
fn divide(
    influence: &mut Influence,
    c: [f64; 2],
    pieces: &[Piece],
    reference: f64,
    smoothing: f64,
) {
    let n = pieces.len();
    let lengths = &influence.lengths;
    // c ln(L' / L) of both gears.
    let taken = (0..n).map(|i| {
        let of_gears = (0..2).map(|g| c[g] * growth(lengths[g][i], reference));
        of_gears.sum::<f64>()
    });
    let taken: Vec<f64> = taken.collect();
    let mut share = vec![0.0; n];
    // S' D S.
    let mut smooth = DMatrix::zeros(n, n);
    let mut begin = 0;
    for line in pieces.chunk_by(|a, b| a.line == b.line) {
        let range = begin..begin + line.len();
        begin = range.end;
        let even = DVector::from_fn(line.len(), |i, _| line[i].length);
        let asked: f64 = range.clone().map(|i| taken[i] * pieces[i].length).sum();
        if asked <= 0.0 {
            continue;
        }
        // Displacements of the line under an even load, times that load.
        let given = (influence.bulk.view_range(range.clone(), range.clone()) * &even).dot(&even);
        let part = (SHARE_OF_A_LINE * given / asked).clamp(0.0, 1.0);
        share[range.clone()].fill(part);
        let mut block = smooth.view_range_mut(range.clone(), range.clone());
        for (at, taken) in line.iter().zip(&taken[range]) {
            // Smooth, so that little of a load that alternates from segment to segment is left.
            let weights = DVector::from_fn(line.len(), |i, _| {
                let t = (line[i].at - at.at) / smoothing;
                (1.0 - t * t).max(0.0).powi(2)
            });
            let sum = weights.dot(&even);
            let scale = part * taken * at.length / (sum * sum);
            block.ger(scale, &weights, &weights, 1.0);
        }
    }
    if share.iter().all(|s| *s == 0.0) {
        return;
    }
    // What is left once all of it or a part is taken off, theta of it from the diagonal.
    let left = |all: f64, theta: f64| {
        let mut left = &influence.bulk - &smooth * (all * (1.0 - theta));
        for (i, piece) in pieces.iter().enumerate() {
            left[(i, i)] -= all * theta * share[i] * taken[i] / piece.length;
        }
        left
    };
    let is_legal = |all: f64, theta: f64| {
        let mut left = left(all, theta);
        for (i, piece) in pieces.iter().enumerate() {
            left[(i, i)] += INDEFINITE * (c[0] + c[1]) / piece.length;
        }
        left.cholesky().is_some()
    };
    let (all, theta) = if is_legal(1.0, 1.0) {
        (1.0, 1.0)
    } else if is_legal(1.0, 0.0) {
        (1.0, largest(|theta| is_legal(1.0, theta)))
    } else {
        (largest(|all| is_legal(all, 0.0)), 0.0)
    };
    influence.bulk = left(all, theta);
    for known in &mut influence.lengths {
        for (length, share) in known.iter_mut().zip(&share) {
            *length *= (all * share * growth(*length, reference)).exp();
        }
    }
}

/// The largest part that leaves a legal matrix, as all below it do; the whole does not.
fn largest(is_legal: impl Fn(f64) -> bool) -> f64 {
    bracket([0.0, 1.0], BISECTIONS, is_legal)[0]
}

/// ln(reference / length), zero where the length is longer.
fn growth(length: f64, reference: f64) -> f64 {
    (reference / length).ln().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const C: [f64; 2] = [3e-12, 2e-12];

    fn piece(line: i32, at: f64, length: f64) -> Piece {
        Piece { line, at, length }
    }

    fn divided(
        bulk: &DMatrix<f64>,
        lengths: &[Vec<f64>; 2],
        pieces: &[Piece],
        reference: f64,
        smoothing: f64,
    ) -> Influence {
        let (bulk, lengths) = (bulk.clone(), lengths.clone());
        let mut influence = Influence {
            bulk,
            lengths,
            motion: None,
        };
        divide(&mut influence, C, pieces, reference, smoothing);
        influence
    }

    #[test]
    fn what_the_bulk_gives_away_the_local_contact_takes() {
        let segments = [piece(0, 0.0, 1e-3), piece(1, 0.0, 2e-3)];
        let before = DMatrix::from_row_slice(2, 2, &[3e-8, 1e-8, 1e-8, 2e-8]);
        let old = [vec![0.1e-3, 0.3e-3], vec![0.05e-3, 0.9e-3]];
        let Influence { bulk, lengths, .. } = divided(&before, &old, &segments, 0.4e-3, 1e-3);
        assert_relative_eq!(lengths[0][0], 0.4e-3, max_relative = 1e-14);
        assert_relative_eq!(lengths[1][0], 0.4e-3, max_relative = 1e-14);
        assert_eq!(lengths[1][1], 0.9e-3, "already longer than wanted");
        for (i, segment) in segments.iter().enumerate() {
            let logs: f64 = (0..2)
                .map(|g| C[g] * (lengths[g][i] / old[g][i]).ln())
                .sum();
            let taken = before[i * 3] - bulk[i * 3];
            assert_relative_eq!(taken, logs / segment.length, max_relative = 1e-12);
        }
        assert_eq!((bulk[1], bulk[2]), (1e-8, 1e-8));
    }

    #[test]
    fn the_line_under_an_even_load_deflects_as_before_however_finely_it_is_cut() {
        for count in [4_usize, 40] {
            let length = 8e-3 / count as f64;
            let segments: Vec<Piece> = (0..count)
                .map(|i| piece(0, (i as f64 + 0.5) * length, length))
                .collect();
            // Much alike all over: no room for a matrix that is diagonal.
            let bulk = DMatrix::from_fn(count, count, |i, j| {
                5e-8 * (-(segments[i].at - segments[j].at).abs() / 4e-3).exp()
            });
            let lengths = [vec![0.05e-3; count], vec![0.1e-3; count]];
            let energy = |bulk: &DMatrix<f64>| 1e-6 * bulk.sum() * length * length;
            let before = energy(&bulk);
            let Influence { bulk, lengths, .. } =
                divided(&bulk, &lengths, &segments, 0.2e-3, 1.5e-3);
            let gained = 1e-6
                * 8e-3
                * (C[0] * (lengths[0][0] / 0.05e-3).ln() + C[1] * (lengths[1][0] / 0.1e-3).ln());
            assert!(lengths[0][0] > 0.15e-3, "{}", lengths[0][0]);
            assert_relative_eq!(before - energy(&bulk), gained, max_relative = 2e-2);
        }
    }

    #[test]
    fn no_more_is_moved_than_a_short_line_can_give() {
        let segments = [piece(0, 0.0, 1e-3)];
        let lengths = [vec![0.1e-3], vec![0.1e-3]];
        // ln 4 would take 6.9e-9; half of what there is goes.
        let bulk = DMatrix::from_element(1, 1, 4e-9);
        let Influence { bulk, lengths, .. } = divided(&bulk, &lengths, &segments, 0.4e-3, 1e-3);
        assert_relative_eq!(bulk[0], 2e-9, max_relative = 1e-12);
        let moved = 5e-9 * (lengths[0][0] / 0.1e-3).ln();
        assert_relative_eq!(moved, 2e-9, max_relative = 1e-12);
    }
}
