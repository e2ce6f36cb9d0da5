//! Finite-element compliance: error and cost.

pub mod convergence;
pub mod cost;
mod gear1;
pub mod held;
pub mod mesh;
pub mod plane;
pub mod reference;

use crate::data::{Data, percent};
use crate::setup::{SHIPPED, Setup, shipped, shipped_at, ste};
use crate::{Context, Result};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::pair;
use serde_json::json;

/// The paper's pair with bores of `bore_mm`, with or without its modifications.
fn paper(modified: bool, bore_mm: f64) -> Result<Pair> {
    let mut pair = shipped(SHIPPED[usize::from(!modified)])?;
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
        let gear = |z: u32| {
            json!({
                "teeth": z,
                "profile_shift": 0.0,
                "face_width_mm": self.face_mm,
                "dedendum_coefficient": 1.25,
                "tool_tip_radius_coefficient": self.tool,
                "bore_diameter_mm": self.bore * self.module_mm * (f64::from(z) - 2.5),
            })
        };
        let pair = json!({
            "name": "spur",
            "meshing": "external",
            "normal_module_mm": self.module_mm,
            "normal_pressure_angle_deg": self.pressure_angle_deg,
            "helix_angle_deg": 0.0,
            "gear1": gear(self.teeth[0]),
            "gear2": gear(self.teeth[1]),
            "operating": {
                "nominal_torque_nm": torques[0],
                "maximum_torque_nm": torques[1],
                "center_distance_offset_um": [-100, 100],
                "misalignment_mrad": [-3, 3],
            },
        });
        Ok(pair::from_json(&pair.to_string())?)
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
pub fn levels(_: &Context, data: &Data) -> Result<()> {
    let mut rows = vec![];
    for name in SHIPPED {
        eprintln!("    {name}");
        let normal = shipped(name)?;
        let coarse = shipped_at(name, Refinement::Coarse)?;
        let [normal_solver, coarse_solver] =
            [Setup::new(normal.clone(), None)?, Setup::new(coarse, None)?].map(|s| s.solver);
        let operating = &normal.operating;
        let nominal = operating.nominal_torque;
        for torque in [0.4 * nominal, nominal, operating.maximum_torque] {
            let n = ste(&normal_solver, torque, 32)?;
            let c = ste(&coarse_solver, torque, 32)?;
            let [mean, swing] = [0, 1].map(|i| percent(c[i], n[i]));
            let found = format!("{:.3} | {:.3} | {mean:+.2} | {swing:+.2}", n[0], n[1]);
            rows.push(format!("{name} | {torque:.0} | {found}"));
        }
    }
    let head = "pair | N m | normal mean, µm | p-p, µm | coarse mean | p-p";
    data.table("levels", head, &rows)
}
