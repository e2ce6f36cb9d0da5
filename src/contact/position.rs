//! Contact at one position of the mesh, for any load and misalignment.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::candidates::{Candidate, POINTS};
use super::complementarity::{Failure, Problem, Solution, Target};
use super::division;
use super::error::{ContactError, OperatingPoint, Prescribed};
use super::hertz::{LocalBody, LocalContact};
use crate::compliance::{BeyondModel, Strip, ToothCompliance};
use crate::gear::PairGeometry;

/// Derivatives of load and moment at a solution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tangent {
    /// d F_bt / d approach, N/m.
    pub force_by_approach: f64,
    /// d F_bt / d misalignment = d (F_bt (z_c - z_ref)) / d approach, N/rad.
    pub force_by_misalignment: f64,
    /// d (F_bt (z_c - z_ref)) / d misalignment, N m/rad.
    pub moment_by_misalignment: f64,
}

/// One strip in a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripLoad {
    /// Tooth pair (see [`Candidate::tooth_pair`]).
    pub tooth_pair: i32,
    /// Ends in gear 1's frame, m.
    pub z: [f64; 2],
    /// Length of roll on gear 1 and gear 2, m.
    pub roll: [f64; 2],
    /// Normal force, N.
    pub force: f64,
    /// Largest Hertz pressure, Pa; where contact reaches a tip edge, 4 / pi times the mean.
    pub pressure: f64,
    /// Whether contact reaches a tip edge. The pressure at a sharp edge has no bound.
    pub reaches_edge: bool,
}

/// Static contact at one operating point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactResult {
    /// STE: approach on the line of action at mid-face from unmodified involutes that just touch, m.
    pub approach: f64,
    /// Transverse force on the line of action F_bt, N.
    pub loa_force: f64,
    /// Shuttling moment F_bt (z_c - z_ref), N m.
    pub moment: f64,
    /// z of the resultant in gear 1's frame, m; mid-face where nothing touches.
    pub contact_z: f64,
    /// Fraction of the load on each tooth pair in reach, ascending.
    pub load_share: Vec<(i32, f64)>,
    /// Largest Hertz pressure, Pa.
    pub max_pressure: f64,
    /// Largest violation of equilibrium or of the contact conditions over the largest force: force on a
    /// strip less what its gaps and local contact ask for under the displacement of all forces.
    pub kkt_residual: f64,
    /// Newton steps it took.
    pub iterations: usize,
    /// Derivatives at the solution.
    pub tangent: Tangent,
    /// Normal force on each strip, N, in the order of [`PositionProblem::candidates`].
    pub forces: Vec<f64>,
    /// Largest Hertz pressure on each strip, Pa.
    pub pressures: Vec<f64>,
}

/// The contact problem at one position and centre distance: influence matrix and gaps.
pub struct PositionProblem {
    candidates: Vec<Candidate>,
    /// Bulk influence matrix of both gears, row by row.
    bulk: Vec<f64>,
    /// Law of one point of each strip.
    local: Vec<LocalContact>,
    /// Points of each strip from mid-face, m.
    lever: Vec<[f64; POINTS]>,
    /// Arm of the normal force on each strip about the axis of gear 1, over its base radius.
    arm: Vec<f64>,
    cos_beta_b: f64,
    base_radius: f64,
    z_ref: f64,
    limits: Limits,
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
    pub(super) fn new(
        geometry: &PairGeometry,
        compliance: &[Arc<dyn ToothCompliance>; 2],
        candidates: Vec<Candidate>,
        limits: Limits,
    ) -> Result<PositionProblem, BeyondModel> {
        let n = candidates.len();
        let mut bulk = DMatrix::zeros(n, n);
        let mut lengths = [Vec::new(), Vec::new()];
        for (i, model) in compliance.iter().enumerate() {
            let strips: Vec<Strip> = candidates.iter().map(|c| c.strips[i]).collect();
            bulk += model.bulk(&strips)?;
            lengths[i] = model.reference_lengths(&strips);
        }
        // Rounding must not break the symmetry that the energy rests on.
        let mut symmetric: Vec<f64> = (0..n * n)
            .map(|at| 0.5 * (bulk[(at / n, at % n)] + bulk[(at % n, at / n)]))
            .collect();
        let cos_beta_b = geometry.base_helix_angle().cos();
        let plane_compliance = [0, 1].map(|i| {
            let gear = &geometry.gears[i];
            (1.0 - gear.poisson_ratio.powi(2)) / gear.youngs_modulus
        });
        let strip_lengths: Vec<f64> = candidates
            .iter()
            .map(|c| (c.z[1] - c.z[0]) / cos_beta_b)
            .collect();
        division::divide(
            &mut symmetric,
            &mut lengths,
            plane_compliance.map(|p| 2.0 * p / PI),
            &strip_lengths,
            division::WANTED_LENGTH * geometry.gears[0].normal_module,
        );
        let local = candidates
            .iter()
            .enumerate()
            .map(|(strip, candidate)| {
                let bodies = [0, 1].map(|i| LocalBody {
                    plane_compliance: plane_compliance[i],
                    reference_length: lengths[i][strip],
                });
                let length = strip_lengths[strip] / POINTS as f64;
                LocalContact::new(bodies, candidate.radius, length, candidate.edge_slope)
            })
            .collect();
        let z_ref = geometry.z_ref();
        Ok(PositionProblem {
            lever: candidates
                .iter()
                .map(|c| c.points().map(|z| z - z_ref))
                .collect(),
            arm: candidates.iter().map(|c| c.arm * cos_beta_b).collect(),
            candidates,
            bulk: symmetric,
            local,
            cos_beta_b,
            base_radius: geometry.gears[0].base_radius(),
            z_ref,
            limits,
        })
    }

    /// The strips that may touch.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Bulk influence matrix of both gears over the strips, m/N, row by row, less what the local contact has
    /// taken over from its diagonal.
    pub fn bulk(&self) -> &[f64] {
        &self.bulk
    }

    /// Gaps at the points of each strip along the normal under `misalignment`, m: it closes them as an approach
    /// of its size there does.
    fn gaps(&self, misalignment: f64) -> Vec<[f64; POINTS]> {
        let closing = |arm: f64, lever: f64| arm * misalignment * lever;
        self.candidates
            .iter()
            .zip(self.arm.iter().zip(&self.lever))
            .map(|(c, (arm, lever))| {
                std::array::from_fn(|q| self.cos_beta_b * c.gap[q] - closing(*arm, lever[q]))
            })
            .collect()
    }

    /// Approach at which the first strip touches, m: the no-load transmission error.
    pub fn no_load_approach(&self, misalignment: f64) -> f64 {
        self.gaps(misalignment)
            .into_iter()
            .zip(&self.arm)
            .flat_map(|(gaps, arm)| gaps.map(|gap| gap / arm))
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
        self.solve(Target::Force(torque / self.base_radius), misalignment, warm)
    }

    /// Contact at the given `approach` (m on the line of action at mid-face) and `misalignment` (rad),
    /// from the forces of `warm` where there is one.
    ///
    /// # Errors
    /// [`ContactError::Input`] for numbers that are not finite, [`ContactError::BeyondReach`] where tip
    /// corners would have to be followed farther than was set, and what the solve itself can refuse
    /// ([`ContactError::ContactTooWide`], [`ContactError::NotPositiveDefinite`],
    /// [`ContactError::NotConverged`]).
    pub fn solve_approach(
        &self,
        approach: f64,
        misalignment: f64,
        warm: Option<&ContactResult>,
    ) -> Result<ContactResult, ContactError> {
        finite("approach", approach)?;
        self.solve(Target::Approach(approach), misalignment, warm)
    }

    fn solve(
        &self,
        target: Target,
        misalignment: f64,
        warm: Option<&ContactResult>,
    ) -> Result<ContactResult, ContactError> {
        finite("misalignment", misalignment)?;
        let gap = self.gaps(misalignment);
        let problem = Problem {
            bulk: &self.bulk,
            local: &self.local,
            gap: &gap,
            arm: &self.arm,
        };
        let start = warm.map(|w| (w.forces.as_slice(), w.approach));
        let at = OperatingPoint {
            prescribed: match target {
                Target::Force(force) => Prescribed::Torque(force * self.base_radius),
                Target::Approach(approach) => Prescribed::Approach(approach),
            },
            misalignment,
            center_distance_offset: self.limits.center_distance_offset,
        };
        let solution = problem
            .solve(target, start, self.limits.foundation)
            .map_err(|failure| match failure {
                Failure::ContactTooWide { pressure } => ContactError::ContactTooWide {
                    at,
                    pressure_mpa: 1e-6 * pressure,
                },
                Failure::NotPositiveDefinite { pivot } => {
                    ContactError::NotPositiveDefinite { at, pivot }
                }
                Failure::NotConverged {
                    iterations,
                    residual,
                } => ContactError::NotConverged {
                    at,
                    iterations,
                    residual,
                },
            })?;
        if let Some(reach) = self.limits.reach {
            let needed = self
                .lever
                .iter()
                .flatten()
                .map(|lever| solution.approach + misalignment * lever)
                .fold(f64::NEG_INFINITY, f64::max);
            if needed > reach {
                return Err(ContactError::BeyondReach {
                    at,
                    needed_um: 1e6 * needed,
                    reach_um: 1e6 * reach,
                });
            }
        }
        Ok(self.result(solution, &gap))
    }

    fn result(&self, solution: Solution, gap: &[[f64; POINTS]]) -> ContactResult {
        let loa_force = dot(&self.arm, &solution.force);
        let mut moment = 0.0;
        let mut pressures = vec![0.0f64; solution.force.len()];
        // Sums of the derivatives of the forces at the points, times powers 0, 1, 2 of their levers.
        let mut slopes = vec![[0.0; 3]; solution.force.len()];
        for i in 0..solution.force.len() {
            if solution.force[i] == 0.0 {
                continue;
            }
            for (gap, lever) in gap[i].iter().zip(&self.lever[i]) {
                let (force, slope) = self.local[i].force(solution.closing[i] - gap);
                moment += self.arm[i] * force * lever;
                pressures[i] = pressures[i].max(self.local[i].pressure(force));
                for (power, sum) in (0..).zip(&mut slopes[i]) {
                    *sum += slope * lever.powi(power);
                }
            }
        }
        let mut load_share: Vec<(i32, f64)> = Vec::new();
        let carried = self.arm.iter().zip(&solution.force).map(|(c, f)| c * f);
        for (candidate, force) in self.candidates.iter().zip(carried) {
            let share = if loa_force > 0.0 {
                force / loa_force
            } else {
                0.0
            };
            match load_share.last_mut() {
                Some((k, sum)) if *k == candidate.tooth_pair => *sum += share,
                _ => load_share.push((candidate.tooth_pair, share)),
            }
        }
        let max_pressure = pressures.iter().copied().fold(0.0, f64::max);
        ContactResult {
            approach: solution.approach,
            loa_force,
            moment,
            contact_z: self.z_ref
                + if loa_force > 0.0 {
                    moment / loa_force
                } else {
                    0.0
                },
            load_share,
            max_pressure,
            kkt_residual: solution.kkt_residual,
            iterations: solution.iterations,
            tangent: self.tangent(&solution, &slopes),
            pressures,
            forces: solution.force,
        }
    }

    /// With K the matrix over the strips in contact, c their arms, and s_n the sums of phi' times the
    /// n-th power of the lever over the points of a strip: dF = K^-1 c (d delta + s_1 / s_0 dM), and the
    /// moment changes by c (s_1 / s_0 dF + c (s_2 - s_1^2 / s_0) dM).
    fn tangent(&self, solution: &Solution, slopes: &[[f64; 3]]) -> Tangent {
        let active = || solution.active.iter().map(|&i| (self.arm[i], slopes[i]));
        let arms: Vec<f64> = active().map(|(c, _)| c).collect();
        let levers: Vec<f64> = active().map(|(c, s)| c * s[1] / s[0]).collect();
        let (mut by_approach, mut by_misalignment) = (arms.clone(), levers.clone());
        solution.factor.solve(&mut by_approach);
        solution.factor.solve(&mut by_misalignment);
        let within: f64 = active()
            .map(|(c, s)| c * c * (s[2] - s[1] * s[1] / s[0]))
            .sum();
        Tangent {
            force_by_approach: dot(&by_approach, &arms),
            force_by_misalignment: dot(&by_misalignment, &arms),
            moment_by_misalignment: dot(&by_misalignment, &levers) + within,
        }
    }

    /// Every strip with what it carries in `result`, for plots of the pressure.
    pub fn strip_loads(&self, result: &ContactResult) -> Vec<StripLoad> {
        self.candidates
            .iter()
            .zip(&result.forces)
            .zip(&result.pressures)
            .zip(&self.local)
            .map(|(((candidate, &force), &pressure), local)| StripLoad {
                tooth_pair: candidate.tooth_pair,
                z: candidate.z,
                roll: candidate.roll,
                force,
                pressure,
                reaches_edge: local.reaches_edge(force / POINTS as f64),
            })
            .collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn finite(field: &'static str, value: f64) -> Result<(), ContactError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(ContactError::Input {
        field,
        value,
        remedy: "give a finite number",
    })
}
