//! Writes docs/finite-elements.md with its plots: the finite-element compliance, its error and its cost.
//!
//! `cargo run --release --example finite_elements`, from the root of the repository. With words as arguments, it
//! only prints the chapters whose titles contain one of them. The chapter on cost starts this program again, once
//! per level, so that each has a memory of its own to measure.

mod cases;
mod convergence;
mod cost;
mod held;
mod independent;
mod levels;
#[path = "../speed_accuracy/machine.rs"]
mod machine;
mod mesh_picture;
mod method;
mod page;
mod paper;
mod plane;
#[path = "../stability/plot.rs"]
mod plot;
mod properties;

use cases::Models;
use page::Outcome;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

/// One chapter: the text from its measurements; plots go to the folder.
type Chapter = fn(&Models, &Path) -> Outcome<String>;

const CHAPTERS: [(&str, Chapter); 9] = [
    ("Model", method::report),
    ("Against plane-strain numbers from elsewhere", plane::report),
    (
        "Against an independent three-dimensional program",
        independent::report,
    ),
    ("Convergence", convergence::report),
    ("Where the gear is held", held::report),
    ("The paper's pair", paper::report),
    ("Load, misalignment and centre distance", properties::report),
    ("Levels of detail of the shipped pairs", levels::report),
    ("Cost", cost::report),
];

fn main() -> Outcome<()> {
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, pair, level] = &chosen[..]
        && flag == cost::MEASURE
    {
        return cost::measure(pair, level);
    }
    let docs = Path::new("docs");
    let plots = docs.join("finite-elements");
    std::fs::create_dir_all(&plots)?;
    let models = Models::default();
    let mut text = format!(
        "# Finite-element compliance: model, error and cost\n\nWritten by `cargo run --release --example \
         finite_elements` (`make report` runs it, too); every number comes from that run. Torques are those on \
         gear 1, transmission errors (STE) those on the line of action at mid-face.\n\n{}\n",
        machine::description()
    );
    let start = Instant::now();
    for (title, chapter) in CHAPTERS {
        if !chosen.is_empty() && !chosen.iter().any(|word| title.contains(word.as_str())) {
            continue;
        }
        eprintln!("[{:6.1} s] {title}", start.elapsed().as_secs_f64());
        let body = chapter(&models, &plots)?;
        if chosen.is_empty() {
            write!(text, "\n## {title}\n\n{}\n", body.trim())?;
        } else {
            println!("## {title}\n\n{body}");
        }
    }
    if chosen.is_empty() {
        let part = docs.join("finite-elements.md.part");
        std::fs::write(&part, text)?;
        std::fs::rename(part, docs.join("finite-elements.md"))?;
    }
    eprintln!("[{:6.1} s] done", start.elapsed().as_secs_f64());
    Ok(())
}
