//! How the bulk matrix changes as contact moves along the profile, found from the elastic models a step to either side.
//!
//! With f_i(s) the unit force on segment i at the place s and C the model's compliance, A_ij = f_i' C f_j. Needed are its slope over
//! the place of one of the two, and a second derivative of a whole contact line that moves, so that few more forces are laid on the
//! model than those of the segments themselves.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use gearmesh::contact::{Candidate, ContactLines, ContactSetup, Motion, Segment};
use gearmesh::gear::PairNumbers;

use crate::compliance::{BeyondModel, Load, ToothCompliance, lower_triangle};

/// A segment on its contact line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Number of the contact line.
    pub line: i32,
    /// Middle along it, m.
    pub at: f64,
    /// Length along it, m.
    pub length: f64,
}

/// The segments of a position as one gear sees them.
pub struct OfGear<'a> {
    /// 0 for gear 1, 1 for gear 2.
    pub gear: usize,
    pub model: &'a dyn ToothCompliance,
    pub segments: Vec<Segment>,
    /// Arms of the forces over those of forces along the normal of the gear's own flank.
    pub arms: Vec<f64>,
    /// Reference lengths, m.
    pub lengths: Vec<f64>,
    /// 2 (1 - nu²) / (pi E), 1/Pa.
    pub plane_compliance: f64,
}

impl OfGear<'_> {
    /// Bulk matrix, lower triangle, m/N.
    pub fn bulk(&self) -> Result<DMatrix<f64>, BeyondModel> {
        let loads: Vec<Load> = (0..self.arms.len()).map(|k| self.alone(k)).collect();
        let wanted = lower_triangle(loads.len());
        (self.model).work(&self.segments, [&loads, &loads], &wanted)
    }

    /// One newton on segment `k`.
    fn alone(&self, k: usize) -> Load {
        vec![(k, self.arms[k])]
    }
}

/// Most segments of a strip. Tilts are smooth along a contact line: two instead of one move the mean transmission error of a plastic pair by
/// 1e-4, its peak to peak by 3e-4.
const OF_STRIP: usize = 2;

/// Neighbouring segments of one contact line, whose tilts are taken together.
struct Strip {
    members: Range<usize>,
    /// Number of the contact line, from 0.
    line: usize,
    /// Middle along it, m.
    at: f64,
    /// Length along it, m.
    length: f64,
    /// Where the middle between both sides lies, m from the segments: zero but near tip edges and starts of involutes.
    middle: f64,
    /// As both gears see it, moved towards the tip of gear 1 and towards that of gear 2.
    moved: [[Segment; 2]; 2],
}

/// Strips of the segments of a position a step along the profile from them, and how they deflect.
pub struct Beside<'a> {
    pieces: &'a [Piece],
    strips: Vec<Strip>,
    step: f64,
    /// Tilts of the strips by forces on the segments, 1/N.
    tilt: DMatrix<f64>,
    /// Displacement of each strip at its place towards the tip of gear 1 and towards that of gear 2, m, where its contact line is moved
    /// alike and bears its own length in newton.
    along: [DVector<f64>; 2],
}

impl<'a> Beside<'a> {
    pub fn new(
        lines: &ContactLines<'_>,
        candidates: &[Candidate],
        seen: &[[Segment; 2]],
        pieces: &'a [Piece],
    ) -> Beside<'a> {
        let step = Motion::still(0, lines.setup).step;
        let numbers = &lines.section.numbers;
        let mut strips = vec![];
        let mut end = 0;
        let of_lines = candidates.chunk_by(|a, b| a.tooth_pair == b.tooth_pair);
        for (line, segments) in of_lines.enumerate() {
            let neighbours = segments.chunk_by(|a, b| a.station + 1 == b.station);
            for segments in neighbours.flat_map(|segments| segments.chunks(OF_STRIP)) {
                let members = end..end + segments.len();
                end = members.end;
                let middle = mean(segments.iter().map(|segment| {
                    let [low, high] = lines.room(segment);
                    0.0f64.min(high - step).max(low + step)
                }));
                let whole = joined(&seen[members.start], &seen[members.end - 1]);
                strips.push(Strip {
                    line,
                    at: mean(pieces[members.clone()].iter().map(|piece| piece.at)),
                    length: pieces[members.clone()].iter().map(|p| p.length).sum(),
                    middle,
                    moved: [step, -step].map(|by| moved_segments(numbers, &whole, middle + by)),
                    members,
                });
            }
        }
        let count = strips.len();
        Beside {
            pieces,
            strips,
            step,
            tilt: DMatrix::zeros(count, candidates.len()),
            along: [DVector::zeros(count), DVector::zeros(count)],
        }
    }

    /// Adds how a gear deflects, and returns its bulk matrix, lower triangle, m/N.
    pub fn add(&mut self, of: &OfGear<'_>) -> Result<DMatrix<f64>, BeyondModel> {
        let (n, count) = (of.segments.len(), self.strips.len());
        let lines = self.strips.last().map_or(0, |strip| strip.line + 1);
        let mut segments = of.segments.clone();
        // Rows: the segments, then slopes and both sides of the strips. Columns: the segments, then both sides of each contact line.
        let mut rows: Vec<Load> = (0..n).map(|k| of.alone(k)).collect();
        let mut columns = rows.clone();
        rows.resize(n + 3 * count, vec![]);
        columns.resize(n + 2 * lines, vec![]);
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            for (k, strip) in self.strips.iter().enumerate() {
                let moved = segments.len();
                segments.push(strip.moved[side][of.gear]);
                let arm = mean(of.arms[strip.members.clone()].iter().copied());
                rows[n + k].push((moved, sign * arm / (2.0 * self.step)));
                rows[n + (1 + side) * count + k].push((moved, arm));
                columns[n + side * lines + strip.line].push((moved, arm * strip.length));
            }
        }
        let of_side = |row: usize| {
            let (side, strip) = ((row - n) / count - 1, (row - n) % count);
            (side, strip, n + side * lines + self.strips[strip].line)
        };
        let wanted = (0..rows.len()).map(|row| {
            if row < n {
                0..row + 1
            } else if row < n + count {
                0..n
            } else {
                let (.., column) = of_side(row);
                column..column + 1
            }
        });
        let wanted: Vec<Range<usize>> = wanted.collect();
        let work = (of.model).work(&segments, [&rows, &columns], &wanted)?;
        self.tilt += work.view((n, 0), (count, n));
        // The reference length stays: where the model of a place beside has another, the bulk takes the difference.
        let lengths = of.model.reference_lengths(&segments[n..]);
        for row in n + count..n + 3 * count {
            let (side, strip, column) = of_side(row);
            let here = &of.lengths[self.strips[strip].members.clone()];
            let growth = lengths[side * count + strip].ln() - mean(here.iter().map(|l| l.ln()));
            self.along[side][strip] += work[(row, column)] + of.plane_compliance * growth;
        }
        Ok(work.view((0, 0), (n, n)).into_owned())
    }

    /// The motion of the segments once both gears are added, `bulk` their matrix.
    pub fn motion(self, bulk: &DMatrix<f64>, setup: &ContactSetup) -> Motion {
        let (pieces, step) = (self.pieces, self.step);
        let mut motion = Motion::still(pieces.len(), setup);
        motion.tilt = self.spread(&self.tilt);
        let mut own = DMatrix::zeros(self.strips.len(), pieces.len());
        let mut bend = DMatrix::zeros(self.strips.len(), 1);
        for (k, strip) in self.strips.iter().enumerate() {
            let on_line = self.strips.iter().filter(|other| other.line == strip.line);
            let on_line = on_line.flat_map(|strip| strip.members.clone());
            // What the strip sees of its line, which bears its own length in newton.
            let of_line = |of: &dyn Fn(usize, usize) -> f64| {
                mean((strip.members.clone()).map(|i| {
                    let seen = on_line.clone().map(|j| of(i, j) * pieces[j].length);
                    seen.sum::<f64>()
                }))
            };
            let here = of_line(&|i, j| bulk[(i, j)]);
            let tilts = of_line(&|i, j| motion.tilt[(i, j)] + motion.tilt[(j, i)]);
            let [up, down] = self.along.each_ref().map(|along| along[k]);
            // The slope at the middle between both sides, and half the second derivative.
            let rise = (up - down) / (2.0 * step);
            let second = 0.5 * (up + down) - here - strip.middle * rise;
            let share = (1.0 - strip.middle.abs() / step).max(0.0);
            if share > 0.0 {
                let square = step * step - strip.middle * strip.middle;
                bend[k] = share * share * second / square;
            }
            // Kernels differ from place to place, most near a tip edge, which forces a step apart feel: a line that moves as a whole
            // does not, and its slope is kept.
            let missing = 0.5 * (rise - tilts) - strip.middle * bend[k];
            own.view_mut((k, strip.members.start), (1, strip.members.len()))
                .fill(missing / strip.length);
        }
        motion.tilt += self.spread(&own);
        motion.bend = self.spread(&bend).column(0).into_owned();
        for (bend, piece) in motion.bend.iter_mut().zip(pieces) {
            *bend = (*bend / piece.length).max(0.0);
        }
        motion
    }

    /// Rows of segments from those of strips: linear along each contact line.
    fn spread(&self, of_strips: &DMatrix<f64>) -> DMatrix<f64> {
        let strips = self.strips.iter().enumerate();
        let places = strips.flat_map(|(k, strip)| strip.members.clone().map(move |i| (k, i)));
        let places: Vec<_> = places
            .map(|(k, i)| self.between(k, self.pieces[i].at))
            .collect();
        DMatrix::from_fn(self.pieces.len(), of_strips.ncols(), |i, column| {
            let ([first, second], share) = places[i];
            (1.0 - share) * of_strips[(first, column)] + share * of_strips[(second, column)]
        })
    }

    /// The strips of one contact line, `k` one of them, between which `at` (m along it) lies or next to which it does, and the share of
    /// the second.
    fn between(&self, k: usize, at: f64) -> ([usize; 2], f64) {
        let strip = &self.strips[k];
        let [before, after] = [k.wrapping_sub(1), k + 1].map(|k| {
            let other = self.strips.get(k);
            other.is_some_and(|other| other.line == strip.line)
        });
        let first = if before && (at < strip.at || !after) {
            k - 1
        } else {
            k
        };
        let second = if before || after { first + 1 } else { first };
        let [a, b] = [first, second].map(|k| self.strips[k].at);
        let share = if first < second {
            (at - a) / (b - a)
        } else {
            0.0
        };
        ([first, second], share)
    }
}

/// Segments from `a` to `b` of one contact line as one.
fn joined(a: &[Segment; 2], b: &[Segment; 2]) -> [Segment; 2] {
    [0, 1].map(|gear| {
        let [low, high] = if a[gear].z[0] <= b[gear].z[0] {
            [a[gear], b[gear]]
        } else {
            [b[gear], a[gear]]
        };
        Segment {
            tooth: low.tooth,
            z: [low.z[0], high.z[1]],
            roll: [low.roll[0], high.roll[1]],
        }
    })
}

/// The length of roll (m) on gear `i` where the flanks are touched `by` (m) nearer to the tip of gear 1 than at the length `roll`.
pub fn moved_roll(pair: &PairNumbers, i: usize, roll: f64, by: f64) -> f64 {
    // Arcs of an involute are roll² / (2 rb).
    let square = roll * roll + 2.0 * pair.base_radius[i] * pair.q[i] * by;
    square.max(0.0).sqrt()
}

/// A segment, seen by both gears as `seen`, where contact has moved `by` (m) towards the tip of gear 1.
pub fn moved_segments(pair: &PairNumbers, seen: &[Segment; 2], by: f64) -> [Segment; 2] {
    [0, 1].map(|i| Segment {
        roll: seen[i].roll.map(|roll| moved_roll(pair, i, roll, by)),
        ..seen[i]
    })
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}
