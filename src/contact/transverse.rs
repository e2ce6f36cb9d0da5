//! Where tooth pairs touch in the transverse section, on the path of contact and beyond its ends.

use std::f64::consts::FRAC_PI_2;

use super::local_law::Corner;
use crate::gear::{Flank, Gear, PairGeometry};
use crate::root::bisection;

const HALVINGS: usize = 30;

/// The numbers of a pair that contact needs again and again; in [`PairGeometry`] they follow from the nominal data through
/// several angles. Index 0 is gear 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairNumbers {
    pub base_radius: [f64; 2],
    /// +1 external gear, -1 ring.
    pub kappa: [f64; 2],
    /// +1 external, -1 internal pair.
    pub e: f64,
    /// abs(rb1 + e rb2), m.
    pub base_radius_sum: f64,
    pub base_pitch: f64,
    /// Tangent of the base helix angle, >= 0.
    pub tan_beta_b: f64,
    pub cos_beta_b: f64,
    /// +1 right-handed helix of gear 1, -1 left-handed.
    pub hand: f64,
    /// Mid-face of the overlap of both faces in gear 1's frame, m.
    pub z_ref: f64,
    /// The overlap of both faces in gear 1's frame: lower end and width, m.
    pub face: [f64; 2],
    pub tip_roll: [f64; 2],
    pub face_offset: [f64; 2],
    pub plane_compliance: [f64; 2],
    /// How much more teeth give way at their tip edges than half-planes.
    pub corners: [Corner; 2],
}

impl PairNumbers {
    /// Those of `geometry`, with tip corners that elastic models resolve down to the distances `corner_resolution` (m) from the
    /// edge; zero: none.
    pub fn new(geometry: &PairGeometry, corner_resolution: [f64; 2]) -> PairNumbers {
        let each = |number: fn(&Gear) -> f64| geometry.gears.each_ref().map(number);
        let (low, width) = geometry.face_overlap();
        let plane_compliance = each(|g| (1.0 - g.poisson_ratio.powi(2)) / g.youngs_modulus);
        let corners = [0, 1].map(|i| {
            let gear = &geometry.gears[i];
            let angle = FRAC_PI_2 + (gear.tip_form_roll() / gear.base_radius()).atan();
            Corner::new(angle, plane_compliance[i], corner_resolution[i])
        });
        PairNumbers {
            base_radius: each(|g| g.base_radius()),
            kappa: each(|g| g.kappa()),
            e: geometry.e(),
            base_radius_sum: geometry.base_radius_sum(),
            base_pitch: geometry.base_pitch(),
            tan_beta_b: geometry.base_helix_angle().tan(),
            cos_beta_b: geometry.base_helix_angle().cos(),
            hand: geometry.gears[0].hand,
            z_ref: geometry.z_ref(),
            face: [low, width],
            tip_roll: each(|g| g.tip_form_roll()),
            face_offset: each(|g| g.face_offset),
            plane_compliance,
            corners,
        }
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

/// A point that may touch: lengths of roll on both gears and what separates the flanks there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransversePoint {
    /// Length of roll on gear 1 and gear 2, m.
    pub roll: [f64; 2],
    /// Gap between the unmodified flanks along the line of action, m: zero on the path of contact.
    pub separation: f64,
    /// Slope of this gap over the distance along the flanks towards the tip of gear 1: zero on the path,
    /// beyond it the inclination of the flanks.
    pub slope: f64,
    /// Arms of the contact force about the axes of gear 1 and gear 2 over their base radii: 1 on the path and on the
    /// gear whose flank a tip edge bears on, whose normals touch its own base circle.
    pub arms: [f64; 2],
}

/// The transverse section at one centre distance.
///
/// Coordinates: pitch point as origin, x along the line of action in the sense in which contact moves,
/// y normal to it towards the side on which gear 1's base tangent point sees its centre behind (O1 lies
/// at y = -rb1). Both base circles carry their tangent points along +x while the pair turns. With
/// q = kappa_1 for gear 1 and -kappa_2 for gear 2, the length of roll is rb tan phi + q xi on either.
#[derive(Debug, Clone, PartialEq)]
pub struct TransverseSection {
    numbers: PairNumbers,
    sides: [Side; 2],
    tan_phi: f64,
    path: [f64; 2],
    /// How far candidates go, m from the pitch point: beyond the path where tip corners count.
    reach: [f64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    rb: f64,
    kappa: f64,
    /// Length of roll grows by q per unit of xi.
    q: f64,
    /// y of the base tangent point seen from the centre, over rb.
    up: f64,
    tip_roll: f64,
    /// Length of roll at which the involute ends at the root.
    form_roll: f64,
}

impl TransverseSection {
    /// Section at `center_distance`, m; with `separation_limit` (m) tip corners are followed beyond the path until flanks are that far
    /// apart. `form_rolls`: lengths of roll at which the involutes end at the root. None without a path of contact.
    pub fn new(
        numbers: &PairNumbers,
        center_distance: f64,
        form_rolls: [f64; 2],
        separation_limit: Option<f64>,
    ) -> Option<TransverseSection> {
        let side = |i: usize| Side {
            rb: numbers.base_radius[i],
            kappa: numbers.kappa[i],
            q: if i == 0 { 1.0 } else { -1.0 } * numbers.kappa[i],
            up: if i == 0 { 1.0 } else { -numbers.e },
            tip_roll: numbers.tip_roll[i],
            form_roll: form_rolls[i],
        };
        let sides = [side(0), side(1)];
        let tan_phi = numbers.tan_phi(center_distance);
        let beyond = |side: &Side| side.kappa * (side.tip_roll - side.rb * tan_phi);
        let path = [-beyond(&sides[1]), beyond(&sides[0])];
        let length = path[1] - path[0];
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let mut section = TransverseSection {
            numbers: *numbers,
            sides,
            tan_phi,
            path,
            reach: path,
        };
        if let Some(limit) = separation_limit {
            for end in 0..2 {
                section.reach[end] = section.reach_beyond(end, limit);
            }
        }
        Some(section)
    }

    /// The section at a `center_distance` (m) next to this one, with candidates as far as here.
    pub fn near(&self, center_distance: f64) -> Option<TransverseSection> {
        let form_rolls = self.sides.map(|side| side.form_roll);
        let section = TransverseSection::new(&self.numbers, center_distance, form_rolls, None)?;
        let reach = self.reach;
        Some(TransverseSection { reach, ..section })
    }

    pub fn numbers(&self) -> &PairNumbers {
        &self.numbers
    }

    pub fn reach(&self) -> [f64; 2] {
        self.reach
    }

    /// Mesh positions between which tooth pair 0 comes within the reach of contact.
    pub fn passage(&self) -> [f64; 2] {
        let tilt = 0.5 * self.numbers.face[1] * self.numbers.tan_beta_b;
        let [first, last] = self.reach;
        [first - tilt, last + tilt].map(|end| end / self.numbers.base_pitch)
    }

    /// The point that may touch while the conjugate position of the tooth pair is `xi`.
    pub fn point(&self, xi: f64) -> TransversePoint {
        if xi < self.path[0] {
            self.tip_corner(0, xi)
        } else if xi > self.path[1] {
            self.tip_corner(1, xi)
        } else {
            let roll = [0, 1].map(|i| self.roll(i, xi));
            TransversePoint {
                roll,
                separation: 0.0,
                slope: 0.0,
                arms: [1.0; 2],
            }
        }
    }

    /// Length of flank from the length of roll `roll` on gear `i` to its tip edge, m.
    pub fn distance_to_edge(&self, i: usize, roll: f64) -> f64 {
        let side = &self.sides[i];
        (side.kappa * (side.tip_roll - roll) * (side.tip_roll + roll) / (2.0 * side.rb)).max(0.0)
    }

    /// Lengths of roll of gear `i` at its tip and where its involute ends at the root, m.
    pub fn flank_ends(&self, i: usize) -> [f64; 2] {
        [self.sides[i].tip_roll, self.sides[i].form_roll]
    }

    fn roll(&self, i: usize, xi: f64) -> f64 {
        self.sides[i].rb * self.tan_phi + self.sides[i].q * xi
    }

    /// The tip edge of the gear whose tip ends the path at `end` (0: gear 2, at the start; 1: gear 1)
    /// against the flank of its mate, both turned to the conjugate position `xi` beyond that end.
    ///
    /// The gap is the signed distance G / cos beta_b of the mate's involute (formulation.md) at the tip
    /// edge: base radius times the angle by which the mate would have to turn to touch it.
    fn tip_corner(&self, end: usize, xi: f64) -> TransversePoint {
        let (tip, mate) = (1 - end, end);
        let (a, b) = (&self.sides[tip], &self.sides[mate]);
        let turn = (xi - self.path[end]) / a.rb;
        let (sin, cos) = turn.sin_cos();
        // Seen from the centre of the tip's gear: towards its base tangent point, and along x.
        let (normal, along) = (
            a.rb * cos - a.q * a.tip_roll * sin,
            a.rb * sin + a.q * a.tip_roll * cos,
        );
        let from_tip = [along, normal];
        let x = along - a.q * a.rb * self.tan_phi;
        let y = a.up * (normal - a.rb);
        // Seen from the centre of the mate.
        let (normal, along) = (b.up * y + b.rb, x + b.q * b.rb * self.tan_phi);
        let radius = normal.hypot(along);
        let roll = ((radius - b.rb).max(0.0) * (radius + b.rb)).sqrt();
        let (seen, involute) = (along.atan2(normal), (roll / b.rb).atan());
        let involute_angle = (xi - b.q * (roll - b.rb * self.tan_phi)) / b.rb + b.q * involute;
        let behind = b.rb * (involute_angle - seen);
        let mut rolls = [0.0; 2];
        rolls[tip] = a.tip_roll;
        rolls[mate] = roll;
        let mut arms = [1.0; 2];
        // The force acts along the mate's normal, turned by this about the mate's centre.
        let turned = seen - b.q * involute;
        let about_tip_gear =
            (from_tip[1] * turned.cos() + a.up * b.up * from_tip[0] * turned.sin()) / a.rb;
        // By how much the normals have turned out of the line of action: clockwise about a centre below it,
        // counter-clockwise about one above.
        let inclined = (a.up * turn - b.up * turned).abs();
        arms[tip] = about_tip_gear;
        TransversePoint {
            roll: rolls,
            separation: if mate == 1 { behind } else { -behind },
            slope: if tip == 0 { -inclined } else { inclined },
            arms,
        }
    }

    /// Farthest conjugate position beyond the path's `end` with a separation below `limit` and a tip edge that faces the involute.
    fn reach_beyond(&self, end: usize, limit: f64) -> f64 {
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let mate = &self.sides[end];
        let is_within = |beyond: f64| {
            let point = self.tip_corner(end, self.path[end] + sign * beyond);
            point.separation <= limit && mate.kappa * (mate.form_roll - point.roll[end]) <= 0.0
        };
        let longest = 0.5 * (self.path[1] - self.path[0]);
        self.path[end] + sign * bisection([0.0, longest], HALVINGS, is_within)
    }
}
