//! What a force on one tooth pair takes of the approach of the next, told from two of them under load.

use crate::contact::{ContactError, ContactSolver, PositionProblem, Prescribed};
use crate::gear::Flank;
use crate::table::TableError;
use crate::table::plan::Coverage;
use crate::table::sweep::point;
use crate::words::rounded;
use rayon::prelude::*;

/// Places at which two tooth pairs are looked at.
const PLACES: usize = 32;

/// Loads at each of them, evenly up to the largest: a greater load spreads over the face, where neighbours take less.
const LOADS: usize = 4;

/// The least part of the force of two tooth pairs that the lesser one carries where they are looked at.
const LEAST_SHARE: f64 = 0.05;

/// The coupling on `flank` of `solver` at each of the `misalignments` (rad), m/N: the least squares of what tooth pairs lack of
/// their approach beside another one, over loads up to the largest of `coverage`.
///
/// # Errors
/// A solve that fails; no place at which two tooth pairs carry.
pub fn coupling(
    solver: &ContactSolver,
    coverage: &Coverage,
    flank: Flank,
    misalignments: &[f64],
) -> Result<Vec<f64>, TableError> {
    let rows = (0..PLACES).into_par_iter().map(|i| {
        let place = -1.0 + i as f64 / PLACES as f64;
        let failed = |m, error: ContactError| TableError::Solve {
            point: point(flank, 0.0, m, place),
            message: error.to_string(),
        };
        let beside = Beside::new(solver, flank, place).map_err(|error| failed(0.0, error))?;
        let look = |&m: &f64| {
            let mut sums = [0.0; 2];
            for load in 1..=LOADS {
                let torque = coverage.maximum_torque * load as f64 / LOADS as f64;
                let seen = beside.look(torque, m).map_err(|error| failed(m, error))?;
                sums = [sums[0] + seen[0], sums[1] + seen[1]];
            }
            Ok(sums)
        };
        misalignments.iter().map(look).collect()
    });
    let rows: Vec<Vec<[f64; 2]>> = rows.collect::<Result<_, TableError>>()?;
    let told = |(node, m): (usize, &f64)| {
        let [products, squares] = [0, 1].map(|k| rows.iter().map(|row| row[node][k]).sum::<f64>());
        if squares > 0.0 {
            return Ok(products / squares);
        }
        Err(TableError::Samples(format!(
            "no place where two tooth pairs carry at a misalignment of {} mrad: tooth pairs one by one need a contact \
             ratio above 1",
            rounded(1e3 * m)
        )))
    };
    misalignments.iter().enumerate().map(told).collect()
}

/// Two neighbouring tooth pairs, the first one at a place.
struct Beside {
    base_radius: f64,
    whole: PositionProblem,
    both: PositionProblem,
    alone: [PositionProblem; 2],
}

impl Beside {
    fn new(solver: &ContactSolver, flank: Flank, place: f64) -> Result<Self, ContactError> {
        Ok(Beside {
            base_radius: solver.geometry().gears[0].base_radius(),
            whole: solver.position(flank, place, 0.0)?,
            both: solver.tooth_pairs(flank, place, 0.0, 1)?,
            alone: [
                solver.tooth_pairs(flank, place, 0.0, 0)?,
                solver.tooth_pairs(flank, place + 1.0, 0.0, 0)?,
            ],
        })
    }

    /// Where all teeth carry `torque`, sums over both of what each lacks of its approach (m) times the force on the other (N), and
    /// of the square of this force; zero where one of them carries hardly anything.
    fn look(&self, torque: f64, misalignment: f64) -> Result<[f64; 2], ContactError> {
        let approach = self
            .whole
            .solve_torque(torque, misalignment, None)?
            .approach;
        let prescribed = Prescribed::Approach(approach);
        let both = self.both.solve_beyond(prescribed, misalignment, None)?;
        let forces = [0, 1].map(|k| {
            let own = both.load_share.iter().find(|(pair, _)| *pair == k);
            own.map_or(0.0, |(_, share)| share * both.loa_force)
        });
        if forces[0].min(forces[1]) < LEAST_SHARE * (forces[0] + forces[1]) {
            return Ok([0.0; 2]);
        }
        let mut sums = [0.0; 2];
        for k in 0..2 {
            let torque = Prescribed::Torque(forces[k] * self.base_radius);
            let own = self.alone[k].solve_beyond(torque, misalignment, None)?;
            let beside = forces[1 - k];
            sums[0] += (approach - own.approach) * beside;
            sums[1] += beside * beside;
        }
        Ok(sums)
    }
}
