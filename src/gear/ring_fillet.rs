//! The fillet of a ring: an arc that touches the involute and the root circle.

use super::Gear;

/// Fillet arc in the transverse section, in the space beside the +theta flank of a tooth whose centre
/// line is theta = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RingFillet {
    /// Radius of the arc, m.
    pub radius: f64,
    /// Polar coordinates of its centre, m and rad.
    pub center: [f64; 2],
    /// Length of roll at which it touches the involute, m.
    pub roll: f64,
    /// Direction from the centre to that point, rad.
    pub upper_direction: f64,
}

impl RingFillet {
    /// None when the root circle lies so deep inside that the arc cannot touch the involute.
    pub(super) fn new(gear: &Gear) -> Option<Self> {
        let rb = gear.base_radius();
        let radius = gear.tool_tip_radius_coefficient * gear.normal_module;
        let center_radius = gear.root_radius() - radius;
        // A parallel to an involute is an involute of the same base circle, its length of roll less by
        // the distance on the hollow side, where the space is.
        let center_roll = gear.roll_length(center_radius);
        if center_radius.is_nan() || center_roll.is_nan() {
            return None;
        }
        let roll = center_roll + radius;
        let half_pitch = std::f64::consts::PI / gear.z();
        let t = roll / rb;
        let angle = half_pitch - gear.half_base_angle() + t - t.atan();
        // The flank normal touches the base circle ahead of the flank by atan(t); both the point of
        // contact and the centre lie on it.
        let tangent_point = angle + t.atan();
        Some(RingFillet {
            radius,
            center: [center_radius, tangent_point - (center_roll / rb).atan()],
            roll,
            upper_direction: tangent_point - std::f64::consts::FRAC_PI_2,
        })
    }
}
