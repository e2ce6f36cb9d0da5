//! Pair files: refused by field, or a pair that can be meshed.

use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::gear::ToothProfile;
use gearmesh_preprocessor::package::Starts;
use gearmesh_preprocessor::pair;

use super::{Target, change};

/// The shipped pairs are where it starts.
pub const TARGET: Target = Target {
    seeds: || SHIPPED.map(|text| text.as_bytes().to_vec()).to_vec(),
    change: change::json,
    check,
};

const SHIPPED: [&str; 5] = [
    include_str!("../../resources/pairs/palermo2013.json"),
    include_str!("../../resources/pairs/palermo2013-unmodified.json"),
    include_str!("../../resources/pairs/fzg-c.json"),
    include_str!("../../resources/pairs/helical-25-47.json"),
    include_str!("../../resources/pairs/planet-ring-27-84.json"),
];

/// See [`Target::check`].
pub fn check(data: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(data) else {
        return false;
    };
    match pair::from_json(text) {
        Ok(pair) => {
            assert_sound(&pair);
            true
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains('`'), "it names no field: {message}");
            false
        }
    }
}

/// Finite geometry, teeth, contact, and a stiffness to start with.
pub fn assert_sound(pair: &Pair) {
    let g = &pair.geometry;
    let total = g.transverse_contact_ratio(g.center_distance) + g.overlap_ratio();
    assert!(total.is_finite() && total >= 1.0, "contact ratio {total}");
    let backlash = g.backlash(g.center_distance);
    assert!(
        backlash > -1e-12 && backlash.is_finite(),
        "backlash {backlash}"
    );
    for i in 0..2 {
        let gear = &g.gears[i];
        let profile = ToothProfile::new(gear).expect("an accepted gear has teeth");
        assert!(profile.root_angle() <= profile.half_pitch());
        assert!(profile.tip_land() > 0.0 && gear.held_radius > 0.0);
        let start = g.active_start_roll(i, g.center_distance);
        let tip = gear.roll_length(gear.tip_radius);
        for roll in [start, tip] {
            for z in [0.0, gear.face_width] {
                let removal = pair.microgeometry.coast[i].removal(gear, roll, z);
                // At most six modifications of a twentieth of a module each.
                assert!(
                    removal.abs() <= 0.3 * gear.normal_module,
                    "removal {removal}"
                );
            }
        }
    }
    let torque = pair.operating.nominal_torque;
    let dynamics = Starts::constant_stiffness(g, torque).dynamics(g);
    assert!(
        dynamics.damping >= 0.0 && dynamics.damping.is_finite(),
        "damping {}",
        dynamics.damping
    );
}
