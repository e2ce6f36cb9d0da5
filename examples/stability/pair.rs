//! The pairs of the experiments.

use gearmesh::gear::{Gear, GearKind, PairGeometry};

fn gear(kind: GearKind, teeth: u32, hand: f64) -> Gear {
    let kappa = if kind == GearKind::Ring { -1.0 } else { 1.0 };
    let helix = 13f64.to_radians();
    let reference = 0.5 * f64::from(teeth) * 4e-3 / helix.cos();
    Gear {
        kind,
        teeth,
        hand,
        normal_module: 4e-3,
        normal_pressure_angle: 20f64.to_radians(),
        helix_angle: helix,
        profile_shift: 0.0,
        face_width: 25e-3,
        face_offset: 0.0,
        tip_radius: reference + kappa * 4.105e-3,
        dedendum_coefficient: 1.25,
        tool_tip_radius_coefficient: 0.38,
        held_radius: if kappa > 0.0 {
            15e-3
        } else {
            reference + 20e-3
        },
        tooth_thinning: 30e-6,
        youngs_modulus: 206e9,
        poisson_ratio: 0.3,
    }
}

/// The paper's pair with each tooth thinned by 30 um on the base circle.
pub fn external() -> PairGeometry {
    PairGeometry {
        gears: [
            gear(GearKind::External, 20, 1.0),
            gear(GearKind::External, 20, -1.0),
        ],
        center_distance: 82.104e-3,
    }
}

/// A ring of 61 teeth as gear 2.
pub fn internal() -> PairGeometry {
    let gears = [
        gear(GearKind::External, 20, 1.0),
        gear(GearKind::Ring, 61, 1.0),
    ];
    let center_distance = gears[1].reference_radius() - gears[0].reference_radius();
    PairGeometry {
        gears,
        center_distance,
    }
}

/// The same with the ring as gear 1.
pub fn ring_first() -> PairGeometry {
    let PairGeometry {
        gears: [pinion, ring],
        center_distance,
    } = internal();
    PairGeometry {
        gears: [ring, pinion],
        center_distance,
    }
}
