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

    /// Largest second difference of the force vector over `n` points of `path`, over its largest force, and
    /// the tangential force along it.
    fn roughness(
        &self,
        path: fn(&Self, f64) -> Inputs,
        n: usize,
    ) -> Result<(f64, Vec<(f64, f64)>)> {
        let latch = self.element.latch(&self.element.nominal_inputs())?;
        let mut curve = Vec::with_capacity(n + 1);
        let mut forces = Vec::with_capacity(n + 1);
        for i in 0..=n {
            let x = i as f64 / n as f64;
            let out = self.element.evaluate(&latch, &path(self, x))?;
            curve.push((x, out.tangential_force));
            forces.push(out.force[1]);
        }
        let scale = forces.iter().map(|f| f.norm()).fold(1.0, f64::max);
        let worst = forces
            .windows(3)
            .map(|w| (w[0] - 2.0 * w[1] + w[2]).norm())
            .fold(0.0, f64::max);
        Ok((worst / scale, curve))
    }

    /// The cells of one row.
    fn row(&self) -> Result<String> {
        let mut row = String::new();
        for (_, path) in PATHS {
            let (coarse, _) = self.roughness(path, 4000)?;
            let (fine, _) = self.roughness(path, 16_000)?;
            write!(row, " {coarse:.0e} ({:.1}) |", coarse / fine)?;
        }
        Ok(row)
    }
}

/// The chapter.
pub fn report(folder: &Path) -> crate::Outcome {
    let mut text = String::from(
        "Largest second difference of the force vector along a path of 4000 points, over the largest force; in brackets by how much 16 000 \
         points make it smaller: 16 where the force is smooth, 4 at a kink, 1 at a jump (or where nothing but rounding is left: 1e-9 and \
         below). The paths leave the tables' range of centre distance (0.1 mm) and misalignment. `sampled`: the potential of \
         `table::samples::Spring`, spline. Elastic force alone, all effects on.\n\n| pair | law | flanks |",
    );
    for (name, _) in PATHS {
        write!(text, " {name} |")?;
    }
    text.push_str("\n|---|---|---|---|---|---|---|---|\n");
    let mut lines = Vec::new();
    let pairs: [(&str, PairGeometry); 3] = [
        ("external", pair::external()),
        ("internal", pair::internal()),
        ("ring first", pair::ring_first()),
    ];
    let grid = Spring::grid([10, 7, 9, 16]);
    let drive = Arc::new(FlankTable::new(&grid, Interpolation::Spline)?);
    let laws = FlankLaws { drive, coast: None };
    let both = LoadedFlank::Both;
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
            writeln!(text, "| {name} | {law} | both |{}", subject.row()?)?;
            if law == "constant" {
                let (_, points) = subject.roughness(PATHS[1].1, 4000)?;
                lines.push(Line {
                    name: (*name).into(),
                    points,
                });
            }
        }
    }
    for real in Real::pairs()? {
        use Interpolation::{Linear, Shepard, Spline};
        let mut choices: Vec<(Formulation, Interpolation, LoadedFlank)> = Vec::new();
        for interpolation in [Spline, Linear, Shepard] {
            for flank in [LoadedFlank::Drive, LoadedFlank::Coast, both] {
                choices.push((Formulation::Conjugate, interpolation, flank));
            }
        }
        choices.push((Formulation::Paper, Spline, both));
        let phi = real
            .geometry
            .operating_pressure_angle(real.geometry.center_distance);
        for (formulation, interpolation, flank) in choices {
            let element = real.element(formulation, interpolation, flank)?;
            let subject = Subject::new(&real.geometry, element, flank, BACKLASH * phi.cos());
            let paper = if formulation == Formulation::Paper {
                ", paper"
            } else {
                ""
            };
            let law = format!("{interpolation:?}{paper}").to_lowercase();
            let flanks = format!("{flank:?}").to_lowercase();
            writeln!(
                text,
                "| {} | {law} | {flanks} |{}",
                real.name,
                subject.row()?
            )?;
        }
    }
    text.push_str(
        "\nThe force over the displacement (first path) has no jump with any interpolant, and none with the spline and Shepard's method \
         anywhere. The linear interpolant has a potential with kinks at the nodes of centre distance, misalignment and mesh position, so its \
         side terms dW/dC, dW/dM and dW/dPMC jump there; its force on the line of action does not.\n",
    );
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
