//! What the motion shows of the master and of the bodies that it moves.
//!
//! Over one communication step H the approach x and its rate v of the teeth change by
//!
//! ```text
//! v' - v = H a,    x' - x - H v = H² d
//! ```
//!
//! Both follow the force F of the mesh that acted in the step: a = g - w F and d = f - theta w F, with w the mobility of the gears (inverse
//! effective mass) and theta 1/2 where the master holds loads over the step and moves the bodies exactly, 1 where it sets velocities first
//! and moves by the new ones (`v += H a; x += H v`), 0 in the explicit Euler rule. What g and f hold, bodies, shafts, bearings and other
//! meshes, is linear and does not change: a modes' sum that earlier values of g and of F foretell. So
//!
//! ```text
//! Δg_n = Σ c_k Δg_(n-k) + Σ b_k w ΔF_(n-k),    k = 1..4 and 0..4
//! ```
//!
//! is fitted to the steps so far by least squares that forget (Ljung, System Identification, 2nd ed. 1999, section 11.2: ARX models by
//! regularised recursive least squares), for d with the same right-hand sides. It needs neither masses nor modes, and cannot drive a mode
//! that it has seen: its frequency is in the coefficients.
//!
//! In which step F acts is what separates two such models: in the one that starts from the poses it was computed from, or in the
//! one after it. Both foretell each step before it is used; the logarithm of the ratio of their errors, summed, is the evidence. A third one, of
//! the acceleration alone, has to be beaten by far: else the motion is given and does not follow the loads.
//!
//! Where several meshes share bodies, evidence alone errs: the force just computed tells of a state with more modes than the
//! models have, so the model without lag foretells better although that force does not act yet. What acts has a mobility: without
//! lag, the force just read must move the bodies, and more than the one before it does. Loads for the step after the next are
//! stable under either master, the others under theirs alone; so no lag is believed late and doubted early.

use serde::{Deserialize, Serialize};

/// Earlier values of the acceleration, and of the force beside the acting one.
const ORDER: usize = 4;
/// Unknowns of a model; the acting force's is that at `ORDER`.
const UNKNOWNS: usize = 2 * ORDER + 1;
/// Accelerations that a row takes.
const KEPT: usize = ORDER + 2;
/// Forces: those of the later lag, too.
const KEPT_FORCES: usize = KEPT + 1;

/// Weight of what the step before showed.
const MEMORY: f64 = 0.98;
/// Weight of no change at all, over the mean square of what was seen: for accelerations, and for forces, whose mobility is known roughly.
const RIDGE: f64 = 1e-4;
const RIDGE_OF_FORCES: f64 = 3e-3;
/// Theta above which the master is taken to set velocities first, and its distance from 1/2 within which bodies move exactly.
const VELOCITIES_FIRST: f64 = 0.9;
const EXACT_BODIES: f64 = 0.25;
/// Theta from which on velocities are set by the force just read: loads one step late do not look like that.
const SET_AT_ONCE: f64 = 0.75;
/// Changes of force over the nominal one that show nothing.
const NOISE: f64 = 1e-6;

/// Errors of a forecast over what it foretells that count as none, squared.
const EXACT: f64 = 1e-4;
/// Most that one step says: a ratio of errors of e^(3/2).
const LOUDEST: f64 = 3.0;
/// Evidence from which on loads act late, from which on they act at once, and from which on it is not looked at again.
const KNOWN: f64 = 4.0;
const CHANGED: f64 = 15.0;
const SETTLED: f64 = 60.0;
/// Steps after which bodies that follow the loads are taken for those of a master that lets them act late.
const PATIENCE: usize = 6;
/// Mobilities over that of the given mass, between which the loads move the bodies, and below which they no longer do: plastics are lighter
/// than steel, and rotors heavier than gears.
const MOBILITY: [f64; 2] = [0.02, 20.0];
const NO_MOBILITY: f64 = 0.01;
/// The models depart anew from the mobility found where it is below this share of the one that they depart from.
const HEAVIER: f64 = 0.3;

/// Steps that differ by less, relatively, are alike.
const ALIKE: f64 = 1e-6;

fn alike(length: f64, other: f64) -> bool {
    (length - other).abs() <= ALIKE * length
}

/// In which step the loads act that a master reads after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Lag {
    /// In the step that starts from the poses they were computed from: the FMU steps before the bodies.
    None,
    /// In the step after that one: all step at once, then exchange.
    One,
}

impl Lag {
    const fn index(self) -> usize {
        match self {
            Self::None => 0,
            Self::One => 1,
        }
    }

    /// Of bodies that go on with their velocities, in steps of `length` s.
    pub(super) fn drift(self, length: f64) -> Ahead {
        let outlook = Outlook {
            free: [0.0; 2],
            slope: 0.0,
            mobility: [0.0; 2],
        };
        let given = match self {
            Self::None => None,
            Self::One => Some([0.0; 2]),
        };
        (outlook, given, length)
    }
}

/// What [`Master::ahead`] gives.
pub(super) type Ahead = (Outlook, Option<[f64; 2]>, f64);

/// Acceleration and displacement over a step beyond those by the force that acts in it, and what that force adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outlook {
    /// a and d without it, m/s².
    pub free: [f64; 2],
    /// Rate of change of that a over the step, m/s³; after a step of another length 0, since with it steps by turns drive modes of trains.
    pub slope: f64,
    /// w and theta w, 1/kg.
    pub mobility: [f64; 2],
}

impl Outlook {
    /// a and d under the force `acting`, N.
    pub fn under(&self, acting: f64) -> [f64; 2] {
        std::array::from_fn(|k| self.free[k] - self.mobility[k] * acting)
    }

    /// The master's rule.
    pub fn theta(&self) -> f64 {
        let [w, share] = self.mobility;
        if w > 0.0 { share / w } else { 0.5 }
    }
}

/// One step as the model sees it: what is known before it, and what came.
struct Row {
    known: [f64; UNKNOWNS],
    came: [f64; 2],
}

/// Accelerations or forces, the newest first.
type Series<const N: usize> = [f64; N];

fn push<const N: usize>(series: &mut Series<N>, newest: f64) {
    series.rotate_right(1);
    series[0] = newest;
}

/// What the steps so far were.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Steps {
    /// a and d, m/s².
    change: [Series<KEPT>; 2],
    /// Forces that were returned, N, positive from the drive flank.
    force: Series<KEPT_FORCES>,
    /// Lengths, s.
    length: Series<3>,
    /// Steps of one motion, and for how many of the last ones midpoints were equally far apart: where all are alike, or go by turns.
    count: usize,
    even: usize,
}

impl Steps {
    /// Whether the midpoint of a step of `length` s is as far from that of the last step as that one is from the one before.
    fn goes_on(&self, length: f64) -> bool {
        match self.count {
            0 => false,
            1 => alike(length, self.length[0]),
            _ => alike(length, self.length[1]),
        }
    }

    /// Changes of w F where `acting(k)` acted in the step k back, and of g, from k = `from` on.
    fn known(&self, w: f64, change: &[f64], acting: &[f64], even: usize) -> [f64; UNKNOWNS] {
        let of_force = |k: usize| w * (acting[k] - acting[k + 1]);
        let mut known = [0.0; UNKNOWNS];
        // Of midpoints at odd distances nothing follows for the next one.
        for i in 0..ORDER.min(even.saturating_sub(2)) {
            known[i] = change[i + 1] - change[i + 2] + of_force(i + 1);
        }
        for k in 0..=ORDER {
            known[ORDER + k] = of_force(k);
        }
        known
    }
}

/// A model with one lag, or that of the acceleration alone.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Model {
    /// Sums of products: of what is known, and of that with what came.
    square: [[f64; UNKNOWNS]; UNKNOWNS],
    product: [[f64; UNKNOWNS]; 2],
    /// The coefficients that they give.
    coefficients: [[f64; UNKNOWNS]; 2],
    /// Theta - 1/2 of the rule to which little excitation leaves it.
    rule: f64,
}

fn dot(a: &[f64; UNKNOWNS], b: &[f64; UNKNOWNS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Model {
    /// Adds a step; returns by how much the acceleration was missed. The first `SIZE` unknowns count.
    fn add<const SIZE: usize>(&mut self, row: &Row, least: f64) -> f64 {
        let error = row.came[0] - dot(&self.coefficients[0], &row.known);
        for i in 0..SIZE {
            let weight = row.known[i];
            for (sum, x) in self.square[i].iter_mut().zip(&row.known) {
                *sum = MEMORY * *sum + weight * x;
            }
            for (products, came) in self.product.iter_mut().zip(row.came) {
                products[i] = MEMORY * products[i] + weight * came;
            }
        }
        self.solve::<SIZE>(least);
        error
    }

    /// Keeps to the rule theta = 1 once theta is near it, and to 1/2 again where it is near that or near 0.
    fn keep_rule(&mut self) {
        let [by_a, by_d] = &self.coefficients;
        let theta = (0.5 - by_d[ORDER]) / (1.0 - by_a[ORDER]);
        if theta > VELOCITIES_FIRST {
            self.rule = 0.5;
        } else if theta < 1.0 - VELOCITIES_FIRST || (theta - 0.5).abs() < EXACT_BODIES {
            self.rule = 0.0;
        }
    }

    /// By Cholesky's decomposition; `least` is a square that is added.
    fn solve<const SIZE: usize>(&mut self, least: f64) {
        let trace: f64 = (0..SIZE).map(|i| self.square[i][i]).sum();
        let mean = trace / SIZE as f64;
        let mut lower = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut inverse = [0.0; UNKNOWNS];
        for i in 0..SIZE {
            let ridge = if i < ORDER { RIDGE } else { RIDGE_OF_FORCES };
            for j in 0..=i {
                let done = lower[i].iter().zip(&lower[j]).take(j);
                let sum = self.square[i][j] - done.map(|(a, b)| a * b).sum::<f64>();
                if i == j {
                    inverse[i] = (sum + ridge * mean + least)
                        .max(f64::MIN_POSITIVE)
                        .sqrt()
                        .recip();
                } else {
                    lower[i][j] = sum * inverse[j];
                }
            }
        }
        if SIZE == UNKNOWNS {
            self.keep_rule();
        }
        for (k, (solution, product)) in self.coefficients.iter_mut().zip(&self.product).enumerate()
        {
            let mut x = *product;
            if k == 1 && SIZE == UNKNOWNS {
                x[ORDER] -= self.rule * (RIDGE_OF_FORCES * mean + least);
            }
            for i in 0..SIZE {
                let sum: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
                x[i] = (x[i] - sum) * inverse[i];
            }
            for i in (0..SIZE).rev() {
                let sum: f64 = (i + 1..SIZE).map(|k| lower[k][i] * x[k]).sum();
                x[i] = (x[i] - sum) * inverse[i];
            }
            *solution = x;
        }
    }
}

/// What is known of the master, and of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Master {
    /// Known beforehand, or found.
    pub lag: Option<Lag>,
    /// Known beforehand.
    told: bool,
    steps: Steps,
    /// By lag.
    models: [Model; 2],
    alone: Model,
    /// Mean square of the changes of acceleration.
    change: f64,
    /// Logarithms of the ratios of errors: of no lag over one, and of the acceleration alone over the better one.
    evidence: [f64; 2],
    settled: bool,
    /// Steps that it comes from.
    rows: usize,
    /// Mobility of the gears that was given, 1/kg, and the one that the models depart from.
    given: f64,
    mobility: f64,
}

impl Master {
    /// At the start, where `force` (N) was read already; `lag` where it is known. The gears alone have about the mobility `given`, 1/kg.
    pub fn new(lag: Option<Lag>, force: f64, given: f64) -> Self {
        Self {
            lag,
            told: lag.is_some(),
            steps: Steps {
                force: [force; KEPT_FORCES],
                ..Steps::default()
            },
            models: [Model::default(); 2],
            alone: Model::default(),
            change: 0.0,
            evidence: [0.0; 2],
            settled: lag.is_some(),
            rows: 0,
            given,
            mobility: given,
        }
    }

    /// Whether steps can have made it.
    pub fn is_valid(&self) -> bool {
        let squares = |model: &Model| (0..UNKNOWNS).all(|i| model.square[i][i] >= 0.0);
        let known = [self.given, self.mobility].iter().all(|w| *w > 0.0);
        known && self.change >= 0.0 && self.models.iter().chain([&self.alone]).all(squares)
    }

    /// The motion goes on from another place.
    pub fn interrupt(&mut self) {
        self.steps.count = 0;
        self.steps.even = 0;
    }

    /// Steps that are remembered.
    pub fn steps(&self) -> usize {
        self.steps.count
    }

    /// Takes in a step: `change` is a and d, m/s², `length` its length, s; `nominal` is the nominal force, N.
    pub fn observe(&mut self, change: [f64; 2], length: f64, nominal: f64) {
        let steps = &mut self.steps;
        steps.even = if steps.goes_on(length) {
            steps.even + 1
        } else {
            1
        };
        steps.count += 1;
        push(&mut steps.length, length);
        for (series, newest) in steps.change.iter_mut().zip(change) {
            push(series, newest);
        }
        // Three accelerations, between which something acted.
        if steps.count < 3 || steps.force[..3].iter().all(|force| *force == 0.0) {
            return;
        }
        let w = self.mobility;
        let noise = (NOISE * nominal * w).powi(2);
        let [a, d] = &self.steps.change;
        let (da, dd) = (a[0] - a[1], d[0] - d[1]);
        let lags = [Lag::None, Lag::One];
        let looked_at = |lag: Lag| !self.settled || self.lag == Some(lag);
        let errors = lags.map(|lag| {
            if !looked_at(lag) {
                return 0.0;
            }
            let acting = &self.steps.force[lag.index()..];
            let known = self.steps.known(w, a, acting, self.steps.even);
            let moved = known[ORDER];
            let row = Row {
                known,
                came: [da + moved, dd + 0.5 * moved],
            };
            self.models[lag.index()].add::<UNKNOWNS>(&row, noise)
        });
        if self.settled {
            let holds = |lag| self.told || self.moves(lag);
            if !self.lag.is_some_and(holds) {
                *self = Self {
                    steps: self.steps,
                    change: self.change,
                    evidence: [0.0, SETTLED],
                    // Patience is spent: late loads are believed as soon as they move the bodies, as before.
                    rows: self.rows,
                    ..Self::new(None, 0.0, self.given)
                };
            }
            return;
        }
        let known = self.steps.known(0.0, a, &[0.0; KEPT], self.steps.even);
        let row = Row {
            known,
            came: [da, 0.0],
        };
        let alone = self.alone.add::<ORDER>(&row, noise);
        self.change = MEMORY * self.change + da * da;
        let floor = EXACT * (da * da + (1.0 - MEMORY) * self.change) + noise;
        let ratio = |worse: f64, better: f64| {
            let [worse, better] = [worse, better].map(|error| error * error + floor);
            (worse / better).ln().clamp(-LOUDEST, LOUDEST)
        };
        let [none, one] = errors;
        let better = if none.abs() < one.abs() { none } else { one };
        self.evidence[0] += ratio(none, one);
        self.evidence[1] = (self.evidence[1] + ratio(alone, better)).min(SETTLED);
        self.rows += 1;
        self.judge();
        if self.lag.is_none() {
            self.depart_anew();
        }
    }

    /// Lets the models depart from the mobility that they show where the bodies are far heavier: what they learn of it is a difference of
    /// nearly equal numbers then, which the weight of no change hides.
    fn depart_anew(&mut self) {
        let [_, of_loads] = self.evidence;
        let [found, _] = self.mobility(self.likely());
        let next = found.max(NO_MOBILITY * self.given);
        if of_loads > 0.0 && found > 0.0 && next < HEAVIER * self.mobility {
            self.mobility = next;
            self.models = [Model::default(); 2];
        }
    }

    /// The lag for which there is more evidence.
    fn likely(&self) -> Lag {
        match self.evidence[0] > 0.0 {
            true => Lag::One,
            false => Lag::None,
        }
    }

    fn judge(&mut self) {
        let [of_lag, of_loads] = self.evidence;
        if of_loads < -KNOWN {
            self.lag = None;
        }
        let moves = |lag: Lag| of_loads > KNOWN && self.moves(lag);
        let [by_force, theta_by_force] = self.mobility(Lag::None);
        let at_once = of_lag < -KNOWN && by_force > 0.0 && theta_by_force > SET_AT_ONCE * by_force;
        let late = || Some(Lag::One).filter(|lag| !at_once && moves(*lag));
        let found = match self.lag {
            Some(Lag::None) if of_lag > KNOWN || !moves(Lag::None) => late(),
            None | Some(Lag::One) if of_lag < -CHANGED && moves(Lag::None) => Some(Lag::None),
            None if of_lag > KNOWN || self.rows >= PATIENCE => late(),
            Some(Lag::One) if self.mobility(Lag::One)[0] < NO_MOBILITY * self.given => None,
            known => known,
        };
        self.lag = found;
        self.settled = found == Some(self.likely()) && of_lag.abs() > SETTLED && of_loads > KNOWN;
    }

    /// Whether the forces that act with this lag move the bodies as much as forces on gears do, and without lag more than those one step late.
    fn moves(&self, lag: Lag) -> bool {
        let [by_a, _] = &self.models[lag.index()].coefficients;
        let late = match lag {
            Lag::None => -(by_a[0] + by_a[ORDER + 1]),
            Lag::One => 0.0,
        };
        let [found, _] = self.mobility(lag);
        let [least, most] = MOBILITY.map(|share| share * self.given);
        (least.max(late * self.mobility)..most).contains(&found)
    }

    /// Mean rate over the last step less the one at its end, m/s: what the master's rule holds back.
    pub fn rate_held_back(&self) -> f64 {
        let [a, d] = &self.steps.change;
        (d[0] - a[0]) * self.steps.length[0]
    }

    /// w and theta w, 1/kg.
    fn mobility(&self, lag: Lag) -> [f64; 2] {
        let w = self.mobility;
        let [by_a, by_d] = &self.models[lag.index()].coefficients;
        [w * (1.0 - by_a[ORDER]), w * (0.5 - by_d[ORDER])]
    }

    /// The steps that start now and after it, under the forces returned so far; both end with the outlook of the one in which the force
    /// acts that is returned now. In between: length of the step, and a and d over it.
    pub fn ahead(&self, lag: Lag, length: f64) -> Ahead {
        let steps = &self.steps;
        let even = if steps.goes_on(length) {
            steps.even + 1
        } else {
            1
        };
        let lengths = [length, steps.length[0]];
        match lag {
            Lag::None => {
                let [a, d] = &steps.change;
                let outlook = self.outlook(lag, [a, d], &steps.force, even, lengths);
                (outlook, None, length)
            }
            Lag::One => {
                let [mut a, mut d] = steps.change;
                let outlook = self.outlook(lag, [&a, &d], &steps.force[1..], even, lengths);
                let given = outlook.under(steps.force[0]);
                push(&mut a, given[0]);
                push(&mut d, given[1]);
                // A master that goes by turns goes on with them.
                let turns = steps.count > 1 && alike(length, steps.length[1]);
                let next = if turns { steps.length[0] } else { length };
                let even = if turns || next == length { even + 1 } else { 1 };
                let lengths = [next, length];
                let outlook = self.outlook(lag, [&a, &d], &steps.force, even, lengths);
                (outlook, Some(given), next)
            }
        }
    }

    /// Of the step after those with `change`, in which `acting` acted, newest first; `lengths` are its own and that of the newest one, s.
    fn outlook(
        &self,
        lag: Lag,
        change: [&Series<KEPT>; 2],
        acting: &[f64],
        even: usize,
        lengths: [f64; 2],
    ) -> Outlook {
        // The step to come has no force yet.
        let mut forces = [0.0; KEPT];
        forces[1..].copy_from_slice(&acting[..KEPT - 1]);
        let mut changes = [0.0; KEPT];
        changes[1..].copy_from_slice(&change[0][..KEPT - 1]);
        let w = self.mobility;
        let known = self.steps.known(w, &changes, &forces, even);
        let model = &self.models[lag.index()];
        let before = w * forces[1];
        let [a, d] = [0, 1].map(|k| change[k][0] + dot(&model.coefficients[k], &known));
        let mobility = self.mobility(lag);
        let free = [a + before, d + 0.5 * before];
        let newest = change[0][0] + mobility[0] * forces[1];
        let slope = if alike(lengths[0], lengths[1]) {
            (free[0] - newest) / lengths[0]
        } else {
            0.0
        };
        Outlook {
            free,
            slope,
            mobility,
        }
    }

    /// Takes the force that is returned, N.
    pub fn give(&mut self, force: f64) {
        push(&mut self.steps.force, force);
    }

    /// Takes the force, N, that is returned in place of the one just taken.
    pub fn give_instead(&mut self, force: f64) {
        self.steps.force[0] = force;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 5e-6;
    const NOMINAL: f64 = 1000.0;
    const MOBILITY: f64 = 2.5;
    const SPRING: f64 = 5e8;

    #[test]
    fn a_given_motion_is_not_taken_for_one_that_follows_the_loads() {
        for per_step in [0.02, 0.1, 0.3] {
            let mut master = Master::new(None, 0.0, MOBILITY);
            let omega = per_step / STEP;
            let at = |n: f64| {
                let (sin, cos) = (omega * n * STEP).sin_cos();
                (1e-6 * (1.0 - cos), 1e-6 * omega * sin)
            };
            for n in 0..400 {
                let ((x0, v0), (x1, v1)) = (at(f64::from(n)), at(f64::from(n + 1)));
                master.give(SPRING * x0);
                let d = (x1 - x0 - STEP * v0) / (STEP * STEP);
                master.observe([(v1 - v0) / STEP, d], STEP, NOMINAL);
                assert_eq!(master.lag, None, "{per_step} in step {n}");
            }
        }
    }
}
