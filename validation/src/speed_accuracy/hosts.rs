//! One step of the unit as hosts call it: from C, from ctypes, through fmpy.

use super::Sampled;
use crate::page::{Page, fixed};
use crate::{Context, Result, in_repository, row};
use gearmesh_preprocessor::package::{self, Contents, Library, Starts};

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
}

pub fn report(context: &Context, page: &mut Page) -> Result<()> {
    let Sampled { setup, grid } = Sampled::of(context)?;
    let (geometry, name) = (&setup.pair.geometry, setup.pair.name.as_str());
    let name_of_library = format!("{}gearmesh{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let library = std::env::current_exe()?.with_file_name(name_of_library);
    let library = Library::read(&library).map_err(|e| format!("{e}; `cargo build --release` makes it"))?;
    let folder = tempfile::tempdir()?;
    let tables = setup.file(grid);
    let spring = Starts::constant_stiffness(geometry, setup.pair.operating.nominal_torque);
    let mut rows = vec![];
    for (kind, tables, starts) in
        [("constant stiffness", None, &spring), ("4-D spline table", Some(&tables), &Starts::of_tables(&tables)?)]
    {
        let unit = folder.path().join(format!("{}.fmu", rows.len()));
        let contents = Contents { name, geometry, tables, contact: None, starts };
        package::pack(&contents, std::slice::from_ref(&library), &unit)?;
        let mut python = std::process::Command::new(&context.python);
        python.arg("benches/fmu_step.py").arg(&unit).current_dir(in_repository("."));
        let answer = python.stderr(std::process::Stdio::inherit()).output();
        let answer = answer.map_err(|e| format!("{}: {e}; `make setup` installs what is needed", context.python))?;
        if !answer.status.success() {
            return Err(format!("benches/fmu_step.py: {}", answer.status).into());
        }
        let steps: Steps = serde_json::from_slice(&answer.stdout)?;
        if steps.moment == 0.0 {
            return Err("the steps of benches/fmu_step.c were out of contact".into());
        }
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
    page.table("hosts", &head, &rows)
}
