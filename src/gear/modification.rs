//! The single modifications a flank may have.

use serde::{Deserialize, Serialize};

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

/// What is taken off a flank about one length of roll, at one place along the face: a parabola, with a topography a cubic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePiece {
    /// Removal there, m.
    pub removal: f64,
    /// Its slope over the length of roll, m/m.
    pub slope: f64,
    /// The slope of that, m/m².
    pub curvature: f64,
    /// The slope of that, m/m³: zero without a topography.
    pub curvature_slope: f64,
    /// Lengths of roll between which all this is one polynomial, m.
    pub range: [f64; 2],
}

impl Default for ProfilePiece {
    /// The unmodified flank.
    fn default() -> Self {
        ProfilePiece::parabola([0.0; 3])
    }
}

impl ProfilePiece {
    /// One of this removal, slope and curvature for all lengths of roll.
    #[inline(always)]
    fn parabola([removal, slope, curvature]: [f64; 3]) -> ProfilePiece {
        ProfilePiece {
            removal,
            slope,
            curvature,
            curvature_slope: 0.0,
            range: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Both together.
    #[inline(always)]
    pub(super) fn and(self, other: ProfilePiece) -> ProfilePiece {
        ProfilePiece {
            removal: self.removal + other.removal,
            slope: self.slope + other.slope,
            curvature: self.curvature + other.curvature,
            curvature_slope: self.curvature_slope + other.curvature_slope,
            range: [
                self.range[0].max(other.range[0]),
                self.range[1].min(other.range[1]),
            ],
        }
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
    /// Removal at the tip minus that at the start of the active profile, at mid-face, m: minus the C_Ha of
    /// ISO 1328-1, which counts material that grows towards the tip.
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
        ProfilePiece::parabola([
            0.5 * amount * along(self.rolls, roll),
            amount / (b - a),
            0.0,
        ])
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
    use super::*;
    use approx::assert_abs_diff_eq;

    fn relief(start_roll: f64, end_roll: f64, shape: ReliefShape) -> ProfileRelief {
        ProfileRelief {
            amount: 8e-6,
            start_roll,
            end_roll,
            shape,
        }
    }

    #[test]
    fn relief_is_zero_up_to_its_start_half_or_a_quarter_half_way_and_whole_at_its_end() {
        use ReliefShape::{Arc, Linear, Parabolic};
        for (shape, half_way) in [(Linear, 4e-6), (Parabolic, 2e-6), (Arc, 2e-6)] {
            // Tip relief of an external gear, then root relief (or the tip of a ring).
            for end in [14e-3, 6e-3] {
                let r = relief(10e-3, end, shape);
                let removals =
                    [20e-3 - end, 10e-3, 5e-3 + 0.5 * end, end].map(|x| r.piece(x).removal);
                assert_abs_diff_eq!(
                    removals[..],
                    [0.0, 0.0, half_way, 8e-6][..],
                    epsilon = 1e-18
                );
                assert_eq!(r.piece(20e-3 - end).slope, 0.0);
            }
        }
    }

    #[test]
    fn an_arc_is_a_circle_that_leaves_the_flank_as_a_tangent() {
        // Steep for a modification: 200 um over 4 mm, radius from amount and length.
        let (amount, length) = (200e-6f64, 4e-3f64);
        let radius = (length * length + amount * amount) / (2.0 * amount);
        let arc = ProfileRelief {
            amount,
            ..relief(10e-3, 14e-3, ReliefShape::Arc)
        };
        for x in [1e-3, 2e-3, 3e-3] {
            let circle = radius - (radius * radius - x * x).sqrt();
            let bound = amount * (amount / length).powi(2);
            assert_abs_diff_eq!(arc.piece(10e-3 + x).removal, circle, epsilon = bound);
        }
    }
}
