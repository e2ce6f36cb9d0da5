//! The elastic model of a pair condensed to what a solve at run time needs: influence matrices over the mesh cycle, and their file.
//!
//! Influence and reference lengths of segments are smooth functions of mesh position and centre distance, whatever the load, and cost
//! most of a solve. They are computed at nodes and interpolated with continuous slopes; all else follows from the pose itself.
//!
//! Nodes also hold segments a little beyond the extended path of contact, for all four neighbours of a position. Mesh position 1 is 0 with
//! tooth pairs counted on by one.
//!
//! The file, [`sealed`]: length of the head, head (JSON), and of each flank influence matrices and what [`CondensedRoots`] hold (32-bit
//! floats); little endian.

use std::sync::Arc;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::bulk::{Influence, Motion};
use super::candidates::{Candidate, ContactLines};
use super::root_stress::CondensedRoots;
use super::setup::ContactSetup;
use crate::accuracy::{InterpolationError, is_beyond};
use crate::sealed;
use crate::vector::Lanes;

/// Influence of the segments of one flank at nodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CondensedFlank {
    /// Equal steps of a mesh cycle.
    pub positions: usize,
    /// Centre distance offsets, m: one, or three ascending ones.
    pub offsets: Vec<f64>,
    /// Stations along the face.
    pub stations: usize,
    /// Lowest number of a tooth pair.
    pub first_pair: i32,
    /// Number of tooth pairs.
    pub pairs: usize,
    /// Shares of gear 1 and gear 2 in the bulk displacement of a tooth pair under its own load.
    pub shares: [f64; 2],
    /// Stress in the tooth roots of gear 1 and gear 2; `None`: it was not computed.
    #[serde(default)]
    pub roots: Option<[CondensedRoots; 2]>,
    /// Whether contact moves along the profile as teeth bend.
    #[serde(default)]
    pub bent_teeth: bool,
    /// Node by node, offsets outside: influence matrix over (tooth pair, station), lower triangle row by row, m/N, then the
    /// reference lengths of gear 1 and gear 2, m, then, where contact moves, tilts row by row, 1/N, and bends, 1/(N m). Zero for segments that are not
    /// there.
    #[serde(skip)]
    pub values: Vec<f32>,
}

/// Mesh positions of the nodes over a cycle.
const POSITIONS: usize = 48;

/// What one node is made of.
pub struct CondensedNode {
    /// Whole segments, ascending.
    pub segments: Vec<Candidate>,
    /// How they deflect under each other's forces.
    pub influence: Influence,
}

impl CondensedFlank {
    /// Segments up to this part of a base pitch beyond the extended path are in a node: two steps to either side of a position.
    pub const MARGIN: f64 = 2.1 / POSITIONS as f64;

    /// Mesh positions and centre distance offsets (m) of the nodes with the offsets `offsets`, in their order.
    pub fn grid(offsets: &[f64]) -> Vec<[f64; 2]> {
        let positions = || (0..POSITIONS).map(|i| i as f64 / POSITIONS as f64);
        let row = |offset: &f64| positions().map(|tau| [tau, *offset]).collect::<Vec<_>>();
        offsets.iter().flat_map(row).collect()
    }

    /// Of the `nodes` at all places of [`CondensedFlank::grid`] with the offsets `offsets` (m), on so many `stations`; `shares`
    /// are those of both gears, see [`CondensedFlank::shares`].
    pub fn from_nodes(
        stations: usize,
        shares: [f64; 2],
        offsets: &[f64],
        nodes: &[CondensedNode],
    ) -> CondensedFlank {
        let pairs = || {
            let segments = nodes.iter().flat_map(|node| &node.segments);
            segments.map(|segment| segment.tooth_pair)
        };
        let first_pair = pairs().min().unwrap_or(0);
        let mut condensed = CondensedFlank {
            positions: POSITIONS,
            offsets: offsets.to_vec(),
            stations,
            first_pair,
            pairs: pairs().max().map_or(0, |k| (k - first_pair + 1) as usize),
            shares,
            roots: None,
            bent_teeth: nodes.iter().any(|node| node.influence.motion.is_some()),
            values: vec![],
        };
        let (size, segments) = (condensed.node_size(), condensed.segments());
        let mut values = vec![0.0; nodes.len() * size];
        for (node, values) in nodes.iter().zip(values.chunks_exact_mut(size)) {
            let influence = &node.influence;
            let rows = node.segments.iter().filter_map(|s| condensed.row(s, 0));
            let rows: Vec<usize> = rows.collect();
            for (i, &row) in rows.iter().enumerate() {
                for (j, &column) in rows[..=i].iter().enumerate() {
                    values[triangle(row) + column] = influence.bulk[(i, j)] as f32;
                }
                for (gear, lengths) in influence.lengths.iter().enumerate() {
                    values[triangle(segments) + gear * segments + row] = lengths[i] as f32;
                }
            }
            let motion = &mut values[triangle(segments) + 2 * segments..];
            if let Some(Motion { tilt, bend, .. }) = &influence.motion {
                for (i, &row) in rows.iter().enumerate() {
                    for (j, &column) in rows.iter().enumerate() {
                        motion[row * segments + column] = tilt[(i, j)] as f32;
                    }
                    motion[segments * segments + row] = bend[i] as f32;
                }
            }
        }
        condensed.values = values;
        condensed
    }

    fn segments(&self) -> usize {
        self.pairs * self.stations
    }

    /// Number of all values; `None` where the grid makes no sense.
    pub fn value_count(&self) -> Option<usize> {
        let ascends = self.offsets.windows(2).all(|w| w[0] < w[1]);
        // Pairs are those on the extended path during one mesh cycle.
        let near = self.first_pair.unsigned_abs() < 1000 && (1..1000).contains(&self.pairs);
        let makes_sense =
            matches!(self.offsets.len(), 1 | 3) && ascends && self.positions >= 4 && near;
        let segments = self.pairs.checked_mul(self.stations)?;
        let mut size = segments.checked_mul(segments.checked_add(5)?)? / 2;
        if self.bent_teeth {
            size = size.checked_add(segments.checked_mul(segments.checked_add(1)?)?)?;
        }
        let nodes = self.offsets.len().checked_mul(self.positions)?;
        nodes.checked_mul(size).filter(|_| makes_sense)
    }

    fn node_size(&self) -> usize {
        let segments = self.segments();
        let of_motion = if self.bent_teeth {
            segments * (segments + 1)
        } else {
            0
        };
        triangle(segments) + 2 * segments + of_motion
    }

    /// Row of a segment in a node, its tooth pair counted on by `turns`.
    fn row(&self, segment: &Candidate, turns: i32) -> Option<usize> {
        let pair = usize::try_from(segment.tooth_pair + turns - self.first_pair).ok()?;
        (pair < self.pairs).then_some(pair * self.stations + segment.station)
    }

    /// Whether the nodes hold this centre distance.
    pub fn holds(&self, offset: f64) -> bool {
        match self.offsets[..] {
            [low, .., high] => !is_beyond([low, high], offset),
            _ => true,
        }
    }

    /// Influence of `segments`, ascending, of `lines`, at a mesh position in [0, 1); beyond the offsets of the nodes that of the
    /// outermost one. A tooth pair deflects under its own load as its weak teeth do.
    pub(super) fn influence(&self, segments: &[&Candidate], lines: &ContactLines<'_>) -> Influence {
        let [along, _] = self.along(lines.tau);
        let [across, _] = self.across(lines.center_distance_offset);
        self.weighted(segments, lines, along, across)
    }

    /// Slopes by mesh position (1/cycle) and by centre distance (1/m) of [`CondensedFlank::influence`].
    pub(super) fn slopes(
        &self,
        segments: &[&Candidate],
        lines: &ContactLines<'_>,
    ) -> [Influence; 2] {
        let [along, by_tau] = self.along(lines.tau);
        let [across, by_offset] = self.across(lines.center_distance_offset);
        let weights = [(by_tau, across), (along, by_offset)];
        weights.map(|(along, across)| self.weighted(segments, lines, along, across))
    }

    /// Sum of the nodes about `lines`: four mesh positions with the weights `along` by up to three centre distances with `across`.
    fn weighted(
        &self,
        segments: &[&Candidate],
        lines: &ContactLines<'_>,
        along: [f64; 4],
        across: [f64; 3],
    ) -> Influence {
        let n = segments.len();
        let mut bulk = DMatrix::zeros(n, n);
        let mut lengths = [vec![0.0; n], vec![0.0; n]];
        let mut motion = self.bent_teeth.then(|| Motion::still(n, lines.setup));
        let (rows_in_all, positions) = (self.segments(), self.positions as i64);
        let first = (lines.tau * self.positions as f64).floor() as i64 - 1;
        for (number, along) in (first..).zip(along) {
            let turns = number.div_euclid(positions) as i32;
            let node = number.rem_euclid(positions) as usize;
            let rows = segments.iter().map(|s| self.row(s, turns)).enumerate();
            let held: Vec<(usize, usize)> = rows.filter_map(|(i, row)| Some((i, row?))).collect();
            let runs = held.chunk_by(|a, b| (a.0 + 1, a.1 + 1) == (b.0, b.1));
            let runs: Vec<_> = runs.collect();
            for (k, across) in across.into_iter().enumerate() {
                let weight = along * across;
                if weight == 0.0 {
                    continue;
                }
                let start = (k * self.positions + node) * self.node_size();
                let values = &self.values[start..][..self.node_size()];
                let (matrix, known) = values.split_at(triangle(rows_in_all));
                let (known_lengths, known_motion) = known.split_at(2 * rows_in_all);
                if let Some(motion) = &mut motion {
                    let (tilts, bends) = known_motion.split_at(rows_in_all * rows_in_all);
                    Lanes::widest().run(|_| {
                        for &(i, row) in &held {
                            // Column i of the transpose.
                            let row_of_tilts = &tilts[row * rows_in_all..][..rows_in_all];
                            let sums = &mut motion.tilt.as_mut_slice()[i * n..][..n];
                            for run in &runs {
                                let (first, column) = run[0];
                                let values = row_of_tilts[column..].iter().take(run.len());
                                for (sum, value) in sums[first..].iter_mut().zip(values) {
                                    *sum += weight * f64::from(*value);
                                }
                            }
                            motion.bend[i] += weight * f64::from(bends[row]);
                        }
                    });
                }
                Lanes::widest().run(|_| {
                    for &(i, row) in &held {
                        let row = &matrix[triangle(row)..][..=row];
                        let sums = &mut bulk.as_mut_slice()[i * n..][..=i];
                        for run in runs.iter().take_while(|run| run[0].0 <= i) {
                            let (first, column) = run[0];
                            let values = row[column..].iter().take(run.len());
                            for (sum, value) in sums[first..].iter_mut().zip(values) {
                                *sum += weight * f64::from(*value);
                            }
                        }
                    }
                });
                for (gear, lengths) in lengths.iter_mut().enumerate() {
                    for &(i, row) in &held {
                        lengths[i] += weight * f64::from(known_lengths[gear * rows_in_all + row]);
                    }
                }
            }
        }
        for (i, row) in segments.iter().enumerate() {
            let scale = lines.teeth.map_or(1.0, |(passing, counts)| {
                passing.compliance(self.shares, counts, row.tooth_pair)
            });
            for (j, column) in segments[..=i].iter().enumerate() {
                if column.tooth_pair == row.tooth_pair {
                    bulk[(j, i)] *= scale;
                }
            }
            if let Some(motion) = &mut motion {
                for (j, column) in segments.iter().enumerate() {
                    if column.tooth_pair == row.tooth_pair {
                        motion.tilt[(j, i)] *= scale;
                    }
                }
                motion.bend[i] *= scale;
            }
        }
        if let Some(motion) = &mut motion {
            motion.tilt.transpose_mut();
        }
        bulk.fill_lower_triangle_with_upper_triangle();
        Influence {
            bulk,
            lengths,
            motion,
        }
    }

    /// Weights of the four nodes about `tau`, and their slopes, 1/cycle: cubic convolution, continuous slope, parabolas exact
    /// (Keys, IEEE Trans. Acoustics, Speech, Signal Processing 29 (1981) 1153-1160).
    fn along(&self, tau: f64) -> [[f64; 4]; 2] {
        let positions = self.positions as f64;
        let t = tau * positions - (tau * positions).floor();
        let (t2, t3) = (t * t, t * t * t);
        let weights = [
            0.5 * (-t3 + 2.0 * t2 - t),
            0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
            0.5 * (-3.0 * t3 + 4.0 * t2 + t),
            0.5 * (t3 - t2),
        ];
        let slopes = [
            0.5 * (-3.0 * t2 + 4.0 * t - 1.0),
            0.5 * (9.0 * t2 - 10.0 * t),
            0.5 * (-9.0 * t2 + 8.0 * t + 1.0),
            0.5 * (3.0 * t2 - 2.0 * t),
        ];
        [weights, slopes.map(|slope| slope * positions)]
    }

    /// Weights of the centre distances at `offset` (m), and their slopes, 1/m: the parabola through three.
    fn across(&self, offset: f64) -> [[f64; 3]; 2] {
        let [a, b, c] = self.offsets[..] else {
            return [[1.0, 0.0, 0.0], [0.0; 3]];
        };
        let x = offset.clamp(a, c);
        let [to_a, to_b, to_c] = [x - a, x - b, x - c];
        let per = [(a - b) * (a - c), (b - a) * (b - c), (c - a) * (c - b)].map(f64::recip);
        let weights = [
            to_b * to_c * per[0],
            to_a * to_c * per[1],
            to_a * to_b * per[2],
        ];
        let slopes = [
            (to_b + to_c) * per[0],
            (to_a + to_c) * per[1],
            (to_a + to_b) * per[2],
        ];
        [weights, if x == offset { slopes } else { [0.0; 3] }]
    }
}

fn triangle(i: usize) -> usize {
    i * (i + 1) / 2
}

/// Changes with the layout.
const MAGIC: &[u8; 32] = b"gearmesh condensed contact v002\n";

/// Contact of both flanks.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFile {
    /// The pair without its elastic model.
    pub setup: Arc<ContactSetup>,
    /// Drive flank.
    pub drive: Arc<CondensedFlank>,
    /// Coast flank, if it is not the drive flank's mirror image.
    pub coast: Option<Arc<CondensedFlank>>,
    /// How far force and shuttling moment are, all teeth taken as alike, from those of static contact on more stations; `None`:
    /// not measured.
    pub error: Option<InterpolationError>,
}

/// The head of the file: all but the values of matrices and roots. It is written from references.
#[derive(Serialize, Deserialize)]
struct Head<Setup, Condensed> {
    setup: Setup,
    drive: Condensed,
    coast: Option<Condensed>,
    #[serde(default)]
    error: Option<InterpolationError>,
}

impl ContactFile {
    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let head = Head {
            setup: &*self.setup,
            drive: &*self.drive,
            coast: self.coast.as_deref(),
            error: self.error,
        };
        let head = serde_json::to_vec(&head).expect("plain structs become JSON");
        let mut bytes = (head.len() as u64).to_le_bytes().to_vec();
        bytes.extend(head);
        for flank in [&self.drive].into_iter().chain(&self.coast) {
            let roots = flank.roots.iter().flatten().map(|roots| &roots.values);
            for values in [&flank.values].into_iter().chain(roots) {
                bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            }
        }
        sealed::seal(MAGIC, &bytes)
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with them, as text.
    pub fn from_bytes(bytes: &[u8]) -> Result<ContactFile, String> {
        let bytes = sealed::open(MAGIC, bytes)?;
        let (length, rest) = bytes.split_first_chunk::<8>().ok_or("it has no head")?;
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let parts = rest.split_at_checked(length);
        let (head, values) = parts.ok_or("the head is longer than the file")?;
        let head: Head<ContactSetup, CondensedFlank> =
            serde_json::from_slice(head).map_err(|e| crate::words::json_problem(&e))?;
        head.setup.check()?;
        let mut rest = values.chunks_exact(4);
        let mut filled = |mut flank: CondensedFlank| -> Result<Arc<CondensedFlank>, String> {
            let count = flank.value_count().ok_or("a grid without nodes")?;
            let stations = head.setup.settings.stations;
            if flank.stations != stations {
                return Err(format!(
                    "{} stations of a flank are not the {stations} of the contact",
                    flank.stations
                ));
            }
            let mut fill = |values: &mut Vec<f32>, count: usize| {
                let next = rest.by_ref().take(count);
                values.extend(next.map(|v| f32::from_le_bytes([v[0], v[1], v[2], v[3]])));
                let are_there = values.len() == count && values.iter().all(|v| v.is_finite());
                let missing = || format!("{count} finite values of a flank are not there");
                are_there.then_some(()).ok_or_else(missing)
            };
            fill(&mut flank.values, count)?;
            for roots in flank.roots.iter_mut().flatten() {
                let suits = |_: &usize| roots.stations == stations;
                let count = (roots.value_count().filter(suits)).ok_or("roots without points")?;
                fill(&mut roots.values, count)?;
            }
            Ok(Arc::new(flank))
        };
        let (drive, coast) = (
            filled(head.drive)?,
            head.coast.map(&mut filled).transpose()?,
        );
        if rest.next().is_some() || !rest.remainder().is_empty() {
            return Err("there are more values than those of its flanks".into());
        }
        Ok(ContactFile {
            drive,
            coast,
            setup: Arc::new(head.setup),
            error: head.error,
        })
    }
}
