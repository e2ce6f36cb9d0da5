//! fmi2DoStep: where a communication step leads, and which loads act over it.

use super::Instance;
use crate::element::{Coupling, History, Loads, Prediction, StepRequest};
use crate::fmi::inputs::InputValues;
use crate::fmi::state::StepLoads;
use crate::fmi::{Refusal, Severity};

impl Instance {
    /// fmi2DoStep from the communication `point` over `step`, s: moves inputs with derivatives to the end of the step and
    /// evaluates there, or predicts the loads by the coupling. A step that is refused changes nothing.
    /// Errors: a step that is not positive, does not start where the last one ended, or passes the stop time;
    /// inputs at which there are no outputs. A step that is discarded for its inputs, and tried again as it was, is an
    /// error: it would be tried for ever.
    pub fn do_step(&mut self, point: f64, step: f64) -> Result<(), Refusal> {
        let clock = self.state.clock.after(point, step)?;
        if let Err(mut refusal) = self.advance(step) {
            if refusal.severity == Severity::Discard {
                let tried = Some(([point, step], self.state.inputs.clone()));
                if self.discarded == tried {
                    refusal.severity = Severity::Error;
                }
                self.discarded = tried;
            }
            return Err(refusal);
        }
        self.state.clock = clock;
        self.watch_range();
        Ok(())
    }

    /// Outputs of the step, with loads by the coupling; the others belong to where derivatives of the inputs lead.
    fn advance(&mut self, step: f64) -> Result<(), Refusal> {
        let end = self.state.inputs.after(step);
        let coupling = self.settings.coupling;
        if end.is_none() && coupling == Coupling::Held {
            return self.outputs().map(drop);
        }
        if let Some(i) = end.as_ref().and_then(InputValues::fault) {
            return Err(self.overflow(i, "an input overflows within the step"));
        }
        let found = match coupling {
            Coupling::Held => None,
            _ => Some(self.predict(coupling, step)?),
        };
        let start = end.map(|end| std::mem::replace(&mut self.state.inputs, end));
        let outcome = self.committed(found, start.is_some());
        if let Some(start) = start.filter(|_| outcome.is_err()) {
            self.state.inputs = start;
            self.changed();
        }
        outcome
    }

    /// Takes over what was `found` for a step, which has moved the inputs or not.
    fn committed(&mut self, found: Option<Prediction>, moved: bool) -> Result<(), Refusal> {
        let all = match &found {
            Some(found) if !moved => found.outputs,
            _ => self.law()?,
        };
        let mut history = found.as_ref().and_then(|found| found.history);
        // Held loads are those where derivatives of the inputs lead, whatever holds them.
        let held = moved && history.as_ref().is_none_or(History::is_held);
        if let Some(history) = history.as_mut().filter(|_| held) {
            *history = self.ready()?.0.held_at(history, &all);
        }
        let loads = found.filter(|_| !held).map(|found| StepLoads {
            given: found.loads,
            beyond: found.loads.without(&Loads::at(&all)),
            moved: false,
        });
        let outputs = self.rows(&all, loads.as_ref(), history.as_ref())?;
        self.changed();
        self.outputs = Some(outputs);
        let before = std::mem::replace(&mut self.state.history, history);
        self.state.loads = loads;
        self.watch_master(before.as_ref());
        Ok(())
    }

    /// Loads for a step of `length` s from the present inputs.
    fn predict(&mut self, coupling: Coupling, length: f64) -> Result<Prediction, Refusal> {
        let request = StepRequest {
            coupling,
            length,
            effective_mass: self.settings.effective_mass,
        };
        let last = self.state.history;
        let (element, buffers, phase) = self.in_phase()?;
        let (motions, workspace) = (&buffers.motions, &mut buffers.workspace);
        Ok(element.predict(&phase, motions, last.as_ref(), &request, workspace)?)
    }
}
