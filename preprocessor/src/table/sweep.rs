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
    let columns: Vec<Vec<Column>> = (0..nc * np)
        .into_par_iter()
        .map(|k| {
            let c = axes.center_distance_offset[k / np];
            let p = axes.mesh_position[k % np];
            let failed = |m: f64, message| TableError::Solve {
                point: point(flank, c, m, p),
                message,
            };
            let mut at = source.position(flank, p, c).map_err(|e| failed(0.0, e))?;
            axes.misalignment
                .iter()
                .map(|&m| {
                    if watch.cancel.load(Ordering::Relaxed) {
                        return Err(TableError::Cancelled);
                    }
                    let low = at.no_load_approach(m);
                    let top = at.top(maximum_torque, m).map_err(|e| failed(m, e))?;
                    let mut samples = vec![top; nu];
                    // From the top down each solution starts from a near one; the top itself is known.
                    for (u, sample) in axes
                        .displacement_fraction
                        .iter()
                        .zip(&mut samples)
                        .rev()
                        .skip(1)
                    {
                        let delta = low + u * (top.approach - low);
                        *sample = at.at_approach(delta, m).map_err(|e| failed(m, e))?;
                    }
                    let count = done.fetch_add(nu + 1, Ordering::Relaxed) + nu + 1;
                    (watch.progress)(count, total);
                    Ok(Column { low, samples })
                })
                .collect()
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
    for c in 0..nc {
        // One row of columns per misalignment, all mesh positions of this centre distance.
        let row = &columns[c * np..(c + 1) * np];
        (0..nm).for_each(|m| {
            let at = |p: usize| &row[p][m];
            grid.no_load_approach.extend((0..np).map(|p| at(p).low));
            grid.top_load_approach
                .extend((0..np).map(|p| at(p).samples[nu - 1].approach));
            for u in 0..nu {
                grid.loa_force
                    .extend((0..np).map(|p| at(p).samples[u].loa_force));
                moment.extend((0..np).map(|p| at(p).samples[u].moment));
            }
        });
    }
    grid.moment = Some(moment);
    Ok(grid)
}

/// Solutions at one (centre distance, misalignment, mesh position), displacements ascending.
struct Column {
    low: f64,
    samples: Vec<Sample>,
}

/// An operating point in words.
pub(super) fn point(flank: Flank, c: f64, m: f64, p: f64) -> String {
    format!(
        "{flank:?} flank, center_distance_offset_um {}, misalignment_mrad {}, mesh_position {p}",
        rounded(1e6 * c),
        rounded(1e3 * m)
    )
}
