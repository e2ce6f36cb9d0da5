//! Settings that follow from a pair without a solution.

use crate::gear::{Pair, Refinement, body};
use gearmesh::contact::{ContactSettings, STIFFNESS_OVER_MODULUS};

/// Stations along the face at least.
const FEWEST_STATIONS: usize = 10;

/// Elements of level coarse over those of level normal: segments shorter than the elements follow no load of their own either.
const COARSE_OVER_NORMAL: f64 = 5.0 / 3.0;

/// Settings for `pair`: 40 stations, or as many as leave each as long as the widest contact of the pair's loads and
/// misalignments is wide, but at least 10; tip corners as the pair file says.
pub fn contact_settings(pair: &Pair) -> ContactSettings {
    let elements = match pair.refinement {
        Refinement::Coarse => COARSE_OVER_NORMAL,
        Refinement::Normal | Refinement::Fine => 1.0,
    };
    let least = elements * 2.0 * pair.largest_half_width();
    let (_, face) = pair.geometry.face_overlap();
    let default = ContactSettings::default();
    ContactSettings {
        stations: ((face / least) as usize).clamp(FEWEST_STATIONS, default.stations),
        tip_corner_contact: pair.tip_corner_contact,
        ..default
    }
}

/// Approach that the pair's largest load and misalignment can cause, m: twice that of a stiff tooth pair, of the bodies, of the
/// misalignment at the ends, and what modifications take off at most.
pub(super) fn estimated_approach(pair: &Pair, form_rolls: [f64; 2]) -> f64 {
    let g = &pair.geometry;
    let force = pair.operating.maximum_torque / g.gears[0].base_radius();
    let modulus = g.gears[0].youngs_modulus.min(g.gears[1].youngs_modulus);
    let width = g.face_overlap().1;
    let [low, high] = pair.operating.misalignment.map(f64::abs);
    let (mut removal, mut bodies) = (0.0, 0.0);
    for (i, gear) in g.gears.iter().enumerate() {
        let rolls = [form_rolls[i], gear.tip_form_roll()];
        let flanks = [&pair.microgeometry.drive[i], &pair.microgeometry.coast[i]];
        let largest = flanks.map(|flank| flank.largest_removal(gear, rolls));
        removal += largest[0].max(largest[1]);
        bodies += force * body::compliance(gear);
    }
    let cos_beta_b = g.base_helix_angle().cos();
    // Force and displacement along the normal are those on the line of action over cos beta_b, as the contact line is the face.
    2.0 * force / (STIFFNESS_OVER_MODULUS * modulus * width * cos_beta_b)
        + bodies
        + 0.5 * low.max(high) * (width + g.base_helix_angle().tan() * g.base_pitch())
        + removal / cos_beta_b
}
