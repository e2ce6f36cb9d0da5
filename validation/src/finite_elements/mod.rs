//! Finite-element compliance: error and cost.

mod convergence;
pub mod cost;
mod held;
mod plane;
mod properties;
mod reference;

use crate::data::{Data, fixed, percent};
use crate::setup::{SHIPPED, shipped, ste};
use crate::{Chapter, Context, Result, row, timing};
use gearmesh::pair::{Pair, Refinement};
use gearmesh_preprocessor::pair;

pub const CHAPTERS: [(&str, Chapter); 8] = [
    ("machine", |_, data| timing::machine(data)),
    ("plane-strain", plane::report),
    ("reference", reference::report),
    ("convergence", convergence::report),
    ("held", held::report),
    ("properties", properties::report),
    ("levels", levels),
    ("cost", cost::report),
];

/// The paper's pair with bores of `bore_mm`, with or without its modifications.
fn paper(modified: bool, bore_mm: f64) -> Result<Pair> {
    let mut pair = shipped(if modified { SHIPPED[0] } else { SHIPPED[1] })?;
    for gear in &mut pair.geometry.gears {
        gear.held_radius = 0.5e-3 * bore_mm;
    }
    Ok(pair)
}

/// A spur pair without shift or modifications.
struct Spur {
    teeth: [u32; 2],
    module_mm: f64,
    pressure_angle_deg: f64,
    /// Tip radius of the tool over the module.
    tool: f64,
    /// Bore over the root diameter.
    bore: f64,
    face_mm: f64,
}

impl Spur {
    /// With the nominal torque, N m, and the largest one.
    fn pair(&self, torques: [f64; 2]) -> Result<Pair> {
        let Self { module_mm, pressure_angle_deg, tool, face_mm, .. } = self;
        let gear = |z: u32| {
            let bore = self.bore * module_mm * (f64::from(z) - 2.5);
            format!(
                r#"{{"teeth": {z}, "profile_shift": 0.0, "face_width_mm": {face_mm}, "dedendum_coefficient": 1.25,
                     "tool_tip_radius_coefficient": {tool}, "bore_diameter_mm": {bore}}}"#
            )
        };
        Ok(pair::from_json(&format!(
            r#"{{"name": "spur", "meshing": "external", "normal_module_mm": {module_mm},
                 "normal_pressure_angle_deg": {pressure_angle_deg}, "helix_angle_deg": 0.0, "gear1": {}, "gear2": {},
                 "operating": {{"nominal_torque_nm": {}, "maximum_torque_nm": {},
                     "center_distance_offset_um": [-100, 100], "misalignment_mrad": [-3, 3]}}}}"#,
            gear(self.teeth[0]),
            gear(self.teeth[1]),
            torques[0],
            torques[1],
        ))?)
    }
}

/// 20/20 teeth, module 4 mm, face 25 mm, bore 30 mm, 100 N m: the spur pair of the convergence tables.
fn thick_spur() -> Result<Pair> {
    let spur = Spur {
        teeth: [20, 20],
        module_mm: 4.0,
        pressure_angle_deg: 20.0,
        tool: 0.38,
        bore: 30.0 / 70.0,
        face_mm: 25.0,
    };
    spur.pair([100.0, 200.0])
}

/// The levels of detail of the shipped pairs side by side.
fn levels(context: &Context, data: &Data) -> Result<()> {
    let mut rows = vec![];
    for name in SHIPPED {
        eprintln!("    {name}");
        let pair = shipped(name)?;
        let normal = context.models.solver(&pair)?;
        let coarse = context.models.solver(&Pair { refinement: Refinement::Coarse, ..pair.clone() })?;
        let operating = &pair.operating;
        for torque in [0.4 * operating.nominal_torque, operating.nominal_torque, operating.maximum_torque] {
            let [n, c] = [ste(&normal, torque, 32)?, ste(&coarse, torque, 32)?];
            let differences = [percent(c[0], n[0]), percent(c[1], n[1])];
            let found = row![name, fixed(torque, 0), fixed(n[0], 3), fixed(n[1], 3)];
            rows.push([found, differences.to_vec()].concat());
        }
    }
    data.table("levels", &["pair", "N m", "normal mean, µm", "p-p, µm", "coarse mean", "p-p"], &rows)
}
