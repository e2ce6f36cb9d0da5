//! Rows of influence at several nodes at once, lane by lane.

use std::hint::black_box;

/// Numbers that are combined at once.
pub const LANES: usize = 4;
/// As many values of a node.
pub type Lanes = [f32; LANES];
/// Offsets of the centre distance that are combined.
pub const OFFSETS: usize = 3;
/// Rows of the four nodes along the cycle at one offset, all as long.
pub type Rows<'a> = [&'a [Lanes]; 4];

/// Adds the sum of `rows`, weighted, to `entries`.
#[inline(always)]
pub fn combine(entries: &mut [[f64; LANES]], weights: &[f64; 4], [a, b, c, d]: Rows<'_>) {
    // Zipped, so that one end is looked for, not that of every row.
    let rows = a.iter().zip(b).zip(c.iter().zip(d));
    for (entry, ((a, b), (c, d))) in entries.iter_mut().zip(rows) {
        // Groups one by one: left to itself the compiler takes several at once, lane by lane, with more shuffles than sums.
        black_box(());
        let mut sums = *entry;
        for (weight, row) in weights.iter().zip([a, b, c, d]) {
            for lane in 0..LANES {
                sums[lane] += weight * f64::from(row[lane]);
            }
        }
        *entry = sums;
    }
}

/// Adds the products of `y` and each of `rows` to `sums`, lane by lane.
#[inline(always)]
pub fn add_products(sums: &mut [[f64; LANES]; 4], y: &[[f64; LANES]], [a, b, c, d]: Rows<'_>) {
    let rows = a.iter().zip(b).zip(c.iter().zip(d));
    let mut all = *sums;
    for (y, ((a, b), (c, d))) in y.iter().zip(rows) {
        for (sums, row) in all.iter_mut().zip([a, b, c, d]) {
            for lane in 0..LANES {
                sums[lane] += y[lane] * f64::from(row[lane]);
            }
        }
    }
    *sums = all;
}
