//! The elastic model of a pair condensed to what a solve at run time needs: influence matrices over the mesh cycle.
//!
//! The influence of strips on each other and the reference lengths of their local contact are smooth functions of
//! mesh position and centre distance, whatever the load, and cost most of a solve. Here they stand at nodes, divided
//! between bulk and local contact as in every solve; between the nodes they are interpolated with continuous
//! slopes. All else (where strips lie, gaps, curvatures, edges, arms) follows from the pose itself.
//!
//! Strips are known by tooth pair and station. Those a little beyond the reach of contact stand in the nodes, too, so
//! that whatever can carry load is there at all four neighbours of a position. Mesh position 1 is 0 with tooth pairs
//! counted on by one.
//!
//! `between` interpolates, by the `neighbours` of a point, whole rows at once in `rows`.

mod between;
mod neighbours;
mod rows;

use serde::{Deserialize, Serialize};

use super::{error::ContactError, influence::Influence, solver::ContactSolver};
use crate::gear::Flank;

/// Influence of the strips of one flank at nodes.
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
    /// Node by node, offsets outside: influence matrix over (tooth pair, station), lower triangle row by row, m/N, then the
    /// reference lengths of gear 1 and gear 2, m. Zero for strips that are not there.
    #[serde(skip)]
    pub values: Vec<f32>,
}

/// A strip: tooth pair and station.
pub type StripName = (i32, usize);

/// Mesh positions of the nodes over a cycle.
const POSITIONS: usize = 48;

/// Strips of one node and their influence.
pub struct CondensedNode {
    strips: Vec<StripName>,
    influence: Influence,
}

impl CondensedFlank {
    /// Number of nodes at the centre distance offsets `offsets`.
    pub fn node_count(offsets: &[f64]) -> usize {
        offsets.len() * POSITIONS
    }

    /// Node `i` of `flank` with the elastic models of `solver`, at the centre distance offsets `offsets` (m). Nodes do not depend on
    /// each other.
    ///
    /// # Errors
    /// As [`ContactSolver::position`].
    pub fn node(
        solver: &ContactSolver,
        flank: Flank,
        offsets: &[f64],
        i: usize,
    ) -> Result<CondensedNode, ContactError> {
        let tau = (i % POSITIONS) as f64 / POSITIONS as f64;
        // Two steps on either side of a position, and a little for rounding.
        let margin = 2.1 / POSITIONS as f64;
        let (strips, influence) = solver.influence(flank, tau, offsets[i / POSITIONS], margin)?;
        Ok(CondensedNode { strips, influence })
    }

    /// Of all `nodes` in order, as [`CondensedFlank::node`] gives them for the same solver, flank and offsets.
    ///
    /// # Errors
    /// As [`ContactSolver::position`].
    pub fn from_nodes(
        solver: &ContactSolver,
        flank: Flank,
        offsets: &[f64],
        nodes: &[CondensedNode],
    ) -> Result<CondensedFlank, ContactError> {
        let pairs = || {
            nodes
                .iter()
                .flat_map(|node| node.strips.iter().map(|s| s.0))
        };
        let first_pair = pairs().min().unwrap_or(0);
        let mut condensed = CondensedFlank {
            positions: POSITIONS,
            offsets: offsets.to_vec(),
            stations: solver.settings().stations,
            first_pair,
            shares: solver.tooth_shares(flank)?,
            pairs: pairs()
                .max()
                .map_or(0, |last| (last - first_pair + 1) as usize),
            values: vec![],
        };
        let size = condensed.node_size();
        condensed.values = vec![0.0; nodes.len() * size];
        for (node, CondensedNode { strips, influence }) in nodes.iter().enumerate() {
            let places: Vec<usize> = (strips.iter())
                .filter_map(|&name| condensed.place(name, 0))
                .collect();
            let strips = condensed.strips();
            let values = &mut condensed.values[node * size..(node + 1) * size];
            for (i, &row) in places.iter().enumerate() {
                for (j, &column) in places[..=i].iter().enumerate() {
                    values[triangle(row, column)] = influence.bulk[i * places.len() + j] as f32;
                }
                for gear in 0..2 {
                    let place = triangle(strips, 0) + gear * strips + row;
                    values[place] = influence.lengths[gear][i] as f32;
                }
            }
        }
        Ok(condensed)
    }
}

/// Place of row `i` and column `j` <= `i`.
fn triangle(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

impl CondensedFlank {
    fn strips(&self) -> usize {
        self.pairs * self.stations
    }

    /// Number of all values; `None` where the grid makes no sense.
    pub fn value_count(&self) -> Option<usize> {
        let ascends = self.offsets.windows(2).all(|w| w[0] < w[1]);
        // Pairs are those in reach of one mesh cycle.
        let near = self.first_pair.unsigned_abs() < 1000 && (1..1000).contains(&self.pairs);
        let makes_sense =
            matches!(self.offsets.len(), 1 | 3) && ascends && self.positions >= 4 && near;
        let strips = self.pairs.checked_mul(self.stations)?;
        let size = strips.checked_mul(strips.checked_add(5)?)? / 2;
        let nodes = self.offsets.len().checked_mul(self.positions)?;
        nodes.checked_mul(size).filter(|_| makes_sense)
    }

    /// Values of one node.
    fn node_size(&self) -> usize {
        triangle(self.strips(), 0) + 2 * self.strips()
    }

    /// Place of a strip, its tooth pair counted on by `turns`.
    fn place(&self, (pair, station): StripName, turns: i32) -> Option<usize> {
        let pair = usize::try_from(pair + turns - self.first_pair).ok()?;
        (pair < self.pairs).then_some(pair * self.stations + station)
    }

    /// Whether the nodes hold this centre distance.
    pub fn holds(&self, offset: f64) -> bool {
        match self.offsets[..] {
            [low, .., high] => (low..=high).contains(&offset),
            _ => true,
        }
    }
}
