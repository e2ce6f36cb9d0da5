//! Contact at one position of the mesh, for any load and misalignment.

use nalgebra::DVector;

use super::bent::Movable;
use super::bulk::Influence;
use super::candidates::{Candidate, ContactLines};
use super::complementarity::{Problem, Solution, Start, Target};
use super::error::{ContactError, Failure, Prescribed, finite};
use super::gap::GapProfile;
use super::local_law::{LocalBody, LocalContact, POINTS};
use super::setup::STIFFNESS_OVER_MODULUS;
use crate::friction::{Sliding, SlidingSums};
use crate::gear::PairNumbers;

/// The contact problem at one position and centre distance: influence matrix and gaps.
pub struct ContactProblem {
    /// The segments that may touch.
    pub candidates: Vec<Candidate>,
    /// How they deflect under each other's forces.
    pub influence: Influence,
    /// Law of one point of each segment.
    pub local: Vec<LocalContact>,
    /// [`Candidate::arm`] of the normal force on each segment times cos beta_b.
    pub arm: DVector<f64>,
    /// Those of the pair.
    pub numbers: PairNumbers,
    /// How gear 1 and gear 2 deflect close to the contact.
    pub bodies: [LocalBody; 2],
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Approach up to which tip edges were followed, m; None: not at all.
    pub followed_approach: Option<f64>,
    /// Stiffness for starting values, N/m per m of contact line.
    pub foundation: f64,
    /// Length of a point of a segment that is half as long as a station, m. The end of contact cuts shorter ones off. There the
    /// line load rises without limit as the piece gets shorter, and its pressure says nothing.
    pub shortest: f64,
    /// Violation of the contact conditions over the largest force whose square a solve may leave, which then ends with a step along the
    /// tangents of all laws. Zero, as made: it goes on until rounding is left.
    pub last_step_from: f64,
}

/// Derivatives of load and moment at a solution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tangent {
    /// d F_bt / d approach, N/m.
    pub force_by_approach: f64,
    /// d F_bt / d misalignment = d moment / d approach, N/rad.
    pub force_by_misalignment: f64,
    /// d moment / d misalignment, N m/rad.
    pub moment_by_misalignment: f64,
}

impl ContactProblem {
    /// The problem of `candidates` on `lines` of the gears `bodies`, which act on each other by `influence`.
    pub fn new(
        lines: &ContactLines<'_>,
        bodies: [LocalBody; 2],
        candidates: Vec<Candidate>,
        influence: Influence,
    ) -> ContactProblem {
        let (setup, numbers) = (lines.setup, &lines.section.numbers);
        let modulus = setup.geometry.gears.iter().map(|g| g.youngs_modulus);
        let arm = |i: usize, _| candidates[i].arm() * numbers.cos_beta_b;
        let mut problem = ContactProblem {
            local: vec![],
            arm: DVector::from_fn(candidates.len(), arm),
            candidates,
            influence,
            numbers: *numbers,
            bodies,
            center_distance_offset: lines.center_distance_offset,
            followed_approach: (setup.settings.tip_corner_contact)
                .then_some(setup.followed_approach),
            foundation: STIFFNESS_OVER_MODULUS * modulus.fold(f64::INFINITY, f64::min),
            shortest: 0.5 * numbers.face[1]
                / (setup.settings.stations as f64 * numbers.cos_beta_b * POINTS as f64),
            last_step_from: 0.0,
        };
        let law = |(i, c): (_, &Candidate)| problem.law(c, &c.profile, problem.lengths(i));
        problem.local = problem.candidates.iter().enumerate().map(law).collect();
        problem
    }

    /// Law of one point of `segment` where the gap is `profile`, with the reference lengths `lengths` (m) of both gears.
    pub fn law(
        &self,
        segment: &Candidate,
        profile: &GapProfile,
        lengths: [f64; 2],
    ) -> LocalContact {
        let length = segment.length(self.numbers.cos_beta_b) / POINTS as f64;
        LocalContact::new(&self.bodies, lengths, profile, length)
    }

    /// Whether contact moves along the profile.
    pub fn moves(&self) -> bool {
        self.influence.motion.is_some()
    }

    /// Reference lengths of both gears at segment `i`, m.
    pub fn lengths(&self, i: usize) -> [f64; 2] {
        self.influence.lengths.each_ref().map(|lengths| lengths[i])
    }

    /// Gaps at the points of each segment along the normal under `misalignment`, m; at a tip edge a tilt closes as much as on the path.
    pub fn gaps(&self, misalignment: f64) -> Vec<[f64; POINTS]> {
        let left = |gap: f64, lever: f64| self.numbers.cos_beta_b * (gap - misalignment * lever);
        let gaps = |c: &Candidate| std::array::from_fn(|q| left(c.gap[q], c.levers[q]));
        self.candidates.iter().map(gaps).collect()
    }

    /// [`ContactError::Unsolved`] of this problem.
    pub fn unsolved(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        failure: Failure,
    ) -> ContactError {
        ContactError::Unsolved {
            prescribed,
            misalignment,
            center_distance_offset: self.center_distance_offset,
            failure,
        }
    }

    /// The contact problem at the gaps `gap` (m).
    fn problem<'a>(&'a self, prescribed: Prescribed, gap: &'a [[f64; POINTS]]) -> Problem<'a> {
        Problem {
            bulk: &self.influence.bulk,
            local: &self.local,
            gap,
            arm: &self.arm,
            target: match prescribed {
                Prescribed::Torque(torque) => Target::Force(torque / self.numbers.base_radius[0]),
                Prescribed::Approach(approach) => Target::Approach(approach),
            },
            foundation: self.foundation,
            shortest: self.shortest,
            movable: (self.influence.motion.as_ref()).map(|motion| Movable {
                motion,
                segments: &self.candidates,
            }),
            last_step_from: self.last_step_from,
        }
    }

    /// Equilibrium under what is `prescribed` and the `misalignment` (rad), also where it exceeds what flanks carry or where tip edges
    /// were followed ([`Solution::excess`]).
    ///
    /// # Errors
    /// [`ContactError::Input`] for a misalignment that is not finite, [`ContactError::Unsolved`] where a [`Failure`] says why.
    pub fn solution(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        start: Option<Start<'_>>,
    ) -> Result<Solution, ContactError> {
        finite("misalignment", misalignment)?;
        let gap = self.gaps(misalignment);
        let problem = self.problem(prescribed, &gap);
        let failed = |failure| self.unsolved(prescribed, misalignment, failure);
        let mut solution = match problem.solve(start) {
            Err(failure) if problem.movable.is_some() => {
                // Under loads beyond all that teeth bear they bend without end; where contact stays, the load is known that no flank carries.
                let movable = None;
                let held = Problem { movable, ..problem }.solve(start);
                let beyond = held.ok().filter(|held| held.excess.is_some());
                beyond.ok_or_else(|| failed(failure))?
            }
            solution => solution.map_err(failed)?,
        };
        if let (None, Some(followed)) = (solution.excess, self.followed_approach) {
            let levers = self.candidates.iter().flat_map(|c| c.levers);
            let approaches = levers.map(|lever| solution.approach + misalignment * lever);
            let needed = approaches.fold(f64::NEG_INFINITY, f64::max);
            solution.excess =
                (needed > followed).then_some(Failure::NotFollowed { needed, followed });
        }
        Ok(solution)
    }

    /// As [`ContactProblem::solution`] if contact stayed where the undeformed flanks come closest, whatever it exceeds.
    ///
    /// # Errors
    /// [`ContactError::Unsolved`] where a [`Failure`] says why.
    pub fn solution_of_held_contact(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        start: Start<'_>,
    ) -> Result<Solution, ContactError> {
        let gap = self.gaps(misalignment);
        let problem = Problem {
            movable: None,
            ..self.problem(prescribed, &gap)
        };
        let solution = problem.solve(Some(start));
        solution.map_err(|failure| self.unsolved(prescribed, misalignment, failure))
    }

    /// Moment of the forces about mid-face on the line of action, N m, and the derivatives at the solution: of force and moment, and
    /// of the force on each segment in contact by approach and misalignment.
    ///
    /// With K the matrix over the segments in contact, c their arms, b = cos beta_b, and s_n the sums of phi' times the
    /// n-th power of the lever over the points of a segment: dF = K^-1 (c d delta + b s_1 / s_0 dM), and the
    /// moment changes by b (s_1 / s_0 dF + b (s_2 - s_1^2 / s_0) dM).
    pub fn moment(&self, solution: &Solution) -> (f64, Tangent, [DVector<f64>; 2]) {
        let (mut moment, mut within) = (0.0, 0.0);
        let normal = self.numbers.cos_beta_b;
        let mut levers = DVector::zeros(solution.active.len());
        for (place, &i) in solution.active.iter().enumerate() {
            let (loads, points) = (&solution.loads[i], &self.candidates[i].levers);
            let mut sums = [0.0; 3];
            for ((force, slope), lever) in loads.forces.iter().zip(loads.slopes).zip(points) {
                moment += normal * force * lever;
                sums[0] += slope;
                sums[1] += slope * lever;
                sums[2] += slope * lever * lever;
            }
            levers[place] = normal * sums[1] / sums[0];
            within += normal * normal * (sums[2] - sums[1] * sums[1] / sums[0]);
        }
        let arms = self.arm.select_rows(&solution.active);
        let [by_approach, by_misalignment] = [&arms, &levers].map(|x| solution.stiffened(x));
        let tangent = Tangent {
            force_by_approach: by_approach.dot(&arms),
            force_by_misalignment: by_misalignment.dot(&arms),
            moment_by_misalignment: by_misalignment.dot(&levers) + within,
        };
        (moment, tangent, [by_approach, by_misalignment])
    }

    /// How `forces` (N) on the segments slide, whose resultant on the line of action is `loa_force` (N), as `sums` adds up.
    pub fn sliding(
        &self,
        sums: &SlidingSums,
        forces: impl Iterator<Item = f64>,
        loa_force: f64,
    ) -> Sliding {
        let mut sum = Sliding::default();
        let normal = loa_force / self.numbers.cos_beta_b;
        for (segment, force) in self.candidates.iter().zip(forces) {
            if loa_force > 0.0 && force > 0.0 {
                let lever = segment.middle() - self.numbers.z_ref;
                let line_load = force / segment.length(self.numbers.cos_beta_b);
                sums.add(&mut sum, force / normal, segment.roll, lever, line_load);
            }
        }
        sum
    }
}
