//! What a solution of the contact problem says: loads, pressures, shares and derivatives.

use nalgebra::DVector;

use super::complementarity::{Solution, Start};
use super::edge_load::EdgeLoad;
use super::error::{ContactError, Prescribed, finite};
use super::position::{Found, PositionProblem};
use crate::friction::{Sliding, SlidingSums};

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

/// One segment in a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentLoad {
    /// Tooth pair, counted in the sense in which contact moves; 0 touches at the pitch point at mid-face at mesh
    /// position 0.
    pub tooth_pair: i32,
    /// Ends in gear 1's frame, m.
    pub z: [f64; 2],
    /// Length of roll on gear 1 and gear 2, m.
    pub roll: [f64; 2],
    /// Normal force, N.
    pub force: f64,
    /// Largest Hertz pressure of the part on which contact stays inside the flanks, Pa.
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
    /// Transverse force on the line of action F_bt, N.
    pub loa_force: f64,
    /// Shuttling moment F_bt (z_c - z_ref), N m: of the forces about the normal of the plane of action through the pitch point at
    /// mid-face, over cos beta_b.
    pub moment: f64,
    /// z_c: where the resultant crosses the pitch plane (y = 0), m in gear 1's frame; of helical pairs it may lie beyond the face.
    /// Mid-face where nothing touches.
    pub contact_z: f64,
    /// Fraction of the load on each tooth pair in reach, ascending.
    pub load_share: Vec<(i32, f64)>,
    /// Largest of `pressures`, Pa.
    pub max_pressure: f64,
    /// Largest line load at a tip edge, if contact reaches one.
    pub edge_load: Option<EdgeLoad>,
    /// Largest violation of equilibrium or of the contact conditions over the largest force: force on a
    /// segment less what its gaps and local contact ask for under the displacement of all forces.
    pub kkt_residual: f64,
    /// Newton steps it took.
    pub iterations: usize,
    /// Derivatives at the solution.
    pub tangent: Tangent,
    /// Normal force on each segment, N, in the order of [`PositionProblem::candidates`].
    pub forces: Vec<f64>,
    /// Pressure of each segment inside the flanks, Pa: Hertz, and at the start of a relief the half-ellipse of the same line load and
    /// spread, the largest along the segment.
    pub pressures: Vec<f64>,
    /// Largest line load on each segment where its contact reaches a tip edge.
    pub edge_loads: Vec<Option<EdgeLoad>>,
    /// What stays open on each segment where the flanks are closest, along the normal, m; zero in contact.
    pub gaps: Vec<f64>,
}

impl ContactResult {
    fn start(&self) -> Start<'_> {
        Start {
            forces: &self.forces,
            approach: self.approach,
        }
    }
}

impl PositionProblem {
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
            return Err(ContactError::input(
                "torque",
                torque,
                "give a finite torque on gear 1 that is not negative; \
                         the coast flank is a flank of its own",
            ));
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
    /// [`ContactError::Input`] for numbers that are not finite, [`ContactError::Unsolved`] where a
    /// [`Failure`](super::Failure) says why.
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
        let found = self.solution(prescribed, misalignment, warm.map(ContactResult::start))?;
        match found.excess {
            Some(failure) => Err(self.unsolved(prescribed, misalignment, failure)),
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
        let found = self.solution(prescribed, misalignment, warm.map(ContactResult::start))?;
        Ok(self.result(found))
    }

    fn result(&self, found: Found) -> ContactResult {
        let Found { solution, gap, .. } = found;
        let loa_force = self.arm.dot(&solution.force);
        let over_force = |value: f64| {
            if loa_force > 0.0 {
                value / loa_force
            } else {
                0.0
            }
        };
        let (moment, tangent) = self.moment(&solution);
        let edge_loads = self.edge_loads(&solution, &gap);
        let pressures = self.pressures(&solution.loads, &edge_loads);
        let mut load_share: Vec<(i32, f64)> = Vec::new();
        for (i, candidate) in self.candidates.iter().enumerate() {
            let share = over_force(self.arm[i] * solution.force[i]);
            match load_share.last_mut() {
                Some((k, sum)) if *k == candidate.tooth_pair => *sum += share,
                _ => load_share.push((candidate.tooth_pair, share)),
            }
        }
        let gaps = gap.iter().zip(&solution.closing).map(|(gap, closing)| {
            let least = gap.iter().copied().fold(f64::INFINITY, f64::min);
            (least - closing).max(0.0)
        });
        ContactResult {
            approach: solution.approach,
            loa_force,
            moment,
            contact_z: self.z_ref + over_force(moment),
            load_share,
            max_pressure: pressures.iter().copied().fold(0.0, f64::max),
            edge_load: edge_loads.iter().copied().fold(None, EdgeLoad::larger),
            kkt_residual: solution.kkt_residual,
            iterations: solution.iterations,
            tangent,
            pressures,
            edge_loads,
            gaps: gaps.collect(),
            forces: solution.force.data.into(),
        }
    }

    /// Moment of the forces about mid-face on the line of action, N m, and the derivatives at the solution.
    ///
    /// With K the matrix over the segments in contact, c their arms, b = cos beta_b, and s_n the sums of phi' times the
    /// n-th power of the lever over the points of a segment: dF = K^-1 (c d delta + b s_1 / s_0 dM), and the
    /// moment changes by b (s_1 / s_0 dF + b (s_2 - s_1^2 / s_0) dM).
    pub(super) fn moment(&self, solution: &Solution) -> (f64, Tangent) {
        let (mut moment, mut within) = (0.0, 0.0);
        let normal = self.cos_beta_b;
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
        let [by_approach, by_misalignment] = [&arms, &levers].map(|x| solution.factor.solve(x));
        let tangent = Tangent {
            force_by_approach: by_approach.dot(&arms),
            force_by_misalignment: by_misalignment.dot(&arms),
            moment_by_misalignment: by_misalignment.dot(&levers) + within,
        };
        (moment, tangent)
    }

    /// How `forces` (N) on the segments slide, whose resultant on the line of action is `loa_force` (N), as `sums` adds up.
    pub(super) fn sliding(&self, sums: &SlidingSums, forces: &[f64], loa_force: f64) -> Sliding {
        let mut sum = Sliding::default();
        let normal = loa_force / self.cos_beta_b;
        for (segment, &force) in self.candidates.iter().zip(forces) {
            if loa_force > 0.0 && force > 0.0 {
                let lever = segment.middle() - self.z_ref;
                let line_load = force / segment.length(self.cos_beta_b);
                sums.add(&mut sum, force / normal, segment.roll, lever, line_load);
            }
        }
        sum
    }

    /// Centroid of the load of `result` along the face, m in gear 1's frame; NaN without load.
    pub fn load_centroid(&self, result: &ContactResult) -> f64 {
        let moments = self.candidates.iter().zip(&result.forces);
        let moment: f64 = moments
            .map(|(segment, force)| segment.middle() * force)
            .sum();
        moment / result.forces.iter().sum::<f64>()
    }

    /// Every segment with what it carries in `result`, for plots of the pressure.
    pub fn segment_loads(&self, result: &ContactResult) -> Vec<SegmentLoad> {
        self.candidates
            .iter()
            .enumerate()
            .map(|(i, candidate)| SegmentLoad {
                tooth_pair: candidate.tooth_pair,
                z: candidate.z,
                roll: candidate.roll,
                force: result.forces[i],
                pressure: result.pressures[i],
                edge: result.edge_loads[i],
                gap: result.gaps[i],
            })
            .collect()
    }
}
