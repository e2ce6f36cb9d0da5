//! Contact of one tooth pair, all other teeth out of the way.

use super::error::ContactError;
use super::position::PositionProblem;
use super::solver::ContactSolver;
use crate::gear::Flank;

impl ContactSolver {
    /// Places, in base pitches from where it touches at the pitch point at mid-face, between which a tooth pair comes within
    /// the reach of contact at the deviation `center_distance_offset` (m).
    ///
    /// # Errors
    /// [`ContactError::OutOfMesh`] where teeth cannot meet.
    pub fn passage(
        &self,
        flank: Flank,
        center_distance_offset: f64,
    ) -> Result<[f64; 2], ContactError> {
        let section = self.section(center_distance_offset)?;
        Ok(self.setup.lines(flank, &section).passage())
    }

    /// As [`ContactSolver::position`] of tooth pair 0 alone, at `place`.
    ///
    /// # Errors
    /// As there; [`ContactError::OutOfMesh`] where it is not within reach.
    pub fn tooth_pair(
        &self,
        flank: Flank,
        place: f64,
        center_distance_offset: f64,
    ) -> Result<PositionProblem, ContactError> {
        let section = self.section(center_distance_offset)?;
        let lines = self.setup.lines(flank, &section);
        let candidates = lines.of_pair(place, 0).collect();
        self.problem(&lines, place, candidates, center_distance_offset)
    }

    /// Approach at which tooth pair 0, alone, first touches at `place` and `misalignment` (rad), m; infinite where it is not
    /// within reach.
    ///
    /// # Errors
    /// As [`ContactSolver::passage`].
    pub fn first_touch(
        &self,
        flank: Flank,
        place: f64,
        center_distance_offset: f64,
        misalignment: f64,
    ) -> Result<f64, ContactError> {
        let section = self.section(center_distance_offset)?;
        let lines = self.setup.lines(flank, &section);
        let touches = lines.of_pair(place, 0).flat_map(|strip| {
            let points = strip.levers.into_iter().zip(strip.gap);
            points.map(move |(lever, gap)| (gap - misalignment * lever) / strip.arms[0])
        });
        Ok(touches.fold(f64::INFINITY, f64::min))
    }
}
