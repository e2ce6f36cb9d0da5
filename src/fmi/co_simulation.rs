//! Co-simulation: communication steps, over which inputs follow polynomials and poses may go on.

use super::clock::Clock;
use super::layout::BODIES;
use super::polynomials::{MAXIMUM_ORDER, Polynomials};
use super::report::Refusal;
use super::unit::Unit;
use super::values::{check_finite, input};

/// Order of the output derivatives that are offered.
const OUTPUT_ORDER: i32 = 1;

/// What co-simulation adds to the unit.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CoSimulation {
    /// Where the simulation stands.
    pub clock: Clock,
    /// The inputs inside the step to come.
    pub polynomials: Polynomials,
}

impl CoSimulation {
    /// fmi2SetRealInputDerivatives, as (value reference, order, value); all or none.
    ///
    /// # Errors
    /// Unknown references, variables that are no inputs, orders beyond 1 to 3, values
    /// that are not finite.
    pub fn set_input_derivatives(
        &mut self,
        items: impl Iterator<Item = (u32, i32, f64)>,
    ) -> Result<(), Refusal> {
        const FUNCTION: &str = "fmi2SetRealInputDerivatives";
        let mut taken = Vec::new();
        for (reference, order, value) in items {
            let (i, name) = input(FUNCTION, reference)?;
            if !usize::try_from(order).is_ok_and(|o| (1..=MAXIMUM_ORDER).contains(&o)) {
                return Err(Refusal::error(format!(
                    "{FUNCTION}: order {order} of {name}; orders 1 to {MAXIMUM_ORDER} are taken"
                )));
            }
            check_finite(FUNCTION, &format!("derivative {order} of {name}"), value)?;
            taken.push((i, order as usize, value));
        }
        for (i, order, value) in taken {
            self.polynomials.set(i, order, value);
        }
        Ok(())
    }

    /// fmi2DoStep: moves the inputs to the end of the step and evaluates there. A step that is refused
    /// changes nothing.
    ///
    /// # Errors
    /// A step that is not positive, does not start where the last one ended, or passes the stop time;
    /// inputs without a right answer.
    pub fn step(&mut self, unit: &mut Unit, point: f64, step: f64) -> Result<(), Refusal> {
        let clock = self.clock.after(point, step)?;
        let moving = |body: &usize| unit.extrapolates(*body).is_some();
        let mut polynomials = self.polynomials.to_come();
        if polynomials.is_constant() && !(0..BODIES.len()).any(|body| moving(&body)) {
            unit.evaluate()?;
        } else {
            let mut inputs = unit.inputs().clone();
            for body in 0..BODIES.len() {
                if let Some(orientation) = unit.extrapolates(body)
                    && !polynomials.moves(body)
                {
                    polynomials.move_body(&mut inputs, body, step, orientation);
                }
            }
            polynomials.advance(&mut inputs, step);
            if let Err(i) = inputs.finite().and(polynomials.finite()) {
                return Err(unit.overflow(i, "fmi2DoStep: an input overflows within the step"));
            }
            let before = unit.replace_inputs(inputs);
            if let Err(refusal) = unit.evaluate() {
                unit.replace_inputs(before);
                return Err(refusal);
            }
        }
        self.polynomials = polynomials;
        self.clock = clock;
        Ok(())
    }

    /// fmi2GetRealOutputDerivatives: time derivatives of the outputs at the current communication
    /// point, for pairs of (value reference, order). Poses change with the velocity inputs, which are
    /// their derivatives, and velocities with the input derivatives that the host gave.
    ///
    /// # Errors
    /// References that are no outputs, another order than 1, inputs at which there are no
    /// outputs.
    pub fn output_derivatives(
        &self,
        unit: &mut Unit,
        items: impl Iterator<Item = (u32, i32)> + Clone,
    ) -> Result<Vec<f64>, Refusal> {
        const FUNCTION: &str = "fmi2GetRealOutputDerivatives";
        if let Some((_, order)) = items.clone().find(|(_, order)| *order != OUTPUT_ORDER) {
            return Err(Refusal::error(format!(
                "{FUNCTION}: order {order}; order {OUTPUT_ORDER} is offered"
            )));
        }
        let references = items.map(|(reference, _)| reference);
        unit.rates(FUNCTION, references, |body| {
            self.polynomials.acceleration(body)
        })
    }
}
