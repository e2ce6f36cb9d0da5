//! Scans of the force for jumps, inside the range of the tables and beyond it.

use super::{Real, pose, spin, undamped};
use crate::data::Data;
use crate::setup::{external_and_internal, ratio};
use crate::spring::Spring;
use crate::{Context, Result};
use gearmesh::element::{Element, Formulation, Inputs, Interpolation, LoadedFlank};
use gearmesh::gear::PairGeometry;
use gearmesh::table::FlankTable;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Compression of the flank in the scans that do not vary it, m on the line of action.
const PRESS: f64 = 5e-6;

/// A path: its name, and the pose at 0..1 of it.
pub type Route = (&'static str, fn(&Subject, f64) -> Inputs);

pub const PATHS: [Route; 5] = [
    ("turn through the gap", |s, x| s.turned(x)),
    ("apart, 10 mm", |s, x| {
        s.pressed(Vector3::x() * (s.pair.e() * (-0.2e-3 + 10e-3 * x)))
    }),
    ("along the axis, 60 mm", |s, x| {
        s.pressed(Vector3::z() * (-30e-3 + 60e-3 * x))
    }),
    ("tilt, -5 to 5 mrad", |s, x| {
        let mut inputs = s.pressed(Vector3::zeros());
        // About an axis across the line of action, so that the tilt is misalignment.
        let phi = s.pair.operating_pressure_angle(s.pair.center_distance);
        let across = Vector3::new(-phi.cos(), s.sign * phi.sin(), 0.0);
        let middle = Vector3::z() * s.pair.z_ref();
        let tilt = Rotation3::new(across * (5e-3 * (2.0 * x - 1.0)));
        let gear = &mut inputs.gears[1];
        gear.p += middle - tilt * middle;
        gear.r = tilt.matrix() * gear.r;
        inputs
    }),
    ("two mesh cycles", |s, x| {
        let angle = 2.0 * TAU / s.pair.gears[0].z() * x;
        let mut inputs = s.pressed(Vector3::zeros());
        inputs.gears[0].r *= spin(angle);
        inputs.gears[1].r = spin(ratio(&s.pair) * angle);
        inputs
    }),
];

/// An element under scan.
pub struct Subject {
    pair: PairGeometry,
    element: Element,
    /// Flank that is pressed: +1 drive, -1 coast.
    sign: f64,
    /// Way from flank to flank on the line of action, m; zero with one flank.
    gap: f64,
}

impl Subject {
    fn new(pair: &PairGeometry, element: Element, flank: LoadedFlank, backlash: f64) -> Self {
        Self {
            pair: pair.clone(),
            element,
            sign: if flank == LoadedFlank::Coast {
                -1.0
            } else {
                1.0
            },
            gap: if flank == LoadedFlank::Both {
                backlash
            } else {
                0.0
            },
        }
    }

    /// From 10 um in the far flank (one flank: 10 um before the touch) to 10 um in the loaded one.
    fn turned(&self, x: f64) -> Inputs {
        let delta = -self.gap - 10e-6 + x * (self.gap + 20e-6);
        self.compressed(delta, Vector3::zeros())
    }

    fn pressed(&self, shift: Vector3<f64>) -> Inputs {
        self.compressed(PRESS, shift)
    }

    fn compressed(&self, delta: f64, shift: Vector3<f64>) -> Inputs {
        let angle = self.sign * delta / self.pair.gears[0].base_radius();
        pose(&self.element, angle, shift)
    }

    /// Force on gear 2 on `path`.
    fn force(&self, path: fn(&Self, f64) -> Inputs, x: f64) -> Result<Vector3<f64>> {
        let phase = self.element.phase_offset(&self.element.nominal_inputs())?;
        Ok(self.element.evaluate(&phase, &path(self, x))?.force[1])
    }

    /// How the force goes along each path.
    pub fn course(&self) -> Result<Vec<Course>> {
        PATHS
            .iter()
            .map(|(_, path)| Course::of(&|x| self.force(*path, x), POINTS))
            .collect()
    }
}

/// Points of a scan.
const POINTS: usize = 4000;
/// Spots of a scan that are looked at closely: those least like a smooth curve.
const SPOTS: usize = 100;
/// Halvings of the steps there; what is left is 5e-13 of the path, just above the rounding of poses.
const HALVINGS: usize = 30;
/// Halvings at which the second difference still stands clear of rounding.
const CLEAR_OF_ROUNDING: usize = 12;
/// Change of the force, over the largest one, that counts as a jump when it does not go away.
const JUMP: f64 = 1e-7;
/// Change of the slope, over the largest one, that counts as a kink.
const KINK: f64 = 1e-3;

/// Worst that the force does on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// Neither of the others.
    Smooth,
    /// The slope jumps by this, over the largest slope.
    Kink(f64),
    /// The force jumps by this, over the largest force.
    Jump(f64),
    /// The element refuses some of the poses.
    Refused,
}

impl Course {
    /// Of `force` over 0..1. Where it is least like a smooth curve over `points` steps, they are halved again
    /// and again around the spot: the change of a smooth force goes with the step, that of its slope, too; what
    /// stays is a jump.
    pub fn of(force: &dyn Fn(f64) -> Result<Vector3<f64>>, points: usize) -> Result<Self> {
        let step = 1.0 / points as f64;
        let forces: Result<Vec<_>> = (0..=points).map(|i| force(i as f64 * step)).collect();
        let Ok(forces) = forces else {
            return Ok(Course::Refused);
        };
        let largest = forces.iter().map(|f| f.norm()).fold(0.0, f64::max);
        let steepest = forces
            .windows(2)
            .map(|w| (w[1] - w[0]).norm() / step)
            .fold(0.0, f64::max);
        // Fourth differences: those of a smooth force are far below what a kink or a jump leaves in them.
        let fourth = |w: &[Vector3<f64>]| w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
        let norms = forces.windows(5).map(|w| fourth(w).norm());
        let mut spots: Vec<(f64, usize)> = norms.zip(2..).collect();
        spots.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut jump, mut kink) = (0.0_f64, 0.0_f64);
        for &(_, i) in spots.iter().take(SPOTS) {
            let mut h = step;
            let mut at = [forces[i - 1], forces[i], forces[i + 1]];
            let mut x = i as f64 * step;
            for halving in 1..=HALVINGS {
                h *= 0.5;
                let [a, m, b] = at;
                let all = [a, force(x - h)?, m, force(x + h)?, b];
                let bends = [1, 2, 3].map(|k| all[k - 1] - 2.0 * all[k] + all[k + 1]);
                // Of a smooth force all three are nearly the same; a kink or a jump is in two at most.
                let calm = bends
                    .into_iter()
                    .min_by(|p, q| p.norm().total_cmp(&q.norm()));
                let over = |k: usize| (bends[k] - calm.unwrap_or_default()).norm();
                let worst = (0..3)
                    .max_by(|&i, &j| over(i).total_cmp(&over(j)))
                    .unwrap_or(1);
                at = [all[worst], all[worst + 1], all[worst + 2]];
                x += h * (worst as f64 - 1.0);
                if halving == CLEAR_OF_ROUNDING {
                    let change = (all[4] - all[3]) - (all[1] - all[0]);
                    kink = kink.max(change.norm() / h / steepest);
                }
            }
            jump = jump.max((at[2] - at[0]).norm() / largest);
        }
        Ok(if jump > JUMP {
            Course::Jump(jump)
        } else if kink > KINK {
            Course::Kink(kink)
        } else {
            Course::Smooth
        })
    }
}

impl std::fmt::Display for Course {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Course::Smooth => f.write_str("smooth"),
            Course::Kink(of) => write!(f, "kink {of:.0e}"),
            Course::Jump(of) => write!(f, "jump {of:.0e}"),
            Course::Refused => f.write_str("refused"),
        }
    }
}

/// Pairs with constant stiffness and with the sampled potential.
fn sampled() -> Result<Vec<(&'static str, &'static str, Subject)>> {
    let [external, internal] = external_and_internal();
    let mut ring_first = internal.clone();
    ring_first.gears.reverse();
    let grid = Spring::grid([10, 7, 9, 16]);
    let drive = Arc::new(FlankTable::new(&grid, Interpolation::Spline)?);
    let both = undamped(LoadedFlank::Both);
    let mut paper = both;
    paper.formulation = Formulation::Paper;
    let mut all = vec![];
    for (name, pair) in [
        ("external", external),
        ("internal", internal),
        ("ring first", ring_first),
    ] {
        let backlash = pair.backlash(pair.center_distance);
        let subject = |element| Subject::new(&pair, element, LoadedFlank::Both, backlash);
        let sampled = |parameters| Element::with_laws(&pair, parameters, drive.clone(), None);
        all.push((name, "constant", subject(Element::new(&pair, &both, None)?)));
        all.push((name, "sampled", subject(sampled(&both)?)));
        all.push((name, "sampled, paper", subject(sampled(&paper)?)));
    }
    Ok(all)
}

/// The element of a pair with its table.
pub fn subject(
    real: &Real,
    formulation: Formulation,
    interpolation: Interpolation,
    flank: LoadedFlank,
) -> Result<Subject> {
    let element = real.element(formulation, interpolation, flank)?;
    Ok(Subject::new(&real.geometry, element, flank, real.gap()))
}

pub fn report(_: &Context, data: &Data) -> Result<()> {
    use Formulation::{Conjugate, Paper};
    use Interpolation::{Linear, Shepard, Spline};
    use LoadedFlank::{Both, Coast, Drive};
    let mut rows = vec![];
    let mut add = |pair: &str, law: &str, flanks: &str, subject: &Subject| -> Result<()> {
        let courses = subject
            .course()?
            .into_iter()
            .map(|course| format!(" | {course}"));
        rows.push(format!(
            "{pair} | {law} | {flanks}{}",
            courses.collect::<String>()
        ));
        Ok(())
    };
    for (pair, law, subject) in sampled()? {
        add(pair, law, "both", &subject)?;
    }
    for real in Real::pairs()? {
        for (name, interpolation) in [("spline", Spline), ("linear", Linear), ("shepard", Shepard)]
        {
            for (flanks, flank) in [("drive", Drive), ("coast", Coast), ("both", Both)] {
                let subject = subject(&real, Conjugate, interpolation, flank)?;
                add(real.name, name, flanks, &subject)?;
            }
        }
        let paper = subject(&real, Paper, Spline, Both)?;
        add(real.name, "spline, paper", "both", &paper)?;
    }
    let head = format!(
        "pair | law | flanks | {}",
        PATHS.map(|path| path.0).join(" | ")
    );
    data.table("continuity", &head, &rows)
}
