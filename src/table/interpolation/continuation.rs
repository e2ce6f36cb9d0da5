//! How far the continuation beyond the ends of C and M stays linear.
//!
//! Beyond an end every coefficient goes on with its slope there and levels out at twice the guard distance
//! ([`Basis::guard`]), so that the force has a continuous slope and its stiffness, far out, a constant value. A
//! guard is as long as nothing loses its meaning on the way: the span keeps at least half of its least value,
//! and no force decreases over the displacement.

use super::basis::Basis;
use super::fit::Block;
use crate::table::TableError;

/// A guard halved this often is shorter than any coordinate can tell: never reached, since spans are positive
/// and forces increase strictly within the range (`fit::make_increasing`).
const HALVINGS: usize = 50;

/// Spans (row 1) out of the coefficients of no-load approach (row 0) and span.
pub fn spans(fields: &Block) -> Block {
    let row = fields.stride(2);
    let mut lengths = fields.lengths;
    lengths[2] = 1;
    let rows = fields.values.chunks(2 * row).flat_map(|c| &c[row..]);
    Block {
        lengths,
        values: rows.copied().collect(),
    }
}

/// Shortens the guards of `c` and `m`, each end by itself, until `span` and, where given, the coefficients `force`
/// over u stay legal beyond each end of each axis and beyond both at once.
///
/// # Errors
/// A span that is not positive within the range.
pub fn limit<const N: usize>(
    c: &mut Basis<N>,
    m: &mut Basis<N>,
    span: &Block,
    force: Option<&Block>,
) -> Result<(), TableError> {
    let least = span.values.iter().copied().fold(f64::INFINITY, f64::min);
    if least <= 0.0 {
        return Err(TableError::TooCoarse { least_m: least });
    }
    let legal = |along_c: Option<Vec<f64>>, along_m: Option<Vec<f64>>| {
        let at = |block: &Block| {
            let on = |b: &Block, axis, row: &Option<Vec<f64>>| {
                row.as_ref().map(|row| b.combined(axis, row))
            };
            let first = on(block, 0, &along_c);
            let first = first.as_ref().unwrap_or(block);
            on(first, 1, &along_m).unwrap_or_else(|| first.clone())
        };
        let increases = |force: &Block| {
            let f = at(force);
            let (n, stride) = (f.lengths[2], f.stride(2));
            f.lines(2).all(|start| {
                let v = |r: usize| f.values[start + r * stride];
                (1..n).all(|r| v(r) >= v(r - 1))
            })
        };
        at(span).values.iter().all(|&v| v >= 0.5 * least) && force.is_none_or(increases)
    };
    for end in 0..2 {
        for _ in 0..HALVINGS {
            if !c.present() || legal(Some(c.far_end(end)), None) {
                break;
            }
            c.guard[end] *= 0.5;
        }
        for _ in 0..HALVINGS {
            if !m.present() || legal(None, Some(m.far_end(end))) {
                break;
            }
            m.guard[end] *= 0.5;
        }
    }
    // What is linear in either coordinate is extreme at the corners: legal there, legal between.
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        for _ in 0..HALVINGS {
            if !c.present() || !m.present() || legal(Some(c.far_end(i)), Some(m.far_end(j))) {
                break;
            }
            c.guard[i] *= 0.5;
            m.guard[j] *= 0.5;
        }
    }
    Ok(())
}
