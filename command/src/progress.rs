//! Progress of a command on standard error: the stage at work and the time so far, on a terminal in one line that is
//! written over, else in a line now and then.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The work of a command; its line disappears when it is dropped.
pub struct Job {
    line: ProgressBar,
    /// When the last line was printed where there is no terminal; None: quiet.
    printed: Option<Mutex<Instant>>,
}

/// Time between two lines where there is no terminal; short work says nothing.
const EVERY: Duration = Duration::from_secs(10);

impl Job {
    pub fn new(quiet: bool) -> Job {
        // Hides itself where standard error is no terminal.
        let target = match quiet {
            true => ProgressDrawTarget::hidden(),
            false => ProgressDrawTarget::stderr(),
        };
        let line = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("after {elapsed}: {msg}") {
            line.set_style(style);
        }
        Job {
            line,
            printed: (!quiet).then(|| Mutex::new(Instant::now())),
        }
    }

    pub fn show(&self, stage: &str, share: f64) {
        let words = format!("{stage}, {:.0} %", 100.0 * share);
        if let (true, Some(printed)) = (self.line.is_hidden(), &self.printed) {
            let mut printed = printed.lock().unwrap_or_else(PoisonError::into_inner);
            if printed.elapsed() >= EVERY {
                *printed = Instant::now();
                let elapsed = HumanDuration(self.line.elapsed());
                eprintln!("gearmesh: after {elapsed}: {words}");
            }
        }
        self.line.set_message(words);
        self.line.tick();
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        self.line.finish_and_clear();
    }
}
