//! How long a communication step an explicit coupling bears.

use super::experiment::{ModulatedSpring, STIFFNESS, SingleFreedom};
use crate::driver::{Coupling, Extrapolation, INERTIA, Master, Spin};
use crate::page::{Page, fixed};
use crate::plot::{Plot, Series};
use crate::setup::external_and_internal;
use crate::{Context, Result, row};
use gearmesh::element::Parameters;

/// Disturbance whose growth is watched: so small that damping never brings the force to its bound, zero,
/// which would hold an unstable motion in a limit cycle.
const DISTURBANCE: f64 = 1e-4;
/// Start of the runs that are compared with the solution, off the static elongation 1.
const AMPLITUDE: f64 = 0.2;

/// Damping ratios; the last is that of the paper's simulations.
pub const ZETAS: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 4.8];

/// How a host may couple.
pub type Way = (Master, Extrapolation);

/// Gear 2 on the mesh spring and a mesh damper of ratio `zeta`, in contact all the time.
pub fn system(zeta: f64) -> Result<SingleFreedom> {
    let [pair, _] = external_and_internal();
    let mass = INERTIA / pair.gears[1].base_radius().powi(2);
    let phi = pair.operating_pressure_angle(pair.center_distance);
    // 2 zeta sqrt(k m) on the line of action is cos^2(phi) of that tangentially.
    let damping = 2.0 * zeta * (STIFFNESS * mass).sqrt() * phi.cos().powi(2);
    let parameters = Parameters { damping, damping_onset: 1e-3, ..Parameters::default() };
    let law = ModulatedSpring { stiffness: STIFFNESS, depth: 0.0 };
    Ok(SingleFreedom::new(&pair, &parameters, law, 100.0, Spin::speed(0.0))?)
}

/// Whether a small disturbance dies out with communication step `h` omega.
pub fn stable(o: &SingleFreedom, way: Way, h: f64) -> Result<bool> {
    let start = o.start(1.0 + DISTURBANCE, 0.0, 0.0);
    let mut coupling = Coupling::new(&o.scene, way, start, h / o.omega, 1)?;
    let mut peaks = [0.0_f64; 2];
    // Long enough in steps and in time to tell growth from decay near the limit.
    let steps = 4000.max((60.0 / h) as usize);
    for n in 0..steps {
        coupling.advance()?;
        let deviation = (o.elongation(coupling.time, &coupling.state)? - 1.0).abs();
        if deviation > 20.0 * DISTURBANCE {
            return Ok(false);
        }
        let half = usize::from(n >= steps / 2);
        peaks[half] = peaks[half].max(deviation);
    }
    Ok(peaks[1] < peaks[0])
}

/// Largest stable omega H.
fn limit(o: &SingleFreedom, way: Way) -> Result<f64> {
    let [least, most] = [5e-3_f64, 8.0];
    if !stable(o, way, least)? {
        return Ok(0.0);
    }
    let [low, _] = super::last_that_holds([least.ln(), most.ln()], 14, |h| stable(o, way, h.exp()))?;
    Ok(low.exp())
}

/// Largest error of y over ten periods against the solution in closed form; in contact throughout.
fn error(o: &SingleFreedom, zeta: f64, way: Way, h: f64) -> Result<f64> {
    let start = o.start(1.0 + AMPLITUDE, 0.0, 0.0);
    let mut coupling = Coupling::new(&o.scene, way, start, h / o.omega, 4)?;
    let damped = (1.0 - zeta * zeta).sqrt();
    let mut worst = 0.0_f64;
    for _ in 0..(60.0 / h) as usize {
        coupling.advance()?;
        let tau = coupling.time * o.omega;
        let (sine, cosine) = (damped * tau).sin_cos();
        let exact = 1.0 + AMPLITUDE * (-zeta * tau).exp() * (cosine + zeta / damped * sine);
        worst = worst.max((o.elongation(coupling.time, &coupling.state)? - exact).abs());
        if worst > 1.0 {
            break;
        }
    }
    Ok(worst)
}

/// Largest stable omega H with held loads, where there is a formula.
pub fn expected_limit(master: Master, zeta: f64) -> Option<f64> {
    match master {
        Master::Sequential => Some((4.0 * zeta).min(1.0 / zeta)),
        Master::Parallel => (zeta <= 0.1).then_some(4.0 * zeta / 3.0),
    }
}

pub fn report(context: &Context, page: &mut Page) -> Result<()> {
    use Extrapolation::{Hold, Inputs, Outputs};
    let zetas = if context.quick { &ZETAS[2..3] } else { &ZETAS };
    for (part, master) in [("sequential", Master::Sequential), ("parallel", Master::Parallel)] {
        let mut rows = vec![];
        for &zeta in zetas {
            let o = system(zeta)?;
            let found = [limit(&o, (master, Hold))?, limit(&o, (master, Inputs))?, limit(&o, (master, Outputs))?];
            let [_, inputs, outputs] = found.map(|limit| format!("{limit:.3} (x {:.3})", limit / found[0]));
            let expected = expected_limit(master, zeta).map_or(String::new(), |x| fixed(x, 3));
            let us = fixed(1e6 * found[0] / o.omega, 2);
            rows.push(row![zeta, expected, fixed(found[0], 3), us, inputs, outputs]);
        }
        let head =
            ["zeta", "held loads, expected", "held loads, found", "H, us", "input derivatives", "output derivatives"];
        page.table(part, &head, &rows)?;
    }
    let zeta = 0.1;
    let o = system(zeta)?;
    let mut series = vec![];
    for master in [Master::Sequential, Master::Parallel] {
        for extrapolation in [Hold, Inputs, Outputs] {
            let mut points = vec![];
            for n in 0..if context.quick { 2 } else { 13 } {
                let h = 1e-3 * 10f64.powf(f64::from(n) * 0.2);
                points.push((h, error(&o, zeta, (master, extrapolation), h)?));
            }
            points.retain(|p| p.1 < 1.0);
            series.push(Series::line(format!("{master:?}, {extrapolation:?}"), points));
        }
    }
    let title = "Error against communication step, zeta = 0.1";
    page.plot("cosimulation", &Plot { title, x: "omega H", y: "largest error of y", logarithmic: [true; 2], series })
}
