//! Hard cases one by one, and scans for jumps of the force.

use crate::pair;
use crate::plot::{Line, Plot};
use gearmesh::element::{
    Element, FlankLaws, Formulation, Inputs, Interpolation, LoadedFlank, Parameters,
};
use gearmesh::gear::PairGeometry;
use gearmesh::table::{FlankTable, samples::Spring};
use nalgebra::{Rotation3, Vector3};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn parameters(loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        loaded_flank,
        damping: 0.0,
        ..Parameters::default()
    }
}

/// Gear 1 turned by `angle`, gear 2 moved by `shift`.
fn pose(element: &Element, angle: f64, shift: Vector3<f64>) -> Inputs {
    let mut inputs = element.nominal_inputs();
    inputs.gears[0].r = Rotation3::from_axis_angle(&Vector3::z_axis(), angle).into_inner();
    inputs.gears[1].p += shift;
    inputs
}

fn describe(element: &Element, inputs: &Inputs) -> Result<String> {
    let latch = element.latch(&element.nominal_inputs())?;
    Ok(match element.evaluate(&latch, inputs) {
        Ok(out) => format!(
            "F_tt = {:.6e} N, flank {}, out of range {}",
            out.tangential_force, out.flank, out.out_of_range
        ),
        Err(e) => format!("refused: {e}"),
    })
}

/// The hard cases.
pub fn report(_: &Path) -> crate::Outcome {
    let external = pair::external();
    let rb = external.gears[0].base_radius();
    let both = Element::new(&external, &parameters(LoadedFlank::Both), None)?;
    let press = 5e-6 / rb;
    let mut text = String::from(
        "Constant stiffness 4.35e8 N/m, both flanks, no damping; pressed by 5 um unless said.\n\n| case | answer |\n|---|---|\n",
    );
    let mut row = |case: &str, answer: String| writeln!(text, "| {case} | {answer} |");
    let none = Vector3::zeros();
    row(
        "reference: drive flank",
        describe(&both, &pose(&both, press, none))?,
    )?;
    row(
        "inside the gap",
        describe(&both, &pose(&both, -30e-6 / rb, none))?,
    )?;
    let gap = external.backlash(external.center_distance);
    row(
        "through the gap: coast flank",
        describe(&both, &pose(&both, -gap / rb - press, none))?,
    )?;
    // Both gears turned 1e7 revolutions: the matrices come from angles in f64.
    let mut inputs = pose(&both, press, none);
    let far = std::f64::consts::TAU * 1e7;
    inputs.gears[0].r = Rotation3::from_axis_angle(&Vector3::z_axis(), far + press).into_inner();
    inputs.gears[1].r = Rotation3::from_axis_angle(&Vector3::z_axis(), -far).into_inner();
    row(
        "1e7 revolutions (an ulp of the angle: 0.3 nm)",
        describe(&both, &inputs)?,
    )?;
    let mut inputs = pose(&both, press, none);
    for m in &mut inputs.gears {
        m.p += Vector3::new(1e6, -2e5, 3e5);
    }
    row(
        "1000 km from the origin (an ulp: 0.1 nm)",
        describe(&both, &inputs)?,
    )?;
    let mut inputs = pose(&both, press, none);
    let speed = std::f64::consts::TAU * 20_000.0 / 60.0;
    inputs.gears[0].w.z = speed;
    inputs.gears[1].w.z = -speed;
    row("20 000 rpm", describe(&both, &inputs)?)?;
    let mut inputs = pose(&both, press, none);
    inputs.gears[1].r =
        Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2).into_inner();
    row("tilt of 90 deg", describe(&both, &inputs)?)?;
    row(
        "coincident centres",
        describe(
            &both,
            &pose(&both, press, Vector3::x() * -external.center_distance),
        )?,
    )?;
    row(
        "10 mm apart: out of mesh",
        describe(&both, &pose(&both, press, Vector3::x() * 10e-3))?,
    )?;
    row(
        "30 mm along the axis: out of mesh",
        describe(&both, &pose(&both, press, Vector3::z() * 30e-3))?,
    )?;
    row(
        "0.2 mm closer: both flanks press",
        describe(&both, &pose(&both, 0.0, Vector3::x() * -0.2e-3))?,
    )?;
    let ring = pair::internal();
    let inside = Element::new(&ring, &parameters(LoadedFlank::Both), None)?;
    row(
        "ring, 20 mm apart (towards concentric): out of mesh",
        describe(&inside, &pose(&inside, press, Vector3::x() * -20e-3))?,
    )?;
    row(
        "ring, coincident centres",
        describe(
            &inside,
            &pose(&inside, press, Vector3::x() * -ring.center_distance),
        )?,
    )?;
    row(
        "ring, 0.2 mm farther: both flanks press",
        describe(&inside, &pose(&inside, 0.0, Vector3::x() * 0.2e-3))?,
    )?;
    Ok(text)
}

/// Largest second difference of the force over `n` points of a path, over the largest force: halving the step of a
/// continuous curve quarters it where it is smooth and halves it at a kink, and leaves it at a jump.
fn roughness(
    element: &Element,
    path: &dyn Fn(f64) -> Inputs,
    n: usize,
) -> Result<(f64, Vec<(f64, f64)>)> {
    let latch = element.latch(&element.nominal_inputs())?;
    let mut curve = Vec::with_capacity(n + 1);
    let mut forces = Vec::with_capacity(n + 1);
    for i in 0..=n {
        let s = i as f64 / n as f64;
        let out = element.evaluate(&latch, &path(s))?;
        curve.push((s, out.tangential_force));
        forces.push(out.force[1]);
    }
    let scale = forces.iter().map(|f| f.norm()).fold(1.0, f64::max);
    let worst = forces
        .windows(3)
        .map(|w| (w[0] - 2.0 * w[1] + w[2]).norm())
        .fold(0.0, f64::max);
    Ok((worst / scale, curve))
}

/// Scans.
pub fn continuity(folder: &Path) -> crate::Outcome {
    let mut text = String::from(
        "Paths through the legal range with 4000 and 16 000 points: the largest second difference of the force vector over the largest \
         force. A jump would keep it; a kink divides it by 4, a smooth curve by 16.\n\n\
         | pair | law | path | 4000 points | 16 000 points | ratio |\n|---|---|---|---|---|---|\n",
    );
    let mut lines = Vec::new();
    let pairs: [(&str, PairGeometry); 3] = [
        ("external", pair::external()),
        ("internal", pair::internal()),
        ("ring first", pair::ring_first()),
    ];
    for (name, geometry) in pairs {
        let drive = Arc::new(FlankTable::new(
            &Spring::grid([10, 7, 9, 16]),
            Interpolation::Spline,
        )?);
        let laws = FlankLaws { drive, coast: None };
        let elements = [
            (
                "constant",
                Element::new(&geometry, &parameters(LoadedFlank::Both), None)?,
            ),
            (
                "table",
                Element::with_laws(&geometry, &parameters(LoadedFlank::Both), &laws)?,
            ),
            (
                "paper, table",
                Element::with_laws(
                    &geometry,
                    &Parameters {
                        formulation: Formulation::Paper,
                        ..parameters(LoadedFlank::Both)
                    },
                    &laws,
                )?,
            ),
        ];
        let rb = geometry.gears[0].base_radius();
        let e = geometry.e();
        for (law, element) in &elements {
            let gap = geometry.backlash(geometry.center_distance);
            let turn = |s: f64| {
                pose(
                    element,
                    (-gap - 10e-6 + s * (gap + 20e-6)) / rb,
                    Vector3::zeros(),
                )
            };
            let radial = |s: f64| {
                pose(
                    element,
                    5e-6 / rb,
                    Vector3::x() * (e * (-0.2e-3 + s * 10e-3)),
                )
            };
            let axial = |s: f64| {
                pose(
                    element,
                    5e-6 / rb,
                    Vector3::new(0.0, 0.0, -30e-3 + s * 60e-3),
                )
            };
            let cycle = |s: f64| {
                // Both gears roll through two pitches, pressed.
                let angle = 2.0 * std::f64::consts::TAU / geometry.gears[0].z() * s;
                let mut x = pose(element, angle + 5e-6 / rb, Vector3::zeros());
                let ratio = -e * geometry.gears[0].z() / geometry.gears[1].z();
                x.gears[1].r =
                    Rotation3::from_axis_angle(&Vector3::z_axis(), ratio * angle).into_inner();
                x
            };
            let paths: [(&str, &dyn Fn(f64) -> Inputs); 4] = [
                ("turn through the gap", &turn),
                ("apart", &radial),
                ("along the axis", &axial),
                ("two mesh cycles", &cycle),
            ];
            for (path_name, path) in paths {
                let (coarse, curve) = roughness(element, path, 4000)?;
                let (fine, _) = roughness(element, path, 16_000)?;
                writeln!(
                    text,
                    "| {name} | {law} | {path_name} | {coarse:.1e} | {fine:.1e} | {:.1} |",
                    coarse / fine
                )?;
                if path_name == "apart" && *law == "constant" {
                    lines.push(Line {
                        name: name.into(),
                        points: curve,
                    });
                }
            }
        }
    }
    Plot {
        title: "Force while the gears are pulled apart",
        x: "path, 10 mm",
        y: "tangential force, N",
        logarithmic: false,
        lines,
    }
    .save(&folder.join("apart.svg"))?;
    text.push_str("\n![apart](stability/apart.svg)\n");
    Ok(text)
}
