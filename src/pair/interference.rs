//! Whether the teeth of an internal pair foul each other away from the mesh.

use crate::gear::{PairGeometry, involute};

/// Tip pressure angles of external gear and ring, with the external gear's index.
struct Internal<'a> {
    geometry: &'a PairGeometry,
    pinion: usize,
    ring: usize,
}

impl<'a> Internal<'a> {
    fn new(geometry: &'a PairGeometry) -> Option<Self> {
        let ring = geometry.ring()?;
        Some(Internal {
            geometry,
            pinion: 1 - ring,
            ring,
        })
    }

    fn tip_pressure_angle(&self, i: usize) -> f64 {
        let g = &self.geometry.gears[i];
        (g.base_radius() / g.tip_radius).acos()
    }
}

/// Clearance between the tip corners of pinion and ring where the tip circles cross, as an angle of the
/// ring, rad; negative: they foul (trochoid interference). None for an external pair, and where the tip
/// circles do not cross. Teeth without backlash are meant.
///
/// KHK, Gear Technical Reference, "Interference of internal gears"; DIN 3993-1.
pub(super) fn tip_corner_clearance(geometry: &PairGeometry) -> Option<f64> {
    let pair = Internal::new(geometry)?;
    let (p, r) = (&geometry.gears[pair.pinion], &geometry.gears[pair.ring]);
    let (ap, ar, c) = (p.tip_radius, r.tip_radius, geometry.center_distance);
    let at_pinion = ((ar * ar - ap * ap - c * c) / (2.0 * c * ap)).acos();
    let at_ring = ((c * c + ar * ar - ap * ap) / (2.0 * c * ar)).acos();
    let inv_w = involute(geometry.operating_pressure_angle(c));
    let turned =
        (at_pinion + involute(pair.tip_pressure_angle(pair.pinion)) - inv_w) * p.z() / r.z();
    let clearance = turned + inv_w - involute(pair.tip_pressure_angle(pair.ring)) - at_ring;
    (!clearance.is_nan()).then_some(clearance)
}

/// Whether the pinion can be brought into mesh radially (no trimming interference); true for an
/// external pair. Same sources as [`tip_corner_clearance`].
pub(super) fn assembles_radially(geometry: &PairGeometry) -> bool {
    let Some(pair) = Internal::new(geometry) else {
        return true;
    };
    let ratio = geometry.gears[pair.pinion].z() / geometry.gears[pair.ring].z();
    let alpha_p = pair.tip_pressure_angle(pair.pinion);
    let alpha_r = pair.tip_pressure_angle(pair.ring);
    let cosines = alpha_p.cos() / alpha_r.cos();
    let at_pinion = ((1.0 - cosines.powi(2)) / (1.0 - ratio.powi(2)))
        .sqrt()
        .asin();
    let at_ring = ((cosines.powi(-2) - 1.0) / (ratio.powi(-2) - 1.0))
        .sqrt()
        .asin();
    let inv_w = involute(geometry.operating_pressure_angle(geometry.center_distance));
    let pinion = at_pinion + involute(alpha_p) - inv_w;
    let ring = (at_ring + involute(alpha_r) - inv_w) / ratio;
    // Not a number: the corners never pass each other on the way in.
    pinion >= ring || pinion.is_nan() || ring.is_nan()
}
