//! How long a communication step an explicit coupling bears.

use super::experiment::{ModulatedSpring, STIFFNESS, SingleFreedom};
use crate::data::{Data, last_that_holds};
use crate::driver::{CoSimulation, INERTIA, Master, Scheme, Spin};
use crate::setup::external_and_internal;
use crate::{Context, Result};
use gearmesh::element::Parameters;

/// Disturbance whose growth is watched: so small that damping never brings the force to its bound, zero,
/// which would hold an unstable motion in a limit cycle.
const DISTURBANCE: f64 = 1e-6;

/// Damping ratios; the last is that of the paper's simulations.
pub const ZETAS: [f64; 7] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 4.8];

/// Gear 2 on the mesh spring and a mesh damper of ratio `zeta`, in contact all the time.
pub fn system(zeta: f64) -> Result<SingleFreedom> {
    let [pair, _] = external_and_internal();
    let mass = mass();
    let phi = pair.operating_pressure_angle(pair.center_distance);
    // 2 zeta sqrt(k m) on the line of action is cos^2(phi) of that tangentially.
    let damping = 2.0 * zeta * (STIFFNESS * mass).sqrt() * phi.cos().powi(2);
    let mut parameters = Parameters::default();
    (parameters.damping, parameters.damping_onset) = (damping, 1e-3);
    let (law, still) = (ModulatedSpring::new(0.0), Spin::speed(0.0));
    SingleFreedom::new(&pair, &parameters, law, 100.0, still)
}

/// Mass of gear 2 on the line of action, kg, the only one that moves.
pub fn mass() -> f64 {
    let [pair, _] = external_and_internal();
    INERTIA / pair.gears[1].base_radius().powi(2)
}

/// Whether a small disturbance does not grow with communication step `h` omega.
pub fn stable(o: &SingleFreedom, scheme: Scheme, h: f64) -> Result<bool> {
    let start = o.start(1.0 + DISTURBANCE, 0.0, 0.0);
    let mut coupling = CoSimulation::new(&o.scene, scheme, start, h / o.omega, 1)?;
    let mut peaks = [0.0_f64; 2];
    // Long enough in steps and in time to tell growth from decay near the limit.
    let steps = 4000.max((60.0 / h) as usize);
    for n in 0..steps {
        coupling.advance()?;
        let deviation = (o.deflection(coupling.time, &coupling.state)?.y - 1.0).abs();
        if deviation > 20.0 * DISTURBANCE {
            return Ok(false);
        }
        let half = usize::from(n >= steps / 2);
        peaks[half] = peaks[half].max(deviation);
    }
    // Without damping the exact motion keeps its amplitude.
    Ok(peaks[1] < (1.0 + 1e-6) * peaks[0])
}

/// Largest stable omega H.
pub fn limit(o: &SingleFreedom, scheme: Scheme) -> Result<f64> {
    let [least, most] = [5e-3_f64, 8.0];
    if !stable(o, scheme, least)? {
        return Ok(0.0);
    }
    let [low, _] = last_that_holds([least.ln(), most.ln()], 14, |h| stable(o, scheme, h.exp()))?;
    Ok(low.exp())
}

/// Largest stable omega H with held loads, where there is a formula.
pub fn expected_limit(master: Master, zeta: f64) -> Option<f64> {
    match master {
        Master::Sequential => Some((4.0 * zeta).min(1.0 / zeta)),
        Master::Parallel => (zeta <= 0.1).then_some(4.0 * zeta / 3.0),
    }
}

/// Pairs with shipped tables.
pub const TABLES: [&str; 4] = ["fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84"];

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let zetas = if context.quick { &ZETAS[3..4] } else { &ZETAS };
    for (part, master) in [
        ("sequential", Master::Sequential),
        ("parallel", Master::Parallel),
    ] {
        let mut rows = vec![];
        for &zeta in zetas {
            let o = system(zeta)?;
            let expected = expected_limit(master, zeta).map(|x| format!("{x:.3}"));
            let held = limit(&o, Scheme::held(master))?;
            let predicted = limit(&o, Scheme::predicted(master, mass()))?;
            rows.push(format!(
                "{zeta} | {} | {held:.3} | {predicted:.2}",
                expected.unwrap_or_default()
            ));
        }
        let head = "zeta | held, expected | held | predicted";
        data.table(part, head, &rows)?;
    }
    Ok(())
}
