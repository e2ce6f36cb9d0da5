//! A flank given point by point: removal over the length of roll and the face.

use serde::{Deserialize, Serialize};

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
    pub(super) fn parabola([removal, slope, curvature]: [f64; 3]) -> ProfilePiece {
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

/// A grid that is no topography.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "fewer than 3 lines along an axis of the grid, lines that do not ascend, a value that is missing, or a number that is \
     not finite"
)]
pub struct TopographyError;

/// How far a cubic may rise above the highest of its nodes, over the range of all of them.
const OVERSHOOT: f64 = 0.25;

/// Equal parts of every cell at whose ends [`Topography::extremes`] looks.
const PARTS: usize = 5;

/// Values and derivatives at a node of the grid: f, df/d roll, df/dz, d²f/d roll dz.
type Node = [f64; 4];

/// Removal on a full grid of lengths of roll and places along the face, between the nodes bicubic: the value and both
/// first derivatives are continuous, parabolas come out exact. Beyond the grid it goes on along its tangents.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored")]
pub struct Topography {
    rolls: Vec<f64>,
    zs: Vec<f64>,
    /// Row by row over z.
    nodes: Vec<Node>,
    largest: f64,
    /// Bounds of the slope over the length of roll within the range of z, m/m, and of its slope over z at its ends, 1/m.
    #[serde(skip)]
    steepest: [f64; 2],
}

/// A [`Topography`] as it is read from the file of a unit.
#[derive(Deserialize)]
struct Stored {
    rolls: Vec<f64>,
    zs: Vec<f64>,
    nodes: Vec<Node>,
    largest: f64,
}

impl TryFrom<Stored> for Topography {
    type Error = TopographyError;

    fn try_from(stored: Stored) -> Result<Topography, TopographyError> {
        let (rolls, zs, nodes) = (stored.rolls, stored.zs, stored.nodes);
        if !is_axis(&rolls) || !is_axis(&zs) || nodes.len() != rolls.len() * zs.len() {
            return Err(TopographyError);
        }
        Ok(Topography {
            steepest: steepest(&rolls, &zs, &nodes),
            rolls,
            zs,
            nodes,
            largest: stored.largest,
        })
    }
}

fn is_axis(x: &[f64]) -> bool {
    x.len() >= 3 && x.is_sorted_by(|a, b| a < b) && x.iter().all(|v| v.is_finite())
}

impl Topography {
    /// `removal[i][j]` (m, material removed positive) at the length of roll `rolls[i]` (m) and at `zs[j]` (m from the
    /// z = 0 face), both ascending.
    ///
    /// # Errors
    /// [`TopographyError`] for a grid of fewer than 3 x 3 nodes, not ascending or not finite.
    pub fn new(
        rolls: Vec<f64>,
        zs: Vec<f64>,
        removal: Vec<Vec<f64>>,
    ) -> Result<Topography, TopographyError> {
        let is_whole = |row: &Vec<f64>| row.len() == zs.len() && row.iter().all(|v| v.is_finite());
        let is_grid = removal.len() == rolls.len() && removal.iter().all(is_whole);
        if !(is_axis(&rolls) && is_axis(&zs) && is_grid) {
            return Err(TopographyError);
        }
        let column =
            |rows: &[Vec<f64>], j: usize| -> Vec<f64> { rows.iter().map(|row| row[j]).collect() };
        let by_z: Vec<Vec<f64>> = removal.iter().map(|row| slopes(&zs, row)).collect();
        let mut nodes = vec![[0.0; 4]; rolls.len() * zs.len()];
        for j in 0..zs.len() {
            let by_roll = slopes(&rolls, &column(&removal, j));
            let mixed = slopes(&rolls, &column(&by_z, j));
            for i in 0..rolls.len() {
                nodes[i * zs.len() + j] = [removal[i][j], by_roll[i], by_z[i][j], mixed[i]];
            }
        }
        let all = || removal.iter().flatten().copied();
        let (least, most) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
        Topography::try_from(Stored {
            rolls,
            zs,
            nodes,
            largest: most + OVERSHOOT * (most - least),
        })
    }

    /// First and last length of roll, m, and the same of z.
    pub fn range(&self) -> [[f64; 2]; 2] {
        [&self.rolls, &self.zs].map(|x| [x[0], x[x.len() - 1]])
    }

    /// Number of lines over the length of roll and over z.
    pub fn size(&self) -> [usize; 2] {
        [self.rolls.len(), self.zs.len()]
    }

    /// Bound of the removal within the grid, m, at least 0.
    pub fn largest_removal(&self) -> f64 {
        self.largest
    }

    /// The least and the largest removal between the lengths of roll `rolls` and the places `zs` (m, each ascending), and
    /// where they are: length of roll, z and removal, m. Between close lines and beyond the grid they can rise far above the
    /// nodes. Both are the first NaN if there is one.
    pub fn extremes(&self, rolls: [f64; 2], zs: [f64; 2]) -> [[f64; 3]; 2] {
        let zs = places(&self.zs, zs);
        let [mut least, mut largest] = [f64::INFINITY, f64::NEG_INFINITY].map(|f| [0.0, 0.0, f]);
        for roll in places(&self.rolls, rolls) {
            for &z in &zs {
                let here = [roll, z, self.removal(roll, z)];
                if here[2].is_nan() {
                    return [here; 2];
                }
                if here[2] < least[2] {
                    least = here;
                }
                if here[2] > largest[2] {
                    largest = here;
                }
            }
        }
        [least, largest]
    }

    /// Bound of the slope over the length of roll at `z` (m), m/m, for every length of roll.
    pub fn steepness(&self, z: f64) -> f64 {
        let [_, [low, high]] = self.range();
        let beyond = (low - z).max(z - high).max(0.0);
        self.steepest[0] + beyond * self.steepest[1]
    }

    /// Removal at the length of roll `roll` and at `z`, m.
    pub fn removal(&self, roll: f64, z: f64) -> f64 {
        self.piece(roll, z).removal
    }

    /// Removal about the length of roll `roll` at `z`, m: a cubic from line to line of the grid, beyond it a straight line.
    pub fn piece(&self, roll: f64, z: f64) -> ProfilePiece {
        let (j, over_z) = weights(&self.zs, z);
        // Removal and its slope on line i.
        let line = |i: usize| {
            let mut sum = [0.0; 2];
            for (b, [value, slope]) in over_z.iter().enumerate() {
                let [f, by_roll, by_z, mixed] = self.nodes[i * self.zs.len() + j + b];
                sum[0] += f * value + by_z * slope;
                sum[1] += by_roll * value + mixed * slope;
            }
            sum
        };
        let last = self.rolls.len() - 1;
        let straight = |i: usize, range: [f64; 2]| {
            let [removal, slope] = line(i);
            ProfilePiece {
                removal: removal + slope * (roll - self.rolls[i]),
                slope,
                range,
                ..ProfilePiece::default()
            }
        };
        if roll < self.rolls[0] {
            return straight(0, [f64::NEG_INFINITY, self.rolls[0]]);
        }
        if roll >= self.rolls[last] {
            return straight(last, [self.rolls[last], f64::INFINITY]);
        }
        let i = cell(&self.rolls, roll);
        let range = [self.rolls[i], self.rolls[i + 1]];
        let [[f, slope], [f_end, slope_end]] = [line(i), line(i + 1)];
        let (h, x) = (range[1] - range[0], roll - range[0]);
        let chord = (f_end - f) / h;
        // f + x (slope + x (bend + x twist)).
        let bend = (3.0 * chord - 2.0 * slope - slope_end) / h;
        let twist = (slope + slope_end - 2.0 * chord) / (h * h);
        ProfilePiece {
            removal: f + x * (slope + x * (bend + x * twist)),
            slope: slope + x * (2.0 * bend + 3.0 * x * twist),
            curvature: 2.0 * bend + 6.0 * x * twist,
            curvature_slope: 6.0 * twist,
            range,
        }
    }
}

/// Bounds of the slope over the length of roll and, at both ends of `zs`, of its slope over z: a polynomial lies between the
/// least and the largest of its Bernstein coefficients.
fn steepest(rolls: &[f64], zs: &[f64], nodes: &[Node]) -> [f64; 2] {
    // Of the slope of the cubic between values f and slopes m at both ends of a cell of length h.
    let largest = |h: f64, f: [f64; 2], m: [f64; 2]| {
        let middle = 3.0 * (f[1] - f[0]) / h - m[0] - m[1];
        m[0].abs().max(m[1].abs()).max(middle.abs())
    };
    let at = |i: usize, j: usize| nodes[i * zs.len() + j];
    let mut bounds = [0.0f64; 2];
    for i in 0..rolls.len() - 1 {
        let h = rolls[i + 1] - rolls[i];
        for j in 0..zs.len() - 1 {
            let third = (zs[j + 1] - zs[j]) / 3.0;
            for (node, by) in [(j, 0.0), (j, third), (j + 1, -third), (j + 1, 0.0)] {
                let ends = [at(i, node), at(i + 1, node)];
                let f = ends.map(|[f, _, by_z, _]| f + by * by_z);
                let m = ends.map(|[_, by_roll, _, mixed]| by_roll + by * mixed);
                bounds[0] = bounds[0].max(largest(h, f, m));
            }
        }
        for j in [0, zs.len() - 1] {
            let ends = [at(i, j), at(i + 1, j)];
            let f = ends.map(|[_, _, by_z, _]| by_z);
            bounds[1] = bounds[1].max(largest(h, f, ends.map(|[.., mixed]| mixed)));
        }
    }
    bounds
}

/// Ends of the [`PARTS`] between `low` and `high` and the lines between them.
fn places(lines: &[f64], [low, high]: [f64; 2]) -> Vec<f64> {
    let inside = lines.iter().copied().filter(|&x| low < x && x < high);
    let ends: Vec<f64> = std::iter::once(low).chain(inside).chain([high]).collect();
    let part = |w: &[f64], k: usize| w[0] + (w[1] - w[0]) * k as f64 / PARTS as f64;
    let parts = |w| (0..PARTS).map(move |k| part(w, k));
    ends.windows(2).flat_map(parts).chain([high]).collect()
}

/// The cell of `nodes` in which `x` lies, the first or the last one outside.
fn cell(nodes: &[f64], x: f64) -> usize {
    let above = nodes.partition_point(|&node| node <= x);
    above.clamp(1, nodes.len() - 1) - 1
}

/// The cell of `x`, and of both its nodes the weights of value and slope in the cubic Hermite interpolation; outside on the
/// tangent at the end.
fn weights(nodes: &[f64], x: f64) -> (usize, [[f64; 2]; 2]) {
    let i = cell(nodes, x);
    let h = nodes[i + 1] - nodes[i];
    let inside = x.clamp(nodes[i], nodes[i + 1]);
    let beyond = x - inside;
    let t = (inside - nodes[i]) / h;
    let s = 1.0 - t;
    let node = |t: f64, s: f64, sign: f64| {
        [
            s * s * (1.0 + 2.0 * t) - sign * 6.0 * s * t / h * beyond,
            sign * h * t * s * s + s * (s - 2.0 * t) * beyond,
        ]
    };
    (i, [node(t, s, 1.0), node(s, t, -1.0)])
}

/// Slopes at `x` of the parabolas through each value and its neighbours.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let slope = |i: usize| {
        let c = i.clamp(1, n - 2);
        let (h0, h1) = (x[c] - x[c - 1], x[c + 1] - x[c]);
        let (s0, s1) = ((y[c] - y[c - 1]) / h0, (y[c + 1] - y[c]) / h1);
        let bend = (s1 - s0) / (h0 + h1);
        s0 + bend * (2.0 * x[i] - x[c - 1] - x[c])
    };
    (0..n).map(slope).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const ROLLS: [f64; 5] = [6e-3, 7e-3, 9e-3, 12e-3, 14e-3];
    const ZS: [f64; 4] = [0.0, 5e-3, 15e-3, 24e-3];

    #[test]
    fn what_is_read_is_checked_as_what_is_made() {
        let text = serde_json::to_string(&sampled(|roll, z| roll * z)).unwrap();
        let read = |text: &str| serde_json::from_str::<Topography>(text);
        assert_eq!(read(&text).unwrap(), sampled(|roll, z| roll * z));
        for spoilt in [
            text.replacen("0.007", "0.017", 1),
            text.replacen("0.024]", "0.024,0.03]", 1),
        ] {
            assert_ne!(spoilt, text);
            let refused = read(&spoilt).unwrap_err().to_string();
            assert!(refused.contains("do not ascend"), "{refused}");
        }
    }

    fn sampled(f: impl Fn(f64, f64) -> f64) -> Topography {
        let rows = ROLLS.map(|roll| ZS.map(|z| f(roll, z)).to_vec());
        Topography::new(ROLLS.to_vec(), ZS.to_vec(), rows.to_vec()).unwrap()
    }

    #[test]
    fn biquadratic_flanks_come_out_exact_with_their_slope() {
        // Crowning in both directions and a twist.
        let f = |r: f64, z: f64| {
            0.3 * (r - 9e-3).powi(2) + 0.02 * (z - 11e-3).powi(2) * (1.0 + 40.0 * r)
        };
        let by_roll = |r: f64, z: f64| 0.6 * (r - 9e-3) + 0.8 * (z - 11e-3).powi(2);
        let flank = sampled(f);
        for i in 0..=20 {
            for j in 0..=20 {
                let (r, z) = (6e-3 + 0.4e-3 * f64::from(i), 1.2e-3 * f64::from(j));
                assert_abs_diff_eq!(flank.removal(r, z), f(r, z), epsilon = 1e-18);
                assert_abs_diff_eq!(flank.piece(r, z).slope, by_roll(r, z), epsilon = 1e-14);
            }
        }
    }

    #[test]
    fn value_and_slope_are_continuous_across_the_lines_of_the_grid_and_go_on_straight_beyond() {
        // Anything but smooth.
        let flank = sampled(|r, z| 1e-6 * ((9e3 * r).sin() + (7e2 * z).cos()).round());
        for &roll in &ROLLS {
            for z in [0.0, 3e-3, 5e-3, 20e-3] {
                let [low, high] = [-1e-12, 1e-12].map(|d| flank.piece(roll + d, z));
                assert_abs_diff_eq!(low.removal, high.removal, epsilon = 1e-13);
                assert_abs_diff_eq!(low.slope, high.slope, epsilon = 1e-9);
            }
        }
        for z in [-1e-3, 12e-3, 30e-3] {
            let [end, beyond] = [14e-3, 17e-3].map(|roll| flank.piece(roll, z));
            let straight = end.removal + 3e-3 * end.slope;
            assert_abs_diff_eq!(beyond.removal, straight, epsilon = 1e-18);
        }
    }

    #[test]
    fn no_slope_exceeds_its_bound_and_the_derivatives_are_those_of_the_slope() {
        let flank = sampled(|r, z| 1e-6 * ((9e3 * r).sin() + (7e2 * z).cos()).round());
        for z in [-2e-3, 0.0, 3e-3, 11e-3, 24e-3, 27e-3] {
            let bound = flank.steepness(z);
            let mut largest = 0.0f64;
            for k in 0..=200 {
                let roll = 5.5e-3 + 0.045e-3 * f64::from(k);
                let [low, here, high] = [-1e-7, 0.0, 1e-7].map(|d| flank.piece(roll + d, z));
                largest = largest.max(here.slope.abs());
                if here.range[0] < roll - 1e-7 && roll + 1e-7 < here.range[1] {
                    let numeric = [high.slope - low.slope, high.curvature - low.curvature];
                    let [curvature, slope] = numeric.map(|change| change / 2e-7);
                    assert_abs_diff_eq!(here.curvature, curvature, epsilon = 1e-6);
                    assert_abs_diff_eq!(here.curvature_slope, slope, epsilon = 1e-3);
                }
            }
            assert!(largest <= bound && bound < 3.0 * largest, "{z}");
        }
    }

    #[test]
    fn the_extremes_are_found_between_lines_and_beyond_them() {
        let flank = sampled(|r, _| if r == 9e-3 { -4e-6 } else { 0.0 });
        let [[roll, _, removal], _] = flank.extremes([6e-3, 14e-3], [0.0, 24e-3]);
        assert_eq!(roll, 9e-3);
        assert_abs_diff_eq!(removal, -4e-6, epsilon = 1e-15);
        let slanted = sampled(|r, z| 1e-3 * (r - 6e-3) + 1e-4 * z);
        let [least, [roll, z, removal]] = slanted.extremes([5e-3, 20e-3], [-1e-3, 30e-3]);
        assert_eq!([roll, z], [20e-3, 30e-3]);
        assert_abs_diff_eq!(removal, 17e-6, epsilon = 1e-15);
        assert_eq!(least[..2], [5e-3, -1e-3]);
        assert_abs_diff_eq!(least[2], -1.1e-6, epsilon = 1e-15);
        // A step between two lines a micrometre apart goes on with its slope.
        let rows = [0.0, 20e-6, 0.0, 0.0, 0.0].map(|um| vec![um; 4]);
        let rolls = vec![3e-3, 3.001e-3, 6e-3, 9e-3, 13e-3];
        let step = Topography::new(rolls, ZS.to_vec(), rows.to_vec()).unwrap();
        let [_, [roll, _, removal]] = step.extremes([3e-3, 13e-3], [0.0, 24e-3]);
        let is_beyond = 3.001e-3 < roll && roll < 6e-3;
        assert!(is_beyond && removal > 1e-3, "{roll} {removal}");
    }

    #[test]
    fn a_grid_that_is_none_is_refused() {
        let rows = vec![vec![0.0; 4]; 5];
        let mut bad = rows.clone();
        bad[2][1] = f64::NAN;
        for (rolls, rows) in [
            (&ROLLS[..2], rows[..2].to_vec()),
            (&[6.0, 5.0, 7.0, 8.0, 9.0], rows.clone()),
            (&ROLLS, rows[..4].to_vec()),
            (&ROLLS, bad),
        ] {
            Topography::new(rolls.to_vec(), ZS.to_vec(), rows).unwrap_err();
        }
    }
}
