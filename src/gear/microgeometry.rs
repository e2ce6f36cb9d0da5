//! What is taken off the involute flanks of one gear.
//!
//! Every amount is in metres along the flank normal, material removed positive. Profile modifications run over
//! the length of roll (`roll`, [`Gear::roll_length`]), lead modifications over the gear's own face, bias and
//! topography over both. [`Microgeometry::removal`] is their sum; contact takes its parts along profile and face. Names
//! and signs of drawings: ISO 21771-1, ISO 1328-1; where a sign differs from theirs, the field says so.

use super::topography::{ProfilePiece, Topography};
use super::{BothFlanks, Gear};
use serde::{Deserialize, Serialize};

/// All modifications of one flank of one gear, SI. The default is the unmodified involute helicoid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Microgeometry {
    /// Tip relief.
    pub tip_relief: Option<ProfileRelief>,
    /// Root relief.
    pub root_relief: Option<ProfileRelief>,
    /// Profile crowning.
    pub profile_crowning: Option<ProfileCrowning>,
    /// Profile slope, and its change along the face: bias.
    pub profile_slope: Option<ProfileSlope>,
    /// Lead crowning: removal at each end of the face, m, parabolic, zero at mid-face.
    pub lead_crowning: f64,
    /// Lead slope: removal at the z = face width end minus that at the z = 0 end, m; zero at
    /// mid-face, so that it shifts no transmission error that is referred to mid-face. The same on both flanks of a
    /// tooth it tapers the tooth, of opposite signs it changes the helix angle.
    pub lead_slope: f64,
    /// End reliefs at the z = 0 end and at the z = face width end.
    pub end_relief: [Option<EndRelief>; 2],
    /// Measured or designed flank, in addition to all others.
    pub topography: Option<Topography>,
}

impl Microgeometry {
    /// Removal along the flank normal, m, at the length of roll `roll` (transverse, m) and at `z`, m from the z = 0 face of this
    /// gear as it stands: who mirrors a gear along its axis must mirror `z` back first.
    pub fn removal(&self, gear: &Gear, roll: f64, z: f64) -> f64 {
        self.profile(gear, roll, z).removal + self.lead(gear, z)
    }

    /// Tip relief and root relief, as far as there are.
    pub fn reliefs(&self) -> impl Iterator<Item = &ProfileRelief> {
        [&self.tip_relief, &self.root_relief].into_iter().flatten()
    }

    /// Slope and curvature over the length of roll without the reliefs, m/m and m/m²; the curvature of a topography is its
    /// second difference over +-`by` (m of roll).
    pub fn smooth_slopes(&self, gear: &Gear, roll: f64, z: f64, by: f64) -> [f64; 2] {
        let none = ProfilePiece::default();
        let slope = self.add_smooth(none, gear, roll, z).slope;
        let crowning = self.profile_crowning.as_ref();
        let mut curvature = crowning.map_or(0.0, |c| c.piece(roll).curvature);
        if let Some(f) = &self.topography {
            let [low, here, high] = [roll - by, roll, roll + by].map(|roll| f.removal(roll, z));
            curvature += (high - 2.0 * here + low) / (by * by);
        }
        [slope, curvature]
    }

    /// [`Microgeometry::removal`] less [`Microgeometry::lead`], and its derivatives by the length of roll.
    #[inline]
    pub fn profile(&self, gear: &Gear, roll: f64, z: f64) -> ProfilePiece {
        let mut piece = ProfilePiece::default();
        for relief in self.reliefs() {
            piece = piece.and(relief.piece(roll));
        }
        self.add_smooth(piece, gear, roll, z)
    }

    /// What modifies the whole profile, on top of `piece`.
    #[inline(always)]
    fn add_smooth(&self, mut piece: ProfilePiece, gear: &Gear, roll: f64, z: f64) -> ProfilePiece {
        if let Some(crowning) = &self.profile_crowning {
            piece = piece.and(crowning.piece(roll));
        }
        if let Some(slope) = &self.profile_slope {
            piece = piece.and(slope.piece(roll, along_face(gear, z)));
        }
        if let Some(topography) = &self.topography {
            piece = piece.and(topography.piece(roll, z));
        }
        piece
    }

    /// The part of [`Microgeometry::removal`] that depends on `z` alone, m.
    pub fn lead(&self, gear: &Gear, z: f64) -> f64 {
        let t = along_face(gear, z);
        let reliefs = self.end_relief.iter().zip([z, gear.face_width - z]);
        let removal = reliefs.map(|(relief, z)| relief.map_or(0.0, |r| r.removal(z)));
        let end_relief: f64 = removal.sum();
        self.lead_crowning * t * t + 0.5 * self.lead_slope * t + end_relief
    }

    /// Whether the removal depends on the length of roll.
    pub fn has_profile(&self) -> bool {
        let is_smooth = self.profile_crowning.is_some() || self.profile_slope.is_some();
        is_smooth || self.topography.is_some() || self.reliefs().next().is_some()
    }

    /// Whether the slope over the length of roll changes along the face.
    pub fn varies_along_face(&self) -> bool {
        self.profile_slope.is_some_and(|p| p.bias != 0.0) || self.topography.is_some()
    }

    /// Bound of [`Microgeometry::removal`] over the whole face between the lengths of roll `rolls` (either first), m.
    pub fn largest_removal(&self, gear: &Gear, rolls: [f64; 2]) -> f64 {
        let mut smooth = self.clone();
        let topography = smooth.topography.take();
        // Without a topography removals are convex in both directions: largest in a corner.
        let ends = [0.0, gear.face_width];
        let removal = |roll: f64| ends.map(|z| smooth.removal(gear, roll, z));
        let largest = rolls.into_iter().flat_map(removal).fold(0.0, f64::max);
        largest + topography.map_or(0.0, |f| f.largest_removal())
    }

    /// Whether the flank looks the same from both ends of the face.
    pub fn is_symmetric(&self) -> bool {
        let [low, high] = &self.end_relief;
        self.lead_slope == 0.0 && low == high && !self.varies_along_face()
    }
}

/// -1 at the z = 0 face, +1 at the other.
fn along_face(gear: &Gear, z: f64) -> f64 {
    2.0 * z / gear.face_width - 1.0
}

/// Modifications of both flanks of both gears.
pub type PairMicrogeometry = BothFlanks<Microgeometry>;

/// How a relief grows from its start to its end. Older files of units have the names with a capital.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReliefShape {
    /// In proportion to the distance from the start.
    #[default]
    #[serde(alias = "Linear")]
    Linear,
    /// With the square of the distance from the start, so that the flank has no kink there.
    #[serde(alias = "Parabolic")]
    Parabolic,
    /// A circular arc that leaves the flank as a tangent. Over a length L an amount a differs from the parabola by
    /// less than a (a / L)², a billionth of a metre at most, and is taken as one.
    #[serde(alias = "Arc")]
    Arc,
}

impl ReliefShape {
    /// Removal over the full amount at the fraction `t` of the way, and its first two derivatives; zero for t < 0, and
    /// continued beyond t = 1, where the mate's tip may touch when the centre distance shrinks.
    #[inline(always)]
    fn evaluate(self, t: f64) -> [f64; 3] {
        match self {
            _ if t < 0.0 => [0.0; 3],
            ReliefShape::Linear => [t, 1.0, 0.0],
            ReliefShape::Parabolic | ReliefShape::Arc => [t * t, 2.0 * t, 2.0],
        }
    }
}

/// Tip or root relief, over the length of roll.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfileRelief {
    /// Removal at `end_roll`, m.
    pub amount: f64,
    /// Length of roll at which it starts, m.
    pub start_roll: f64,
    /// Length of roll at which it reaches `amount`, m: the tip, or for root relief the start of the
    /// active profile. Below `start_roll` for a root relief and for the tip relief of a ring.
    pub end_roll: f64,
    /// Growth between them.
    pub shape: ReliefShape,
}

impl ProfileRelief {
    /// Removal and its derivatives at the length of roll `roll`, m, valid up to where the relief starts.
    #[inline(always)]
    pub fn piece(&self, roll: f64) -> ProfilePiece {
        let (from_start, length) = (roll - self.start_roll, self.end_roll - self.start_roll);
        let begun = from_start * length >= 0.0;
        let steepness = self.amount / length;
        let mut piece = ProfilePiece::default();
        if begun {
            let [removal, slope, curvature] = self.shape.evaluate(from_start / length);
            let by_roll = [steepness * slope, steepness / length * curvature];
            piece = ProfilePiece::parabola([self.amount * removal, by_roll[0], by_roll[1]]);
        }
        // Whether the piece goes on towards longer lengths of roll.
        let is_before = begun == (length > 0.0);
        piece.range[usize::from(!is_before)] = self.start_roll;
        piece
    }

    /// 1 where the relief lies at longer lengths of roll than its start, -1 at shorter ones.
    pub fn side(&self) -> f64 {
        (self.end_roll - self.start_roll).signum()
    }
}

/// Profile crowning (barrelling): parabolic, zero at mid-profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfileCrowning {
    /// Removal at both ends of the active profile, m.
    pub amount: f64,
    /// Lengths of roll at these ends, m.
    pub rolls: [f64; 2],
}

impl ProfileCrowning {
    /// Removal and its derivatives at the length of roll `roll`, m.
    #[inline(always)]
    pub fn piece(&self, roll: f64) -> ProfilePiece {
        let way = along(self.rolls, roll);
        let per_length = 2.0 / (self.rolls[1] - self.rolls[0]);
        let slope = 2.0 * self.amount * per_length;
        ProfilePiece::parabola([self.amount * way.powi(2), slope * way, slope * per_length])
    }
}

/// Profile slope and its change along the face: linear over the length of roll, zero at mid-profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfileSlope {
    /// Removal at the tip minus that at the start of the active profile, at mid-face, m: minus cos beta_b times the C_Ha of
    /// ISO 1328-1, which counts material that grows towards the tip, in the transverse section.
    pub amount: f64,
    /// `amount` at the z = face width end minus that at the z = 0 end, m: the twist (bias) of the flank.
    pub bias: f64,
    /// Lengths of roll at the start of the active profile and at the tip, m.
    pub rolls: [f64; 2],
}

impl ProfileSlope {
    /// Removal and its derivative at the length of roll `roll`, m; `t` from -1 at the z = 0 end to +1 at the other.
    #[inline(always)]
    pub fn piece(&self, roll: f64, t: f64) -> ProfilePiece {
        let amount = self.amount + 0.5 * self.bias * t;
        let [a, b] = self.rolls;
        let removal = 0.5 * amount * along(self.rolls, roll);
        ProfilePiece::parabola([removal, amount / (b - a), 0.0])
    }
}

/// -1 at the first of both lengths of roll, +1 at the second.
fn along([a, b]: [f64; 2], roll: f64) -> f64 {
    (2.0 * roll - a - b) / (b - a)
}

/// End relief at one end of the face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EndRelief {
    /// Removal at the face end, m.
    pub amount: f64,
    /// How far it reaches into the face, m.
    pub length: f64,
    /// Growth towards the end.
    pub shape: ReliefShape,
}

impl EndRelief {
    /// Removal at the distance `from_end` from the end of the face, m.
    pub fn removal(&self, from_end: f64) -> f64 {
        self.amount * self.shape.evaluate(1.0 - from_end / self.length)[0]
    }
}

#[cfg(test)]
mod tests {
    use super::ReliefShape::{Arc, Linear, Parabolic};
    use super::*;
    use crate::gear::{GearKind, samples};
    use approx::assert_abs_diff_eq;

    fn gear() -> Gear {
        Gear {
            face_width: 24e-3,
            ..samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
        }
    }

    fn relief(start_roll: f64, end_roll: f64, shape: ReliefShape) -> ProfileRelief {
        ProfileRelief {
            amount: 8e-6,
            start_roll,
            end_roll,
            shape,
        }
    }

    /// One of everything.
    fn all() -> Microgeometry {
        let [rolls, zs] = [[6e-3, 8e-3, 11e-3, 14e-3], [0.0, 7e-3, 15e-3, 24e-3]];
        let removal =
            rolls.map(|r: f64| zs.map(|z| 1e-4 * r * r + 2e-5 * z - 1e-3 * r * z).to_vec());
        Microgeometry {
            tip_relief: Some(relief(10e-3, 14e-3, Parabolic)),
            root_relief: Some(relief(9e-3, 6e-3, Linear)),
            profile_crowning: Some(ProfileCrowning {
                amount: 3e-6,
                rolls: [6e-3, 14e-3],
            }),
            profile_slope: Some(ProfileSlope {
                amount: 4e-6,
                bias: -2e-6,
                rolls: [6e-3, 14e-3],
            }),
            lead_crowning: 5e-6,
            lead_slope: 12e-6,
            end_relief: [2e-3, 3e-3].map(|length| {
                Some(EndRelief {
                    amount: 10e-6,
                    length,
                    shape: Linear,
                })
            }),
            topography: Topography::new(rolls.to_vec(), zs.to_vec(), removal.to_vec()).ok(),
        }
    }

    #[test]
    fn a_piece_has_the_derivatives_of_the_removal_and_is_it_between_its_ends() {
        let (all, gear) = (all(), gear());
        let smooth = Microgeometry {
            topography: None,
            ..all.clone()
        };
        for roll in [6.5e-3, 7.7e-3, 9.5e-3, 12.1e-3, 13.9e-3] {
            for z in [0.0, 1e-3, 12e-3, 23.3e-3] {
                let d = 1e-8;
                let difference =
                    |of: &dyn Fn(f64) -> f64| (of(roll + d) - of(roll - d)) / (2.0 * d);
                let piece = all.profile(&gear, roll, z);
                let slope = difference(&|roll| all.removal(&gear, roll, z));
                assert_abs_diff_eq!(piece.slope, slope, epsilon = 1e-9);
                let curvature = difference(&|roll| all.profile(&gear, roll, z).slope);
                assert_abs_diff_eq!(piece.curvature, curvature, epsilon = 1e-6);
                let piece = smooth.profile(&gear, roll, z);
                let [low, high] = piece.range;
                assert!(low <= roll && roll <= high);
                for other in [low.max(6e-3), high.min(14e-3)] {
                    let by = other - roll;
                    let profile = piece.removal + by * (piece.slope + 0.5 * by * piece.curvature);
                    let removal = profile + smooth.lead(&gear, z);
                    let expected = smooth.removal(&gear, other, z);
                    assert_abs_diff_eq!(removal, expected, epsilon = 1e-19);
                }
            }
        }
    }

    #[test]
    fn every_modification_takes_off_what_its_definition_says() {
        let alone = |change: fn(&mut Microgeometry, Microgeometry)| {
            let mut m = Microgeometry::default();
            change(&mut m, all());
            m
        };
        let lead_crowning = alone(|m, all| m.lead_crowning = all.lead_crowning);
        let crowning = alone(|m, all| m.profile_crowning = all.profile_crowning);
        let lead_slope = alone(|m, all| m.lead_slope = all.lead_slope);
        let slope = alone(|m, all| m.profile_slope = all.profile_slope);
        let ends = alone(|m, all| m.end_relief = all.end_relief);
        let relieved = |end_roll: f64, shape: ReliefShape| Microgeometry {
            tip_relief: Some(relief(10e-3, end_roll, shape)),
            ..Microgeometry::default()
        };
        // Whether it looks the same from both ends of the face; length of roll and z in mm, removal in um.
        for (m, is_symmetric, points) in [
            // A parabola has a quarter of its end value half way out.
            (lead_crowning, true, "9 12 0, 9 0 5, 9 24 5, 9 6 1.25"),
            (crowning, true, "10 12 0, 6 0 3, 14 24 3, 12 9 0.75"),
            // 0.5 mrad that opens the side of larger z.
            (lead_slope, false, "9 0 -6, 9 5 -3.5, 9 12 0, 9 24 6"),
            // From -2 to 2 um at mid-face, from -1.5 to 1.5 and -2.5 to 2.5 at its ends: the mean of the flank stays.
            (slope, false, "6 12 -2, 14 12 2, 14 24 1.5, 6 0 -2.5"),
            (ends, false, "9 0 10, 9 1 5, 9 22.5 5, 9 20.9 0"),
            // Of an external gear's tip, and of a root or the tip of a ring.
            (
                relieved(14e-3, Linear),
                true,
                "6 9 0, 10 0 0, 12 0 4, 14 24 8",
            ),
            (relieved(14e-3, Parabolic), true, "10 0 0, 12 0 2, 14 24 8"),
            (
                relieved(6e-3, Linear),
                true,
                "14 9 0, 10 0 0, 8 0 4, 6 24 8",
            ),
            (relieved(6e-3, Parabolic), true, "10 0 0, 8 0 2, 6 24 8"),
        ] {
            for point in points.split(", ") {
                let mut numbers = point.split(' ').map(|text| text.parse().unwrap());
                let [roll, z, um] = [(); 3].map(|()| numbers.next().unwrap());
                let removal = m.removal(&gear(), 1e-3 * roll, 1e-3 * z);
                assert_abs_diff_eq!(1e6 * removal, um, epsilon = 1e-12);
            }
            assert_eq!(m.is_symmetric(), is_symmetric, "{m:?}");
        }
    }

    #[test]
    fn no_place_of_the_flank_exceeds_the_bound() {
        let (m, gear) = (all(), gear());
        let bound = m.largest_removal(&gear, [14e-3, 6e-3]);
        let points = (0..=40).flat_map(|i| (0..=40).map(move |j| [i, j].map(f64::from)));
        let removals = points.map(|[i, j]| m.removal(&gear, 6e-3 + 0.2e-3 * i, 0.6e-3 * j));
        let largest = removals.fold(f64::NEG_INFINITY, f64::max);
        let range = largest..2.0 * largest;
        assert!(range.contains(&bound), "{largest} {bound}");
    }

    #[test]
    fn an_arc_is_a_circle_that_leaves_the_flank_as_a_tangent() {
        // Steep for a modification: 200 um over 4 mm, radius from amount and length.
        let (amount, length) = (200e-6f64, 4e-3f64);
        let radius = (length * length + amount * amount) / (2.0 * amount);
        let arc = ProfileRelief {
            amount,
            ..relief(10e-3, 14e-3, Arc)
        };
        for x in [1e-3, 2e-3, 3e-3] {
            let circle = radius - (radius * radius - x * x).sqrt();
            let bound = amount * (amount / length).powi(2);
            assert_abs_diff_eq!(arc.piece(10e-3 + x).removal, circle, epsilon = bound);
        }
    }
}
