//! Bodies that are no solids of revolution, in series with the law of the mean body.
//!
//! At the coordinates x = (delta, theta) and y = (C, mesh position) the law W of the mean body stands at x', short of x by the deflection of
//! the bodies under its own force and moment g:
//!
//! ```text
//! x' = x - c g ,   g = dW/dx (x', y) ,   U(x, y) = W(x', y) + g' c g / 2
//! ```
//!
//! with the symmetric c of [`TurningBodies`], which changes with the mesh position. U is stationary in x', so that dU/dx = g and dU/dy =
//! dW/dy - g' (dc/dy) g / 2: one potential, of which the energy is kept. Second derivatives follow with S = (I + H c)^-1, H = d²W/dx²:
//!
//! ```text
//! d²U/dx² = S H ,   dg/dy = S (d²W/dxdy - H c_y g) ,   dx'/dy = -c dg/dy - c_y g
//! ```

use super::motion::ElementError;
use crate::gear::TurningBodies;
use crate::gear::teeth::Counts;
use crate::table::{COORDINATES, Potential};
use nalgebra::{Matrix2, Vector2};
use std::sync::Arc;

/// Newton steps at most; two or three are usual.
const MOST_STEPS: usize = 40;
/// Halvings of a step that leads away.
const MOST_HALVINGS: usize = 8;
/// Step over the approach after which the next one would be rounding: steps shrink quadratically.
const LAST_STEP: f64 = 1e-7;
/// Places of x = (delta, theta) and y = (C, mesh position) among the coordinates.
const X: [usize; 2] = [0, 2];
const Y: [usize; 2] = [1, 3];

/// The bodies of one flank as its law sees them.
#[derive(Clone)]
pub(crate) struct Bodies {
    pub turning: Arc<TurningBodies>,
    /// Factor on what couples force and moment, -1 for a mirrored law, and on what moments do alone; zero where the misalignment has no
    /// effect.
    pub factors: [f64; 2],
}

impl Bodies {
    /// The potential at the coordinates `at` after the mesh cycles `counts`, from that of the mean body, `law`.
    ///
    /// # Errors
    /// Those of the law; no place is found, as where the bodies give less way than their mean and the law is stiffer than they are.
    #[inline(never)]
    pub fn in_series(
        &self,
        at: [f64; COORDINATES],
        counts: Counts,
        mut law: impl FnMut([f64; COORDINATES]) -> Result<Potential, ElementError>,
    ) -> Result<Potential, ElementError> {
        let [by_moment, alone] = self.factors;
        let [c, slope, curvature] = self.turning.compliance(counts, at[3]).map(|c| {
            let tilt = by_moment * c[(0, 1)];
            Matrix2::new(c[(0, 0)], tilt, tilt, alone * c[(1, 1)])
        });
        let start = Vector2::new(at[0], at[2]);
        let mut law_at = |x: &Vector2<f64>| law([x[0], at[1], x[1], at[3]]);
        // What x' is too far by.
        let excess = |x: &Vector2<f64>, w: &Potential| x + c * force(w) - start;
        let mut x = start;
        let mut w = law_at(&x)?;
        let mut step_is_last = false;
        for _ in 0..MOST_STEPS {
            // Without load nothing deflects.
            if step_is_last || w.gradient[0] == 0.0 && x == start {
                return Ok(potential(&w, [&c, &slope, &curvature]));
            }
            let lever = lever(&w);
            let size = |off: &Vector2<f64>| off[0].abs() + lever * off[1].abs();
            let newton = Matrix2::identity() + c * block(&w, X, X);
            let off = excess(&x, &w);
            let Some(mut step) = newton.lu().solve(&-off) else {
                break;
            };
            let mut next = law_at(&(x + step))?;
            for _ in 0..MOST_HALVINGS {
                if size(&excess(&(x + step), &next)) <= size(&off) {
                    break;
                }
                step *= 0.5;
                next = law_at(&(x + step))?;
            }
            x += step;
            w = next;
            step_is_last = size(&step) <= LAST_STEP * (start[0].abs() + x[0].abs());
        }
        Err(ElementError::Law(
            "bodyEffect = true: no balance is found between the teeth and the gear bodies; the load lies far beyond that of the tables, \
             or set bodyEffect = false"
                .into(),
        ))
    }
}

fn force(w: &Potential) -> Vector2<f64> {
    Vector2::from(X.map(|i| w.gradient[i]))
}

fn block(w: &Potential, rows: [usize; 2], columns: [usize; 2]) -> Matrix2<f64> {
    Matrix2::from_fn(|i, j| w.hessian[rows[i]][columns[j]])
}

/// Approach that counts as much as a misalignment of 1 rad, m.
fn lever(w: &Potential) -> f64 {
    let [by_approach, by_misalignment] = X.map(|i| w.hessian[i][i]);
    match by_approach > 0.0 && by_misalignment > 0.0 {
        true => (by_misalignment / by_approach).sqrt(),
        false => 0.0,
    }
}

/// U and its derivatives from W, `w`, at x', under c and its derivatives by the mesh position.
fn potential(w: &Potential, [c, slope, curvature]: [&Matrix2<f64>; 3]) -> Potential {
    let g = force(w);
    let of_force = |c: &Matrix2<f64>| g.dot(&(c * g));
    let mut u = *w;
    u.value += 0.5 * of_force(c);
    u.gradient[3] -= 0.5 * of_force(slope);
    let h = block(w, X, X);
    let Some(softer) = (Matrix2::identity() + h * c).try_inverse() else {
        return u;
    };
    let stiffness = softer * h;
    // Columns by C and by mesh position; c changes with the latter alone.
    let given = slope * g;
    let given = Matrix2::from_columns(&[Vector2::zeros(), given]);
    let crossed = softer * (block(w, X, Y) - h * given);
    let moved = -(c * crossed) - given;
    let mut own = block(w, Y, Y) + block(w, Y, X) * moved;
    let by_slope = Vector2::from(crossed.tr_mul(&(slope * g)));
    own[(1, 0)] -= by_slope[0];
    own[(1, 1)] -= by_slope[1] + 0.5 * of_force(curvature);
    for i in 0..2 {
        for j in 0..2 {
            u.hessian[X[i]][X[j]] = stiffness[(i, j)];
            u.hessian[X[i]][Y[j]] = crossed[(i, j)];
            u.hessian[Y[j]][X[i]] = crossed[(i, j)];
            u.hessian[Y[i]][Y[j]] = own[(i, j)];
        }
    }
    u
}
