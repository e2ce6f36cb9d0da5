//! One instance of the unit: what the functions of the interface do, in safe Rust.
//!
//! Outputs are a pure function of inputs, parameters and latch, evaluated when they are asked for
//! (dirty flag), so that hosts may set and get without a step between and may go back in time.

use std::sync::Arc;

use super::lifecycle::{Function, State};
use super::parameters::{element_parameters, orientation};
use super::report::{Refusal, Severity};
use super::resources::Resources;
use super::signals::{MAXIMUM_ORDER, Signals};
use super::snapshot::Snapshot;
use super::stored::Stored;
use super::values::{check_finite, check_value, find};
use super::variables::{
    Causality, INPUT_COUNT, Kind, VARIABLE_COUNT, VARIABLES, Variability, Variable, index, index_of,
};
use crate::element::{CONTINUOUS_OUTPUTS, Element, Outputs};

/// Outputs at the present inputs.
pub struct Evaluated {
    pub(super) all: Outputs,
    /// The continuous ones in the order of their variables.
    continuous: [f64; CONTINUOUS_OUTPUTS],
}

/// One instance of the unit.
pub struct Instance {
    pub(super) resources: Arc<Resources>,
    starts: [f64; VARIABLE_COUNT],
    pub(super) now: Snapshot,
    /// Made from the parameters when first needed.
    pub(super) element: Option<Element>,
    pub(super) outputs: Option<Evaluated>,
    /// Whether the last evaluation lay outside the table, for the log.
    was_out_of_range: bool,
    pub(super) stored: Stored,
    events: Vec<String>,
}

impl Instance {
    /// A new instance of the unit with these resources.
    pub fn new(resources: Arc<Resources>) -> Self {
        let starts = resources.starts();
        let now = initial(&starts);
        Self {
            resources,
            starts,
            now,
            element: None,
            outputs: None,
            was_out_of_range: false,
            stored: Stored::default(),
            events: Vec::new(),
        }
    }

    /// Current state of its life.
    pub fn state(&self) -> State {
        self.now.state
    }

    /// After a call that was refused with `severity`: fmi2Error and fmi2Fatal have states of their own.
    pub fn fail(&mut self, severity: Severity) {
        match severity {
            Severity::Error => self.now.state = State::Error,
            Severity::Fatal => self.now.state = State::Fatal,
            Severity::Warning | Severity::Discard => {}
        }
    }

    /// Current communication point, s.
    pub fn time(&self) -> f64 {
        self.now.time
    }

    /// Events since the last call, for the log.
    pub fn take_events(&mut self) -> Vec<String> {
        std::mem::take(&mut self.events)
    }

    /// Refuses `function` where the state machine does not allow it.
    ///
    /// # Errors
    /// Names the state and where the function is allowed.
    pub fn admit(&self, function: Function, name: &str) -> Result<(), Refusal> {
        if function.is_allowed(self.now.state) {
            return Ok(());
        }
        Err(Refusal::error(format!(
            "{name} is not allowed in the state {:?}; it is in {}",
            self.now.state,
            function.allowed_names()
        )))
    }

    /// fmi2SetupExperiment.
    ///
    /// # Errors
    /// Times that are not finite or in the wrong order.
    pub fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        if !start.is_finite() {
            return Err(Refusal::error(format!("startTime = {start} is not finite")));
        }
        // NaN is no time after the start.
        let ordered = stop.is_none_or(|stop| stop >= start);
        if let (Some(stop), false) = (stop, ordered) {
            return Err(Refusal::error(format!(
                "stopTime = {stop} lies before startTime = {start}"
            )));
        }
        self.now.start_time = start;
        self.now.time = start;
        self.now.stop_time = stop;
        Ok(())
    }

    /// fmi2EnterInitializationMode.
    pub fn enter_initialization(&mut self) {
        self.now.state = State::InitializationMode;
    }

    /// fmi2ExitInitializationMode: makes the element and latches the phases of the teeth.
    ///
    /// # Errors
    /// Parameters or poses that make no mesh; the instance stays in initialization.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        let inputs = self
            .now
            .signals
            .motions(orientation(&self.now.parameters))?;
        self.make_element()?;
        let element = self.element.as_ref().expect("made above");
        let latch = element.latch(&inputs).map_err(refuse)?;
        self.now.latch = Some(latch);
        self.outputs = None;
        self.evaluate()?;
        self.now.state = State::StepComplete;
        let outputs = &self.outputs.as_ref().expect("evaluated above").all;
        self.events.push(format!(
            "initialized at t = {} s: pair {}, centre distance {} m, mesh position {}",
            self.now.time, self.resources.unit.name, outputs.center_distance, outputs.mesh_position
        ));
        Ok(())
    }

    /// fmi2Terminate.
    pub fn terminate(&mut self) {
        self.now.state = State::Terminated;
    }

    /// fmi2Reset: as after fmi2Instantiate; stored states stay valid.
    pub fn reset(&mut self) {
        self.now = initial(&self.starts);
        self.element = None;
        self.outputs = None;
        self.was_out_of_range = false;
        self.events.push("reset".into());
    }

    /// Sets variables that are served by `kind` (Integer serves enumerations, too); all or none.
    ///
    /// # Errors
    /// Unknown references, wrong types, values that are not finite or outside their range, variables
    /// that may not be set now.
    pub fn set(
        &mut self,
        function: &str,
        kind: Kind,
        items: impl Iterator<Item = (u32, f64)> + Clone,
    ) -> Result<(), Refusal> {
        for (reference, value) in items.clone() {
            // Inputs are Real, always settable and unbounded (tested in `variables`); they are set in every step.
            if kind == Kind::Real
                && index_of(reference).is_some_and(|i| i < INPUT_COUNT)
                && value.is_finite()
            {
                continue;
            }
            let i = find(function, kind, reference)?;
            let variable = &VARIABLES[i];
            self.settable(function, variable)?;
            check_value(function, variable, value)?;
        }
        for (reference, value) in items {
            let Some(i) = index_of(reference) else {
                continue;
            };
            if i < INPUT_COUNT {
                self.now.signals.set(i, value);
            } else if self.now.parameters[i].to_bits() != value.to_bits() {
                self.now.parameters[i] = value;
                self.retune(i)?;
            }
            self.outputs = None;
        }
        Ok(())
    }

    /// A changed parameter: the element follows.
    fn retune(&mut self, i: usize) -> Result<(), Refusal> {
        if i == index::DAMPING
            && let Some(element) = &self.element
        {
            self.element = Some(
                element
                    .with_damping(self.now.parameters[i])
                    .map_err(refuse)?,
            );
        } else {
            self.element = None;
        }
        Ok(())
    }

    fn settable(&self, function: &str, variable: &Variable) -> Result<(), Refusal> {
        let name = variable.name;
        match (variable.causality, variable.variability) {
            (Causality::Input, _) | (Causality::Parameter, Variability::Tunable) => Ok(()),
            (Causality::Parameter, _) if self.now.state != State::StepComplete => Ok(()),
            (Causality::Parameter, _) => Err(Refusal::error(format!(
                "{function}: {name} is fixed after initialization; call fmi2Reset and set it before"
            ))),
            (Causality::Output, _) => Err(Refusal::error(format!(
                "{function}: {name} is an output and cannot be set"
            ))),
        }
    }

    /// Values of variables that are served by `kind`.
    ///
    /// # Errors
    /// Unknown references, wrong types; inputs or parameters at which there are no outputs.
    pub fn get(
        &mut self,
        function: &str,
        kind: Kind,
        references: impl Iterator<Item = u32>,
        mut put: impl FnMut(f64),
    ) -> Result<(), Refusal> {
        for reference in references {
            // Read in every step.
            if kind == Kind::Real
                && let Some(Evaluated { continuous, .. }) = &self.outputs
                && let Some(value) = index_of(reference)
                    .and_then(|i| i.checked_sub(INPUT_COUNT))
                    .and_then(|row| continuous.get(row))
            {
                put(*value);
                continue;
            }
            let i = find(function, kind, reference)?;
            put(match VARIABLES[i].causality {
                Causality::Input => self.now.signals.value[i],
                Causality::Parameter => self.now.parameters[i],
                Causality::Output => self.output(i)?,
            });
        }
        Ok(())
    }

    fn output(&mut self, i: usize) -> Result<f64, Refusal> {
        let outputs = self.evaluate()?;
        Ok(match i {
            index::MESH_FLANK => f64::from(outputs.all.flank),
            index::MESH_OUT_OF_RANGE => f64::from(u8::from(outputs.all.out_of_range)),
            _ => outputs.continuous[i - INPUT_COUNT],
        })
    }

    fn make_element(&mut self) -> Result<&Element, Refusal> {
        if self.element.is_none() {
            let parameters = element_parameters(&self.now.parameters);
            self.element = Some(self.resources.element(&parameters)?);
        }
        Ok(self.element.as_ref().expect("made above"))
    }

    /// The element, and phase zeros: the latched ones, or in initialization those of the present pose.
    pub(super) fn element_and_latch(
        &mut self,
    ) -> Result<(&Element, crate::element::Latch, crate::element::Inputs), Refusal> {
        let inputs = self
            .now
            .signals
            .motions(orientation(&self.now.parameters))?;
        let latched = self.now.latch;
        let element = self.make_element()?;
        let latch = match latched {
            Some(latch) => latch,
            None => element.latch(&inputs).map_err(refuse)?,
        };
        Ok((element, latch, inputs))
    }

    pub(super) fn evaluate(&mut self) -> Result<&Evaluated, Refusal> {
        if self.outputs.is_none() {
            let (element, latch, inputs) = self.element_and_latch()?;
            let all = element.evaluate(&latch, &inputs).map_err(refuse)?;
            let continuous = all.to_array();
            if let Some(row) = continuous.iter().position(|x| !x.is_finite()) {
                let name = VARIABLES[INPUT_COUNT + row].name;
                return Err(self.overflow(name));
            }
            self.outputs = Some(Evaluated { all, continuous });
        }
        Ok(self.outputs.as_ref().expect("evaluated above"))
    }

    /// Numbers so large that `what` cannot be computed; names the largest input.
    pub(super) fn overflow(&self, what: &str) -> Refusal {
        let values = self.now.signals.value.iter();
        let largest = values
            .enumerate()
            .max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
        let (i, value) = largest.map_or((0, 0.0), |(i, v)| (i, *v));
        Refusal::error(format!(
            "{what} is not finite at these inputs and parameters; the largest input is {} = {value}: \
             check it and the parameters for numbers out of all proportion",
            VARIABLES[i].name
        ))
    }

    /// fmi2SetRealInputDerivatives; all or none.
    ///
    /// # Errors
    /// Unknown references, variables that are no inputs, orders beyond 1 to 3, values
    /// that are not finite.
    pub fn set_input_derivatives(
        &mut self,
        items: impl Iterator<Item = (u32, i32, f64)> + Clone,
    ) -> Result<(), Refusal> {
        const FUNCTION: &str = "fmi2SetRealInputDerivatives";
        for (reference, order, value) in items.clone() {
            let i = find(FUNCTION, Kind::Real, reference)?;
            let name = VARIABLES[i].name;
            if i >= INPUT_COUNT {
                return Err(Refusal::error(format!("{FUNCTION}: {name} is no input")));
            }
            if usize::try_from(order).is_ok_and(|o| (1..=MAXIMUM_ORDER).contains(&o)) {
                check_finite(FUNCTION, &format!("derivative {order} of {name}"), value)?;
            } else {
                return Err(Refusal::error(format!(
                    "{FUNCTION}: order {order} of {name}; orders 1 to {MAXIMUM_ORDER} are taken"
                )));
            }
        }
        for (reference, order, value) in items {
            if let Some(i) = index_of(reference) {
                self.now.signals.set_derivative(i, order as usize, value);
            }
        }
        Ok(())
    }

    /// fmi2DoStep: moves the inputs to the end of the step and evaluates there.
    ///
    /// # Errors
    /// A step that is not positive, does not start where the last one ended, or passes the stop time;
    /// inputs without a right answer.
    pub fn do_step(&mut self, point: f64, step: f64) -> Result<(), Refusal> {
        if !step.is_finite() || step <= 0.0 {
            return Err(Refusal::error(format!(
                "fmi2DoStep: communicationStepSize = {step}; it must be positive and finite"
            )));
        }
        // Hosts add up times in their own way: equal means equal to rounding, never exactly.
        let tolerance = 1e-3 * step + 1e-9 * self.now.time.abs();
        let follows = (point - self.now.time).abs() <= tolerance; // never for NaN
        if !follows {
            return Err(Refusal::error(format!(
                "fmi2DoStep: currentCommunicationPoint = {point}, but the last step ended at {}; \
                 restore a stored state to go back",
                self.now.time
            )));
        }
        let end = point + step;
        if let Some(stop) = self.now.stop_time
            && end > stop + tolerance
        {
            return Err(Refusal::error(format!(
                "fmi2DoStep: the step ends at {end}, after stopTime = {stop}; shorten it"
            )));
        }
        let parameters = &self.now.parameters;
        let poses = parameters[index::EXTRAPOLATE_POSES] != 0.0;
        self.now
            .signals
            .advance(step, poses, orientation(parameters));
        self.now.time = end;
        self.outputs = None;
        let out_of_range = self.evaluate()?.all.out_of_range;
        if out_of_range != self.was_out_of_range {
            let what = if out_of_range { "left" } else { "entered" };
            self.events
                .push(format!("t = {end} s: {what} the range of the table"));
            self.was_out_of_range = out_of_range;
        }
        Ok(())
    }
}

fn initial(starts: &[f64; VARIABLE_COUNT]) -> Snapshot {
    Snapshot {
        state: State::Instantiated,
        time: 0.0,
        start_time: 0.0,
        stop_time: None,
        parameters: *starts,
        signals: Signals::constant(std::array::from_fn(|i| starts[i])),
        latch: None,
    }
}

pub(super) fn refuse(error: crate::element::ElementError) -> Refusal {
    Refusal::error(error.to_string())
}
