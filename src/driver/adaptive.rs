//! Integration with error control, by the crate `differential-equations`.

use super::scene::Scene;
use super::state::State;
use differential_equations::prelude::*;

/// The solver gave up, or the scene reached a pose without meaning.
#[derive(Debug, thiserror::Error)]
pub enum AdaptiveError {
    /// Message of the solver.
    #[error("integration stopped: {0}")]
    Solver(String),
}

struct Equations<'a>(&'a Scene);

impl ODE<f64, State> for Equations<'_> {
    fn diff(&self, t: f64, y: &State, dydt: &mut State) {
        // The trait has no error path; NaN makes the solver reject the step and, at last, stop.
        *dydt = self
            .0
            .coupled_rates(t, y)
            .unwrap_or([f64::NAN; super::STATES]);
    }
}

/// States at the `times` (s, ascending, the first being that of `start`) by Dormand-Prince 8(5,3) with
/// relative and absolute tolerance `tolerance` on every number of the state.
///
/// # Errors
/// When the solver cannot keep the tolerance or the element refuses a pose.
pub fn integrate(
    scene: &Scene,
    start: &State,
    times: &[f64],
    tolerance: f64,
) -> Result<Vec<State>, AdaptiveError> {
    let equations = Equations(scene);
    let mut states = vec![*start];
    for span in times.windows(2) {
        // One solve for every span: the solver's dense output is less accurate than its steps.
        let solution = IVP::ode(&equations, span[0], span[1], states[states.len() - 1])
            .method(
                ExplicitRungeKutta::dop853()
                    .rtol(tolerance)
                    .atol(tolerance)
                    .max_steps(100_000_000),
            )
            .solve()
            .map_err(|e| AdaptiveError::Solver(format!("{e:?}")))?;
        match solution.y.last() {
            Some(y) => states.push(*y),
            None => return Err(AdaptiveError::Solver("no step was taken".into())),
        }
    }
    Ok(states)
}
