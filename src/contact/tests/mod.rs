//! Claims about static contact, on real pairs.

use std::sync::Arc;

use super::*;
use crate::compliance::ToothCompliance;
use crate::compliance::analytical::{AnalyticalCompliance, AxialState};
use crate::pair::Pair;

mod mechanics;
mod paper;
mod plane_strain;
mod separation;
mod symmetry;

/// Spur pair of equal basic rack, bore radius = root radius / 1.4, face 10 mm.
pub(super) fn spur_pair(
    module_mm: f64,
    teeth: [u32; 2],
    angle_deg: f64,
    coefficients: [f64; 3],
) -> Pair {
    let [addendum, dedendum, round] = coefficients;
    let gear = |z: u32| {
        let root = module_mm * (f64::from(z) - 2.0 * dedendum);
        format!(
            r#"{{ "teeth": {z}, "face_width_mm": 10.0, "addendum_coefficient": {addendum},
                  "dedendum_coefficient": {dedendum}, "tool_tip_radius_coefficient": {round},
                  "bore_diameter_mm": {}, "youngs_modulus_gpa": 206.0, "poisson_ratio": 0.3 }}"#,
            root / 1.4
        )
    };
    Pair::from_json(&format!(
        r#"{{ "name": "spur", "meshing": "external", "normal_module_mm": {module_mm},
              "normal_pressure_angle_deg": {angle_deg}, "helix_angle_deg": 0.0,
              "gear1": {}, "gear2": {},
              "operating": {{ "nominal_torque_nm": 10.0, "maximum_torque_nm": 3000.0,
                "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0] }} }}"#,
        gear(teeth[0]),
        gear(teeth[1])
    ))
    .unwrap()
}

/// Solver of `pair` on analytical compliances.
pub(super) fn solver(pair: &Pair, axial: AxialState, settings: ContactSettings) -> ContactSolver {
    let compliance = [0, 1].map(|i| {
        let model = AnalyticalCompliance::new(&pair.geometry.gears[i], axial).unwrap();
        Arc::new(model) as Arc<dyn ToothCompliance>
    });
    ContactSolver::new(pair, compliance, settings).unwrap()
}
