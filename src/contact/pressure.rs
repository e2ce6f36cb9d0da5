//! Flank pressure and line load at tip edges, strip by strip.
//!
//! An oblique contact line crosses the start of a relief within a fraction of a millimetre, and there pressure is largest. A strip whose
//! contact may reach one is looked at between its middle and its ends, too, under the line load in between those of neighbouring strips.

use super::local::{LocalContact, PointLoads};
use super::position::PositionProblem;
use super::result::{EdgeLoad, larger};
#[cfg(feature = "preprocess")]
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
    #[cfg(feature = "preprocess")]
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
            let at = |place: f64| {
                let z = strip.middle() + place * (strip.z[1] - strip.z[0]);
                let profile = lines.profile(tau, strip.tooth_pair, z);
                law(numbers, &Candidate { profile, ..*strip }, self.lengths(i))
            };
            (self.local[i].has_relief()).then(|| Box::new(PLACES.map(at)))
        };
        self.beside = self.candidates.iter().enumerate().map(of).collect();
    }

    /// Largest pressure (Pa) inside the flanks and largest line load at a tip edge of each strip under `loads`.
    pub(super) fn pressures(&self, loads: &[PointLoads]) -> (Vec<f64>, Vec<Option<EdgeLoad>>) {
        let (inside, edges): (Vec<_>, Vec<_>) = (0..loads.len())
            .map(|i| self.inside_and_at_edge(i, &loads[i]))
            .unzip();
        let of = |(i, force): (usize, &Option<f64>)| {
            let Some(force) = *force else { return 0.0 };
            let middle = self.local[i].pressure(force).unwrap_or(0.0);
            let Some(Some(laws)) = self.beside.get(i) else {
                return middle;
            };
            let at = |(place, law): (f64, &LocalContact)| {
                law.pressure_at_relief(self.line_load(&inside, i, place))
            };
            (PLACES.into_iter().zip(laws.iter()).filter_map(at)).fold(middle, f64::max)
        };
        (inside.iter().enumerate().map(of).collect(), edges)
    }

    /// Mean force (N) of the loaded points of strip `i` that stay inside the flanks, and the largest line load at a tip edge.
    ///
    /// Only the local law tells the points of a strip apart: where the gap changes along it, a point bears more than the line does
    /// there. Their mean is what the line bears.
    fn inside_and_at_edge(&self, i: usize, loads: &PointLoads) -> (Option<f64>, Option<EdgeLoad>) {
        let (mut inside, mut points) = (0.0, 0.0);
        let mut edge = None;
        let candidate = &self.candidates[i];
        for (&force, z) in loads.forces.iter().zip(candidate.points()) {
            if force == 0.0 {
                continue;
            }
            if !self.local[i].reaches_edge(force) {
                inside += force;
                points += 1.0;
                continue;
            }
            let here = EdgeLoad {
                line_load: force / self.local[i].length(),
                z,
                gear: candidate.edge_gear(),
            };
            edge = larger(edge, Some(here));
        }
        ((points > 0.0).then(|| inside / points), edge)
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
            if next.tooth_pair != strip.tooth_pair || next.station.abs_diff(strip.station) != 1 {
                return None;
            }
            Some((of(other)? - here) / (next.middle() - strip.middle()))
        });
        here + rise.unwrap_or(0.0) * place * (strip.z[1] - strip.z[0])
    }
}
