//! Writes docs/speed-accuracy.md with its plots: what tables, interpolants, effects, hosts and steps cost
//! in time and in error.
//!
//! `cargo run --release --example speed_accuracy -- [--quick] [--levels] [DOCS [PYTHON]]`, from the root of the
//! repository; DOCS is `docs` and PYTHON `.venv/bin/python` unless given. `--quick` takes fewer points and
//! coarser finite elements: for trying out, not for the record. `--levels` writes the last section alone, the levels of detail, to
//! another DOCS.

mod document;
#[path = "../common/driver/mod.rs"]
mod driver;
mod effects;
mod floor;
mod growth;
mod hosts;
mod interpolants;
mod levels;
mod machine;
mod plot;
mod poses;
mod preprocessing;
mod run_up;
mod setting;
mod timing;
mod whole_element;

use document::{Document, Error};
use gearmesh::contact::CycleInput;
use gearmesh::gear::Flank;
use gearmesh::pair::Refinement;
use setting::Setting;
use std::path::Path;

/// Pair of the report.
const PAIR: &str = "resources/pairs/palermo2013.json";
/// Its unmodified version, for the run-up.
const UNMODIFIED: &str = "resources/pairs/palermo2013-unmodified.json";
/// A spur pair.
const SPUR: &str = "resources/pairs/fzg-c.json";

/// A mesh cycle at nominal centre distance and parallel axes; torque and positions are the caller's.
fn nominal_cycle() -> CycleInput {
    CycleInput {
        flank: Flank::Drive,
        torque: 0.0,
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions: 1,
    }
}

fn main() -> Result<(), Error> {
    let (flags, paths): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|a| a.starts_with("--"));
    let known = ["--quick", "--levels"];
    if let Some(unknown) = flags.iter().find(|f| !known.contains(&f.as_str())) {
        return Err(format!("{unknown}: the options are {}", known.join(" and ")).into());
    }
    let [quick, levels] = known.map(|option| flags.iter().any(|f| f == option));
    let folder = paths.first().map_or("docs", String::as_str);
    if levels {
        if paths.is_empty() || folder == "docs" {
            return Err("--levels writes a page of this section alone: name a folder for it other than docs".into());
        }
        let mut document = Document::new(Path::new(folder), "Levels of detail")?;
        levels_of_detail(&mut document, quick)?;
        eprintln!("Wrote {}", document.save()?.display());
        return Ok(());
    }
    let python = paths.get(1).map_or(".venv/bin/python", String::as_str);
    let library = library()?;

    let mut document = Document::new(Path::new(folder), "Speed against accuracy")?;
    document.paragraph(
        "Written by `make report` (examples/speed_accuracy) with plots and numbers from the code as it is.",
    );
    document.paragraph(&machine::description());
    document.paragraph(&format!(
        "Method: times are medians of {} rounds in one process, in which all candidates of a table take \
         turns, each with an untimed run first, so that every ratio belongs to one run; one thread. Errors are against direct solutions of \
         static tooth contact at held-out random operating points, {} per scene. Pair: {PAIR}.{}",
        timing::ROUNDS,
        points(quick),
        if quick {
            " A run with `--quick`: fewer points, half the mesh positions, coarse finite elements."
        } else {
            ""
        },
    ));
    let setting = Setting::new(PAIR, Refinement::Coarse)?;
    let counts = [16, 9, 17, if quick { 32 } else { 64 }];
    eprintln!("Samples of the contact solver");
    let samples = setting.samples(counts)?;

    let outcomes = interpolants::measure(&setting, &samples, points(quick))?;
    interpolants::report(&mut document, &outcomes)?;
    document.save()?;
    whole_element::report(&mut document, &setting, &samples, points(quick))?;
    document.save()?;
    let spur = Setting::new(SPUR, Refinement::Coarse)?;
    effects::report(&mut document, &setting, &spur, &samples, points(quick))?;
    document.save()?;
    growth::report(&mut document, &setting, &samples)?;
    document.save()?;
    hosts::report(&mut document, &setting, &samples, &library, python)?;
    document.save()?;
    run_up::report(
        &mut document,
        &Setting::new(UNMODIFIED, Refinement::Coarse)?,
    )?;
    document.save()?;
    let levels = [
        (Refinement::Coarse, "coarse"),
        (Refinement::Normal, "normal"),
    ];
    let levels = &levels[..if quick { 1 } else { 2 }];
    preprocessing::report(&mut document, PAIR, levels, points(quick))?;
    document.save()?;
    levels_of_detail(&mut document, quick)?;
    let path = document.save()?;
    eprintln!("Wrote {}", path.display());
    Ok(())
}

/// The section on levels of detail.
fn levels_of_detail(document: &mut Document, quick: bool) -> Result<(), Error> {
    let refinements = [
        (Refinement::Coarse, "coarse"),
        (Refinement::Normal, "normal"),
        (Refinement::Fine, "fine"),
    ];
    let (refinements, counts) = if quick {
        (&refinements[..2], [8, 5, 9, 16])
    } else {
        (&refinements[..], [12, 5, 17, 32])
    };
    levels::report(document, PAIR, refinements, counts)
}

/// Held-out points per scene.
fn points(quick: bool) -> usize {
    if quick { 200 } else { 1000 }
}

/// The unit's library that cargo put beside this program's folder.
fn library() -> Result<std::path::PathBuf, Error> {
    let program = std::env::current_exe()?;
    let name = format!(
        "{}gearmesh{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    let path = program
        .parent()
        .and_then(Path::parent)
        .map(|release| release.join(name))
        .filter(|p| p.exists());
    path.ok_or_else(|| "the unit's library is missing: run `cargo build --release` first".into())
}
