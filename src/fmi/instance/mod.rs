//! One instance of the FMU: what the functions of the interface do, in safe Rust.
//!
//! Outputs and their derivatives are a pure function of inputs, parameters, phase offsets and, with `coupling`, of what the last step gave.
//! They are made when they are read and cached until one of these changes (`Instance::changed`), so that hosts may set
//! and get in any order, value by value, and go back in time. A call that is refused changes nothing.

mod derivatives;
mod step;
mod watch;

use std::collections::HashMap;
use std::sync::Arc;

use super::inputs::{BODIES, InputValues, Resolution};
use super::lifecycle::{Clock, Function, Interface, State};
use super::parameters::Settings;
use super::resources::Resources;
use super::state::{InstanceState, StepLoads, new_handle, unknown};
use super::variables::{
    Causality, FIRST_PARAMETER, INPUTS, Kind, OUTPUTS, VARIABLES, Variability, Variable,
    all_finite, block_of, check_value, find, index, index_of, output_row,
};
use super::{Refusal, Severity};
use crate::element::{
    CONTINUOUS_OUTPUTS, Coupling, Element, Formulation, History, Inputs, Jacobian, Mode, Outputs,
    PhaseOffset, Workspace,
};
use crate::words::number;

/// Inputs, m, rad and their rates, above it are out of all proportion.
const USUAL_INPUT: f64 = 1e12;

/// One instance of the FMU.
pub struct Instance {
    pub(super) resources: Arc<Resources>,
    pub(super) state: InstanceState,
    /// By handle.
    stored: HashMap<usize, InstanceState>,
    /// Those of the parameters in `state`.
    settings: Settings,
    /// Made with the settings when first needed.
    element: Option<Element>,
    /// What the teeth resolve of the motion of each body.
    resolution: [Resolution; BODIES.len()],
    buffers: Buffers,
    /// At the present state, if they were evaluated.
    outputs: Option<Rows>,
    slopes: Slopes,
    /// How often the gears left the range, for the log.
    departures: usize,
    /// How often loads came to be made otherwise, for the log.
    turns: usize,
    /// The step that was discarded last, from its point over its size, s, and the inputs that it was tried with.
    discarded: Option<([f64; 2], InputValues)>,
    events: Vec<(Severity, String)>,
}

/// What the element reads and writes at an evaluation.
struct Buffers {
    motions: Inputs,
    workspace: Workspace,
    slopes: Box<Jacobian>,
}

/// What of the derivatives in [`Buffers`] belongs to the present state.
enum Slopes {
    Stale,
    /// All but the row of `mesh.stiffness`, which costs the most.
    WithoutStiffness,
    All,
}

/// Outputs in the order of their variables.
type Rows = [f64; OUTPUTS];

/// Row of an output, by the index of its variable.
const fn row(index: usize) -> usize {
    index - INPUTS
}

impl Instance {
    /// A new instance of the FMU with these resources.
    pub fn new(resources: Arc<Resources>, interface: Interface) -> Self {
        let pair = &resources.unit.geometry;
        let [z1, z2] = [pair.gears[0].z(), pair.gears[1].z()];
        let of_teeth = |teeth: f64| Resolution::new(teeth, pair.base_pitch());
        let carrier = Resolution {
            position: f64::INFINITY, // of no consequence, see `ready`
            ..of_teeth(z1.max(z2))
        };
        Self {
            resolution: [of_teeth(z1), of_teeth(z2), carrier],
            state: InstanceState {
                interface,
                state: State::Instantiated,
                clock: Clock::default(),
                inputs: InputValues::new(&resources.starts),
                parameters: std::array::from_fn(|k| resources.starts[FIRST_PARAMETER + k]),
                phase_offset: None,
                history: None,
                loads: None,
                out_of_range: false,
            },
            stored: HashMap::new(),
            settings: resources.settings.clone(),
            element: None,
            buffers: Buffers {
                motions: Inputs::default(),
                workspace: Workspace::default(),
                slopes: Box::new(Jacobian::zeros()),
            },
            outputs: None,
            slopes: Slopes::Stale,
            departures: 0,
            turns: 0,
            discarded: None,
            events: Vec::new(),
            resources,
        }
    }

    /// Current state of its life.
    pub fn state(&self) -> State {
        self.state.state
    }

    /// Current communication point, s; model exchange: the time last set.
    pub fn time(&self) -> f64 {
        self.state.clock.time
    }

    /// After a call that was refused: fmi2Error and fmi2Fatal have states of their own. A solver or master may try points at
    /// which there are no outputs, and go elsewhere when they are discarded; in Initialization Mode there is no elsewhere.
    pub fn fail(&mut self, refusal: &mut Refusal) {
        if self.state() == State::InitializationMode && refusal.severity == Severity::Discard {
            refusal.severity = Severity::Error;
        }
        match refusal.severity {
            Severity::Error => self.state.state = State::Error,
            Severity::Fatal => self.state.state = State::Fatal,
            Severity::Event | Severity::Warning | Severity::Discard => {}
        }
    }

    /// See [`Function::admit`].
    #[inline]
    pub fn admit(&self, function: Function) -> Result<(), Refusal> {
        function.admit(self.state(), self.state.interface)
    }

    /// fmi2SetupExperiment.
    pub fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        self.state.clock.setup(start, stop)
    }

    /// fmi2ExitInitializationMode: makes the element and takes the phases of the teeth.
    /// Errors: parameters or poses that make no mesh; phases are as before.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        let (element, buffers) = self.ready()?;
        let phase = element.start(&buffers.motions)?;
        self.state.phase_offset = Some(phase);
        self.changed();
        let outputs = self.outputs().copied();
        let outputs = outputs.inspect_err(|_| self.state.phase_offset = None)?;
        self.watch_range();
        self.state.state = match self.state.interface {
            Interface::CoSimulation => State::StepComplete,
            Interface::ModelExchange => State::EventMode,
        };
        let text = format!(
            "initialized: pair {}, centre distance {} m, mesh position {}",
            self.resources.unit.name,
            outputs[row(index::MESH_CENTER_DISTANCE)],
            outputs[row(index::MESH_POSITION)]
        );
        self.report(Severity::Event, &text);
        Ok(())
    }

    /// fmi2Reset: as after fmi2Instantiate; stored states stay valid.
    pub fn reset(&mut self) {
        *self = Self {
            stored: std::mem::take(&mut self.stored),
            departures: self.departures,
            turns: self.turns,
            events: vec![(Severity::Event, "reset".into())],
            ..Self::new(self.resources.clone(), self.state.interface)
        };
    }

    /// fmi2GetFMUstate: stores the state over the one with this `handle`, or under a new one, which it returns.
    /// Errors: a handle that is none of this instance; so in all that follows.
    pub fn store(&mut self, handle: Option<usize>) -> Result<usize, Refusal> {
        if let Some(handle) = handle {
            self.stored(handle)?;
        }
        let handle = handle.unwrap_or_else(new_handle);
        self.stored.insert(handle, self.state.clone());
        Ok(handle)
    }

    /// fmi2SetFMUstate.
    pub fn restore(&mut self, handle: usize) -> Result<(), Refusal> {
        self.go_to(self.stored(handle)?.clone())
    }

    /// fmi2FreeFMUstate.
    pub fn discard(&mut self, handle: usize) -> Result<(), Refusal> {
        self.stored.remove(&handle).map(drop).ok_or_else(unknown)
    }

    /// fmi2SerializeFMUstate, and with its length fmi2SerializedFMUstateSize.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, Refusal> {
        Ok(self.stored(handle)?.to_bytes(&self.resources.unit.guid))
    }

    /// fmi2DeSerializeFMUstate: a new handle.
    /// Errors: bytes that are no state of this FMU.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<usize, Refusal> {
        let state = InstanceState::from_bytes(bytes, &self.resources.unit.guid)?;
        state.check(self.state.interface)?;
        let handle = new_handle();
        self.stored.insert(handle, state);
        Ok(handle)
    }

    fn stored(&self, handle: usize) -> Result<&InstanceState, Refusal> {
        self.stored.get(&handle).ok_or_else(unknown)
    }

    /// Goes to a state of this FMU.
    /// Errors: a state that no instance of this FMU and interface has made; nothing is changed.
    pub(super) fn go_to(&mut self, state: InstanceState) -> Result<(), Refusal> {
        self.configure(state.check(self.state.interface)?);
        self.state = state;
        self.discarded = None;
        // What follows a state is the same whatever came before it is restored.
        self.buffers.workspace = Workspace::default();
        self.changed();
        Ok(())
    }

    /// Inputs, parameters or phase offsets have changed: what was made of them is stale.
    #[inline]
    fn changed(&mut self) {
        self.outputs = None;
        self.slopes = Slopes::Stale;
    }

    /// Takes other settings. An element in which only the damping differs stays: it is tunable, and tables are large.
    fn configure(&mut self, settings: Settings) {
        if settings == self.settings {
            return;
        }
        let damping = settings.element.damping;
        self.settings.element.damping = damping;
        match &mut self.element {
            Some(element) if settings == self.settings => element.set_damping(damping),
            _ => self.element = None,
        }
        self.settings = settings;
    }

    /// fmi2SetReal, fmi2SetInteger, which serves enumerations, and fmi2SetBoolean, with 0 and 1; all or none.
    /// Errors: unknown references, wrong types, values that are not finite or outside their range, variables
    /// that may not be set now.
    pub fn set<T: Copy + Into<f64>>(
        &mut self,
        kind: Kind,
        references: &[u32],
        values: &[T],
    ) -> Result<(), Refusal> {
        // Most hosts set all inputs in every step: they are Real, always settable and unbounded (tested in `variables`).
        let block = block_of(references).filter(|block| kind == Kind::Real && block.end <= INPUTS);
        let numbers = values.iter().map(|&value| value.into());
        if let Some(block) = block
            && all_finite(numbers.clone())
        {
            self.state.inputs.set_from(block.start, numbers);
            self.moved();
            return Ok(());
        }
        let mut parameters = None;
        for (&reference, &value) in references.iter().zip(values) {
            let value = value.into();
            let is_input = index_of(reference).is_some_and(|i| i < INPUTS);
            if is_input && kind == Kind::Real && value.is_finite() {
                continue;
            }
            let i = find(kind, reference)?;
            let variable = &VARIABLES[i];
            // Hosts that write all tunable parameters at every step change nothing by it.
            let is_kept = variable.variability == Variability::Tunable
                && self.state.parameters[i - FIRST_PARAMETER] == value;
            if !is_kept {
                self.check_settable(variable)?;
            }
            check_value(variable, value)?;
            parameters.get_or_insert(self.state.parameters)[i - FIRST_PARAMETER] = value;
        }
        if let Some(parameters) = parameters {
            self.configure(Settings::new(&parameters)?);
            self.state.parameters = parameters;
        }
        let mut moved = false;
        for (&reference, &value) in references.iter().zip(values) {
            if let Some(i) = index_of(reference).filter(|i| *i < INPUTS) {
                self.state.inputs.set(i, value.into());
                moved = true;
            }
        }
        match moved {
            true => self.moved(),
            false => self.changed(),
        }
        Ok(())
    }

    /// Inputs have changed.
    #[inline]
    fn moved(&mut self) {
        if let Some(loads) = &mut self.state.loads {
            loads.moved = true;
        }
        self.changed();
    }

    fn check_settable(&self, variable: &Variable) -> Result<(), Refusal> {
        let initial = matches!(
            self.state(),
            State::Instantiated | State::InitializationMode
        );
        let integrating = self.state() == State::ContinuousTimeMode;
        let reason = match (variable.causality, variable.variability) {
            (Causality::Input, _) => return Ok(()),
            (Causality::Parameter, Variability::Tunable) if !integrating => return Ok(()),
            (Causality::Parameter, _) if initial => return Ok(()),
            (Causality::Parameter, Variability::Tunable) => {
                "changes at events only; call fmi2EnterEventMode before"
            }
            (Causality::Parameter, _) => {
                "is fixed after initialization; call fmi2Reset and set it before"
            }
            (Causality::Output, _) => "is an output and cannot be set",
        };
        Err(Refusal::error(format!("{} {reason}", variable.name)))
    }

    /// fmi2GetReal, fmi2GetInteger, which serves enumerations, and fmi2GetBoolean (0 and 1): calls `put` with the values, some at a time.
    /// Errors: unknown references, wrong types; inputs or parameters at which there are no outputs.
    pub fn get(
        &mut self,
        kind: Kind,
        references: &[u32],
        mut put: impl FnMut(&[f64]),
    ) -> Result<(), Refusal> {
        let block =
            block_of(references).filter(|block| kind == Kind::Real && block.start >= INPUTS);
        if let Some(block) = block {
            put(&self.outputs()?[row(block.start)..row(block.end)]);
        } else {
            for &reference in references {
                let i = find(kind, reference)?;
                put(&[match output_row(i) {
                    Some(row) => self.outputs()?[row],
                    None if i < INPUTS => self.state.inputs.get(i),
                    None => self.state.parameters[i - FIRST_PARAMETER],
                }]);
            }
        }
        // In Initialization Mode poses may be on their way to the start.
        if self.state() != State::InitializationMode {
            self.watch_range();
        }
        Ok(())
    }

    /// The element, made if there is none, and its buffers with the motions that it looks at, from the present inputs.
    #[inline(always)]
    fn ready(&mut self) -> Result<(&Element, &mut Buffers), Refusal> {
        let (inputs, orientation) = (&self.state.inputs, self.settings.orientation);
        let motions = &mut self.buffers.motions;
        for body in 0..2 {
            let motion = &mut motions.gears[body];
            inputs.write_motion(body, orientation, self.resolution[body], motion)?;
        }
        if self.settings.element.formulation == Formulation::Paper {
            inputs.write_motion(2, orientation, self.resolution[2], &mut motions.carrier)?;
            // The position and velocity of its origin cancel out; gear 1's are those that cost no rounding.
            let gear = &motions.gears[0];
            (motions.carrier.p, motions.carrier.v) = (gear.p, gear.v);
        }
        if self.element.is_none() {
            self.element = Some(self.resources.element(&self.settings.element)?);
        }
        let element = self.element.as_ref().expect("made above");
        Ok((element, &mut self.buffers))
    }

    /// As [`Instance::ready`], with the phases of the teeth; before phases are taken, those of the present pose.
    #[inline(always)]
    fn in_phase(&mut self) -> Result<(&Element, &mut Buffers, PhaseOffset), Refusal> {
        let phase = self.state.phase_offset;
        let (element, buffers) = self.ready()?;
        let phase = phase.map_or_else(|| element.phase_offset(&buffers.motions), Ok)?;
        Ok((element, buffers, phase))
    }

    /// Outputs at the present state.
    #[inline(always)]
    fn outputs(&mut self) -> Result<&Rows, Refusal> {
        if self.outputs.is_none() {
            let pose = self.law()?;
            let (loads, history) = (self.state.loads.as_ref(), self.state.history.as_ref());
            self.outputs = Some(self.rows(&pose, loads, history)?);
        }
        Ok(self.outputs.as_ref().expect("made above"))
    }

    /// Those of the pose.
    #[inline(always)]
    fn law(&mut self) -> Result<Outputs, Refusal> {
        let (element, buffers, phase) = self.in_phase()?;
        let (motions, workspace) = (&buffers.motions, &mut buffers.workspace);
        Ok(element.evaluate_from(&phase, motions, workspace)?)
    }

    /// Those of the pose, with what the last step gave. After fmi2SetReal its loads change as those of the pose, until the teeth part.
    #[inline(always)]
    fn rows(
        &self,
        pose: &Outputs,
        loads: Option<&StepLoads>,
        history: Option<&History>,
    ) -> Result<Rows, Refusal> {
        let mut rows = [0.0; OUTPUTS];
        rows[..CONTINUOUS_OUTPUTS].copy_from_slice(&pose.to_array());
        match loads {
            Some(step) if !step.moved => step.given.write(&mut rows),
            Some(step) if pose.flank != 0 => step.beyond.add_to(&mut rows),
            _ => {}
        }
        if self.settings.coupling != Coupling::Held {
            rows[CONTINUOUS_OUTPUTS + 1] = self.settings.effective_mass;
        }
        if let Some(history) = history {
            let report = history.report;
            rows[CONTINUOUS_OUTPUTS..].copy_from_slice(&[
                match report.mode {
                    Mode::Held | Mode::TooLong => 0.0,
                    Mode::Sequential => 1.0,
                    Mode::Parallel => 2.0,
                },
                report.effective_mass,
                report.error,
            ]);
        }
        match all_finite(rows.iter().copied()) {
            true => Ok(rows),
            false => {
                let row = rows.iter().position(|x| !x.is_finite());
                Err(self.not_finite("", row.unwrap_or(0)))
            }
        }
    }

    /// Of the output in `row`, or of `what` of it.
    #[cold]
    fn not_finite(&self, what: &str, row: usize) -> Refusal {
        let what = format!("{what}{} is not finite", VARIABLES[INPUTS + row].name);
        let largest = self.state.inputs.largest();
        if self.state.inputs.get(largest).abs() > USUAL_INPUT {
            return self.overflow(largest, &what);
        }
        let parameters = VARIABLES[FIRST_PARAMETER..].iter();
        let sizes = parameters.zip(&self.state.parameters);
        let largest = sizes.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
        let of_all = largest.map_or(String::new(), |(variable, value)| {
            format!(
                ", of which {} = {} is the largest",
                variable.name,
                number(*value)
            )
        });
        Refusal::discard(format!("{what}: check the parameters{of_all}"))
    }

    /// Numbers so large that nothing can be computed; `i` is the input to look at.
    fn overflow(&self, i: usize, what: &str) -> Refusal {
        Refusal::discard(format!(
            "{what}: check {} = {} and its derivatives for numbers out of all proportion",
            VARIABLES[i].name,
            number(self.state.inputs.get(i))
        ))
    }
}

#[cfg(test)]
pub(super) mod tests;
