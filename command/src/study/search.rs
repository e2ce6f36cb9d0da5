//! Search for the point of least cost by the covariance matrix adaptation evolution strategy (Hansen, The CMA Evolution Strategy:
//! A Tutorial, 2016), which takes no derivatives and bears kinks and several minima.

use std::cell::RefCell;

use basin::{
    BoundedCmaEs, BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError,
    Constraints, CostFunction, DenseMatrix, Executor,
};

use crate::error::{Error, Result};

/// Standard deviation of the first generation about the middle, and of the one at which the search ends, in shares of the ranges.
const FIRST: f64 = 0.3;
const LAST: f64 = 4e-3;

/// Why a search stops.
enum Stop {
    /// As many points as it may try.
    Enough,
    Failed(Error),
}

/// The cost in the unit cube.
struct Cube<F> {
    /// None: no more points.
    cost: RefCell<F>,
    ends: [Vec<f64>; 2],
}

impl<F> Constraints for Cube<F> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        let [low, high] = &self.ends;
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(low), Some(high)))
    }
}

impl<F: FnMut(&[f64]) -> Result<Option<f64>>> CostFunction for Cube<F> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Stop;

    fn cost(&self, point: &Vec<f64>) -> Result<f64, Stop> {
        let cost = (self.cost.borrow_mut())(point).map_err(Stop::Failed)?;
        cost.ok_or(Stop::Enough)
    }
}

/// Tries points of the unit cube of `count` axes, the same ones for the same `seed` and costs, and returns whether they gathered in
/// one place; `cost` ends the search by None.
pub fn search(
    count: usize,
    seed: u64,
    cost: impl FnMut(&[f64]) -> Result<Option<f64>>,
) -> Result<bool> {
    let cube = Cube {
        cost: RefCell::new(cost),
        ends: [vec![0.0; count], vec![1.0; count]],
    };
    let strategy: BoundedCmaEs<Vec<f64>, DenseMatrix> = BoundedCmaEs::new(seed, FIRST);
    let strategy = strategy.with_absolute_distribution_size_tolerance(LAST);
    match Executor::from_start(cube, strategy, vec![0.5; count]).run() {
        Ok(_) => Ok(true),
        Err(ConstraintSolveError::Evaluation(Stop::Enough)) => Ok(false),
        Err(ConstraintSolveError::Evaluation(Stop::Failed(error))) => Err(error),
        Err(_) => Err("the optimizer rejects its ranges".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kinked_minimum_inside_and_at_an_end_is_found_with_the_same_points_in_every_run() {
        for minimum in [[0.3, 0.62], [0.0, 1.0]] {
            let run = |seed, most: usize| {
                let mut points: Vec<Vec<f64>> = Vec::new();
                let ended = search(2, seed, |point| {
                    points.push(point.to_vec());
                    let cost = (point[0] - minimum[0]).abs() + 3.0 * (point[1] - minimum[1]).abs();
                    Ok((points.len() < most).then_some(cost))
                });
                (ended.unwrap(), points)
            };
            let (has_ended, points) = run(1, 1000);
            assert!(has_ended && points.len() < 300, "{}", points.len());
            let distance = |p: &Vec<f64>| (p[0] - minimum[0]).abs().max((p[1] - minimum[1]).abs());
            let nearest = points.iter().map(distance).fold(1.0, f64::min);
            assert!(nearest < 2.0 * LAST, "{nearest}");
            assert_eq!(run(1, 1000).1, points);
            assert_ne!(run(2, 1000).1, points);
            let (has_ended, fewer) = run(1, 20);
            assert_eq!((has_ended, &fewer[..]), (false, &points[..20]));
        }
    }
}
