//! Writes docs/finite-elements.md with its plots: the finite-element compliance, its error and its cost.
//!
//! `cargo run --release --example finite_elements`, from the root of the repository. With words as arguments,
//! only the chapters whose titles contain one of them are measured anew and the others stay as they are in the
//! page. The chapter on cost starts this program again, once per level, so that each has a memory of its own
//! to measure.

mod cases;
mod convergence;
mod cost;
mod held;
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
mod reference;

use cases::Models;
use gearmesh::storage::write_whole;
use page::Outcome;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

/// One chapter: the text from its measurements; plots go to the folder.
type Chapter = fn(&Models, &Path) -> Outcome<String>;

const CHAPTERS: [(&str, Chapter); 9] = [
    ("Model", method::report),
    ("Against plane-strain numbers from elsewhere", plane::report),
    ("Against scripts/contact_reference.py", reference::report),
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
    let page = docs.join("finite-elements.md");
    let before = std::fs::read_to_string(&page).unwrap_or_default();
    let mut text = format!(
        "# Finite-element compliance: model, error and cost\n\nWritten by `cargo run --release --example \
         finite_elements` (`make report` runs it, too); every number comes from there. Torques are those on \
         gear 1, transmission errors (STE) those on the line of action at mid-face.\n\n{}\n",
        machine::description()
    );
    let start = Instant::now();
    for (title, chapter) in CHAPTERS {
        let known = chapter_of(&before, title);
        if !chosen.is_empty() && !chosen.iter().any(|word| title.contains(word.as_str())) {
            if let Some(body) = known {
                write!(text, "\n## {title}\n\n{body}\n")?;
            }
            continue;
        }
        eprintln!("[{:6.1} s] {title}", start.elapsed().as_secs_f64());
        let body = chapter(&models, &plots)?;
        write!(text, "\n## {title}\n\n{}\n", body.trim())?;
    }
    write_whole(&page, text.as_bytes())?;
    eprintln!(
        "[{:6.1} s] docs/finite-elements.md",
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

/// The text under the heading `title` of a page.
fn chapter_of<'a>(page: &'a str, title: &str) -> Option<&'a str> {
    let mut chapters = page.split("\n## ").skip(1);
    chapters.find_map(|chapter| {
        let (heading, body) = chapter.split_once('\n')?;
        (heading == title).then_some(body.trim())
    })
}
