//! Stress in the tooth roots at a position and over a mesh cycle that are solved.

use std::sync::Arc;

use rayon::prelude::*;

use super::mesh_cycle::{CycleInput, MeshCycle};
use crate::finite_element::{RootStress, SpreadSegments};
use crate::static_contact::{
    ContactError, ContactResult, ContactSolver, PositionProblem, SegmentLoad,
};
use gearmesh::contact::{RootField, RootPoint, Segment};
use gearmesh::gear::{Flank, PairGeometry};

/// Stress in the root of one tooth at one mesh position. z of its points is in gear 1's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothRoot {
    /// Number of the mesh position in the cycle.
    pub position: usize,
    /// The tooth pair that the tooth belongs to.
    pub tooth_pair: i32,
    /// Where the largest principal stress is largest.
    pub largest: RootPoint,
    /// The same at the 30 degree tangent (ring: 60 degrees); None if the fillet has none.
    pub at_tangent: Option<RootPoint>,
}

/// Stress in the roots of one gear over the cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct GearRoots {
    /// Every tooth under load at every position.
    pub teeth: Vec<ToothRoot>,
    /// The fillet of the tooth with the largest stress there: along the face (ascending in gear 1's frame) the points along the
    /// profile, from the middle of the space to the start of the involute; empty without load.
    pub field: Vec<Vec<RootPoint>>,
}

impl GearRoots {
    /// The tooth with the largest stress; None without load.
    pub fn largest(&self) -> Option<&ToothRoot> {
        let teeth = self.teeth.iter();
        teeth.max_by(|a, b| a.largest.stress.total_cmp(&b.largest.stress))
    }

    /// Largest stress at each of `positions`, Pa; 0 without load. `of` picks it.
    pub fn over_cycle(&self, positions: usize, of: impl Fn(&ToothRoot) -> Option<f64>) -> Vec<f64> {
        let mut out: Vec<Option<f64>> = vec![None; positions];
        for tooth in &self.teeth {
            let here = &mut out[tooth.position];
            if let Some(stress) = of(tooth) {
                *here = Some(here.map_or(stress, |other| stress.max(other)));
            }
        }
        out.into_iter().map(|s| s.unwrap_or(0.0)).collect()
    }
}

/// Segments of both gears at one position of the mesh, and what their loads do to the roots.
pub struct PositionRoots<'a> {
    models: &'a [Arc<RootStress>; 2],
    segments: [SpreadSegments; 2],
    center_distance_offset: f64,
}

impl<'a> PositionRoots<'a> {
    /// Of all segments of `problem`; `models` are those of gear 1 and gear 2 for its flank.
    pub fn new(problem: &PositionProblem, models: &'a [Arc<RootStress>; 2]) -> Self {
        let offset = problem.contact.center_distance_offset;
        Self::of_segments(&problem.seen, offset, models)
    }

    fn of_segments(
        seen: &[[Segment; 2]],
        center_distance_offset: f64,
        models: &'a [Arc<RootStress>; 2],
    ) -> Self {
        PositionRoots {
            models,
            segments: [0, 1].map(|i| {
                let segments: Vec<Segment> = seen.iter().map(|both| both[i]).collect();
                models[i].spread(&segments)
            }),
            center_distance_offset,
        }
    }

    /// The fillet of gear `i` + 1 on its tooth of `tooth_pair` under `loads` on the segments.
    fn field(
        &self,
        i: usize,
        tooth_pair: i32,
        loads: &[SegmentLoad],
    ) -> Result<RootField<'_>, ContactError> {
        let tooth = [tooth_pair, -tooth_pair][i];
        let forces: Vec<f64> = loads.iter().map(|segment| segment.force).collect();
        let field = self.models[i].of_tooth(tooth, &self.segments[i], &forces);
        field.map_err(|model| ContactError::BeyondModel {
            center_distance_offset: self.center_distance_offset,
            model,
        })
    }

    /// Largest principal stress in the roots of gear 1 and gear 2 under the load of `result`, a solution of the problem
    /// it was made of: over face and fillet of every tooth under load, Pa; 0 without load.
    ///
    /// # Errors
    /// [`ContactError::BeyondModel`] where more teeth bear load than the models hold.
    pub fn largest(&self, result: &ContactResult) -> Result<[f64; 2], ContactError> {
        let mut largest = [0.0f64; 2];
        for pair in under_load(result) {
            for (i, largest) in largest.iter_mut().enumerate() {
                let field = self.field(i, pair, &result.segments)?;
                *largest = largest.max(field.largest().stress);
            }
        }
        Ok(largest)
    }
}

/// The tooth pairs that bear, ascending.
fn under_load(result: &ContactResult) -> Vec<i32> {
    let loaded = result.segments.iter().filter(|segment| segment.force > 0.0);
    let mut pairs: Vec<i32> = loaded.map(|segment| segment.tooth_pair).collect();
    pairs.dedup();
    pairs
}

impl MeshCycle {
    /// Stress in the roots of gear 1 and gear 2 under the loads of this cycle, which `solver` solved for `input`; `models` are
    /// those of gear 1 and gear 2.
    ///
    /// # Errors
    /// [`ContactError::BeyondModel`] where more teeth bear load than the models hold.
    pub fn root_stress(
        &self,
        solver: &ContactSolver,
        input: &CycleInput,
        models: &[Arc<RootStress>; 2],
    ) -> Result<[GearRoots; 2], ContactError> {
        let positions = self.results.par_iter().map(|result| {
            let loaded = result.segments.iter().filter(|segment| segment.force > 0.0);
            let loaded: Vec<SegmentLoad> = loaded.copied().collect();
            let seen: Vec<_> = loaded.iter().map(|segment| segment.seen).collect();
            let roots = PositionRoots::of_segments(&seen, input.center_distance_offset, models);
            (roots, loaded)
        });
        let positions: Vec<(PositionRoots, Vec<SegmentLoad>)> = positions.collect();
        let results = self.results.iter().enumerate();
        let teeth = results.flat_map(|(position, result)| {
            let pairs = under_load(result).into_iter();
            pairs.map(move |pair| (position, pair))
        });
        let teeth: Vec<(usize, i32)> = teeth.collect();
        let cycle = CycleRoots {
            geometry: &solver.setup().geometry,
            flank: input.flank,
            positions,
            teeth,
        };
        Ok([cycle.of_gear(0)?, cycle.of_gear(1)?])
    }
}

/// The loads of a mesh cycle on the roots of both gears.
struct CycleRoots<'a> {
    geometry: &'a PairGeometry,
    flank: Flank,
    /// The loaded segments of each position.
    positions: Vec<(PositionRoots<'a>, Vec<SegmentLoad>)>,
    /// Position and tooth pair of all teeth under load.
    teeth: Vec<(usize, i32)>,
}

impl CycleRoots<'_> {
    fn of_gear(&self, i: usize) -> Result<GearRoots, ContactError> {
        let roots = self.teeth.par_iter().map(|&(position, tooth_pair)| {
            let field = self.field(i, position, tooth_pair)?;
            Ok(ToothRoot {
                position,
                tooth_pair,
                largest: self.placed(i, field.largest()),
                at_tangent: field.at_tangent().map(|point| self.placed(i, point)),
            })
        });
        let roots: Result<Vec<ToothRoot>, ContactError> = roots.collect();
        let mut found = GearRoots {
            teeth: roots?,
            field: Vec::new(),
        };
        if let Some(tooth) = found.largest() {
            let field = self.field(i, tooth.position, tooth.tooth_pair)?;
            let mut rows = Vec::new();
            for number in 0..field.z().len() {
                let profile = field.profile(number);
                rows.push(
                    profile
                        .map(|point| self.placed(i, point))
                        .collect::<Vec<_>>(),
                );
            }
            rows.sort_by(|a, b| a[0].z.total_cmp(&b[0].z));
            found.field = rows;
        }
        Ok(found)
    }

    fn field(
        &self,
        i: usize,
        position: usize,
        tooth_pair: i32,
    ) -> Result<RootField<'_>, ContactError> {
        let (roots, loads) = &self.positions[position];
        roots.field(i, tooth_pair, loads)
    }

    /// `point` from the canonical coordinates of gear `i` into gear 1's frame.
    fn placed(&self, i: usize, point: RootPoint) -> RootPoint {
        let gear = &self.geometry.gears[i];
        let z = match self.geometry.is_mirrored(self.flank, i) {
            true => gear.face_width - point.z,
            false => point.z,
        };
        RootPoint {
            z: gear.face_offset + z,
            ..point
        }
    }
}
