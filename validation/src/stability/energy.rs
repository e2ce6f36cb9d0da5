//! Work on closed loops and drift of energy in a long run, conjugate beside the paper's formulation.

use super::Real;
use crate::data::Data;
use crate::driver::{Bearing, Gear, MASS, Scene, Spin, State, TRANSVERSE_INERTIA};
use crate::setup::external_and_internal;
use crate::spring::Spring;
use crate::{Context, Result};
use gearmesh::element::{
    Element, Formulation, Inputs, Interpolation, LoadedFlank, Parameters, StiffnessModel,
};
use gearmesh::gear::PairGeometry;
use gearmesh::table::FlankTable;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

const TORQUE: f64 = 60.0;

/// A pair with its law.
pub enum Case {
    /// The sampled four-dimensional potential of `Spring`.
    Sampled(PairGeometry),
    /// The paper's modified pair with its table.
    Real(Real),
}

impl Case {
    /// The sampled potential on the paper's pair.
    pub fn sampled() -> Self {
        let [external, _] = external_and_internal();
        Case::Sampled(external)
    }

    fn geometry(&self) -> &PairGeometry {
        match self {
            Case::Sampled(geometry) => geometry,
            Case::Real(real) => &real.geometry,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Case::Sampled(_) => "sampled potential",
            Case::Real(real) => real.name,
        }
    }

    /// The element with the choices of `parameters`: undamped, both flanks.
    fn element(&self, mut parameters: Parameters) -> Result<Element> {
        parameters.stiffness_model = StiffnessModel::Table;
        parameters.loaded_flank = LoadedFlank::Both;
        parameters.backlash = Some(120e-6);
        parameters.damping = 0.0;
        Ok(match self {
            Case::Sampled(geometry) => {
                let grid = Spring::grid([10, 7, 9, 16]);
                let drive = Arc::new(FlankTable::new(&grid, parameters.interpolation)?);
                Element::with_laws(geometry, &parameters, drive, None)?
            }
            Case::Real(real) => {
                Element::new(&real.geometry, &parameters, Some(real.table.clone()))?
            }
        })
    }
}

/// All effects on, the load variable.
pub fn choice(formulation: Formulation, interpolation: Interpolation) -> Parameters {
    Parameters {
        formulation,
        interpolation,
        ..Parameters::default()
    }
}

/// Work on a closed loop and the mean energy on it, J.
struct Loop {
    work: f64,
    energy: f64,
}

/// An ellipse in the freedoms `i`, `j` (0-11) with these half axes.
fn ellipse(element: &Element, start: &Inputs, [i, j]: [usize; 2], size: [f64; 2]) -> Result<Loop> {
    let phase = element.phase_offset(&element.nominal_inputs())?;
    let points = 4000;
    let (mut work, mut energy) = (0.0, 0.0);
    for n in 0..points {
        let (sine, cosine) = (TAU * n as f64 / points as f64).sin_cos();
        let (mut x, mut rate) = ([0.0; 12], [0.0; 12]);
        x[i] += size[0] * cosine;
        rate[i] -= size[0] * sine;
        x[j] += size[1] * sine;
        rate[j] += size[1] * cosine;
        let mut inputs = *start;
        for (body, m) in inputs.gears.iter_mut().enumerate() {
            let part =
                |v: &[f64; 12], k: usize| Vector3::from_column_slice(&v[6 * body + k..][..3]);
            let (turn, turn_rate) = (part(&x, 3), part(&rate, 3));
            m.p += part(&x, 0);
            m.r = Rotation3::new(turn).matrix() * m.r;
            m.v = part(&rate, 0);
            let bracket = turn.cross(&turn_rate);
            m.w = turn_rate + bracket / 2.0 + turn.cross(&bracket) / 6.0;
        }
        let out = element.evaluate(&phase, &inputs)?;
        for (body, m) in inputs.gears.iter().enumerate() {
            work += out.force[body].dot(&m.v) + out.moment[body].dot(&m.w);
        }
        energy += out.energy;
    }
    let mean = 1.0 / f64::from(points);
    Ok(Loop {
        work: work * TAU * mean,
        energy: energy * mean,
    })
}

/// Largest work over energy of all 66 pairs of freedoms, and the loop of 5 um rotation by 10 um radially.
fn loops(element: &Element) -> Result<(f64, Loop)> {
    let mut start = element.nominal_inputs();
    // 5 um into the drive flank, a little misaligned.
    let [external, _] = external_and_internal();
    start.gears[0].r = super::spin((5e-6 + 4e-6) / external.gears[0].base_radius());
    start.gears[1].r = Rotation3::from_euler_angles(3e-4, -2e-4, 0.0).into_inner();
    let mut worst = 0.0_f64;
    for i in 0..12 {
        for j in 0..i {
            let size = [i, j].map(|k| if k % 6 < 3 { 1e-6 } else { 1e-6 / 40e-3 });
            let found = ellipse(element, &start, [i, j], size)?;
            worst = worst.max((found.work / found.energy).abs());
        }
    }
    start.gears[0].r = super::spin(12e-6 / 38.5e-3);
    Ok((
        worst,
        ellipse(element, &start, [5, 6], [2.5e-6 / 38.5e-3, 5e-6])?,
    ))
}

/// Gear 2 in six freedoms on undamped springs, gear 1 at rest, and a start away from rest.
fn six_freedoms(pair: &PairGeometry, element: Element) -> Result<(Scene, State)> {
    let (still, loaded) = (Spin::speed(0.0), Spin::torque(TORQUE));
    let mut gears = [Gear::new(pair, 0, still), Gear::new(pair, 1, loaded)];
    for gear in &mut gears {
        gear.center_of_mass = 12.5e-3;
    }
    gears[1].bearing = Some(Bearing::springs([2e8, 2e8, 1e8], 1e5));
    let scene = Scene::new(element, gears)?;
    let mut start = scene.with_spin(&scene.rest(), 1, 7e-6 / 38.5e-3, 0.0);
    start[1].v = Vector3::new(0.02, -0.03, 0.05);
    start[1].l += Vector3::new(2e-4, 1e-4, 0.0);
    Ok((scene, start))
}

/// Step of the long runs, s.
const STEP: f64 = 2.5e-7;

/// What a long run gives.
pub struct LongRun {
    /// Steps made: the paper's law can throw the gear out of mesh, where the run ends.
    pub steps: usize,
    /// Largest energy error over the initial kinetic energy of the oscillation.
    pub error: f64,
}

/// Up to `steps` steps.
pub fn long_run(case: &Case, parameters: Parameters, steps: usize) -> Result<LongRun> {
    let (scene, mut y) = six_freedoms(case.geometry(), case.element(parameters)?)?;
    let energy = |y: &State| -> Result<f64> { Ok(scene.energy(0.0, y)? - TORQUE * y[1].twist()) };
    let g = y[1];
    let turning = g.l.norm_squared() / TRANSVERSE_INERTIA;
    let oscillation = 0.5 * (MASS * g.v.norm_squared() + turning);
    let start = energy(&y)?;
    let (mut made, mut error) = (0, 0.0_f64);
    while made < steps {
        let Ok(next) = scene.step(made as f64 * STEP, &y, STEP) else {
            break;
        };
        y = next;
        made += 1;
        if made % (steps / 200).max(1) == 0 {
            error = error.max(((energy(&y)? - start) / oscillation).abs());
        }
    }
    Ok(LongRun { steps: made, error })
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    use Formulation::{Conjugate, Paper};
    use Interpolation::{Linear, Shepard, Spline};
    let (sampled, real) = (Case::sampled(), Case::Real(Real::coarse("palermo2013")?));
    let mut constant_load = choice(Conjugate, Spline);
    constant_load.load_dependent = false;
    let without_tilt = Parameters {
        misalignment_effect: false,
        shuttling_effect: false,
        ..constant_load
    };
    let common = [
        ("spline", choice(Conjugate, Spline)),
        ("linear", choice(Conjugate, Linear)),
        ("Shepard", choice(Conjugate, Shepard)),
        ("spline", choice(Paper, Spline)),
    ];
    let constant = [
        (
            "spline, constant load, misalignment and shuttling off",
            without_tilt,
        ),
        ("spline, constant load", constant_load),
    ];
    let mut rows = vec![];
    for (case, choices) in [
        (&sampled, &common[..]),
        (&real, &common),
        (&real, &constant),
    ] {
        for (name, parameters) in choices {
            let (ratio, Loop { work, energy }) = loops(&case.element(*parameters)?)?;
            let law = format!("{} | {:?} | {name}", case.name(), parameters.formulation);
            rows.push(format!(
                "{law} | {ratio:.1e} | {:.2e} | {energy:.2e}",
                work.abs()
            ));
        }
    }
    let head = "law | formulation | interpolant | worst work / energy | work 5 um x 10 um, J | energy there, J";
    data.table("loops", head, &rows)?;

    let mut rows = vec![];
    for (case, formulation, interpolation, steps) in [
        (&sampled, Conjugate, Spline, 500_000),
        (&real, Conjugate, Spline, 5_000_000),
        (&real, Conjugate, Linear, 1_000_000),
        (&real, Conjugate, Shepard, 1_000_000),
        (&real, Paper, Spline, 250_000),
    ] {
        let steps = if context.quick { steps / 100 } else { steps };
        let LongRun { steps, error } = long_run(case, choice(formulation, interpolation), steps)?;
        let law = format!("{} | {formulation:?} | {interpolation:?}", case.name());
        rows.push(format!("{law} | {steps} | {error:.1e}"));
    }
    let head = "law | formulation | interpolant | steps | energy error";
    data.table("long-runs", head, &rows)
}
