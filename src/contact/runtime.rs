//! Static contact at run time: the same solve as everywhere, at the pose as it is, as one potential.
//!
//! With the forces y of a solution, the potential of the mesh is
//!
//! W = y' A y / 2 + sum of the energies of the local contact,
//!
//! stationary in y: F_bt = dW/d delta and the moment dW/dM come with the solution, and its slopes by centre distance and
//! mesh position are those at fixed y, segment by segment, by differences of a smooth function of the pose.

use std::sync::Arc;

use super::candidates::{Candidate, ContactLines, SegmentName};
use super::complementarity::Start;
use super::condensed::CondensedFlank;
use super::error::{ContactError, Prescribed};
use super::position::{Found, PositionProblem, law};
use super::result::Tangent;
use super::setup::ContactSetup;
use super::transverse::{PairNumbers, TransverseSection};
use crate::gear::teeth::{Counts, Passing};
use crate::gear::{Flank, Microgeometry};

/// Potential of one flank.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactPotential {
    /// W, J.
    pub energy: f64,
    /// Derivatives by approach (F_bt), centre distance, misalignment (shuttling moment) and mesh position.
    pub gradient: [f64; 4],
    /// Second derivatives by approach and misalignment.
    pub tangent: Tangent,
    /// Approach beyond that for which tip edges are followed, centre distance beyond the nodes, segments in reach that they do not
    /// hold, or a pressure that no flank carries.
    pub out_of_range: bool,
}

/// The contact of one flank of a pair, ready to be solved anywhere.
#[derive(Debug, Clone)]
pub struct RuntimeContact {
    setup: Arc<ContactSetup>,
    numbers: PairNumbers,
    condensed: Arc<CondensedFlank>,
    flank: Flank,
    /// `None`: all teeth are alike.
    teeth: Option<Arc<Passing>>,
    /// Whether no flank stands out of the unmodified one, so that flanks that are far apart there are so in all.
    only_removes: bool,
}

/// Forces of the last solve, from which the next one starts. It saves steps of Newton's iteration and changes the solution by no
/// more than rounding.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Warm {
    /// Segments that carry by tooth pair, counted from the start, and station, ascending; N.
    forces: Vec<((i64, usize), f64)>,
}

/// A pose of the mesh.
#[derive(Debug, Clone, Copy)]
struct Pose {
    /// m.
    approach: f64,
    /// Deviation from the nominal centre distance, m.
    offset: f64,
    /// rad.
    misalignment: f64,
    /// Mesh position, in [0, 1).
    tau: f64,
    /// Which teeth are in mesh.
    counts: Counts,
}

/// Steps of the differences by mesh position and by centre distance, m: what the energy of a segment curves over them is a
/// millionth of its slope, and so is what rounding leaves.
const STEPS: [f64; 2] = [1e-8, 1e-10];

/// Segments whose gap exceeds their closing by more than this part of the largest closing take no part: the others'
/// forces push flanks apart nearly everywhere, and where they do not, by far less.
const MARGIN: f64 = 0.1;

/// Flanks that are farther apart than this many times what approach, misalignment and teeth close at most are beyond that
/// margin, whatever the arm of their force.
const CLEARLY_APART: f64 = 1.25;

impl RuntimeContact {
    /// The contact of `flank`, whose condensed model is `condensed`.
    pub fn new(setup: Arc<ContactSetup>, condensed: Arc<CondensedFlank>, flank: Flank) -> Self {
        let own = setup.teeth.flank(flank).iter().flat_map(|t| &t.flanks);
        let only_removes = (setup.microgeometry.flank(flank).iter())
            .chain(own.map(|own| &own.microgeometry))
            .all(Microgeometry::only_removes);
        RuntimeContact {
            numbers: PairNumbers::new(&setup.geometry).with_corners(setup.corner_resolution),
            teeth: Passing::new(&setup.geometry, &setup.teeth, flank).map(Arc::new),
            only_removes,
            setup,
            condensed,
            flank,
        }
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
        let pose = Pose {
            approach,
            offset,
            misalignment,
            tau: position - turns,
            counts: counts.map(|count| count + turns as i64),
        };
        let last = std::mem::take(warm);
        let section = self.setup.section(&self.numbers, offset)?;
        let candidates = self.near(&section, pose);
        if candidates.is_empty() {
            return Ok(ContactPotential::default());
        }
        let count = candidates.len();
        let problem = self.problem(candidates, pose);
        let all_held = problem.candidates().len() == count;
        let start = last.start(problem.candidates(), pose);
        let solve = |start| problem.solution(Prescribed::Approach(approach), misalignment, start);
        let found = match solve(start.as_ref()) {
            // A start that leads nowhere must not decide.
            Err(_) if start.is_some() => solve(None),
            found => found,
        }?;
        let solution = &found.solution;
        let carrying = problem.candidates().iter().zip(&solution.force);
        warm.forces = carrying
            .filter(|(_, force)| **force > 0.0)
            .map(|(segment, force)| (pose.since_start(segment), *force))
            .collect();
        if warm.forces.is_empty() {
            return Ok(ContactPotential {
                out_of_range: !all_held,
                ..ContactPotential::default()
            });
        }
        let (energy, [by_tau, by_offset]) =
            self.at_fixed_forces(&problem, &section, pose, &found)?;
        let (moment, tangent) = problem.moment(solution);
        let force = problem.arm.dot(&solution.force);
        Ok(ContactPotential {
            energy,
            gradient: [force, by_offset, moment, by_tau],
            tangent,
            out_of_range: found.excess.is_some() || !self.condensed.holds(offset) || !all_held,
        })
    }

    /// The energy of `problem`, and its slopes by mesh position and centre distance at fixed forces.
    ///
    /// With x what gap and local contact take up on a segment, dW = y' dA y / 2 + sum of d Phi(x), where x changes with A,
    /// arm and gap: at a solution phi(x) = y, so that the share of A is -y' dA y / 2 in all.
    fn at_fixed_forces(
        &self,
        problem: &PositionProblem,
        section: &TransverseSection,
        pose: Pose,
        found: &Found,
    ) -> Result<(f64, [f64; 2]), ContactError> {
        let (segments, solution) = (problem.candidates(), &found.solution);
        let loaded: Vec<usize> = (0..segments.len())
            .filter(|&i| solution.force[i] > 0.0)
            .collect();
        let names: Vec<SegmentName> = loaded.iter().map(|&i| segments[i].name()).collect();
        let forces: Vec<f64> = loaded.iter().map(|&i| solution.force[i]).collect();
        let scale = |k| self.compliance(pose, k);
        let influence = (self.condensed).slopes(&names, &forces, scale, pose.tau, pose.offset);
        let mut slopes = [0, 1].map(|axis| -influence[axis].work);
        let offset = pose.offset + STEPS[1];
        let there = self.setup.section(&self.numbers, offset)?;
        let tau = pose.tau + STEPS[0];
        let moved = [
            (Pose { tau, ..pose }, section),
            (Pose { offset, ..pose }, &there),
        ];
        let mut energy = 0.0;
        for (place, &i) in loaded.iter().enumerate() {
            // What the forces displace the bodies by on this segment.
            let deflection = problem.arm[i] * pose.approach - solution.closing[i];
            let local = solution.loads[i].energy();
            energy += 0.5 * solution.force[i] * deflection + local;
            for (axis, (pose, section)) in moved.iter().enumerate() {
                let known = problem.lengths(i);
                let lengths =
                    [0, 1].map(|g| known[g] + influence[axis].lengths[g][place] * STEPS[axis]);
                let there = (self.lines(section, *pose))
                    .segment(pose.tau, names[place], segments[i].closest)
                    .map_or(0.0, |segment| {
                        self.local_energy(&segment, lengths, deflection, *pose)
                    });
                slopes[axis] += (there - local) / STEPS[axis];
            }
        }
        Ok((energy, slopes))
    }

    /// Energy of the local contact of `segment`, whose reference lengths are `lengths` (m), J, where the bodies are displaced by
    /// `deflection` (m).
    fn local_energy(
        &self,
        segment: &Candidate,
        lengths: [f64; 2],
        deflection: f64,
        pose: Pose,
    ) -> f64 {
        let cos_beta_b = self.numbers.cos_beta_b;
        let law = law(&self.numbers, segment, &segment.profile, lengths);
        let closing = segment.arms[0] * cos_beta_b * pose.approach - deflection;
        let left = |q: usize| segment.gap[q] - pose.misalignment * segment.levers[q];
        law.loads(std::array::from_fn(|q| closing - cos_beta_b * left(q)))
            .energy()
    }

    /// The segments that may carry at `pose`; none if none touches.
    fn near(&self, section: &TransverseSection, pose: Pose) -> Vec<Candidate> {
        let [first, last] = section.reach();
        let within = if self.only_removes {
            let lever = 0.5 * self.numbers.face[1] + self.numbers.tan_beta_b * last.max(-first);
            let closing = pose.approach.max(0.0)
                + (pose.misalignment * lever).abs()
                + self.setup.teeth.largest_closing();
            section.within(CLEARLY_APART * closing)
        } else {
            [first, last]
        };
        let mut segments = self.lines(section, pose).candidates(pose.tau, within);
        // How far flanks overlap, along the line of action.
        let overlap = |segment: &Candidate| {
            let closed = segment.arms[0] * pose.approach;
            let points = segment.levers.into_iter().zip(segment.gap);
            let each = points.map(|(lever, gap)| closed + pose.misalignment * lever - gap);
            each.fold(f64::NEG_INFINITY, f64::max)
        };
        let most = segments.iter().map(overlap).fold(0.0, f64::max);
        segments.retain(|segment| most > 0.0 && overlap(segment) > -MARGIN * most);
        segments
    }

    /// The contact lines in `section`.
    fn lines<'a>(&'a self, section: &'a TransverseSection, pose: Pose) -> ContactLines<'a> {
        ContactLines {
            teeth: self.teeth.as_deref().map(|passing| (passing, pose.counts)),
            ..self.setup.lines(self.flank, section)
        }
    }

    /// Compliance of tooth pair `k` under its own load over that of others.
    fn compliance(&self, pose: Pose, k: i32) -> f64 {
        let shares = self.condensed.shares;
        (self.teeth.as_ref()).map_or(1.0, |teeth| teeth.compliance(shares, pose.counts, k))
    }

    /// The problem of those of `candidates` that the nodes hold: far beyond their centre distances others come into reach, which
    /// bear nothing.
    fn problem(&self, mut candidates: Vec<Candidate>, pose: Pose) -> PositionProblem {
        let influence = |candidates: &[Candidate]| {
            let names: Vec<SegmentName> = candidates.iter().map(Candidate::name).collect();
            let scale = |k| self.compliance(pose, k);
            (self.condensed).influence(&names, scale, pose.tau, pose.offset)
        };
        let mut known = influence(&candidates);
        let [first, second] = &known.lengths;
        let held: Vec<bool> = first
            .iter()
            .zip(second)
            .map(|(a, b)| *a > 0.0 && *b > 0.0)
            .collect();
        if held.contains(&false) {
            let mut held = held.into_iter();
            candidates.retain(|_| held.next() == Some(true));
            known = influence(&candidates);
        }
        let limits = self.setup.limits(pose.offset);
        PositionProblem::with(&self.numbers, candidates, known, limits)
    }
}

impl Pose {
    /// The name by which a segment is known in other cycles.
    fn since_start(self, segment: &Candidate) -> (i64, usize) {
        (
            i64::from(segment.tooth_pair) - self.counts[0],
            segment.station,
        )
    }
}

impl Warm {
    /// Where a solve for `segments` at `pose` starts; `None` where nothing is known.
    fn start(&self, segments: &[Candidate], pose: Pose) -> Option<Start> {
        let force = |segment: &Candidate| {
            let name = pose.since_start(segment);
            let place = self.forces.binary_search_by_key(&name, |known| known.0);
            place.map_or(0.0, |place| self.forces[place].1)
        };
        (!self.forces.is_empty()).then(|| Start {
            forces: segments.iter().map(force).collect(),
            approach: pose.approach,
        })
    }
}
