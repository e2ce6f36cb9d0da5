//! How long a communication step an explicit coupling bears.

use super::experiment::{ModulatedSpring, STIFFNESS, SingleFreedom};
use crate::data::{Data, last_that_holds};
use crate::driver::{CoSimulation, Gear, INERTIA, Master, Scene, Spin, State, Way};
use crate::setup::external_and_internal;
use crate::{Context, Result, in_repository};
use gearmesh::element::{Element, Parameters};
use gearmesh::table::{Table, TableFile};
use nalgebra::{DMatrix, Matrix2, Vector2};
use std::sync::Arc;

/// Disturbance whose growth is watched: so small that damping never brings the force to its bound, zero,
/// which would hold an unstable motion in a limit cycle, nor tells the element its mass: it starts from twice the least.
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
pub fn stable(o: &SingleFreedom, way: Way, h: f64) -> Result<bool> {
    let start = o.start(1.0 + DISTURBANCE, 0.0, 0.0);
    let mut coupling = CoSimulation::new(&o.scene, way, start, h / o.omega, 1)?;
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
pub fn limit(o: &SingleFreedom, way: Way) -> Result<f64> {
    let [least, most] = [5e-3_f64, 8.0];
    if !stable(o, way, least)? {
        return Ok(0.0);
    }
    let [low, _] = last_that_holds([least.ln(), most.ln()], 14, |h| stable(o, way, h.exp()))?;
    Ok(low.exp())
}

/// Largest stable omega H with held loads, where there is a formula.
pub fn expected_limit(master: Master, zeta: f64) -> Option<f64> {
    match master {
        Master::Sequential => Some((4.0 * zeta).min(1.0 / zeta)),
        Master::Parallel => (zeta <= 0.1).then_some(4.0 * zeta / 3.0),
    }
}

/// Largest stable omega H with predicted loads at `mass` over the true one, at most `most`: where a multiplier of the linear map from
/// step to step leaves the unit circle. The motion that the element foresees is solved exactly here.
pub fn expected_prediction(master: Master, zeta: f64, mass: f64, most: f64) -> f64 {
    let spectral_radius = |h: f64| -> f64 {
        // Scaled: k = 1, m = 1, so that time is omega t. y'' = a - (y + 2 zeta y')/mass over h, from (x, v) under a:
        // (y, y') = e^(A h) (x - mass a, v) + (mass a, 0).
        let a = Matrix2::new(0.0, 1.0, -1.0 / mass, -2.0 * zeta / mass);
        let e = (a * h).exp();
        // The constant force by x, v and a: (8 F(h/2) - F(0) - F(h)) / 6.
        let half = (a * (0.5 * h)).exp();
        let constant = |x: f64, v: f64, a: f64| {
            let start = Vector2::new(x - mass * a, v);
            let force = |s: Vector2<f64>| s[0] + mass * a + 2.0 * zeta * s[1];
            (8.0 * force(half * start) - force(start) - force(e * start)) / 6.0
        };
        let step = |x: f64, v: f64, f: f64| [x + h * v - 0.5 * h * h * f, v - h * f];
        // State: x, v, v one step before, force over the last step, force over the coming one (parallel).
        let map = |s: [f64; 5]| -> [f64; 5] {
            let [x, v, before, last, coming] = s;
            let a = (v - before) / h + last / mass;
            match master {
                Master::Sequential => {
                    let f = constant(x, v, a);
                    let [x1, v1] = step(x, v, f);
                    [x1, v1, v, f, 0.0]
                }
                Master::Parallel => {
                    let given = a - coming / mass;
                    let next = constant(x + h * v + 0.5 * h * h * given, v + h * given, a);
                    let [x1, v1] = step(x, v, coming);
                    [x1, v1, v, coming, next]
                }
            }
        };
        let columns = DMatrix::from_fn(5, 5, |row, column| {
            map(std::array::from_fn(|i| f64::from(u8::from(i == column))))[row]
        });
        columns
            .complex_eigenvalues()
            .iter()
            .map(|z| z.norm())
            .fold(0.0, f64::max)
    };
    let stable = |h: f64| spectral_radius(h) < 1.0 + 1e-9;
    // From below: beyond the limit there may be stable islands.
    let count = 4000;
    let first = (1..=count)
        .map(|n| most * f64::from(n) / f64::from(count))
        .find(|h| !stable(*h));
    first.map_or(most, |h| h - 0.5 * most / f64::from(count))
}

/// Pairs with shipped tables.
pub const TABLES: [&str; 4] = ["fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84"];
/// Angle omega H that packing chooses.
const PACKED_ANGLE: f64 = 0.4;

/// Energy that the coupling brings to the undamped shipped pair `name`, over that of the swing it starts with, after `steps` steps
/// at the packed angle: gear 1 stands, gear 2 swings about its load by a fifth of the deflection.
pub fn energy_brought(name: &str, way: impl Fn(f64) -> Way, steps: usize) -> Result<f64> {
    let file = TableFile::read(in_repository(&format!("resources/tables/{name}.json")))?;
    let (geometry, torque) = (file.geometry.clone(), file.nominal_torque_nm);
    let table = Arc::new(Table::from_file(file)?);
    let parameters = Parameters {
        damping: 0.0,
        nominal_torque: torque,
        center_distance_effect: table.effects.center_distance,
        misalignment_effect: table.effects.misalignment,
        ..Parameters::default()
    };
    let element = Element::new(&geometry, &parameters, Some(table))?;
    let [first, second] = geometry.gears.each_ref().map(|gear| gear.base_radius());
    // Pressed against the drive flank.
    let load = torque * second / first * geometry.e();
    let (still, loaded) = (Spin::speed(0.0), Spin::torque(load));
    let gears = [
        Gear::new(&geometry, 0, still),
        Gear::new(&geometry, 1, loaded),
    ];
    let scene = Scene::new(element, gears)?;
    let pressed =
        |approach: f64| scene.with_spin(&scene.rest(), 1, geometry.e() * approach / second, 0.0);
    let carries =
        |approach| Ok(scene.contact(0.0, &pressed(approach))?.moment[1].z.abs() >= load.abs());
    let [_, balance] = last_that_holds([1e-3, 0.0], 60, carries)?;
    let cosine = scene.element.line_of_action(geometry.center_distance);
    let stiffness = scene.contact(0.0, &pressed(balance))?.stiffness / cosine.powi(2);
    let mass = INERTIA / second.powi(2);
    let (start, still) = (pressed(1.2 * balance), pressed(balance));
    // The load has a potential, too.
    let energy = |t: f64, state: &State| -> Result<f64> {
        Ok(scene.energy(t, state)? - load * state[1].twist())
    };
    let h = PACKED_ANGLE * (mass / stiffness).sqrt();
    let (least, first) = (energy(0.0, &still)?, energy(0.0, &start)?);
    let swing = first - least;
    let mut run = CoSimulation::new(&scene, way(mass), start, h, 4)?;
    for _ in 0..steps {
        run.advance()?;
        if energy(run.time, &run.state)? > least + 100.0 * swing {
            return Ok(f64::INFINITY);
        }
    }
    Ok((energy(run.time, &run.state)? - first) / swing)
}

/// Masses that the element starts from, over the true one: twice the least that it is told.
pub const MASSES: [f64; 5] = [0.5, 0.8, 1.0, 2.0, 4.0];

/// Where the element goes over to held loads: omega H = 1.7 with the least mass that it is told, half of that it starts from.
pub fn longest(factor: f64) -> f64 {
    1.7 * (0.5 * factor).sqrt().min(1.0)
}

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
            let held = limit(&o, Way::held(master))?;
            let unknown = limit(&o, Way::predicted(master, 0.0))?;
            let mut row = format!(
                "{zeta} | {} | {held:.3} | {unknown:.3}",
                expected.unwrap_or_default()
            );
            for factor in MASSES {
                let found = limit(&o, Way::predicted(master, 0.5 * factor * mass()))?;
                let expected = expected_prediction(master, zeta, factor, longest(factor));
                row += &format!(" | {found:.2} ({expected:.2})");
            }
            rows.push(row);
        }
        let head = "zeta | held, expected | held | no mass | mass x 0.5 | x 0.8 | x 1 | x 2 | x 4";
        data.table(part, head, &rows)?;
    }
    Ok(())
}
