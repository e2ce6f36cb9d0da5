//! Stress in the tooth roots over a mesh cycle that is solved.

use std::sync::Arc;

use rayon::prelude::*;

use super::error::ContactError;
use super::mesh_cycle::{CycleInput, MeshCycle};
use super::result::StripLoad;
use super::solver::ContactSolver;
use crate::compliance::Strip;
use crate::compliance::finite_element::{RootPoint, RootStress};

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
    /// The place of `teeth` with the largest stress; None without load.
    pub largest: Option<usize>,
    /// The fillet of that tooth there: along the face (ascending in gear 1's frame) the points along the profile, from
    /// the middle of the space to the start of the involute.
    pub field: Vec<Vec<RootPoint>>,
}

impl GearRoots {
    /// The tooth with the largest stress.
    pub fn largest(&self) -> Option<&ToothRoot> {
        self.teeth.get(self.largest?)
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

/// A strip as both gears see it, and its tooth pair and force, N.
struct Load {
    seen: [Strip; 2],
    tooth_pair: i32,
    force: f64,
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
        let loads: Vec<Vec<Load>> = self
            .mesh_position
            .iter()
            .zip(&self.loads)
            .map(|(tau, strips)| loads(solver, input, *tau, strips))
            .collect::<Result<_, _>>()?;
        let [first, second] = [0, 1].map(|i| of_gear(solver, input, &models[i], i, &loads));
        Ok([first?, second?])
    }
}

fn loads(
    solver: &ContactSolver,
    input: &CycleInput,
    tau: f64,
    strips: &[StripLoad],
) -> Result<Vec<Load>, ContactError> {
    let setup = solver.setup();
    let section = solver.section(input.center_distance_offset)?;
    let lines = setup.lines(input.flank, &section);
    let under_load = strips.iter().filter(|strip| strip.force > 0.0);
    Ok(under_load
        .map(|strip| Load {
            seen: lines.seen_by_gears(tau, (strip.tooth_pair, strip.z), false),
            tooth_pair: strip.tooth_pair,
            force: strip.force,
        })
        .collect())
}

fn of_gear(
    solver: &ContactSolver,
    input: &CycleInput,
    model: &RootStress,
    i: usize,
    loads: &[Vec<Load>],
) -> Result<GearRoots, ContactError> {
    let field = |position: usize, tooth_pair: i32| {
        let tooth = if i == 0 { tooth_pair } else { -tooth_pair };
        let loads: Vec<(Strip, f64)> = loads[position]
            .iter()
            .map(|load| (load.seen[i], load.force))
            .collect();
        model
            .of_tooth(tooth, &loads)
            .map_err(|model| ContactError::BeyondModel {
                center_distance_offset_um: 1e6 * input.center_distance_offset,
                model,
            })
    };
    let setup = solver.setup();
    let section = solver.section(input.center_distance_offset)?;
    let lines = setup.lines(input.flank, &section);
    let placed = |point: RootPoint| RootPoint {
        z: lines.z_in_frame(i, point.z),
        ..point
    };
    let teeth: Vec<(usize, i32)> = loads
        .iter()
        .enumerate()
        .flat_map(|(position, loads)| {
            let mut pairs: Vec<i32> = loads.iter().map(|load| load.tooth_pair).collect();
            pairs.dedup();
            pairs.into_iter().map(move |pair| (position, pair))
        })
        .collect();
    let teeth = teeth
        .into_par_iter()
        .map(|(position, tooth_pair)| {
            let field = field(position, tooth_pair)?;
            Ok(ToothRoot {
                position,
                tooth_pair,
                largest: placed(field.largest()),
                at_tangent: field.at_tangent().map(placed),
            })
        })
        .collect::<Result<Vec<ToothRoot>, ContactError>>()?;
    let stress = |tooth: &ToothRoot| tooth.largest.stress;
    let largest = (0..teeth.len()).max_by(|a, b| stress(&teeth[*a]).total_cmp(&stress(&teeth[*b])));
    let field = match largest.map(|at| &teeth[at]) {
        Some(tooth) => {
            let field = field(tooth.position, tooth.tooth_pair)?;
            let along_face = 0..field.z().len();
            let mut rows: Vec<Vec<RootPoint>> = along_face
                .map(|number| field.profile(number).map(placed).collect())
                .collect();
            rows.sort_by(|a, b| a[0].z.total_cmp(&b[0].z));
            rows
        }
        None => Vec::new(),
    };
    Ok(GearRoots {
        teeth,
        largest,
        field,
    })
}
