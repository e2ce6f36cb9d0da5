//! A flank given point by point: removal over the length of roll and the face.

use serde::{Deserialize, Serialize};

/// Why a grid is no topography.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TopographyError {
    /// Fewer than three lines along one of the axes.
    #[error("fewer than 3 lines along an axis of the grid")]
    TooFew,
    /// Lines that do not ascend, values that are missing, or numbers that are none.
    #[error(
        "lines of the grid that do not ascend, a value that is missing, or a number that is not finite"
    )]
    NotAscending,
}

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
        let Stored {
            rolls,
            zs,
            nodes,
            largest,
        } = stored;
        check_axes(&rolls, &zs)?;
        if nodes.len() != rolls.len() * zs.len() {
            return Err(TopographyError::NotAscending);
        }
        Ok(Topography {
            rolls,
            zs,
            nodes,
            largest,
        })
    }
}

fn check_axes(rolls: &[f64], zs: &[f64]) -> Result<(), TopographyError> {
    if rolls.len() < 3 || zs.len() < 3 {
        return Err(TopographyError::TooFew);
    }
    let ascends = |x: &[f64]| x.windows(2).all(|w| w[0] < w[1]) && x.iter().all(|v| v.is_finite());
    if !ascends(rolls) || !ascends(zs) {
        return Err(TopographyError::NotAscending);
    }
    Ok(())
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
        check_axes(&rolls, &zs)?;
        let is_full = removal.len() == rolls.len()
            && removal
                .iter()
                .all(|row| row.len() == zs.len() && row.iter().all(|v| v.is_finite()));
        if !is_full {
            return Err(TopographyError::NotAscending);
        }
        let column =
            |rows: &[Vec<f64>], j: usize| rows.iter().map(|row| row[j]).collect::<Vec<_>>();
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
        Ok(Topography {
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
    /// where they are: length of roll, z and removal, m. Between lines that lie close a cubic can rise far above its
    /// nodes, and beyond the grid its tangents can. Both are the first NaN if there is one.
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

    /// Removal at the length of roll `roll` and at `z`, m.
    pub fn removal(&self, roll: f64, z: f64) -> f64 {
        self.evaluate(roll, z)[0]
    }

    /// Removal and its derivative by the length of roll.
    pub fn evaluate(&self, roll: f64, z: f64) -> [f64; 2] {
        let (i, over_roll) = weights(&self.rolls, roll);
        let (j, over_z) = weights(&self.zs, z);
        let mut sum = [0.0; 2];
        for (a, at_roll) in over_roll.iter().enumerate() {
            for (b, at_z) in over_z.iter().enumerate() {
                let [f, by_roll, by_z, mixed] = self.nodes[(i + a) * self.zs.len() + j + b];
                let value = f * at_z.value[0] + by_z * at_z.slope[0];
                let slope = by_roll * at_z.value[0] + mixed * at_z.slope[0];
                for (d, sum) in sum.iter_mut().enumerate() {
                    *sum += value * at_roll.value[d] + slope * at_roll.slope[d];
                }
            }
        }
        sum
    }
}

/// Ends of the [`PARTS`] between `low` and `high` and the lines between them.
fn places(lines: &[f64], [low, high]: [f64; 2]) -> Vec<f64> {
    let inside = lines.iter().copied().filter(|&x| low < x && x < high);
    let ends: Vec<f64> = std::iter::once(low).chain(inside).chain([high]).collect();
    let parts = ends
        .windows(2)
        .flat_map(|w| (0..PARTS).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / PARTS as f64));
    parts.chain([high]).collect()
}

/// Weights of one node, each with its derivative.
struct Weight {
    value: [f64; 2],
    slope: [f64; 2],
}

/// The cell of `x` and the cubic Hermite weights of both its nodes; outside the tangent at the end.
fn weights(nodes: &[f64], x: f64) -> (usize, [Weight; 2]) {
    let last = nodes.len() - 1;
    let i = nodes.partition_point(|&node| node <= x).clamp(1, last) - 1;
    let h = nodes[i + 1] - nodes[i];
    let inside = x.clamp(nodes[i], nodes[i + 1]);
    let t = (inside - nodes[i]) / h;
    let s = 1.0 - t;
    let cubic = |t: f64, s: f64, sign: f64| Weight {
        value: [s * s * (1.0 + 2.0 * t), -sign * 6.0 * s * t / h],
        slope: [sign * h * t * s * s, s * (s - 2.0 * t)],
    };
    let both = [cubic(t, s, 1.0), cubic(s, t, -1.0)];
    let beyond = x - inside;
    let go_on = |[f, d]: [f64; 2]| [f + d * beyond, d];
    let both = both.map(|w| Weight {
        value: go_on(w.value),
        slope: go_on(w.slope),
    });
    (i, both)
}

/// Slopes at `x` of the parabolas through each value and its neighbours.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    (0..n)
        .map(|i| {
            let c = i.clamp(1, n - 2);
            let (h0, h1) = (x[c] - x[c - 1], x[c + 1] - x[c]);
            let (s0, s1) = ((y[c] - y[c - 1]) / h0, (y[c + 1] - y[c]) / h1);
            let bend = (s1 - s0) / (h0 + h1);
            s0 + bend * (2.0 * x[i] - x[c - 1] - x[c])
        })
        .collect()
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
                assert_abs_diff_eq!(flank.evaluate(r, z)[1], by_roll(r, z), epsilon = 1e-14);
            }
        }
    }

    #[test]
    fn value_and_slope_are_continuous_across_the_lines_of_the_grid() {
        // Anything but smooth.
        let flank = sampled(|r, z| 1e-6 * ((9e3 * r).sin() + (7e2 * z).cos()).round());
        for &roll in &ROLLS {
            for z in [0.0, 3e-3, 5e-3, 20e-3] {
                let [low, high] = [-1e-12, 1e-12].map(|d| flank.evaluate(roll + d, z));
                assert_abs_diff_eq!(low[0], high[0], epsilon = 1e-13);
                assert_abs_diff_eq!(low[1], high[1], epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn beyond_the_grid_the_flank_goes_on_straight() {
        let flank = sampled(|r, z| r * r + 0.1 * r * z);
        for z in [-1e-3, 12e-3, 30e-3] {
            let [end, slope] = flank.evaluate(14e-3, z);
            assert_abs_diff_eq!(flank.removal(17e-3, z), end + 3e-3 * slope, epsilon = 1e-18);
            assert_abs_diff_eq!(flank.evaluate(17e-3, z)[1], slope, epsilon = 1e-15);
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
        let step = |rolls: [f64; 5]| {
            let rows = [0.0, 20e-6, 0.0, 0.0, 0.0].map(|um| vec![um; 4]);
            Topography::new(rolls.to_vec(), ZS.to_vec(), rows.to_vec()).unwrap()
        };
        let [_, [roll, _, removal]] =
            step([3e-3, 3.001e-3, 6e-3, 9e-3, 13e-3]).extremes([3e-3, 13e-3], [0.0, 24e-3]);
        assert!(
            3.001e-3 < roll && roll < 6e-3 && removal > 1e-3,
            "{roll} {removal}"
        );
    }

    #[test]
    fn a_grid_that_is_none_is_refused() {
        let rows = || vec![vec![0.0; 4]; 5];
        let refused =
            |rolls: &[f64], rows| Topography::new(rolls.to_vec(), ZS.to_vec(), rows).unwrap_err();
        assert_eq!(refused(&ROLLS[..2], rows()), TopographyError::TooFew);
        assert_eq!(
            refused(&[6.0, 5.0, 7.0, 8.0, 9.0], rows()),
            TopographyError::NotAscending
        );
        assert_eq!(
            refused(&ROLLS, vec![vec![0.0; 4]; 4]),
            TopographyError::NotAscending
        );
        let mut bad = rows();
        bad[2][1] = f64::NAN;
        assert_eq!(refused(&ROLLS, bad), TopographyError::NotAscending);
    }
}
