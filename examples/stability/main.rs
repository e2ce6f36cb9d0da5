//! Regenerates docs/stability.md with its plots:
//! `cargo run --release --example stability`. With words as arguments, it only prints the
//! chapters whose titles contain one of them.

mod continuity;
mod cosimulation;
#[path = "../common/driver/mod.rs"]
mod driver;
mod energy;
mod experiment;
mod hard;
mod oscillator;
mod pair;
mod plot;
mod poses;
mod rattle;
mod tables;

use gearmesh::storage::write_whole;
use std::fmt::Write as _;
use std::path::Path;

/// Result of one experiment: text for the report.
type Outcome = Result<String, Box<dyn std::error::Error>>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let docs = Path::new("docs");
    std::fs::create_dir_all(docs.join("stability"))?;
    type Chapter = fn(&Path) -> Outcome;
    let chapters: [(&str, Chapter); 6] = [
        ("Energy on closed loops and in long runs", energy::report),
        ("Nonlinear cases with known answers", oscillator::report),
        ("Rattle of an idle gear", rattle::report),
        ("Explicit co-simulation", cosimulation::report),
        ("Hard cases", hard::report),
        ("Continuity of the force", continuity::report),
    ];
    let mut text = String::from(
        "# Stability of the element\n\nWritten by `cargo run --release --example stability`; every number \
         below comes from that run (`make report` runs it, too).\n",
    );
    let start = std::time::Instant::now();
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    for (title, chapter) in chapters {
        eprintln!("[{:6.1} s] {title}", start.elapsed().as_secs_f64());
        if !chosen.is_empty() {
            if chosen.iter().any(|word| title.contains(word.as_str())) {
                println!("{}", chapter(&docs.join("stability"))?);
            }
            continue;
        }
        write!(
            text,
            "\n## {title}\n\n{}",
            chapter(&docs.join("stability"))?
        )?;
    }
    if !chosen.is_empty() {
        return Ok(());
    }
    write_whole(&docs.join("stability.md"), text.as_bytes())?;
    eprintln!(
        "[{:6.1} s] docs/stability.md",
        start.elapsed().as_secs_f64()
    );
    Ok(())
}
