//! Contact at one position of the mesh, for any load and misalignment.

use nalgebra::{DMatrix, DVector};

use super::candidates::Candidate;
use super::complementarity::{Problem, Solution, Start, Target};
use super::error::{ContactError, Failure, OperatingPoint, Prescribed, finite};
use super::influence::Influence;
use super::local_law::{Corner, LocalBody, LocalContact, POINTS};
use super::profile::GapProfile;
use super::setup::{ContactSetup, STIFFNESS_OVER_MODULUS};
use super::transverse::PairNumbers;

/// The contact problem at one position and centre distance: influence matrix and gaps.
pub struct PositionProblem {
    pub(super) candidates: Vec<Candidate>,
    /// Bulk influence matrix of both gears over the segments, m/N, less what local contact has taken over.
    pub(super) bulk: DMatrix<f64>,
    /// Law of one point of each segment.
    pub(super) local: Vec<LocalContact>,
    /// Laws along each segment; none at all where loads along segments are not asked for.
    pub(super) along: Vec<LawsAlong>,
    /// Reference lengths of both gears at each segment, m.
    lengths: [Vec<f64>; 2],
    plane_compliance: [f64; 2],
    corners: [Corner; 2],
    /// Arm of the normal force on each segment about the axis of gear 1, over its base radius.
    pub(super) arm: DVector<f64>,
    pub(super) cos_beta_b: f64,
    base_radius: f64,
    pub(super) z_ref: f64,
    limits: Limits,
}

pub(super) struct LawsAlong {
    /// Near a tip edge; none where contact does not come to one.
    pub edge: Vec<LawAt>,
    /// Where contact may reach the start of a relief.
    pub relief: Vec<LawAt>,
}

pub(super) struct LawAt {
    pub position: f64,
    pub law: LocalContact,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Approach up to which tip edges were followed, m; None: not at all.
    pub reach: Option<f64>,
    /// Stiffness for starting values, N/m per m of contact line.
    pub foundation: f64,
}

impl Limits {
    pub fn new(setup: &ContactSetup, center_distance_offset: f64) -> Limits {
        let modulus = setup.geometry.gears.iter().map(|g| g.youngs_modulus);
        Limits {
            center_distance_offset,
            reach: setup.settings.tip_corner_contact.then_some(setup.reach),
            foundation: STIFFNESS_OVER_MODULUS * modulus.fold(f64::INFINITY, f64::min),
        }
    }
}

impl PositionProblem {
    pub(super) fn with(
        numbers: &PairNumbers,
        candidates: Vec<Candidate>,
        influence: Influence,
        limits: Limits,
    ) -> PositionProblem {
        let cos_beta_b = numbers.cos_beta_b;
        let mut problem = PositionProblem {
            local: vec![],
            arm: DVector::from_fn(candidates.len(), |i, _| candidates[i].arms[0] * cos_beta_b),
            candidates,
            bulk: influence.bulk,
            lengths: influence.lengths,
            plane_compliance: numbers.plane_compliance,
            corners: numbers.corners,
            along: vec![],
            cos_beta_b,
            base_radius: numbers.base_radius[0],
            z_ref: numbers.z_ref,
            limits,
        };
        let each = problem.candidates.iter().enumerate();
        problem.local = each
            .map(|(i, segment)| problem.law(segment, &segment.profile, problem.lengths(i)))
            .collect();
        problem
    }

    /// Law of one point of `segment` where the gap is `profile`, with the reference lengths `lengths` (m) of both gears.
    pub(super) fn law(
        &self,
        segment: &Candidate,
        profile: &GapProfile,
        lengths: [f64; 2],
    ) -> LocalContact {
        let bodies = [0, 1].map(|i| LocalBody {
            plane_compliance: self.plane_compliance[i],
            reference_length: lengths[i],
            corner: self.corners[i],
        });
        let length = segment.length(self.cos_beta_b) / POINTS as f64;
        LocalContact::new(bodies, profile, length)
    }

    /// The segments that may touch.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Gaps at the points of each segment along the normal under `misalignment`, m; at a tip edge a tilt closes as much as on the path.
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

    pub(super) fn unsolved(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        failure: Failure,
    ) -> ContactError {
        let at = OperatingPoint {
            prescribed,
            misalignment,
            center_distance_offset: self.limits.center_distance_offset,
        };
        ContactError::Unsolved { at, failure }
    }

    /// Solves from `start` if there is one, and says what the solution exceeds.
    pub(super) fn solution(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        start: Option<Start<'_>>,
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
            .map_err(|failure| self.unsolved(prescribed, misalignment, failure))?;
        let overload = problem.overload(&solution);
        let mut excess = overload.map(|pressure| Failure::Overload { pressure });
        if let (None, Some(reach)) = (excess, self.limits.reach) {
            let levers = self.candidates.iter().flat_map(|c| c.levers);
            let needed = levers
                .map(|lever| solution.approach + misalignment * lever)
                .fold(f64::NEG_INFINITY, f64::max);
            excess = (needed > reach).then_some(Failure::BeyondReach { needed, reach });
        }
        Ok(Found {
            solution,
            gap,
            excess,
        })
    }

    pub(super) fn lengths(&self, i: usize) -> [f64; 2] {
        self.lengths.each_ref().map(|lengths| lengths[i])
    }
}

pub(super) struct Found {
    pub solution: Solution,
    /// Gaps at the points of each segment along the normal under the misalignment, m.
    pub gap: Vec<[f64; POINTS]>,
    /// What it exceeds: a pressure that no flank carries, or the approach for which tip edges were followed.
    pub excess: Option<Failure>,
}
