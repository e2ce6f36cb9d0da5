//! Contact at one position of the mesh, for any load and misalignment.

use nalgebra::{DMatrix, DVector};

use super::along::Along;
use super::candidates::{Candidate, POINTS};
use super::complementarity::{Failure, Problem, Solution, Start, Target};
use super::error::{ContactError, OperatingPoint, Prescribed};
use super::influence::Influence;
use super::local::{GapProfile, LocalBody, LocalContact};
use super::result::ContactResult;
use super::transverse::PairNumbers;

/// The contact problem at one position and centre distance: influence matrix and gaps.
pub struct PositionProblem {
    pub(super) candidates: Vec<Candidate>,
    /// Bulk influence matrix of both gears over the segments, m/N, less what local contact has taken over.
    pub(super) bulk: DMatrix<f64>,
    /// Law of one point of each segment.
    pub(super) local: Vec<LocalContact>,
    /// Laws along each segment; none at all where loads along segments are not asked for.
    pub(super) along: Vec<Along>,
    /// Reference lengths of both gears at each segment, m.
    lengths: [Vec<f64>; 2],
    /// Arm of the normal force on each segment about the axis of gear 1, over its base radius.
    pub(super) arm: DVector<f64>,
    pub(super) cos_beta_b: f64,
    base_radius: f64,
    pub(super) z_ref: f64,
    limits: Limits,
}

/// Law of one point of `segment` where the gap is `profile`, with the reference lengths `lengths` (m) of both gears.
pub(super) fn law(
    numbers: &PairNumbers,
    segment: &Candidate,
    profile: &GapProfile,
    lengths: [f64; 2],
) -> LocalContact {
    let bodies = [0, 1].map(|i| LocalBody {
        plane_compliance: numbers.plane_compliance[i],
        reference_length: lengths[i],
        corner: numbers.corners[i],
    });
    let length = segment.length(numbers.cos_beta_b) / POINTS as f64;
    LocalContact::new(bodies, profile, length)
}

/// What holds for all loads at one position.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Approach up to which tip edges were followed, m; None: not at all.
    pub reach: Option<f64>,
    /// Stiffness for starting values, N/m per m of contact line.
    pub foundation: f64,
}

impl PositionProblem {
    /// The problem of `candidates` whose influence is known.
    pub(super) fn with(
        numbers: &PairNumbers,
        candidates: Vec<Candidate>,
        influence: Influence,
        limits: Limits,
    ) -> PositionProblem {
        let cos_beta_b = numbers.cos_beta_b;
        let each = candidates.iter().enumerate();
        let local = each.map(|(i, segment)| {
            let lengths = [0, 1].map(|gear| influence.lengths[gear][i]);
            law(numbers, segment, &segment.profile, lengths)
        });
        PositionProblem {
            local: local.collect(),
            arm: DVector::from_fn(candidates.len(), |i, _| candidates[i].arms[0] * cos_beta_b),
            candidates,
            bulk: influence.bulk,
            lengths: influence.lengths,
            along: vec![],
            cos_beta_b,
            base_radius: numbers.base_radius[0],
            z_ref: numbers.z_ref,
            limits,
        }
    }

    /// The segments that may touch.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Bulk influence matrix of both gears over the segments, m/N, less what the local contact has taken over from its diagonal.
    pub fn bulk(&self) -> &DMatrix<f64> {
        &self.bulk
    }

    /// Gaps at the points of each segment along the normal under `misalignment`, m. At a tip edge the normal is turned by so little that
    /// a tilt closes there, unlike an approach, as much as on the path.
    fn gaps(&self, misalignment: f64) -> Vec<[f64; POINTS]> {
        let left = |gap: f64, lever: f64| self.cos_beta_b * (gap - misalignment * lever);
        let segments = self.candidates.iter();
        segments
            .map(|c| std::array::from_fn(|q| left(c.gap[q], c.levers[q])))
            .collect()
    }

    /// Approach at which the first segment touches, m: the no-load transmission error.
    pub fn no_load_approach(&self, misalignment: f64) -> f64 {
        // Rounded so that it closes no gap.
        let touch = |gap: f64, arm: f64| {
            let approach = gap / arm;
            match arm * approach > gap {
                true => approach.next_down(),
                false => approach,
            }
        };
        self.gaps(misalignment)
            .into_iter()
            .zip(&self.arm)
            .flat_map(|(gaps, arm)| gaps.map(|gap| touch(gap, *arm)))
            .fold(f64::INFINITY, f64::min)
    }

    /// Equilibrium under `torque` (N m on gear 1, >= 0) and `misalignment` (rad), from the forces of
    /// `warm`, a solution at the same position, where there is one. Without torque the flanks just touch.
    ///
    /// # Errors
    /// [`ContactError::Input`] for a torque that is negative or not finite, else as
    /// [`PositionProblem::solve_approach`].
    pub fn solve_torque(
        &self,
        torque: f64,
        misalignment: f64,
        warm: Option<&ContactResult>,
    ) -> Result<ContactResult, ContactError> {
        if !(torque.is_finite() && torque >= 0.0) {
            return Err(ContactError::Input {
                field: "torque",
                value: torque,
                remedy: "give a finite torque on gear 1 that is not negative; \
                         the coast flank is a flank of its own",
            });
        }
        if torque == 0.0 {
            finite("misalignment", misalignment)?;
            return self.solve_approach(self.no_load_approach(misalignment), misalignment, None);
        }
        self.solve(Prescribed::Torque(torque), misalignment, warm)
    }

    /// Contact at the given `approach` (m on the line of action at mid-face) and `misalignment` (rad),
    /// from the forces of `warm` where there is one.
    ///
    /// # Errors
    /// [`ContactError::Input`] for numbers that are not finite, [`ContactError::BeyondReach`] where tip
    /// corners would have to be followed farther than was set, and what the solve itself can refuse
    /// ([`ContactError::Overload`], [`ContactError::NotPositiveDefinite`],
    /// [`ContactError::NotConverged`]).
    pub fn solve_approach(
        &self,
        approach: f64,
        misalignment: f64,
        warm: Option<&ContactResult>,
    ) -> Result<ContactResult, ContactError> {
        finite("approach", approach)?;
        self.solve(Prescribed::Approach(approach), misalignment, warm)
    }

    fn solve(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        warm: Option<&ContactResult>,
    ) -> Result<ContactResult, ContactError> {
        let found = self.solution(prescribed, misalignment, warm.map(start).as_ref())?;
        let at = self.operating_point(prescribed, misalignment);
        match found.excess {
            Some(Excess::Pressure(pressure)) => Err(ContactError::Overload {
                at,
                pressure_mpa: 1e-6 * pressure,
            }),
            Some(Excess::Reach { needed, reach }) => Err(ContactError::BeyondReach {
                at,
                needed_um: 1e6 * needed,
                reach_um: 1e6 * reach,
            }),
            None => Ok(self.result(found)),
        }
    }

    /// As [`PositionProblem::solve_torque`] and [`PositionProblem::solve_approach`], also where a flank bears more than any
    /// does, or where tip edges were not followed: for tables, whose ends no load reaches.
    ///
    /// # Errors
    /// What the solve itself can refuse.
    pub fn solve_beyond(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        warm: Option<&ContactResult>,
    ) -> Result<ContactResult, ContactError> {
        let found = self.solution(prescribed, misalignment, warm.map(start).as_ref())?;
        Ok(self.result(found))
    }

    fn operating_point(&self, prescribed: Prescribed, misalignment: f64) -> OperatingPoint {
        OperatingPoint {
            prescribed,
            misalignment,
            center_distance_offset: self.limits.center_distance_offset,
        }
    }

    /// Solves from `start` where there is one, and says what the solution exceeds of what the model is made for.
    pub(super) fn solution(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        start: Option<&Start>,
    ) -> Result<Found, ContactError> {
        finite("misalignment", misalignment)?;
        let target = match prescribed {
            Prescribed::Torque(torque) => Target::Force(torque / self.base_radius),
            Prescribed::Approach(approach) => Target::Approach(approach),
        };
        let gap = self.gaps(misalignment);
        let problem = Problem {
            bulk: &self.bulk,
            local: &self.local,
            gap: &gap,
            arm: &self.arm,
        };
        let solution = problem
            .solve(target, start, self.limits.foundation)
            .map_err(|failure| {
                let at = self.operating_point(prescribed, misalignment);
                match failure {
                    Failure::NotPositiveDefinite => ContactError::NotPositiveDefinite { at },
                    Failure::NotConverged {
                        iterations,
                        residual,
                    } => ContactError::NotConverged {
                        at,
                        iterations,
                        residual,
                    },
                }
            })?;
        let mut excess = problem.overload(&solution).map(Excess::Pressure);
        if let (None, Some(reach)) = (excess, self.limits.reach) {
            let levers = self.candidates.iter().flat_map(|c| c.levers);
            let needed = levers
                .map(|lever| solution.approach + misalignment * lever)
                .fold(f64::NEG_INFINITY, f64::max);
            excess = (needed > reach).then_some(Excess::Reach { needed, reach });
        }
        Ok(Found {
            solution,
            gap,
            excess,
        })
    }

    /// Reference lengths of gear 1 and gear 2 at segment `i`, m.
    pub(super) fn lengths(&self, i: usize) -> [f64; 2] {
        self.lengths.each_ref().map(|lengths| lengths[i])
    }
}

/// A solution as it is found.
pub(super) struct Found {
    pub solution: Solution,
    /// Gaps at the points of each segment along the normal under the misalignment, m.
    pub gap: Vec<[f64; POINTS]>,
    pub excess: Option<Excess>,
}

/// What a solution exceeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Excess {
    /// A pressure, Pa, that no flank carries.
    Pressure(f64),
    /// An approach, m, beyond that for which tip edges were followed.
    Reach { needed: f64, reach: f64 },
}

/// From the solution `warm`.
fn start(warm: &ContactResult) -> Start {
    Start {
        forces: warm.forces.clone(),
        approach: warm.approach,
    }
}

pub(super) fn finite(field: &'static str, value: f64) -> Result<(), ContactError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(ContactError::Input {
        field,
        value,
        remedy: "give a finite number",
    })
}
