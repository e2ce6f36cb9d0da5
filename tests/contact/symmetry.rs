//! Mirrors and renumbering must change nothing.

use super::*;

/// A pair file with both gears' entries, external 20 / 31 or internal 20 / 61, every modification on.
pub(super) fn text(meshing: &str, helix_deg: f64, swap: bool) -> String {
    let gear = |teeth: u32, held: &str, relief: f64, slope: f64| {
        format!(
            r#"{{ "teeth": {teeth}, "profile_shift": 0.2, "face_width_mm": 18.0, {held},
                 "tip_relief": {{ "amount_um": {relief}, "start": "pitch_point", "shape": "parabolic" }},
                 "lead_crowning_um": 3.0, "lead_slope_um": {slope},
                 "youngs_modulus_gpa": 206.0, "poisson_ratio": 0.3 }}"#
        )
    };
    let pinion = gear(20, r#""bore_diameter_mm": 24.0"#, 6.0, 2.0);
    let wheel = if meshing == "external" {
        gear(31, r#""bore_diameter_mm": 30.0"#, 9.0, -1.0)
    } else {
        gear(61, r#""rim_diameter_mm": 215.0"#, 9.0, -1.0)
    };
    // The same load on the line of action, whichever gear the torque is given on.
    let ratio = if meshing == "external" { 31.0 } else { 61.0 } / 20.0;
    let (first, second, torque) = if swap {
        (wheel, pinion, 2000.0 * ratio)
    } else {
        (pinion, wheel, 2000.0)
    };
    format!(
        r#"{{ "name": "symmetry", "meshing": "{meshing}", "normal_module_mm": 3.0,
             "normal_pressure_angle_deg": 20.0, "helix_angle_deg": {helix_deg},
             "gear1": {first}, "gear2": {second},
             "operating": {{ "nominal_torque_nm": 200.0, "maximum_torque_nm": {torque},
               "center_distance_offset_um": [-50.0, 50.0], "misalignment_mrad": [-1.0, 1.0] }} }}"#
    )
}

/// Mesh position, force on the line of action in N and misalignment in rad.
const CASES: [(f64, f64, f64); 3] = [
    (0.1, 3000.0, 0.4e-3),
    (0.55, 8000.0, -0.7e-3),
    (0.9, 800.0, 0.0),
];

struct Mesh<'a> {
    text: &'a str,
    flank: Flank,
    tip_corner_contact: bool,
}

impl Mesh<'_> {
    fn solve(&self, tau: f64, loa_force: f64, misalignment: f64) -> ContactResult {
        let pair = pair::from_json(self.text).unwrap();
        let settings = ContactSettings {
            tip_corner_contact: self.tip_corner_contact,
            ..with_stations(16)
        };
        let problem = coarse_solver(&pair, settings).position(self.flank, tau, 20e-6);
        let torque = loa_force * pair.geometry.gears[0].base_radius();
        let result = problem.unwrap().solve_torque(torque, misalignment, None);
        result.unwrap()
    }
}

fn drive(text: &str) -> Mesh<'_> {
    Mesh {
        text,
        flank: Flank::Drive,
        tip_corner_contact: true,
    }
}

fn coast(text: &str) -> Mesh<'_> {
    Mesh {
        flank: Flank::Coast,
        ..drive(text)
    }
}

fn assert_same(a: &ContactResult, b: &ContactResult, z_b: f64) {
    assert_abs_diff_eq!(
        a.approach,
        b.approach,
        epsilon = 1e-9 * a.approach.abs().max(1e-6)
    );
    assert_abs_diff_eq!(a.contact_z, z_b, epsilon = 1e-9);
    assert_relative_eq!(a.max_pressure, b.max_pressure, max_relative = 1e-7);
}

#[test]
fn contact_on_the_path_does_not_depend_on_which_gear_is_numbered_1() {
    // On a tip edge it does: there the ratio of the torques is not that of the base radii, and the torque given
    // is the one on gear 1. An internal pair presses the ring in the sense in which it turns: the flank changes its name.
    let cases = [
        ("external", -15.0, Flank::Drive),
        ("internal", 15.0, Flank::Coast),
    ];
    for (meshing, swapped_helix, flank) in cases {
        let [first, second] =
            [(15.0, false), (swapped_helix, true)].map(|(helix, swap)| text(meshing, helix, swap));
        let on_path = |text, flank| Mesh {
            text,
            flank,
            tip_corner_contact: false,
        };
        for (tau, force, m) in CASES {
            let a = on_path(&first, Flank::Drive).solve(tau, force, m);
            let b = on_path(&second, flank).solve(-tau, force, m);
            assert_same(&a, &b, b.contact_z);
        }
    }
}

#[test]
fn a_left_handed_pair_is_the_mirror_image_of_a_right_handed_one() {
    for meshing in ["external", "internal"] {
        // The mirror contains the axes: it turns over hand and flank and keeps z.
        let [right, left] = [15.0, -15.0].map(|helix| text(meshing, helix, false));
        for (tau, force, m) in CASES {
            let a = drive(&right).solve(tau, force, m);
            let b = coast(&left).solve(tau, force, m);
            assert_same(&a, &b, b.contact_z);
        }
    }
}

#[test]
fn without_lead_slope_the_coast_flank_is_the_drive_flank_seen_from_the_other_end() {
    for meshing in ["external", "internal"] {
        let symmetric = text(meshing, 15.0, false)
            .replace(r#""lead_slope_um": 2"#, r#""lead_slope_um": 0"#)
            .replace(r#""lead_slope_um": -1"#, r#""lead_slope_um": 0"#);
        assert!(pair::from_json(&symmetric).unwrap().coast_mirrors_drive());
        for (tau, force, m) in CASES {
            let a = drive(&symmetric).solve(tau, force, m);
            let b = coast(&symmetric).solve(tau, force, -m);
            assert_same(&a, &b, 18e-3 - b.contact_z);
        }
    }
}

#[test]
fn a_spur_pair_is_its_own_mirror_image_under_misalignment() {
    let width = pair::from_json(SPUR).unwrap().geometry.face_overlap().1;
    for (tau, force, _) in CASES {
        let [a, b] = [0.5e-3, -0.5e-3].map(|m| drive(SPUR).solve(tau, force, m));
        assert_same(&a, &b, width - b.contact_z);
        // M > 0 closes the side of larger z.
        assert!(a.contact_z > 0.5 * width);
    }
}

#[test]
fn positions_one_base_pitch_apart_are_the_same() {
    let pair = text("external", 15.0, false);
    for (tau, force, m) in CASES {
        let [a, b] = [tau, tau + 7.0].map(|tau| drive(&pair).solve(tau, force, m));
        assert_same(&a, &b, b.contact_z);
    }
}
