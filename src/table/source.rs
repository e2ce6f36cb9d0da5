//! Where samples come from: the contact solver, or anything else that answers the same questions.

use crate::contact::{ContactResult, ContactSolver, PositionProblem};
use crate::gear::Flank;

/// One static equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// STE on the line of action at mid-face, m.
    pub approach: f64,
    /// F_bt, N.
    pub loa_force: f64,
    /// F_bt (z_c - z_ref), N m.
    pub moment: f64,
}

/// Static contact at one mesh position and centre distance.
pub trait StaticPosition {
    /// Approach at the first touch, m.
    fn no_load_approach(&mut self, misalignment: f64) -> f64;
    /// Equilibrium under a torque on gear 1, N m.
    ///
    /// # Errors
    /// What the solver says.
    fn at_torque(&mut self, torque: f64, misalignment: f64) -> Result<Sample, String>;
    /// Equilibrium at an approach, m.
    ///
    /// # Errors
    /// What the solver says.
    fn at_approach(&mut self, approach: f64, misalignment: f64) -> Result<Sample, String>;
}

/// Static contact of a pair.
pub trait StaticSource: Sync {
    /// The contact at `mesh_position` and `center_distance_offset` (m).
    ///
    /// # Errors
    /// What the solver says.
    fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Box<dyn StaticPosition + '_>, String>;
}

/// A position of the contact solver with the last solution, from which the next one starts.
struct SolverPosition {
    problem: PositionProblem,
    warm: Option<ContactResult>,
}

impl SolverPosition {
    fn keep(&mut self, result: ContactResult) -> Sample {
        let sample = Sample {
            approach: result.approach,
            loa_force: result.loa_force,
            moment: result.moment,
        };
        self.warm = Some(result);
        sample
    }
}

impl StaticPosition for SolverPosition {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        self.problem.no_load_approach(misalignment)
    }

    fn at_torque(&mut self, torque: f64, misalignment: f64) -> Result<Sample, String> {
        let result = self
            .problem
            .solve_torque(torque, misalignment, self.warm.as_ref())
            .map_err(|e| e.to_string())?;
        Ok(self.keep(result))
    }

    fn at_approach(&mut self, approach: f64, misalignment: f64) -> Result<Sample, String> {
        let result = self
            .problem
            .solve_approach(approach, misalignment, self.warm.as_ref())
            .map_err(|e| e.to_string())?;
        Ok(self.keep(result))
    }
}

impl StaticSource for ContactSolver {
    fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Box<dyn StaticPosition + '_>, String> {
        let problem = ContactSolver::position(self, flank, mesh_position, center_distance_offset)
            .map_err(|e| e.to_string())?;
        Ok(Box::new(SolverPosition {
            problem,
            warm: None,
        }))
    }
}
