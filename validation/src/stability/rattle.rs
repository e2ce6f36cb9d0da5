//! An idle gear that rattles: a ball bouncing on a vibrating table, drag torque in place of gravity.

use super::experiment::{ModulatedSpring, STIFFNESS, SingleFreedom};
use crate::data::{Data, last_that_holds};
use crate::driver::{INERTIA, Spin, State};
use crate::setup::external_and_internal;
use crate::{Context, Result};
use gearmesh::element::Parameters;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Contact frequency over drive frequency: how short contacts are against flights.
const STIFF: f64 = 400.0;
/// Drag torque, N m: so small that a flight (about 5 drag/inertia/w^2 high) stays far below half a base
/// pitch, beyond which the element would see the next tooth.
const DRAG: f64 = 5e-3;
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

/// Drive frequency, rad/s.
fn frequency() -> f64 {
    let [pair, _] = external_and_internal();
    (STIFFNESS / INERTIA).sqrt() * pair.gears[1].base_radius() / STIFF
}

/// Idle gear with the drag torque `drag` while gear 1 moves as A sin(w t).
fn system(damping: f64, drag: f64, amplitude: f64, w: f64) -> Result<SingleFreedom> {
    let [pair, _] = external_and_internal();
    // Damping in full from almost the first touch, so that restitution does not depend on speed.
    let mut parameters = Parameters::default();
    (parameters.damping, parameters.damping_onset) = (damping, 1e-6);
    let law = ModulatedSpring::new(0.0);
    let speed = Spin::Speed(Arc::new(move |t| amplitude * w * (w * t).cos()));
    SingleFreedom::new(&pair, &parameters, law, drag, speed)
}

/// A step that resolves the contact, strides through the flight and lands on the flank.
///
/// Damping sets in within picometres of the touch; a step that starts there, not before it, integrates
/// every impact alike. The second number is the transmission error at `y`.
fn step(o: &SingleFreedom, t: f64, y: &State) -> Result<(f64, f64)> {
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
        let stride = TAU / o.omega * STIFF / 200.0;
        (0.3 * gap / closing.abs().max(1e-9)).clamp(fine, stride)
    };
    Ok((h, out.transmission_error))
}

/// Restitution against a gear 1 at rest, from an impact at `speed` rad/s of gear 2.
fn restitution(damping: f64, speed: f64) -> Result<f64> {
    let o = system(damping, 1e-9, 0.0, 1.0)?;
    let rate = |y: &State| y[1].l.z / INERTIA;
    // Gap of 1 um, closing: gear 2 turns in its + sense onto the drive flank.
    let (touching, gap) = (o.start(0.0, 0.0, 0.0), -1e-6 / o.base_radius);
    let mut y = o.scene.with_spin(&touching, 1, gap, speed);
    let mut t = 0.0;
    loop {
        let (h, _) = step(&o, t, &y)?;
        y = o.scene.step(t, &y, h)?;
        t += h;
        if rate(&y) < 0.0 && o.scene.contact(t, &y)?.flank == 0 {
            return Ok(-rate(&y) / speed);
        }
    }
}

/// Damping at which the restitution is `target`.
fn damping_for(target: f64, speed: f64) -> Result<f64> {
    // The upper end is a damping ratio of about 0.7, which still rebounds.
    let above = |damping| Ok(restitution(damping, speed)? > target);
    let [low, high] = last_that_holds([1.0, 1.5e4], 24, above)?;
    Ok(0.5 * (low + high))
}

/// Whether the motion at `gamma`, started on the period-1 orbit of the bouncing ball but for `OFFSET`, has one impact in
/// every period and a disturbance of the interval between impacts that dies out within `PERIODS`.
fn period_one(damping: f64, restitution: f64, gamma: f64) -> Result<bool> {
    let w = frequency();
    let g = DRAG / INERTIA;
    let amplitude = gamma * g / w / w;
    let o = system(damping, DRAG, amplitude, w)?;
    // Period-1 orbit: leaves with u, the table's velocity v: u - v = e (u + v), u = g T / 2.
    let period = TAU / w;
    let u = 0.5 * g * period;
    let v = u * (1.0 - restitution) / (1.0 + restitution);
    // Gear 1's velocity along the direction in which gear 2 is thrown is A w cos(phase); the stable
    // branch has the table past its middle: decelerating, sin(phase) > 0.
    let phase = (v / (amplitude * w)).min(1.0).acos() + TAU * OFFSET;
    let theta1 = amplitude * phase.sin();
    let y = o.scene.with_spin(&o.scene.rest(), 0, theta1, 0.0);
    // External, equal teeth: touching means theta_2 = -theta_1; thrown means -theta_2' > 0.
    let mut y = o.scene.with_spin(&y, 1, -theta1 - 1e-12, -u);
    let mut t = phase / w;
    let end = t + PERIODS * period;
    let mut impacts = vec![];
    let (mut touching, mut last_free) = (false, t);
    while t < end {
        let (h, te) = step(&o, t, &y)?;
        if te > 0.0 && !touching {
            impacts.push(t / period);
        }
        touching = te > 0.0;
        if !touching {
            last_free = t;
        } else if t - last_free > 0.05 * period {
            // It rests on the flank for a part of the cycle.
            return Ok(false);
        }
        y = o.scene.step(t, &y, h)?;
        t += h;
    }
    let off = impacts.windows(2).map(|w| (w[1] - w[0] - 1.0).abs());
    let off: Vec<f64> = off.collect();
    let spread = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let each = off.len().abs_diff(PERIODS as usize) <= 2 && spread(&off) < 0.5;
    Ok(each && spread(&off[off.len() - WINDOW..]) < 0.5 * spread(&off[..WINDOW]))
}

/// Last Gamma with period-1 motion on the way from `inside` to `outside`.
fn edge(damping: f64, restitution: f64, inside: f64, outside: f64) -> Result<f64> {
    let holds = |gamma: f64| period_one(damping, restitution, gamma);
    if !holds(inside)? || holds(outside)? {
        return Err(format!("the edge is not between Gamma = {inside} and {outside}").into());
    }
    let bisections = ((inside - outside).abs() / 2e-4).log2().ceil() as usize;
    Ok(last_that_holds([inside, outside], bisections, holds)?[0])
}

/// Gamma between which impacts without duration leave period-1 motion stable, and the upper edge where the
/// disturbance is halved within `HALVING` periods.
fn expected_edges(restitution: f64) -> [f64; 3] {
    let lower = PI * (1.0 - restitution) / (1.0 + restitution);
    // Multipliers of the bouncing ball: product r^2, sum 1 + r^2 - (1 + r)^2 sqrt(Gamma^2 - lower^2).
    let square = restitution * restitution;
    let with_multiplier = |m: f64| {
        let sum = m + square / m;
        lower.hypot((1.0 + square - sum) / (1.0 + restitution).powi(2))
    };
    let halving = with_multiplier(-0.5_f64.powf(1.0 / HALVING));
    [lower, with_multiplier(-1.0), halving]
}

/// Relative speed of impacts in period-1 motion, rad/s: u + v = 2 u / (1 + r).
fn impact_speed(restitution: f64) -> f64 {
    2.0 / (1.0 + restitution) * PI * DRAG / INERTIA / frequency()
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let mut rows = vec![];
    for chosen in [0.5_f64, 0.8]
        .into_iter()
        .take(if context.quick { 1 } else { 2 })
    {
        let speed = impact_speed(chosen);
        let damping = damping_for(chosen, speed)?;
        let measured = restitution(damping, speed)?;
        let slow = restitution(damping, speed / 3.0)?;
        let fast = restitution(damping, 3.0 * speed)?;
        let [lower, upper, halving] = expected_edges(measured);
        let middle = 0.5 * (lower + upper);
        let from = edge(damping, measured, middle, 0.8 * lower)?;
        let to = edge(damping, measured, middle, 1.15 * upper)?;
        let restitutions = format!("{chosen} | {measured:.4} | {slow:.4}, {fast:.4}");
        let edges = format!("{lower:.3} | {from:.4} | {upper:.3} | {halving:.4} | {to:.4}");
        rows.push(format!("{restitutions} | {edges}"));
    }
    let head = "restitution | restitution measured | restitution at a third and at three times the speed \
        | lower edge expected | lower edge found | upper edge expected \
        | upper edge with this criterion | upper edge found";
    data.table("rattle", head, &rows)
}
