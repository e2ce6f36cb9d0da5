//! `gearmesh inspect FILE`: what is in a file that gearmesh reads or writes.

use std::hint::black_box;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use gearmesh::element::{Parameters, PhaseReference, Workspace};
use gearmesh::fmi::resources::{Resources, UnitFile};
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::table::{InterpolationError, Table, TableFile};
use gearmesh::words::{count, shown};
use gearmesh_preprocessor::package::{self, start_in_words};
use gearmesh_preprocessor::{pair, storage};
use nalgebra::{Rotation3, Vector3};
use serde::de::IgnoredAny;

use crate::columns::{Listing, rows};
use crate::error::Result;
use crate::output;
use crate::pair_summary::{as_json, pair_summary};

/// Show what is in a pair file, in tables or in an FMU.
#[derive(Debug, Args)]
pub struct Inspect {
    /// The file
    file: PathBuf,

    /// JSON of a pair file, with the quantities of a drawing
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub fn run(self) -> Result<()> {
        let name = self.file.display();
        let is_archive = is_archive(&self.file)?;
        let text = match is_archive {
            true => String::new(),
            false => output::read_text(&self.file)?,
        };
        let is_tables = is_tables(&text);
        if self.json && (is_archive || is_tables) {
            refuse!("--json: {name} is no pair file; leave the option out");
        }
        let shown = if is_archive {
            fmu(&self.file)?
        } else if is_tables {
            table_file(&TableFile::from_json(&text).map_err(|e| format!("{name}: {e}"))?)?
        } else {
            // Files that it names are sought in its folder.
            let read = pair::read_with_gauges(&self.file);
            let (pair, gauges) = read.map_err(|e| format!("{name}: {e}"))?;
            match self.json {
                true => format!("{:#}\n", as_json(&pair, gauges)),
                false => pair_summary(&pair, gauges),
            }
        };
        output::print(&shown)
    }
}

/// Whether the file begins as zip archives do.
fn is_archive(path: &Path) -> Result<bool> {
    let mut mark = Vec::new();
    storage::open(path)
        .and_then(|file| file.take(2).read_to_end(&mut mark))
        .map_err(|error| output::unreadable(path, &error))?;
    Ok(mark == b"PK")
}

/// Tables say their format; a pair file does not.
pub fn is_tables(text: &str) -> bool {
    #[derive(serde::Deserialize)]
    struct Marks {
        format: Option<IgnoredAny>,
        axes: Option<IgnoredAny>,
    }
    serde_json::from_str::<Marks>(text)
        .is_ok_and(|marks| marks.format.is_some() && marks.axes.is_some())
}

fn table_file(file: &TableFile) -> Result<String> {
    // Tables that no FMU could use are no tables.
    Table::from_file(file.clone())?;
    let mut rows = Listing::default();
    for (name, value) in file.summary() {
        rows.row(name, value);
    }
    Ok(format!("{}: tables\n{rows}", shown(&file.name)))
}

fn fmu(path: &Path) -> Result<String> {
    let found = package::inspect(path)?;
    let unit = &found.unit;
    let tables = (found.tables.as_deref().map(TableFile::from_json)).transpose()?;
    if (tables.as_ref()).is_some_and(|tables| tables.geometry != unit.geometry) {
        refuse!(
            "{}: its tables are those of another pair; pack the FMU again",
            path.display()
        );
    }
    let contact_error = found.contact.as_ref().and_then(|contact| contact.error);
    let contact_error = contact_error.as_ref();
    let error = level_error(unit, tables.as_ref(), contact_error);
    let mut rows = Listing::default();
    rows! { rows;
        "GUID" => "{}", unit.guid;
        "platforms" => "{}", found.platforms.join(", ");
    }
    let resources = Resources::new(unit.clone(), tables.clone(), found.contact)
        .map_err(|error| format!("{}: {error}", path.display()))?;
    if let Some(time) = evaluation_time(&resources)? {
        let us = 1e6 * time;
        rows! { rows; "time of one evaluation" => "{us:.2} us on this machine, under nominal torque and with the start values below"; }
    }
    let step = found.step_size;
    match package::step_error(unit, tables.as_ref(), step) {
        None => rows.row("communication step", format!("{step:?} s")),
        Some(error) => rows! { rows;
            "communication step" => "{step:?} s; costs {:.2} % rms of the variation of mesh.transmissionError under a load applied \
                 over 2 ms, {:.2} % in steady state", 100.0 * error.run, 100.0 * error.steady;
        },
    }
    if contact_error.is_some() && !error.starts_with("contact:") {
        rows! { rows; "error of contact at run time" => "{}", run_time_error(contact_error); }
    }
    rows.row("error", error);
    for (name, value) in &unit.starts {
        rows.row(format!("start: {name}"), start_in_words(name, *value));
    }
    for (name, size) in &found.files {
        rows.row(format!("file: {name}"), count(*size as usize, "byte"));
    }
    let mut text = format!("{}: FMU\n{rows}", shown(&unit.name));
    if let Some(tables) = &tables {
        text += &format!("\n{}", table_file(tables)?);
    }
    Ok(text)
}

pub fn run_time_error(error: Option<&InterpolationError>) -> String {
    error.map_or("not measured; build the FMU again".into(), |error| {
        format!("{error}; against static contact on more stations, all teeth alike")
    })
}

/// The level that `unit` starts with, and how far its forces were from static contact when the FMU was made; `contact`: at run time.
fn level_error(
    unit: &UnitFile,
    tables: Option<&TableFile>,
    contact: Option<&InterpolationError>,
) -> String {
    let item = |i: usize| start_in_words(VARIABLES[i].name, unit.start(&VARIABLES[i]));
    let level = item(index::STIFFNESS_MODEL);
    let error = match (&*level, tables) {
        ("contact", _) => run_time_error(contact),
        ("teeth", Some(TableFile { teeth: Some(t), .. })) => {
            format!("{} against contact at run time", t.error)
        }
        ("table", Some(tables)) => {
            let error = tables.interpolation_error.map(|error| error.to_string());
            let error = error.unwrap_or("not measured".into());
            let mut less = Vec::new();
            let [distances, misalignments, ..] = tables.axes.lengths();
            for (i, nodes) in [
                (index::LOAD_DEPENDENT, 2),
                (index::CENTER_DISTANCE_EFFECT, distances),
                (index::MISALIGNMENT_EFFECT, misalignments),
            ] {
                if unit.start(&VARIABLES[i]) == 0.0 && nodes > 1 {
                    less.push(format!("{} = false", VARIABLES[i].name));
                }
            }
            if item(index::INTERPOLATION) != "spline" {
                less.push("another interpolation".into());
            }
            match less.join(", ").as_str() {
                "" => error,
                less => format!("{error}; that of the spline with all axes, more with {less}"),
            }
        }
        _ => "not measured: one stiffness for all loads and mesh positions".to_owned(),
    };
    format!("{level}: {error}")
}

/// Rounds, of which the fastest counts: others were interrupted.
const ROUNDS: usize = 11;
const ROUND: Duration = Duration::from_millis(1);
/// Positions over one mesh cycle, so that an evaluation meets another cell than the last one.
const POSITIONS: usize = 64;

/// Time of one evaluation of an FMU with its start values and its nominal torque, s; None if no pose bears that torque.
fn evaluation_time(resources: &Resources) -> Result<Option<f64>> {
    // From any pose: where teeth stand counts for no cost.
    let parameters = Parameters {
        phase_reference: PhaseReference::FromInitialPose,
        ..resources.settings.element
    };
    let element = resources.element(&parameters).map_err(|e| e.to_string())?;
    let nominal = element.nominal_inputs();
    let phase = element.phase_offset(&nominal)?;
    let turned = |spins: [f64; 2]| {
        let mut inputs = nominal;
        for (gear, spin) in inputs.gears.iter_mut().zip(spins) {
            gear.r = *Rotation3::from_axis_angle(&Vector3::z_axis(), spin).matrix();
        }
        inputs
    };
    let bears = |spin: &f64| {
        let outputs = element.evaluate(&phase, &turned([*spin, 0.0]));
        outputs.is_ok_and(|o| o.moment[0].z.abs() >= parameters.nominal_torque)
    };
    // Gear 1 ahead by a micrometre's worth of an angle to a hundredth of a radian, on either flank.
    let spins = (0..60).map(|i| 1e-6 * 1.17f64.powi(i));
    let Some(spin) = spins.flat_map(|spin| [spin, -spin]).find(bears) else {
        return Ok(None);
    };
    let geometry = &resources.unit.geometry;
    let [z1, z2] = [0, 1].map(|i| f64::from(geometry.gears[i].teeth));
    let pose = |i: usize| {
        let turn = std::f64::consts::TAU / z1 * i as f64 / POSITIONS as f64;
        turned([spin + turn, -turn * z1 / (geometry.e() * z2)])
    };
    let poses: Vec<_> = (0..POSITIONS).map(pose).collect();
    let mut next = poses.iter().cycle();
    let mut workspace = Workspace::default();
    let mut run = |count: usize| {
        let begin = Instant::now();
        for inputs in next.by_ref().take(count) {
            // Poses around one that was evaluated.
            let _ = black_box(element.evaluate_from(&phase, black_box(inputs), &mut workspace));
        }
        begin.elapsed()
    };
    let mut count = 1;
    while run(count) < ROUND {
        count *= 2;
    }
    let fastest = (0..ROUNDS).map(|_| run(count)).min();
    Ok(fastest.map(|time| time.as_secs_f64() / count as f64))
}
