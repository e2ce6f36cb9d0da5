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

const COUPLINGS: [(Master, Extrapolation); 6] = [
    (Master::Sequential, Extrapolation::Hold),
    (Master::Sequential, Extrapolation::Inputs),
    (Master::Sequential, Extrapolation::Outputs),
    (Master::Parallel, Extrapolation::Hold),
    (Master::Parallel, Extrapolation::Inputs),
    (Master::Parallel, Extrapolation::Outputs),
];

/// The chapter.
pub fn report(folder: &Path) -> crate::Outcome {
    let mut text = String::from(
        "One freedom, k = 4.9e8 N/m on the line of action, all damping in the mesh, in contact throughout. Largest stable omega H by bisection, \
         in brackets over that with held loads: how far input derivatives (`Inputs`, see below) and output derivatives (`Outputs`) move it.\n",
    );
    for (master, expected) in [
        (Master::Sequential, "min(4 zeta, 1/zeta)"),
        (Master::Parallel, "4 zeta / 3 at small zeta"),
    ] {
        write!(
            text,
            "\n{master:?} master:\n\n| zeta | held loads, expected: {expected} | held loads, found | input derivatives | output derivatives |\n\
             |---|---|---|---|---|\n"
        )?;
        for zeta in [0.01, 0.03, 0.1, 0.3, 1.0, 4.8] {
            let o = system(zeta)?;
            let expected = match master {
                Master::Sequential => format!("{:.3}", (4.0 * zeta).min(1.0 / zeta)),
                Master::Parallel if zeta <= 0.1 => format!("{:.3}", 4.0 * zeta / 3.0),
                Master::Parallel => String::new(),
            };
            let hold = limit(&o, master, Extrapolation::Hold)?;
            let moved = |extrapolation| -> Result<String> {
                let found = limit(&o, master, extrapolation)?;
                Ok(format!("{found:.3} (x {:.3})", found / hold))
            };
            writeln!(
                text,
                "| {zeta} | {expected} | {hold:.3} | {} | {} |",
                moved(Extrapolation::Inputs)?,
                moved(Extrapolation::Outputs)?
            )?;
        }
    }
    let zeta = 0.1;
    let o = system(zeta)?;
    let mut lines = Vec::new();
    for (master, extrapolation) in COUPLINGS {
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
    text.push_str(
        "\n![error](stability/cosimulation.svg)\n\n\
         ### Choosing the communication step\n\n\
         1. Reduced mass on the line of action m = J1 J2 / (J1 rb2^2 + J2 rb1^2) (one gear driven at a speed: J / rb^2 of the other), tangent \
         stiffness k (`mesh.stiffness`), damping c (parameter `damping` / cos^2 phi): omega = sqrt(k/m), zeta = c / (2 sqrt(k m)).\n\
         2. Let the element step first (sequential) if the host can; take the column of the table that fits the host; choose H below half \
         of its omega H, divided by omega. With zeta = 0.03 and omega = 4.2e4 rad/s a sequential master with held loads stands 2.9 us; \
         choose 1.4 us; with input derivatives accuracy, not stability, decides (plot).\n\
         3. Small zeta: pass the velocities' derivatives (`fmi2SetRealInputDerivatives`) or let the element use the velocities it knows; \
         this is `Inputs`: the element moves its inputs on to the middle of the step in which its loads act. `Outputs`: the host runs \
         the loads on linearly with `fmi2GetRealOutputDerivatives`.\n\
         4. zeta near 1 and above (the paper's c = 1e5 N s/m: 4.8): zeta omega H < 1, half of that for a parallel master, and no \
         extrapolation helps, since the damper, not the spring, limits the step. The paper's pair then needs H below 5 us, 2.5 us in \
         parallel; a smaller c is the only way to a longer step.\n\
         5. Check by halving H: a result that changes was not converged.\n\n\
         ### Choosing the damping\n\n\
         Choose zeta, then `damping` = 2 zeta sqrt(k_t m_t) with the tangential `mesh.stiffness` k_t and the reduced mass on the pitch \
         circle m_t = m / cos^2 phi (for the paper's pair: 4.35e8 N/m, 0.25 kg). Published damping ratios of steel gears in mesh run from 0.03 to 0.17; \
         the default, 1000 N s/m, is 0.05 for the paper's pair. With several freedoms k_t and m_t are those of the mode in which the teeth move \
         most. More than zeta = 0.3 costs step (table) and hides resonances; the paper's 1e5 N s/m, zeta = 4.8, is overdamped. Zero is legal: \
         the conjugate formulation then keeps the energy, and only the host's damping is left.\n",
    );
    Ok(text)
}
