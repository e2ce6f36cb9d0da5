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
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return Ok(Vec::new());
    };
    let equations = Equations(scene);
    let solution = IVP::ode(&equations, first, last, *start)
        .t_eval(times.to_vec())
        .method(
            ExplicitRungeKutta::dop853()
                .rtol(tolerance)
                .atol(tolerance)
                .max_steps(100_000_000),
        )
        .solve()
        .map_err(|e| AdaptiveError::Solver(format!("{e:?}")))?;
    Ok(solution.y)
}
