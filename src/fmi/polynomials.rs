//! Inputs as functions of time inside a communication step.
//!
//! An input whose derivatives the host gave (fmi2SetRealInputDerivatives) follows its Taylor polynomial
//! about the start of the step; a step moves value and derivatives to its end, so that an input that is
//! not set anew goes on along its polynomial.

use nalgebra::Vector3;

use super::inputs::InputValues;
use super::layout::{ANGULAR_VELOCITY, BODIES, VELOCITY};
use super::settings::Orientation;

/// Highest order of input derivatives that is taken.
pub const MAXIMUM_ORDER: usize = 3;

/// Derivatives of order 1, 2, .. of one input.
type Derivatives = [f64; MAXIMUM_ORDER];

/// Time derivatives of the inputs at the current communication point.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Polynomials {
    /// Of each input, once the host gave them.
    given: Vec<Option<Derivatives>>,
    count: usize,
}

impl Polynomials {
    /// Constant inputs, `count` of them.
    pub fn constant(count: usize) -> Self {
        Self {
            given: vec![None; count],
            count: 0,
        }
    }

    /// fmi2SetRealInputDerivatives of input `i`, `order` from 1 to [`MAXIMUM_ORDER`].
    pub fn set(&mut self, i: usize, order: usize, value: f64) {
        self.count += usize::from(self.given[i].is_none());
        self.given[i].get_or_insert_default()[order - 1] = value;
    }

    /// fmi2SetReal of input `i`: a new value clears its derivatives.
    #[inline]
    pub fn clear(&mut self, i: usize) {
        if self.count > 0 && self.given[i].take().is_some() {
            self.count -= 1;
        }
    }

    /// Whether all inputs are constant.
    pub fn is_constant(&self) -> bool {
        self.count == 0
    }

    /// Whether the host gave derivatives of the position or orientation of `body`.
    pub fn moves(&self, body: usize) -> bool {
        let first = BODIES[body].first;
        let mut pose = self.given[first..first + VELOCITY].iter();
        self.count > 0 && pose.any(Option::is_some)
    }

    /// All derivatives are finite; else the input of one that is not.
    pub fn finite(&self) -> Result<(), usize> {
        let bad = |d: &Option<Derivatives>| d.is_some_and(|d| d.iter().any(|x| !x.is_finite()));
        self.given.iter().position(bad).map_or(Ok(()), Err)
    }

    fn of(&self, i: usize) -> Derivatives {
        self.given[i].unwrap_or_default()
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

    /// Moves the inputs and their derivatives on by `h` s.
    pub fn advance(&mut self, inputs: &mut InputValues, h: f64) {
        for (i, derivative) in self.given.iter_mut().enumerate() {
            let Some(derivative) = derivative else {
                continue;
            };
            inputs.advance(i, taylor(derivative, h) * h);
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
    fn an_input_follows_its_polynomial_over_two_steps() {
        let mut values = InputValues::new(vec![0.0; inputs()]);
        let mut polynomials = Polynomials::constant(inputs());
        let p = |t: f64| 2.0 + 3.0 * t - 0.5 * t * t + 4.0 * t * t * t;
        values.set(0, p(0.0));
        polynomials.set(0, 1, 3.0);
        polynomials.set(0, 2, -1.0);
        polynomials.set(0, 3, 24.0);
        polynomials.advance(&mut values, 0.25);
        polynomials.advance(&mut values, 0.5);
        assert_abs_diff_eq!(values.get(0), p(0.75), epsilon = 1e-14);
        polynomials.clear(0);
        assert!(polynomials.is_constant());
        let before = values.clone();
        polynomials.advance(&mut values, 1.0);
        assert_eq!(values, before);
    }

    #[test]
    fn a_body_moves_by_the_integral_of_its_velocity_until_the_host_gives_its_pose_a_rate() {
        let mut values = InputValues::new(vec![0.0; inputs()]);
        let mut polynomials = Polynomials::constant(inputs());
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
        let mut polynomials = Polynomials::constant(inputs());
        polynomials.set(7, 3, 1e308);
        assert_eq!(polynomials.finite(), Ok(()));
        polynomials.advance(&mut values, 1e3);
        assert_eq!(polynomials.finite(), Err(7));
        assert_eq!(values.finite(), Err(7));
    }
}
