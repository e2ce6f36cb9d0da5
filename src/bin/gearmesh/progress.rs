//! Progress on standard error, where it is a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Whether bars are shown.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    quiet: bool,
}

/// One bar; it disappears when dropped.
pub struct Bar {
    bar: ProgressBar,
}

/// Resolution of a bar that shows a share of the work.
const FULL: u64 = 1000;

impl Progress {
    /// Bars, unless `quiet`.
    pub fn new(quiet: bool) -> Self {
        Progress { quiet }
    }

    /// A bar for a share from 0 to 1 of `task`.
    pub fn share(self, task: &str) -> Bar {
        let style = ProgressStyle::with_template("{prefix}: [{bar:30}] {elapsed} {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        let target = if self.quiet {
            ProgressDrawTarget::hidden()
        } else {
            // Hides itself where standard error is no terminal.
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(FULL), target)
            .with_style(style)
            .with_prefix(task.to_owned());
        Bar { bar }
    }
}

impl Bar {
    /// The share that is done, and what is being done.
    pub fn set(&self, message: &str, share: f64) {
        self.bar.set_message(message.to_owned());
        self.bar
            .set_position((share.clamp(0.0, 1.0) * FULL as f64) as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
