//! One step of the unit as hosts call it: from C, from ctypes, through fmpy.

use super::Sampled;
use crate::data::{Data, fixed};
use crate::stability::last_that_holds;
use crate::{Context, Result, in_repository, row};
use gearmesh::table::TableFile;
use gearmesh_preprocessor::package::{self, Contents, Library, Starts};
use std::path::Path;

/// What benches/fmu_step.py prints; `empty` is of the unit that computes nothing.
#[derive(serde::Deserialize)]
struct Steps {
    inputs: usize,
    outputs: usize,
    moment: f64,
    c: f64,
    c_instructions: Option<f64>,
    empty: f64,
    empty_instructions: Option<f64>,
    ctypes: f64,
    fmpy: f64,
    value_by_value: f64,
    libcosim: f64,
    ecos: f64,
}

/// What benches/fmu_step.py finds for the packed `unit`.
fn steps(context: &Context, unit: &Path) -> Result<Steps> {
    let mut python = std::process::Command::new(&context.python);
    python.arg("benches/fmu_step.py").arg(unit).current_dir(in_repository("."));
    let answer = python.stderr(std::process::Stdio::inherit()).output();
    let answer = answer
        .map_err(|e| format!("{}: {e}; `make .venv/.examples-complete` installs what is needed", context.python))?;
    if !answer.status.success() {
        return Err(format!("benches/fmu_step.py: {}", answer.status).into());
    }
    let steps: Steps = serde_json::from_slice(&answer.stdout)?;
    if steps.moment == 0.0 {
        return Err("the steps of benches/fmu_step.c were out of contact".into());
    }
    Ok(steps)
}

/// The unit's library, built beside this program.
fn library() -> Result<Library> {
    let name = format!("{}gearmesh{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let library = std::env::current_exe()?.with_file_name(name);
    Library::read(&library).map_err(|e| format!("{e}; `cargo build --release` makes it").into())
}

/// Error of the transmission error that a second of simulated time may bring.
const BEARABLE: f64 = 0.01;

/// What a simulated second costs at an error of [`BEARABLE`], by coupling: steps as long as that allows, times their duration.
pub fn cost(context: &Context, data: &Data) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut rows = vec![];
    for name in ["palermo2013", "helical-25-47"] {
        let tables = TableFile::read(in_repository(&format!("resources/tables/{name}.json")))?;
        let geometry = tables.geometry.clone();
        for coupling in ["held", "sequential", "parallel"] {
            let starts = Starts::of_tables(&tables)?.with(&[format!("coupling={coupling}").parse()?]);
            let contents =
                Contents { name, geometry: &geometry, tables: Some(&tables), contact: None, starts: &starts };
            let path = folder.path().join(format!("{name}-{coupling}.fmu"));
            package::pack(&contents, &[library()?], &path)?;
            let unit = package::inspect(&path)?.unit;
            let bears =
                |step: f64| package::step_error(&unit, Some(&tables), step).is_some_and(|error| error < BEARABLE);
            let [longest, _] = last_that_holds([1e-7_f64.ln(), 1e-4_f64.ln()], 10, |step| Ok(bears(step.exp())))?;
            let longest = longest.exp();
            let found = steps(context, &path)?;
            let seconds =
                [found.c, found.ctypes, found.fmpy, found.libcosim, found.ecos].map(|ns| fixed(1e-9 * ns / longest, 2));
            rows.push([row![name, coupling, fixed(1e6 * longest, 2), fixed(found.c, 0)], seconds.to_vec()].concat());
        }
    }
    let head = [
        "pair",
        "coupling",
        "step at 1 %, us",
        "C, ns a step",
        "C, s",
        "ctypes, s",
        "fmpy, s",
        "libcosim, s",
        "Ecos, s",
    ];
    data.table("cost-per-second", &head, &rows)
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let Sampled { setup, grid } = Sampled::of(context)?;
    let (geometry, name) = (&setup.pair.geometry, setup.pair.name.as_str());
    let folder = tempfile::tempdir()?;
    let tables = setup.file(grid);
    let spring = Starts::constant_stiffness(geometry, setup.pair.operating.nominal_torque);
    let mut rows = vec![];
    for (kind, tables, starts) in
        [("constant stiffness", None, &spring), ("4-D spline table", Some(&tables), &Starts::of_tables(&tables)?)]
    {
        let unit = folder.path().join(format!("{}.fmu", rows.len()));
        // One evaluation a step, as with every host that is no master.
        let starts = starts.clone().with(&["coupling=held".parse()?]);
        let contents = Contents { name, geometry, tables, contact: None, starts: &starts };
        package::pack(&contents, &[library()?], &unit)?;
        let steps = steps(context, &unit)?;
        let instructions = steps.c_instructions.zip(steps.empty_instructions);
        let instructions = instructions.map_or("-".into(), |(unit, empty)| fixed(unit / empty, 1));
        let block = format!("{kind}, {} inputs, {} outputs", steps.inputs, steps.outputs);
        let python = [steps.ctypes, steps.fmpy, steps.value_by_value].map(|ns| fixed(ns, 0));
        rows.push(
            [row![block, fixed(steps.c, 0), fixed(steps.c / steps.empty, 1), instructions], python.to_vec()].concat(),
        );
    }
    let head = [
        "unit",
        "C, ns",
        "times an empty unit, by time",
        "by instructions",
        "ctypes, ns",
        "fmpy, ns",
        "fmpy value by value, ns",
    ];
    data.table("hosts", &head, &rows)
}
