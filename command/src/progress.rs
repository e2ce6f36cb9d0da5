//! Progress of a command on standard error: a bar on a terminal, else a line now and then.
//!
//! The bar is that of the stage at work. How long a stage takes on the machine at hand is not known before it has begun.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};

/// The work of a command; its bar disappears when it is dropped.
pub struct Job {
    bar: Option<ProgressBar>,
    begin: Instant,
    state: Mutex<State>,
}

struct State {
    /// What is at work, since when, and the share of it that is done.
    stage: String,
    since: Instant,
    share: f64,
    last_line: Instant,
}

/// Resolution of the bar.
const FULL: u64 = 1000;

/// Time between two lines where there is no terminal; short work says nothing.
const EVERY: Duration = Duration::from_secs(10);

impl Job {
    /// Work whose progress is shown, unless `quiet`.
    pub fn new(quiet: bool) -> Job {
        let bar = (!quiet).then(|| {
            let style = ProgressStyle::with_template("[{bar:30}] {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar())
                .progress_chars("=> ");
            // Hides itself where standard error is no terminal.
            ProgressBar::with_draw_target(Some(FULL), ProgressDrawTarget::stderr())
                .with_style(style)
                .with_finish(ProgressFinish::AndClear)
        });
        let now = Instant::now();
        Job {
            bar,
            begin: now,
            state: Mutex::new(State {
                stage: String::new(),
                since: now,
                share: 0.0,
                last_line: now,
            }),
        }
    }

    /// `share` (0 to 1) of `stage` is done; `detail` may say of how much.
    pub fn tell(&self, stage: &str, share: f64, detail: &str) {
        let Some(bar) = &self.bar else { return };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.stage != stage {
            state.stage = stage.into();
            state.since = Instant::now();
            state.share = 0.0;
        }
        // Threads report out of order.
        state.share = state.share.max(share.clamp(0.0, 1.0));
        let text = text(self.begin.elapsed(), &state, detail);
        if bar.is_hidden() && state.last_line.elapsed() >= EVERY {
            state.last_line = Instant::now();
            eprintln!("gearmesh: {text}");
        }
        bar.set_message(text);
        bar.set_position((state.share * FULL as f64) as u64);
    }
}

fn text(elapsed: Duration, state: &State, detail: &str) -> String {
    let State { stage, share, .. } = state;
    let comma = if detail.is_empty() { "" } else { ", " };
    format!(
        "after {}: {stage}, {:.0} %{comma}{detail}{}",
        clock(elapsed),
        100.0 * share,
        left(state.since.elapsed(), *share)
    )
}

/// What is left of a stage if the rest of it goes as what is done went; nothing as long as that says little, or at
/// the end.
fn left(elapsed: Duration, share: f64) -> String {
    if !(0.02..1.0).contains(&share) || elapsed < Duration::from_secs(2) {
        return String::new();
    }
    let rest = elapsed.as_secs_f64() * (1.0 - share) / share;
    format!(
        ", about {} left of it",
        clock(Duration::from_secs_f64(rest))
    )
}

/// A time as people read it.
fn clock(time: Duration) -> String {
    match time.as_secs_f64().round() as u64 {
        s @ 0..60 => format!("{s} s"),
        s @ 60..3600 => format!("{} min {} s", s / 60, s % 60),
        s => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_begins_at_nothing_and_does_not_go_back() {
        let job = Job::new(false);
        let share = || job.state.lock().unwrap().share;
        job.tell("elastic model of gear 1", 0.9, "");
        job.tell("contact", 0.5, "");
        job.tell("contact", 0.4, "");
        assert_eq!(share(), 0.5);
        job.tell("model of the fillets", 0.1, "");
        assert_eq!(share(), 0.1);
    }

    #[test]
    fn the_time_left_is_that_of_the_stage_at_work_whatever_went_before() {
        let now = Instant::now();
        let state = State {
            stage: "model of the fillets of gear 1".into(),
            since: now.checked_sub(Duration::from_secs(40)).unwrap(),
            share: 0.2,
            last_line: now,
        };
        assert_eq!(
            text(Duration::from_secs(100), &state, "3 of 15 solves"),
            "after 1 min 40 s: model of the fillets of gear 1, 20 %, 3 of 15 solves, about 2 min 40 s left of it"
        );
        for share in [0.001, 1.0] {
            assert_eq!(left(Duration::from_secs(10), share), "");
        }
    }

    #[test]
    fn times_are_told_in_minutes_and_hours() {
        let of = |seconds| clock(Duration::from_secs(seconds));
        assert_eq!(
            [of(59), of(61), of(7260)],
            ["59 s", "1 min 1 s", "2 h 1 min"]
        );
    }
}
