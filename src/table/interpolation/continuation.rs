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

/// Shortens the guards of `c` and `m`, each end by itself, until `span` and the coefficients `force` over u stay legal beyond
/// each end of each axis and beyond both at once.
pub fn limit<const N: usize>(
    c: &mut Basis<N>,
    m: &mut Basis<N>,
    span: &Block,
    force: &Block,
) -> Result<(), TableError> {
    let least = span.values.iter().copied().fold(f64::INFINITY, f64::min);
    if least <= 0.0 {
        return Err(TableError::TooCoarse { least_m: least });
    }
    // Where the axes 0 and 1 have levelled out beyond the ends given.
    let legal = |axes: [&Basis<N>; 2], ends: [Option<usize>; 2]| {
        let far_out = |block: &Block| {
            let mut block = block.clone();
            for (axis, (basis, end)) in axes.into_iter().zip(ends).enumerate() {
                if let Some(end) = end {
                    block = block.combined(axis, &basis.far_end(end));
                }
            }
            block
        };
        let force = far_out(force);
        let stride = force.stride(2);
        let increases = |start: usize| {
            let line = force.values[start..].iter().step_by(stride);
            line.take(force.lengths[2]).is_sorted()
        };
        far_out(span).values.iter().all(|&v| v >= 0.5 * least) && force.lines(2).all(increases)
    };
    // What is linear in either coordinate is extreme at the corners: legal there, legal between.
    const BEYOND: [[Option<usize>; 2]; 8] = [
        [Some(0), None],
        [None, Some(0)],
        [Some(1), None],
        [None, Some(1)],
        [Some(0), Some(0)],
        [Some(0), Some(1)],
        [Some(1), Some(0)],
        [Some(1), Some(1)],
    ];
    for ends in BEYOND {
        if ends[0].is_some() && !c.present() || ends[1].is_some() && !m.present() {
            continue;
        }
        for _ in 0..HALVINGS {
            if legal([c, m], ends) {
                break;
            }
            for (basis, end) in [&mut *c, &mut *m].into_iter().zip(ends) {
                if let Some(end) = end {
                    basis.guard[end] *= 0.5;
                }
            }
        }
    }
    Ok(())
}
