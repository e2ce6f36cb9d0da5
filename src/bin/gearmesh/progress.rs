//! Progress of a whole command on standard error: a bar on a terminal, else a line now and then.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Whether progress is shown.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    quiet: bool,
}

/// A part of a command's work.
#[derive(Debug, Clone)]
pub struct Phase {
    /// What is done, in words of the field.
    pub name: String,
    /// Estimated time, s; only the ratios count.
    pub seconds: f64,
}

/// The work of a command in its order.
#[derive(Debug, Default)]
pub struct Plan {
    phases: Vec<Phase>,
    /// The phase in which contact is solved.
    contact: usize,
    /// The model of the fillets of gear 1, that of gear 2 behind it.
    fillets: usize,
}

/// The work of a command; its bar disappears when it is dropped.
pub struct Job {
    bar: Option<ProgressBar>,
    plan: Plan,
    begin: Instant,
    state: Mutex<State>,
}

struct State {
    /// Share of each phase that is done.
    done: Vec<f64>,
    last_line: Instant,
}

/// Resolution of the bar.
const FULL: u64 = 1000;

/// Time between two lines where there is no terminal; short work says nothing.
const EVERY: Duration = Duration::from_secs(10);

impl Plan {
    /// The elastic models of both gears, which take `elastic` s each, and `contact` by its name and its time, s.
    pub fn new(elastic: [f64; 2], (name, seconds): (&str, f64)) -> Plan {
        let mut phases = of_gears("elastic model", elastic);
        phases.push(Phase {
            name: name.into(),
            seconds,
        });
        Plan {
            phases,
            contact: 2,
            fillets: 0,
        }
    }

    /// The same, and behind it the models of the fillets for the stress in the tooth roots, which take `seconds` s each.
    pub fn then_fillets(mut self, seconds: [f64; 2]) -> Plan {
        self.fillets = self.phases.len();
        self.phases
            .extend(of_gears("model of the fillets", seconds));
        self
    }

    /// The same with the models of the fillets between elastic models and contact.
    pub fn with_fillets(mut self, seconds: [f64; 2]) -> Plan {
        self.fillets = self.contact;
        let models = of_gears("model of the fillets", seconds);
        self.phases.splice(self.contact..self.contact, models);
        self.contact += 2;
        self
    }
}

/// A phase for each gear.
fn of_gears(what: &str, seconds: [f64; 2]) -> Vec<Phase> {
    let phase = |i: usize| Phase {
        name: format!("{what} of gear {}", i + 1),
        seconds: seconds[i],
    };
    vec![phase(0), phase(1)]
}

impl Progress {
    /// Shown, unless `quiet`.
    pub fn new(quiet: bool) -> Self {
        Progress { quiet }
    }

    /// The work of `plan`.
    pub fn job(self, plan: Plan) -> Job {
        let bar = (!self.quiet).then(|| {
            let style = ProgressStyle::with_template("[{bar:30}] {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar())
                .progress_chars("=> ");
            // Hides itself where standard error is no terminal.
            ProgressBar::with_draw_target(Some(FULL), ProgressDrawTarget::stderr())
                .with_style(style)
        });
        let now = Instant::now();
        Job {
            bar,
            begin: now,
            state: Mutex::new(State {
                done: vec![0.0; plan.phases.len()],
                last_line: now,
            }),
            plan,
        }
    }
}

impl Job {
    /// `share` (0 to 1) of the elastic model of gear `gear` (0 or 1) is done; `message` is what is being done.
    pub fn elastic(&self, gear: usize, share: f64, message: &str) {
        self.set(gear, share, message);
    }

    /// Likewise for the model of its fillets.
    pub fn fillets(&self, gear: usize, share: f64, message: &str) {
        self.set(self.plan.fillets + gear, share, message);
    }

    /// Likewise for the contact.
    pub fn contact(&self, share: f64, message: &str) {
        self.set(self.plan.contact, share, message);
    }

    /// Likewise for phase `phase`.
    fn set(&self, phase: usize, share: f64, message: &str) {
        let Some(bar) = &self.bar else { return };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        // A phase that has begun ends those before it.
        state.done[..phase].fill(1.0);
        // Threads report out of order.
        state.done[phase] = state.done[phase].max(share.clamp(0.0, 1.0));
        let whole = whole(&self.plan.phases, &state.done);
        let elapsed = self.begin.elapsed();
        let text = format!(
            "{:.0} % after {}{}: {}, {message}",
            100.0 * whole,
            clock(elapsed),
            left(elapsed, whole),
            self.plan.phases[phase].name,
        );
        if bar.is_hidden() && state.last_line.elapsed() >= EVERY {
            state.last_line = Instant::now();
            eprintln!("gearmesh: {text}");
        }
        bar.set_message(text);
        bar.set_position((whole * FULL as f64) as u64);
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Share of the whole work that is done.
fn whole(phases: &[Phase], done: &[f64]) -> f64 {
    let total: f64 = phases.iter().map(|phase| phase.seconds).sum();
    let done: f64 = phases.iter().zip(done).map(|(p, d)| p.seconds * d).sum();
    if total > 0.0 { done / total } else { 1.0 }
}

/// What is left if the rest goes as what is done went; nothing as long as that says little.
fn left(elapsed: Duration, whole: f64) -> String {
    if whole < 0.02 || elapsed < Duration::from_secs(2) {
        return String::new();
    }
    let rest = elapsed.as_secs_f64() * (1.0 - whole) / whole;
    format!(", about {} left", clock(Duration::from_secs_f64(rest)))
}

/// A time as people read it.
pub fn clock(time: Duration) -> String {
    match time.as_secs_f64().round() as u64 {
        s @ 0..60 => format!("{s} s"),
        s @ 60..3600 => format!("{} min {} s", s / 60, s % 60),
        s => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Vec<Phase> {
        let phase = |name: &str, seconds| Phase {
            name: name.into(),
            seconds,
        };
        vec![phase("long", 30.0), phase("short", 10.0)]
    }

    #[test]
    fn the_whole_is_weighed_by_estimated_times() {
        assert!((whole(&two(), &[0.5, 0.0]) - 0.375).abs() < 1e-12);
        assert!((whole(&two(), &[1.0, 0.5]) - 0.875).abs() < 1e-12);
        assert_eq!(whole(&[], &[]), 1.0);
    }

    #[test]
    fn a_phase_that_begins_ends_those_before_it_and_none_goes_back() {
        let job = Progress::new(false).job(Plan {
            phases: two(),
            ..Plan::default()
        });
        job.set(0, 0.2, "");
        job.set(1, 0.5, "");
        job.set(1, 0.4, "");
        assert_eq!(job.state.lock().unwrap().done, [1.0, 0.5]);
    }

    #[test]
    fn fillets_have_phases_of_their_own_before_or_behind_the_contact() {
        let plan = || Plan::new([1.0, 2.0], ("contact", 4.0));
        let names = |plan: &Plan| -> Vec<String> {
            let own = plan.phases.iter().skip(2);
            own.map(|phase| phase.name.clone()).collect()
        };
        let fillets = [
            "model of the fillets of gear 1",
            "model of the fillets of gear 2",
        ];
        let (behind, between) = (
            plan().then_fillets([8.0, 9.0]),
            plan().with_fillets([8.0, 9.0]),
        );
        assert_eq!(names(&behind), ["contact", fillets[0], fillets[1]]);
        assert_eq!(names(&between), [fillets[0], fillets[1], "contact"]);
        for (plan, done) in [
            (behind, [1.0, 1.0, 1.0, 1.0, 0.5]),
            (between, [1.0, 1.0, 1.0, 1.0, 0.25]),
        ] {
            let job = Progress::new(false).job(plan);
            job.contact(0.25, "");
            job.fillets(1, 0.5, "");
            assert_eq!(job.state.lock().unwrap().done, done);
        }
    }

    #[test]
    fn times_are_told_in_minutes_and_hours() {
        let of = |seconds| clock(Duration::from_secs(seconds));
        assert_eq!(
            [of(59), of(61), of(7260)],
            ["59 s", "1 min 1 s", "2 h 1 min"]
        );
        assert_eq!(left(Duration::from_secs(10), 0.25), ", about 30 s left");
        assert_eq!(left(Duration::from_secs(10), 0.001), "");
    }
}
