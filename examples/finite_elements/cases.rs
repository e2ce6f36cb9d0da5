//! Pairs, their solvers, and mesh cycles.

use crate::page::Outcome;
use gearmesh::compliance::ToothCompliance;
use gearmesh::compliance::finite_element::{PairCompliance, Settings};
use gearmesh::contact::{ContactSettings, ContactSolver, CycleInput, MeshCycle};
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::pair::Pair;
use std::cell::RefCell;
use std::sync::Arc;

/// The pairs in resources/pairs.
pub const SHIPPED: [&str; 5] = [
    "palermo2013",
    "palermo2013-unmodified",
    "fzg-c",
    "helical-25-47",
    "planet-ring-27-84",
];

/// The pair file resources/pairs/`name`.json.
pub fn shipped(name: &str) -> Outcome<Pair> {
    Ok(Pair::read(format!("resources/pairs/{name}.json"))?)
}

/// The paper's pair with bores of `bore_mm`, with or without its modifications.
pub fn paper(modified: bool, bore_mm: f64) -> Outcome<Pair> {
    let name = if modified { SHIPPED[0] } else { SHIPPED[1] };
    let mut pair = shipped(name)?;
    for gear in &mut pair.geometry.gears {
        gear.held_radius = 0.5e-3 * bore_mm;
    }
    Ok(pair)
}

/// Spur pair without shift or modifications, alpha 20°; the bore is the root diameter times `bore_ratio`.
pub fn spur(
    teeth: [u32; 2],
    module_mm: f64,
    tool: f64,
    bore_ratio: f64,
    face_mm: f64,
    torque: f64,
) -> Outcome<Pair> {
    let gear = |z: u32| {
        let bore = bore_ratio * module_mm * (f64::from(z) - 2.5);
        format!(
            r#"{{"teeth": {z}, "profile_shift": 0.0, "face_width_mm": {face_mm}, "dedendum_coefficient": 1.25,
                 "tool_tip_radius_coefficient": {tool}, "bore_diameter_mm": {bore}}}"#
        )
    };
    Ok(Pair::from_json(&format!(
        r#"{{"name": "spur", "meshing": "external", "normal_module_mm": {module_mm},
             "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 0.0, "gear1": {}, "gear2": {},
             "operating": {{"nominal_torque_nm": {torque}, "maximum_torque_nm": {},
                 "center_distance_offset_um": [-100, 100], "misalignment_mrad": [-3, 3]}}}}"#,
        gear(teeth[0]),
        gear(teeth[1]),
        2.0 * torque
    ))?)
}

/// 20/20 teeth, module 4 mm, face 25 mm, bore 30 mm, 100 N m: the spur pair of the convergence tables.
pub fn thick_spur() -> Outcome<Pair> {
    spur([20, 20], 4.0, 0.38, 30.0 / 70.0, 25.0, 100.0)
}

/// Elastic models computed so far in this run.
#[derive(Default)]
pub struct Models {
    known: RefCell<Vec<(PairGeometry, Settings, PairCompliance)>>,
}

impl Models {
    /// The models of `pair` with `settings`, and whether they are new.
    pub fn get(&self, pair: &Pair, settings: &Settings) -> Outcome<PairCompliance> {
        let same = |known: &&(PairGeometry, Settings, PairCompliance)| {
            known.0 == pair.geometry && known.1 == *settings
        };
        if let Some((.., models)) = self.known.borrow().iter().find(same) {
            return Ok(models.clone());
        }
        let models = PairCompliance::new(&pair.geometry, settings, None, &|_, _, _| true)?;
        self.known
            .borrow_mut()
            .push((pair.geometry.clone(), *settings, models.clone()));
        Ok(models)
    }

    /// Solver of `pair` at its level of refinement.
    pub fn solver(&self, pair: &Pair) -> Outcome<ContactSolver> {
        let models = self.get(pair, &Settings::for_pair(pair))?;
        solver(pair, &models, ContactSettings::for_pair(pair))
    }
}

/// Solver of `pair` on `models`.
pub fn solver(
    pair: &Pair,
    models: &PairCompliance,
    contact: ContactSettings,
) -> Outcome<ContactSolver> {
    let compliance = models
        .gears
        .clone()
        .map(|gear| gear as Arc<dyn ToothCompliance>);
    Ok(ContactSolver::new(pair, compliance, contact)?)
}

/// A mesh cycle of the drive flank at nominal centre distance with parallel axes.
pub fn cycle(solver: &ContactSolver, torque: f64, positions: usize) -> Outcome<MeshCycle> {
    let input = CycleInput {
        flank: Flank::Drive,
        torque,
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions,
    };
    Ok(MeshCycle::solve(solver, &input)?)
}

/// Mean and peak-to-peak STE of such a cycle, um.
pub fn ste(solver: &ContactSolver, torque: f64, positions: usize) -> Outcome<[f64; 2]> {
    let cycle = cycle(solver, torque, positions)?;
    Ok([1e6 * cycle.mean_ste(), 1e6 * cycle.peak_to_peak_ste()])
}
