//! What a force on one tooth pair takes of the approach of the next, told from two of them under load.

use crate::contact::{ContactError, ContactSolver, Prescribed};
use crate::gear::Flank;
use crate::table::TableError;
use crate::table::plan::Coverage;
use crate::table::sweep::point;

/// Places at which two tooth pairs are looked at.
const PLACES: usize = 32;

/// The least part of the force of two tooth pairs that the lesser one carries where they are looked at.
const LEAST_SHARE: f64 = 0.05;

/// The coupling of the drive flank of `solver` under the nominal load of `coverage` with parallel axes, m/N: the least squares of
/// what tooth pairs lack of their approach beside another one.
///
/// # Errors
/// A solve that fails; no place at which two tooth pairs carry.
pub fn coupling(solver: &ContactSolver, coverage: &Coverage) -> Result<f64, TableError> {
    let mut sums = [0.0; 2];
    for i in 0..PLACES {
        let place = -1.0 + i as f64 / PLACES as f64;
        let seen = look(solver, coverage.nominal_torque, place);
        let seen = seen.map_err(|error| TableError::Solve {
            point: point(Flank::Drive, 0.0, 0.0, place),
            message: error.to_string(),
        })?;
        for [lacks, force] in seen.into_iter().flatten() {
            sums[0] += lacks * force;
            sums[1] += force * force;
        }
    }
    if sums[1] == 0.0 {
        return Err(TableError::Samples(
            "no place where two tooth pairs carry: tooth pairs one by one need a contact ratio above 1"
                .into(),
        ));
    }
    Ok(sums[0] / sums[1])
}

/// What each of two tooth pairs at `place` and one base pitch ahead lacks of its approach (m) under `torque`, and the force on the
/// other (N).
fn look(
    solver: &ContactSolver,
    torque: f64,
    place: f64,
) -> Result<Option<[[f64; 2]; 2]>, ContactError> {
    let approach = solver
        .position(Flank::Drive, place, 0.0)?
        .solve_torque(torque, 0.0, None)?
        .approach;
    let both = solver
        .tooth_pairs(Flank::Drive, place, 0.0, 1)?
        .solve_beyond(Prescribed::Approach(approach), 0.0, None)?;
    let forces = [0, 1].map(|k| {
        let own = both.load_share.iter().find(|(pair, _)| *pair == k);
        own.map_or(0.0, |(_, share)| share * both.loa_force)
    });
    if forces[0].min(forces[1]) < LEAST_SHARE * (forces[0] + forces[1]) {
        return Ok(None);
    }
    let base_radius = solver.geometry().gears[0].base_radius();
    let mut seen = [[0.0; 2]; 2];
    for (k, seen) in seen.iter_mut().enumerate() {
        let alone = solver.tooth_pairs(Flank::Drive, place + k as f64, 0.0, 0)?;
        let torque = Prescribed::Torque(forces[k] * base_radius);
        let own = alone.solve_beyond(torque, 0.0, None)?;
        *seen = [approach - own.approach, forces[1 - k]];
    }
    Ok(Some(seen))
}
