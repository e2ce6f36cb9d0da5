//! Contact at one position of the mesh, and what a solution says.

use nalgebra::DMatrix;

use super::error::ContactError;
use super::motion::{moved_roll, moved_segments};
use gearmesh::contact::{
    Candidate, ContactProblem, Failure, Influence, LocalContact, Prescribed, Segment, Solution,
    Start, Tangent, finite,
};

/// The contact problem at one position and centre distance, with what its results tell beside forces.
pub struct PositionProblem {
    /// What is solved.
    pub contact: ContactProblem,
    /// Its segments as gear 1 and gear 2 see them.
    pub seen: Vec<[Segment; 2]>,
    /// Laws along each segment of a helical pair.
    pub(super) along: Vec<LawsAlong>,
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
    /// Fraction of the load on each tooth pair that may touch, ascending.
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

/// Force and moment of an equilibrium, and what the next solve starts from: all that tables need of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Resultant {
    /// As [`ContactResult::approach`], m.
    pub approach: f64,
    /// Misalignment, rad.
    pub misalignment: f64,
    /// As [`ContactResult::loa_force`], N.
    pub loa_force: f64,
    /// As [`ContactResult::moment`], N m.
    pub moment: f64,
    /// As [`ContactResult::kkt_residual`].
    pub kkt_residual: f64,
    /// Newton steps it took.
    pub iterations: usize,
    /// Derivatives at the solution.
    pub tangent: Tangent,
    /// As [`ContactResult::excess`].
    pub excess: Option<Failure>,
    /// Force on each segment, N, and its derivatives by the approach, N/m, and by the misalignment, N/rad.
    segments: Vec<[f64; 3]>,
}

impl From<&ContactResult> for Resultant {
    fn from(result: &ContactResult) -> Self {
        let segments = result.segments.iter();
        Resultant {
            approach: result.approach,
            misalignment: result.misalignment,
            loa_force: result.loa_force,
            moment: result.moment,
            kkt_residual: result.kkt_residual,
            iterations: result.iterations,
            tangent: result.tangent,
            excess: result.excess,
            segments: segments
                .map(|s| [s.force, s.slopes[0], s.slopes[1]])
                .collect(),
        }
    }
}

impl Resultant {
    /// Forces on the segments (N) at `approach` (m) by the cubics through forces and derivatives here and at `other`, another approach
    /// under the same misalignment; none where nothing touches here.
    fn onwards(&self, other: &Resultant, approach: f64) -> Vec<f64> {
        let step = self.approach - other.approach;
        let t = (approach - self.approach) / step;
        let both = self.segments.iter().zip(&other.segments);
        let forces = both.map(|([force, slope, _], [before, slope_before, _])| {
            let (rise, slopes) = (force - before, [slope_before * step, slope * step]);
            let cubic = slopes[0] + slopes[1] - 2.0 * rise;
            let square = slopes[1] - rise + cubic;
            let onwards = force + t * (slopes[1] + t * (square + t * cubic));
            if *force > 0.0 { onwards.max(0.0) } else { 0.0 }
        });
        forces.collect()
    }
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
    /// The segments that may touch.
    pub fn candidates(&self) -> &[Candidate] {
        &self.contact.candidates
    }

    /// Approach at which the first segment touches, m: the no-load transmission error.
    pub fn no_load_approach(&self, misalignment: f64) -> f64 {
        let gaps = self
            .contact
            .gaps(misalignment)
            .into_iter()
            .zip(&self.contact.arm);
        let touches = gaps.flat_map(|(gaps, arm)| {
            gaps.map(|gap| match gap / arm {
                // Rounded so that it closes no gap.
                approach if arm * approach > gap => approach.next_down(),
                approach => approach,
            })
        });
        touches.fold(f64::INFINITY, f64::min)
    }

    /// Equilibrium under `torque` (N m on gear 1, >= 0) and `misalignment` (rad), from the forces of `warm`, a solution at the
    /// same position, if there is one. Without torque the flanks just touch.
    ///
    /// # Errors
    /// [`Input`](gearmesh::contact::ContactError::Input) for a torque that is negative or not finite, else as [`PositionProblem::solve_approach`].
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
    /// [`Input`](gearmesh::contact::ContactError::Input) for numbers that are not finite, [`Unsolved`](gearmesh::contact::ContactError::Unsolved) where a [`Failure`] says why.
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
        match result.excess {
            None => Ok(result),
            Some(failure) => Err(self
                .contact
                .unsolved(prescribed, misalignment, failure)
                .into()),
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
        let warm = warm.map(Resultant::from);
        let start = (warm.as_ref()).map(|warm| self.predicted(prescribed, misalignment, warm));
        let solution = self.solution(prescribed, misalignment, start)?;
        Ok(self.result(solution, misalignment))
    }

    /// Force and moment alone, likewise, from the forces of `known` solutions at this position: the nearest, and one beyond it under the
    /// `misalignment` asked for.
    ///
    /// # Errors
    /// As [`PositionProblem::solve_beyond`].
    pub fn resultant(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        known: [Option<&Resultant>; 2],
    ) -> Result<Resultant, ContactError> {
        let start = match (prescribed, known) {
            (Prescribed::Approach(approach), [Some(near), Some(far)])
                if near.approach != far.approach =>
            {
                Some((near.onwards(far, approach), approach))
            }
            (_, [near, _]) => near.map(|near| self.predicted(prescribed, misalignment, near)),
        };
        let solution = self.solution(prescribed, misalignment, start)?;
        Ok(self.resultant_of(&solution, misalignment))
    }

    fn solution(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        start: Option<(Vec<f64>, f64)>,
    ) -> Result<Solution, ContactError> {
        let start = start.as_ref().map(|(forces, approach)| Start {
            forces,
            approach: *approach,
        });
        Ok(self.contact.solution(prescribed, misalignment, start)?)
    }

    /// Forces on the segments, N, and approach, m, to which the derivatives at `warm` lead.
    fn predicted(
        &self,
        prescribed: Prescribed,
        misalignment: f64,
        warm: &Resultant,
    ) -> (Vec<f64>, f64) {
        let tilt = misalignment - warm.misalignment;
        let tangent = warm.tangent;
        let rise = match prescribed {
            Prescribed::Approach(approach) => approach - warm.approach,
            Prescribed::Torque(torque) => {
                let more = torque / self.contact.numbers.base_radius[0] - warm.loa_force;
                let rise =
                    (more - tangent.force_by_misalignment * tilt) / tangent.force_by_approach;
                // Where next to nothing touches there is no slope to go by.
                if rise.is_finite() { rise } else { 0.0 }
            }
        };
        let segments = warm.segments.iter();
        let forces = segments.map(|[force, by_approach, by_misalignment]| {
            (force + by_approach * rise + by_misalignment * tilt).max(0.0)
        });
        (forces.collect(), warm.approach + rise)
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
        if !self.contact.moves() || result.loa_force <= 0.0 {
            return Ok(result.approach);
        }
        let forces: Vec<f64> = result.segments.iter().map(|s| s.force).collect();
        let start = Start {
            forces: &forces,
            approach: result.approach,
        };
        let prescribed = Prescribed::Torque(result.loa_force * self.contact.numbers.base_radius[0]);
        let solution = (self.contact).solution_of_held_contact(prescribed, misalignment, start)?;
        Ok(solution.approach)
    }

    /// The segments where `solution` has moved contact to, with the laws there; those that bear nothing stay.
    fn moved(&self, solution: &Solution) -> Option<PositionProblem> {
        let placed = solution.placed.as_ref()?;
        let mut moved = PositionProblem {
            contact: ContactProblem {
                candidates: self.contact.candidates.clone(),
                influence: Influence {
                    bulk: DMatrix::zeros(0, 0),
                    lengths: self.contact.influence.lengths.clone(),
                    motion: None,
                },
                local: self.contact.local.clone(),
                arm: self.contact.arm.clone(),
                ..self.contact
            },
            seen: self.seen.clone(),
            along: vec![],
        };
        for (i, candidate) in moved.contact.candidates.iter_mut().enumerate() {
            let by = placed.places[i];
            if solution.force[i] > 0.0 {
                let numbers = &self.contact.numbers;
                candidate.roll = [0, 1].map(|g| moved_roll(numbers, g, candidate.roll[g], by));
                moved.seen[i] = moved_segments(numbers, &self.seen[i], by);
                moved.contact.local[i] = self.tilted(i, &self.contact.local[i], placed.tilts[i]);
                candidate.profile = *moved.contact.local[i].profile();
            }
        }
        let along = self.along.iter().enumerate().map(|(i, along)| {
            let [edge, relief] = [&along.edge, &along.relief].map(|laws| {
                let tilted = laws.iter().map(|at| LawAt {
                    position: at.position,
                    law: self.tilted(i, &at.law, placed.tilts[i]),
                });
                tilted.collect()
            });
            LawsAlong { edge, relief }
        });
        moved.along = along.collect();
        Some(moved)
    }

    /// `law` of segment `i` where its flanks have tilted by `tilt`, rad.
    fn tilted(&self, i: usize, law: &LocalContact, tilt: f64) -> LocalContact {
        let profile = law.profile().tilted(tilt);
        let segment = &self.contact.candidates[i];
        self.contact.law(segment, &profile, self.contact.lengths(i))
    }

    fn result(&self, solution: Solution, misalignment: f64) -> ContactResult {
        match self.moved(&solution) {
            Some(moved) => moved.result_here(&solution, misalignment),
            None => self.result_here(&solution, misalignment),
        }
    }

    fn resultant_of(&self, solution: &Solution, misalignment: f64) -> Resultant {
        let (moment, tangent, [by_approach, by_misalignment]) = self.contact.moment(solution);
        let mut segments: Vec<[f64; 3]> = solution.force.iter().map(|&f| [f, 0.0, 0.0]).collect();
        for (place, &i) in solution.active.iter().enumerate() {
            segments[i][1] = by_approach[place];
            segments[i][2] = by_misalignment[place];
        }
        Resultant {
            approach: solution.approach,
            misalignment,
            loa_force: self.contact.arm.dot(&solution.force),
            moment,
            kkt_residual: solution.kkt_residual,
            iterations: solution.iterations,
            tangent,
            excess: solution.excess,
            segments,
        }
    }

    /// What `solution` says, whose segments lie where contact is.
    fn result_here(&self, solution: &Solution, misalignment: f64) -> ContactResult {
        let gap = match &solution.placed {
            Some(placed) => placed.gap.clone(),
            None => self.contact.gaps(misalignment),
        };
        let resultant = self.resultant_of(solution, misalignment);
        let Resultant {
            loa_force, moment, ..
        } = resultant;
        let over_force = |value: f64| match loa_force > 0.0 {
            true => value / loa_force,
            false => 0.0,
        };
        let mut edge_loads = self.edge_loads(solution, &gap);
        let mut pressures = self.pressures(&solution.loads, &edge_loads);
        for (i, law) in self.contact.local.iter().enumerate() {
            if law.length() < self.contact.shortest {
                (edge_loads[i], pressures[i]) = (None, 0.0);
            }
        }
        let mut load_share: Vec<(i32, f64)> = Vec::new();
        let mut segments = Vec::with_capacity(gap.len());
        for (i, candidate) in self.contact.candidates.iter().enumerate() {
            let [force, by_approach, by_misalignment] = resultant.segments[i];
            let share = over_force(self.contact.arm[i] * force);
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
                slopes: [by_approach, by_misalignment],
                pressure: pressures[i],
                edge: edge_loads[i],
                gap: (least - solution.closing[i]).max(0.0),
            });
        }
        let torque_forces = [0, 1].map(|g| {
            let bearing = self.contact.candidates.iter().zip(&solution.force);
            let parts = bearing.map(|(segment, force)| segment.arms[g] * force);
            self.contact.numbers.cos_beta_b * parts.sum::<f64>()
        });
        ContactResult {
            approach: solution.approach,
            misalignment,
            loa_force,
            torque_forces,
            moment,
            contact_z: self.contact.numbers.z_ref + over_force(moment),
            load_share,
            max_pressure: pressures.into_iter().fold(0.0, f64::max),
            edge_load: edge_loads.into_iter().fold(None, EdgeLoad::larger),
            kkt_residual: solution.kkt_residual,
            iterations: solution.iterations,
            tangent: resultant.tangent,
            excess: solution.excess,
            segments,
        }
    }
}
