//! Writes the tables of docs/data.

use gearmesh_validation::data::Data;
use gearmesh_validation::{
    Chapter, Context, Result, contact_at_run_time, finite_elements, in_repository, speed_accuracy, stability,
};
use std::path::PathBuf;
use std::time::Instant;

const FOLDERS: [(&str, &[(&str, Chapter)]); 4] = [
    ("stability", &stability::CHAPTERS),
    ("finite-elements", &finite_elements::CHAPTERS),
    ("speed-accuracy", &speed_accuracy::CHAPTERS),
    ("contact-at-run-time", &contact_at_run_time::CHAPTERS),
];

const HELP: &str = "gearmesh-validation [--quick] [--data FOLDER] [--python PROGRAM] [CHAPTER...]

A CHAPTER is FOLDER/CHAPTER or its beginning; without one, all are run. Folders are those of docs/data.

  --quick           fewer points and coarser elements: for trying out, not for the record
  --data FOLDER     where tables go; docs/data unless given
  --python PROGRAM  interpreter that has fmpy; .venv/bin/python unless given
";

fn main() -> Result<()> {
    let mut context = Context { python: ".venv/bin/python".into(), ..Context::default() };
    let mut data = in_repository("docs/data");
    let mut wanted = vec![];
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} takes a value"));
        match argument.as_str() {
            "--quick" => context.quick = true,
            "--data" => data = PathBuf::from(value()?),
            "--python" => context.python = value()?,
            // Of the chapter on cost, which measures memory in a process of its own.
            "--measure" => return finite_elements::cost::measure(&value()?, &value()?),
            "--help" => {
                print!("{HELP}{}", names());
                return Ok(());
            }
            _ if names().lines().any(|name| name.trim().starts_with(&argument)) => wanted.push(argument),
            _ => return Err(format!("{argument}: no such option or chapter; the chapters are\n{}", names()).into()),
        }
    }
    let start = Instant::now();
    for (folder, chapters) in FOLDERS {
        for (chapter, run) in chapters {
            let name = format!("{folder}/{chapter}");
            if wanted.is_empty() || wanted.iter().any(|wanted| name.starts_with(wanted.as_str())) {
                eprintln!("[{:6.1} s] {name}", start.elapsed().as_secs_f64());
                run(&context, &Data(data.join(folder)))?;
            }
        }
    }
    Ok(())
}

/// The chapters, one on each line.
fn names() -> String {
    let of_folder = |(folder, chapters): (&str, &[(&str, Chapter)])| {
        chapters.iter().map(|(chapter, _)| format!("  {folder}/{chapter}\n")).collect::<String>()
    };
    FOLDERS.into_iter().map(of_folder).collect()
}
