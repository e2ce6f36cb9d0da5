//! An idle gear that rattles: a ball bouncing on a vibrating table, drag torque in place of gravity.

use crate::driver::{Method, Spin, State, gear_state};
use crate::experiment::{ModulatedSpring, SingleFreedom};
use crate::pair;
use gearmesh::element::{LoadedFlank, Parameters};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

const STIFFNESS: f64 = 4.9e8;
const INERTIA: f64 = 4.213e-4;
/// How short contacts are against flights.
#[derive(Clone, Copy)]
struct Setting {
    /// Contact frequency over drive frequency.
    stiff: f64,
    /// Drag torque, N m: so small that a flight (about 5 drag/inertia/w^2 high) stays far below half a base
    /// pitch, beyond which the element would see the next tooth.
    drag: f64,
}

const SHORT: Setting = Setting {
    stiff: 400.0,
    drag: 5e-3,
};
impl Setting {
    /// Drive frequency, rad/s.
    fn frequency(self) -> f64 {
        let rb = pair::external().gears[1].base_radius();
        (STIFFNESS * rb * rb / INERTIA).sqrt() / self.stiff
    }
}
/// Step in contact, in 1/omega.
const FINE: f64 = 0.03;
/// Penetration at which a landing step aims, m: past the onset of damping, far below that of an impact.
const LANDING: f64 = 1e-10;
/// Length of a run, and how far off its orbit it starts, in periods of the drive.
const PERIODS: f64 = 120.0;
const OFFSET: f64 = 0.005;
/// Intervals in the windows at either end of a run that are compared, and periods from one window to the other.
const WINDOW: usize = 20;
const HALVING: f64 = PERIODS - WINDOW as f64;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Idle gear with the drag torque `drag` while gear 1 moves as A sin(w t).
fn system(damping: f64, drag: f64, amplitude: f64, w: f64) -> Result<SingleFreedom> {
    let pair = pair::external();
    let parameters = Parameters {
        loaded_flank: LoadedFlank::Drive,
        damping,
        // Damping in full from almost the first touch, so that restitution does not depend on speed.
        damping_onset: 1e-6,
        ..Parameters::default()
    };
    let law = ModulatedSpring {
        stiffness: STIFFNESS,
        depth: 0.0,
    };
    let speed = Spin::Speed(Arc::new(move |t| amplitude * w * (w * t).cos()));
    Ok(SingleFreedom::new(
        &pair,
        &parameters,
        law,
        INERTIA,
        drag,
        0.0,
        speed,
        0.0,
    )?)
}

/// A step that resolves the contact, strides through the flight and lands on the flank.
///
/// Damping sets in within picometres of the touch; a step that starts there, not before it, integrates
/// every impact alike. The second number is the transmission error at `y`.
fn step(o: &SingleFreedom, stiff: f64, t: f64, y: &State) -> Result<(f64, f64)> {
    let out = o.scene.contact(t, y)?;
    let fine = FINE / o.omega;
    let gap = -out.transmission_error;
    if gap <= 0.0 {
        return Ok((fine, out.transmission_error));
    }
    let closing = out.transmission_error_rate;
    let to_touch = (gap + LANDING) / closing;
    let h = if closing > 0.0 && to_touch < 2.0 * fine {
        to_touch
    } else {
        let stride = TAU / o.omega * stiff / 200.0;
        (0.3 * gap / closing.abs().max(1e-9)).clamp(fine, stride)
    };
    Ok((h, out.transmission_error))
}

/// Spin rate of gear 2, rad/s.
fn rate(y: &State) -> f64 {
    gear_state(y, 1).l.z / INERTIA
}

/// Restitution against a gear 1 at rest, from an impact at `speed` rad/s of gear 2.
fn restitution(setting: Setting, damping: f64, speed: f64) -> Result<f64> {
    let o = system(damping, 1e-9, 0.0, 1.0)?;
    let start = o.start(0.0, 0.0, 0.0);
    // Gap of 1 um, closing: gear 2 turns in its + sense onto the drive flank.
    let mut y = o.scene.with_spin(&start, 1, -1e-6 / o.base_radius, speed);
    let mut t = 0.0;
    loop {
        let (h, _) = step(&o, setting.stiff, t, &y)?;
        y = Method::RungeKutta4.step(&o.scene, t, &y, h)?;
        t += h;
        if rate(&y) < 0.0 && o.scene.contact(t, &y)?.flank == 0 {
            return Ok(-rate(&y) / speed);
        }
    }
}

/// Damping at which the restitution is `target`.
fn damping_for(setting: Setting, target: f64, speed: f64) -> Result<f64> {
    // The upper end is a damping ratio of about 0.7, which still rebounds.
    let (mut low, mut high) = (1.0, 1.5e4);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if restitution(setting, middle, speed)? > target {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(0.5 * (low + high))
}

/// Course of the impacts at `gamma`.
struct Bounces {
    /// Time of each impact, in periods of the drive.
    times: Vec<f64>,
    /// The gear came to rest on the flank for a part of the cycle.
    rested: bool,
}

/// Bounces at `gamma` over `PERIODS`, started on the period-1 orbit of the bouncing ball, off by `OFFSET`.
fn bounces(setting: Setting, damping: f64, restitution: f64, gamma: f64) -> Result<Bounces> {
    let w = setting.frequency();
    let amplitude = gamma * setting.drag / INERTIA / w / w;
    let o = system(damping, setting.drag, amplitude, w)?;
    // Period-1 orbit: leaves with u, the table's velocity v: u - v = e (u + v), u = g T / 2.
    let g = setting.drag / INERTIA;
    let period = TAU / w;
    let u = 0.5 * g * period;
    let v = u * (1.0 - restitution) / (1.0 + restitution);
    // Gear 1's velocity along the direction in which gear 2 is thrown is A w cos(phase); the stable
    // branch has the table past its middle: decelerating, sin(phase) > 0.
    let cosine = (v / (amplitude * w)).min(1.0);
    let phase = cosine.acos() + TAU * OFFSET;
    let theta1 = amplitude * phase.sin();
    let y = o.scene.with_spin(&o.scene.rest(), 0, theta1, 0.0);
    // External, equal teeth: touching means theta_2 = -theta_1; thrown means -theta_2' > 0.
    let mut y = o.scene.with_spin(&y, 1, -theta1 - 1e-12, -u);
    let mut t = phase / w;
    let end = t + PERIODS * period;
    let mut out = Bounces {
        times: Vec::new(),
        rested: false,
    };
    let mut touching = false;
    let mut last_free = t;
    while t < end {
        let (h, te) = step(&o, setting.stiff, t, &y)?;
        if te > 0.0 && !touching {
            out.times.push(t / period);
        }
        touching = te > 0.0;
        if !touching {
            last_free = t;
        } else if t - last_free > 0.05 * period {
            out.rested = true;
            return Ok(out);
        }
        y = Method::RungeKutta4.step(&o.scene, t, &y, h)?;
        t += h;
    }
    Ok(out)
}

/// One impact in every period, and a disturbance of the interval between impacts that dies out.
fn period_one(bounces: &Bounces) -> bool {
    let intervals: Vec<f64> = bounces.times.windows(2).map(|w| w[1] - w[0]).collect();
    let n = intervals.len();
    let spread = |range: &[f64]| range.iter().map(|i| (i - 1.0).abs()).fold(0.0, f64::max);
    !bounces.rested
        && (PERIODS as usize - 2..=PERIODS as usize + 2).contains(&n)
        && spread(&intervals) < 0.5
        && spread(&intervals[n - WINDOW..]) < 0.5 * spread(&intervals[..WINDOW])
}

/// Last Gamma with period-1 motion on the way from `inside` to `outside`, by bisection.
fn edge(
    setting: Setting,
    damping: f64,
    restitution: f64,
    mut inside: f64,
    mut outside: f64,
) -> Result<f64> {
    let period_one = |gamma: f64| {
        Ok::<_, Box<dyn std::error::Error>>(period_one(&bounces(
            setting,
            damping,
            restitution,
            gamma,
        )?))
    };
    for bound in [inside, outside] {
        let found = period_one(bound)?;
        if found != (bound == inside) {
            return Err(format!("Gamma = {bound}: period-1 motion {found}").into());
        }
    }
    while (inside - outside).abs() > 2e-4 {
        let middle = 0.5 * (inside + outside);
        if period_one(middle)? {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    Ok(inside)
}

/// Gamma between which impacts without duration leave period-1 motion stable, and the upper edge where the
/// disturbance is halved within [`HALVING`] periods.
fn expected_edges(restitution: f64) -> [f64; 3] {
    let lower = std::f64::consts::PI * (1.0 - restitution) / (1.0 + restitution);
    // Multipliers of the bouncing ball: product r^2, sum 1 + r^2 - (1 + r)^2 sqrt(Gamma^2 - lower^2).
    let square = restitution * restitution;
    let with_multiplier = |m: f64| {
        let sum = m + square / m;
        lower.hypot((1.0 + square - sum) / (1.0 + restitution).powi(2))
    };
    [
        lower,
        with_multiplier(-1.0),
        with_multiplier(-0.5_f64.powf(1.0 / HALVING)),
    ]
}

/// Relative speed of impacts in period-1 motion, rad/s: u + v = 2 u / (1 + r).
fn impact_speed(restitution: f64) -> f64 {
    let flight = SHORT.drag / INERTIA / SHORT.frequency();
    2.0 / (1.0 + restitution) * std::f64::consts::PI * flight
}

/// The chapter.
pub fn report(_: &Path) -> crate::Outcome {
    let mut text = format!(
        "Gear 1 moves as A sin(w t), gear 2 is idle under a drag torque T; Gamma = A w^2 J / T, omega / w = {}. The damping is set so \
         that the restitution measured on the element, by letting gear 2 fall on gear 1 at rest, is the one asked for. Period-1 motion (one \
         impact in every period) is started {OFFSET} of a period off its orbit and counts as stable if the disturbance has halved after \
         {PERIODS} periods; edges by bisection to 0.0002. Expected for impacts without duration: \
         pi (1 - r)/(1 + r) to the root of its square plus 4 (1 + r^2)^2/(1 + r)^4. Restitution is that at the impact speed of \
         the orbit; at a third and at three times that speed it must be the same for the comparison to hold.\n\n\
         At the upper edge a disturbance only just dies out, so that asking for half of it within the {HALVING} periods between the two \
         windows that are compared stops short of the edge: the multiplier must be above -0.5^(1/{HALVING}), which the last column but one has for impacts without duration.\n\n\
         | restitution wanted | measured | at a third and at three times the speed | stable from, expected | found | stable up to, expected | with this criterion | found |\n\
         |---|---|---|---|---|---|---|---|\n",
        SHORT.stiff
    );
    for wanted in [0.5_f64, 0.8] {
        let speed = impact_speed(wanted);
        let damping = damping_for(SHORT, wanted, speed)?;
        let measured = restitution(SHORT, damping, speed)?;
        let [slow, fast] = [speed / 3.0, 3.0 * speed].map(|s| restitution(SHORT, damping, s));
        let [lower, upper, halving] = expected_edges(measured);
        let middle = 0.5 * (lower + upper);
        let from = edge(SHORT, damping, measured, middle, 0.8 * lower)?;
        let to = edge(SHORT, damping, measured, middle, 1.15 * upper)?;
        writeln!(
            text,
            "| {wanted} | {measured:.4} | {:.4}, {:.4} | {lower:.3} | {from:.4} | {upper:.3} | {halving:.4} | {to:.4} |",
            slow?, fast?
        )?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn period_one_rattle_is_stable_between_the_edges_of_the_bouncing_ball() {
        for wanted in [0.5, 0.8] {
            let speed = impact_speed(wanted);
            let damping = damping_for(SHORT, wanted, speed).unwrap();
            let measured = restitution(SHORT, damping, speed).unwrap();
            assert!((measured - wanted).abs() < 1e-4, "{measured}");
            let [lower, _, upper] = expected_edges(measured);
            for (gamma, stable) in [
                (0.99 * lower, false),
                (1.01 * lower, true),
                (0.995 * upper, true),
                (1.01 * upper, false),
            ] {
                let found = period_one(&bounces(SHORT, damping, measured, gamma).unwrap());
                assert_eq!(found, stable, "r = {wanted}, Gamma = {gamma}");
            }
        }
    }
}
