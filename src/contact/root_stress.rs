//! Stress in the tooth roots: the fillet beside the loaded flank, and at run time a map from loads at stations to it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::candidates::{Candidate, ContactLines};
use super::segment::Segment;
use crate::vector::Lanes;

/// Components of stress at each point: along the profile, along the helix, shear; Pa.
pub const COMPONENTS: usize = 3;

/// The points of the fillet at which stress is observed, along the profile and the face, in the coordinates of [`Segment`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Fillet {
    /// Places along the profile from the middle of the space to the start of the involute: radius, m.
    pub radii: Vec<f64>,
    /// Angle between the tangent plane and the tooth's centre line there, rad.
    pub tangents: Vec<f64>,
    /// Arc length from the start of the involute, m, ascending, <= 0.
    pub arcs: Vec<f64>,
    /// Places along the face, m, ascending; a single one in plane strain.
    pub z: Vec<f64>,
    /// Roll length at the start of the involute, m.
    pub form_roll: f64,
    /// 1/m: arc = this * (roll² - form_roll²) on the flank.
    pub arc_per_roll_squared: f64,
    /// Distance from a load within which stress is left out of the largest one, m.
    pub local: f64,
    /// Tangent to the centre line at which the standards look, rad.
    pub standard_tangent: f64,
}

/// Stress in the root of one tooth beside its loaded flank.
#[derive(Debug, Clone, PartialEq)]
pub struct RootField<'a> {
    fillet: &'a Fillet,
    /// Places along the face, m.
    z: Cow<'a, [f64]>,
    /// At each place along the face how many places along the profile, from the middle of the space, lie off the loads.
    clear: Vec<usize>,
    /// Largest principal stress at each place along the face (outer) and along the profile, Pa, tension positive.
    principal: Vec<f64>,
}

/// A point of the fillet and the largest principal stress there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RootPoint {
    /// Largest principal stress, Pa, tension positive.
    pub stress: f64,
    /// Along the face, m from the z = 0 face of the gear as [`Segment`] counts it.
    pub z: f64,
    /// Distance from the axis, m.
    pub radius: f64,
    /// Angle between the fillet's tangent plane and the tooth's centre line, rad.
    pub tangent: f64,
}

impl Fillet {
    /// Number of components of stress at all points.
    pub fn components(&self) -> usize {
        COMPONENTS * self.radii.len() * self.z.len()
    }

    /// The field of the stress `components`, Pa (by face, profile, component), of a tooth with the segments `loaded` on its flank.
    pub fn field<'s>(
        &self,
        components: &[f64],
        loaded: impl Iterator<Item = &'s Segment> + Clone,
    ) -> RootField<'_> {
        self.field_at(Cow::Borrowed(&self.z), components, loaded)
    }

    /// The same where the places along the face are `z`, m: in plane strain the slices that were looked at.
    pub fn field_at<'f, 's>(
        &'f self,
        z: Cow<'f, [f64]>,
        components: &[f64],
        loaded: impl Iterator<Item = &'s Segment> + Clone,
    ) -> RootField<'f> {
        let principal = components.chunks(COMPONENTS).map(|s| {
            let (mean, half) = (0.5 * (s[0] + s[1]), 0.5 * (s[0] - s[1]));
            mean + half.hypot(s[2])
        });
        let clear = z.iter().map(|z| self.clear(*z, loaded.clone()));
        RootField {
            fillet: self,
            clear: clear.collect(),
            z,
            principal: principal.collect(),
        }
    }

    /// How many places along the profile at `z` lie farther than `local` from the `loaded` segments of this tooth; at least one.
    fn clear<'s>(&self, z: f64, loaded: impl Iterator<Item = &'s Segment>) -> usize {
        let lowest = loaded.filter_map(|segment| {
            let nearest = z.clamp(segment.z[0], segment.z[1]);
            let along = (nearest - segment.z[0]) / (segment.z[1] - segment.z[0]);
            let roll = segment.roll[0] + along * (segment.roll[1] - segment.roll[0]);
            let square = self.local.powi(2) - (z - nearest).powi(2);
            let arc = self.arc_per_roll_squared * (roll.powi(2) - self.form_roll.powi(2));
            (square > 0.0).then(|| arc - square.sqrt())
        });
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        self.arcs.partition_point(|arc| *arc < lowest).max(1)
    }
}

/// Stress in the tooth roots of one gear by the loads on its stations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CondensedRoots {
    /// The fillet of every tooth.
    pub fillet: Fillet,
    /// Largest difference of tooth numbers between a load and a root; loads farther away leave no stress.
    pub reach: usize,
    /// Stations along the face, as of the contact lines.
    pub stations: usize,
    /// Lengths of roll of the loads at the start of the involute and at the tip, m; falling for a ring.
    pub rolls: [f64; 2],
    /// Change of the length of roll along a contact line over that of z.
    pub roll_by_z: f64,
    /// Differences of tooth numbers (root minus load) from -reach to reach, stations, [`ROLLS`] equal steps of roll, places along the
    /// face, places along the profile, components: Pa/N.
    #[serde(skip)]
    pub values: Vec<f32>,
}

/// Lengths of roll at which loads are known.
pub const ROLLS: usize = 7;

impl CondensedRoots {
    /// Number of all values; `None` where the grid makes no sense.
    pub fn value_count(&self) -> Option<usize> {
        let fillet = &self.fillet;
        let profile = fillet.arcs.len();
        let makes_sense = profile >= 3
            && [fillet.radii.len(), fillet.tangents.len()] == [profile; 2]
            && !fillet.z.is_empty()
            && self.reach < 1000
            && self.rolls[0] != self.rolls[1];
        let teeth = self.reach.checked_mul(2)?.checked_add(1)?;
        let columns = teeth.checked_mul(self.stations)?.checked_mul(ROLLS)?;
        let count = columns.checked_mul(fillet.components())?;
        makes_sense.then_some(count)
    }

    /// Largest principal stress over face, fillet and loaded teeth of gear `i` under `loads` on segments of `lines`, Pa; 0 without
    /// load.
    pub(super) fn largest(
        &self,
        lines: &ContactLines<'_>,
        i: usize,
        loads: &[(&Candidate, f64)],
    ) -> f64 {
        let seen = |(c, _): &(&Candidate, f64)| {
            let mut segment = lines.seen_by_gear(i, c.tooth_pair, c.z, [c.roll[i]; 2]);
            let half = 0.5 * self.roll_by_z * (segment.z[1] - segment.z[0]);
            segment.roll[0] -= half;
            segment.roll[1] += half;
            segment
        };
        let seen: Vec<Segment> = loads.iter().map(seen).collect();
        let (count, reach, [low, high]) = (self.fillet.components(), self.reach as i32, self.rolls);
        let mut stress = vec![0.0; count];
        let mut largest = 0.0f64;
        for of_tooth in seen.chunk_by(|a, b| a.tooth == b.tooth) {
            stress.fill(0.0);
            Lanes::widest().run(|_| {
                for ((candidate, force), segment) in loads.iter().zip(&seen) {
                    let away = of_tooth[0].tooth - segment.tooth;
                    if away.abs() > reach {
                        continue;
                    }
                    let x = (candidate.roll[i] - low) / (high - low) * (ROLLS - 1) as f64;
                    let first = (x.floor().max(1.0) as usize - 1).min(ROLLS - 4);
                    let station = (away + reach) as usize * self.stations + candidate.station;
                    let columns = self.values[(station * ROLLS + first) * count..].chunks(count);
                    for (weight, column) in cubic(x - first as f64).into_iter().zip(columns) {
                        let force = weight * force;
                        for (sum, value) in stress.iter_mut().zip(column) {
                            *sum += force * f64::from(*value);
                        }
                    }
                }
            });
            let field = self.fillet.field(&stress, of_tooth.iter());
            largest = largest.max(field.largest().stress);
        }
        largest
    }
}

/// Weights of the cubic through 0, 1, 2, 3 at `x`, cut to them.
fn cubic(x: f64) -> [f64; 4] {
    let x = x.clamp(0.0, 3.0);
    let [a, b, c, d] = [x, x - 1.0, x - 2.0, x - 3.0];
    [
        -b * c * d / 6.0,
        a * c * d / 2.0,
        -a * b * d / 2.0,
        a * b * c / 6.0,
    ]
}

impl RootField<'_> {
    /// Places along the face, m.
    pub fn z(&self) -> &[f64] {
        &self.z
    }

    /// Largest principal stress from the middle of the space to the start of the involute, at the place `number` along the face.
    pub fn profile(&self, number: usize) -> impl Iterator<Item = RootPoint> {
        let fillet = self.fillet;
        let points = self.stress(number).iter().enumerate();
        points.map(move |(i, stress)| RootPoint {
            stress: *stress,
            z: self.z[number],
            radius: fillet.radii[i],
            tangent: fillet.tangents[i],
        })
    }

    /// Largest principal stress at the places along the profile, Pa.
    fn stress(&self, number: usize) -> &[f64] {
        let n = self.fillet.arcs.len();
        &self.principal[number * n..][..n]
    }

    /// Where the largest principal stress is largest, but for places within 0.45 normal modules of a load on this flank: there it
    /// is local, and without limit under a corner. Between the places along the profile by a parabola.
    pub fn largest(&self) -> RootPoint {
        let places = (0..self.z.len()).map(|number| self.largest_at(number));
        places.reduce(larger).unwrap_or_default()
    }

    /// The same at the place `number` along the face.
    pub fn largest_at(&self, number: usize) -> RootPoint {
        let (stress, arcs, clear) = (self.stress(number), &self.fillet.arcs, self.clear[number]);
        let top = (0..clear).max_by(|a, b| stress[*a].total_cmp(&stress[*b]));
        let i = top.unwrap_or(0);
        if i == 0 || i + 1 == clear {
            return self.at_arc(number, arcs[i]);
        }
        let [x0, x2] = [i - 1, i + 1].map(|k| arcs[k] - arcs[i]);
        let [y0, y2] = [i - 1, i + 1].map(|k| stress[k] - stress[i]);
        // Through (0, 0): y = a x + b x²; both neighbours lie lower, so that b < 0 and the top between them.
        let b = (y0 / x0 - y2 / x2) / (x0 - x2);
        let a = y0 / x0 - b * x0;
        let away = if b < 0.0 { -0.5 * a / b } else { 0.0 };
        self.at_arc(number, arcs[i] + away)
    }

    /// Largest over the face where the fillet's tangent makes 30 degrees (ring: 60) with the centre line of the tooth, but for
    /// what [`RootField::largest`] leaves out, unless that is all of it. None if the fillet has no such place.
    pub fn at_tangent(&self) -> Option<RootPoint> {
        let (arcs, tangents) = (&self.fillet.arcs, &self.fillet.tangents);
        let standard = self.fillet.standard_tangent;
        let holds = |i: &usize| tangents[*i] <= standard && standard < tangents[i - 1];
        let after = (1..arcs.len()).rev().find(holds)?;
        let t = (standard - tangents[after]) / (tangents[after - 1] - tangents[after]);
        let arc = arcs[after] + t * (arcs[after - 1] - arcs[after]);
        let is_clear = |number: &usize| after < self.clear[*number];
        let anywhere = !(0..self.clear.len()).any(|number| is_clear(&number));
        let places = (0..self.clear.len()).filter(|number| anywhere || is_clear(number));
        places.map(|number| self.at_arc(number, arc)).reduce(larger)
    }

    /// Parabola through the three places nearest to `arc`.
    fn at_arc(&self, number: usize, arc: f64) -> RootPoint {
        let (fillet, arcs) = (self.fillet, &self.fillet.arcs);
        let distance = |i: &usize| (arcs[*i] - arc).abs();
        let nearest = (0..arcs.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let i = nearest.unwrap_or(0).clamp(1, arcs.len() - 2);
        let three = [i - 1, i, i + 1];
        let weights = three.map(|k| {
            let others = three.iter().filter(|o| **o != k);
            let part = others.map(|o| (arc - arcs[*o]) / (arcs[k] - arcs[*o]));
            part.product::<f64>()
        });
        let mean = |of: &[f64]| three.iter().zip(weights).map(|(k, w)| w * of[*k]).sum();
        RootPoint {
            stress: mean(self.stress(number)),
            z: self.z[number],
            radius: mean(&fillet.radii),
            tangent: mean(&fillet.tangents),
        }
    }
}

fn larger(a: RootPoint, b: RootPoint) -> RootPoint {
    if b.stress > a.stress { b } else { a }
}
