//! The numbers of a pair that contact asks for again and again, each made once: in [`PairGeometry`] they follow from
//! the nominal data through several angles.

use super::local::Corner;
use crate::gear::{Flank, PairGeometry};

/// Geometry of a pair, derived. Index 0 is gear 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairNumbers {
    /// Base radii, m.
    pub base_radius: [f64; 2],
    /// +1 external gear, -1 ring.
    pub kappa: [f64; 2],
    /// +1 external, -1 internal pair.
    pub e: f64,
    /// abs(rb1 + e rb2), m.
    pub base_radius_sum: f64,
    /// Transverse base pitch, m.
    pub base_pitch: f64,
    /// Tangent of the base helix angle, >= 0.
    pub tan_beta_b: f64,
    /// Its cosine.
    pub cos_beta_b: f64,
    /// +1 right-handed helix of gear 1, -1 left-handed.
    pub hand: f64,
    /// Mid-face of the overlap of both faces in gear 1's frame, m.
    pub z_ref: f64,
    /// The overlap of both faces in gear 1's frame: lower end and width, m.
    pub face: [f64; 2],
    /// Lengths of roll at the tips, m.
    pub tip_roll: [f64; 2],
    /// z = 0 faces in gear 1's frame, m.
    pub face_offset: [f64; 2],
    /// (1 - nu²) / E, 1/Pa.
    pub plane_compliance: [f64; 2],
    /// How much more teeth give way at their tip edges than half-planes; none by [`PairNumbers::new`].
    pub corners: [Corner; 2],
}

impl PairNumbers {
    /// Those of `geometry`.
    pub fn new(geometry: &PairGeometry) -> PairNumbers {
        let of = |number: fn(&crate::gear::Gear) -> f64| geometry.gears.each_ref().map(number);
        let (low, width) = geometry.face_overlap();
        PairNumbers {
            base_radius: of(|g| g.base_radius()),
            kappa: of(|g| g.kappa()),
            e: geometry.e(),
            base_radius_sum: geometry.base_radius_sum(),
            base_pitch: geometry.base_pitch(),
            tan_beta_b: geometry.base_helix_angle().tan(),
            cos_beta_b: geometry.base_helix_angle().cos(),
            hand: geometry.gears[0].hand,
            z_ref: geometry.z_ref(),
            face: [low, width],
            tip_roll: of(|g| g.tip_form_roll()),
            face_offset: of(|g| g.face_offset),
            plane_compliance: of(|g| (1.0 - g.poisson_ratio.powi(2)) / g.youngs_modulus),
            corners: [Corner::NONE; 2],
        }
    }

    /// The same with tip corners that elastic models hold down to the distances `resolved` (m) from the edge; zero: none.
    pub fn with_corners(mut self, resolved: [f64; 2]) -> PairNumbers {
        for (i, resolved) in resolved.into_iter().enumerate() {
            // Between the flank and the tip land, for an external gear and a ring.
            let angle =
                0.5 * std::f64::consts::PI + (self.tip_roll[i] / self.base_radius[i]).atan();
            self.corners[i] = Corner::new(angle, self.plane_compliance[i], resolved);
        }
        self
    }

    /// Tangent of the operating transverse pressure angle at `center_distance` (m); not a number where the base circles
    /// have no common tangent.
    pub fn tan_phi(&self, center_distance: f64) -> f64 {
        let (c, base) = (center_distance, self.base_radius_sum);
        ((c - base) * (c + base)).sqrt() / base
    }

    /// As [`PairGeometry::contact_line`].
    pub fn contact_line(&self, flank: Flank, tau: f64, k: i32, z: f64) -> f64 {
        (tau + f64::from(k)) * self.base_pitch + self.lean(flank) * (z - self.z_ref)
    }

    /// sigma = s h tan beta_b: slope dy/dz of the contact lines of `flank` in the plane of action.
    pub fn lean(&self, flank: Flank) -> f64 {
        flank.sign() * self.hand * self.tan_beta_b
    }

    /// What a misalignment M closes on the line of action at `z` (m) of the contact line of tooth pair `k`, over M, m:
    /// (z - z_ref) + sigma y, y from the pitch point along the path. A tilt moves the point (y, z) of gear 2 by M (z n_t - y z)
    /// against gear 1, n_t the line of action, and the normal of the flanks is cos beta_b (n_t - sigma z).
    pub fn lever(&self, flank: Flank, tau: f64, k: i32, z: f64) -> f64 {
        (z - self.z_ref) + self.lean(flank) * self.contact_line(flank, tau, k, z)
    }
}
