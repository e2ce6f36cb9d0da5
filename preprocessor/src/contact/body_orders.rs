//! How bodies that are no solids of revolution change the compliance of the mesh with their angle: what the element takes in series.

use std::f64::consts::TAU;

use crate::gear::Pair;
use crate::static_contact::{ContactError, ContactSolver};
use gearmesh::gear::{BodyOrder, BodyOrders, Flank};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Positions of the mesh cycle: what the place of the load on the teeth changes comes again with it.
const POSITIONS: usize = 16;

/// Compliance that the orders left out have at most together, rms, over that of the mesh: a share of the force.
const LEFT_OUT: f64 = 1e-3;
/// Distance of forces from mid-face at which that is measured, over the face.
const LEVER: f64 = 0.2;

/// Compliance by (force, force), (force, moment) and (moment, moment).
type Parts = [f64; 3];

/// The orders of both bodies of `pair` on both flanks, under its nominal torque. None where both are solids of revolution.
///
/// Of the forces f of static contact on the mean body, F and M are made by the patterns df/dF and df/dM, and the work of these on what the body
/// displaces beyond its mean is the compliance: to first order in the change that of the whole contact, as the work of the forces changes by
/// half of f' dA f.
///
/// # Errors
/// As [`ContactSolver::position`] and the solve under the nominal torque.
pub fn body_orders(
    pair: &Pair,
    solver: &ContactSolver,
) -> Result<Option<BodyOrders>, ContactError> {
    if pair.bodies.iter().all(Option::is_none) {
        return Ok(None);
    }
    Ok(Some(BodyOrders {
        drive: on_flank(pair, solver, Flank::Drive)?,
        coast: on_flank(pair, solver, Flank::Coast)?,
    }))
}

/// Those of both bodies on `flank`.
fn on_flank(
    pair: &Pair,
    solver: &ContactSolver,
    flank: Flank,
) -> Result<[Vec<BodyOrder>; 2], ContactError> {
    let places = (0..POSITIONS).into_par_iter();
    let turns = places.map(|i| Turn::new(pair, solver, flank, i as f64 / POSITIONS as f64));
    let turns = turns.collect::<Result<Vec<_>, _>>()?;
    let compliances = turns.iter().map(|turn| turn.mesh_compliance);
    let left_out = LEFT_OUT * compliances.sum::<f64>() / POSITIONS as f64;
    let lever = LEVER * pair.geometry.face_overlap().1;
    Ok([0, 1].map(|gear| orders(&in_order(&turns, gear), lever, left_out)))
}

/// A turn of both bodies at one mesh position.
struct Turn {
    /// Of the whole contact on the mean bodies, m/N.
    mesh_compliance: f64,
    /// What the body of each gear adds after each number of mesh cycles; empty of a solid of revolution.
    gears: [Vec<Parts>; 2],
}

/// What the body of `gear` adds at ascending angles.
fn in_order(turns: &[Turn], gear: usize) -> Vec<Parts> {
    let cycles = 0..turns[0].gears[gear].len();
    cycles
        .flat_map(|cycle| turns.iter().map(move |turn| turn.gears[gear][cycle]))
        .collect()
}

impl Turn {
    /// At the mesh position `tau` under the nominal torque of `pair`.
    fn new(
        pair: &Pair,
        solver: &ContactSolver,
        flank: Flank,
        tau: f64,
    ) -> Result<Turn, ContactError> {
        let problem = solver.position(flank, tau, 0.0)?;
        let found = problem.solve_torque(pair.operating.nominal_torque, 0.0, None)?;
        let slopes = DMatrix::from_fn(found.segments.len(), 2, |i, j| found.segments[i].slopes[j]);
        let tangent = found.tangent;
        let [by_approach, by_misalignment] =
            [tangent.force_by_approach, tangent.force_by_misalignment];
        let stiffness = [
            by_approach,
            by_misalignment,
            by_misalignment,
            tangent.moment_by_misalignment,
        ];
        let mut patterns = match DMatrix::from_row_slice(2, 2, &stiffness).try_inverse() {
            Some(compliance) => slopes * compliance,
            // One segment bears alone: moments do nothing that forces do not.
            None => slopes * DMatrix::from_row_slice(2, 2, &[1.0 / by_approach, 0.0, 0.0, 0.0]),
        };
        // What bears now, and not what more of it would bear, makes the force.
        for (i, segment) in found.segments.iter().enumerate() {
            let by_moment = patterns[(i, 1)];
            patterns[(i, 0)] = (segment.force - by_moment * found.moment) / found.loa_force;
        }
        let mut gears = [vec![], vec![]];
        for (gear, parts) in gears.iter_mut().enumerate() {
            let found = solver.beyond_mean_body(flank, &problem, gear, &patterns)?;
            *parts = (found.into_iter().flatten())
                .map(|c| [c[(0, 0)], 0.5 * (c[(0, 1)] + c[(1, 0)]), c[(1, 1)]])
                .collect();
        }
        Ok(Turn {
            mesh_compliance: 1.0 / by_approach,
            gears,
        })
    }
}

/// The Fourier series of `samples` over a turn without its smallest orders, by the approaches to a force at the `lever` (m) from mid-face: these have the rms value
/// `left_out` (m/N) at most.
fn orders(samples: &[Parts], lever: f64, left_out: f64) -> Vec<BodyOrder> {
    let mut all: Vec<BodyOrder> = (1..samples.len().div_ceil(2))
        .map(|order| of_order(samples, order))
        .collect();
    all.sort_by(|a, b| square(b, lever).total_cmp(&square(a, lever)));
    let mut left: f64 = all.iter().map(|part| square(part, lever)).sum();
    let count = all
        .iter()
        .take_while(|part| {
            let is_needed = 0.5 * left > left_out * left_out;
            left -= square(part, lever);
            is_needed
        })
        .count();
    all.truncate(count);
    all.sort_by_key(|part| part.order);
    all
}

/// Squares of the approaches by a force at the `lever` (m), as the parts of `order` make them.
fn square(order: &BodyOrder, lever: f64) -> f64 {
    let squares = order.parts().map(|[a, b]| a * a + b * b);
    squares[0] + (2.0 * lever).powi(2) * squares[1] + lever.powi(4) * squares[2]
}

fn of_order(samples: &[Parts], order: usize) -> BodyOrder {
    let n = samples.len();
    let mut sums = [[0.0; 2]; 3];
    for (i, parts) in samples.iter().enumerate() {
        let (sin, cos) = (TAU * (order * i % n) as f64 / n as f64).sin_cos();
        for (sum, part) in sums.iter_mut().zip(parts) {
            sum[0] += 2.0 / n as f64 * part * cos;
            sum[1] += 2.0 / n as f64 * part * sin;
        }
    }
    let [approach_m_per_n, tilt_rad_per_n, tilt_rad_per_nm] = sums;
    BodyOrder {
        order: order as u32,
        approach_m_per_n,
        tilt_rad_per_n,
        tilt_rad_per_nm,
    }
}
