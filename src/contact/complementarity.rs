//! The frictionless contact problem of many segments: forces that press only, gaps that are not negative.
//!
//! Symbols: docs/theory/contact.md. What local contact and gaps of segment i have to take up is x_i = c_i delta - (A F)_i,
//! F_i = phi_i(x_i). Eliminating the local contact like this leaves no inequality: the solution is the minimum over (y, delta)
//! of the convex function J = y' A y / 2 + sum Phi_i(x_i(y, delta)) - F_bt delta, Phi' = phi, at which y = F. Newton's method
//! on it needs a symmetric positive definite system over the segments in contact, D + A with D = 1 / phi', bordered by
//! the load. A search along each step for the zero of the (monotone) directional derivative makes it descend from any start.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::bent::{Movable, Placed, Response, System};
use super::error::Failure;
use super::local_law::{LocalContact, POINTS, PointLoads};
use crate::root::bisection;

pub struct Problem<'a> {
    /// Bulk influence matrix, m/N, symmetric.
    pub bulk: &'a DMatrix<f64>,
    /// Local law of one point of each segment.
    pub local: &'a [LocalContact],
    /// Gaps along the normal at the points of each segment, m, misalignment included.
    pub gap: &'a [[f64; POINTS]],
    /// Arm of the normal force on each segment about the axes, over the base radii; by virtual work also what the flanks close along
    /// their normal per approach.
    pub arm: &'a DVector<f64>,
    pub target: Target,
    /// Stiffness of the elastic foundation that gives the forces to start from, N/m per m of contact line.
    pub foundation: f64,
    /// Length of a point, m, from which on its pressure is judged.
    pub shortest: f64,
    /// How contact moves along the profile; `None`: it stays.
    pub movable: Option<Movable<'a>>,
    /// Relative residual below which, with contact that stays, one step along the tangents of all laws ends the solve. What it leaves
    /// is of the order of the square and is not measured; a residual below that square ends a solve anyway, and derivatives are no
    /// more exact than it takes to find the next solution. Zero: no such step.
    pub last_step_from: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Transverse force on the line of action, N, > 0.
    Force(f64),
    /// Approach on the line of action, m.
    Approach(f64),
}

/// Where a solve starts.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// Normal force on each segment, N.
    pub forces: &'a [f64],
    /// Approach on the line of action, m; that of the target takes its place.
    pub approach: f64,
}

/// Forces in equilibrium.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Normal force on each segment, N.
    pub force: DVector<f64>,
    /// Approach on the line of action, m.
    pub approach: f64,
    /// What local contact and gap have to take up together on each segment, m.
    pub closing: DVector<f64>,
    /// Local contact at the points of each segment.
    pub loads: Vec<PointLoads>,
    /// Newton steps it took.
    pub iterations: usize,
    /// Largest violation of equilibrium or of the contact conditions over the largest force: force on a segment less what its
    /// gaps and local contact ask for under the displacement of all forces; after a step along tangents the square of the one before.
    pub kkt_residual: f64,
    /// The segments in contact.
    pub active: Vec<usize>,
    /// Factor of D + A over the segments in contact.
    factor: Factor,
    /// Where contact has moved to; `None`: it stays.
    pub placed: Option<Placed>,
    response: Option<Response>,
    /// Relative error to which its response is repeated.
    tolerance: f64,
    /// What it exceeds: a pressure that no flank carries, or the approach for which tip edges were followed.
    pub excess: Option<Failure>,
}

impl Solution {
    /// Forces on the segments in contact by which their closings grow by `closing`, N from m.
    pub fn stiffened(&self, closing: &DVector<f64>) -> DVector<f64> {
        match &self.response {
            Some(response) => response.solve(&self.factor, closing, self.tolerance),
            None => self.factor.solve(closing),
        }
    }
}

type Factor = Cholesky<f64, Dyn>;

/// Newton steps after which a solve gives up with an error. Twenty are seldom needed.
pub const MAXIMUM_ITERATIONS: usize = 200;
/// Relative residual below which Newton steps are taken as a whole where contact moves.
const NEAR: f64 = 0.1;
/// Relative error of the linear response of a solution, and that of a Newton step where contact moves.
const OF_RESPONSE: f64 = 1e-11;
const OF_STEP: f64 = 1e-4;
/// Newton steps after which contact moves half the way only.
const SWINGING: usize = 50;
/// Relative residual at which the iteration ends.
const TOLERANCE: f64 = 1e-12;
/// Relative error that a few roundings leave.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// D + A over the segments in contact.
struct Factored {
    active: Vec<usize>,
    factor: Factor,
    /// Share of a residual that a step by it leaves: the larger of the relative residual where it was made and of what a step did leave.
    contraction: f64,
}

impl Factored {
    /// Whether it is that of the segments `active`, and a step by it leaves no more than `share`.
    fn serves(&self, active: &[usize], share: f64) -> bool {
        self.active == active && self.contraction <= share
    }
}

#[derive(Debug, Clone)]
struct Iterate {
    y: DVector<f64>,
    ay: DVector<f64>,
    delta: f64,
    x: DVector<f64>,
    loads: Vec<PointLoads>,
}

struct Step {
    y: DVector<f64>,
    delta: f64,
}

impl Problem<'_> {
    /// Solves from `start`, or from an elastic foundation where there is none.
    pub fn solve(&self, start: Option<Start<'_>>) -> Result<Solution, Failure> {
        let still = |movable| Placed::undeformed(movable, self.gap);
        let mut placed = self.movable.map(still);
        let (forces, delta) = self.start(start);
        self.place(&mut placed, &forces, 1.0);
        let mut at = self.iterate(self.system(&placed), forces, delta);
        let mut residual = self.residual(self.system(&placed), &at);
        // Forces balance the prescribed one after a whole step; where they start right, rounding may leave no whole step.
        let free = matches!(self.target, Target::Approach(_));
        let mut balanced = free;
        let enough = TOLERANCE.max(self.last_step_from.powi(2));
        // A step along tangents needs the factor of those, and an exact solve is to end at rounding.
        let shares = self.last_step_from > 0.0 && self.movable.is_some();
        let mut known: Option<Factored> = None;
        for iteration in 0..MAXIMUM_ITERATIONS {
            if residual.is_nan() {
                return Err(Failure::NotConverged {
                    iterations: iteration,
                    residual,
                });
            }
            if balanced && residual <= enough {
                return self.finish(at, placed, iteration, known);
            }
            let active = at.active();
            if active.is_empty() && !free {
                // Nothing touches: close up until the foundation alone would carry the load.
                let (_, delta) = self.start(None);
                placed = self.movable.map(still);
                at = self.iterate(
                    self.system(&placed),
                    DVector::zeros(self.local.len()),
                    delta,
                );
                residual = self.residual(self.system(&placed), &at);
                balanced = free;
                continue;
            }
            let system = self.system(&placed);
            let known_serves =
                |known: &Factored| shares && known.serves(&active, enough / residual);
            let factored = match known.take().filter(known_serves) {
                Some(known) => known,
                None => self.factored(system, &at, active, residual)?,
            };
            let Factored { factor, active, .. } = &factored;
            // Places that follow the forces.
            let near = placed.as_ref().filter(|_| residual < NEAR);
            let response = (self.movable.zip(near))
                .map(|(movable, placed)| Response::new(movable, placed, &at.y, active));
            let step = self.newton_step(system, &at, active, factor, response.as_ref());
            if residual < self.last_step_from
                && let Some(last) = self.along_tangents(system, &at, &step)
            {
                return Ok(self.solution(last, factored, iteration + 1, residual * residual));
            }
            if response.is_some() {
                // The whole step, as it will be; what counts is what it leaves at the new places.
                at.y += &step.y;
                at.delta += step.delta;
                balanced = true;
            } else {
                let is_whole;
                (at, is_whole) = self.advance(system, at, &step);
                balanced |= is_whole;
            }
            if placed.is_some() {
                // Where contact moves so easily that it would swing about its place, half the way.
                let share = if iteration < SWINGING { 1.0 } else { 0.5 };
                self.place(&mut placed, &at.y, share);
                at = self.iterate(self.system(&placed), at.y, at.delta);
            }
            let before = residual;
            residual = self.residual(self.system(&placed), &at);
            known = Some(Factored {
                contraction: factored.contraction.max(residual / before),
                ..factored
            });
        }
        Err(Failure::NotConverged {
            iterations: MAXIMUM_ITERATIONS,
            residual,
        })
    }

    fn place(&self, placed: &mut Option<Placed>, forces: &DVector<f64>, share: f64) {
        if let (Some(movable), Some(last)) = (self.movable, placed.as_mut()) {
            *last = last.under(movable, self.gap, forces, share);
        }
    }

    fn system<'a>(&'a self, placed: &'a Option<Placed>) -> System<'a> {
        let moved = self.movable.zip(placed.as_ref());
        System {
            bulk: self.bulk,
            gap: placed.as_ref().map_or(self.gap, |placed| &placed.gap),
            moved: moved.map(|(movable, placed)| (movable.motion, &placed.places)),
        }
    }

    /// Largest difference between the force of a segment and what its law gives over the largest force, beyond the rounding of the
    /// closing.
    fn residual(&self, system: System<'_>, at: &Iterate) -> f64 {
        let (mut largest, mut error) = (0.0f64, 0.0f64);
        for (i, loads) in at.loads.iter().enumerate() {
            let gap = system.gap[i].iter().fold(0.0, |m: f64, g| m.max(g.abs()));
            let sizes = (self.arm[i] * at.delta).abs() + at.ay[i].abs() + gap;
            let own = (at.y[i] - loads.force()).abs() - ROUNDING * loads.slope() * sizes;
            if own.is_nan() {
                return own;
            }
            error = error.max(own);
            largest = largest.max(loads.force());
        }
        if error > 0.0 { error / largest } else { 0.0 }
    }

    /// Forces (N) and approach (m) to start from.
    fn start(&self, start: Option<Start<'_>>) -> (DVector<f64>, f64) {
        let n = self.local.len();
        let known = start.filter(|start| start.forces.len() == n);
        let springs = |delta: f64| {
            DVector::from_fn(n, |i, _| {
                let closed = self.gap[i].map(|gap| (self.arm[i] * delta - gap).max(0.0));
                self.foundation * self.local[i].length() * closed.iter().sum::<f64>()
            })
        };
        let delta = match (self.target, known) {
            (Target::Approach(approach), _) => approach,
            (Target::Force(_), Some(start)) => start.approach,
            (Target::Force(force), None) => {
                let touches = || (0..n).flat_map(|i| self.gap[i].map(|gap| gap / self.arm[i]));
                let all = touches().fold(f64::NEG_INFINITY, f64::max);
                let least = touches().fold(f64::INFINITY, f64::min);
                // Where all touch they are as stiff as they get.
                let stiffness = self.arm.dot(&(springs(all + 1.0) - springs(all)));
                let carried = |delta| self.arm.dot(&springs(delta));
                let ends = [least, all + force / stiffness];
                bisection(ends, 60, |delta| carried(delta) < force)
            }
        };
        let forces = known.map(|start| DVector::from_column_slice(start.forces));
        (forces.unwrap_or_else(|| springs(delta)), delta)
    }

    /// The forces `y` at the approach `delta`.
    fn iterate(&self, system: System<'_>, y: DVector<f64>, delta: f64) -> Iterate {
        let ay = system.displaced(&y);
        self.with_displacement(system, y, ay, delta)
    }

    fn with_displacement(
        &self,
        system: System<'_>,
        y: DVector<f64>,
        ay: DVector<f64>,
        delta: f64,
    ) -> Iterate {
        let x = self.arm * delta - &ay;
        let points = x.iter().zip(self.local).zip(system.gap);
        let loads = points.map(|((x, law), gap)| law.loads(gap.map(|gap| x - gap)));
        let loads = loads.collect();
        Iterate {
            y,
            ay,
            delta,
            x,
            loads,
        }
    }

    /// The factor of the segments `active` at `at`, where the relative residual is `residual`.
    fn factored(
        &self,
        system: System<'_>,
        at: &Iterate,
        active: Vec<usize>,
        residual: f64,
    ) -> Result<Factored, Failure> {
        let mut matrix = system.of_active(&active);
        for (number, &i) in active.iter().enumerate() {
            matrix[(number, number)] += at.loads[i].slope().recip();
        }
        let factor = matrix.cholesky().ok_or(Failure::NotPositiveDefinite)?;
        Ok(Factored {
            active,
            factor,
            contraction: residual,
        })
    }

    fn newton_step(
        &self,
        system: System<'_>,
        at: &Iterate,
        active: &[usize],
        factor: &Factor,
        response: Option<&Response>,
    ) -> Step {
        let forces = |closing: &DVector<f64>| match response {
            Some(response) => response.solve(factor, closing, OF_STEP),
            None => factor.solve(closing),
        };
        let mut y = -&at.y;
        active.iter().for_each(|&i| y[i] = 0.0);
        // Mostly nothing lets go.
        let freed = match y.amax() > 0.0 {
            true => system.displaced(&y),
            false => DVector::zeros(y.len()),
        };
        let mut change = forces(&DVector::from_fn(active.len(), |place, _| {
            let (i, loads) = (active[place], &at.loads[active[place]]);
            (loads.force() - at.y[i]) / loads.slope() - freed[i]
        }));
        let mut delta = 0.0;
        if let Target::Force(force) = self.target {
            let arm = self.arm.select_rows(active);
            let unit = forces(&arm);
            let carried = arm.dot(&change) + arm.dot(&at.y.select_rows(active));
            delta = (force - carried) / arm.dot(&unit);
            change.axpy(delta, &unit, 1.0);
        }
        for (&i, change) in active.iter().zip(&change) {
            y[i] = *change;
        }
        Step { y, delta }
    }

    /// Derivative of J along `step`, which changes displacements by `ay`.
    fn slope(&self, at: &Iterate, step: &Step, ay: &DVector<f64>) -> f64 {
        let (mut slope, mut carried) = (0.0, 0.0);
        for (i, loads) in at.loads.iter().enumerate() {
            slope += ay[i] * (at.y[i] - loads.force());
            carried += self.arm[i] * loads.force();
        }
        match self.target {
            Target::Force(force) => slope + step.delta * (carried - force),
            Target::Approach(_) => slope,
        }
    }

    /// Goes along `step` as far as J does not rise too much, and returns whether that is all of it.
    fn advance(&self, system: System<'_>, from: Iterate, step: &Step) -> (Iterate, bool) {
        let ay = system.displaced(&step.y);
        let moved = |t: f64| {
            let at = self.with_displacement(
                system,
                &from.y + &step.y * t,
                &from.ay + &ay * t,
                from.delta + t * step.delta,
            );
            let slope = self.slope(&at, step, &ay);
            (at, slope)
        };
        let initial = self.slope(&from, step, &ay);
        let (mut at, end) = moved(1.0);
        // At the level of rounding the sign of the slope means nothing.
        if initial >= 0.0 || end <= -0.9 * initial {
            return (at, true);
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let slope;
            (at, slope) = moved(middle);
            if slope.abs() <= -0.2 * initial {
                break;
            }
            if slope > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        (at, false)
    }

    /// The largest pressure under `loads` that no flank carries.
    fn overload(&self, loads: &[PointLoads]) -> Option<Failure> {
        let lines = loads.iter().zip(self.local);
        let lines = lines.filter(|(_, local)| local.length() >= self.shortest);
        let pressures = lines.filter_map(|(loads, local)| {
            let largest = loads.forces.into_iter().fold(0.0, f64::max);
            local.overload(largest / local.length())
        });
        let pressure = pressures.reduce(f64::max)?;
        Some(Failure::Overload { pressure })
    }

    /// Where `step` leads if all laws go on along their tangents, which its forces then obey; `None` where a point comes into contact
    /// or leaves it, and where contact moves.
    fn along_tangents(&self, system: System<'_>, from: &Iterate, step: &Step) -> Option<Iterate> {
        if self.movable.is_some() {
            return None;
        }
        let ay = system.displaced(&step.y);
        let mut at = from.clone();
        for (i, loads) in at.loads.iter_mut().enumerate() {
            let by = self.arm[i] * step.delta - ay[i];
            for q in 0..POINTS {
                let penetration = from.x[i] - system.gap[i][q];
                let more = loads.slopes[q] * by;
                loads.energies[q] += by * (loads.forces[q] + 0.5 * more);
                loads.forces[q] += more;
                if (penetration > 0.0) != (penetration + by > 0.0) || loads.forces[q] < 0.0 {
                    return None;
                }
            }
            at.x[i] += by;
        }
        at.y += &step.y;
        at.ay += ay;
        at.delta += step.delta;
        Some(at)
    }

    fn solution(
        &self,
        at: Iterate,
        Factored { active, factor, .. }: Factored,
        iterations: usize,
        kkt_residual: f64,
    ) -> Solution {
        Solution {
            factor,
            response: None,
            tolerance: OF_RESPONSE.max(self.last_step_from.powi(2)),
            excess: self.overload(&at.loads),
            force: at.y,
            approach: at.delta,
            closing: at.x,
            loads: at.loads,
            iterations,
            kkt_residual,
            active,
            placed: None,
        }
    }

    /// Cleans the forces up and judges them by the original conditions.
    fn finish(
        &self,
        mut at: Iterate,
        placed: Option<Placed>,
        iterations: usize,
        known: Option<Factored>,
    ) -> Result<Solution, Failure> {
        let system = self.system(&placed);
        let presses = |i: usize| at.loads[i].force() > 0.0;
        let mut force =
            DVector::from_fn(
                at.y.len(),
                |i, _| if presses(i) { at.y[i].max(0.0) } else { 0.0 },
            );
        if let Target::Force(wanted) = self.target {
            // Clipping can take off the last digits.
            force *= wanted / self.arm.dot(&force);
        }
        if force != at.y {
            at = self.iterate(system, force, at.delta);
        }
        let largest = at.y.max();
        let forces = at.y.iter().zip(&at.loads);
        let errors = forces.map(|(force, loads)| (force - loads.force()).abs() / largest);
        let mut kkt_residual = errors.fold(0.0, f64::max);
        if let Target::Force(wanted) = self.target {
            kkt_residual = kkt_residual.max((self.arm.dot(&at.y) / wanted - 1.0).abs());
        }
        let mut active = at.active();
        active.retain(|&i| at.y[i] > 0.0);
        let factored = match known {
            Some(known) if known.serves(&active, self.last_step_from) => known,
            _ => self.factored(system, &at, active, kkt_residual)?,
        };
        let response = (self.movable.zip(placed.as_ref()))
            .map(|(movable, placed)| Response::new(movable, placed, &at.y, &factored.active));
        Ok(Solution {
            response,
            placed,
            ..self.solution(at, factored, iterations, kkt_residual)
        })
    }
}

impl Iterate {
    fn active(&self) -> Vec<usize> {
        let touches = |i: &usize| self.loads[*i].slope() > 0.0;
        (0..self.loads.len()).filter(touches).collect()
    }
}
