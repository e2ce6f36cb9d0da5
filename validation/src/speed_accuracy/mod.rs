//! Speed against accuracy: what tables, interpolants, effects, hosts and steps cost in time and in error.

mod effects;
mod element;
mod growth;
mod hosts;
mod interpolants;
mod levels;
mod run_up;

use crate::data::last_that_holds;
use crate::setup::{Setup, ratio, shipped_at};
use crate::{Chapter, Context, Result, timing};
use gearmesh::contact::ContactSettings;
use gearmesh::element::{Element, Inputs, Latch, LoadedFlank, Parameters, StiffnessModel};
use gearmesh::pair::Refinement;
use gearmesh::random::Random;
use gearmesh::table::{Axis, FlankGrid, Table};
use nalgebra::{Rotation3, Vector3};
use std::sync::Arc;

pub const CHAPTERS: [(&str, Chapter); 8] = [
    ("machine", |_, data| timing::machine(data)),
    ("interpolants", interpolants::report),
    ("element", element::report),
    ("effects", effects::report),
    ("growth", growth::report),
    ("cost-per-second", hosts::cost),
    ("run-up", run_up::report),
    ("levels", levels::report),
];

/// Pair of most chapters.
const PAIR: &str = "palermo2013";

/// That pair on coarse elements, and samples of it over all four dimensions.
pub struct Sampled {
    setup: Setup,
    grid: FlankGrid,
}

impl Sampled {
    fn of(context: &Context) -> Result<&Self> {
        if context.samples.get().is_none() {
            eprintln!("    samples of the contact solver");
            let setup = coarse(PAIR)?;
            let grid = setup.samples([16, 9, 17, if context.quick { 32 } else { 64 }])?;
            let _ = context.samples.set(Self { setup, grid });
        }
        context.samples.get().ok_or_else(|| "no samples".into())
    }
}

/// The shipped pair `name` on coarse elements, with as many segments as other refinements have.
fn coarse(name: &str) -> Result<Setup> {
    let pair = shipped_at(name, Refinement::Coarse)?;
    let mut contact = ContactSettings::default();
    contact.tip_corner_contact = pair.tip_corner_contact;
    Setup::new(pair, contact)
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
        let nodes = thin.axes.along_mut(axis).clone();
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

/// An element with random poses of both gears in contact, as a solver would hand them in.
struct Posed {
    element: Element,
    latch: Latch,
    poses: Vec<Inputs>,
}

/// How far poses spread: centre distance offset, m, tilt of gear 2 about each axis across it, rad, and normal force, N.
struct Spread {
    center_distance: f64,
    tilt: f64,
    normal_force: [f64; 2],
}

impl Posed {
    fn new(
        setup: &Setup,
        parameters: &Parameters,
        table: &Arc<Table>,
        spread: &Spread,
    ) -> Result<Self> {
        let element = Element::new(&setup.pair.geometry, parameters, Some(table.clone()))?;
        let latch = element.latch(&element.nominal_inputs())?;
        let ratio = ratio(&setup.pair.geometry);
        let mut random = Random::new(0x2545_F491_4F6C_DD1D);
        let mut both = |x: f64| random.within([-x, x]);
        let spin = |angle: f64| *Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix();
        let mut poses = vec![];
        for _ in 0..256 {
            let mut inputs = element.nominal_inputs();
            inputs.gears[1].p += Vector3::new(both(spread.center_distance), both(1e-5), both(1e-5));
            let tilt = Rotation3::from_euler_angles(both(spread.tilt), both(spread.tilt), 0.0);
            let turn = both(3.0);
            inputs.gears[1].r = tilt.matrix() * spin(turn * ratio);
            let [low, high] = spread.normal_force;
            let force = 0.5 * (low + high) + 0.5 * both(high - low);
            // Force rises with the angle of gear 1; half a base pitch at most lies between contact and no contact.
            let free = |angle: f64| {
                let mut turned = inputs;
                turned.gears[0].r = spin(turn + angle);
                Ok(element.evaluate(&latch, &turned)?.normal_force < force)
            };
            let [free, deep] = last_that_holds([-5e-3, 5e-3], 40, free)?;
            inputs.gears[0].r = spin(turn + 0.5 * (free + deep));
            for (gear, speed) in inputs.gears.iter_mut().zip([100.0, 100.0 * ratio]) {
                gear.w = Vector3::z() * speed;
                gear.v = Vector3::new(both(1e-3), both(1e-3), both(1e-3));
            }
            poses.push(inputs);
        }
        Ok(Self {
            element,
            latch,
            poses,
        })
    }
}
