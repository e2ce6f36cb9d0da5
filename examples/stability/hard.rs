//! Hard cases one by one: poses at the limits, and motion through the backlash.

use crate::driver::{Bearing, Freedoms, Gear, Method, Scene, Spin};
use crate::pair;
use crate::poses::{BACKLASH, Real, pose, ratio, spin, undamped};
use gearmesh::element::{
    Element, ElementError, Formulation, Inputs, Interpolation, LoadedFlank, Outputs, Parameters,
};
use gearmesh::gear::PairGeometry;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Compression unless said, m on the line of action.
const PRESS: f64 = 5e-6;
/// Torque on gear 2 of the runs, N m, and its polar inertia, kg m^2.
const TORQUE: f64 = 100.0;
const INERTIA: f64 = 4.213e-4;
/// Damping of the runs, N s/m.
const DAMPING: f64 = 1000.0;
/// Step of the runs, s.
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
        let pair = pair::external();
        let mut all = vec![Self {
            name: "constant stiffness",
            backlash: pair.backlash(pair.center_distance),
            element: Element::new(&pair, &undamped(LoadedFlank::Both), None)?,
            pair,
        }];
        for real in Real::pairs()? {
            let phi = real
                .geometry
                .operating_pressure_angle(real.geometry.center_distance);
            all.push(Self {
                name: real.name,
                backlash: BACKLASH * phi.cos(),
                element: real.element(
                    Formulation::Conjugate,
                    Interpolation::Spline,
                    LoadedFlank::Both,
                )?,
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

    fn evaluate(&self, inputs: &Inputs) -> std::result::Result<Outputs, ElementError> {
        let latch = self.element.latch(&self.element.nominal_inputs())?;
        self.element.evaluate(&latch, inputs)
    }

    /// The same with damping.
    fn damped(&self) -> Result<Element> {
        Ok(self.element.with_damping(DAMPING)?)
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
        let speed = TAU * 20_000.0 / 60.0;
        inputs.gears[0].w.z = speed;
        inputs.gears[1].w.z = ratio(&s.pair) * speed;
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
) -> Result<Vec<Outputs>> {
    let pair = &subject.pair;
    // The drive flank pushes gear 2 against its spin angle (internal: along it).
    let sense = pair.e();
    let gear = |i: usize, spin| Gear {
        mass: 1.0,
        polar_inertia: INERTIA,
        transverse_inertia: INERTIA,
        center_of_mass: 0.0,
        origin: Vector3::new(i as f64 * pair.center_distance, 0.0, 0.0),
        bearing: Bearing::default(),
        freedoms: Freedoms::default(),
        spin,
    };
    let load = Spin::Torque(Arc::new(move |t, _| sense * torque(t)));
    let gears = [gear(0, Spin::speed(0.0)), gear(1, load)];
    let scene = Scene::new(subject.damped()?, gears)?;
    let turn = sense * delta / pair.gears[1].base_radius();
    let mut y = scene.with_spin(&scene.rest(), 1, turn, 0.0);
    let mut n = 0;
    let mut found = Vec::new();
    for &end in times {
        while (n as f64) * STEP < end {
            y = Method::RungeKutta4.step(&scene, n as f64 * STEP, &y, STEP)?;
            n += 1;
        }
        found.push(scene.contact(end, &y)?);
    }
    Ok(found)
}

/// The runs: what is told of them, and the loads on all subjects.
fn runs(subjects: &[Subject]) -> Result<String> {
    let mut text = format!(
        "\nIn motion: gear 1 at rest, gear 2 (J = {INERTIA} kg m^2) spins freely under a torque, damping {DAMPING} N s/m, Runge-Kutta 4, \
         step {STEP:e} s. At rest the tangential force must be the torque over the operating pitch radius of gear 2.\n\n\
         | pair | torque / pitch radius | reversal from +{TORQUE} to -{TORQUE} N m within 10 ms: before | 30 ms after | released in the \
         middle of the gap: 30 ms after |\n|---|---|---|---|---|\n"
    );
    for subject in subjects {
        let pair = &subject.pair;
        let radius = pair.operating_pitch_radius(1, pair.center_distance);
        let ramp = |t: f64| TORQUE * (1.0 - 2.0 * ((t - 20e-3) / 10e-3).clamp(0.0, 1.0));
        let reversal = motion(subject, PRESS, ramp, &[20e-3, 60e-3])?;
        let released = motion(subject, -0.5 * subject.backlash, |_| TORQUE, &[30e-3])?;
        writeln!(
            text,
            "| {} | {:.2} N | {} | {} | {} |",
            subject.name,
            TORQUE / radius,
            in_words(&reversal[0]),
            in_words(&reversal[1]),
            in_words(&released[0])
        )?;
    }
    Ok(text)
}

/// The chapter.
pub fn report(_: &Path) -> crate::Outcome {
    let subjects = Subject::all()?;
    let stiffness = Parameters::default().constant_stiffness;
    let mut text = format!(
        "Tangential force, both flanks able to carry, no damping, pressed by {:.0} um on the line of action unless said. The external pair with \
         {stiffness:.2e} N/m, the paper's pair with its shipped table, and planet and ring with a table on coarse finite elements \
         (backlash {:.0} um), all effects on, spline.\n\n| case |",
        1e6 * PRESS,
        1e6 * BACKLASH
    );
    for subject in &subjects {
        write!(text, " {} |", subject.name)?;
    }
    text.push_str("\n|---|---|---|---|\n");
    let mut refusals = Vec::new();
    for (case, make) in POSES {
        write!(text, "| {case} |")?;
        for subject in &subjects {
            match subject.evaluate(&make(subject)) {
                Ok(out) => write!(text, " {} |", in_words(&out))?,
                Err(error) => {
                    refusals.push(format!("- {case}, {}: {error}", subject.name));
                    write!(text, " refused |")?;
                }
            }
        }
        text.push('\n');
    }
    writeln!(text, "\nRefusals in full:\n\n{}", refusals.join("\n"))?;
    text.push_str(&runs(&subjects)?);
    Ok(text)
}
