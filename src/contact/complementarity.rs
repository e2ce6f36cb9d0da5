//! The frictionless contact problem of many strips: forces that press only, gaps that are not negative.
//!
//! Strips i with normal forces F_i >= 0 and a load sum c_i F_i = F_bt at the approach delta, c_i the arm of
//! the normal force about the axis of gear 1 over its base radius (cos beta_b inside the flanks):
//!
//! x_i = c_i delta - (A F)_i is what local contact and gaps have to take up, F_i = phi_i(x_i),
//!
//! A the bulk influence matrix, phi_i(x) = sum_q l_q(x - g_iq) over the points q of the strip, g the gaps along
//! the normal and l_q the inverse of the local law, zero for arguments <= 0. Eliminating the local contact
//! like this leaves no inequality: the solution is the minimum over (y, delta) of the convex function with a
//! continuous gradient
//!
//! J = y' A y / 2 + sum Phi_i(x_i(y, delta)) - F_bt delta, Phi' = phi,
//!
//! at which y = F. Newton's method on it needs a symmetric positive definite system over the strips in
//! contact, D + A with D = 1 / phi', bordered by the load. A search along each step for the zero of the
//! (monotone) directional derivative makes it descend from any start.

use super::candidates::POINTS;
use super::cholesky::{self, Cholesky, dot};
use super::local::{LocalContact, PointLoads};
use crate::table::widest;

/// One frictionless contact problem.
pub struct Problem<'a> {
    /// Bulk influence matrix, m/N, row by row, symmetric.
    pub bulk: &'a [f64],
    /// Local law of one point of each strip.
    pub local: &'a [LocalContact],
    /// Gaps along the normal at the points of each strip, m, misalignment included.
    pub gap: &'a [[f64; POINTS]],
    /// Arm of the normal force on each strip about the axis of gear 1, over its base radius; by virtual work
    /// also what the flanks close along their normal per approach.
    pub arm: &'a [f64],
}

/// What is prescribed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Transverse force on the line of action, N, > 0.
    Force(f64),
    /// Approach on the line of action, m.
    Approach(f64),
}

/// Forces and approach, and the factor at the last iterate.
#[derive(Debug, Clone, Default)]
pub struct Solution {
    /// Normal force on each strip, N.
    pub force: Vec<f64>,
    /// Approach on the line of action, m.
    pub approach: f64,
    /// What local contact and gap have to take up together on each strip, m.
    pub closing: Vec<f64>,
    /// Local contact at the points of each strip.
    pub loads: Vec<PointLoads>,
    /// Newton steps.
    pub iterations: usize,
    /// Largest violation of equilibrium or of the contact conditions: force on a strip less what its gaps
    /// and local contact ask for under the displacement of all forces, over the largest force.
    pub kkt_residual: f64,
    /// Indices of the strips in contact.
    pub active: Vec<usize>,
    /// Factor of D + A over the strips in contact, at the solution.
    pub factor: Cholesky,
    /// D over the strips in contact where it was factored.
    compliance: Vec<f64>,
}

/// Why there is no solution; [`super::ContactError`] adds where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// Index of the failing pivot among the strips in contact.
    NotPositiveDefinite { pivot: usize },
    /// Newton's iteration stopped short of its tolerance at this relative residual, or where a force was not a number.
    NotConverged { iterations: usize, residual: f64 },
}

/// Newton steps after which a solve gives up with an error. Twenty are seldom needed.
pub const MAXIMUM_ITERATIONS: usize = 200;
/// Relative residual at which the iteration ends.
const TOLERANCE: f64 = 1e-12;
/// A step that lessens the residual as much as the last one did, with the same factor, would leave at most this many times the
/// tolerance: then it costs less than a new factor.
const KEEPS_FACTOR: f64 = 30.0;

/// Relative error that a few roundings leave.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// State of the iteration.
struct Iterate {
    y: Vec<f64>,
    /// A y.
    ay: Vec<f64>,
    delta: f64,
    x: Vec<f64>,
    /// Local contact at x: at the points, and the force with its derivative.
    loads: Vec<PointLoads>,
    phi: Vec<(f64, f64)>,
}

impl Iterate {
    fn largest(&self) -> f64 {
        self.phi.iter().map(|p| p.0).fold(0.0, f64::max)
    }
}

/// Where a step began.
#[derive(Default)]
struct Origin {
    y: Vec<f64>,
    ay: Vec<f64>,
    delta: f64,
}

impl Origin {
    fn keep(&mut self, at: &Iterate) {
        self.y.clone_from(&at.y);
        self.ay.clone_from(&at.ay);
        self.delta = at.delta;
    }
}

/// What the steps of one solve use again and again.
#[derive(Default)]
struct Work {
    /// Step of the forces, and A times it.
    dy: Vec<f64>,
    q: Vec<f64>,
    /// Where the step began.
    from: Origin,
    /// The strips in contact where the factor was made.
    factored: Vec<usize>,
}

impl Problem<'_> {
    fn len(&self) -> usize {
        self.arm.len()
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.bulk[i * self.len()..(i + 1) * self.len()]
    }

    /// Solves from `start` (forces, approach), or from an elastic foundation of the stiffness
    /// `foundation` (N/m per m of contact line) where there is none.
    ///
    /// # Errors
    /// [`Failure::NotPositiveDefinite`], [`Failure::NotConverged`].
    pub fn solve(
        &self,
        target: Target,
        start: Option<(&[f64], f64)>,
        foundation: f64,
    ) -> Result<Solution, Failure> {
        let mut at = self.start(target, start, foundation);
        let mut solution = Solution::default();
        let n = self.len();
        let mut work = Work {
            dy: vec![0.0; n],
            q: vec![0.0; n],
            ..Work::default()
        };
        let mut residual = self.residual(&at) / at.largest();
        let mut keeps = false;
        // The forces balance the one that is asked for after a whole step, and from there on whatever part of one is gone: where
        // they start as they should be, rounding may leave no whole step that lessens anything.
        let free = matches!(target, Target::Approach(_));
        let mut balanced = free;
        for iteration in 0..MAXIMUM_ITERATIONS {
            if at.phi.iter().any(|phi| phi.0.is_nan()) {
                return Err(Failure::NotConverged {
                    iterations: iteration,
                    residual: f64::NAN,
                });
            }
            solution.active.clear();
            solution
                .active
                .extend((0..self.len()).filter(|&i| at.phi[i].1 > 0.0));
            if solution.active.is_empty() {
                if let Target::Force(force) = target {
                    // Nothing touches: close up until the foundation alone would carry the load.
                    at = self.start(Target::Force(force), None, foundation);
                    at.y.fill(0.0);
                    at.ay.fill(0.0);
                    self.refresh(&mut at);
                    balanced = free;
                    continue;
                }
                if at.y.iter().all(|y| *y == 0.0) {
                    solution.force = at.y;
                    solution.closing = at.x;
                    solution.loads = at.loads;
                    solution.approach = at.delta;
                    solution.iterations = iteration;
                    return Ok(solution);
                }
            }
            if !(keeps && solution.active == work.factored) {
                self.factor(&at, &mut solution)?;
                work.factored.clone_from(&solution.active);
            }
            let d_delta = self.newton_step(target, &at, &solution, &mut work.dy);
            cholesky::multiply(self.bulk, &work.dy, &mut work.q);
            let t = self.go(target, &mut at, &mut work, d_delta);
            let before = std::mem::replace(&mut residual, self.residual(&at) / at.largest());
            keeps = t == 1.0 && residual * residual <= KEEPS_FACTOR * TOLERANCE * before;
            balanced |= t == 1.0;
            if balanced && residual <= TOLERANCE {
                solution.iterations = iteration + 1;
                return self.finish(target, at, solution);
            }
        }
        Err(Failure::NotConverged {
            iterations: MAXIMUM_ITERATIONS,
            residual,
        })
    }

    /// Largest difference between the force of a strip and what its law gives, N, beyond what rounding of the closing makes of it:
    /// flanks that just touch close by less than their gaps are known to.
    fn residual(&self, at: &Iterate) -> f64 {
        let mut largest = 0.0;
        for (i, (force, slope)) in at.phi.iter().enumerate() {
            let error = (at.y[i] - force).abs();
            if error.is_nan() {
                return error;
            }
            if error > largest {
                let gap = self.gap[i].iter().fold(0.0, |m: f64, g| m.max(g.abs()));
                let sizes = (self.arm[i] * at.delta).abs() + at.ay[i].abs() + gap;
                largest = f64::max(largest, error - ROUNDING * slope * sizes);
            }
        }
        largest
    }

    fn start(&self, target: Target, start: Option<(&[f64], f64)>, foundation: f64) -> Iterate {
        let n = self.len();
        let mut at = Iterate {
            y: vec![0.0; n],
            ay: vec![0.0; n],
            delta: 0.0,
            x: vec![0.0; n],
            loads: vec![PointLoads::default(); n],
            phi: vec![(0.0, 0.0); n],
        };
        match start {
            Some((force, delta)) if force.len() == self.len() => {
                at.y.copy_from_slice(force);
                at.delta = match target {
                    Target::Force(_) => delta,
                    Target::Approach(approach) => approach,
                };
            }
            _ => {
                at.delta = match target {
                    Target::Approach(approach) => approach,
                    Target::Force(force) => self.foundation_approach(force, foundation),
                };
                for i in 0..self.len() {
                    let closing = self.arm[i] * at.delta;
                    let closed: f64 = self.gap[i].iter().map(|g| (closing - g).max(0.0)).sum();
                    at.y[i] = foundation * self.local[i].length() * closed;
                }
            }
        }
        cholesky::multiply(self.bulk, &at.y, &mut at.ay);
        self.refresh(&mut at);
        at
    }

    /// Approach at which independent springs of the stiffness `foundation` per length carry `force`.
    fn foundation_approach(&self, force: f64, foundation: f64) -> f64 {
        // Approach at which each point touches, and the stiffness it adds.
        let mut order: Vec<(f64, f64)> = (0..self.len())
            .flat_map(|i| {
                let c = self.arm[i];
                let stiffness = c * c * foundation * self.local[i].length();
                self.gap[i].map(|g| (g / c, stiffness))
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut stiffness, mut moment) = (0.0, 0.0);
        for (rank, (gap, k)) in order.iter().enumerate() {
            stiffness += k;
            moment += k * gap;
            let delta = (force + moment) / stiffness;
            if order.get(rank + 1).is_none_or(|next| delta <= next.0) {
                return delta;
            }
        }
        0.0
    }

    /// Local contact on strip `i` where it and gaps take up `x`.
    #[inline(always)]
    fn law(&self, i: usize, x: f64) -> PointLoads {
        self.local[i].loads(self.gap[i].map(|gap| x - gap))
    }

    fn refresh(&self, at: &mut Iterate) {
        widest(
            #[inline(always)]
            || {
                for i in 0..self.len() {
                    at.x[i] = self.arm[i] * at.delta - at.ay[i];
                    at.loads[i] = self.law(i, at.x[i]);
                    at.phi[i] = at.loads[i].sum();
                }
            },
        );
    }

    /// Newton step of the forces into `dy`, with the factor that there is; returns that of the approach. Whatever the D of
    /// the factor, it descends.
    fn newton_step(
        &self,
        target: Target,
        at: &Iterate,
        solution: &Solution,
        dy: &mut [f64],
    ) -> f64 {
        let active = &solution.active;
        // Strips out of contact give up what they still carry.
        let released: Vec<usize> = (0..self.len())
            .filter(|&i| at.phi[i].1 <= 0.0 && at.y[i] != 0.0)
            .collect();
        dy.fill(0.0);
        for &i in &released {
            dy[i] = -at.y[i];
        }
        let mut right: Vec<f64> = active
            .iter()
            .zip(&solution.compliance)
            .map(|(&i, compliance)| {
                let freed: f64 = released.iter().map(|&j| self.row(i)[j] * at.y[j]).sum();
                (at.phi[i].0 - at.y[i]) * compliance + freed
            })
            .collect();
        solution.factor.solve(&mut right);
        let mut d_delta = 0.0;
        if let Target::Force(force) = target {
            let arm: Vec<f64> = active.iter().map(|&i| self.arm[i]).collect();
            let mut unit = arm.clone();
            solution.factor.solve(&mut unit);
            let carried: f64 = active
                .iter()
                .zip(&right)
                .map(|(&i, r)| self.arm[i] * (at.y[i] + r))
                .sum();
            d_delta = (force - carried) / dot(&arm, &unit);
            for (r, u) in right.iter_mut().zip(&unit) {
                *r += u * d_delta;
            }
        }
        for (&i, r) in active.iter().zip(&right) {
            dy[i] = *r;
        }
        d_delta
    }

    fn factor(&self, at: &Iterate, solution: &mut Solution) -> Result<(), Failure> {
        let active = &solution.active;
        solution.compliance.clear();
        (solution.compliance).extend(active.iter().map(|&i| at.phi[i].1.recip()));
        let n = self.len();
        // Strips in contact that follow each other: their places among those, and the first one.
        let mut runs: Vec<(std::ops::Range<usize>, usize)> = Vec::with_capacity(8);
        for (place, &i) in active.iter().enumerate() {
            match runs.last_mut() {
                Some((places, first)) if *first + places.len() == i => places.end += 1,
                _ => runs.push((place..place + 1, i)),
            }
        }
        solution
            .factor
            .factor_rows(active.len(), |r, row| {
                let bulk = &self.bulk[active[r] * n..][..n];
                for (places, first) in &runs {
                    let begin = places.start.max(r);
                    if begin < places.end {
                        let there = &bulk[first + begin - places.start..];
                        let columns = &mut row[begin - r..places.end - r];
                        columns.copy_from_slice(&there[..columns.len()]);
                    }
                }
                row[0] += solution.compliance[r];
            })
            .map_err(|pivot| Failure::NotPositiveDefinite { pivot })
    }

    /// Moves `at` to `from` plus the fraction `t` of the step; returns dJ/dt there.
    fn move_to(
        &self,
        target: Target,
        (from, at): (&Origin, &mut Iterate),
        (dy, q, d_delta): (&[f64], &[f64], f64),
        t: f64,
    ) -> f64 {
        for i in 0..self.len() {
            at.y[i] = from.y[i] + t * dy[i];
            at.ay[i] = from.ay[i] + t * q[i];
        }
        at.delta = from.delta + t * d_delta;
        self.refresh(at);
        self.slope(target, at, q, d_delta)
    }

    /// dJ/dt at `at`.
    fn slope(&self, target: Target, at: &Iterate, q: &[f64], d_delta: f64) -> f64 {
        let (mut slope, mut carried) = (0.0, 0.0);
        for (i, (force, _)) in at.phi.iter().enumerate() {
            slope += q[i] * (at.y[i] - force);
            carried += self.arm[i] * force;
        }
        match target {
            Target::Force(force) => slope + d_delta * (carried - force),
            Target::Approach(_) => slope,
        }
    }

    /// Goes along the step and returns which fraction of it: all of it unless J rises too much at its end, where the
    /// zero of dJ/dt is sought.
    fn go(&self, target: Target, at: &mut Iterate, work: &mut Work, d_delta: f64) -> f64 {
        let Work { dy, q, from, .. } = work;
        let initial = self.slope(target, at, q, d_delta);
        from.keep(at);
        let step = (dy.as_slice(), q.as_slice(), d_delta);
        let end = self.move_to(target, (from, at), step, 1.0);
        // At the level of rounding the sign of the slope means nothing.
        if initial >= 0.0 || end <= -0.9 * initial {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        let mut middle = 0.5;
        for _ in 0..40 {
            middle = 0.5 * (low + high);
            let slope = self.move_to(target, (from, at), step, middle);
            if slope.abs() <= -0.2 * initial {
                break;
            }
            if slope > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        middle
    }

    /// Largest pressure of the strip on which `solution` has one that no flank carries, Pa.
    pub fn overload(&self, solution: &Solution) -> Option<f64> {
        let strips = solution.loads.iter().zip(self.local);
        let largest = strips.filter_map(|(loads, local)| {
            local.overload(loads.forces.iter().copied().fold(0.0, f64::max))
        });
        largest.reduce(f64::max)
    }

    /// Cleans the forces up and judges them by the original conditions.
    fn finish(
        &self,
        target: Target,
        mut at: Iterate,
        mut solution: Solution,
    ) -> Result<Solution, Failure> {
        let mut force: Vec<f64> =
            at.y.iter()
                .zip(&at.phi)
                .map(|(y, phi)| if phi.0 > 0.0 { y.max(0.0) } else { 0.0 })
                .collect();
        if let Target::Force(wanted) = target {
            // Clipping can take off the last digits.
            let scale = wanted / dot(self.arm, &force);
            force.iter_mut().for_each(|f| *f *= scale);
        }
        if force != at.y {
            at.y.clone_from(&force);
            cholesky::multiply(self.bulk, &at.y, &mut at.ay);
            self.refresh(&mut at);
        }
        let largest = force.iter().copied().fold(0.0, f64::max);
        for (force, phi) in force.iter().zip(&at.phi) {
            let error = (force - phi.0).abs() / largest;
            solution.kkt_residual = solution.kkt_residual.max(error);
        }
        if let Target::Force(wanted) = target {
            let carried = dot(self.arm, &force);
            solution.kkt_residual = solution.kkt_residual.max((carried / wanted - 1.0).abs());
        }
        solution.active.clear();
        solution
            .active
            .extend((0..self.len()).filter(|&i| force[i] > 0.0 && at.phi[i].1 > 0.0));
        self.factor(&at, &mut solution)?;
        solution.force = force;
        solution.closing = at.x;
        solution.loads = at.loads;
        solution.approach = at.delta;
        Ok(solution)
    }
}
