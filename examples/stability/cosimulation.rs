//! How long a communication step an explicit coupling bears.

use crate::driver::{Coupling, Extrapolation, Master, Spin};
use crate::experiment::{ModulatedSpring, SingleFreedom};
use crate::pair;
use crate::plot::{Line, Plot};
use gearmesh::element::{LoadedFlank, Parameters};
use std::fmt::Write as _;
use std::path::Path;

const STIFFNESS: f64 = 4.9e8;
const INERTIA: f64 = 4.213e-4;
/// Disturbance whose growth is watched: so small that damping never brings the force to its bound, zero,
/// which would hold an unstable motion in a limit cycle.
const DISTURBANCE: f64 = 1e-4;
/// Start of the runs that are compared with the solution, off the static elongation 1.
const AMPLITUDE: f64 = 0.2;

const ZETAS: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, PAPER_ZETA];
/// Damping ratio of the paper's simulations; stiffness and mass of its pair on the pitch circle, N/m and kg.
const PAPER_ZETA: f64 = 4.8;
const PAPER_STIFFNESS: f64 = 4.35e8;
const PAPER_MASS: f64 = 0.25;

const EXTRAPOLATIONS: [Extrapolation; 3] = [
    Extrapolation::Hold,
    Extrapolation::Inputs,
    Extrapolation::Outputs,
];

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Gear 2 on the mesh spring and a mesh damper of ratio `zeta`, in contact all the time.
fn system(zeta: f64) -> Result<SingleFreedom> {
    let pair = pair::external();
    let rb = pair.gears[1].base_radius();
    let phi = pair.operating_pressure_angle(pair.center_distance);
    let mass = INERTIA / rb / rb;
    let parameters = Parameters {
        loaded_flank: LoadedFlank::Drive,
        // 2 zeta sqrt(k m) on the line of action is cos^2(phi) of that tangentially.
        damping: 2.0 * zeta * (STIFFNESS * mass).sqrt() * phi.cos().powi(2),
        damping_onset: 1e-3,
        ..Parameters::default()
    };
    let law = ModulatedSpring {
        stiffness: STIFFNESS,
        depth: 0.0,
    };
    Ok(SingleFreedom::new(
        &pair,
        &parameters,
        law,
        INERTIA,
        100.0,
        0.0,
        Spin::speed(0.0),
        0.0,
    )?)
}

/// Whether a small disturbance dies out with communication step `h` omega.
fn stable(o: &SingleFreedom, master: Master, extrapolation: Extrapolation, h: f64) -> Result<bool> {
    let start = o.start(1.0 + DISTURBANCE, 0.0, 0.0);
    let mut coupling = Coupling::new(&o.scene, master, extrapolation, start, h / o.omega, 1)?;
    let mut peaks = [0.0_f64; 2];
    // Long enough in steps and in time to tell growth from decay near the limit.
    let steps = 4000.max((60.0 / h) as usize);
    for n in 0..steps {
        coupling.advance()?;
        let deviation = (o.elongation(coupling.time(), coupling.state())? - 1.0).abs();
        if deviation > 20.0 * DISTURBANCE {
            return Ok(false);
        }
        let half = usize::from(n >= steps / 2);
        peaks[half] = peaks[half].max(deviation);
    }
    Ok(peaks[1] < peaks[0])
}

/// Largest stable omega H, by bisection.
fn limit(o: &SingleFreedom, master: Master, extrapolation: Extrapolation) -> Result<f64> {
    let (mut low, mut high) = (5e-3_f64, 8.0_f64);
    if !stable(o, master, extrapolation, low)? {
        return Ok(0.0);
    }
    for _ in 0..14 {
        let middle = (low * high).sqrt();
        if stable(o, master, extrapolation, middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(low)
}

/// Largest error of y over ten periods against the solution in closed form; in contact throughout.
fn error(
    o: &SingleFreedom,
    zeta: f64,
    master: Master,
    extrapolation: Extrapolation,
    h: f64,
) -> Result<f64> {
    let start = o.start(1.0 + AMPLITUDE, 0.0, 0.0);
    let mut coupling = Coupling::new(&o.scene, master, extrapolation, start, h / o.omega, 4)?;
    let damped = (1.0 - zeta * zeta).sqrt();
    let mut worst = 0.0_f64;
    for _ in 0..(60.0 / h) as usize {
        coupling.advance()?;
        let tau = coupling.time() * o.omega;
        let (sine, cosine) = (damped * tau).sin_cos();
        let exact = 1.0 + AMPLITUDE * (-zeta * tau).exp() * (cosine + zeta / damped * sine);
        let y = o.elongation(coupling.time(), coupling.state())?;
        worst = worst.max((y - exact).abs());
        if worst > 1.0 {
            break;
        }
    }
    Ok(worst)
}

/// The chapter.
pub fn report(folder: &Path) -> crate::Outcome {
    let mut text = String::from(
        "One freedom, k = 4.9e8 N/m on the line of action, all damping in the mesh, in contact throughout. Largest stable omega H by bisection, \
         in brackets over that with held loads: how far input derivatives (`Inputs`, see below) and output derivatives (`Outputs`) move it.\n",
    );
    let mut limits = Vec::new();
    for (master, expected) in [
        (Master::Sequential, "min(4 zeta, 1/zeta)"),
        (Master::Parallel, "4 zeta / 3 at small zeta"),
    ] {
        write!(
            text,
            "\n{master:?} master:\n\n| zeta | held loads, expected: {expected} | held loads, found | input derivatives | output derivatives |\n\
             |---|---|---|---|---|\n"
        )?;
        for zeta in ZETAS {
            let o = system(zeta)?;
            let expected = expected_limit(master, zeta).map(|x| format!("{x:.3}"));
            let [hold, inputs, outputs] = EXTRAPOLATIONS.map(|x| limit(&o, master, x));
            let found = [hold?, inputs?, outputs?];
            limits.push((master, zeta, found));
            let moved = found.map(|x| format!("{x:.3} (x {:.3})", x / found[0]));
            writeln!(
                text,
                "| {zeta} | {} | {:.3} | {} | {} |",
                expected.unwrap_or_default(),
                found[0],
                moved[1],
                moved[2]
            )?;
        }
    }
    let zeta = 0.1;
    let o = system(zeta)?;
    let mut lines = Vec::new();
    let couplings = [Master::Sequential, Master::Parallel]
        .into_iter()
        .flat_map(|m| EXTRAPOLATIONS.map(|x| (m, x)));
    for (master, extrapolation) in couplings {
        let mut points = Vec::new();
        for n in 0..13 {
            let h = 1e-3 * 10f64.powf(f64::from(n) * 0.2);
            let worst = error(&o, zeta, master, extrapolation, h)?;
            if worst < 1.0 {
                points.push((h, worst));
            }
        }
        lines.push(Line {
            name: format!("{master:?}, {extrapolation:?}"),
            points,
        });
    }
    Plot {
        title: "Error against communication step, zeta = 0.1",
        x: "omega H",
        y: "largest error of y",
        logarithmic: true,
        lines,
    }
    .save(&folder.join("cosimulation.svg"))?;
    text.push_str("\n![error](stability/cosimulation.svg)\n\n");
    text.push_str(&advice(&limits, o.omega)?);
    Ok(text)
}

/// What the limits come to, with `omega` of the pair that they were found on.
fn advice(limits: &[(Master, f64, [f64; 3])], omega: f64) -> Result<String> {
    let of = |master: Master, zeta: f64| {
        let row = limits.iter().find(|l| l.0 == master && l.1 == zeta);
        row.map(|l| l.2).ok_or("no limit at this damping ratio")
    };
    let light = of(Master::Sequential, 0.03)?;
    let heavy = [Master::Sequential, Master::Parallel].map(|m| of(m, PAPER_ZETA));
    let [sequential, parallel] = [heavy[0]?, heavy[1]?];
    let us = |limit: f64| 1e6 * limit / omega;
    let gain = [sequential, parallel]
        .iter()
        .map(|[hold, inputs, outputs]| inputs.max(*outputs) / hold)
        .fold(0.0, f64::max);
    let helps = if gain < 1.05 {
        "no extrapolation helps"
    } else {
        "extrapolation helps"
    };
    let default = Parameters::default().damping;
    let zeta = |c: f64| c / (2.0 * (PAPER_STIFFNESS * PAPER_MASS).sqrt());
    Ok(format!(
        "### Choosing the communication step\n\n\
         1. Reduced mass on the line of action m = J1 J2 / (J1 rb2^2 + J2 rb1^2) (one gear driven at a speed: J / rb^2 of the other), tangent \
         stiffness k (`mesh.stiffness`), damping c (parameter `damping` / cos^2 phi): omega = sqrt(k/m), zeta = c / (2 sqrt(k m)).\n\
         2. Let the element step first (sequential) if the host can; take the column of the table that fits the host; choose H below half \
         of its omega H, divided by omega. With zeta = 0.03 and omega = {omega:.1e} rad/s a sequential master with held loads stands \
         {:.1} us: choose {:.1} us. With input derivatives it stands {:.0} times that, and accuracy decides (plot).\n\
         3. Small zeta: pass the velocities' derivatives (`fmi2SetRealInputDerivatives`) or let the element use the velocities it knows; \
         this is `Inputs`: the element moves its inputs on to the middle of the step in which its loads act. `Outputs`: the host runs \
         the loads on linearly with `fmi2GetRealOutputDerivatives`.\n\
         4. zeta near 1 and above: the damper, not the spring, limits the step (zeta omega H = {:.2} sequential, {:.2} parallel at \
         zeta = {PAPER_ZETA}), and {helps} there (at most x {gain:.2}). The paper's pair with its c = 1e5 N s/m, zeta = {:.1}, needs H below \
         {:.1} us, {:.1} us in parallel; a smaller c is the way to a longer step.\n\
         5. Check by halving H: a result that changes was not converged.\n\n\
         ### Choosing the damping\n\n\
         Choose zeta, then `damping` = 2 zeta sqrt(k_t m_t) with the tangential `mesh.stiffness` k_t and the reduced mass on the pitch \
         circle m_t = m / cos^2 phi (for the paper's pair: {PAPER_STIFFNESS:.2e} N/m, {PAPER_MASS} kg). Published damping ratios of steel gears in mesh run from \
         0.03 to 0.17; packing takes 0.05 with both gears as solid steel discs; an element without a pack takes {default} N s/m, {:.2} for the paper's pair. With several \
         freedoms k_t and m_t are those of the mode in which the teeth move \
         most. More than zeta = 0.3 costs step (table) and hides resonances. Zero is legal: \
         the conjugate formulation then keeps the energy, and only the host's damping is left.\n",
        us(light[0]),
        0.5 * us(light[0]),
        light[1] / light[0],
        PAPER_ZETA * sequential[0],
        PAPER_ZETA * parallel[0],
        zeta(1e5),
        us(sequential[0]),
        us(parallel[0]),
        zeta(default),
    ))
}

/// Largest stable omega H with held loads, where there is a formula.
fn expected_limit(master: Master, zeta: f64) -> Option<f64> {
    match master {
        Master::Sequential => Some((4.0 * zeta).min(1.0 / zeta)),
        Master::Parallel => (zeta <= 0.1).then_some(4.0 * zeta / 3.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_loads_are_stable_up_to_the_step_of_the_formulas_and_not_beyond() {
        for master in [Master::Sequential, Master::Parallel] {
            for zeta in ZETAS {
                let Some(expected) = expected_limit(master, zeta) else {
                    continue;
                };
                let o = system(zeta).unwrap();
                let at = |h| stable(&o, master, Extrapolation::Hold, h).unwrap();
                assert!(at(0.97 * expected), "{master:?}, zeta = {zeta}");
                assert!(!at(1.03 * expected), "{master:?}, zeta = {zeta}");
            }
        }
    }

    #[test]
    fn input_derivatives_bear_ten_times_the_step_at_usual_damping() {
        let o = system(0.03).unwrap();
        let hold = expected_limit(Master::Sequential, 0.03).unwrap();
        assert!(stable(&o, Master::Sequential, Extrapolation::Inputs, 10.0 * hold).unwrap());
        assert!(stable(&o, Master::Sequential, Extrapolation::Outputs, 6.0 * hold).unwrap());
    }
}
