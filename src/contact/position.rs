//! Contact at one position of the mesh, for any load and misalignment: the problem, and what a solution says.

use nalgebra::{DMatrix, DVector};

use super::bent::Movable;
use super::candidates::{Candidate, ContactLines};
use super::complementarity::{Problem, Solution, Start, Target};
use super::error::{ContactError, Failure, Prescribed, finite};
use super::gap::GapProfile;
use super::influence::Influence;
use super::local_law::{LocalContact, POINTS};
use super::setup::STIFFNESS_OVER_MODULUS;
use super::transverse::PairNumbers;
use crate::compliance::Segment;
use crate::friction::{Sliding, SlidingSums};

/// The contact problem at one position and centre distance: influence matrix and gaps.
pub struct PositionProblem {
    /// The segments that may touch.
    pub candidates: Vec<Candidate>,
    /// As gear 1 and gear 2 see them; not known at run time, nor are the laws along them.
    pub seen: Vec<[Segment; 2]>,
    influence: Influence,
    /// Law of one point of each segment.
    pub(super) local: Vec<LocalContact>,
    /// Laws along each segment of a helical pair.
    pub(super) along: Vec<LawsAlong>,
    /// [`Candidate::arm`] of the normal force on each segment.
    pub(super) arm: DVector<f64>,
    pub(super) numbers: PairNumbers,
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Approach up to which tip edges were followed, m; None: not at all.
    pub(super) reach: Option<f64>,
    /// Stiffness for starting values, N/m per m of contact line.
    foundation: f64,
    /// Length of a point of a segment that is half as long as a station, m. The end of contact cuts shorter ones off. There the
    /// line load rises without limit as the piece gets shorter, and its pressure says nothing.
    shortest: f64,
}

/// Laws along one segment.
#[derive(Default)]
pub(super) struct LawsAlong {
    /// Near a tip edge; none where contact does not come to one.
    pub edge: Vec<LawAt>,
    /// Where contact may reach the start of a relief.
    pub relief: Vec<LawAt>,
}

pub(super) struct LawAt {
    /// Part of the segment's length from its middle.
    pub position: f64,
    pub law: LocalContact,
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

/// Contact at a tip edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeLoad {
    /// Normal force per length of contact line, N/m, at this position, not the mean of a segment.
    pub line_load: f64,
    /// Where along the face, in gear 1's frame, m.
    pub z: f64,
    /// The gear whose tip edge it is, 0 or 1.
    pub gear: usize,
}

impl EdgeLoad {
    /// The one with the larger line load.
    pub fn larger(a: Option<EdgeLoad>, b: Option<EdgeLoad>) -> Option<EdgeLoad> {
        match (a, b) {
            (Some(a), Some(b)) if b.line_load > a.line_load => Some(b),
            (a, b) => a.or(b),
        }
    }
}

/// One segment in a solution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SegmentLoad {
    /// Tooth pair, as [`Candidate::tooth_pair`].
    pub tooth_pair: i32,
    /// Ends in gear 1's frame, m.
    pub z: [f64; 2],
    /// Length of roll on gear 1 and gear 2, m.
    pub roll: [f64; 2],
    /// As gear 1 and gear 2 see it.
    pub seen: [Segment; 2],
    /// Normal force, N.
    pub force: f64,
    /// Derivatives of the force by the approach, N/m, and by the misalignment, N/rad.
    pub slopes: [f64; 2],
    /// Largest pressure where contact stays inside the flanks, Pa: Hertz, at the start of a relief the half-ellipse of the same line
    /// load and spread.
    pub pressure: f64,
    /// Where contact reaches a tip edge, and pressure has no bound, and bears most.
    pub edge: Option<EdgeLoad>,
    /// What stays open between the flanks where they are closest, along the normal, m; zero in contact.
    pub gap: f64,
}

impl SegmentLoad {
    /// Normal force per length of contact line, N/m; `cos_base_helix` is that of the base helix angle.
    pub fn line_load(&self, cos_base_helix: f64) -> f64 {
        self.force * cos_base_helix / (self.z[1] - self.z[0])
    }
}

/// Static contact at one operating point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactResult {
    /// STE: approach on the line of action at mid-face from unmodified involutes that just touch, m.
    pub approach: f64,
    /// Misalignment, rad.
    pub misalignment: f64,
    /// Transverse force on the line of action F_bt, N.
    pub loa_force: f64,
    /// Torques of the contact forces about the axes of gear 1 and gear 2 over their base radii, N: F_bt in the mean, and both of them unless a tip
    /// edge bears.
    pub torque_forces: [f64; 2],
    /// Shuttling moment F_bt (z_c - z_ref), N m: of the forces about the normal of the plane of action through the pitch point at
    /// mid-face, over cos beta_b.
    pub moment: f64,
    /// z_c: where the resultant crosses the pitch plane (y = 0), m in gear 1's frame; of helical pairs it may lie beyond the face.
    /// Mid-face where nothing touches.
    pub contact_z: f64,
    /// Fraction of the load on each tooth pair in reach, ascending.
    pub load_share: Vec<(i32, f64)>,
    /// Largest pressure of a segment, Pa.
    pub max_pressure: f64,
    /// Largest line load at a tip edge, if contact reaches one.
    pub edge_load: Option<EdgeLoad>,
    /// Largest violation of equilibrium or of the contact conditions over the largest force: force on a segment less what its
    /// gaps and local contact ask for under the displacement of all forces.
    pub kkt_residual: f64,
    /// Newton steps it took.
    pub iterations: usize,
    /// Derivatives at the solution.
    pub tangent: Tangent,
    /// A pressure that no flank carries, or an approach beyond that for which tip edges were followed.
    pub excess: Option<Failure>,
    /// Every segment that may touch, in the order of [`PositionProblem::candidates`].
    pub segments: Vec<SegmentLoad>,
}

impl ContactResult {
    /// Centroid of the load along the face, m in gear 1's frame; NaN without load.
    pub fn load_centroid(&self) -> f64 {
        let moments = self.segments.iter();
        let moment: f64 = moments.map(|s| 0.5 * (s.z[0] + s.z[1]) * s.force).sum();
        moment / self.segments.iter().map(|s| s.force).sum::<f64>()
    }
}

impl PositionProblem {
    /// The problem of `candidates` on `lines`, which give way to each other by `influence`.
    pub(super) fn new(
        lines: &ContactLines<'_>,
        candidates: Vec<Candidate>,
        influence: Influence,
    ) -> PositionProblem {
        let (setup, numbers) = (lines.setup, &lines.section.numbers);
        let modulus = setup.geometry.gears.iter().map(|g| g.youngs_modulus);
        let arm = |i: usize, _| candidates[i].arm() * numbers.cos_beta_b;
        let mut problem = PositionProblem {
            local: vec![],
            arm: DVector::from_fn(candidates.len(), arm),
            candidates,
            seen: vec![],
            influence,
            along: vec![],
            numbers: *numbers,
            center_distance_offset: lines.center_distance_offset,
            reach: setup.settings.tip_corner_contact.then_some(setup.reach),
            foundation: STIFFNESS_OVER_MODULUS * modulus.fold(f64::INFINITY, f64::min),
            shortest: 0.5 * numbers.face[1]
                / (setup.settings.stations as f64 * numbers.cos_beta_b * POINTS as f64),
        };
        let law = |(i, c): (_, &Candidate)| problem.law(c, &c.profile, problem.lengths(i));
        problem.local = problem.candidates.iter().enumerate().map(law).collect();
        problem
    }

    /// Law of one point of `segment` where the gap is `profile`, with the reference lengths `lengths` (m) of both gears.
    pub(super) fn law(
        &self,
        segment: &Candidate,
        profile: &GapProfile,
        lengths: [f64; 2],
    ) -> LocalContact {
        let length = segment.length(self.numbers.cos_beta_b) / POINTS as f64;
        LocalContact::new(&self.numbers.bodies, lengths, profile, length)
    }

    /// Whether contact moves along the profile.
    pub(super) fn moves(&self) -> bool {
        self.influence.motion.is_some()
    }

    /// Reference lengths of both gears at segment `i`, m.
    pub(super) fn lengths(&self, i: usize) -> [f64; 2] {
        self.influence.lengths.each_ref().map(|lengths| lengths[i])
    }

    /// Gaps at the points of each segment along the normal under `misalignment`, m; at a tip edge a tilt closes as much as on the path.
    fn gaps(&self, misalignment: f64) -> Vec<[f64; POINTS]> {
        let left = |gap: f64, lever: f64| self.numbers.cos_beta_b * (gap - misalignment * lever);
        let gaps = |c: &Candidate| std::array::from_fn(|q| left(c.gap[q], c.levers[q]));
        self.candidates.iter().map(gaps).collect()
    }

    /// Approach at which the first segment touches, m: the no-load transmission error.
    pub fn no_load_approach(&self, misalignment: f64) -> f64 {
        // Rounded so that it closes no gap.
        let touch = |gap: f64, arm: f64| match gap / arm {
            approach if arm * approach > gap => approach.next_down(),
            approach => approach,
        };
        let gaps = self.gaps(misalignment).into_iter().zip(&self.arm);
        let touches = gaps.flat_map(|(gaps, arm)| gaps.map(|gap| touch(gap, *arm)));
        touches.fold(f64::INFINITY, f64::min)
    }

    /// Equilibrium under `torque` (N m on gear 1, >= 0) and `misalignment` (rad), from the forces of `warm`, a solution at the
    /// same position, if there is one. Without torque the flanks just touch.
    ///
    /// # Errors
    /// [`ContactError::Input`] for a torque that is negative or not finite, else as [`PositionProblem::solve_approach`].
    pub fn solve_torque(
        &self,
        torque: f64,
        misalignment: f64,
        warm: Option<&ContactResult>,
    ) -> Result<ContactResult, ContactError> {
        if !(torque.is_finite() && torque >= 0.0) {
            let remedy = "give a finite torque on gear 1 that is not negative; the coast flank is a flank of its own";
            return Err(ContactError::input("torque", torque, remedy));
        }
        if torque == 0.0 {
            finite("misalignment", misalignment)?;
            return self.solve_approach(self.no_load_approach(misalignment), misalignment, None);
        }
        self.solve(Prescribed::Torque(torque), misalignment, warm)
    }

    /// Contact at `approach` (m on the line of action at mid-face) and `misalignment` (rad), from the forces of `warm` if there is one.
    ///
    /// # Errors
    /// [`ContactError::Input`] for numbers that are not finite, [`ContactError::Unsolved`] where a [`Failure`] says why.
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
        let result = self.solve_beyond(prescribed, misalignment, warm)?;
        let failed = |failure| Err(self.unsolved(prescribed, misalignment, failure));
        result.excess.map_or(Ok(result), failed)
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
        let predicted = warm.map(|warm| self.predicted(prescribed, misalignment, warm));
        let start = predicted.as_ref().map(|(forces, approach)| Start {
            forces,
            approach: *approach,
        });
        let solution = self.solution(prescribed, misalignment, start)?;
        Ok(self.result(solution, misalignment))
    }

    /// Forces on the segments, N, and approach, m, to which the derivatives at `warm` lead.
    fn predicted(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        warm: &ContactResult,
    ) -> (Vec<f64>, f64) {
        let tilt = misalignment - warm.misalignment;
        let tangent = warm.tangent;
        let rise = match prescribed {
            Prescribed::Approach(approach) => approach - warm.approach,
            Prescribed::Torque(torque) => {
                let more = torque / self.numbers.base_radius[0] - warm.loa_force;
                let rise =
                    (more - tangent.force_by_misalignment * tilt) / tangent.force_by_approach;
                // Where next to nothing touches there is no slope to go by.
                if rise.is_finite() { rise } else { 0.0 }
            }
        };
        let force = |s: &SegmentLoad| (s.force + s.slopes[0] * rise + s.slopes[1] * tilt).max(0.0);
        let forces = warm.segments.iter().map(force).collect();
        (forces, warm.approach + rise)
    }

    fn unsolved(
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

    /// Approach (m) under the load of `result`, a solution at `misalignment` (rad), if contact stayed where the undeformed flanks come
    /// closest.
    ///
    /// # Errors
    /// What the solve can refuse.
    pub fn approach_of_held_contact(
        &self,
        misalignment: f64,
        result: &ContactResult,
    ) -> Result<f64, ContactError> {
        if !self.moves() || result.loa_force <= 0.0 {
            return Ok(result.approach);
        }
        let forces: Vec<f64> = result.segments.iter().map(|s| s.force).collect();
        let start = Start {
            forces: &forces,
            approach: result.approach,
        };
        let prescribed = Prescribed::Torque(result.loa_force * self.numbers.base_radius[0]);
        let gap = self.gaps(misalignment);
        let problem = Problem {
            movable: None,
            ..self.problem(prescribed, &gap)
        };
        let solution = problem.solve(Some(start));
        let failed = |failure| self.unsolved(prescribed, misalignment, failure);
        Ok(solution.map_err(failed)?.approach)
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
        }
    }

    pub(super) fn solution(
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
        if let (None, Some(reach)) = (solution.excess, self.reach) {
            let levers = self.candidates.iter().flat_map(|c| c.levers);
            let approaches = levers.map(|lever| solution.approach + misalignment * lever);
            let needed = approaches.fold(f64::NEG_INFINITY, f64::max);
            solution.excess = (needed > reach).then_some(Failure::BeyondReach { needed, reach });
        }
        Ok(solution)
    }

    /// The segments where `solution` has moved contact to, with the laws there; those that bear nothing stay.
    fn moved(&self, solution: &Solution) -> Option<PositionProblem> {
        let placed = solution.placed.as_ref()?;
        let mut moved = PositionProblem {
            candidates: self.candidates.clone(),
            seen: self.seen.clone(),
            influence: Influence {
                bulk: DMatrix::zeros(0, 0),
                lengths: self.influence.lengths.clone(),
                motion: None,
            },
            local: self.local.clone(),
            along: vec![],
            arm: self.arm.clone(),
            ..*self
        };
        let law = |i: usize, law: &LocalContact| {
            let profile = law.profile().tilted(placed.tilts[i]);
            self.law(&self.candidates[i], &profile, self.lengths(i))
        };
        for (i, candidate) in moved.candidates.iter_mut().enumerate() {
            let by = placed.places[i];
            if solution.force[i] > 0.0 {
                let roll = |g: usize| self.numbers.moved_roll(g, candidate.roll[g], by);
                candidate.roll = [0, 1].map(roll);
                moved.seen[i] = self.numbers.moved(&self.seen[i], by);
                moved.local[i] = law(i, &self.local[i]);
                candidate.profile = *moved.local[i].profile();
            }
        }
        let along = self.along.iter().enumerate().map(|(i, along)| {
            let laws = |laws: &[LawAt]| {
                let there = laws.iter().map(|at| LawAt {
                    position: at.position,
                    law: law(i, &at.law),
                });
                there.collect()
            };
            LawsAlong {
                edge: laws(&along.edge),
                relief: laws(&along.relief),
            }
        });
        moved.along = along.collect();
        Some(moved)
    }

    fn result(&self, solution: Solution, misalignment: f64) -> ContactResult {
        match self.moved(&solution) {
            Some(moved) => moved.result_here(&solution, misalignment),
            None => self.result_here(&solution, misalignment),
        }
    }

    /// What `solution` says, whose segments lie where contact is.
    fn result_here(&self, solution: &Solution, misalignment: f64) -> ContactResult {
        let gap = match &solution.placed {
            Some(placed) => placed.gap.clone(),
            None => self.gaps(misalignment),
        };
        let loa_force = self.arm.dot(&solution.force);
        let over_force = |value: f64| match loa_force > 0.0 {
            true => value / loa_force,
            false => 0.0,
        };
        let (moment, tangent, [by_approach, by_misalignment]) = self.moment(solution);
        let mut slopes = vec![[0.0; 2]; gap.len()];
        for (place, &i) in solution.active.iter().enumerate() {
            slopes[i] = [by_approach[place], by_misalignment[place]];
        }
        let mut edge_loads = self.edge_loads(solution, &gap);
        let mut pressures = self.pressures(&solution.loads, &edge_loads);
        for (i, law) in self.local.iter().enumerate() {
            if law.length() < self.shortest {
                (edge_loads[i], pressures[i]) = (None, 0.0);
            }
        }
        let mut load_share: Vec<(i32, f64)> = Vec::new();
        let mut segments = Vec::with_capacity(gap.len());
        for (i, candidate) in self.candidates.iter().enumerate() {
            let force = solution.force[i];
            let share = over_force(self.arm[i] * force);
            match load_share.last_mut() {
                Some((k, sum)) if *k == candidate.tooth_pair => *sum += share,
                _ => load_share.push((candidate.tooth_pair, share)),
            }
            let least = gap[i].iter().copied().fold(f64::INFINITY, f64::min);
            segments.push(SegmentLoad {
                tooth_pair: candidate.tooth_pair,
                z: candidate.z,
                roll: candidate.roll,
                seen: self.seen[i],
                force,
                slopes: slopes[i],
                pressure: pressures[i],
                edge: edge_loads[i],
                gap: (least - solution.closing[i]).max(0.0),
            });
        }
        let torque_force = |g: usize| {
            let bearing = self.candidates.iter().zip(&solution.force);
            let parts = bearing.map(|(segment, force)| segment.arms[g] * force);
            self.numbers.cos_beta_b * parts.sum::<f64>()
        };
        ContactResult {
            approach: solution.approach,
            misalignment,
            loa_force,
            torque_forces: [0, 1].map(torque_force),
            moment,
            contact_z: self.numbers.z_ref + over_force(moment),
            load_share,
            max_pressure: pressures.into_iter().fold(0.0, f64::max),
            edge_load: edge_loads.into_iter().fold(None, EdgeLoad::larger),
            kkt_residual: solution.kkt_residual,
            iterations: solution.iterations,
            tangent,
            excess: solution.excess,
            segments,
        }
    }

    /// Moment of the forces about mid-face on the line of action, N m, and the derivatives at the solution: of force and moment, and
    /// of the force on each segment in contact by approach and misalignment.
    ///
    /// With K the matrix over the segments in contact, c their arms, b = cos beta_b, and s_n the sums of phi' times the
    /// n-th power of the lever over the points of a segment: dF = K^-1 (c d delta + b s_1 / s_0 dM), and the
    /// moment changes by b (s_1 / s_0 dF + b (s_2 - s_1^2 / s_0) dM).
    pub(super) fn moment(&self, solution: &Solution) -> (f64, Tangent, [DVector<f64>; 2]) {
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
    pub(super) fn sliding(
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
