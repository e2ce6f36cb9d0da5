//! The strips that may touch at one position of the mesh.

use super::closest::Flanks;
use super::transverse::TransverseSection;
use crate::compliance::Strip;
use crate::gear::{Flank, Gear, Microgeometry, PairGeometry};

/// Points of a strip at which the local contact is evaluated apart, so that the edge of the contact crosses
/// a strip in small steps: at the middles of equal parts.
pub const POINTS: usize = 4;

/// A strip of one contact line that may carry load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Tooth pair, counted in the sense in which contact moves; 0 touches at the pitch point at mid-face
    /// at mesh position 0.
    pub tooth_pair: i32,
    /// Ends in gear 1's frame, m, ascending.
    pub z: [f64; 2],
    /// Length of roll on gear 1 and gear 2 at mid-strip, where the flanks come closest, m.
    pub roll: [f64; 2],
    /// Gaps along the line of action before load and misalignment at the points of the strip, ascending in z,
    /// m: microgeometry of both flanks and the separation off the path of contact.
    pub gap: [f64; POINTS],
    /// Relative radius of curvature in the normal section, m.
    pub radius: f64,
    /// Slope of the gap at the nearest tip edge, from the edge into the flank, in the normal section; negative
    /// where contact lies inside the flank.
    pub edge_slope: f64,
    /// The gear, 0 or 1, that this edge belongs to.
    pub edge_gear: usize,
    /// Arm of the force about the axis of gear 1, in the transverse plane over its base radius; at
    /// mid-strip.
    pub arm: f64,
    /// The strip in the canonical coordinates of gear 1 and gear 2.
    pub strips: [Strip; 2],
}

impl Candidate {
    /// Middle of the strip in gear 1's frame, m.
    pub fn middle(&self) -> f64 {
        0.5 * (self.z[0] + self.z[1])
    }

    /// Points at which [`Candidate::gap`] is given, in gear 1's frame, m.
    pub fn points(&self) -> [f64; POINTS] {
        points(self.z)
    }
}

fn points(z: [f64; 2]) -> [f64; POINTS] {
    std::array::from_fn(|q| z[0] + (z[1] - z[0]) * (q as f64 + 0.5) / POINTS as f64)
}

/// What does not change with the position of the mesh.
pub struct ContactLines<'a> {
    /// The pair.
    pub geometry: &'a PairGeometry,
    /// Modifications of both gears.
    pub microgeometry: &'a [Microgeometry; 2],
    /// Transverse section at the centre distance.
    pub section: &'a TransverseSection,
    /// Loaded flank of gear 1.
    pub flank: Flank,
    /// Number of equal stations over the overlap of both faces.
    pub stations: usize,
}

/// Pieces shorter than this fraction of a station are left out where a path end cuts it: what they could
/// carry is below the rounding of the load.
const SHORTEST: f64 = 1e-9;

impl ContactLines<'_> {
    /// All candidates at the mesh position `tau`, tooth pair by tooth pair, ascending in z.
    pub fn candidates(&self, tau: f64) -> Vec<Candidate> {
        let (low, width) = self.geometry.face_overlap();
        let step = width / self.stations as f64;
        let pitch = self.geometry.base_pitch();
        let tilt = 0.5 * width * self.geometry.base_helix_angle().tan();
        let [first, last] = self.section.reach();
        let k_first = ((first - tilt) / pitch - tau).floor() as i32;
        let k_last = ((last + tilt) / pitch - tau).ceil() as i32;
        let mut all = Vec::new();
        for k in k_first..=k_last {
            for station in 0..self.stations {
                let z = [
                    low + step * station as f64,
                    low + step * (station + 1) as f64,
                ];
                if let Some(z) = self.within_reach(tau, k, z)
                    && z[1] - z[0] > SHORTEST * step
                {
                    all.push(self.candidate(tau, k, z));
                }
            }
        }
        all
    }

    /// The part of `z` in which tooth pair `k` lies within the reach of contact.
    fn within_reach(&self, tau: f64, k: i32, z: [f64; 2]) -> Option<[f64; 2]> {
        let xi = z.map(|z| self.geometry.contact_line(self.flank, tau, k, z));
        let [first, last] = self.section.reach();
        let slope = xi[1] - xi[0];
        if slope.abs() <= 1e-12 * (last - first) {
            // A spur pair: the whole strip or nothing.
            let middle = 0.5 * (xi[0] + xi[1]);
            return (first <= middle && middle <= last).then_some(z);
        }
        // Fractions of the strip at which its line crosses the limits.
        let at = |limit: f64| (limit - xi[0]) / slope;
        let (a, b) = if slope > 0.0 {
            (at(first), at(last))
        } else {
            (at(last), at(first))
        };
        let (a, b) = (a.max(0.0), b.min(1.0));
        (a < b).then(|| [z[0] + a * (z[1] - z[0]), z[0] + b * (z[1] - z[0])])
    }

    fn candidate(&self, tau: f64, k: i32, z: [f64; 2]) -> Candidate {
        let g = self.geometry;
        let closest = |z: f64| {
            let at = self.section.point(g.contact_line(self.flank, tau, k, z));
            Flanks::new(g, self.microgeometry, at, z).closest_point(self.section)
        };
        let middle = closest(0.5 * (z[0] + z[1]));
        let ends = z.map(closest);
        let gap = points(z).map(|z| closest(z).gap);
        let cos_beta_b = g.base_helix_angle().cos();
        // Curvatures in the normal section: kappa cos beta_b / rho_t, negative for a ring.
        let curvature: f64 = (0..2)
            .map(|i| g.gears[i].kappa() * cos_beta_b / middle.roll[i])
            .sum();
        Candidate {
            tooth_pair: k,
            z,
            roll: middle.roll,
            gap,
            radius: curvature.recip(),
            // The transverse tangent is normal to the generator; the gap is cos beta_b of that along the
            // line of action.
            edge_slope: middle.edge_slope * cos_beta_b,
            edge_gear: middle.edge_gear,
            arm: middle.arm,
            strips: [0, 1].map(|i| self.canonical(i, k, z, [ends[0].roll[i], ends[1].roll[i]])),
        }
    }

    /// The strip as gear `i` sees it once it is mirrored into a right-handed gear whose loaded flank
    /// faces +theta.
    ///
    /// The loaded flank faces the sense sigma_1 = s on gear 1 and sigma_2 = e s on gear 2. A mirror
    /// theta -> -theta turns over both sigma and the hand, a mirror z -> -z the hand alone; so theta is
    /// mirrored for sigma = -1 and z for h sigma = -1. Tooth pair k lies k pitches ahead in the sense of
    /// rotation: tooth s k on gear 1 and -e s k on gear 2, after the mirror k and -k.
    fn canonical(&self, i: usize, k: i32, z: [f64; 2], roll: [f64; 2]) -> Strip {
        let gear: &Gear = &self.geometry.gears[i];
        let s = self.flank.sign();
        let sigma = if i == 0 { s } else { self.geometry.e() * s };
        let tooth = if i == 0 { k } else { -k };
        let own = z.map(|z| (z - gear.face_offset).clamp(0.0, gear.face_width));
        if gear.hand * sigma < 0.0 {
            let b = gear.face_width;
            Strip {
                tooth,
                z: [b - own[1], b - own[0]],
                roll: [roll[1], roll[0]],
            }
        } else {
            Strip {
                tooth,
                z: own,
                roll,
            }
        }
    }
}
