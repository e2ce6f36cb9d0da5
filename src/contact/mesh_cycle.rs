//! Quasi-static contact over one mesh cycle.

use std::time::Instant;

use rayon::prelude::*;

use super::error::ContactError;
use super::result::{ContactResult, EdgeLoad, larger};
use super::solver::ContactSolver;
use crate::friction::{FrictionLaw, Sliding};
use crate::gear::Flank;

/// Harmonics of the mesh frequency that are reported.
pub const HARMONICS: usize = 5;

/// Where a mesh cycle is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleInput {
    /// Loaded flank of gear 1.
    pub flank: Flank,
    /// Torque on gear 1, N m, >= 0.
    pub torque: f64,
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Misalignment in the plane of action, rad.
    pub misalignment: f64,
    /// Number of equidistant positions, from 0 on.
    pub positions: usize,
}

/// One mesh cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCycle {
    /// Mesh positions i / N, base pitches.
    pub mesh_position: Vec<f64>,
    /// The solution at each.
    pub results: Vec<ContactResult>,
    /// How the load slides at each, every strip counted alike.
    pub sliding: Vec<Sliding>,
    /// The same with the weights of the pair's law of friction.
    pub friction: Vec<Sliding>,
    /// Wall clock of the whole cycle, s.
    pub solve_seconds: f64,
}

impl MeshCycle {
    /// Solves all positions, in parallel.
    ///
    /// # Errors
    /// [`ContactError::Input`] for no positions, else the first error of a position.
    pub fn solve(solver: &ContactSolver, input: &CycleInput) -> Result<MeshCycle, ContactError> {
        let n = input.positions;
        if n == 0 {
            return Err(ContactError::Input {
                field: "positions",
                value: 0.0,
                remedy: "give at least 1; 11 or more for five harmonics",
            });
        }
        let begin = Instant::now();
        let mesh_position: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
        let even = FrictionLaw::default();
        let solved = mesh_position
            .par_iter()
            .map(|&tau| {
                let problem = solver.position(input.flank, tau, input.center_distance_offset)?;
                let result = problem.solve_torque(input.torque, input.misalignment, None)?;
                let sliding = solver.sliding(&problem, &result, &even);
                let friction = solver.sliding(&problem, &result, solver.friction());
                Ok((result, sliding, friction))
            })
            .collect::<Result<Vec<_>, ContactError>>()?;
        let (mut results, mut sliding, mut friction) = (vec![], vec![], vec![]);
        for (result, even, weighted) in solved {
            results.push(result);
            sliding.push(even);
            friction.push(weighted);
        }
        Ok(MeshCycle {
            mesh_position,
            results,
            sliding,
            friction,
            solve_seconds: begin.elapsed().as_secs_f64(),
        })
    }

    /// STE at each position, m on the line of action at mid-face.
    pub fn ste(&self) -> Vec<f64> {
        self.results.iter().map(|r| r.approach).collect()
    }

    /// Mean STE, m.
    pub fn mean_ste(&self) -> f64 {
        self.ste().iter().sum::<f64>() / self.results.len() as f64
    }

    /// Highest minus lowest STE, m.
    pub fn peak_to_peak_ste(&self) -> f64 {
        let ste = self.ste();
        ste.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - ste.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Amplitudes of harmonics 1 to 5 of the STE, m. NaN for those above half the number of positions,
    /// which these positions cannot tell apart.
    pub fn harmonics(&self) -> [f64; HARMONICS] {
        let ste = self.ste();
        let n = ste.len();
        std::array::from_fn(|h| {
            let order = h + 1;
            if 2 * order >= n {
                return f64::NAN;
            }
            let (mut cos, mut sin) = (0.0, 0.0);
            for (tau, value) in self.mesh_position.iter().zip(&ste) {
                let angle = 2.0 * std::f64::consts::PI * order as f64 * tau;
                cos += value * angle.cos();
                sin += value * angle.sin();
            }
            2.0 / n as f64 * cos.hypot(sin)
        })
    }

    /// Mean of z_c, m in gear 1's frame.
    pub fn mean_contact_z(&self) -> f64 {
        self.results.iter().map(|r| r.contact_z).sum::<f64>() / self.results.len() as f64
    }

    /// Largest Hertz pressure of the cycle inside the flanks, Pa.
    pub fn max_pressure(&self) -> f64 {
        self.results
            .iter()
            .map(|r| r.max_pressure)
            .fold(0.0, f64::max)
    }

    /// Largest line load of the cycle at a tip edge, if contact reaches one.
    pub fn edge_load(&self) -> Option<EdgeLoad> {
        self.results.iter().map(|r| r.edge_load).fold(None, larger)
    }

    /// Largest KKT residual of the cycle.
    pub fn kkt_residual(&self) -> f64 {
        self.results
            .iter()
            .map(|r| r.kkt_residual)
            .fold(0.0, f64::max)
    }
}
