//! Scans of the force for jumps, inside the range of the tables and beyond it.

use crate::pair;
use crate::plot::{Line, Plot};
use crate::poses::{BACKLASH, Real, pose, ratio, spin, undamped};
use gearmesh::element::{
    Element, FlankLaws, Formulation, Inputs, Interpolation, LoadedFlank, Parameters,
};
use gearmesh::gear::PairGeometry;
use gearmesh::table::{FlankTable, samples::Spring};
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Compression of the flank in the scans that do not vary it, m on the line of action.
const PRESS: f64 = 5e-6;

/// A path: its name, and the pose at 0..1 of it.
type Route = (&'static str, fn(&Subject, f64) -> Inputs);

const PATHS: [Route; 5] = [
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
struct Subject {
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
        let latch = self.element.latch(&self.element.nominal_inputs())?;
        Ok(self.element.evaluate(&latch, &path(self, x))?.force[1])
    }

    /// How the force goes along each path.
    fn course(&self) -> Result<Vec<Course>> {
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
enum Course {
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
    fn of(force: &dyn Fn(f64) -> Result<Vector3<f64>>, points: usize) -> Result<Self> {
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
        let mut spots: Vec<(f64, usize)> = forces
            .windows(5)
            .enumerate()
            .map(|(i, w)| {
                let fourth = w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
                (fourth.norm(), i + 2)
            })
            .collect();
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
                    .min_by(|p, q| p.norm().total_cmp(&q.norm()))
                    .unwrap_or_default();
                let worst = (0..3)
                    .max_by(|&i, &j| {
                        let over = |k: usize| (bends[k] - calm).norm();
                        over(i).total_cmp(&over(j))
                    })
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
            Course::Jump(of) => write!(f, "**jump {of:.0e}**"),
            Course::Refused => f.write_str("refused"),
        }
    }
}

/// The courses of one element.
struct Row {
    pair: String,
    law: String,
    flanks: String,
    courses: Vec<Course>,
}

impl Row {
    fn of(pair: &str, law: &str, flanks: &str, subject: &Subject) -> Result<Self> {
        Ok(Row {
            pair: pair.into(),
            law: law.into(),
            flanks: flanks.into(),
            courses: subject.course()?,
        })
    }
}

/// What the rows come to: per law, the paths on which the force jumps.
fn verdict(rows: &[Row]) -> String {
    let mut laws: Vec<&str> = rows.iter().map(|r| r.law.as_str()).collect();
    laws.sort_unstable();
    laws.dedup();
    let jumps = |law: &str| -> Vec<&str> {
        let of_law = || rows.iter().filter(|r| r.law == law);
        (0..PATHS.len())
            .filter(|&i| of_law().any(|r| matches!(r.courses[i], Course::Jump(_))))
            .map(|i| PATHS[i].0)
            .collect()
    };
    let (with, without): (Vec<&str>, Vec<&str>) =
        laws.into_iter().partition(|l| !jumps(l).is_empty());
    let mut text = String::new();
    if !without.is_empty() {
        text += &format!("Without a jump on any path: {}.", without.join("; "));
    }
    for law in with {
        text += &format!(
            " With jumps, {law}: on the paths `{}`.",
            jumps(law).join("`, `")
        );
    }
    text.trim_start().to_owned()
}

/// The chapter.
pub fn report(folder: &Path) -> crate::Outcome {
    let mut text = format!(
        "The force vector along paths of {POINTS} points. At the {SPOTS} spots of a path that are least like a smooth curve \
         the steps are halved {HALVINGS} times. *Jump*: what is then left of the change of the force, over the largest force ({JUMP:.0e} and more); *kink*: jump of \
         the slope, over the largest slope ({KINK:.0e} and more). The paths leave the tables' range of centre distance (0.1 mm) and \
         misalignment; *refused*: one flank alone, and a pose on the path lies behind the other. `sampled`: the potential of `table::samples::Spring`, spline. Elastic force alone, all effects on.\n\n\
         | pair | law | flanks |",
    );
    for (name, _) in PATHS {
        write!(text, " {name} |")?;
    }
    text.push_str("\n|---|---|---|---|---|---|---|---|\n");
    let mut lines = Vec::new();
    let mut rows = sampled_rows(&mut lines)?;
    for real in Real::pairs()? {
        rows.extend(table_rows(&real)?);
    }
    for row in &rows {
        write!(text, "| {} | {} | {} |", row.pair, row.law, row.flanks)?;
        for course in &row.courses {
            write!(text, " {course} |")?;
        }
        text.push('\n');
    }
    writeln!(
        text,
        "\n{}\n\nThe linear interpolant has a potential with kinks at the nodes of centre distance, misalignment and mesh position: \
         its side terms dW/dC, dW/dM and dW/dPMC jump there, its force on the line of action does not.",
        verdict(&rows)
    )?;
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

/// Constant stiffness and the sampled potential; in `lines` the force of the first while the gears part.
fn sampled_rows(lines: &mut Vec<Line>) -> Result<Vec<Row>> {
    let pairs: [(&str, PairGeometry); 3] = [
        ("external", pair::external()),
        ("internal", pair::internal()),
        ("ring first", pair::ring_first()),
    ];
    let grid = Spring::grid([10, 7, 9, 16]);
    let drive = Arc::new(FlankTable::new(&grid, Interpolation::Spline)?);
    let laws = FlankLaws { drive, coast: None };
    let both = LoadedFlank::Both;
    let mut rows = Vec::new();
    for (name, pair) in &pairs {
        let paper = Parameters {
            formulation: Formulation::Paper,
            ..undamped(both)
        };
        let elements = [
            ("constant", Element::new(pair, &undamped(both), None)?),
            ("sampled", Element::with_laws(pair, &undamped(both), &laws)?),
            ("sampled, paper", Element::with_laws(pair, &paper, &laws)?),
        ];
        for (law, element) in elements {
            let gap = pair.backlash(pair.center_distance);
            let subject = Subject::new(pair, element, both, gap);
            rows.push(Row::of(name, law, "both", &subject)?);
            if law == "constant" {
                let latch = subject.element.latch(&subject.element.nominal_inputs())?;
                let point = |i: usize| {
                    let x = i as f64 / POINTS as f64;
                    let out = subject.element.evaluate(&latch, &PATHS[1].1(&subject, x))?;
                    Ok((x, out.tangential_force))
                };
                lines.push(Line {
                    name: (*name).into(),
                    points: (0..=POINTS).map(point).collect::<Result<_>>()?,
                });
            }
        }
    }
    Ok(rows)
}

/// A pair with its table: every interpolant on every choice of flanks, and the paper's formulation.
fn table_rows(real: &Real) -> Result<Vec<Row>> {
    use Interpolation::{Linear, Shepard, Spline};
    use LoadedFlank::{Both, Coast, Drive};
    let mut choices = Vec::new();
    for interpolation in [Spline, Linear, Shepard] {
        for flank in [Drive, Coast, Both] {
            choices.push((Formulation::Conjugate, interpolation, flank));
        }
    }
    choices.push((Formulation::Paper, Spline, Both));
    choices
        .into_iter()
        .map(|(formulation, interpolation, flank)| {
            let (law, subject) = subject(real, formulation, interpolation, flank)?;
            let flanks = format!("{flank:?}").to_lowercase();
            Row::of(real.name, &law, &flanks, &subject)
        })
        .collect()
}

/// The element of a pair with its table, and the name of its law.
fn subject(
    real: &Real,
    formulation: Formulation,
    interpolation: Interpolation,
    flank: LoadedFlank,
) -> Result<(String, Subject)> {
    let element = real.element(formulation, interpolation, flank)?;
    let phi = real
        .geometry
        .operating_pressure_angle(real.geometry.center_distance);
    let paper = if formulation == Formulation::Paper {
        ", paper"
    } else {
        ""
    };
    let law = format!("{interpolation:?}{paper}").to_lowercase();
    Ok((
        law,
        Subject::new(&real.geometry, element, flank, BACKLASH * phi.cos()),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_a_kink_and_a_bend_are_told_apart() {
        // Beside a bend that is much larger over one step of the scan.
        let with = |extra: fn(f64) -> f64| {
            let force = move |x: f64| Ok(Vector3::new(2.0 + (40.0 * x).sin(), extra(x), 1.0));
            Course::of(&force, 500).unwrap()
        };
        assert_eq!(with(|x| x * x), Course::Smooth);
        assert_eq!(with(|x| (x - 0.3).max(0.0).powi(2)), Course::Smooth);
        assert!(
            matches!(with(|x| 0.4 * (x - 0.3217).max(0.0)), Course::Kink(k) if (k / 0.01 - 1.0).abs() < 0.1)
        );
        let step = |x: f64| if x > 0.7123 { 3e-4 } else { 0.0 };
        assert!(matches!(with(step), Course::Jump(j) if (j / 9.5e-5 - 1.0).abs() < 0.1));
    }

    #[test]
    fn on_shipped_tables_spline_and_shepard_jump_nowhere_and_the_linear_force_does_not_over_displacement()
     {
        use Interpolation::{Linear, Shepard, Spline};
        for real in Real::pairs().unwrap() {
            for (formulation, interpolation) in [
                (Formulation::Conjugate, Spline),
                (Formulation::Conjugate, Shepard),
                (Formulation::Paper, Spline),
                (Formulation::Conjugate, Linear),
            ] {
                let (law, subject) =
                    subject(&real, formulation, interpolation, LoadedFlank::Both).unwrap();
                for ((path, _), course) in PATHS.iter().zip(subject.course().unwrap()) {
                    println!("{} {law} {path}: {course}", real.name);
                    let linear_elsewhere = interpolation == Linear && *path != PATHS[0].0;
                    assert!(
                        linear_elsewhere || !matches!(course, Course::Jump(_)),
                        "{}, {law}, {path}: {course}",
                        real.name
                    );
                }
            }
        }
    }
}
