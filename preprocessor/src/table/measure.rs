//! Errors against static solutions at random operating points.

use super::plan::Coverage;
use super::sweep::Watch;
use gearmesh::random::Random;
use gearmesh::table::{Query, TableError};
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// Seed of the points on which stated errors are measured.
pub(super) const SEED: u64 = 0x9E37_79B9_7F4A_7C15;

/// A torque on gear 1, N m, at a query whose approach is not known yet.
pub(super) type OperatingPoint = (f64, Query);

impl Coverage {
    /// `count` random operating points: torques even in (0, maximum), mesh positions in a cycle, the other coordinates in their
    /// ranges.
    pub(super) fn draw(&self, mut random: Random, count: usize) -> Vec<OperatingPoint> {
        (0..count)
            .map(|_| {
                let torque = self.maximum_torque * random.next();
                let query = Query {
                    delta: 0.0,
                    center_distance_offset: drawn(&mut random, self.center_distance_offset),
                    misalignment: drawn(&mut random, self.misalignment),
                    mesh_position: random.next(),
                };
                (torque, query)
            })
            .collect()
    }
}

/// A random value of `range`; 0 where there is none.
pub(super) fn drawn(random: &mut Random, range: Option<[f64; 2]>) -> f64 {
    range.map_or(0.0, |range| random.within(range))
}

/// What `error` finds at each of `points`, in parallel.
pub(super) fn errors<const K: usize>(
    points: Vec<OperatingPoint>,
    watch: &Watch,
    error: impl Fn(OperatingPoint) -> Result<[f64; K], TableError> + Sync,
) -> Result<Vec<[f64; K]>, TableError> {
    let at = |point| match watch.cancel.load(Ordering::Relaxed) {
        true => Err(TableError::Cancelled),
        false => error(point),
    };
    points.into_par_iter().map(at).collect()
}
