//! What a report shows and compares: a pair file with its solver, or tables.

use gearmesh::contact::{ContactError, ContactResult, ContactSolver, Tangent};
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::table::{Query, Table};
use gearmesh_preprocessor::contact::{CycleInput, FaceLoad, LoadCase, MeshCycle};

use crate::case::{Case, load_matrix};
use crate::model::Fillets;

/// Loads at which every variant is shown: those of the operating range of the reported pair.
pub struct Loads {
    pub nominal: f64,
    /// Torques of the curves over the mesh cycle, N m.
    pub torques: Vec<f64>,
    pub survey: Vec<f64>,
    /// Misalignments over their range, rad; empty where there is none.
    pub tilts: Vec<f64>,
    /// Positions over the mesh cycle at `torques`.
    pub positions: usize,
    pub speeds: Vec<f64>,
}

pub enum Variant<'a> {
    /// With its fillets where the stress in the roots is shown.
    Pair(&'a ContactSolver, Option<&'a Fillets>),
    Tables(Box<Table>),
}

impl Variant<'_> {
    pub fn geometry(&self) -> &PairGeometry {
        match self {
            Variant::Pair(solver, _) => solver.geometry(),
            Variant::Tables(table) => table.geometry(),
        }
    }

    /// Mesh cycles of the drive flank for each of `torques` (N m) with each of `misalignments` (rad); tables know STE, stiffness, z_c.
    pub fn cases(
        &self,
        torques: &[f64],
        misalignments: &[f64],
        positions: usize,
    ) -> Result<Vec<Case>, ContactError> {
        let loads = load_matrix(torques, misalignments);
        let input = |load: &LoadCase| CycleInput {
            flank: Flank::Drive,
            torque: load.torque,
            center_distance_offset: 0.0,
            misalignment: load.misalignment,
            positions,
        };
        match self {
            Variant::Pair(solver, fillets) => {
                Case::solve_all(solver, *fillets, &input(&loads[0]), &loads, &|_| {})
            }
            Variant::Tables(table) => Ok(loads.iter().map(|l| of_table(table, input(l))).collect()),
        }
    }
}

fn of_table(table: &Table, input: CycleInput) -> Case {
    let geometry = table.geometry();
    let force = input.torque / geometry.gears[0].base_radius();
    let (flank, _) = table.flank(Flank::Drive);
    let result = |&mesh_position: &f64| {
        let mut pose = Query {
            misalignment: input.misalignment,
            mesh_position,
            ..Query::default()
        };
        pose.delta = flank.approach_at(force, &pose);
        let found = flank.evaluate(&pose, false);
        ContactResult {
            approach: pose.delta,
            contact_z: geometry.z_ref() + found.gradient[2] / found.gradient[0],
            tangent: Tangent {
                force_by_approach: found.hessian[0][0],
                ..Tangent::default()
            },
            ..ContactResult::default()
        }
    };
    let positions = (0..input.positions).map(|i| i as f64 / input.positions as f64);
    let mesh_position: Vec<f64> = positions.collect();
    Case {
        input,
        cycle: MeshCycle {
            results: mesh_position.iter().map(result).collect(),
            mesh_position,
            ..MeshCycle::default()
        },
        face_load: FaceLoad::default(),
        roots: None,
    }
}
