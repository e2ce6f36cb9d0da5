//! One instance of the unit: what the functions of the interface do, in safe Rust.

use std::sync::Arc;

use super::clock::Clock;
use super::co_simulation::CoSimulation;
use super::inputs::InputValues;
use super::layout::inputs;
use super::lifecycle::{Function, Interface, State};
use super::report::{Event, Refusal, Severity};
use super::resources::Resources;
use super::snapshot::Snapshot;
use super::stored::Stored;
use super::unit::Unit;
use super::values::{Value, accept, find};
use super::variables::{Causality, Kind, VARIABLES, Variability, Variable, index_of};
use crate::words::number;

/// One instance of the unit.
pub struct Instance {
    state: State,
    unit: Unit,
    simulation: Simulation,
    pub(super) stored: Stored,
    /// Whether the outputs last looked at were out of range, for the log.
    was_out_of_range: bool,
    /// How often they left it, for the log.
    departures: usize,
    /// The step that was discarded last, from its point over its size, s, and the inputs that it was tried with.
    discarded: Option<([f64; 2], InputValues)>,
    events: Vec<Event>,
}

/// Warnings that the gears have left the range, of one instance.
const MOST_WARNINGS: usize = 100;

/// What goes beyond the unit.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) enum Simulation {
    CoSimulation(CoSimulation),
    /// The host integrates; there are no states and nothing depends on time.
    ModelExchange(Clock),
}

impl Simulation {
    fn new(interface: Interface) -> Self {
        let clock = Clock::default();
        match interface {
            Interface::ModelExchange => Simulation::ModelExchange(clock),
            Interface::CoSimulation => Simulation::CoSimulation(CoSimulation {
                clock,
                polynomials: Default::default(),
            }),
        }
    }

    fn interface(&self) -> Interface {
        match self {
            Simulation::CoSimulation(_) => Interface::CoSimulation,
            Simulation::ModelExchange(_) => Interface::ModelExchange,
        }
    }

    fn clock(&mut self) -> &mut Clock {
        match self {
            Simulation::CoSimulation(co_simulation) => &mut co_simulation.clock,
            Simulation::ModelExchange(clock) => clock,
        }
    }
}

impl Instance {
    /// A new instance of the unit with these resources.
    pub fn new(resources: Arc<Resources>, interface: Interface) -> Self {
        Self {
            state: State::Instantiated,
            unit: Unit::new(resources),
            simulation: Simulation::new(interface),
            stored: Stored::default(),
            was_out_of_range: false,
            departures: 0,
            discarded: None,
            events: Vec::new(),
        }
    }

    /// Current state of its life.
    pub fn state(&self) -> State {
        self.state
    }

    /// What packing put beside the library.
    pub(super) fn resources(&self) -> &Arc<Resources> {
        self.unit.resources()
    }

    /// After a call that was refused with `severity`: fmi2Error and fmi2Fatal have states of their own.
    pub fn fail(&mut self, severity: Severity) {
        match severity {
            Severity::Error => self.state = State::Error,
            Severity::Fatal => self.state = State::Fatal,
            Severity::Warning | Severity::Discard => {}
        }
    }

    /// Current communication point, s; model exchange: the time last set.
    pub fn time(&self) -> f64 {
        match &self.simulation {
            Simulation::CoSimulation(co_simulation) => co_simulation.clock.time(),
            Simulation::ModelExchange(clock) => clock.time(),
        }
    }

    /// Events since the last call, for the log.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Refuses `function` where the state machine does not allow it.
    ///
    /// # Errors
    /// Names the state and where the function is allowed, or the interface it belongs to.
    pub fn admit(&self, function: Function, name: &str) -> Result<(), Refusal> {
        let interface = self.simulation.interface();
        if let Some(other) = function.interface().filter(|i| *i != interface) {
            return Err(Refusal::error(format!(
                "{name} belongs to {other:?}; this instance was made for {interface:?}"
            )));
        }
        if function.is_allowed(self.state) {
            return Ok(());
        }
        Err(Refusal::error(format!(
            "{name} is not allowed in the state {:?}; it is in {}",
            self.state,
            function.allowed_names()
        )))
    }

    /// fmi2SetupExperiment.
    ///
    /// # Errors
    /// As `Clock::setup`.
    pub fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        self.simulation.clock().setup(start, stop)
    }

    /// fmi2EnterInitializationMode, fmi2EnterEventMode, fmi2EnterContinuousTimeMode, fmi2Terminate.
    pub fn enter(&mut self, state: State) {
        self.state = state;
    }

    /// fmi2ExitInitializationMode: makes the element and takes the phases of the teeth.
    ///
    /// # Errors
    /// Parameters or poses that make no mesh.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        let taken = self.unit.take_phases();
        self.settled(taken)?;
        self.watch_range();
        self.state = match self.simulation.interface() {
            Interface::CoSimulation => State::StepComplete,
            Interface::ModelExchange => State::EventMode,
        };
        let (time, name) = (self.time(), &self.resources().unit.name);
        let said: Vec<_> = self.unit.present().map(|outputs| {
            Event::Told(format!(
                "initialized at t = {time} s: pair {name}, centre distance {} m, mesh position {}",
                outputs.all.center_distance, outputs.all.mesh_position
            ))
        }).collect();
        self.events.extend(said);
        Ok(())
    }

    /// fmi2Reset: as after fmi2Instantiate; stored states stay valid.
    pub fn reset(&mut self) {
        self.state = State::Instantiated;
        self.unit = Unit::new(self.unit.resources().clone());
        self.simulation = Simulation::new(self.simulation.interface());
        self.was_out_of_range = false;
        self.discarded = None;
        self.events.push(Event::Told("reset".into()));
    }

    /// fmi2SetReal; all or none.
    ///
    /// # Errors
    /// Unknown references, wrong types, values that are not finite or outside their range, variables
    /// that may not be set now.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        const FUNCTION: &str = "fmi2SetReal";
        let inputs = inputs();
        let items = references.iter().copied().zip(values.iter().copied());
        // Inputs are Real, always settable and unbounded (tested in `variables`); most hosts set all of them in
        // every step, as one block.
        if let Some(block) = block(references)
            && block.end <= inputs
            && all_finite(values)
        {
            self.unit.inputs_mut().set_block(block.start, values);
            return Ok(());
        }
        for (reference, value) in items.clone() {
            self.acceptable(FUNCTION, Kind::Real, reference, value)?;
        }
        let mut parameters = Vec::new();
        let values = self.unit.inputs_mut();
        for (reference, value) in items {
            match index_of(reference) {
                Some(i) if i < inputs => values.set(i, value),
                Some(i) => parameters.push((i, Value::Real(value))),
                None => {}
            }
        }
        parameters
            .into_iter()
            .try_for_each(|(i, value)| self.unit.set_parameter(i, value))
    }

    /// fmi2SetInteger, which serves enumerations, too, and fmi2SetBoolean, with 0 and 1; all or none.
    ///
    /// # Errors
    /// As [`Instance::set_real`].
    pub fn set_discrete(
        &mut self,
        function: &str,
        kind: Kind,
        items: impl Iterator<Item = (u32, i32)>,
    ) -> Result<(), Refusal> {
        let accepted = items
            .map(|(reference, value)| self.acceptable(function, kind, reference, f64::from(value)));
        for (i, value) in accepted.collect::<Result<Vec<_>, _>>()? {
            self.unit.set_parameter(i, value)?;
        }
        Ok(())
    }

    /// Index and value of a variable that may be set to `number` now.
    fn acceptable(
        &self,
        function: &str,
        kind: Kind,
        reference: u32,
        number: f64,
    ) -> Result<(usize, Value), Refusal> {
        let i = find(function, kind, reference)?;
        self.settable(function, &VARIABLES[i])?;
        Ok((i, accept(function, &VARIABLES[i], number)?))
    }

    fn settable(&self, function: &str, variable: &Variable) -> Result<(), Refusal> {
        let name = variable.name;
        let initial = matches!(self.state, State::Instantiated | State::InitializationMode);
        let integrating = self.state == State::ContinuousTimeMode;
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
        Err(Refusal::error(format!("{function}: {name} {reason}")))
    }

    /// What fmi2GetReal reads, if it is a block of outputs that are at hand.
    pub fn outputs_at_hand(&self, references: &[u32]) -> Option<&[f64]> {
        let block = block(references)?;
        let (first, values) = self.unit.at_hand()?;
        values.get(block.start.checked_sub(first)?..block.end - first)
    }

    /// fmi2GetReal: calls `put` with each value.
    ///
    /// # Errors
    /// Unknown references, wrong types; inputs or parameters at which there are no outputs.
    pub fn get_real(
        &mut self,
        references: impl Iterator<Item = u32>,
        mut put: impl FnMut(f64),
    ) -> Result<(), Refusal> {
        for reference in references {
            put(self.value("fmi2GetReal", Kind::Real, reference)?.number());
        }
        // In Initialization Mode poses may be on their way to the start.
        if self.state != State::InitializationMode {
            self.watch_range();
        }
        Ok(())
    }

    /// fmi2GetInteger, which serves enumerations, too, and fmi2GetBoolean (0 and 1).
    ///
    /// # Errors
    /// As [`Instance::get_real`].
    pub fn get_discrete(
        &mut self,
        function: &str,
        kind: Kind,
        references: impl Iterator<Item = u32>,
        mut put: impl FnMut(i32),
    ) -> Result<(), Refusal> {
        for reference in references {
            put(match self.value(function, kind, reference)? {
                Value::Integer(x) => x,
                Value::Boolean(x) => i32::from(x),
                Value::Real(x) => x as i32,
            });
        }
        Ok(())
    }

    fn value(&mut self, function: &str, kind: Kind, reference: u32) -> Result<Value, Refusal> {
        let i = find(function, kind, reference)?;
        let value = self.unit.get(i);
        self.settled(value)
    }

    /// A solver or master may try points at which there are no outputs, and go elsewhere when they are discarded; in
    /// Initialization Mode there is no elsewhere.
    fn settled<T>(&self, outcome: Result<T, Refusal>) -> Result<T, Refusal> {
        outcome.map_err(|refusal| match (self.state, refusal.severity) {
            (State::InitializationMode, Severity::Discard) => Refusal::error(refusal.message),
            _ => refusal,
        })
    }

    /// fmi2GetDirectionalDerivative; see `Unit::directional_derivative`.
    ///
    /// # Errors
    /// As there.
    pub fn directional_derivative(
        &mut self,
        unknown: &[u32],
        known: impl Iterator<Item = (u32, f64)>,
    ) -> Result<Vec<f64>, Refusal> {
        let all = self.unit.directional_derivative(unknown, known);
        self.settled(all)
    }

    /// The co-simulation; `admit` lets none of its functions in without one.
    fn co_simulation(&mut self) -> Result<(&mut CoSimulation, &mut Unit), Refusal> {
        match &mut self.simulation {
            Simulation::CoSimulation(co_simulation) => Ok((co_simulation, &mut self.unit)),
            Simulation::ModelExchange(_) => {
                Err(Refusal::error("the instance was made for model exchange"))
            }
        }
    }

    /// fmi2SetRealInputDerivatives; see `CoSimulation::set_input_derivatives`.
    ///
    /// # Errors
    /// As there.
    pub fn set_input_derivatives(
        &mut self,
        items: impl Iterator<Item = (u32, i32, f64)>,
    ) -> Result<(), Refusal> {
        self.co_simulation()?.0.set_input_derivatives(items)
    }

    /// fmi2GetRealOutputDerivatives; see `CoSimulation::output_derivatives`.
    ///
    /// # Errors
    /// As there.
    pub fn output_derivatives(
        &mut self,
        items: impl Iterator<Item = (u32, i32)> + Clone,
    ) -> Result<Vec<f64>, Refusal> {
        let (co_simulation, unit) = self.co_simulation()?;
        co_simulation.output_derivatives(unit, items)
    }

    /// fmi2DoStep; see `CoSimulation::step`.
    ///
    /// # Errors
    /// As there. A step that is discarded for its inputs, and tried again as it was, is an error: it would be tried for ever.
    pub fn do_step(&mut self, point: f64, step: f64) -> Result<(), Refusal> {
        let (co_simulation, unit) = self.co_simulation()?;
        if let Err(mut refusal) = co_simulation.step(unit, point, step) {
            if refusal.severity == Severity::Discard {
                let tried = Some(([point, step], unit.inputs().clone()));
                if self.discarded == tried {
                    refusal.severity = Severity::Error;
                }
                self.discarded = tried;
            }
            return Err(refusal);
        }
        self.watch_range();
        Ok(())
    }

    /// Says when the gears leave the range where outputs are to be trusted, and when they come back.
    fn watch_range(&mut self) {
        let is_out = self.unit.present().any(|outputs| outputs.all.out_of_range);
        if is_out == self.was_out_of_range {
            return;
        }
        self.was_out_of_range = is_out;
        let time = number(self.time());
        // Loads come and go with every oscillation; a pose out of range is somebody's mistake or decision.
        self.events.push(match self.unit.out_of_range() {
            Some(reasons) => {
                self.departures += 1;
                match self.departures {
                    ..=MOST_WARNINGS => {
                        Event::Warned(format!("t = {time} s: out of range: {reasons}"))
                    }
                    n if n == MOST_WARNINGS + 1 => Event::Warned(format!(
                        "t = {time} s: out of range for the {n}th time: no more warnings of this follow"
                    )),
                    _ => return,
                }
            }
            None if is_out => Event::Told(format!(
                "t = {time} s: the load left the range of the table"
            )),
            None => Event::Told(format!("t = {time} s: in range again")),
        });
    }

    /// fmi2SetTime.
    ///
    /// # Errors
    /// A time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), Refusal> {
        self.simulation.clock().set(time)
    }

    /// All that a later result depends on.
    pub(super) fn snapshot(&self) -> Snapshot {
        Snapshot {
            state: self.state,
            simulation: self.simulation.clone(),
            point: self.unit.point(),
            out_of_range: self.was_out_of_range,
        }
    }

    /// Refuses a snapshot that no instance of this unit and interface has made.
    ///
    /// # Errors
    /// What does not fit.
    pub(super) fn check(&self, snapshot: &Snapshot) -> Result<(), Refusal> {
        let own = self.simulation.interface();
        let found = snapshot.simulation.interface();
        if found != own {
            return Err(Refusal::error(format!(
                "the stored state belongs to {found:?}; this instance was made for {own:?}"
            )));
        }
        snapshot.point.settings()?;
        let fits = match snapshot.state {
            State::Instantiated | State::InitializationMode | State::Error => true,
            State::StepComplete => own == Interface::CoSimulation && snapshot.point.has_phases(),
            State::EventMode | State::ContinuousTimeMode => {
                own == Interface::ModelExchange && snapshot.point.has_phases()
            }
            State::Terminated => snapshot.point.has_phases(),
            State::Fatal => false,
        };
        let follows = match &snapshot.simulation {
            Simulation::CoSimulation(co_simulation) => co_simulation.polynomials.fits(inputs()),
            Simulation::ModelExchange(_) => true,
        };
        if fits && follows {
            return Ok(());
        }
        Err(Refusal::error(format!(
            "the stored state is {:?} with phases, or with derivatives of inputs, that no {own:?} of this unit has",
            snapshot.state
        )))
    }

    /// Back to a snapshot of this unit.
    ///
    /// # Errors
    /// A snapshot of the other interface, or one that does not fit; nothing is changed.
    pub(super) fn go_to(&mut self, snapshot: &Snapshot) -> Result<(), Refusal> {
        self.check(snapshot)?;
        self.unit.go_to(&snapshot.point)?;
        self.state = snapshot.state;
        self.simulation = snapshot.simulation.clone();
        self.was_out_of_range = snapshot.out_of_range;
        self.discarded = None;
        Ok(())
    }
}

/// Indices of variables whose references follow one another, within inputs or within outputs.
fn block(references: &[u32]) -> Option<std::ops::Range<usize>> {
    let first = *references.first()?;
    // Without a branch for each, so that the compiler takes several at once.
    let places = references.iter().zip(0..);
    let differ = places.fold(0, |d, (&r, k)| d | (r ^ first.wrapping_add(k)));
    let (start, end) = (index_of(first)?, index_of(*references.last()?)? + 1);
    (differ == 0 && end == start + references.len()).then_some(start..end)
}

/// Whether all of `values` are finite, several at once.
fn all_finite(values: &[f64]) -> bool {
    // One more than the exponent of what is not finite carries into the sign.
    const EXPONENT: u64 = 0x7ff << 52;
    let carries = |x: &f64| (x.to_bits() & EXPONENT) + (1 << 52);
    values.iter().fold(0, |any, x| any | carries(x)) >> 63 == 0
}
