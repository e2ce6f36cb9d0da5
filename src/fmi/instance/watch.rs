//! What the log hears: events, gears that leave the range and come back, and loads that come to be made otherwise.

use super::{Instance, row};
use crate::element::{History, Mode};
use crate::fmi::variables::index;
use crate::fmi::{Refusal, Severity};
use crate::words::number;

/// Warnings of one instance that the gears have left the range, and reports that loads come to be made otherwise.
const MOST_WARNINGS: usize = 100;

impl Instance {
    /// Events since the last call, for the log.
    pub fn take_events(&mut self) -> Vec<(Severity, String)> {
        std::mem::take(&mut self.events)
    }

    pub(super) fn report(&mut self, severity: Severity, text: &str) {
        let text = format!("t = {} s: {text}", number(self.time()));
        self.events.push((severity, text));
    }

    /// Reports when loads come to be made otherwise than in the step before.
    pub(super) fn watch_master(&mut self, before: Option<&History>) {
        let mode = |history: &History| history.report.mode;
        let (was, now) = (before.map(mode), self.state.history.as_ref().map(mode));
        let (was, now) = (was.unwrap_or_default(), now.unwrap_or_default());
        if was == now || self.turns > MOST_WARNINGS {
            return;
        }
        self.turns += 1;
        let Some(report) = self.state.history.map(|history| history.report) else {
            return;
        };
        let (mass, theta) = (report.effective_mass, report.theta);
        let rule = format!("effective mass {mass:.4} kg, x' - x - H v = {theta:.2} H (v' - v)");
        let (severity, text) = match now {
            Mode::Held => (
                Severity::Event,
                "coupling: loads of the communication point".into(),
            ),
            Mode::TooLong => (
                Severity::Warning,
                format!(
                    "coupling: loads are held over the step, which is {:.2} rad of the natural frequency of the mesh; up to 1.7 rad they can be \
                     predicted: take a shorter step",
                    report.angle
                ),
            ),
            Mode::Sequential => (
                Severity::Event,
                format!(
                    "coupling: loads for the step that starts at the communication point ({rule})"
                ),
            ),
            Mode::Parallel => (
                Severity::Event,
                format!("coupling: loads for the step after the one asked for ({rule})"),
            ),
        };
        self.report(severity, &text);
    }

    /// Why the pose is outside the range, in words; empty where the load is.
    fn out_of_range(&mut self) -> Result<String, Refusal> {
        let outputs = self.law()?;
        let (element, buffers) = self.ready()?;
        Ok(element.out_of_range(&buffers.motions, &outputs)?)
    }

    /// Reports when the gears leave the range where outputs are to be trusted, and when they come back.
    pub(super) fn watch_range(&mut self) {
        let Some(outputs) = &self.outputs else {
            return;
        };
        let out_of_range = outputs[row(index::MESH_OUT_OF_RANGE)] != 0.0;
        if std::mem::replace(&mut self.state.out_of_range, out_of_range) == out_of_range {
            return;
        }
        if !out_of_range {
            return self.report(Severity::Event, "in range again");
        }
        let reasons = self.out_of_range().unwrap_or_default();
        // Loads come and go with every oscillation; a pose out of range is somebody's mistake or decision.
        if reasons.is_empty() {
            return self.report(Severity::Event, "the load left the range of the table");
        }
        self.departures += 1;
        if self.departures <= MOST_WARNINGS {
            self.report(Severity::Warning, &format!("out of range: {reasons}"));
        } else if self.departures == MOST_WARNINGS + 1 {
            let text = "out of range once more: no more warnings of this follow";
            self.report(Severity::Warning, text);
        }
    }
}
