//! Fills a grid with static solutions, in parallel over centre distance and mesh position.

use super::source::{Sample, StaticSource};
use gearmesh::gear::Flank;
use gearmesh::table::{Axes, FlankGrid, TableError};
use gearmesh::words::rounded;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Watches a sweep from outside: counts what is done and can stop it.
pub struct Watch<'a> {
    /// Called with (solves done, solves in all), from any thread.
    pub progress: &'a (dyn Fn(usize, usize) + Sync),
    /// Set it to stop; the sweep then ends with [`TableError::Cancelled`].
    pub cancel: &'a AtomicBool,
}

/// Solves at every node of `axes` for one flank: the displacements are imposed, so nothing is inverted.
/// The top load is `maximum_torque`, N m on gear 1.
///
/// # Errors
/// The first solve that fails, with its operating point; cancellation.
pub fn sweep(
    source: &dyn StaticSource,
    flank: Flank,
    axes: &Axes,
    maximum_torque: f64,
    watch: &Watch,
) -> Result<FlankGrid, TableError> {
    let [nc, nm, nu, np] = axes.lengths();
    let total = nc * nm * (nu + 1) * np;
    let done = AtomicUsize::new(0);
    // Over (centre distance, mesh position): misalignments, first touch and displacements.
    let columns: Vec<Vec<Sample>> = (0..nc * np)
        .into_par_iter()
        .map(|k| {
            let c = axes.center_distance_offset[k / np];
            let p = axes.mesh_position[k % np];
            let failed = |m: f64, message| TableError::Solve {
                point: point(flank, c, m, p),
                message,
            };
            let mut at = source.position(flank, p, c).map_err(|e| failed(0.0, e))?;
            let mut column = Vec::with_capacity(nm * (nu + 1));
            for &m in &axes.misalignment {
                if watch.cancel.load(Ordering::Relaxed) {
                    return Err(TableError::Cancelled);
                }
                let low = at.no_load_approach(m);
                let top = at.top(maximum_torque, m).map_err(|e| failed(m, e))?;
                let mut samples = vec![top; nu + 1];
                samples[0].approach = low;
                // From the top down each solution starts from a near one; the top itself is known.
                for (u, sample) in (axes.displacement_fraction.iter().zip(&mut samples[1..]))
                    .rev()
                    .skip(1)
                {
                    let delta = low + u * (top.approach - low);
                    *sample = at.at_approach(delta, m).map_err(|e| failed(m, e))?;
                }
                column.append(&mut samples);
                let count = done.fetch_add(nu + 1, Ordering::Relaxed) + nu + 1;
                (watch.progress)(count, total);
            }
            Ok(column)
        })
        .collect::<Result<_, _>>()?;

    let mut grid = FlankGrid {
        axes: axes.clone(),
        no_load_approach: vec![],
        top_load_approach: vec![],
        loa_force: vec![],
        moment: None,
    };
    let mut moment = vec![];
    for block in in_order(&columns, np).chunks((nu + 1) * np) {
        let (low, samples) = block.split_at(np);
        let top = &samples[(nu - 1) * np..];
        grid.no_load_approach.extend(low.iter().map(|s| s.approach));
        grid.top_load_approach
            .extend(top.iter().map(|s| s.approach));
        grid.loa_force.extend(samples.iter().map(|s| s.loa_force));
        moment.extend(samples.iter().map(|s| s.moment));
    }
    grid.moment = Some(moment);
    Ok(grid)
}

/// What `columns` over (centre distance, mesh position) hold, in the order of tables: the mesh position, of which there are
/// `positions`, fastest.
pub(super) fn in_order<S: Copy>(columns: &[Vec<S>], positions: usize) -> Vec<S> {
    let rows = columns.chunks(positions);
    rows.flat_map(|row| {
        (0..row[0].len()).flat_map(move |at| row.iter().map(move |column| column[at]))
    })
    .collect()
}

/// An operating point in words.
pub(super) fn point(flank: Flank, c: f64, m: f64, p: f64) -> String {
    format!(
        "{flank:?} flank, center_distance_offset_um {}, misalignment_mrad {}, mesh_position {p}",
        rounded(1e6 * c),
        rounded(1e3 * m)
    )
}
