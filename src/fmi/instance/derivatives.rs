//! Derivatives: of the outputs by inputs, by parameters and by time, and those of the inputs that a host gives.

use super::{Instance, Slopes, row};
use crate::element::{BODY_COLUMNS, Direction};
use crate::fmi::Refusal;
use crate::fmi::inputs::{BODIES, MAXIMUM_ORDER};
use crate::fmi::variables::{
    FIRST_PARAMETER, INPUTS, Kind, OUTPUTS, VARIABLES, check_finite, find, index, output_row,
};

/// Order of the output derivatives that are offered.
const OUTPUT_ORDER: i32 = 1;

impl Instance {
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
