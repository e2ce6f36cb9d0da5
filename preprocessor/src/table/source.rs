//! Where samples come from: the contact solver, or anything else that answers the same questions.

use gearmesh::contact::{ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use std::sync::{Mutex, PoisonError};

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
    /// Equilibrium up to which a table for this largest torque goes: that under the torque itself.
    ///
    /// # Errors
    /// What the solver says.
    fn top(&mut self, torque: f64, misalignment: f64) -> Result<Sample, String> {
        self.at_torque(torque, misalignment)
    }
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

/// How well the solves of a source went.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SolveQuality {
    /// Number of solves.
    pub solves: usize,
    /// Most Newton steps that one of them took.
    pub most_iterations: usize,
    /// Largest KKT residual, see [`ContactResult::kkt_residual`].
    pub kkt_residual: f64,
}

impl SolveQuality {
    /// Both taken together.
    #[must_use]
    pub fn with(self, other: SolveQuality) -> SolveQuality {
        SolveQuality {
            solves: self.solves + other.solves,
            most_iterations: self.most_iterations.max(other.most_iterations),
            kkt_residual: self.kkt_residual.max(other.kkt_residual),
        }
    }
}

/// A contact solver that keeps account of its solves.
pub struct WatchedSolver<'a> {
    solver: &'a ContactSolver,
    quality: Mutex<SolveQuality>,
}

impl<'a> WatchedSolver<'a> {
    /// Nothing solved yet.
    pub fn new(solver: &'a ContactSolver) -> Self {
        WatchedSolver {
            solver,
            quality: Mutex::default(),
        }
    }

    /// Of all solves so far whose position has been dropped.
    pub fn quality(&self) -> SolveQuality {
        // The account is whole even if a thread panicked while it held the lock.
        *self.quality.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl StaticSource for WatchedSolver<'_> {
    fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Box<dyn StaticPosition + '_>, String> {
        let at = SolverPosition::new(self.solver, flank, mesh_position, center_distance_offset)?;
        Ok(Box::new(WatchedPosition { at, source: self }))
    }
}

/// A position of a [`WatchedSolver`]; it reports when it is dropped.
struct WatchedPosition<'a> {
    at: SolverPosition,
    source: &'a WatchedSolver<'a>,
}

impl StaticPosition for WatchedPosition<'_> {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        self.at.no_load_approach(misalignment)
    }

    fn at_torque(&mut self, torque: f64, misalignment: f64) -> Result<Sample, String> {
        self.at.at_torque(torque, misalignment)
    }

    fn at_approach(&mut self, approach: f64, misalignment: f64) -> Result<Sample, String> {
        self.at.at_approach(approach, misalignment)
    }
}

impl Drop for WatchedPosition<'_> {
    fn drop(&mut self) {
        let mut sum = (self.source.quality.lock()).unwrap_or_else(PoisonError::into_inner);
        *sum = sum.with(self.at.quality);
    }
}

/// A position of the contact solver with the last solution, from which the next one starts.
struct SolverPosition {
    problem: PositionProblem,
    warm: Option<ContactResult>,
    quality: SolveQuality,
}

impl SolverPosition {
    fn new(
        solver: &ContactSolver,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Self, String> {
        let problem = solver
            .position(flank, mesh_position, center_distance_offset)
            .map_err(|e| e.to_string())?;
        Ok(SolverPosition {
            problem,
            warm: None,
            quality: SolveQuality::default(),
        })
    }

    fn keep(&mut self, result: ContactResult) -> Sample {
        self.quality = self.quality.with(SolveQuality {
            solves: 1,
            most_iterations: result.iterations,
            kkt_residual: result.kkt_residual,
        });
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
        let at = SolverPosition::new(self, flank, mesh_position, center_distance_offset)?;
        Ok(Box::new(at))
    }
}
