//! The gears of tests, benchmarks and experiments: those of the paper's Table 1, and others made likewise.

#![allow(dead_code)] // none needs all of them

use gearmesh::gear::{Gear, GearKind, PairGeometry};

/// A gear with rack, face and material of the paper's Table 1 (module 4 mm, 20 deg, face 25 mm): the tip stands one
/// transverse module above the reference circle (ring: within it), shifted with the profile; held at a bore of
/// 30 mm (ring: 20 mm outside the reference circle).
pub fn gear(kind: GearKind, teeth: u32, hand: f64, helix_deg: f64, profile_shift: f64) -> Gear {
    let mut gear = Gear {
        kind,
        teeth,
        hand,
        normal_module: 4e-3,
        normal_pressure_angle: 20f64.to_radians(),
        helix_angle: helix_deg.to_radians(),
        profile_shift,
        face_width: 25e-3,
        face_offset: 0.0,
        tip_radius: 0.0,
        dedendum_coefficient: 1.25,
        tool_tip_radius_coefficient: 0.38,
        held_radius: 15e-3,
        body: None,
        foundation: None,
        tooth_thinning: 0.0,
        tip_chamfer: 0.0,
        root_form_radius: None,
        youngs_modulus: 206e9,
        poisson_ratio: 0.3,
    };
    let reference = gear.reference_radius();
    gear.tip_radius = reference + (gear.kappa() + profile_shift) * gear.transverse_module();
    if kind == GearKind::Ring {
        gear.held_radius = reference + 20e-3;
    }
    gear
}

/// `gear` with all lengths in proportion to the normal module `module`, m.
pub fn with_module(mut gear: Gear, module: f64) -> Gear {
    let scale = module / gear.normal_module;
    for length in [
        &mut gear.normal_module,
        &mut gear.face_width,
        &mut gear.tip_radius,
        &mut gear.held_radius,
        &mut gear.tip_chamfer,
    ] {
        *length *= scale;
    }
    if let Some(body) = &mut gear.body {
        let both = body.web.iter_mut().chain(&mut body.hub);
        for length in both.chain([&mut body.rim_radius, &mut body.hub_radius]) {
            *length *= scale;
        }
    }
    gear
}

fn equal_gears(hand: f64, helix_deg: f64, center_distance: f64) -> PairGeometry {
    PairGeometry {
        gears: [hand, -hand].map(|hand| gear(GearKind::External, 20, hand, helix_deg, 0.0)),
        center_distance,
    }
}

/// The paper's pair: 20 teeth each, helix 13 deg, gear 1 of `hand`, C = 82.104 mm, no backlash.
pub fn paper_pair(hand: f64) -> PairGeometry {
    equal_gears(hand, 13.0, 82.104e-3)
}

/// The same without helix, C = 80 mm.
pub fn spur_pair() -> PairGeometry {
    equal_gears(1.0, 0.0, 80e-3)
}

/// `pair` with each tooth (ring: each space) thinned (widened) by `thinning` on the base circle, m.
pub fn thinned(mut pair: PairGeometry, thinning: f64) -> PairGeometry {
    for gear in &mut pair.gears {
        gear.tooth_thinning = thinning;
    }
    pair
}
