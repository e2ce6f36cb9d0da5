//! Inputs as functions of time inside a communication step.
//!
//! An input whose derivatives the host gave (fmi2SetRealInputDerivatives) follows its Taylor polynomial
//! about the start of the step to come, whether its value was set before them or after. At the end of the step it
//! stands where the polynomial led; it goes no further, unless derivatives are given again.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::inputs::InputValues;
use super::layout::{ANGULAR_VELOCITY, BODIES, VELOCITY};
use super::settings::Orientation;

/// Highest order of input derivatives that is taken.
pub const MAXIMUM_ORDER: usize = 3;

/// Derivatives of order 1, 2, .. of one input.
type Derivatives = [f64; MAXIMUM_ORDER];

/// Time derivatives of the inputs at the current communication point.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Polynomials {
    /// By input, where the host gave them.
    given: BTreeMap<usize, Derivatives>,
    /// Whether the step is done that they were given for.
    done: bool,
}

impl Polynomials {
    /// fmi2SetRealInputDerivatives of input `i`, `order` from 1 to [`MAXIMUM_ORDER`].
    pub fn set(&mut self, i: usize, order: usize, value: f64) {
        *self = self.to_come();
        self.given.entry(i).or_default()[order - 1] = value;
    }

    /// Those of the step to come.
    pub fn to_come(&self) -> Self {
        match self.done {
            true => Self::default(),
            false => self.clone(),
        }
    }

    /// Whether all inputs are constant.
    pub fn is_constant(&self) -> bool {
        self.given.is_empty()
    }

    /// Whether these are derivatives of `count` inputs.
    pub fn fits(&self, count: usize) -> bool {
        self.given.keys().all(|i| *i < count)
    }

    /// Whether the host gave derivatives of the position or orientation of `body`.
    pub fn moves(&self, body: usize) -> bool {
        let first = BODIES[body].first;
        self.given.range(first..first + VELOCITY).next().is_some()
    }

    /// All derivatives are finite; else the input of one that is not.
    pub fn finite(&self) -> Result<(), usize> {
        let mut all = self.given.iter();
        let bad = all.find(|(_, d)| d.iter().any(|x| !x.is_finite()));
        bad.map_or(Ok(()), |(i, _)| Err(*i))
    }

    fn of(&self, i: usize) -> Derivatives {
        self.given.get(&i).copied().unwrap_or_default()
    }

    /// Time derivatives of the velocity inputs: acceleration and angular acceleration of `body`.
    pub fn acceleration(&self, body: usize) -> [Vector3<f64>; 2] {
        let first = BODIES[body].first;
        [VELOCITY, ANGULAR_VELOCITY].map(|at| Vector3::from_fn(|k, _| self.of(first + at + k)[0]))
    }

    /// Moves `body` over `h` s with its velocity inputs, each integrated along its polynomial.
    pub fn move_body(
        &self,
        inputs: &mut InputValues,
        body: usize,
        h: f64,
        orientation: Orientation,
    ) {
        let first = BODIES[body].first;
        let way = |at: usize| {
            Vector3::from_fn(|k, _| {
                let i = first + at + k;
                let [d1, d2, d3] = self.of(i);
                h * (inputs.get(i) + h / 2.0 * (d1 + h / 3.0 * (d2 + h / 4.0 * d3)))
            })
        };
        let (moved, turned) = (way(VELOCITY), way(ANGULAR_VELOCITY));
        inputs.move_body(body, moved, turned, orientation);
    }

    /// Moves the inputs and their derivatives on by `h` s, to the end of the step.
    pub fn advance(&mut self, inputs: &mut InputValues, h: f64) {
        self.done = true;
        for (i, derivative) in &mut self.given {
            inputs.advance(*i, taylor(derivative, h) * h);
            for k in 0..MAXIMUM_ORDER - 1 {
                derivative[k] += taylor(&derivative[k + 1..], h) * h;
            }
        }
    }
}

/// d1 + d2 h/2! + d3 h^2/3! + ...
fn taylor(derivative: &[f64], h: f64) -> f64 {
    derivative
        .iter()
        .enumerate()
        .rev()
        .fold(0.0, |sum, (k, d)| (sum * h + d) / (k as f64 + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::layout::{POSITION, inputs};
    use approx::assert_abs_diff_eq;

    #[test]
    fn an_input_follows_its_polynomial_over_one_step() {
        let mut values = InputValues::new(vec![0.0; inputs()]);
        let mut polynomials = Polynomials::default();
        let p = |t: f64| 2.0 + 3.0 * t - 0.5 * t * t + 4.0 * t * t * t;
        polynomials.set(0, 1, 3.0);
        polynomials.set(0, 2, -1.0);
        polynomials.set(0, 3, 24.0);
        values.set(0, p(0.0));
        polynomials.advance(&mut values, 0.75);
        assert_abs_diff_eq!(values.get(0), p(0.75), epsilon = 1e-14);
        assert!(polynomials.to_come().is_constant());
        polynomials.set(1, 1, 1.0);
        polynomials.advance(&mut values, 1.0);
        assert_abs_diff_eq!(values.get(0), p(0.75), epsilon = 1e-14);
    }

    #[test]
    fn a_body_moves_by_the_integral_of_its_velocity_until_the_host_gives_its_pose_a_rate() {
        let mut values = InputValues::new(vec![0.0; inputs()]);
        let mut polynomials = Polynomials::default();
        values.set(VELOCITY, 2.0);
        polynomials.set(VELOCITY, 1, 6.0);
        assert!(!polynomials.moves(0));
        polynomials.move_body(&mut values, 0, 0.5, Orientation::Angles);
        let fine = crate::fmi::inputs::Resolution::new(20.0, 1e-2);
        let p = values.motion(0, Orientation::Angles, fine).unwrap().p;
        assert_abs_diff_eq!(p.x, 2.0 * 0.5 + 3.0 * 0.25, epsilon = 1e-15);
        assert_eq!(values.get(POSITION), 0.0);
        polynomials.set(POSITION, 1, 1.0);
        assert!(polynomials.moves(0) && !polynomials.moves(1));
    }

    #[test]
    fn derivatives_that_overflow_are_told_by_their_input() {
        let mut values = InputValues::new(vec![0.0; inputs()]);
        let mut polynomials = Polynomials::default();
        polynomials.set(7, 3, 1e308);
        assert_eq!(polynomials.finite(), Ok(()));
        polynomials.advance(&mut values, 1e3);
        assert_eq!(polynomials.finite(), Err(7));
        assert_eq!(values.finite(), Err(7));
    }
}
