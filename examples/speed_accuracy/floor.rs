//! What the arithmetic of a 4-D spline evaluation costs at least on this machine.

use crate::document::Document;
use crate::timing::{Candidate, medians};
use std::hint::black_box;

/// Coefficients under one 4-D cell: 4 x 4 (centre distance, misalignment) x 5 displacement rows x 4 positions.
const BLOCK: usize = 4 * 4 * 5 * 4;

/// Sums over the whole block: the potential, its first and its second derivative over displacement.
const SUMS: usize = 3;

/// The least multiplications and additions: every coefficient into every sum, nothing else, from a
/// block that stays in the nearest cache, with as many independent chains as the sums allow.
fn floor() -> f64 {
    let block: Vec<f64> = (0..BLOCK).map(|i| 1.0 + i as f64).collect();
    let weights: [[f64; SUMS]; 5] =
        std::array::from_fn(|r| std::array::from_fn(|s| 0.1 + (r + s) as f64));
    medians(&mut [Candidate::new(64, || {
        for _ in 0..64 {
            let block: &[f64] = black_box(&block);
            let weights = black_box(&weights);
            let mut sums = [[0.0_f64; 4]; SUMS];
            for rows in block.chunks_exact(20) {
                for (row, w) in rows.chunks_exact(4).zip(weights) {
                    for s in 0..SUMS {
                        for k in 0..4 {
                            sums[s][k] += w[s] * row[k];
                        }
                    }
                }
            }
            black_box(sums);
        }
    })])[0]
}

/// The paragraph.
pub fn report(document: &mut Document, kernel: f64, element: f64) {
    let floor = floor();
    document.paragraph(&format!(
        "Floor: loading the {BLOCK} coefficients under one 4-D cell and multiplying each into {SUMS} sums \
         (potential, force, stiffness), with weights given, no addresses to compute and no derivatives \
         across, takes {floor:.0} ns here with two-lane registers. The spline kernel's value takes {:.1} \
         times that, the whole element {:.1} times.",
        kernel / floor,
        element / floor,
    ));
}
