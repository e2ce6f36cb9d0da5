//! Flank pressure, strip by strip.
//!
//! An oblique contact line crosses the start of a relief within a fraction of a millimetre, and there pressure is largest. A strip whose
//! contact may reach one is looked at between its middle and its ends, too, under the line load in between those of neighbouring strips.

use super::candidates::POINTS;
use super::local::{LocalContact, PointLoads};
use super::position::PositionProblem;
use super::result::EdgeLoad;
use super::{
    candidates::{Candidate, ContactLines},
    numbers::PairNumbers,
    position::law,
};

/// Places of a strip, parts of its length from its middle.
const PLACES: [f64; 4] = [-0.5, -0.25, 0.25, 0.5];

/// Laws of a strip at [`PLACES`], where its contact may reach the start of a relief.
pub(super) type Beside = Option<Box<[LocalContact; PLACES.len()]>>;

impl PositionProblem {
    /// Makes the laws beside the middles of the strips, which lie on `lines` at the mesh position `tau`.
    pub(super) fn look_beside(
        &mut self,
        numbers: &PairNumbers,
        lines: &ContactLines<'_>,
        tau: f64,
    ) {
        // The contact lines of spur pairs run along the start of a relief.
        if numbers.tan_beta_b == 0.0 {
            return;
        }
        let of = |(i, strip): (usize, &Candidate)| {
            let at = |place: f64| law(numbers, &lines.along(tau, strip, place), self.lengths(i));
            (self.local[i].has_relief()).then(|| Box::new(PLACES.map(at)))
        };
        self.beside = self.candidates.iter().enumerate().map(of).collect();
    }

    /// Largest pressure (Pa) inside the flanks of each strip under `loads`; `edges` are the loads at their tip edges.
    pub(super) fn pressures(&self, loads: &[PointLoads], edges: &[Option<EdgeLoad>]) -> Vec<f64> {
        let inside: Vec<_> = (0..loads.len())
            .map(|i| self.inside(i, &loads[i]))
            .collect();
        let of = |(i, force): (usize, &Option<f64>)| {
            let Some(force) = *force else {
                // At its middle the line lies nearer to the edge than where it bears.
                return match edges[i] {
                    Some(_) => 0.0,
                    None => self.local[i].hertz_pressure(loads[i].sum().0 / POINTS as f64),
                };
            };
            let middle = self.local[i].pressure(force).unwrap_or(0.0);
            let Some(Some(laws)) = self.beside.get(i) else {
                return middle;
            };
            let at = |(place, law): (f64, &LocalContact)| {
                law.pressure_at_relief(self.line_load(&inside, i, place))
            };
            (PLACES.into_iter().zip(laws.iter()).filter_map(at)).fold(middle, f64::max)
        };
        inside.iter().enumerate().map(of).collect()
    }

    /// Mean force (N) of the loaded points of strip `i` that stay inside the flanks by the law of its middle.
    ///
    /// Only the local law tells the points of a strip apart: where the gap changes along it, a point bears more than the line does
    /// there. Their mean is what the line bears.
    fn inside(&self, i: usize, loads: &PointLoads) -> Option<f64> {
        let (mut inside, mut points) = (0.0, 0.0);
        for force in loads.forces {
            if force != 0.0 && !self.local[i].reaches_edge(force) {
                inside += force;
                points += 1.0;
            }
        }
        (points > 0.0).then(|| inside / points)
    }

    /// Line load (N/m) at `place` of strip `i`, linear towards its neighbour on that side, if that bears inside the flanks; `forces` are
    /// the mean ones of the points.
    fn line_load(&self, forces: &[Option<f64>], i: usize, place: f64) -> f64 {
        let of = |i: usize| Some(forces.get(i)?.as_ref()? / self.local[i].length());
        let here = of(i).unwrap_or(0.0);
        let beside = match place < 0.0 {
            true => i.checked_sub(1),
            false => Some(i + 1),
        };
        let strip = &self.candidates[i];
        let rise = beside.and_then(|other| {
            let next = self.candidates.get(other)?;
            if !self.are_neighbours(i, other) {
                return None;
            }
            Some((of(other)? - here) / (next.middle() - strip.middle()))
        });
        here + rise.unwrap_or(0.0) * place * (strip.z[1] - strip.z[0])
    }
}
