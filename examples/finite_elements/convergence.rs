//! Mesh, flank grid, kernel, face stations, layers and coupling: what each changes.

use crate::cases::{self, Models, paper, solver};
use crate::page::{Outcome, percent, table, verdict};
use gearmesh::compliance::finite_element::{
    Discretization, FiniteElementCompliance, PairCompliance, Settings,
};
use gearmesh::compliance::{BeyondModel, Strip, ToothCompliance};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::pair::{Pair, Refinement};
use nalgebra::DMatrix;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

const TORQUE: f64 = 100.0;
const POSITIONS: usize = 32;

/// One setting apart from level normal.
struct Variant {
    name: &'static str,
    sizes: Discretization,
    stations: usize,
}

/// The chapter.
pub fn report(models: &Models, _: &Path) -> Outcome<String> {
    let mut text = String::from(
        "Mesh cycles at 100 N m, 32 positions, contact at tip edges included. Sizes in normal modules; *level normal* is the \
         default. The finest is level fine with twice the stations along the face. Bar: default within 1 % of the finest in \
         the mean, 2 % in the peak-to-peak.\n\n",
    );
    let spur = cases::thick_spur()?;
    let mut swings = vec![];
    for (name, pair) in [
        (
            "Spur pair 20/20, m 4 mm, face 25 mm, bore 30 mm, unmodified",
            spur,
        ),
        (
            "Reference pair (palermo2013-unmodified)",
            paper(false, 30.0)?,
        ),
        ("Reference pair, modified (palermo2013)", paper(true, 30.0)?),
    ] {
        eprintln!("    {name}");
        let (chapter, swing) = one_pair(models, name, &pair)?;
        text += &chapter;
        swings.push(swing);
    }
    text += &format!(
        "The peak-to-peak of the unmodified reference pair is {:.1} times that of the modified one, in which errors of the compliance \
         weigh as many times more. *Neighbours ignored* takes the influence of a loaded tooth on the others out, as models with a \
         single elastic tooth do; all teeth of the gear are real ones in every other row, so there is no row for the size \
         of a sector.\n",
        swings[1] / swings[2]
    );
    Ok(text)
}

fn variants() -> Vec<Variant> {
    let normal = Discretization::of(Refinement::Normal);
    let variant = |name, sizes| Variant {
        name,
        sizes,
        stations: 40,
    };
    vec![
        variant("level coarse", Discretization::of(Refinement::Coarse)),
        variant(
            "section x 2/3",
            Discretization {
                flank_element: normal.flank_element / 1.5,
                tooth_element: normal.tooth_element / 1.5,
                root_element: normal.root_element / 1.5,
                growth: normal.growth.powf(1.0 / 1.5),
                ..normal
            },
        ),
        variant(
            "flank grid alone x 2/3",
            Discretization {
                flank_element: normal.flank_element / 1.5,
                ..normal
            },
        ),
        variant(
            "layers x 2/3",
            Discretization {
                layer: normal.layer / 1.5,
                end_layer: normal.end_layer / 1.5,
                ..normal
            },
        ),
        variant(
            "kernel 0.12",
            Discretization {
                kernel_half_width: 0.12,
                ..normal
            },
        ),
        variant(
            "kernel 0.25",
            Discretization {
                kernel_half_width: 0.25,
                ..normal
            },
        ),
        Variant {
            stations: 20,
            ..variant("20 stations along the face", normal)
        },
        Variant {
            stations: 80,
            ..variant("80 stations along the face", normal)
        },
    ]
}

/// The table of a pair, and its peak-to-peak with the finest model, um.
fn one_pair(models: &Models, name: &str, pair: &Pair) -> Outcome<(String, f64)> {
    let default = Settings::for_pair(pair);
    let stations = |n| ContactSettings {
        stations: n,
        ..ContactSettings::default()
    };
    let cycle = |settings: &Settings, n: usize| -> Outcome<([f64; 2], f64)> {
        let begin = Instant::now();
        let compliance = models.get(pair, settings)?;
        let seconds = begin.elapsed().as_secs_f64();
        let solver = solver(pair, &compliance, stations(n))?;
        Ok((cases::ste(&solver, TORQUE, POSITIONS)?, seconds))
    };
    let fine = Settings {
        discretization: Discretization::of(Refinement::Fine),
        ..default
    };
    let (finest, fine_seconds) = cycle(&fine, 80)?;
    let (normal, normal_seconds) = cycle(&default, 40)?;
    let mut rows = vec![];
    let mut add = |name: &str, found: [f64; 2], seconds: f64| {
        rows.push([
            name.to_owned(),
            format!("{:.4}", found[0]),
            format!("{:.4}", found[1]),
            percent(found[0], finest[0]),
            percent(found[1], finest[1]),
            if seconds > 0.05 {
                format!("{seconds:.1}")
            } else {
                String::new()
            },
        ]);
    };
    add("finest", finest, fine_seconds);
    add("**level normal**", normal, normal_seconds);
    let (found, seconds) = cycle(&fine, 40)?;
    add("level fine", found, seconds);
    for v in variants() {
        let settings = Settings {
            discretization: v.sizes,
            ..default
        };
        let (found, seconds) = cycle(&settings, v.stations)?;
        add(v.name, found, seconds);
    }
    let compliance = models.get(pair, &default)?;
    let alone = ContactSolver::new(pair, single_teeth(&compliance), stations(40))?;
    add(
        "neighbours ignored",
        cases::ste(&alone, TORQUE, POSITIONS)?,
        0.0,
    );
    let error = |k: usize| (normal[k] / finest[k] - 1.0).abs();
    let text = format!(
        "**{name}**: mean {}, peak-to-peak {}.\n\n{}",
        verdict(error(0) <= 1e-2),
        verdict(error(1) <= 2e-2),
        table(
            [
                "setting",
                "mean µm",
                "p-p µm",
                "mean %",
                "p-p %",
                "compliance s, where it is new"
            ],
            &rows
        )
    );
    Ok((text, finest[1]))
}

/// A model without the influence of one tooth on another.
struct SingleTeeth(Arc<FiniteElementCompliance>);

impl ToothCompliance for SingleTeeth {
    fn bulk(&self, strips: &[Strip]) -> Result<DMatrix<f64>, BeyondModel> {
        let mut matrix = self.0.bulk(strips)?;
        for i in 0..strips.len() {
            for j in 0..strips.len() {
                if strips[i].tooth != strips[j].tooth {
                    matrix[(i, j)] = 0.0;
                }
            }
        }
        Ok(matrix)
    }

    fn reference_lengths(&self, strips: &[Strip]) -> Vec<f64> {
        self.0.reference_lengths(strips)
    }
}

fn single_teeth(models: &PairCompliance) -> [Arc<dyn ToothCompliance>; 2] {
    models
        .gears
        .clone()
        .map(|gear| Arc::new(SingleTeeth(gear)) as Arc<dyn ToothCompliance>)
}
