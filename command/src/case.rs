//! Mesh cycles under their loads, and their results in one number each.

use std::f64::consts::TAU;

use gearmesh::contact::Tangent;
use gearmesh::friction::{Loss, Sliding, loss_factor_of, ohlendorf};
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::table::{Query, Table};
use gearmesh::words::rounded;
use gearmesh_preprocessor::contact::{
    CycleInput, FaceLoad, GearRoots, LoadCase, MeshCycle, Revolution,
};
use gearmesh_preprocessor::gear::{Pair, Shaft};
use gearmesh_preprocessor::shaft::{BearingLoad, ShaftState};
use gearmesh_preprocessor::static_contact::{ContactError, ContactResult, ContactSolver};

use crate::columns::{Column, columns};
use crate::model::Fillets;

pub struct Case {
    pub input: CycleInput,
    pub load: LoadCase,
    pub cycle: MeshCycle,
    /// Load along the face, in the stations of the solver; empty of tables, which do not know it.
    pub face_load: FaceLoad,
    /// Stress in the roots of gear 1 and gear 2, where it is requested.
    pub roots: Option<[GearRoots; 2]>,
    /// The shafts, mean over the mesh cycle, where the gears have any.
    pub shafts: Option<ShaftState>,
    /// Turns of gears whose bodies are no solids of revolution, where they are requested.
    pub revolutions: Vec<Revolution>,
}

impl Case {
    /// A mesh cycle for each of `loads`, the rest as in `input`, with the gears on their `shafts` and the stress in the roots where there are `fillets`;
    /// `progress` gets the share of them that is solved.
    pub fn solve_all(
        (solver, shafts): (&ContactSolver, &[Option<Shaft>; 2]),
        fillets: Option<&Fillets>,
        input: &CycleInput,
        loads: &[LoadCase],
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<Case>, ContactError> {
        let cycles = MeshCycle::solve_all(solver, shafts, input, loads, progress)?;
        cycles
            .into_iter()
            .zip(loads)
            .map(|(cycle, load)| {
                let roots = fillets.map(|fillets| cycle.root_stress(solver, input, &fillets.maps));
                Ok(Case {
                    roots: roots.transpose()?,
                    face_load: cycle.face_load(solver),
                    shafts: ShaftState::mean(&cycle.shafts),
                    revolutions: vec![],
                    input: *input,
                    load: *load,
                    cycle,
                })
            })
            .collect()
    }

    pub fn torque_in_words(&self) -> String {
        torque_in_words(self.load.torque)
    }

    /// The largest root stress of gear `i`, MPa; 0 without load, None where it is not requested.
    pub fn root_stress(&self, i: usize) -> Option<f64> {
        let largest = self.roots.as_ref()?[i].largest();
        Some(largest.map_or(0.0, |tooth| 1e-6 * tooth.largest.stress))
    }

    /// The same at the 30 degree tangent (ring: 60 degrees).
    pub fn root_stress_at_tangent(&self, i: usize) -> Option<f64> {
        let teeth = self.roots.as_ref()?[i].teeth.iter();
        let stresses = teeth.filter_map(|tooth| Some(1e-6 * tooth.at_tangent?.stress));
        Some(stresses.fold(0.0, f64::max))
    }

    pub fn share(&self, i: usize, pair: i32) -> f64 {
        let mut shares = self.cycle.results[i].load_share.iter();
        let share = shares.find(|(k, _)| *k == pair);
        share.map_or(0.0, |share| share.1)
    }

    /// What friction takes while gear 1 makes `rpm` turns a minute.
    pub fn loss(&self, pair: &Pair, rpm: f64) -> Loss {
        let sliding = [&self.cycle.sliding[..], &self.cycle.friction];
        let (torque, spin) = (self.load.torque, rpm * TAU / 60.0);
        Loss::new(&pair.geometry, &pair.friction, sliding, torque, spin)
    }

    /// Share of the transmitted power that is lost at a coefficient of friction of 1.
    pub fn loss_factor(&self, solver: &ContactSolver) -> f64 {
        let distance = Sliding::mean_distance(&self.cycle.sliding);
        loss_factor_of(solver.geometry(), distance)
    }
}

/// What a report shows mesh cycles of.
pub enum Variant<'a> {
    /// With its shafts, and its fillets where the stress in the roots is shown.
    Pair(
        &'a ContactSolver,
        &'a [Option<Shaft>; 2],
        Option<&'a Fillets>,
    ),
    Tables(Box<Table>),
}

impl Variant<'_> {
    pub fn geometry(&self) -> &PairGeometry {
        match self {
            Variant::Pair(solver, ..) => solver.geometry(),
            Variant::Tables(table) => &table.file.geometry,
        }
    }

    /// Mesh cycles of the drive flank for each of `torques` (N m) with each of `misalignments` (rad); tables know STE, stiffness, z_c.
    pub fn cases(
        &self,
        torques: &[f64],
        misalignments: &[f64],
        positions: usize,
    ) -> Result<Vec<Case>, ContactError> {
        let loads = LoadCase::matrix(torques, misalignments);
        let input = CycleInput {
            flank: Flank::Drive,
            center_distance_offset: 0.0,
            positions,
        };
        match self {
            Variant::Pair(solver, shafts, fillets) => {
                Case::solve_all((solver, shafts), *fillets, &input, &loads, &|_| {})
            }
            Variant::Tables(table) => {
                Ok(loads.iter().map(|l| of_table(table, input, *l)).collect())
            }
        }
    }
}

fn of_table(table: &Table, input: CycleInput, load: LoadCase) -> Case {
    let geometry = &table.file.geometry;
    let force = load.torque / geometry.gears[0].base_radius();
    let (flank, _) = table.flank(Flank::Drive);
    let mut cycle = MeshCycle::default();
    for i in 0..input.positions {
        let mut pose = Query {
            misalignment: load.misalignment,
            mesh_position: i as f64 / input.positions as f64,
            ..Query::default()
        };
        pose.delta = flank.approach_at(force, &pose);
        let found = flank.evaluate(&pose, false);
        cycle.mesh_position.push(pose.mesh_position);
        cycle.results.push(ContactResult {
            approach: pose.delta,
            contact_z: geometry.z_ref() + found.gradient[2] / found.gradient[0],
            tangent: Tangent {
                force_by_approach: found.hessian[0][0],
                ..Tangent::default()
            },
            ..ContactResult::default()
        });
    }
    Case {
        input,
        load,
        cycle,
        face_load: FaceLoad::default(),
        roots: None,
        shafts: None,
        revolutions: vec![],
    }
}

pub fn torque_in_words(torque: f64) -> String {
    format!("{} N m", rounded(torque))
}

type Row<'a> = &'a Case;

pub fn load<'r>() -> Vec<Column<'static, Row<'r>>> {
    columns! { |c: &Row|
        "torque_nm", ["torque", "N m", None] => c.load.torque;
        "misalignment_mrad", ["misalignment", "mrad", None] => rounded(c.load.misalignment * 1e3);
    }
}

pub fn summary<'s, 'r>(solver: &'s ContactSolver) -> Vec<Column<'s, Row<'r>>> {
    let width = solver.geometry().face_overlap().1;
    columns! { |c: &Row|
        "mean_ste_loa_um", ["mean STE", "um", 4] => 1e6 * c.cycle.mean_ste();
        // One position has no swing.
        "peak_to_peak_ste_loa_um", ["p-p STE", "um", 4] => (c.cycle.results.len() > 1).then(|| 1e6 * c.cycle.peak_to_peak_ste());
        "", ["1st harm.", "um", 4] => c.cycle.harmonics()[0].map(|h| 1e6 * h.amplitude);
        "cycle_maximum_pressure_mpa", ["p_max", "MPa", 1] => 1e-6 * c.cycle.max_pressure();
        "cycle_edge_line_load_n_per_mm", ["tip edge", "N/mm", 1] => c.cycle.edge_load().map_or(0.0, |edge| 1e-3 * edge.line_load);
        "face_load_factor", ["K_Hbeta", "", 3] => c.face_load.face_load_factor();
        "mean_mesh_stiffness_loa_n_per_m", ["stiffness", "N/m", 4] => c.cycle.mean_stiffness();
        "", ["per width", "N/(mm um)", 3] => 1e-9 * c.cycle.mean_stiffness() / width;
    }
}

/// What the shafts do, mean over the mesh cycle; none without shafts.
pub fn on_shafts<'r>(case: Option<&Case>) -> Vec<Column<'static, Row<'r>>> {
    if case.is_none_or(|case| case.shafts.is_none()) {
        return vec![];
    }
    columns! { |c: &Row|
        "shaft_misalignment_mrad", ["M shafts", "mrad", 4] => c.shafts.as_ref().map(|s| 1e3 * s.misalignment);
        "shaft_bow_um", ["bow", "um", 3] => c.shafts.as_ref().map(|s| 1e6 * s.bow());
        "shaft_torsion_um", ["torsion", "um", 3] => c.shafts.as_ref().map(|s| 1e6 * s.torsion_over_face());
        "shaft_approach_loa_um", ["shafts deflect", "um", 3] => c.shafts.as_ref().map(|s| 1e6 * s.approach);
    }
}

pub const SHAFT_LEGEND: &str = "\
With shafts on bearings. M shafts: misalignment of the axes at mid-face under load; bow: how much less bending closes both ends of
the face than its middle; torsion: how much more twist closes the end of large z; shafts deflect: displacement on the line of action at
mid-face through shafts and bearings, twist up to where the torques enter included. It is not in the STE, which is that of the teeth
and bodies at mid-face.
";

pub const LEGEND: &str = "\
STE: static transmission error on the line of action at mid-face, p-p: peak to peak, 1st harm.: amplitude of its first
harmonic; p_max: largest flank pressure; tip edge: largest line load there; K_Hbeta: largest over mean load along the
face; stiffness: mean of the cycle, tangent, on the line of action, also over the common face width.
";

pub fn details<'s, 'r>(solver: &'s ContactSolver) -> Vec<Column<'s, Row<'r>>> {
    let g = solver.geometry();
    columns! { |c: &Row|
        "cycle_edge_gear", ["tip edge of gear", "", None] => c.cycle.edge_load().map(|edge| edge.gear + 1);
        "cycle_edge_z_mm", ["tip edge at z", "mm", 2] => c.cycle.edge_load().map(|edge| 1e3 * edge.z);
        "transverse_contact_ratio", ["transverse contact ratio", "", 4] => g.transverse_contact_ratio(c.input.center_distance(g));
        "overlap_ratio", ["overlap ratio", "", 4] => g.overlap_ratio();
        "bent_teeth_mean_ste_percent", ["mean STE by the bend of the teeth", "%", 2] => 100.0 * c.cycle.share_of_bent_teeth()[0];
        "bent_teeth_peak_to_peak_ste_percent", ["p-p STE by the bend of the teeth", "%", 2] => 100.0 * c.cycle.share_of_bent_teeth()[1];
        "loss_factor", ["loss factor by the load share", "", 4] => c.loss_factor(solver);
        "loss_factor_ohlendorf", ["loss factor of Ohlendorf", "", 4] => ohlendorf(g, c.input.center_distance(g));
    }
}

/// A bearing of a gear's shaft: gear, number and place (m from the gear's own z = 0 face), and what it bears.
pub struct BearingRow {
    gear: usize,
    number: usize,
    z: f64,
    load: BearingLoad,
}

/// Every bearing of both shafts of `pair` in `state`.
pub fn bearings(pair: &Pair, state: &ShaftState) -> Vec<BearingRow> {
    (0..2)
        .flat_map(|gear| {
            let given = pair.shafts[gear].iter().flat_map(|shaft| &shaft.bearings);
            let loads = given.zip(&state.bearings[gear]).enumerate();
            loads.map(move |(k, (bearing, load))| BearingRow {
                gear: gear + 1,
                number: k + 1,
                z: bearing.z,
                load: *load,
            })
        })
        .collect()
}

pub fn bearing_columns() -> Vec<Column<'static, BearingRow>> {
    columns! { |b: &BearingRow|
        "gear", ["gear", "", None] => b.gear;
        "bearing", ["bearing", "", None] => b.number;
        "z_mm", ["z", "mm", 2] => 1e3 * b.z;
        "force_x_n", ["F_x", "N", 1] => b.load.linear[0];
        "force_y_n", ["F_y", "N", 1] => b.load.linear[1];
        "force_z_n", ["F_z", "N", 1] => b.load.linear[2];
        "radial_force_n", ["radial", "N", 1] => b.load.linear[0].hypot(b.load.linear[1]);
        "tilting_moment_nm", ["tilting moment", "N m", 3] => b.load.angular[0].hypot(b.load.angular[1]);
    }
}
