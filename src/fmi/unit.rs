//! The unit without time: outputs as a pure function of inputs, parameters and phase zeros.
//!
//! [`super::co_simulation`] and model exchange both stand on it. Outputs and derivatives are made when
//! they are asked for, so hosts may set and get without a step between, and go back in time.

use std::sync::Arc;

use nalgebra::Vector3;

use super::inputs::{InputValues, Part};
use super::layout::{MESHES, Role, body_of, inputs, role};
use super::mesh::{Evaluated, Failure, Freedoms, Mesh};
use super::report::Refusal;
use super::resources::Resources;
use super::settings::{FIELDS, Orientation, Settings};
use super::values::{Value, accept, check_finite, find};
use super::variables::{Kind, VARIABLES, index};
use crate::element::{BODY_COLUMNS, CONTINUOUS_OUTPUTS, Latch};
use crate::words::number;

/// Values or slopes of all outputs of a mesh.
type Outputs = [f64; CONTINUOUS_OUTPUTS];

/// The unit of one instance.
pub struct Unit {
    resources: Arc<Resources>,
    inputs: InputValues,
    meshes: Vec<Mesh>,
}

/// Everything that the outputs are a function of.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Point {
    inputs: InputValues,
    /// Of each mesh.
    meshes: Vec<MeshPoint>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
struct MeshPoint {
    /// Numbers of the parameters in their order, as start values write them.
    parameters: Vec<f64>,
    latch: Option<Latch>,
}

impl Unit {
    /// The unit with its start values.
    pub fn new(resources: Arc<Resources>) -> Self {
        let starts = &resources.starts;
        let meshes = MESHES.iter().zip(&starts.settings);
        let pair = &resources.unit.geometry;
        let meshes = meshes.map(|(mesh, settings)| Mesh::new(mesh, settings.clone(), pair));
        Self {
            inputs: InputValues::new(starts.inputs.clone()),
            meshes: meshes.collect(),
            resources,
        }
    }

    /// What packing put beside the library.
    pub fn resources(&self) -> &Arc<Resources> {
        &self.resources
    }

    /// The inputs.
    pub fn inputs(&self) -> &InputValues {
        &self.inputs
    }

    /// Puts other inputs in their place and returns those before.
    pub fn replace_inputs(&mut self, inputs: InputValues) -> InputValues {
        self.forget();
        std::mem::replace(&mut self.inputs, inputs)
    }

    fn forget(&mut self) {
        self.meshes.iter_mut().for_each(Mesh::forget);
    }

    /// Orientation inputs in use of a body whose pose moves with its velocities inside a step.
    pub fn extrapolates(&self, body: usize) -> Option<Orientation> {
        let uses = |mesh: &&Mesh| mesh.settings().extrapolate_poses && mesh.looks_at(body);
        Some(self.meshes.iter().find(uses)?.settings().orientation)
    }

    /// The point it stands at, to come back to.
    pub fn point(&self) -> Point {
        let meshes = self.meshes.iter().map(|mesh| MeshPoint {
            parameters: mesh.settings().numbers(),
            latch: mesh.latch(),
        });
        Point {
            inputs: self.inputs.clone(),
            meshes: meshes.collect(),
        }
    }

    /// Goes to `point`, which came from [`Unit::point`] of this unit, in this process or another one.
    ///
    /// # Errors
    /// A point with other variables or illegal numbers; nothing is changed.
    pub fn go_to(&mut self, point: &Point) -> Result<(), Refusal> {
        let settings = point.settings()?;
        self.inputs = point.inputs.clone();
        for ((mesh, settings), to) in self.meshes.iter_mut().zip(settings).zip(&point.meshes) {
            mesh.configure(settings, to.latch)?;
        }
        Ok(())
    }

    /// The inputs, to be set.
    #[inline]
    pub fn inputs_mut(&mut self) -> &mut InputValues {
        self.forget();
        &mut self.inputs
    }

    /// Sets the parameter with the index `i` in [`VARIABLES`], if its type has `value`.
    ///
    /// # Errors
    /// As [`Mesh::configure`].
    pub fn set_parameter(&mut self, i: usize, value: Value) -> Result<(), Refusal> {
        let Role::Parameter { mesh, field } = role(i) else {
            return Ok(());
        };
        let mesh = &mut self.meshes[mesh];
        let mut settings = mesh.settings().clone();
        (FIELDS[field].set)(&mut settings, value);
        let latch = mesh.latch();
        mesh.configure(settings, latch)
    }

    /// Value of the variable with the index `i` in [`VARIABLES`].
    ///
    /// # Errors
    /// Inputs or parameters at which there are no outputs.
    pub fn get(&mut self, i: usize) -> Result<Value, Refusal> {
        Ok(match role(i) {
            Role::Input => Value::Real(self.inputs.get(i)),
            Role::Parameter { mesh, field } => (FIELDS[field].get)(self.meshes[mesh].settings()),
            Role::Output { mesh, row } => Value::Real(self.outputs(mesh)?.continuous[row]),
        })
    }

    /// Outputs that are at hand, as (index of the first in [`VARIABLES`], values), of one mesh:
    /// hosts read them in every step.
    #[inline]
    pub fn at_hand(&self) -> Option<(usize, &[f64])> {
        let mesh = self.meshes.first()?;
        Some((mesh.variables().outputs, &mesh.present()?.continuous))
    }

    /// Makes the outputs at the present inputs, unless they are at hand.
    ///
    /// # Errors
    /// Inputs or parameters at which there are no outputs.
    pub fn evaluate(&mut self) -> Result<(), Refusal> {
        (0..self.meshes.len()).try_for_each(|mesh| self.outputs(mesh).map(drop))
    }

    /// Outputs of each mesh that are at hand.
    pub fn present(&self) -> impl Iterator<Item = &Evaluated> {
        self.meshes.iter().filter_map(Mesh::present)
    }

    /// What puts the poses out of range at which the outputs are at hand; `None` where they are in range.
    pub fn out_of_range(&mut self) -> Option<String> {
        let (resources, inputs) = (&self.resources, &self.inputs);
        let meshes = self.meshes.iter_mut();
        let reasons: Vec<String> = meshes
            .filter_map(|mesh| mesh.out_of_range(resources, inputs))
            .filter(|reasons| !reasons.is_empty())
            .collect();
        (!reasons.is_empty()).then(|| reasons.join("; "))
    }

    fn outputs(&mut self, mesh: usize) -> Result<&Evaluated, Refusal> {
        // The borrow of a result that is returned early would last: look first, then return.
        if self.meshes[mesh].present().is_none() {
            let made = self.meshes[mesh].evaluate(&self.resources, &self.inputs);
            if let Err(failure) = made.map(drop) {
                return Err(self.explain(mesh, "", failure));
            }
        }
        Ok(self.meshes[mesh].present().expect("made above"))
    }

    fn explain(&self, mesh: usize, what: &str, failure: Failure) -> Refusal {
        match failure {
            Failure::Refused(refusal) => refusal,
            Failure::NotFinite(row) => {
                let name = VARIABLES[MESHES[mesh].outputs + row].name;
                let what = format!("{what}{name} is not finite");
                match self.inputs.largest() {
                    (i, size) if size.abs() > OUT_OF_PROPORTION => self.overflow(i, &what),
                    _ => Refusal::error(format!(
                        "{what}, though no input is out of proportion: check the parameters and the unit's tables"
                    )),
                }
            }
        }
    }

    /// Numbers so large that nothing can be computed; `i` is the input to look at.
    pub fn overflow(&self, i: usize, what: &str) -> Refusal {
        Refusal::discard(format!(
            "{what}: check {} = {}, its derivatives and the parameters for numbers out of all proportion",
            VARIABLES[i].name,
            number(self.inputs.get(i))
        ))
    }

    /// Takes the phases of the teeth from the present pose, and makes the outputs there.
    ///
    /// # Errors
    /// Parameters or poses that make no mesh; phases and outputs are as before.
    pub fn take_phases(&mut self) -> Result<(), Refusal> {
        let before = self.point();
        let mut outcome = Ok(());
        for mesh in &mut self.meshes {
            outcome = outcome.and_then(|()| mesh.take_phase(&self.resources, &self.inputs));
        }
        let outcome = outcome.and_then(|()| self.evaluate());
        if outcome.is_err() {
            self.go_to(&before)?;
        }
        outcome
    }

    /// fmi2GetDirectionalDerivative: derivatives of the `unknown` outputs, in their order, along the
    /// change of inputs that `known` gives as (value reference, seed). Exact for the formulation in
    /// use; in Initialization Mode the phases of the teeth follow the pose, and the derivatives with
    /// them. Inputs that the formulation does not look at change nothing. In Initialization Mode Real parameters
    /// are among what is known, too: by differences of the outputs, good to some eight digits.
    ///
    /// # Errors
    /// References that are no outputs, inputs or such parameters, seeds that are not finite, inputs at
    /// which there are no outputs.
    pub fn directional_derivative(
        &mut self,
        unknown: &[u32],
        known: impl Iterator<Item = (u32, f64)>,
    ) -> Result<Vec<f64>, Refusal> {
        const FUNCTION: &str = "fmi2GetDirectionalDerivative";
        let places = places(FUNCTION, unknown.iter().copied())?;
        let mut directions = vec![Freedoms::zeros(); self.meshes.len()];
        let mut parameters = Vec::new();
        for (reference, seed) in known {
            let i = find(FUNCTION, Kind::Real, reference)?;
            let name = VARIABLES[i].name;
            check_finite(FUNCTION, &format!("the seed of {name}"), seed)?;
            match role(i) {
                Role::Input => {}
                Role::Parameter { mesh, field } if self.meshes[mesh].latch().is_none() => {
                    parameters.push((mesh, field, i, seed));
                    continue;
                }
                Role::Parameter { .. } => {
                    return Err(Refusal::error(format!(
                        "{FUNCTION}: {name} is no input; by parameters there are derivatives in Initialization Mode alone"
                    )));
                }
                Role::Output { .. } => {
                    return Err(Refusal::error(format!("{FUNCTION}: {name} is no input")));
                }
            }
            for (mesh, direction) in self.meshes.iter().zip(&mut directions) {
                let orientation = mesh.settings().orientation;
                let (part, change) = self.inputs.direction(i, orientation);
                for (k, body) in mesh.variables().bodies().into_iter().enumerate() {
                    if body_of(i) == body {
                        add(direction, k, part, change * seed);
                    }
                }
            }
        }
        let mut rows = self.rows(&places, &directions)?;
        for (mesh, field, i, seed) in parameters {
            let slopes = self.by_parameter(mesh, field, i)?;
            for (sum, (of, row)) in rows.iter_mut().zip(&places) {
                *sum += if *of == mesh {
                    seed * slopes[*row]
                } else {
                    0.0
                };
            }
        }
        Ok(rows)
    }

    /// Derivatives of the outputs of a mesh by its Real parameter in the place `field`, the variable `i`: by differences, from one side where
    /// the other is no value of it.
    fn by_parameter(&mut self, mesh: usize, field: usize, i: usize) -> Result<Outputs, Refusal> {
        /// Of the larger one of value and nominal value.
        const STEP: f64 = 1e-5;
        let settings = self.meshes[mesh].settings().clone();
        let value = (FIELDS[field].get)(&settings).number();
        let step = STEP * value.abs().max(VARIABLES[i].nominal);
        let at = |x: f64| {
            let mut settings = settings.clone();
            (FIELDS[field].set)(&mut settings, Value::Real(x));
            // The mesh that it stands beside holds its tables.
            let mut beside = Mesh::new(&MESHES[mesh], settings, &self.resources.unit.geometry);
            let made = beside.evaluate(&self.resources, &self.inputs);
            let made = made.map(|outputs| (x, outputs.continuous));
            made.map_err(|failure| self.explain(mesh, "", failure))
        };
        let (high, above) = at(value + step).or_else(|_| at(value))?;
        let (low, below) = at(value - step).or_else(|_| at(value))?;
        Ok(std::array::from_fn(|row| {
            (above[row] - below[row]) / (high - low)
        }))
    }

    /// Time derivatives of the outputs with these references: poses change with the velocity inputs,
    /// which are their derivatives, and velocities with `acceleration` (of a body: linear, angular).
    ///
    /// # Errors
    /// References that are no outputs, inputs at which there are no outputs.
    pub fn rates(
        &mut self,
        function: &str,
        references: impl Iterator<Item = u32>,
        acceleration: impl Fn(usize) -> [Vector3<f64>; 2],
    ) -> Result<Vec<f64>, Refusal> {
        let places = places(function, references)?;
        let mut directions = vec![Freedoms::zeros(); self.meshes.len()];
        for (mesh, direction) in self.meshes.iter().zip(&mut directions) {
            for (k, body) in mesh.variables().bodies().into_iter().enumerate() {
                let [v, w] = self.inputs.velocities(body);
                let [a, alpha] = acceleration(body);
                add(direction, k, Part::Translation, v);
                add(direction, k, Part::Rotation, w);
                add(direction, k, Part::Velocity, a);
                add(direction, k, Part::AngularVelocity, alpha);
            }
        }
        self.rows(&places, &directions)
    }

    fn rows(
        &mut self,
        places: &[(usize, usize)],
        directions: &[Freedoms],
    ) -> Result<Vec<f64>, Refusal> {
        let mut all = Vec::with_capacity(directions.len());
        const STIFFNESS: usize = index::MESH_STIFFNESS - index::GEAR1_FORCE_1;
        for (k, direction) in directions.iter().enumerate() {
            let stiffness = places.contains(&(k, STIFFNESS));
            let mesh = &mut self.meshes[k];
            all.push(mesh.along(&self.resources, &self.inputs, direction, stiffness)?);
        }
        let row = |&(mesh, row): &(usize, usize)| {
            let slope = all[mesh][row];
            let fails = || self.explain(mesh, "the derivative of ", Failure::NotFinite(row));
            slope.is_finite().then_some(slope).ok_or_else(fails)
        };
        places.iter().map(row).collect()
    }
}

/// In SI units; beyond it lies no place, angle or speed of a gear.
const OUT_OF_PROPORTION: f64 = 1e12;

impl Point {
    /// Whether the phases of all teeth are taken.
    pub fn has_phases(&self) -> bool {
        self.meshes.iter().all(|mesh| mesh.latch.is_some())
    }

    /// The settings of its meshes.
    ///
    /// # Errors
    /// A point of another unit: other inputs or parameters, or numbers that are none of their values.
    pub fn settings(&self) -> Result<Vec<Settings>, Refusal> {
        const FUNCTION: &str = "fmi2SetFMUstate";
        let sizes = |mesh: &MeshPoint| mesh.parameters.len() == FIELDS.len();
        if self.meshes.len() != MESHES.len()
            || !self.inputs.fits(inputs())
            || !self.meshes.iter().all(sizes)
        {
            let said = "the stored state has parameters or inputs that this unit has not";
            return Err(Refusal::error(said));
        }
        let of = |mesh: &MeshPoint, first: usize| {
            for (variable, number) in VARIABLES[first..].iter().zip(&mesh.parameters) {
                accept(FUNCTION, variable, *number)?;
            }
            Settings::of_starts(first, |i| mesh.parameters[i - first])
                .map_err(|variable| Refusal::error(format!("{FUNCTION}: {}", variable.name)))
        };
        let meshes = self.meshes.iter().zip(MESHES);
        meshes.map(|(mesh, m)| of(mesh, m.parameters)).collect()
    }
}

/// Adds to a direction of a mesh's body (0, 1: gears, 2: carrier). The place and the velocity of the
/// carrier's origin change nothing.
fn add(direction: &mut Freedoms, body: usize, part: Part, change: Vector3<f64>) {
    let is_place = matches!(part, Part::Translation | Part::Velocity);
    if body == 2 && is_place {
        return;
    }
    let mut rows = direction.fixed_rows_mut::<3>(BODY_COLUMNS * body + 3 * part as usize);
    rows += change;
}

/// Meshes and rows of the outputs with these references.
fn places(
    function: &str,
    references: impl Iterator<Item = u32>,
) -> Result<Vec<(usize, usize)>, Refusal> {
    references
        .map(|reference| {
            let i = find(function, Kind::Real, reference)?;
            match role(i) {
                Role::Output { mesh, row } => Ok((mesh, row)),
                _ => {
                    let name = VARIABLES[i].name;
                    Err(Refusal::error(format!("{function}: {name} is no output")))
                }
            }
        })
        .collect()
}
