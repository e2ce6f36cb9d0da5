//! The frictionless contact problem of many segments: forces that press only, gaps that are not negative.
//!
//! Symbols: docs/theory/contact.md. What local contact and gaps of segment i have to take up is x_i = c_i delta - (A F)_i,
//! F_i = phi_i(x_i). Eliminating the local contact like this leaves no inequality: the solution is the minimum over (y, delta)
//! of the convex function J = y' A y / 2 + sum Phi_i(x_i(y, delta)) - F_bt delta, Phi' = phi, at which y = F. Newton's method
//! on it needs a symmetric positive definite system over the segments in contact, D + A with D = 1 / phi', bordered by
//! the load. A search along each step for the zero of the (monotone) directional derivative makes it descend from any start.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

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
    /// Arm of the normal force on each segment about the axis of gear 1, over its base radius; by virtual work also what the
    /// flanks close along their normal per approach.
    pub arm: &'a DVector<f64>,
    pub target: Target,
    /// Stiffness of the elastic foundation that gives the forces to start from, N/m per m of contact line.
    pub foundation: f64,
    /// Length of a point, m, from which on its pressure is judged.
    pub shortest: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Transverse force on the line of action, N, > 0.
    Force(f64),
    /// Approach on the line of action, m.
    Approach(f64),
}

#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// Normal force on each segment, N.
    pub forces: &'a [f64],
    /// Approach on the line of action, m; that of the target takes its place.
    pub approach: f64,
}

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
    pub iterations: usize,
    /// See [`super::ContactResult::kkt_residual`].
    pub kkt_residual: f64,
    pub active: Vec<usize>,
    /// Factor of D + A over the segments in contact.
    pub factor: Factor,
    /// What it exceeds: a pressure that no flank carries, or the approach for which tip edges were followed.
    pub excess: Option<Failure>,
}

type Factor = Cholesky<f64, Dyn>;

/// Newton steps after which a solve gives up with an error. Twenty are seldom needed.
pub const MAXIMUM_ITERATIONS: usize = 200;
/// Relative residual at which the iteration ends.
const TOLERANCE: f64 = 1e-12;
/// Relative error that a few roundings leave.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

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
    ay: DVector<f64>,
    delta: f64,
}

impl Problem<'_> {
    /// Solves from `start`, or from an elastic foundation where there is none.
    pub fn solve(&self, start: Option<Start<'_>>) -> Result<Solution, Failure> {
        let mut at = self.start(start);
        let mut residual = self.residual(&at);
        // Forces balance the prescribed one after a whole step; where they start right, rounding may leave no whole step.
        let free = matches!(self.target, Target::Approach(_));
        let mut balanced = free;
        for iteration in 0..MAXIMUM_ITERATIONS {
            if residual.is_nan() {
                return Err(Failure::NotConverged {
                    iterations: iteration,
                    residual,
                });
            }
            if balanced && residual <= TOLERANCE {
                return self.finish(at, iteration);
            }
            let active = at.active();
            if active.is_empty() && !free {
                // Nothing touches: close up until the foundation alone would carry the load.
                let delta = self.start(None).delta;
                at = self.iterate(DVector::zeros(self.local.len()), delta);
                residual = self.residual(&at);
                balanced = free;
                continue;
            }
            let factor = self.factor(&at, &active)?;
            let step = self.newton_step(&at, &active, &factor);
            let is_whole;
            (at, is_whole) = self.advance(at, &step);
            residual = self.residual(&at);
            balanced |= is_whole;
        }
        Err(Failure::NotConverged {
            iterations: MAXIMUM_ITERATIONS,
            residual,
        })
    }

    /// Largest difference between the force of a segment and what its law gives over the largest force, beyond the rounding of the
    /// closing.
    fn residual(&self, at: &Iterate) -> f64 {
        let (mut largest, mut error) = (0.0f64, 0.0f64);
        for (i, loads) in at.loads.iter().enumerate() {
            let gap = self.gap[i].iter().fold(0.0, |m: f64, g| m.max(g.abs()));
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

    fn start(&self, start: Option<Start<'_>>) -> Iterate {
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
        self.iterate(forces.unwrap_or_else(|| springs(delta)), delta)
    }

    /// The forces `y` at the approach `delta`.
    fn iterate(&self, y: DVector<f64>, delta: f64) -> Iterate {
        let ay = self.bulk * &y;
        self.with_displacement(y, ay, delta)
    }

    fn with_displacement(&self, y: DVector<f64>, ay: DVector<f64>, delta: f64) -> Iterate {
        let x = self.arm * delta - &ay;
        let points = x.iter().zip(self.local).zip(self.gap);
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

    fn factor(&self, at: &Iterate, active: &[usize]) -> Result<Factor, Failure> {
        let mut matrix = self.bulk.select_rows(active).select_columns(active);
        for (number, &i) in active.iter().enumerate() {
            matrix[(number, number)] += at.loads[i].slope().recip();
        }
        matrix.cholesky().ok_or(Failure::NotPositiveDefinite)
    }

    fn newton_step(&self, at: &Iterate, active: &[usize], factor: &Factor) -> Step {
        let mut y = -&at.y;
        active.iter().for_each(|&i| y[i] = 0.0);
        let freed = self.bulk * &y;
        let mut change = DVector::from_fn(active.len(), |place, _| {
            let (i, loads) = (active[place], &at.loads[active[place]]);
            (loads.force() - at.y[i]) / loads.slope() - freed[i]
        });
        factor.solve_mut(&mut change);
        let mut delta = 0.0;
        if let Target::Force(force) = self.target {
            let arm = self.arm.select_rows(active);
            let mut unit = arm.clone();
            factor.solve_mut(&mut unit);
            let carried = arm.dot(&change) + arm.dot(&at.y.select_rows(active));
            delta = (force - carried) / arm.dot(&unit);
            change.axpy(delta, &unit, 1.0);
        }
        for (&i, change) in active.iter().zip(&change) {
            y[i] = *change;
        }
        Step {
            ay: self.bulk * &y,
            y,
            delta,
        }
    }

    fn slope(&self, at: &Iterate, step: &Step) -> f64 {
        let (mut slope, mut carried) = (0.0, 0.0);
        for (i, loads) in at.loads.iter().enumerate() {
            slope += step.ay[i] * (at.y[i] - loads.force());
            carried += self.arm[i] * loads.force();
        }
        match self.target {
            Target::Force(force) => slope + step.delta * (carried - force),
            Target::Approach(_) => slope,
        }
    }

    /// Goes along `step` as far as J does not rise too much, and returns whether that is all of it.
    fn advance(&self, from: Iterate, step: &Step) -> (Iterate, bool) {
        let moved = |t: f64| {
            let at = self.with_displacement(
                &from.y + &step.y * t,
                &from.ay + &step.ay * t,
                from.delta + t * step.delta,
            );
            let slope = self.slope(&at, step);
            (at, slope)
        };
        let initial = self.slope(&from, step);
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

    /// Cleans the forces up and judges them by the original conditions.
    fn finish(&self, mut at: Iterate, iterations: usize) -> Result<Solution, Failure> {
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
            at = self.iterate(force, at.delta);
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
        Ok(Solution {
            factor: self.factor(&at, &active)?,
            excess: self.overload(&at.loads),
            force: at.y,
            approach: at.delta,
            closing: at.x,
            loads: at.loads,
            iterations,
            kkt_residual,
            active,
        })
    }
}

impl Iterate {
    fn active(&self) -> Vec<usize> {
        let touches = |i: &usize| self.loads[*i].slope() > 0.0;
        (0..self.loads.len()).filter(touches).collect()
    }
}
