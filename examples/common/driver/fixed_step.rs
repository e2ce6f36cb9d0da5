//! Explicit integrators with a fixed step.

use super::scene::Scene;
use super::state::{GEAR_STATES, State, gear_state, set_gear_state};
use gearmesh::element::ElementError;
use nalgebra::UnitQuaternion;

/// Fixed-step integrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Velocities first, then positions with the new velocities; first order, symplectic.
    SemiImplicitEuler,
    /// Classical Runge-Kutta, fourth order.
    RungeKutta4,
}

impl Method {
    /// `state` one step `h` (s) after `t`.
    ///
    /// # Errors
    /// As the element's evaluation.
    pub fn step(self, scene: &Scene, t: f64, state: &State, h: f64) -> Result<State, ElementError> {
        match self {
            Method::SemiImplicitEuler => {
                let rates = scene.coupled_rates(t, state)?;
                Ok(drift(scene, t, &kick(state, &rates, h), h))
            }
            Method::RungeKutta4 => runge_kutta_4(t, state, h, |t, y| scene.coupled_rates(t, y)),
        }
    }
}

/// One classical Runge-Kutta step of y' = f(t, y).
///
/// # Errors
/// Those of `f`.
pub(super) fn runge_kutta_4<E>(
    t: f64,
    y: &State,
    h: f64,
    f: impl Fn(f64, &State) -> Result<State, E>,
) -> Result<State, E> {
    let ahead = |k: &State, h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let k1 = f(t, y)?;
    let k2 = f(t + 0.5 * h, &ahead(&k1, 0.5 * h))?;
    let k3 = f(t + 0.5 * h, &ahead(&k2, 0.5 * h))?;
    let k4 = f(t + h, &ahead(&k3, h))?;
    Ok(std::array::from_fn(|i| {
        y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
    }))
}

/// Velocities and angular momenta advanced by `h` at fixed positions.
fn kick(state: &State, rates: &State, h: f64) -> State {
    let mut out = *state;
    for i in 0..2 {
        for k in 7..GEAR_STATES {
            out[i * GEAR_STATES + k] += h * rates[i * GEAR_STATES + k];
        }
    }
    out
}

/// Positions advanced by `h` at fixed velocities and angular momenta; the rotation with the angular
/// velocity half-way, which changes with the axis.
fn drift(scene: &Scene, t: f64, state: &State, h: f64) -> State {
    let mut out = *state;
    for i in 0..2 {
        let mut g = gear_state(state, i);
        let start = scene.angular_velocity(t, i, &g);
        let mut half = g;
        half.q = UnitQuaternion::from_scaled_axis(start * (0.5 * h)) * g.q;
        let w = scene.angular_velocity(t + 0.5 * h, i, &half);
        g.q = UnitQuaternion::from_scaled_axis(w * h) * g.q;
        g.p += g.v * h;
        set_gear_state(&mut out, i, &g);
    }
    out
}
