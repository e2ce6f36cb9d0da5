//! Cross-sections of a shaft, and its shoulders.

use std::f64::consts::PI;

use crate::gear::Shaft;
use gearmesh::gear::Gear;

/// Places closer than this are one, m.
pub const SAME_PLACE: f64 = 1e-8;

/// Rigidities of a cross-section.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rigidity {
    /// E I, N m².
    pub bending: f64,
    /// k G A, N.
    pub shear: f64,
    /// E A, N.
    pub tension: f64,
    /// G I_p, N m².
    pub torsion: f64,
}

impl Rigidity {
    /// A ring between the radii `inner` and `outer`, m. Shear factor after Cowper, J. Appl. Mech. 33 (1966) 335-340, Table 1.
    pub fn ring([inner, outer]: [f64; 2], youngs_modulus: f64, poisson_ratio: f64) -> Rigidity {
        let shear_modulus = 0.5 * youngs_modulus / (1.0 + poisson_ratio);
        let area = PI * (outer * outer - inner * inner);
        let moment = 0.25 * PI * (outer.powi(4) - inner.powi(4));
        let (nu, m2) = (poisson_ratio, (inner / outer).powi(2));
        let hollow = (1.0 + m2).powi(2);
        let factor =
            6.0 * (1.0 + nu) * hollow / ((7.0 + 6.0 * nu) * hollow + (20.0 + 12.0 * nu) * m2);
        Rigidity {
            bending: youngs_modulus * moment,
            shear: factor * shear_modulus * area,
            tension: youngs_modulus * area,
            torsion: 2.0 * shear_modulus * moment,
        }
    }

    /// The section of `shaft` at `z` (m), with the body of `gear` where that sits.
    pub fn at(shaft: &Shaft, gear: &Gear, z: f64) -> Rigidity {
        let [inner, outer] = shaft.radii_at(z);
        let mut all = Rigidity::ring([inner, outer], shaft.youngs_modulus, shaft.poisson_ratio);
        let sits = shaft.seat[0] <= z && z <= shaft.seat[1];
        if sits && shaft.seat_radius > outer {
            let radii = [outer, shaft.seat_radius];
            let body = Rigidity::ring(radii, gear.youngs_modulus, gear.poisson_ratio);
            all.bending += body.bending;
            all.shear += body.shear;
            all.tension += body.tension;
            all.torsion += body.torsion;
        }
        all
    }
}

/// Where the thinner section beside a shoulder is softer than its length makes it.
pub struct Shoulder {
    /// Ends of this part of the thinner section, m.
    pub z: [f64; 2],
    /// Flexibility in bending, shear and torsion over that of the section alone.
    pub softer: [f64; 3],
}

/// The shoulders of `shaft`, those of its gear among them.
///
/// The end of the thicker section acts as so much more length of the thinner one. Beside a half-space it is that of a rigid disc
/// on it, which tilts by 3 (1 - nu) M / (8 G r³), moves by (2 - nu) F / (8 G r) and turns by 3 T / (16 G r³) (Johnson, Contact Mechanics,
/// sections 3.6 to 3.9); with q = r/R the ratio of the radii it is 1 - 4 q³ + 3 q⁴ of that, in shear (1 - q)², as if the section grew from
/// one radius to the other at 45 degrees. Taken with the thinner section, so that the teeth above the shoulder keep the shape
/// of the whole body.
pub fn shoulders(shaft: &Shaft) -> Vec<Shoulder> {
    let [first, .., last] = shaft.section_ends()[..] else {
        return vec![];
    };
    let mut ends = shaft.section_ends();
    ends.extend(shaft.seat.map(|z| z.clamp(first, last)));
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|b, a| *b - *a < SAME_PLACE);
    // Ends and outer radius between neighbouring ends.
    let mut pieces = Vec::new();
    for piece in ends.windows(2) {
        let z = 0.5 * (piece[0] + piece[1]);
        let sits = shaft.seat[0] <= z && z <= shaft.seat[1];
        let [_, outer] = shaft.radii_at(z);
        let radius = if sits {
            outer.max(shaft.seat_radius)
        } else {
            outer
        };
        pieces.push((piece, radius));
    }
    let shoulders = pieces.windows(2).map(|both| {
        let (thin, thick) = match both[0].1 < both[1].1 {
            true => (both[0], both[1]),
            false => (both[1], both[0]),
        };
        let (q, nu) = (thin.1 / thick.1, shaft.poisson_ratio);
        let moments = 1.0 - 4.0 * q.powi(3) + 3.0 * q.powi(4);
        let shear_factor = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
        let more = [
            3.0 * PI / 16.0 * (1.0 - nu * nu) * moments,
            PI / 8.0 * shear_factor * (2.0 - nu) * (1.0 - q).powi(2),
            3.0 * PI / 32.0 * moments,
        ];
        let part = thin.1.min(thin.0[1] - thin.0[0]);
        Shoulder {
            z: match both[0].1 < both[1].1 {
                true => [thin.0[1] - part, thin.0[1]],
                false => [thin.0[0], thin.0[0] + part],
            },
            softer: more.map(|length| 1.0 + length * thin.1 / part),
        }
    });
    shoulders.collect()
}
