//! Work on closed loops and drift of energy in a long run, conjugate beside the paper's formulation.

use crate::driver::{
    Bearing, Freedoms, Gear, Method, Scene, Spin, State, gear_state, set_gear_state, twist,
};
use crate::pair;
use crate::plot::{Line, Plot};
use crate::tables;
use gearmesh::element::{
    Element, FlankLaws, Formulation, Inputs, Interpolation, LoadedFlank, Parameters, StiffnessModel,
};
use gearmesh::gear::PairGeometry;
use gearmesh::table::{FlankTable, Table, samples::Spring};
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const INERTIA: f64 = 4.213e-4;
const MASS: f64 = 0.8;
const TORQUE: f64 = 60.0;

/// A pair with its law.
enum Case {
    /// The sampled four-dimensional potential of [`Spring`].
    Sampled(PairGeometry),
    /// The paper's modified pair with its table.
    Real(PairGeometry, Arc<Table>),
}

impl Case {
    fn geometry(&self) -> &PairGeometry {
        match self {
            Case::Sampled(geometry) | Case::Real(geometry, _) => geometry,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Case::Sampled(_) => "sampled potential",
            Case::Real(..) => "palermo2013",
        }
    }

    /// The element with the choices of `parameters`: undamped, both flanks.
    fn element(&self, parameters: Parameters) -> Result<Element> {
        let parameters = Parameters {
            stiffness_model: StiffnessModel::Table,
            loaded_flank: LoadedFlank::Both,
            backlash: Some(120e-6),
            damping: 0.0,
            ..parameters
        };
        Ok(match self {
            Case::Sampled(geometry) => {
                let grid = Spring::grid([10, 7, 9, 16]);
                let drive = Arc::new(FlankTable::new(&grid, parameters.interpolation)?);
                Element::with_laws(geometry, &parameters, &FlankLaws { drive, coast: None })?
            }
            Case::Real(geometry, table) => {
                Element::new(geometry, &parameters, Some(table.clone()))?
            }
        })
    }
}

/// All effects on, the load variable.
fn choice(formulation: Formulation, interpolation: Interpolation) -> Parameters {
    Parameters {
        formulation,
        interpolation,
        ..Parameters::default()
    }
}

/// Work and mean energy on an ellipse in the freedoms `i`, `j` (0-11) with these half axes.
fn loop_work(
    element: &Element,
    start: &Inputs,
    i: usize,
    j: usize,
    size: [f64; 2],
) -> Result<(f64, f64)> {
    let latch = element.latch(&element.nominal_inputs())?;
    let points = 4000;
    let (mut work, mut energy) = (0.0, 0.0);
    for n in 0..points {
        let t = TAU * n as f64 / points as f64;
        let (mut x, mut rate) = ([0.0; 12], [0.0; 12]);
        x[i] += size[0] * t.cos();
        rate[i] -= size[0] * t.sin();
        x[j] += size[1] * t.sin();
        rate[j] += size[1] * t.cos();
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
        let out = element.evaluate(&latch, &inputs)?;
        for (body, m) in inputs.gears.iter().enumerate() {
            work += out.force[body].dot(&m.v) + out.moment[body].dot(&m.w);
        }
        energy += out.energy;
    }
    Ok((work * TAU / points as f64, energy / points as f64))
}

/// Largest work over energy of all 66 pairs of freedoms, and that of 5 um rotation by 10 um radial.
fn loops(element: &Element) -> Result<(f64, f64, f64)> {
    let mut start = element.nominal_inputs();
    // 5 um into the drive flank, a little misaligned.
    let turn = (5e-6 + 4e-6) / pair::external().gears[0].base_radius();
    start.gears[0].r = Rotation3::from_axis_angle(&Vector3::z_axis(), turn).into_inner();
    start.gears[1].r = Rotation3::from_euler_angles(3e-4, -2e-4, 0.0).into_inner();
    let mut worst = 0.0_f64;
    for i in 0..12 {
        for j in 0..i {
            let size = [i, j].map(|k| if k % 6 < 3 { 1e-6 } else { 1e-6 / 40e-3 });
            let (work, energy) = loop_work(element, &start, i, j, size)?;
            worst = worst.max((work / energy).abs());
        }
    }
    start.gears[0].r = Rotation3::from_axis_angle(&Vector3::z_axis(), 12e-6 / 38.5e-3).into_inner();
    let (work, energy) = loop_work(element, &start, 5, 6, [2.5e-6 / 38.5e-3, 5e-6])?;
    Ok((worst, work.abs(), energy))
}

/// Gear 2 in six freedoms on undamped springs, gear 1 held, and a start away from rest.
fn six_freedoms(pair: &PairGeometry, element: Element) -> Result<(Scene, State)> {
    let gear = |i: usize, spin, freedoms| Gear {
        mass: MASS,
        polar_inertia: INERTIA,
        transverse_inertia: 0.6 * INERTIA,
        center_of_mass: 12.5e-3,
        origin: Vector3::new(i as f64 * pair.center_distance, 0.0, 0.0),
        bearing: Bearing {
            stiffness: [2e8, 2e8, 1e8],
            tilt_stiffness: 1e5,
            ..Bearing::default()
        },
        freedoms,
        spin,
    };
    let gears = [
        gear(0, Spin::speed(0.0), Freedoms::default()),
        gear(1, Spin::torque(TORQUE), Freedoms::ALL),
    ];
    let scene = Scene::new(element, gears)?;
    let mut start = scene.with_spin(&scene.rest(), 1, 7e-6 / 38.5e-3, 0.0);
    let mut g = gear_state(&start, 1);
    g.v = Vector3::new(0.02, -0.03, 0.05);
    g.l += Vector3::new(2e-4, 1e-4, 0.0);
    set_gear_state(&mut start, 1, &g);
    Ok((scene, start))
}

/// Energy error over the initial kinetic energy of the oscillation, sampled along `steps` steps of `h`.
fn long_run(
    pair: &PairGeometry,
    element: Element,
    steps: usize,
    h: f64,
) -> Result<Vec<(f64, f64)>> {
    let (scene, mut y) = six_freedoms(pair, element)?;
    let energy = |y: &State| -> Result<f64> {
        Ok(scene.energy(0.0, y)? - TORQUE * twist(&gear_state(y, 1).q))
    };
    let g = gear_state(&y, 1);
    let oscillation = 0.5 * MASS * g.v.norm_squared() + 0.5 * g.l.norm_squared() / (0.6 * INERTIA);
    let start = energy(&y)?;
    let mut curve = vec![(0.0, 0.0)];
    for n in 1..=steps {
        y = match Method::RungeKutta4.step(&scene, n as f64 * h, &y, h) {
            Ok(y) => y,
            // The paper's law can throw the gear out of mesh: the curve ends there.
            Err(_) => break,
        };
        if n % (steps / 200).max(1) == 0 {
            curve.push((n as f64 * h, (energy(&y)? - start) / oscillation));
        }
    }
    Ok(curve)
}

fn worst(curve: &[(f64, f64)]) -> f64 {
    curve.iter().map(|p| p.1.abs()).fold(0.0, f64::max)
}

/// The chapter.
pub fn report(folder: &Path) -> crate::Outcome {
    let mut text = String::from(
        "Two laws over displacement, centre distance, misalignment and mesh position, every effect on, both flanks: `sampled potential` \
         (`table::samples::Spring`) and `palermo2013`, the table of that pair on coarse finite elements. \
         Loops: ellipses of 1 um (rotations: 1 um at 40 mm) in each of the 66 pairs of the twelve freedoms, worst work over energy; then \
         5 um of rotation by 10 um radially (ellipse inscribed).\n\n\
         | law | formulation | interpolant | worst work / energy | work 5 um x 10 um, J | energy there, J |\n|---|---|---|---|---|---|\n",
    );
    let (real, table) = tables::palermo()?;
    let cases = [
        Case::Sampled(pair::external()),
        Case::Real(real.geometry, table),
    ];
    use Formulation::{Conjugate, Paper};
    use Interpolation::{Linear, Shepard, Spline};
    let constant_load = Parameters {
        load_dependent: false,
        ..choice(Conjugate, Spline)
    };
    let without_tilt = Parameters {
        misalignment_effect: false,
        shuttling_effect: false,
        ..constant_load
    };
    // Of the last row: a constant load with every effect.
    let mut of_constant_load = 0.0;
    for case in &cases {
        let mut rows = vec![
            ("Conjugate", "spline", choice(Conjugate, Spline)),
            ("Conjugate", "linear", choice(Conjugate, Linear)),
            ("Conjugate", "Shepard", choice(Conjugate, Shepard)),
            ("Paper", "spline", choice(Paper, Spline)),
        ];
        if matches!(case, Case::Real(..)) {
            let tilt_off = "spline, constant load, misalignment and shuttling off";
            rows.push(("Conjugate", tilt_off, without_tilt));
            rows.push(("Conjugate", "spline, constant load", constant_load));
        }
        for (formulation, interpolant, parameters) in rows {
            let (ratio, work, energy) = loops(&case.element(parameters)?)?;
            of_constant_load = ratio;
            writeln!(
                text,
                "| {} | {formulation} | {interpolant} | {ratio:.1e} | {work:.2e} | {energy:.2e} |",
                case.name()
            )?;
        }
    }
    writeln!(
        text,
        "\nConstant load is a secant stiffness; its shuttling moment is F (z_c - z_ref) with z_c at the nominal load, as in the paper, \
         and not dW/dM. Loops that tilt a gear then do work, here {of_constant_load:.1e} of the energy (last row)."
    )?;
    let h = 2.5e-7;
    writeln!(
        text,
        "\nGear 2 in six freedoms on undamped springs, gear 1 held, {TORQUE} N m; Runge-Kutta 4, step {h:.1e} s. Largest energy \
         error over the kinetic energy at the start:\n\n| law | formulation | interpolant | steps | energy error |\n|---|---|---|---|---|"
    )?;
    let mut curves = Vec::new();
    for (case, formulation, interpolation, steps) in [
        (&cases[0], Conjugate, Spline, 500_000),
        (&cases[1], Conjugate, Spline, 5_000_000),
        (&cases[1], Conjugate, Linear, 1_000_000),
        (&cases[1], Conjugate, Shepard, 1_000_000),
        (&cases[1], Paper, Spline, 250_000),
    ] {
        let element = case.element(choice(formulation, interpolation))?;
        let curve = long_run(case.geometry(), element, steps, h)?;
        let name = case.name();
        writeln!(
            text,
            "| {name} | {formulation:?} | {interpolation:?} | {steps} | {:.1e} |",
            worst(&curve)
        )?;
        curves.push((format!("{name}, {formulation:?}, {interpolation:?}"), curve));
    }
    text.push_str("\n![energy](stability/energy.svg)\n");
    let log = |curve: Vec<(f64, f64)>| {
        curve
            .into_iter()
            .filter(|p| p.0 > 0.0 && p.1 != 0.0)
            .map(|p| (p.0, p.1.abs()))
            .collect::<Vec<_>>()
    };
    let lines = curves
        .into_iter()
        .map(|(name, curve)| Line {
            name,
            points: log(curve),
        })
        .collect();
    Plot {
        title: "Energy error over oscillation energy",
        x: "time, s",
        y: "relative error",
        logarithmic: true,
        lines,
    }
    .save(&folder.join("energy.svg"))?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Formulation::{Conjugate, Paper};
    use Interpolation::{Linear, Shepard, Spline};

    #[test]
    fn closed_loops_give_nothing_but_in_the_papers_formulation() {
        let case = Case::Sampled(pair::external());
        for interpolation in [Spline, Linear, Shepard] {
            let element = case.element(choice(Conjugate, interpolation)).unwrap();
            let (ratio, work, energy) = loops(&element).unwrap();
            assert!(
                ratio < 1e-9 && work < 1e-9 * energy,
                "{interpolation:?}: {ratio}, {work} J"
            );
        }
        let paper = case.element(choice(Paper, Spline)).unwrap();
        let (ratio, work, _) = loops(&paper).unwrap();
        assert!(ratio > 1e-2 && work > 1e-3, "{ratio}, {work} J");
    }

    #[test]
    fn a_run_in_six_freedoms_keeps_its_energy() {
        let case = Case::Sampled(pair::external());
        for interpolation in [Spline, Shepard] {
            let element = case.element(choice(Conjugate, interpolation)).unwrap();
            let curve = long_run(case.geometry(), element, 20_000, 2.5e-7).unwrap();
            assert!(worst(&curve) < 1e-6, "{interpolation:?}: {}", worst(&curve));
        }
    }
}
