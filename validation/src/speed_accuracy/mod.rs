//! Speed against accuracy: what interpolants, instances, hosts, steps and levels cost in time and in error.

pub mod hosts;
pub mod instances;
pub mod interpolants;
pub mod levels;
pub mod run_up;

use crate::setup::{Setup, shipped_at};
use crate::{Context, Result};
use gearmesh::contact::ContactSettings;
use gearmesh::element::{LoadedFlank, Parameters, StiffnessModel};
use gearmesh::table::{Axis, FlankGrid};
use gearmesh_preprocessor::gear::Refinement;
use std::sync::OnceLock;

/// Pair of most chapters.
const PAIR: &str = "palermo2013";

/// That pair on coarse elements, and samples of it over all four dimensions.
pub struct Sampled {
    setup: Setup,
    grid: FlankGrid,
}

impl Sampled {
    /// Solved once for all chapters.
    fn of(context: &Context) -> Result<&'static Self> {
        static SAMPLED: OnceLock<Sampled> = OnceLock::new();
        if let Some(sampled) = SAMPLED.get() {
            return Ok(sampled);
        }
        eprintln!("    samples of the contact solver");
        let setup = coarse(PAIR)?;
        let grid = setup.samples([16, 9, 17, if context.quick { 32 } else { 64 }])?;
        Ok(SAMPLED.get_or_init(|| Self { setup, grid }))
    }
}

/// The shipped pair `name` on coarse elements, with as many segments as other refinements have.
fn coarse(name: &str) -> Result<Setup> {
    let pair = shipped_at(name, Refinement::Coarse)?;
    Setup::new(pair, Some(ContactSettings::default().stations))
}

/// Held-out points per scene.
fn points(context: &Context) -> usize {
    if context.quick { 200 } else { 1000 }
}

/// Every `step`-th node of `grid` along (displacement, centre distance, misalignment, mesh position),
/// ends kept; a step of 0 takes the nominal node alone.
fn thinned(grid: &FlankGrid, steps: [usize; 4]) -> FlankGrid {
    let axes = [
        Axis::Displacement,
        Axis::CenterDistance,
        Axis::Misalignment,
        Axis::MeshPosition,
    ];
    let mut thin = grid.clone();
    for (axis, step) in axes.into_iter().zip(steps) {
        let nodes = thin.axes.nodes()[axis as usize].to_vec();
        let nominal = (0..nodes.len()).min_by(|&i, &j| nodes[i].abs().total_cmp(&nodes[j].abs()));
        // The last displacement, the top load, is the one that must stay.
        let first = if axis == Axis::Displacement {
            step - 1
        } else {
            0
        };
        let chosen: Vec<usize> = match step {
            0 => nominal.into_iter().collect(),
            _ => (first..nodes.len()).step_by(step).collect(),
        };
        thin = thin.with_nodes(axis, &chosen);
    }
    thin
}

/// Parameters with every effect on.
fn everything(setup: &Setup) -> Parameters {
    Parameters {
        stiffness_model: StiffnessModel::Table,
        nominal_torque: setup.pair.operating.nominal_torque,
        loaded_flank: LoadedFlank::Both,
        ..Parameters::default()
    }
}
