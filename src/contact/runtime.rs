//! Static contact at run time: the same solve as everywhere, at the pose as it is, as one potential.
//!
//! With the forces y of a solution, the potential of the mesh is
//!
//! W = y' A y / 2 + sum of the energies of the local contact,
//!
//! stationary in y: F_bt = dW/d delta and the moment dW/dM come with the solution, and its slopes by centre distance and
//! mesh position are those at fixed y, segment by segment, by differences of a smooth function of the pose.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DVector;

use super::bulk::Influence;
use super::candidates::{Candidate, ContactLines};
use super::complementarity::{Solution, Start};
use super::condensed::{CondensedFlank, ContactFile};
use super::error::{ContactError, Prescribed};
use super::local_law::LocalBody;
use super::position::{ContactProblem, Tangent};
use super::setup::ContactSetup;
use crate::friction::{Sliding, SlidingSums};
use crate::gear::teeth::{Counts, Passing};
use crate::gear::{Flank, PairNumbers};

/// Potential of one flank.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactPotential {
    /// W, J.
    pub energy: f64,
    /// Derivatives by approach (F_bt), centre distance, misalignment (shuttling moment) and mesh position.
    pub gradient: [f64; 4],
    /// Second derivatives by approach and misalignment.
    pub tangent: Tangent,
    /// How the load slides; zero unless [`RuntimeContact::with_friction`] asks for it.
    pub sliding: Sliding,
    /// Largest principal stress in the tooth roots of gear 1 and gear 2, Pa; zero unless [`RuntimeContact::with_root_stress`] asks
    /// for it.
    pub root_stress: [f64; 2],
    /// Approach beyond that for which tip edges are followed, centre distance beyond the nodes, candidates that they lack,
    /// or a pressure that no flank carries.
    pub out_of_range: bool,
}

/// The contact of one flank of a pair, ready to be solved anywhere.
#[derive(Debug, Clone)]
pub struct RuntimeContact {
    setup: Arc<ContactSetup>,
    numbers: PairNumbers,
    bodies: [LocalBody; 2],
    condensed: Arc<CondensedFlank>,
    flank: Flank,
    /// `None`: all teeth are alike.
    teeth: Option<Arc<Passing>>,
    friction: Option<SlidingSums>,
    root_stress: bool,
}

/// Forces of the last solve, from which the next one starts: saves Newton steps, changes the solution by rounding alone.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Warm {
    /// N, by tooth pair, counted from the start, and station; those that carry.
    forces: BTreeMap<(i64, usize), f64>,
}

struct Pose<'a> {
    approach: f64,
    misalignment: f64,
    /// Which teeth are in mesh.
    counts: Counts,
    /// At its mesh position, in [0, 1).
    lines: ContactLines<'a>,
}

impl Pose<'_> {
    /// What a segment is known by in other cycles.
    fn since_start(&self, segment: &Candidate) -> (i64, usize) {
        let tooth_pair = i64::from(segment.tooth_pair) - self.counts[0];
        (tooth_pair, segment.station)
    }

    /// The segments that may carry.
    fn candidates(&self) -> Vec<Candidate> {
        let mut segments = self.lines.candidates();
        let overlap = |segment: &Candidate| {
            let closed = segment.arm() * self.approach;
            let points = segment.levers.into_iter().zip(segment.gap);
            let each = points.map(|(lever, gap)| closed + self.misalignment * lever - gap);
            each.fold(f64::NEG_INFINITY, f64::max)
        };
        let most = segments.iter().map(overlap).fold(0.0, f64::max);
        segments.retain(|segment| most > 0.0 && overlap(segment) > -MARGIN * most);
        segments
    }
}

/// Steps of the differences by mesh position and by centre distance, m: curvature and rounding leave a millionth of the slope.
const STEPS: [f64; 2] = [1e-8, 1e-10];

/// Segments whose gap exceeds their closing by more than this part of the largest closing take no part.
const MARGIN: f64 = 0.1;

impl ContactFile {
    /// The contact of `flank`; `None`: the drive flank's, mirrored.
    pub fn flank(&self, flank: Flank) -> Option<RuntimeContact> {
        let condensed = match flank {
            Flank::Drive => &self.drive,
            Flank::Coast => self.coast.as_ref()?,
        };
        let (setup, condensed) = (self.setup.clone(), condensed.clone());
        Some(RuntimeContact::new(setup, condensed, flank))
    }
}

impl RuntimeContact {
    /// The contact of `flank`, whose condensed model is `condensed`.
    pub fn new(setup: Arc<ContactSetup>, condensed: Arc<CondensedFlank>, flank: Flank) -> Self {
        RuntimeContact {
            numbers: PairNumbers::new(&setup.geometry),
            bodies: setup.local_bodies(),
            teeth: Passing::new(&setup.geometry, &setup.teeth, flank).map(Arc::new),
            setup,
            condensed,
            flank,
            friction: None,
            root_stress: false,
        }
    }

    /// The same with the sliding under the law of friction of its pair; without a law it stays zero.
    #[must_use]
    pub fn with_friction(mut self) -> Self {
        let law = self.setup.friction.as_ref();
        self.friction = law.map(|law| SlidingSums::new(&self.setup.geometry, law));
        self
    }

    /// The same with the stress in the tooth roots; it stays zero where the condensed model has none.
    #[must_use]
    pub fn with_root_stress(mut self) -> Self {
        self.root_stress = true;
        self
    }

    /// The potential at the approach (m), centre distance offset (m), misalignment (rad) and mesh position `at`, with the
    /// teeth of the cycle `counts`, from the forces of `warm`, which become those found.
    ///
    /// # Errors
    /// [`ContactError::OutOfMesh`] where teeth cannot meet, and a solve that does not converge.
    pub fn potential(
        &self,
        at: [f64; 4],
        counts: Counts,
        warm: &mut Warm,
    ) -> Result<ContactPotential, ContactError> {
        let [approach, offset, misalignment, position] = at;
        let turns = position.floor();
        let counts = counts.map(|count| count + turns as i64);
        let last = std::mem::take(&mut warm.forces);
        let pose = Pose {
            approach,
            misalignment,
            counts,
            lines: ContactLines {
                setup: &self.setup,
                center_distance_offset: offset,
                section: self.setup.section(&self.numbers, offset)?,
                flank: self.flank,
                tau: position - turns,
                teeth: self.teeth.as_deref().map(|passing| (passing, counts)),
                clamped: false,
            },
        };
        let candidates = pose.candidates();
        if candidates.is_empty() {
            return Ok(ContactPotential::default());
        }
        let count = candidates.len();
        let problem = self.problem(candidates, &pose.lines);
        let segments = &problem.candidates;
        let missing = segments.len() < count;
        let known = |segment| last.get(&pose.since_start(segment)).copied().unwrap_or(0.0);
        let forces: Vec<f64> = segments.iter().map(known).collect();
        let start = (!last.is_empty()).then_some(Start {
            forces: &forces,
            approach,
        });
        let solve = |start| problem.solution(Prescribed::Approach(approach), misalignment, start);
        let solution = match solve(start) {
            Err(_) if start.is_some() => solve(None),
            solution => solution,
        }?;
        let loads = segments.iter().zip(solution.force.iter().copied());
        let loads: Vec<_> = loads.filter(|(_, force)| *force > 0.0).collect();
        let forces = loads.iter().map(|(s, force)| (pose.since_start(s), *force));
        warm.forces = forces.collect();
        if loads.is_empty() {
            return Ok(ContactPotential {
                out_of_range: missing,
                ..ContactPotential::default()
            });
        }
        let (energy, [by_tau, by_offset]) = self.at_fixed_forces(&problem, &pose, &solution)?;
        let (moment, tangent, _) = problem.moment(&solution);
        let force = problem.arm.dot(&solution.force);
        let sliding = (self.friction.as_ref()).map_or(Sliding::default(), |sums| {
            problem.sliding(sums, solution.force.iter().copied(), force)
        });
        let roots = (self.condensed.roots.as_ref()).filter(|_| self.root_stress);
        Ok(ContactPotential {
            energy,
            gradient: [force, by_offset, moment, by_tau],
            tangent,
            sliding,
            root_stress: roots.map_or([0.0; 2], |roots| {
                [0, 1].map(|i| roots[i].largest(&pose.lines, i, &loads))
            }),
            out_of_range: solution.excess.is_some() || !self.condensed.holds(offset) || missing,
        })
    }

    /// The energy of `problem`, and its slopes by mesh position and centre distance at fixed forces.
    ///
    /// With x what gap and local contact take up on a segment, dW = y' dA y / 2 + sum of d Phi(x), where x changes with A,
    /// arm and gap: at a solution phi(x) = y, so that the share of A is -y' dA y / 2 in all.
    fn at_fixed_forces(
        &self,
        problem: &ContactProblem,
        pose: &Pose<'_>,
        solution: &Solution,
    ) -> Result<(f64, [f64; 2]), ContactError> {
        let segments = &problem.candidates;
        let carries = |i: &usize| solution.force[*i] > 0.0;
        let loaded: Vec<usize> = (0..segments.len()).filter(carries).collect();
        let carrying: Vec<&Candidate> = loaded.iter().map(|&i| &segments[i]).collect();
        let forces: DVector<f64> = solution.force.select_rows(&loaded);
        let lines = &pose.lines;
        let influence = self.condensed.slopes(&carrying, lines);
        let places = (solution.placed.as_ref()).map(|placed| placed.places.select_rows(&loaded));
        let mut slopes = [0, 1].map(|axis| {
            let Influence { bulk, motion, .. } = &influence[axis];
            let still = -0.5 * (bulk * &forces).dot(&forces);
            let (Some(motion), Some(places)) = (motion, &places) else {
                return still;
            };
            let moments = places.component_mul(&forces);
            let bent = motion.bend.component_mul(&moments) * 0.5 + &motion.tilt * &forces;
            still - bent.dot(&moments)
        });
        let offset = lines.center_distance_offset + STEPS[1];
        let farther = (lines.section).near(self.setup.geometry.center_distance + offset);
        let moved = [
            ContactLines {
                tau: lines.tau + STEPS[0],
                ..lines.clone()
            },
            ContactLines {
                center_distance_offset: offset,
                section: farther.ok_or_else(|| self.setup.out_of_mesh(offset))?,
                ..lines.clone()
            },
        ];
        let mut energy = 0.0;
        for (number, &i) in loaded.iter().enumerate() {
            let deflection = problem.arm[i] * pose.approach - solution.closing[i];
            let local = solution.loads[i].energy();
            energy += 0.5 * solution.force[i] * deflection + local;
            for (axis, lines) in moved.iter().enumerate() {
                let known = problem.lengths(i);
                let grown = |g: usize| influence[axis].lengths[g][number] * STEPS[axis];
                let lengths = [0, 1].map(|g| known[g] + grown(g));
                let there = lines.segment(segments[i].tooth_pair, segments[i].station);
                let there = there.map_or(0.0, |segment| {
                    let law = problem.law(&segment, &segment.profile, lengths);
                    let closing = self.numbers.cos_beta_b * segment.arm() * pose.approach;
                    let left = |q: usize| segment.gap[q] - pose.misalignment * segment.levers[q];
                    let opened = (solution.placed.as_ref())
                        .map_or(0.0, |placed| placed.opened(i, &segment.profile));
                    let penetration =
                        |q| closing - deflection - opened - self.numbers.cos_beta_b * left(q);
                    law.loads(std::array::from_fn(penetration)).energy()
                });
                slopes[axis] += (there - local) / STEPS[axis];
            }
        }
        Ok((energy, slopes))
    }

    /// The problem of those of `candidates` that the nodes hold; others, far beyond their centre distances, bear nothing.
    fn problem(&self, mut candidates: Vec<Candidate>, lines: &ContactLines<'_>) -> ContactProblem {
        let influence = |candidates: &[Candidate]| {
            let segments: Vec<&Candidate> = candidates.iter().collect();
            self.condensed.influence(&segments, lines)
        };
        let mut known = influence(&candidates);
        let [first, second] = &known.lengths;
        let held = first.iter().zip(second).map(|(a, b)| *a > 0.0 && *b > 0.0);
        let held: Vec<bool> = held.collect();
        if held.contains(&false) {
            let mut held = held.into_iter();
            candidates.retain(|_| held.next() == Some(true));
            known = influence(&candidates);
        }
        ContactProblem::new(lines, self.bodies, candidates, known)
    }
}
