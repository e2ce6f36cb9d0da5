//! Static contact at run time: the same solve as everywhere, at the pose as it is, as one potential.
//!
//! With the forces y of a solution, the potential of the mesh is
//!
//! W = y' A y / 2 + sum of the energies of the local contact,
//!
//! stationary in y: F_bt = dW/d delta and the moment dW/dM come with the solution, and its slopes by centre distance and
//! mesh position are those at fixed y, strip by strip: in closed form where a strip touches inside its flanks, else by
//! differences of a smooth function of the pose; where contact only reaches the start of a relief, of its law alone,
//! with the rates of its gaps in closed form.

use std::sync::Arc;

use super::candidates::{Candidate, ContactLines, POINTS, StripRates, TeethAt};
use super::cholesky::dot;
use super::complementarity::{Solution, Target};
use super::condensed::{CondensedFlank, StripName};
use super::error::ContactError;
use super::near::Near;
use super::numbers::PairNumbers;
use super::position::{PositionProblem, law};
use super::result::Tangent;
use super::setup::ContactSetup;
use super::transverse::TransverseSection;
use super::warm::{SinceStart, Warm};
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
    /// Approach beyond that for which tip edges are followed, centre distance beyond the nodes, strips in reach that they do not
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

/// Steps of the differences by centre distance, m, and by mesh position: what the energy of a strip curves over them is a millionth of
/// its slope, and so is what rounding leaves.
const STEPS: [f64; 2] = [1e-10, 1e-8];

/// Strips whose gap exceeds their closing by more than this part of the largest closing take no part: the others'
/// forces push flanks apart nearly everywhere, and where they do not, by far less.
const MARGIN: f64 = 0.1;

/// Flanks that are farther apart than this many times what approach, misalignment and teeth close at most are beyond that
/// margin, whatever the arm of their force.
const CLEARLY_APART: f64 = 1.25;

impl RuntimeContact {
    /// The contact of `flank`, whose condensed model is `condensed`.
    pub fn new(setup: Arc<ContactSetup>, condensed: Arc<CondensedFlank>, flank: Flank) -> Self {
        RuntimeContact {
            numbers: PairNumbers::new(&setup.geometry).with_corners(setup.corner_resolution),
            teeth: Passing::new(&setup.geometry, &setup.teeth, flank).map(Arc::new),
            only_removes: {
                let own = setup.teeth.flank(flank).iter().flat_map(|t| &t.flanks);
                (setup.microgeometry.flank(flank).iter())
                    .chain(own.map(|own| &own.microgeometry))
                    .all(Microgeometry::only_removes)
            },
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
        let tau = position - turns;
        let cycle = Cycle {
            tau,
            counts: counts.map(|count| count + turns as i64),
        };
        let section = self.setup.section(&self.numbers, offset)?;
        let (near, all_held) = self.near(&section, at, cycle);
        let Some((problem, rates)) = near else {
            warm.clear();
            return Ok(ContactPotential {
                out_of_range: !all_held,
                ..ContactPotential::default()
            });
        };
        let names: Vec<StripName> = problem.candidates().iter().map(Candidate::name).collect();
        let pose = [approach, misalignment, position];
        let start = warm.forces(names.iter().map(|name| cycle.since_start(*name)), pose);
        let start = start.as_deref();
        let start = start.map(|forces| (forces, approach));
        let target = Target::Approach(approach);
        let found = match problem.solution(target, misalignment, start) {
            // A start that leads nowhere must not decide.
            Err(_) if start.is_some() => problem.solution(target, misalignment, None),
            found => found,
        }?;
        let solution = &found.solution;
        if solution.force.iter().all(|force| *force == 0.0) {
            warm.clear();
            return Ok(ContactPotential::default());
        }
        let load = Load {
            misalignment,
            solution,
            gap: &found.gap,
            rates: &rates,
        };
        let (energy, [by_offset, by_tau]) =
            self.held(&problem, &section, (offset, cycle), &load)?;
        let (moment, tangent, slopes) = problem.moment(solution);
        let carrying = solution.active.iter().zip(slopes);
        let carrying = carrying.map(|(&i, slopes)| {
            let name = cycle.since_start(names[i]);
            (name, solution.force[i], slopes)
        });
        warm.keep(pose, carrying);
        Ok(ContactPotential {
            energy,
            gradient: [
                dot(&problem.arm, &solution.force),
                by_offset,
                moment,
                by_tau,
            ],
            tangent,
            out_of_range: found.excess.is_some() || !self.condensed.holds(offset) || !all_held,
        })
    }

    /// The energy of `problem` under `load`, and its slopes by centre distance and mesh position with the forces held.
    ///
    /// With x what gap and local contact take up on a strip, dW = y' dA y / 2 + sum of d Phi(x), where x changes with A,
    /// arm and gap: at a solution phi(x) = y, so that the share of A is -y' dA y / 2 in all.
    fn held(
        &self,
        problem: &PositionProblem,
        section: &TransverseSection,
        (offset, cycle): (f64, Cycle),
        load: &Load,
    ) -> Result<(f64, [f64; 2]), ContactError> {
        let strips = problem.candidates();
        let Solution { force, closing, .. } = load.solution;
        let approach = load.solution.approach;
        let loaded: Vec<usize> = (0..strips.len()).filter(|&i| force[i] > 0.0).collect();
        let names: Vec<StripName> = loaded.iter().map(|&i| strips[i].name()).collect();
        let forces: Vec<f64> = loaded.iter().map(|&i| force[i]).collect();
        let tau = cycle.tau;
        let scale = |k| self.compliance(cycle, k);
        let slopes = self.condensed.slopes(&names, scale, &forces, [tau, offset]);
        let deflection = |i: usize| problem.arm[i] * approach - closing[i];
        let mut energy: f64 = loaded.iter().map(|&i| 0.5 * force[i] * deflection(i)).sum();
        let [mut by_tau, mut by_offset] = slopes.bulk.map(|q| -0.5 * q);
        let (plane, cos_beta_b) = (self.numbers.plane_compliance, self.numbers.cos_beta_b);
        let mut moved: Option<TransverseSection> = None;
        for (place, &i) in loaded.iter().enumerate() {
            let penetration = load.gap[i].map(|gap| closing[i] - gap);
            let lengths = problem.lengths(i);
            let by = slopes
                .lengths
                .each_ref()
                .map(|by| [by[0][place], by[1][place]]);
            let loads = &load.solution.loads[i];
            let inside = problem.local[i].held(loads, penetration, plane);
            if let (Some(held), Some(rates)) = (inside, &load.rates[i]) {
                energy += held.energy;
                let along = |axis: usize| {
                    let opened = rates[axis].gap.iter().zip(loads.forces);
                    let closing: f64 = opened.map(|(g, f)| g * f).sum();
                    let lengths: f64 = (0..2)
                        .map(|g| held.by_log_length[g] * by[axis][g] / lengths[g])
                        .sum();
                    held.by_log_radius * rates[axis].log_radius + lengths - cos_beta_b * closing
                };
                by_tau += along(0);
                by_offset += along(1);
                continue;
            }
            let here: f64 = penetration.map(|x| problem.local[i].energy(x)).iter().sum();
            energy += here;
            let moved = match &moved {
                Some(moved) => moved,
                None => {
                    // Limits of the strips move only where they cut them.
                    let lines = self.lines(section, cycle);
                    let are_whole = loaded.iter().all(|&i| lines.is_whole(&strips[i]));
                    let offset = offset + STEPS[0];
                    moved.insert(match are_whole {
                        true => self.setup.beside(section, offset),
                        false => self.setup.section(&self.numbers, offset),
                    }?)
                }
            };
            let of = |section: &TransverseSection, turn: f64, axis: usize, step: f64| {
                let lengths = [0, 1].map(|g| lengths[g] + by[axis][g] * step);
                let lines = self.lines(section, cycle);
                let (tau, name) = (cycle.tau + turn, names[place]);
                if let Some(rates) = &load.rates[i] {
                    // Only the law is asked for anew.
                    let strip = lines.along(tau, &strips[i], 0.0);
                    let law = law(&self.numbers, &strip, lengths);
                    let points = penetration.iter().zip(rates[axis].gap);
                    let opened = points.map(|(x, gap)| x - cos_beta_b * gap * step);
                    return opened.map(|x| law.energy(x)).sum::<f64>();
                }
                lines.strip(tau, name).map_or(0.0, |strip| {
                    let arm = strip.arms[0] * cos_beta_b;
                    let law = law(&self.numbers, &strip, lengths);
                    let points = strip.levers.into_iter().zip(strip.gap);
                    let energy = |(lever, gap): (f64, f64)| {
                        let left = gap - load.misalignment * lever;
                        law.energy(arm * approach - deflection(i) - cos_beta_b * left)
                    };
                    points.map(energy).sum()
                })
            };
            let [step, turn] = STEPS;
            by_offset += (of(moved, 0.0, 1, step) - here) / step;
            by_tau += (of(section, turn, 0, turn) - here) / turn;
        }
        Ok((energy, [by_offset, by_tau]))
    }

    /// The problem of the strips that may carry, and how fast they change; `None` if none touches. And whether the nodes hold all
    /// that do: far beyond their centre distances others come into reach, which bear nothing.
    fn near(
        &self,
        section: &TransverseSection,
        [approach, offset, misalignment, _]: [f64; 4],
        cycle: Cycle,
    ) -> (Option<Carrying>, bool) {
        let [first, last] = section.reach();
        let lever = 0.5 * self.numbers.face[1] + self.numbers.tan_beta_b * last.max(-first);
        let closing = approach.max(0.0) + (misalignment * lever).abs();
        let closing = closing + self.setup.teeth.largest_closing();
        let seen = if self.only_removes {
            section.within(CLEARLY_APART * closing)
        } else {
            section.reach()
        };
        let near = Near {
            approach,
            misalignment,
            margin: MARGIN,
            convex: self.only_removes,
        };
        let (mut candidates, mut rates) = self.lines(section, cycle).moving(cycle.tau, seen, &near);
        // Contact lines move along the path, and with them what the misalignment closes.
        let closing = misalignment * self.numbers.lean(self.flank) * self.numbers.base_pitch;
        for [by_tau, _] in rates.iter_mut().flatten() {
            by_tau.gap.iter_mut().for_each(|gap| *gap -= closing);
        }
        // How far points overlap, along the line of action.
        let overlaps: Vec<f64> = candidates
            .iter()
            .map(|c| {
                let points = c.levers.into_iter().zip(c.gap);
                let overlap = points.map(|(lever, gap)| near.overlap(lever, c.arms[0], gap));
                overlap.fold(f64::NEG_INFINITY, f64::max)
            })
            .collect();
        let most = overlaps.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if most <= 0.0 {
            return (None, true);
        }
        let mut carrying = overlaps.iter().map(|overlap| *overlap > -MARGIN * most);
        candidates.retain(|_| carrying.next() == Some(true));
        let mut carrying = overlaps.iter().map(|overlap| *overlap > -MARGIN * most);
        rates.retain(|_| carrying.next() == Some(true));
        let problem = self.problem(candidates, offset, cycle);
        let strips = problem.candidates();
        let held = |i: usize| problem.lengths(i).iter().all(|length| *length > 0.0);
        if (0..strips.len()).all(held) {
            return (Some((problem, rates)), true);
        }
        let held = || (0..strips.len()).map(held);
        let candidates: Vec<Candidate> = (strips.iter().zip(held()))
            .filter_map(|(strip, held)| held.then_some(*strip))
            .collect();
        let mut kept = held();
        rates.retain(|_| kept.next() == Some(true));
        let near = (!candidates.is_empty()).then(|| self.problem(candidates, offset, cycle));
        (near.map(|problem| (problem, rates)), false)
    }

    /// The contact lines in `section`.
    fn lines<'a>(&'a self, section: &'a TransverseSection, cycle: Cycle) -> ContactLines<'a> {
        let counts = cycle.counts;
        ContactLines {
            teeth: self
                .teeth
                .as_deref()
                .map(|passing| TeethAt { passing, counts }),
            ..self.setup.lines(self.flank, section)
        }
    }

    /// Compliance of tooth pair `k` under its own load over that of others.
    fn compliance(&self, cycle: Cycle, k: i32) -> f64 {
        let shares = self.condensed.shares;
        self.teeth
            .as_ref()
            .map_or(1.0, |teeth| teeth.compliance(shares, cycle.counts, k))
    }

    fn problem(&self, candidates: Vec<Candidate>, offset: f64, cycle: Cycle) -> PositionProblem {
        let names: Vec<StripName> = candidates.iter().map(|c| c.name()).collect();
        let influence =
            self.condensed
                .influence(&names, |k| self.compliance(cycle, k), [cycle.tau, offset]);
        let limits = self.setup.limits(offset);
        PositionProblem::with(&self.numbers, candidates, influence, limits)
    }
}

/// The problem of the strips that may carry, and how fast each changes by mesh position and by centre distance, where that is known.
type Carrying = (PositionProblem, Vec<Option<[StripRates; 2]>>);

/// A place in the mesh cycle.
#[derive(Debug, Clone, Copy)]
struct Cycle {
    /// Mesh position, in [0, 1).
    tau: f64,
    /// Which teeth are in mesh.
    counts: Counts,
}

impl Cycle {
    /// The name by which a strip is known in other cycles.
    fn since_start(self, (pair, station): StripName) -> SinceStart {
        (i64::from(pair) - self.counts[0], station)
    }
}

/// Where a solution was found.
struct Load<'a> {
    /// rad.
    misalignment: f64,
    solution: &'a Solution,
    /// Gaps along the normal under this misalignment, m.
    gap: &'a [[f64; POINTS]],
    /// By strip.
    rates: &'a [Option<[StripRates; 2]>],
}
