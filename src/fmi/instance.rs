//! One instance of the FMU: what the functions of the interface do, in safe Rust.
//!
//! Outputs and their derivatives are a pure function of inputs, parameters, phase offsets and, with `coupling`, of what the last step gave.
//! They are made when they are read and cached until one of these changes (`Instance::changed`), so that hosts may set
//! and get in any order, value by value, and go back in time. A call that is refused changes nothing.

use std::collections::HashMap;
use std::sync::Arc;

use super::inputs::{BODIES, InputValues, MAXIMUM_ORDER, Resolution};
use super::lifecycle::{Clock, Function, Interface, State};
use super::parameters::Settings;
use super::resources::Resources;
use super::state::{InstanceState, StepLoads, new_handle, unknown};
use super::variables::{
    Causality, FIRST_PARAMETER, INPUTS, Kind, OUTPUTS, VARIABLES, Variability, Variable,
    all_finite, block_of, check_finite, check_value, find, index, index_of, output_row,
};
use super::{Refusal, Severity};
use crate::element::{
    BODY_COLUMNS, CONTINUOUS_OUTPUTS, Coupling, Direction, Element, Formulation, History, Inputs,
    Jacobian, Loads, Mode, Outputs, PhaseOffset, Prediction, StepRequest, Workspace,
};
use crate::words::number;

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

/// Warnings that the gears have left the range, of one instance.
const MOST_WARNINGS: usize = 100;

/// Order of the output derivatives that are offered.
const OUTPUT_ORDER: i32 = 1;

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

    /// Events since the last call, for the log.
    pub fn take_events(&mut self) -> Vec<(Severity, String)> {
        std::mem::take(&mut self.events)
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

    fn report(&mut self, severity: Severity, text: &str) {
        let text = format!("t = {} s: {text}", number(self.time()));
        self.events.push((severity, text));
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
    fn not_finite(&self, what: &str, row: usize) -> Refusal {
        let what = format!("{what}{} is not finite", VARIABLES[INPUTS + row].name);
        self.overflow(self.state.inputs.largest(), &what)
    }

    /// Numbers so large that nothing can be computed; `i` is the input to look at.
    fn overflow(&self, i: usize, what: &str) -> Refusal {
        Refusal::discard(format!(
            "{what}: check {} = {}, its derivatives and the parameters for numbers out of all proportion",
            VARIABLES[i].name,
            number(self.state.inputs.get(i))
        ))
    }

    /// fmi2GetDirectionalDerivative: derivatives of the `unknown` outputs, in their order, along the
    /// change that `seeds` gives of the inputs `known`. Exact but for `mesh.stiffness` and contact at run time, which have
    /// central differences; in Initialization Mode the phases of the teeth follow the pose, and the derivatives with
    /// them. Inputs that the formulation does not look at change nothing. In Initialization Mode Real parameters
    /// are among what is known, too: by differences of the outputs, good to some eight digits.
    /// Errors: references that are no outputs, inputs or such parameters, seeds that are not finite, inputs at
    /// which there are no outputs.
    pub fn directional_derivative(
        &mut self,
        unknown: &[u32],
        known: &[u32],
        seeds: &[f64],
    ) -> Result<Vec<f64>, Refusal> {
        let rows = rows(unknown)?;
        let mut direction = Direction::zeros();
        let mut by_parameters = [0.0; OUTPUTS];
        for (&reference, &seed) in known.iter().zip(seeds) {
            let i = find(Kind::Real, reference)?;
            let name = VARIABLES[i].name;
            check_finite(&format!("the seed of {name}"), seed)?;
            if i < INPUTS {
                let (column, change) = self.state.inputs.direction(i, self.settings.orientation);
                let mut columns = direction.fixed_rows_mut::<3>(column);
                columns += change * seed;
            } else if output_row(i).is_some() {
                return Err(no_input(i, ""));
            } else if self.state.phase_offset.is_some() {
                let reason = "; by parameters there are derivatives in Initialization Mode alone";
                return Err(no_input(i, reason));
            } else {
                let slopes = self.by_parameter(i)?;
                for (sum, slope) in by_parameters.iter_mut().zip(slopes) {
                    *sum += slope * seed;
                }
            }
        }
        let mut slopes = self.along(&rows, &direction)?;
        for (slope, row) in slopes.iter_mut().zip(rows) {
            *slope += by_parameters[row];
            if !slope.is_finite() {
                return Err(self.not_finite("the derivative of ", row));
            }
        }
        Ok(slopes)
    }

    /// Derivatives of the outputs by the Real parameter `i`: by differences, from one side where the other is no value of
    /// it.
    fn by_parameter(&mut self, i: usize) -> Result<[f64; OUTPUTS], Refusal> {
        /// Of the larger one of value and nominal value.
        const STEP: f64 = 1e-5;
        const POSITION: usize = row(index::MESH_POSITION);
        // While this instance has its element, the others share the interpolants of its tables.
        self.ready()?;
        let value = self.state.parameters[i - FIRST_PARAMETER];
        let step = STEP * value.abs().max(VARIABLES[i].nominal);
        let with = |x: f64| -> Result<_, Refusal> {
            let mut other = Self::new(self.resources.clone(), self.state.interface);
            let mut state = self.state.clone();
            state.parameters[i - FIRST_PARAMETER] = x;
            other.go_to(state)?;
            Ok((x, *other.outputs()?))
        };
        let (high, above) = with(value + step).or_else(|_| with(value))?;
        let (low, below) = with(value - step).or_else(|_| with(value))?;
        Ok(std::array::from_fn(|row| {
            let change = above[row] - below[row];
            // The mesh position goes on at 0 where it ends at 1.
            let turns = if row == POSITION { change.round() } else { 0.0 };
            (change - turns) / (high - low)
        }))
    }

    /// Derivatives of the outputs `rows` along `direction`. Before phases are taken those follow the pose.
    fn along(&mut self, rows: &[usize], direction: &Direction) -> Result<Vec<f64>, Refusal> {
        const STIFFNESS: usize = row(index::MESH_STIFFNESS);
        let with_stiffness = rows.contains(&STIFFNESS);
        let is_known = match self.slopes {
            Slopes::Stale => false,
            Slopes::WithoutStiffness => !with_stiffness,
            Slopes::All => true,
        };
        if !is_known {
            self.slopes = Slopes::Stale;
            let phase = self.state.phase_offset;
            let (element, buffers) = self.ready()?;
            let (slopes, workspace) = (&mut buffers.slopes, &mut buffers.workspace);
            element.slopes(
                phase.as_ref(),
                &buffers.motions,
                with_stiffness,
                slopes,
                workspace,
            )?;
            self.slopes = match with_stiffness {
                true => Slopes::All,
                false => Slopes::WithoutStiffness,
            };
        }
        let slopes = *self.buffers.slopes * direction;
        // What is known of the master changes at steps alone.
        let slope = |&row: &usize| match slopes.get(row).copied().unwrap_or(0.0) {
            slope if slope.is_finite() => Ok(slope),
            _ => Err(self.not_finite("the derivative of ", row)),
        };
        rows.iter().map(slope).collect()
    }

    /// fmi2SetRealInputDerivatives; all or none.
    /// Errors: unknown references, variables that are no inputs, orders beyond 1 to 3, values
    /// that are not finite.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Refusal> {
        let mut inputs = self.state.inputs.clone();
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let i = find(Kind::Real, reference)?;
            let name = VARIABLES[i].name;
            if i >= INPUTS {
                return Err(no_input(i, ""));
            }
            let known = usize::try_from(order).ok();
            let known = known.filter(|order| (1..=MAXIMUM_ORDER).contains(order));
            let order = known.ok_or_else(|| {
                Refusal::error(format!(
                    "order {order} of {name}; orders 1 to {MAXIMUM_ORDER} are taken"
                ))
            })?;
            check_finite(&format!("derivative {order} of {name}"), value)?;
            inputs.set_derivative(i, order, value);
        }
        self.state.inputs = inputs;
        Ok(())
    }

    /// fmi2GetRealOutputDerivatives: time derivatives of the outputs at the current communication
    /// point, of the first order. Poses change with the velocity inputs, which are
    /// their derivatives, and velocities with the input derivatives that the host gave.
    /// Errors: references that are no outputs, another order than 1, inputs at which there are no outputs.
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
    ) -> Result<Vec<f64>, Refusal> {
        if let Some(order) = orders.iter().find(|order| **order != OUTPUT_ORDER) {
            return Err(Refusal::error(format!(
                "order {order}; order {OUTPUT_ORDER} is offered"
            )));
        }
        let mut direction = Direction::zeros();
        for body in 0..BODIES.len() {
            for (k, rate) in self.state.inputs.rates(body).iter().enumerate() {
                let column = body * BODY_COLUMNS + 3 * k;
                direction.fixed_rows_mut::<3>(column).copy_from(rate);
            }
        }
        self.along(&rows(references)?, &direction)
    }

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

    /// Reports when loads come to be made otherwise than in the step before.
    fn watch_master(&mut self, before: Option<&History>) {
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
                    "coupling: loads of the communication point, for the step is {:.2} of the mesh's own radians per step, and 1.7 at most can be \
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
    fn watch_range(&mut self) {
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

fn no_input(i: usize, reason: &str) -> Refusal {
    Refusal::error(format!("{} is no input{reason}", VARIABLES[i].name))
}

/// Rows of the outputs with these references.
fn rows(references: &[u32]) -> Result<Vec<usize>, Refusal> {
    let row = |&reference: &u32| {
        let i = find(Kind::Real, reference)?;
        let name = VARIABLES[i].name;
        output_row(i).ok_or_else(|| Refusal::error(format!("{name} is no output")))
    };
    references.iter().map(row).collect()
}

#[cfg(test)]
#[path = "instance_tests.rs"]
pub(super) mod tests;
