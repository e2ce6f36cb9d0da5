//! One step of the unit as hosts call it: from C, from ctypes, through fmpy.

use crate::document::{Document, Error};
use crate::setting::Setting;
use gearmesh::package::{self, Contents, Library, Starts};
use gearmesh::table::FlankGrid;
use std::path::Path;

/// What benches/fmu_step.py prints.
#[derive(serde::Deserialize)]
struct Steps {
    inputs: usize,
    outputs: usize,
    moment: f64,
    c: f64,
    c_instructions: Option<f64>,
    /// The unit that computes nothing.
    empty: f64,
    empty_instructions: Option<f64>,
    ctypes: f64,
    fmpy: f64,
    value_by_value: f64,
}

/// The section. `library` is the compiled unit, `python` the interpreter that has fmpy.
pub fn report(
    document: &mut Document,
    setting: &Setting,
    samples: &FlankGrid,
    library: &Path,
    python: &str,
) -> Result<(), Error> {
    document.section("One step of the FMU from its hosts");
    let folder = tempfile::tempdir()?;
    let mut rows = vec![];
    let mut block = String::new();
    let spring = Starts::constant_stiffness(
        &setting.pair.geometry,
        setting.pair.operating.nominal_torque,
    );
    let tables = setting.file(samples);
    let starts = Starts::of_tables(&tables)?;
    for (name, tables, starts) in [
        ("constant stiffness", None, &spring),
        ("4-D spline table", Some(&tables), &starts),
    ] {
        let contents = Contents {
            name: &setting.pair.name,
            geometry: &setting.pair.geometry,
            tables,
            contact: None,
            starts,
        };
        let unit = folder.path().join(format!("{}.fmu", rows.len()));
        package::pack(&contents, &[Library::read(library)?], &unit)?;
        let answer = std::process::Command::new(python)
            .arg("benches/fmu_step.py")
            .arg(&unit)
            .stderr(std::process::Stdio::inherit())
            .output()
            .map_err(|e| format!("{python}: {e}; `make setup` installs what is needed"))?;
        if !answer.status.success() {
            return Err(format!("benches/fmu_step.py: {}", answer.status).into());
        }
        let steps: Steps = serde_json::from_slice(&answer.stdout)?;
        if steps.moment == 0.0 {
            return Err("the steps of benches/fmu_step.c were out of contact".into());
        }
        rows.push([
            name.to_owned(),
            format!("{:.0}", steps.c),
            format!("{:.1}", steps.c / steps.empty),
            steps
                .c_instructions
                .zip(steps.empty_instructions)
                .map_or_else(
                    || "-".to_owned(),
                    |(unit, empty)| format!("{:.1}", unit / empty),
                ),
            format!("{:.0}", steps.ctypes),
            format!("{:.0}", steps.fmpy),
            format!("{:.0}", steps.value_by_value),
        ]);
        block = format!(
            "{} Real inputs and {} Real outputs",
            steps.inputs, steps.outputs
        );
    }
    document.paragraph(&format!(
        "One step is fmi2SetReal of all inputs, fmi2DoStep, fmi2GetReal of all main outputs: {block}, one \
         block each, loaded teeth. *C*: benches/fmu_step.c, the library loaded with dlopen. *Empty*: benches/empty_fmu.c, \
         a unit with as many variables that computes nothing, written as the Reference FMUs of the FMI project are. *ctypes*: \
         Python's foreign functions with arrays made beforehand. *fmpy*: FMU2Slave.setReal, doStep, getReal \
         with lists. *Value by value*: the same with one call for each variable."
    ));
    document.table(
        [
            "unit",
            "C, ns",
            "times an empty unit, by time",
            "by instructions",
            "ctypes, ns",
            "fmpy, ns",
            "fmpy value by value, ns",
        ],
        &rows,
    );
    Ok(())
}
