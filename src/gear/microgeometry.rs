//! What is taken off the involute flanks of one gear.
//!
//! Every amount is in metres along the flank normal, material removed positive, and holds for both
//! flanks of every tooth alike. Profile modifications run over the length of roll
//! (`roll`, [`Gear::roll_length`]), lead modifications over the gear's own face.

use super::Gear;

/// How a relief grows from its start to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReliefShape {
    /// In proportion to the distance from the start.
    Linear,
    /// With the square of the distance from the start, so that the flank has no kink there.
    Parabolic,
}

impl ReliefShape {
    /// Removal over the full amount at the fraction `t` of the way; zero for t <= 0, and continued
    /// beyond t = 1, where the mate's tip may touch when the centre distance shrinks.
    fn fraction(self, t: f64) -> f64 {
        let t = t.max(0.0);
        match self {
            ReliefShape::Linear => t,
            ReliefShape::Parabolic => t * t,
        }
    }
}

/// Tip or root relief, over the length of roll.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// Removal at the length of roll `roll`, m.
    pub fn removal(&self, roll: f64) -> f64 {
        let t = (roll - self.start_roll) / (self.end_roll - self.start_roll);
        self.amount * self.shape.fraction(t)
    }
}

/// Profile crowning (barrelling): parabolic, zero at mid-profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileCrowning {
    /// Removal at both ends of the active profile, m.
    pub amount: f64,
    /// Lengths of roll at these ends, m.
    pub rolls: [f64; 2],
}

impl ProfileCrowning {
    /// Removal at the length of roll `roll`, m.
    pub fn removal(&self, roll: f64) -> f64 {
        let [a, b] = self.rolls;
        let t = (2.0 * roll - a - b) / (b - a);
        self.amount * t * t
    }
}

/// End relief: the same at both ends of the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndRelief {
    /// Removal at the face ends, m.
    pub amount: f64,
    /// How far it reaches into the face, m.
    pub length: f64,
    /// Growth towards the end.
    pub shape: ReliefShape,
}

impl EndRelief {
    /// Removal at `z` on a face 0 ..= `face_width`, m.
    pub fn removal(&self, z: f64, face_width: f64) -> f64 {
        let to_nearer_end = z.min(face_width - z);
        self.amount * self.shape.fraction(1.0 - to_nearer_end / self.length)
    }
}

/// All modifications of one gear, SI. The default is the unmodified involute helicoid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Microgeometry {
    /// Tip relief.
    pub tip_relief: Option<ProfileRelief>,
    /// Root relief.
    pub root_relief: Option<ProfileRelief>,
    /// Profile crowning.
    pub profile_crowning: Option<ProfileCrowning>,
    /// Lead crowning: removal at each end of the face, m, parabolic, zero at mid-face.
    pub lead_crowning: f64,
    /// Lead slope: removal at the z = face width end minus that at the z = 0 end, m; zero at
    /// mid-face, so that it shifts no transmission error that is referred to mid-face. On both flanks
    /// of a tooth alike: > 0 tapers the tooth towards larger z.
    pub lead_slope: f64,
    /// End relief.
    pub end_relief: Option<EndRelief>,
}

impl Microgeometry {
    /// Removal along the flank normal, m, at the length of roll `roll` (transverse, m) and at `z`, m,
    /// from the z = 0 face of this gear towards its other face. This is the gear as it stands: who
    /// mirrors a gear along its axis must mirror `z` back first.
    pub fn removal(&self, gear: &Gear, roll: f64, z: f64) -> f64 {
        self.profile_removal(roll) + self.lead_removal(gear, z)
    }

    /// The part of [`Microgeometry::removal`] that depends on the length of roll alone, m.
    pub fn profile_removal(&self, roll: f64) -> f64 {
        self.tip_relief.map_or(0.0, |r| r.removal(roll))
            + self.root_relief.map_or(0.0, |r| r.removal(roll))
            + self.profile_crowning.map_or(0.0, |c| c.removal(roll))
    }

    /// The part of [`Microgeometry::removal`] that depends on the place along the face alone, m.
    pub fn lead_removal(&self, gear: &Gear, z: f64) -> f64 {
        // -1 at the z = 0 face, +1 at the other.
        let t = 2.0 * z / gear.face_width - 1.0;
        self.lead_crowning * t * t
            + 0.5 * self.lead_slope * t
            + self
                .end_relief
                .map_or(0.0, |r| r.removal(z, gear.face_width))
    }

    /// Whether the flank looks the same from both ends of the face. Only then is the coast flank, seen
    /// with the gear turned end for end, the drive flank again; a lead slope breaks it.
    pub fn is_symmetric(&self) -> bool {
        self.lead_slope == 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::GearKind;
    use super::super::samples;
    use super::*;
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

    #[test]
    fn relief_is_zero_before_its_start_and_whole_at_its_end() {
        for shape in [ReliefShape::Linear, ReliefShape::Parabolic] {
            // Tip relief of an external gear, then root relief (or the tip of a ring).
            for (start, end) in [(10e-3, 14e-3), (10e-3, 6e-3)] {
                let r = relief(start, end, shape);
                assert_eq!(r.removal(start), 0.0);
                assert_eq!(r.removal(2.0 * start - end), 0.0);
                assert_abs_diff_eq!(r.removal(end), 8e-6, epsilon = 1e-20);
            }
        }
    }

    #[test]
    fn half_way_a_linear_relief_has_half_and_a_parabolic_one_a_quarter() {
        let half_way = |shape| relief(10e-3, 14e-3, shape).removal(12e-3);
        assert_abs_diff_eq!(half_way(ReliefShape::Linear), 4e-6, epsilon = 1e-18);
        assert_abs_diff_eq!(half_way(ReliefShape::Parabolic), 2e-6, epsilon = 1e-18);
    }

    #[test]
    fn crowning_takes_its_amount_off_both_ends_and_nothing_at_the_middle() {
        let m = Microgeometry {
            lead_crowning: 5e-6,
            profile_crowning: Some(ProfileCrowning {
                amount: 3e-6,
                rolls: [6e-3, 14e-3],
            }),
            ..Default::default()
        };
        assert_abs_diff_eq!(m.removal(&gear(), 10e-3, 12e-3), 0.0, epsilon = 1e-20);
        for z in [0.0, 24e-3] {
            assert_abs_diff_eq!(m.removal(&gear(), 10e-3, z), 5e-6, epsilon = 1e-18);
            for roll in [6e-3, 14e-3] {
                assert_abs_diff_eq!(m.removal(&gear(), roll, z), 8e-6, epsilon = 1e-18);
            }
        }
        // A parabola has a quarter of its end value half way out.
        assert_abs_diff_eq!(m.lead_removal(&gear(), 6e-3), 1.25e-6, epsilon = 1e-18);
        assert!(m.is_symmetric());
    }

    #[test]
    fn a_lead_slope_is_a_misalignment_about_mid_face() {
        let m = Microgeometry {
            lead_slope: 12e-6,
            ..Default::default()
        };
        for z in [0.0, 5e-3, 12e-3, 24e-3] {
            // 12 um over 24 mm: 0.5 mrad that opens the side of larger z.
            assert_abs_diff_eq!(
                m.removal(&gear(), 9e-3, z),
                0.5e-3 * (z - 12e-3),
                epsilon = 1e-18
            );
        }
        assert!(!m.is_symmetric());
    }

    #[test]
    fn end_relief_touches_only_its_length_at_both_ends() {
        let m = Microgeometry {
            end_relief: Some(EndRelief {
                amount: 10e-6,
                length: 4e-3,
                shape: ReliefShape::Linear,
            }),
            ..Default::default()
        };
        let at = |z| m.removal(&gear(), 9e-3, z);
        assert_abs_diff_eq!(at(0.0), 10e-6, epsilon = 1e-18);
        assert_abs_diff_eq!(at(24e-3), 10e-6, epsilon = 1e-18);
        assert_abs_diff_eq!(at(1e-3), 7.5e-6, epsilon = 1e-18);
        assert_abs_diff_eq!(at(23e-3), 7.5e-6, epsilon = 1e-18);
        assert_eq!(at(4e-3), 0.0);
        assert_eq!(at(12e-3), 0.0);
    }
}
