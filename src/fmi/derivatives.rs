//! Derivatives of the outputs: along a direction of inputs, and in time.

use super::instance::{Instance, refuse};
use super::parameters::orientation;
use super::report::Refusal;
use super::signals::Part;
use super::values::find;
use super::variables::{INPUT_COUNT, Kind, VARIABLES};
use crate::element::{CONTINUOUS_OUTPUTS, InputsChange, MotionChange};

/// Order of the output derivatives that are offered.
const OUTPUT_ORDER: i32 = 1;

impl Instance {
    /// fmi2GetDirectionalDerivative: derivatives of the `unknown` outputs, in their order, along the
    /// change of inputs that `known` gives as (value reference, seed). Exact for the formulation in
    /// use. Inputs of the orientation that is not in use, and the carrier where it is not looked at,
    /// change nothing.
    ///
    /// # Errors
    /// References that are no continuous outputs or inputs, seeds that are not finite, inputs at
    /// which there are no outputs.
    pub fn directional_derivative(
        &mut self,
        unknown: &[u32],
        known: impl Iterator<Item = (u32, f64)>,
    ) -> Result<Vec<f64>, Refusal> {
        const FUNCTION: &str = "fmi2GetDirectionalDerivative";
        let rows = rows(FUNCTION, unknown.iter().copied())?;
        let orientation = orientation(&self.now.parameters);
        let mut change = InputsChange::default();
        for (reference, seed) in known {
            let i = find(FUNCTION, Kind::Real, reference)?;
            let name = VARIABLES[i].name;
            if i >= INPUT_COUNT {
                return Err(Refusal::error(format!("{FUNCTION}: {name} is no input")));
            }
            if !seed.is_finite() {
                return Err(Refusal::error(format!(
                    "{FUNCTION}: seed {seed} of {name} is not finite"
                )));
            }
            let (body, part, direction) = self.now.signals.direction(i, orientation);
            let motion = body_change(&mut change, body);
            let place = match part {
                Part::Translation => &mut motion.p,
                Part::Rotation => &mut motion.rotation,
                Part::Velocity => &mut motion.v,
                Part::AngularVelocity => &mut motion.w,
            };
            *place += direction * seed;
        }
        let all = self.along(&change)?;
        Ok(rows.into_iter().map(|row| all[row]).collect())
    }

    /// fmi2GetRealOutputDerivatives: time derivatives of the outputs at the current communication
    /// point, for pairs of (value reference, order). Poses change with the velocity inputs, which are
    /// their derivatives, and velocities with the input derivatives that the host gave.
    ///
    /// # Errors
    /// References that are no continuous outputs, another order than 1, inputs at which there are no
    /// outputs.
    pub fn output_derivatives(
        &mut self,
        items: impl Iterator<Item = (u32, i32)> + Clone,
    ) -> Result<Vec<f64>, Refusal> {
        const FUNCTION: &str = "fmi2GetRealOutputDerivatives";
        let rows = rows(FUNCTION, items.clone().map(|(reference, _)| reference))?;
        if let Some((_, order)) = items.clone().find(|(_, order)| *order != OUTPUT_ORDER) {
            return Err(Refusal::error(format!(
                "{FUNCTION}: order {order}; order {OUTPUT_ORDER} is offered"
            )));
        }
        let (_, _, inputs) = self.element_and_latch()?;
        let mut change = InputsChange::default();
        for (body, motion) in [&inputs.gears[0], &inputs.gears[1], &inputs.carrier]
            .into_iter()
            .enumerate()
        {
            let [a, alpha] = self.now.signals.acceleration(body);
            *body_change(&mut change, body) = MotionChange {
                p: motion.v,
                rotation: motion.w,
                v: a,
                w: alpha,
            };
        }
        let all = self.along(&change)?;
        Ok(rows.into_iter().map(|row| all[row]).collect())
    }

    fn along(&mut self, change: &InputsChange) -> Result<[f64; CONTINUOUS_OUTPUTS], Refusal> {
        let (element, latch, inputs) = self.element_and_latch()?;
        let all = element
            .directional_derivative(&latch, &inputs, change)
            .map_err(refuse)?;
        match all.iter().position(|x| !x.is_finite()) {
            None => Ok(all),
            Some(row) => {
                let name = VARIABLES[INPUT_COUNT + row].name;
                Err(self.overflow(&format!("the derivative of {name}")))
            }
        }
    }
}

fn body_change(change: &mut InputsChange, body: usize) -> &mut MotionChange {
    match body {
        0 | 1 => &mut change.gears[body],
        _ => &mut change.carrier,
    }
}

/// Rows of the continuous outputs with these references.
fn rows(function: &str, references: impl Iterator<Item = u32>) -> Result<Vec<usize>, Refusal> {
    references
        .map(|reference| {
            let i = find(function, Kind::Real, reference)?;
            i.checked_sub(INPUT_COUNT)
                .filter(|row| *row < CONTINUOUS_OUTPUTS)
                .ok_or_else(|| {
                    let name = VARIABLES[i].name;
                    Refusal::error(format!("{function}: {name} is no output"))
                })
        })
        .collect()
}
