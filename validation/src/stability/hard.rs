//! Hard cases one by one: poses at the limits, and motion through the backlash.

use super::{Real, pose, spin, undamped};
use crate::data::Data;
use crate::driver::{Gear, Scene, Spin};
use crate::setup::{external_and_internal, ratio};
use crate::{Context, Result};
use gearmesh::element::{Element, Formulation, Inputs, Interpolation, LoadedFlank, Outputs};
use gearmesh::gear::PairGeometry;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

/// Compression unless said, m on the line of action.
const PRESS: f64 = 5e-6;
/// Torque on gear 2 of the runs, N m.
const TORQUE: f64 = 100.0;
/// Damping of the runs, N s/m, and their step, s.
const DAMPING: f64 = 1000.0;
const STEP: f64 = 2e-7;

/// One of the elements that all cases are tried on.
struct Subject {
    name: &'static str,
    pair: PairGeometry,
    backlash: f64,
    element: Element,
}

impl Subject {
    /// Constant stiffness, a shipped table and an internal pair.
    fn all() -> Result<Vec<Self>> {
        let [pair, _] = external_and_internal();
        let element = Element::new(&pair, &undamped(LoadedFlank::Both), None)?;
        let backlash = pair.backlash(pair.center_distance);
        let mut all = vec![Self {
            name: "constant stiffness",
            backlash,
            element,
            pair,
        }];
        for real in Real::pairs()? {
            let element = real.element(
                Formulation::Conjugate,
                Interpolation::Spline,
                LoadedFlank::Both,
            )?;
            all.push(Self {
                name: real.name,
                backlash: real.gap(),
                element,
                pair: real.geometry,
            });
        }
        Ok(all)
    }

    /// Gear 1 turned so far that its drive flank is compressed by `delta`, gear 2 moved by `apart` away from
    /// the mesh and by `along` its axis.
    fn pose(&self, delta: f64, apart: f64, along: f64) -> Inputs {
        let shift = Vector3::new(self.pair.e() * apart, 0.0, along);
        pose(
            &self.element,
            delta / self.pair.gears[0].base_radius(),
            shift,
        )
    }
}

/// A pose of one subject.
type MakePose = fn(&Subject) -> Inputs;

const POSES: [(&str, MakePose); 11] = [
    ("drive flank pressed", |s| s.pose(PRESS, 0.0, 0.0)),
    ("at rest in the middle of the gap", |s| {
        s.pose(-0.5 * s.backlash, 0.0, 0.0)
    }),
    ("through the gap, coast flank pressed", |s| {
        s.pose(-s.backlash - PRESS, 0.0, 0.0)
    }),
    ("1e7 revolutions (ulp of the angle: 0.3 nm)", |s| {
        let mut inputs = s.pose(0.0, 0.0, 0.0);
        let far = TAU * 1e7;
        inputs.gears[0].r = spin(far + PRESS / s.pair.gears[0].base_radius());
        inputs.gears[1].r = spin(ratio(&s.pair) * far);
        inputs
    }),
    ("1000 km from the origin (ulp: 0.1 nm)", |s| {
        let mut inputs = s.pose(PRESS, 0.0, 0.0);
        for m in &mut inputs.gears {
            m.p += Vector3::new(1e6, -2e5, 3e5);
        }
        inputs
    }),
    ("20 000 rpm", |s| {
        let mut inputs = s.pose(PRESS, 0.0, 0.0);
        inputs.gears[0].w.z = TAU * 20_000.0 / 60.0;
        inputs.gears[1].w.z = ratio(&s.pair) * inputs.gears[0].w.z;
        inputs
    }),
    ("both flanks pressed: 0.2 mm closer (ring: farther)", |s| {
        s.pose(0.0, -0.2e-3, 0.0)
    }),
    ("out of mesh: three modules apart", |s| {
        s.pose(PRESS, 3.0 * s.pair.gears[0].normal_module, 0.0)
    }),
    ("out of mesh: 50 mm along the axis", |s| {
        s.pose(PRESS, 0.0, 50e-3)
    }),
    ("tilt of 90 deg", |s| {
        let mut inputs = s.pose(PRESS, 0.0, 0.0);
        inputs.gears[1].r = Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2).into_inner();
        inputs
    }),
    ("coincident centres", |s| {
        s.pose(PRESS, -s.pair.e() * s.pair.center_distance, 0.0)
    }),
];

/// The load in words.
fn in_words(out: &Outputs) -> String {
    let flank = match out.flank {
        1 => "drive",
        -1 => "coast",
        _ => "no flank",
    };
    let range = if out.out_of_range {
        ", out of range"
    } else {
        ""
    };
    format!("{:.2} N, {flank}{range}", out.tangential_force)
}

/// Gear 2 free to spin under `torque(t)` against gear 1 at rest, from the angle at which the drive flank is
/// compressed by `delta`; the loads at each of `times`.
fn motion(
    subject: &Subject,
    delta: f64,
    torque: impl Fn(f64) -> f64 + Send + Sync + 'static,
    times: &[f64],
) -> Result<String> {
    let pair = &subject.pair;
    // The drive flank pushes gear 2 against its spin angle (internal: along it).
    let sense = pair.e();
    let load = Spin::Torque(Arc::new(move |t, _| sense * torque(t)));
    let gears = [
        Gear::new(pair, 0, Spin::speed(0.0)),
        Gear::new(pair, 1, load),
    ];
    let mut element = subject.element.clone();
    element.set_damping(DAMPING);
    let scene = Scene::new(element, gears)?;
    let turn = sense * delta / pair.gears[1].base_radius();
    let mut y = scene.with_spin(&scene.rest(), 1, turn, 0.0);
    let mut n = 0;
    let mut found = vec![];
    for &end in times {
        while (n as f64) * STEP < end {
            y = scene.step(n as f64 * STEP, &y, STEP)?;
            n += 1;
        }
        found.push(in_words(&scene.contact(end, &y)?));
    }
    Ok(found.join(" | "))
}

pub fn report(_: &Context, data: &Data) -> Result<()> {
    let subjects = Subject::all()?;
    let mut rows = vec![];
    for (case, make) in POSES {
        let mut row = case.to_owned();
        for subject in &subjects {
            let element = &subject.element;
            let phase = element.phase_offset(&element.nominal_inputs())?;
            row += " | ";
            row += &match element.evaluate(&phase, &make(subject)) {
                Ok(out) => in_words(&out),
                Err(error) => format!("refused: {error}"),
            };
        }
        rows.push(row);
    }
    let names: Vec<_> = subjects.iter().map(|s| s.name).collect();
    data.table("poses", &format!("case | {}", names.join(" | ")), &rows)?;

    let mut rows = vec![];
    for subject in &subjects {
        let pair = &subject.pair;
        let expected = TORQUE / pair.operating_pitch_radius(1, pair.center_distance);
        let ramp = |t: f64| TORQUE * (1.0 - 2.0 * ((t - 20e-3) / 10e-3).clamp(0.0, 1.0));
        let reversal = motion(subject, PRESS, ramp, &[20e-3, 60e-3])?;
        let released = motion(subject, -0.5 * subject.backlash, |_| TORQUE, &[30e-3])?;
        rows.push(format!(
            "{} | {expected:.2} N | {reversal} | {released}",
            subject.name
        ));
    }
    let head = "pair | torque / pitch radius | reversal from +100 to -100 N m within 10 ms: before \
        | 30 ms after | released in the middle of the gap: 30 ms after";
    data.table("motion", head, &rows)
}
