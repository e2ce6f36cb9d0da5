use super::*;
use crate::gear::GearKind;

/// A spur gear of module 1 mm, material of contact.md, bore radius = root radius / 1.4.
fn spur(teeth: u32) -> Gear {
    let mut gear = Gear {
        kind: GearKind::External,
        teeth,
        hand: 1.0,
        normal_module: 1e-3,
        normal_pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        profile_shift: 0.0,
        face_width: 10e-3,
        face_offset: 0.0,
        tip_radius: 1e-3 * (0.5 * f64::from(teeth) + 1.0),
        dedendum_coefficient: 1.25,
        tool_tip_radius_coefficient: 0.38,
        held_radius: 0.0,
        tooth_thinning: 0.0,
        youngs_modulus: 206e9,
        poisson_ratio: 0.3,
    };
    gear.held_radius = gear.root_radius() / 1.4;
    gear
}

/// Plane-strain displacement at the crossing of load line and centre line, m per N/m, for a load at
/// `radius`.
fn tooth_compliance(gear: &Gear, radius: f64) -> f64 {
    let model = AnalyticalCompliance::new(gear, AxialState::PlaneStrain).unwrap();
    let roll = gear.roll_length(radius);
    let strip = Strip {
        tooth: 0,
        z: [0.0, 1.0],
        roll: [roll, roll],
    };
    model.bulk(&[strip]).unwrap()[(0, 0)]
}

#[test]
fn tooth_compliance_is_that_of_plane_finite_elements_within_4_percent() {
    for (teeth, radius_mm, um_per_n_mm) in [
        (17, 8.0023, 0.01626),
        (17, 8.5, 0.02226),
        (43, 21.5, 0.02085),
        (43, 22.4434, 0.05411),
    ] {
        let c = 1e9 * tooth_compliance(&spur(teeth), 1e-3 * radius_mm);
        let error = c / um_per_n_mm - 1.0;
        assert!(
            error.abs() < 0.04,
            "{teeth} teeth, {radius_mm} mm: {error:+.3}"
        );
    }
}
