//! Progress of a command on standard error: a bar on a terminal, else a line now and then.
//!
//! The bar is that of the stage at work, and so is the time left. How long a stage takes on the machine at hand is not known
//! before it has begun.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The work of a command; its bar disappears when it is dropped.
pub struct Job {
    bar: ProgressBar,
    quiet: bool,
    /// What is at work, and when the last line was printed.
    stage: Mutex<(String, Instant)>,
}

const FULL: u64 = 1000;

/// Time between two lines where there is no terminal; short work says nothing.
const EVERY: Duration = Duration::from_secs(10);

impl Job {
    /// Work whose progress is shown, unless `quiet`.
    pub fn new(quiet: bool) -> Job {
        // Hides itself where standard error is no terminal.
        let target = match quiet {
            true => ProgressDrawTarget::hidden(),
            false => ProgressDrawTarget::stderr(),
        };
        let bar = ProgressBar::with_draw_target(Some(FULL), target);
        let template = "[{bar:30}] after {elapsed}: {msg}, {percent} %, about {eta} left of it";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        Job {
            bar,
            quiet,
            stage: Mutex::new((String::new(), Instant::now())),
        }
    }

    /// `share` (0 to 1) of `stage` is done; a share that falls far begins the stage anew.
    pub fn tell(&self, stage: &str, share: f64) {
        let mut now = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        let done = (share.clamp(0.0, 1.0) * FULL as f64) as u64;
        if now.0 != stage || 2 * done < self.bar.position() {
            now.0 = stage.into();
            self.bar.set_message(now.0.clone());
            self.bar.set_position(0);
            self.bar.reset_eta();
        }
        // Threads report out of order.
        self.bar.set_position(done.max(self.bar.position()));
        if self.bar.is_hidden() && !self.quiet && now.1.elapsed() >= EVERY {
            now.1 = Instant::now();
            let [elapsed, left] = [self.bar.elapsed(), self.bar.eta()].map(HumanDuration);
            eprintln!(
                "gearmesh: after {elapsed}: {stage}, {:.0} %, about {left} left of it",
                100.0 * share
            );
        }
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_begins_at_nothing_and_does_not_go_back() {
        let job = Job::new(true);
        job.tell("elastic model of gear 1", 0.9);
        job.tell("contact", 0.5);
        job.tell("contact", 0.4);
        assert_eq!(job.bar.position(), 500);
        job.tell("contact", 0.1);
        assert_eq!(job.bar.position(), 100);
        job.tell("model of the fillets", 0.1);
        assert_eq!(job.bar.position(), 100);
    }
}
