//! An idle gear that rattles: a ball bouncing on a vibrating table, drag torque in place of gravity.

use crate::pair;
use gearmesh::driver::{Method, ModulatedSpring, SingleFreedom, Spin, State, gear_state};
use gearmesh::element::{LoadedFlank, Parameters};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

const STIFFNESS: f64 = 4.9e8;
const INERTIA: f64 = 4.213e-4;
/// Contact frequency over drive frequency: contacts are short against the flight.
const STIFF: f64 = 400.0;

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

/// A step that resolves the contact and strides through the flight.
fn step(o: &SingleFreedom, t: f64, y: &State) -> Result<(f64, f64)> {
    let out = o.scene.contact(t, y)?;
    let fine = 0.02 / o.omega;
    let gap = -out.transmission_error;
    let closing = out.transmission_error_rate.abs().max(1e-9);
    let h = if gap > 0.0 {
        (0.3 * gap / closing).clamp(fine, TAU / o.omega * STIFF / 200.0)
    } else {
        fine
    };
    Ok((h, out.transmission_error))
}

/// Spin rate of gear 2, rad/s.
fn rate(y: &State) -> f64 {
    gear_state(y, 1).l.z / INERTIA
}

/// Restitution against a gear 1 at rest, from an impact at `speed` rad/s of gear 2.
fn restitution(damping: f64, speed: f64) -> Result<f64> {
    let o = system(damping, 1e-9, 0.0, 1.0)?;
    let start = o.start(0.0, 0.0, 0.0);
    // Gap of 1 um, closing: gear 2 turns in its + sense onto the drive flank.
    let mut y = o.scene.with_spin(&start, 1, -1e-6 / o.base_radius, speed);
    let mut t = 0.0;
    loop {
        let (h, _) = step(&o, t, &y)?;
        y = Method::RungeKutta4.step(&o.scene, t, &y, h)?;
        t += h;
        if rate(&y) < 0.0 && o.scene.contact(t, &y)?.flank == 0 {
            return Ok(-rate(&y) / speed);
        }
    }
}

/// Damping at which the restitution is `target`.
fn damping_for(target: f64, speed: f64) -> Result<f64> {
    // The upper end is a damping ratio of about 0.7, which still rebounds.
    let (mut low, mut high) = (1.0, 1.5e4);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if restitution(middle, speed)? > target {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(0.5 * (low + high))
}

/// Impact phases (fraction of the drive's period) of the last impacts at `gamma`, started on the period-1 orbit.
fn impacts(damping: f64, restitution: f64, gamma: f64) -> Result<Vec<f64>> {
    let drag = 5.0;
    let omega = {
        let rb = pair::external().gears[1].base_radius();
        (STIFFNESS * rb * rb / INERTIA).sqrt()
    };
    let w = omega / STIFF;
    let amplitude = gamma * drag / INERTIA / w / w;
    let o = system(damping, drag, amplitude, w)?;
    // Period-1 orbit: leaves with u, the table's velocity v: u - v = e (u + v), u = g T / 2.
    let g = drag / INERTIA;
    let period = TAU / w;
    let u = 0.5 * g * period;
    let v = u * (1.0 - restitution) / (1.0 + restitution);
    // Gear 1's velocity along the direction in which gear 2 is thrown is A w cos(phase).
    let cosine = (v / (amplitude * w)).min(1.0);
    // The stable branch has the table past its middle: decelerating, sin(phase) > 0.
    let phase = cosine.acos();
    let theta1 = amplitude * phase.sin();
    let start = o.scene.rest();
    let mut y = o.scene.with_spin(&start, 0, theta1, 0.0);
    // External, equal teeth: touching means theta_2 = -theta_1; thrown means -theta_2' > 0.
    y = o.scene.with_spin(&y, 1, -theta1 - 1e-12, -u);
    let mut t = phase / w;
    let end = t + 100.0 * period;
    let mut phases = Vec::new();
    let mut touching = true;
    let mut last_free = t;
    while t < end {
        // Resting on each other for a part of the cycle is no bouncing; and it would take fine steps for long.
        if t - last_free > 0.05 * period {
            return Ok(Vec::new());
        }
        let (h, te) = step(&o, t, &y)?;
        if te > 0.0 && !touching {
            phases.push((t * w / TAU).rem_euclid(1.0));
        }
        touching = te > 0.0;
        if !touching {
            last_free = t;
        }
        y = Method::RungeKutta4.step(&o.scene, t, &y, h)?;
        t += h;
    }
    Ok(phases)
}

/// One impact per period, all at the same phase, at the end of the run.
fn period_one(phases: &[f64]) -> bool {
    let last = &phases[phases.len().saturating_sub(20)..];
    let spread =
        last.iter().fold(f64::MIN, |a, &b| a.max(b)) - last.iter().fold(f64::MAX, |a, &b| a.min(b));
    (95..105).contains(&phases.len()) && spread < 2e-3
}

/// The chapter.
pub fn report(_: &Path) -> crate::Outcome {
    let mut text = String::from(
        "Gear 1 moves as A sin(w t), gear 2 is idle under a drag torque; Gamma = A w^2 J / T. The damping is set so that the restitution \
         measured on the element is the one asked for. Period-1 motion (one impact per period, same phase), scanned in steps of 0.01 \
         outwards from the middle of the range, each run started on the exact orbit.\n\n\
         | restitution, wanted / measured | period-1 expected | found |\n|---|---|---|\n",
    );
    for (wanted, expected) in [(0.5, [1.047, 1.527]), (0.8, [0.349, 1.071])] {
        // A typical impact speed of these orbits, rad/s.
        let speed = 1.0;
        let damping = damping_for(wanted, speed)?;
        let measured = restitution(damping, speed)?;
        let middle = 0.5 * (expected[0] + expected[1]);
        let mut found = [f64::NAN; 2];
        for (bound, direction) in found.iter_mut().zip([-1.0, 1.0]) {
            let mut gamma = middle;
            while period_one(&impacts(damping, measured, gamma)?) && gamma > 0.05 {
                *bound = gamma;
                gamma += direction * 0.01;
            }
        }
        writeln!(
            text,
            "| {wanted} / {measured:.4} | {:.3}-{:.3} | {:.3}-{:.3} |",
            expected[0], expected[1], found[0], found[1]
        )?;
    }
    Ok(text)
}
