//! Static contact at run time: the same solve as everywhere, at the pose as it is, as one potential.
//!
//! With the forces y of a solution, the potential of the mesh is
//!
//! W = y' A y / 2 + sum of the energies of the local contact,
//!
//! stationary in y: F_bt = dW/d delta and the moment dW/dM come with the solution, and its slopes by centre distance and
//! mesh position are those at fixed y, by central differences of a smooth function of the pose.

use std::sync::Arc;

use super::complementarity::Target;
use super::condensed::{CondensedFlank, StripName};
use super::error::ContactError;
use super::position::PositionProblem;
use super::result::Tangent;
use super::setup::ContactSetup;
use super::transverse::TransverseSection;
use crate::gear::Flank;

/// What a solve at run time knows of the one before: forces by strip. It saves steps of Newton's iteration and changes the
/// solution by no more than rounding.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Warm(Vec<(StripName, f64)>);

/// Potential of one flank.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactPotential {
    /// W, J.
    pub energy: f64,
    /// Derivatives by approach (F_bt), centre distance, misalignment (shuttling moment) and mesh position.
    pub gradient: [f64; 4],
    /// Second derivatives by approach and misalignment.
    pub tangent: Tangent,
    /// Approach beyond that for which tip edges are followed, centre distance beyond the nodes, or a pressure that
    /// no flank carries.
    pub out_of_range: bool,
}

/// The contact of one flank of a pair, ready to be solved anywhere.
#[derive(Debug, Clone)]
pub struct RuntimeContact {
    setup: Arc<ContactSetup>,
    condensed: Arc<CondensedFlank>,
    flank: Flank,
}

/// Steps of the central differences by centre distance, m, and by mesh position.
const STEPS: [f64; 2] = [1e-8, 1e-5];

/// Strips whose gap exceeds their closing by more than this part of the largest closing take no part: the others'
/// forces push flanks apart nearly everywhere, and where they do not, by far less.
const MARGIN: f64 = 0.1;

impl RuntimeContact {
    /// The contact of `flank`, whose condensed model is `condensed`.
    pub fn new(setup: Arc<ContactSetup>, condensed: Arc<CondensedFlank>, flank: Flank) -> Self {
        RuntimeContact {
            setup,
            condensed,
            flank,
        }
    }

    /// The potential at the approach (m), centre distance offset (m), misalignment (rad) and mesh position `at`, from
    /// the forces of `warm`, which become those found.
    ///
    /// # Errors
    /// [`ContactError::OutOfMesh`] where teeth cannot meet, and a solve that does not converge.
    pub fn potential(
        &self,
        at: [f64; 4],
        warm: &mut Warm,
    ) -> Result<ContactPotential, ContactError> {
        let [approach, offset, misalignment, position] = at;
        let tau = position - position.floor();
        let section = self.setup.section(offset)?;
        let Some(problem) = self.near(&section, at, tau) else {
            warm.0.clear();
            return Ok(ContactPotential::default());
        };
        let names: Vec<StripName> = problem.candidates().iter().map(|c| c.name()).collect();
        let start: Vec<f64> = names
            .iter()
            .map(|name| {
                let known = warm.0.binary_search_by(|(other, _)| other.cmp(name));
                known.map_or(0.0, |place| warm.0[place].1)
            })
            .collect();
        let start = (!warm.0.is_empty()).then_some(start.as_slice());
        let start = start.map(|forces| (forces, approach));
        let (result, excess) =
            problem.solve_any(Target::Approach(approach), misalignment, start)?;
        warm.0.clear();
        warm.0
            .extend(names.iter().copied().zip(result.forces.iter().copied()));
        warm.0.retain(|(_, force)| *force > 0.0);
        if warm.0.is_empty() {
            return Ok(ContactPotential::default());
        }
        let energy = problem.energy(&result.forces, approach, misalignment);
        let held = |section: &TransverseSection, offset: f64, tau: f64| {
            let problem = self.held(&warm.0, section, offset, tau);
            problem.energy(approach, misalignment)
        };
        let [step, turn] = STEPS;
        let mut sides = [0.0; 2];
        for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
            let moved = offset + sign * step;
            *side = held(&self.setup.section(moved)?, moved, tau);
        }
        let by_offset = (sides[0] - sides[1]) / (2.0 * step);
        let along = |sign: f64| held(&section, offset, tau + sign * turn);
        let by_tau = (along(1.0) - along(-1.0)) / (2.0 * turn);
        Ok(ContactPotential {
            energy,
            gradient: [result.loa_force, by_offset, result.moment, by_tau],
            tangent: result.tangent,
            out_of_range: excess.is_some() || !self.condensed.holds(offset),
        })
    }

    /// The problem of the strips that may carry; `None` if none touches.
    fn near(
        &self,
        section: &TransverseSection,
        [approach, offset, misalignment, _]: [f64; 4],
        tau: f64,
    ) -> Option<PositionProblem> {
        let mut candidates = self.setup.lines(self.flank, section).candidates(tau);
        let z_ref = self.setup.geometry.z_ref();
        // How far points overlap, along the line of action.
        let overlaps: Vec<f64> = candidates
            .iter()
            .map(|c| {
                let points = c.points().into_iter().zip(c.gap);
                let overlap =
                    points.map(|(z, gap)| c.arm * (approach + misalignment * (z - z_ref)) - gap);
                overlap.fold(f64::NEG_INFINITY, f64::max)
            })
            .collect();
        let most = overlaps.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if most <= 0.0 {
            return None;
        }
        let mut overlaps = overlaps.into_iter();
        candidates.retain(|_| overlaps.next().is_some_and(|o| o > -MARGIN * most));
        Some(self.problem(candidates, offset, tau))
    }

    fn problem(&self, candidates: Vec<super::Candidate>, offset: f64, tau: f64) -> PositionProblem {
        let names: Vec<StripName> = candidates.iter().map(|c| c.name()).collect();
        let influence = self.condensed.influence(&names, tau, offset);
        let limits = self.setup.limits(offset);
        PositionProblem::with(&self.setup.geometry, candidates, influence, limits)
    }

    /// The problem of the strips of `forces` elsewhere, with these forces held.
    fn held(
        &self,
        forces: &[(StripName, f64)],
        section: &TransverseSection,
        offset: f64,
        tau: f64,
    ) -> Held {
        let lines = self.setup.lines(self.flank, section);
        let turns = tau.floor();
        let (mut candidates, mut held) = (vec![], vec![]);
        for &((pair, station), force) in forces {
            // Counted on where the step crosses a mesh cycle.
            let named = (pair + turns as i32, station);
            if let Some(candidate) = lines.strip(tau - turns, named) {
                candidates.push(candidate);
                held.push(force);
            }
        }
        Held {
            problem: self.problem(candidates, offset, tau - turns),
            forces: held,
        }
    }
}

/// A problem and forces that are held.
struct Held {
    problem: PositionProblem,
    forces: Vec<f64>,
}

impl Held {
    fn energy(&self, approach: f64, misalignment: f64) -> f64 {
        self.problem.energy(&self.forces, approach, misalignment)
    }
}
