//! What is taken off the involute flanks of one gear.
//!
//! Every amount is in metres along the flank normal, material removed positive. Profile modifications run over
//! the length of roll (`roll`, [`Gear::roll_length`]), lead modifications over the gear's own face, bias and
//! topography over both. [`Microgeometry::removal`] is their one home. Names and signs of drawings: ISO 21771-1,
//! ISO 1328-1; where a sign differs from theirs, the field says so.

use super::modification::{EndRelief, ProfileCrowning, ProfilePiece, ProfileRelief, ProfileSlope};
use super::topography::Topography;
use super::{Flank, Gear};
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
    /// Profile slope (C_Ha), and its change along the face: bias.
    pub profile_slope: Option<ProfileSlope>,
    /// Lead crowning: removal at each end of the face, m, parabolic, zero at mid-face.
    pub lead_crowning: f64,
    /// Lead slope (C_Hb): removal at the z = face width end minus that at the z = 0 end, m; zero at
    /// mid-face, so that it shifts no transmission error that is referred to mid-face. The same on both flanks of a
    /// tooth it tapers the tooth, of opposite signs it changes the helix angle.
    pub lead_slope: f64,
    /// End reliefs at the z = 0 end and at the z = face width end.
    pub end_relief: [Option<EndRelief>; 2],
    /// Measured or designed flank, in addition to all others.
    pub topography: Option<Topography>,
}

impl Microgeometry {
    /// Removal along the flank normal, m, at the length of roll `roll` (transverse, m) and at `z`, m,
    /// from the z = 0 face of this gear towards its other face. This is the gear as it stands: who
    /// mirrors a gear along its axis must mirror `z` back first.
    pub fn removal(&self, gear: &Gear, roll: f64, z: f64) -> f64 {
        self.profile(gear, roll, z).removal + self.lead(gear, z)
    }

    /// Tip relief and root relief, as far as there are.
    pub fn reliefs(&self) -> impl Iterator<Item = &ProfileRelief> {
        self.tip_relief.iter().chain(&self.root_relief)
    }

    /// Slope and curvature over the length of roll without the reliefs, m/m and m/m²; the curvature of a topography is its
    /// second difference over +-`by` (m of roll).
    pub fn smooth_slopes(&self, gear: &Gear, roll: f64, z: f64, by: f64) -> [f64; 2] {
        let slope = self
            .add_smooth(ProfilePiece::default(), gear, roll, z)
            .slope;
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
        let none = ProfilePiece::default();
        let reliefs = self.reliefs().fold(none, |sum, r| sum.and(r.piece(roll)));
        self.add_smooth(reliefs, gear, roll, z)
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
        let ends = [z, gear.face_width - z];
        let reliefs = self.end_relief.iter().zip(ends);
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

    /// Bound of [`Microgeometry::removal`] over the lengths of roll `rolls` (the ends of the flank, either
    /// first) and the whole face, m.
    pub fn largest_removal(&self, gear: &Gear, rolls: [f64; 2]) -> f64 {
        let mut smooth = self.clone();
        let topography = smooth.topography.take();
        // Without a topography removals are convex in both directions: largest in a corner.
        let ends = [0.0, gear.face_width];
        let removal = |roll: f64| ends.map(|z| smooth.removal(gear, roll, z));
        let largest = rolls.into_iter().flat_map(removal).fold(0.0, f64::max);
        largest + topography.map_or(0.0, |f| f.largest_removal())
    }

    /// Whether the flank looks the same from both ends of the face. Only then is the coast flank, seen
    /// with the gear turned end for end, the drive flank again.
    pub fn is_symmetric(&self) -> bool {
        self.lead_slope == 0.0
            && self.end_relief[0] == self.end_relief[1]
            && !self.varies_along_face()
    }
}

/// -1 at the z = 0 face, +1 at the other.
fn along_face(gear: &Gear, z: f64) -> f64 {
    2.0 * z / gear.face_width - 1.0
}

/// Modifications of both flanks of both gears.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PairMicrogeometry {
    /// Gear 1 and gear 2, the flanks that touch when gear 1 turns in its + sense and drives. On gear 1 and on
    /// gear 2 of an external pair they face +theta, on gear 2 of an internal pair -theta.
    pub drive: [Microgeometry; 2],
    /// The other flanks.
    pub coast: [Microgeometry; 2],
}

impl PairMicrogeometry {
    /// Modifications of gear 1 and gear 2 on the loaded flanks.
    pub fn flank(&self, flank: Flank) -> &[Microgeometry; 2] {
        match flank {
            Flank::Drive => &self.drive,
            Flank::Coast => &self.coast,
        }
    }

    /// Whether the coast flanks are the drive flanks seen from the other end of the faces.
    pub fn coast_mirrors_drive(&self) -> bool {
        self.drive == self.coast && self.drive.iter().all(Microgeometry::is_symmetric)
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples;
    use super::super::{GearKind, ReliefShape};
    use super::*;
    use approx::assert_abs_diff_eq;

    fn gear() -> Gear {
        Gear {
            face_width: 24e-3,
            ..samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
        }
    }

    /// One of everything.
    fn all() -> Microgeometry {
        let relief = |start_roll, end_roll, shape| ProfileRelief {
            amount: 8e-6,
            start_roll,
            end_roll,
            shape,
        };
        let [rolls, zs] = [[6e-3, 8e-3, 11e-3, 14e-3], [0.0, 7e-3, 15e-3, 24e-3]];
        let removal =
            rolls.map(|r: f64| zs.map(|z| 1e-4 * r * r + 2e-5 * z - 1e-3 * r * z).to_vec());
        Microgeometry {
            tip_relief: Some(relief(10e-3, 14e-3, ReliefShape::Parabolic)),
            root_relief: Some(relief(9e-3, 6e-3, ReliefShape::Linear)),
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
                    shape: ReliefShape::Linear,
                })
            }),
            topography: Topography::new(rolls.to_vec(), zs.to_vec(), removal.to_vec()).ok(),
        }
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_removal_over_the_length_of_roll() {
        let (m, gear) = (all(), gear());
        for roll in [6.5e-3, 7.7e-3, 9.5e-3, 12.1e-3, 13.9e-3] {
            for z in [0.0, 1e-3, 12e-3, 23.3e-3] {
                let d = 1e-8;
                let at = |roll| m.removal(&gear, roll, z);
                let numeric = (at(roll + d) - at(roll - d)) / (2.0 * d);
                let piece = m.profile(&gear, roll, z);
                assert_abs_diff_eq!(piece.slope, numeric, epsilon = 1e-9);
                let at = |roll| m.profile(&gear, roll, z).slope;
                let numeric = (at(roll + d) - at(roll - d)) / (2.0 * d);
                assert_abs_diff_eq!(piece.curvature, numeric, epsilon = 1e-6);
            }
        }
    }

    #[test]
    fn a_piece_is_the_removal_between_its_ends() {
        let (mut smooth, gear) = (all(), gear());
        smooth.topography = None;
        for roll in [6.5e-3, 7.7e-3, 9.5e-3, 12.1e-3, 13.9e-3] {
            for z in [0.0, 1e-3, 12e-3, 23.3e-3] {
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
        // Whether it looks the same from both ends of the face; length of roll and z in mm, removal in um, one after another.
        let cases: [(_, _, &[f64]); 5] = [
            // A parabola has a quarter of its end value half way out.
            (
                alone(|m, all| m.lead_crowning = all.lead_crowning),
                true,
                &[
                    9.0, 12.0, 0.0, 9.0, 0.0, 5.0, 9.0, 24.0, 5.0, 9.0, 6.0, 1.25,
                ],
            ),
            (
                alone(|m, all| m.profile_crowning = all.profile_crowning),
                true,
                &[
                    10.0, 12.0, 0.0, 6.0, 0.0, 3.0, 14.0, 24.0, 3.0, 12.0, 9.0, 0.75,
                ],
            ),
            // 0.5 mrad that opens the side of larger z.
            (
                alone(|m, all| m.lead_slope = all.lead_slope),
                false,
                &[
                    9.0, 0.0, -6.0, 9.0, 5.0, -3.5, 9.0, 12.0, 0.0, 9.0, 24.0, 6.0,
                ],
            ),
            // From -2 to 2 um at mid-face, from -1.5 to 1.5 and -2.5 to 2.5 at its ends: the mean of the flank stays.
            (
                alone(|m, all| m.profile_slope = all.profile_slope),
                false,
                &[
                    6.0, 12.0, -2.0, 14.0, 12.0, 2.0, 14.0, 24.0, 1.5, 6.0, 0.0, -2.5,
                ],
            ),
            (
                alone(|m, all| m.end_relief = all.end_relief),
                false,
                &[
                    9.0, 0.0, 10.0, 9.0, 1.0, 5.0, 9.0, 22.5, 5.0, 9.0, 20.9, 0.0,
                ],
            ),
        ];
        for (m, is_symmetric, points) in cases {
            for point in points.chunks(3) {
                let removal = m.removal(&gear(), 1e-3 * point[0], 1e-3 * point[1]);
                assert_abs_diff_eq!(1e6 * removal, point[2], epsilon = 1e-12);
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
        assert!(
            largest <= bound && bound < 2.0 * largest,
            "{largest} {bound}"
        );
    }
}
