//! Where samples come from: the contact solver, or anything else that answers the same questions.

use gearmesh::contact::{ContactResult, ContactSolver, PositionProblem, Prescribed};
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

impl From<&ContactResult> for Sample {
    fn from(result: &ContactResult) -> Self {
        Sample {
            approach: result.approach,
            loa_force: result.loa_force,
            moment: result.moment,
        }
    }
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
        let problem = self
            .solver
            .position(flank, mesh_position, center_distance_offset);
        Ok(Box::new(SolverPosition {
            problem: problem.map_err(|e| e.to_string())?,
            warm: None,
            quality: SolveQuality::default(),
            account: Some(&self.quality),
        }))
    }
}

impl StaticSource for ContactSolver {
    fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Box<dyn StaticPosition + '_>, String> {
        let problem = self.position(flank, mesh_position, center_distance_offset);
        Ok(Box::new(SolverPosition {
            problem: problem.map_err(|e| e.to_string())?,
            warm: None,
            quality: SolveQuality::default(),
            account: None,
        }))
    }
}

/// A position of the contact solver with the last solution, from which the next one starts.
struct SolverPosition<'a> {
    problem: PositionProblem,
    warm: Option<ContactResult>,
    quality: SolveQuality,
    /// Where the quality goes when this is dropped.
    account: Option<&'a Mutex<SolveQuality>>,
}

impl SolverPosition<'_> {
    fn solve(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, String> {
        let (problem, warm) = (&self.problem, self.warm.as_ref());
        let result = match prescribed {
            Prescribed::Torque(torque) => problem.solve_torque(torque, misalignment, warm),
            Prescribed::Approach(approach) => problem.solve_approach(approach, misalignment, warm),
        };
        let result = result.map_err(|e| e.to_string())?;
        self.quality = self.quality.with(SolveQuality {
            solves: 1,
            most_iterations: result.iterations,
            kkt_residual: result.kkt_residual,
        });
        let sample = Sample::from(&result);
        self.warm = Some(result);
        Ok(sample)
    }
}

impl StaticPosition for SolverPosition<'_> {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        self.problem.no_load_approach(misalignment)
    }

    fn at_torque(&mut self, torque: f64, misalignment: f64) -> Result<Sample, String> {
        self.solve(Prescribed::Torque(torque), misalignment)
    }

    fn at_approach(&mut self, approach: f64, misalignment: f64) -> Result<Sample, String> {
        self.solve(Prescribed::Approach(approach), misalignment)
    }
}

impl Drop for SolverPosition<'_> {
    fn drop(&mut self) {
        if let Some(account) = self.account {
            let mut sum = account.lock().unwrap_or_else(PoisonError::into_inner);
            *sum = sum.with(self.quality);
        }
    }
}
