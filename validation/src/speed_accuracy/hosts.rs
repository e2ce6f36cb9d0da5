//! What a simulated second costs as hosts step the FMU: from C, from ctypes, through fmpy and masters.

use crate::data::{Data, last_that_holds};
use crate::{Context, Result, in_repository};
use gearmesh::table::TableFile;
use gearmesh_preprocessor::package::{self, Contents, Library, Starts};
use std::path::Path;
use std::process::{Command, Stdio};

/// What benches/fmu_step.py prints: nanoseconds of a step by host, and the moment of the last one, N m.
#[derive(serde::Deserialize)]
struct Steps {
    moment: f64,
    c: f64,
    ctypes: f64,
    fmpy: f64,
    libcosim: f64,
    ecos: f64,
}

/// What benches/fmu_step.py finds for the packed `fmu`.
fn steps(context: &Context, fmu: &Path) -> Result<Steps> {
    let mut python = Command::new(&context.python);
    python
        .arg("benches/fmu_step.py")
        .arg(fmu)
        .current_dir(in_repository("."));
    let missing = |e| {
        format!(
            "{}: {e}; `make .venv/.examples-complete` installs what is needed",
            context.python
        )
    };
    let answer = python.stderr(Stdio::inherit()).output().map_err(missing)?;
    if !answer.status.success() {
        return Err(format!("benches/fmu_step.py: {}", answer.status).into());
    }
    let steps: Steps = serde_json::from_slice(&answer.stdout)?;
    if steps.moment == 0.0 {
        return Err("the steps of benches/fmu_step.c were out of contact".into());
    }
    Ok(steps)
}

/// The FMU's library, built beside this program.
fn library() -> Result<Library> {
    let name = format!(
        "{}gearmesh{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    let library = std::env::current_exe()?.with_file_name(name);
    Library::read(&library).map_err(|e| format!("{e}; `cargo build --release` makes it").into())
}

/// Error of the transmission error that a second of simulated time may bring.
const BEARABLE: f64 = 0.01;

/// The cost at an error of `BEARABLE`, by coupling: steps as long as that allows, times their duration.
pub fn cost(context: &Context, data: &Data) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut rows = vec![];
    for name in ["palermo2013", "helical-25-47"] {
        let tables = TableFile::read(in_repository(&format!("resources/tables/{name}.json")))?;
        for coupling in ["held", "sequential", "parallel", "automatic"] {
            let contents = Contents {
                name,
                geometry: &tables.geometry,
                contact: None,
                starts: &Starts::of_tables(&tables)?
                    .with(&[format!("coupling={coupling}").parse()?]),
            };
            let path = folder.path().join(format!("{name}-{coupling}.fmu"));
            package::pack(&contents, &[library()?], &path)?;
            let unit = package::inspect(&path)?.unit;
            let bears = |step: f64| {
                let error = package::step_error(&unit, Some(&tables), step.exp());
                Ok(error.is_some_and(|error| error.run < BEARABLE))
            };
            let [longest, _] = last_that_holds([1e-7_f64.ln(), 1e-4_f64.ln()], 10, bears)?;
            let found = steps(context, &path)?;
            let c = found.c;
            let step = longest.exp();
            let mut row = format!("{name} | {coupling} | {:.2} | {c:.0}", 1e6 * step);
            for ns in [c, found.ctypes, found.fmpy, found.libcosim, found.ecos] {
                row += &format!(" | {:.2}", 1e-9 * ns / step);
            }
            rows.push(row);
        }
    }
    let head = "pair | coupling | step at 1 %, us | C, ns a step | C, s | ctypes, s | fmpy, s | libcosim, s | Ecos, s";
    data.table("cost-per-second", head, &rows)
}
