//! What a solver tries on its own pair: how far tip edges have to be followed, and whether contact moves as teeth bend.

use super::error::ContactError;
use super::solver::ContactSolver;
use crate::gear::Pair;
use gearmesh::contact::{Failure, Prescribed};
use gearmesh::gear::Flank;

/// Positions of the mesh at which the largest load is tried for how far tip edges have to be followed.
const TRIED: [f64; 2] = [0.0, 0.5];
/// Ratio of the approach up to which they are followed to the largest found there, for other positions and centre distances.
const MARGIN: f64 = 1.25;
/// Farther edges take up load, so that approaches fall: one more trial as a rule.
const TRIALS: usize = 8;

/// Part of the approach by which contact on bent teeth changes it at least, if it is to be followed.
const LEAST_BEND: f64 = 1e-3;
/// Positions of the mesh at which that is tried.
const TRIED_FOR_BEND: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

impl ContactSolver {
    /// With contact that stays where undeformed flanks come closest if that changes the approach under the largest load of `pair` by less than
    /// [`LEAST_BEND`] at the positions tried, as with steel gears: it then costs nothing.
    pub(super) fn bent_as_needed(mut self, pair: &Pair) -> ContactSolver {
        if self.setup.settings.bent_teeth {
            // What cannot be solved here is refused when it comes up.
            self.setup.settings.bent_teeth = self.bends(pair).unwrap_or(true);
        }
        self
    }

    fn bends(&self, pair: &Pair) -> Result<bool, ContactError> {
        let torque = Prescribed::Torque(pair.operating.maximum_torque);
        for flank in loaded_flanks(pair) {
            for position in TRIED_FOR_BEND {
                let problem = self.position(flank, position, 0.0)?;
                let free = problem.solve_beyond(torque, 0.0, None)?;
                let held = problem.approach_of_held_contact(0.0, &free)?;
                if (free.approach / held - 1.0).abs() > LEAST_BEND {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// With edges followed farther where the largest load of `pair` brings teeth nearer than
    /// [`estimated_approach`](super::settings::estimated_approach) says, as with bodies that tilt under the thrust of a steep helix. What cannot be solved here is refused when it comes up.
    pub(super) fn followed_as_needed(mut self, pair: &Pair) -> ContactSolver {
        let mut solved = self.setup.followed_approach;
        for _ in 0..TRIALS {
            match self.needed_approach(pair) {
                Ok(Some(needed)) => {
                    solved = self.setup.followed_approach;
                    self.setup.followed_approach = MARGIN * needed;
                }
                Ok(None) => break,
                Err(_) => return self.followed_to(solved),
            }
        }
        self
    }

    /// Largest approach at the positions tried, m, if tip edges are not followed that far.
    fn needed_approach(&self, pair: &Pair) -> Result<Option<f64>, ContactError> {
        let torque = Prescribed::Torque(pair.operating.maximum_torque);
        let mut largest = None;
        for flank in loaded_flanks(pair) {
            for position in TRIED {
                let problem = self.position(flank, position, 0.0)?;
                for misalignment in pair.operating.misalignment {
                    let found = problem.contact.solution(torque, misalignment, None)?;
                    if let Some(Failure::NotFollowed { needed, .. }) = found.excess {
                        largest = Some(needed.max(largest.unwrap_or(0.0)));
                    }
                }
            }
        }
        Ok(largest)
    }
}

/// The flanks that differ.
fn loaded_flanks(pair: &Pair) -> impl Iterator<Item = Flank> {
    let flanks = 2 - usize::from(pair.coast_mirrors_drive());
    [Flank::Drive, Flank::Coast].into_iter().take(flanks)
}
