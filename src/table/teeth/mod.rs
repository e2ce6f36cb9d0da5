//! Tooth pair by tooth pair: the fast level for teeth that differ.
//!
//! A table holds the potential W1(a, C, M, s) of one tooth pair alone over its approach and its place s along the path of
//! contact, in base pitches from where it touches at the pitch point. Neighbours are coupled through tooth roots and bodies: the load of
//! one takes a part of the approach of the next. Teeth that differ enter as what their errors close of the gap of each pair.
//!
//! Tooth pair k closes by b_k = delta + e_k. The forces on the others deflect it, so that a_k = b_k - sum of c_|j-k| F_j remains, and
//! it carries F_k = dW1/da there. The coupling compliances c depend on the misalignment M. The loads make
//!
//! W = sum of W1(a_k) + sum over every two of c_|j-k| F_j F_k
//!
//! stationary, so that slopes of W are those at fixed loads: those of the W1 at fixed a_k and, by M, -c' F_j F_k of every two: twice
//! that of what remains to both, less once that of the second sum. The loads are also where the complementary energy
//!
//! sum of (a_k - b_k) F_k - W1(a_k) + sum over every two of c_|j-k| F_j F_k
//!
//! is least, which is convex in F while the compliance of a tooth pair exceeds the least eigenvalue of the c, negative
//! ([`TeethRecord::check_gain`]). Newton's iteration finds it, its steps shortened until this energy falls.

// Loops over a few tooth pairs and coordinates read best by index, in step through several arrays.
#![allow(clippy::needless_range_loop)]

mod pairs;
mod record;

pub use record::{GearTeethRecord, TeethRecord};

use super::interpolation::{Basis, Ends, axis};
use super::{
    COORDINATES, Effects, FlankGrid, FlankTable, Interpolation, Load, LoadJet, LoadSpline,
    Potential, Query, TableError, flank_table,
};
use crate::friction::Sliding;
use crate::gear::teeth::{Counts, Passing};
use crate::gear::{Flank, PairGeometry};
use crate::vector::Lanes;
use nalgebra::SMatrix;
use pairs::{Compliances, MOST, Pair, Pairs};
use std::sync::Arc;

/// Steps at most; nearly all points take three or four.
const MOST_STEPS: usize = 200;

/// Part of what the slope of the complementary energy promises that a step must keep, the least part of Newton's step that is
/// tried, and the part of the energies that rounding may take.
const LEAST_GAIN: f64 = 0.1;
const LEAST_PART: f64 = 1e-6;
const ROUNDING: f64 = 1e-13;

/// A step of this part of the span of the table is the last: what it leaves of the energy is of third order in it.
const LAST_STEP: f64 = 1e-6;

/// The potential of one flank whose teeth may differ, and which of them are in mesh.
#[derive(Debug, Clone)]
pub struct TeethFlank {
    pairs: Arc<PairTable>,
    /// `None`: all teeth are alike.
    passing: Option<Passing>,
}

impl TeethFlank {
    /// `flank` of `record`, which is of the pair `geometry`, reduced to the dimensions that `effects` switch on.
    ///
    /// # Errors
    /// An effect whose axis is missing; a coupling that is too large for the table.
    pub fn new(
        record: &TeethRecord,
        geometry: &PairGeometry,
        flank: Flank,
        effects: &Effects,
    ) -> Result<Self, TableError> {
        Ok(TeethFlank {
            pairs: Arc::new(PairTable::new(record, flank, effects)?),
            passing: Passing::new(geometry, &record.teeth(), flank),
        })
    }

    /// Both flanks of `record`, as [`TeethFlank::new`]; with the drive flank's samples for both they share them.
    pub fn both(
        record: &TeethRecord,
        geometry: &PairGeometry,
        effects: &Effects,
    ) -> Result<[Self; 2], TableError> {
        let drive = TeethFlank::new(record, geometry, Flank::Drive, effects)?;
        let coast = if record.coast.is_some() {
            TeethFlank::new(record, geometry, Flank::Coast, effects)?
        } else {
            TeethFlank {
                pairs: drive.pairs.clone(),
                passing: Passing::new(geometry, &record.teeth(), Flank::Coast),
            }
        };
        Ok([drive, coast])
    }

    /// Whether its teeth differ.
    pub fn tells_teeth_apart(&self) -> bool {
        self.passing.is_some()
    }

    /// Potential at `query` with the mesh cycles that passed on gear 1 and gear 2 since the pair of teeth 0; tooth pair k is at
    /// the place mesh position + k. As [`FlankTable::evaluate`]; NaN where no loads were found.
    pub fn evaluate(&self, query: &Query, counts: Counts, want_hessian: bool) -> Potential {
        self.evaluate_sliding(query, counts, want_hessian).0
    }

    /// As [`TeethFlank::evaluate`], with how the load slides; zero unless friction is among the effects.
    pub fn evaluate_sliding(
        &self,
        query: &Query,
        counts: Counts,
        want_hessian: bool,
    ) -> (Potential, Sliding) {
        let turns = query.mesh_position.floor();
        let tau = query.mesh_position - turns;
        let counts = counts.map(|count| count + turns as i64);
        let closing = |k| {
            let passing = self.passing.as_ref();
            passing.map_or([0.0; 2], |passing| passing.closing(counts, k, tau))
        };
        let [delta, c, m, _] = query.coordinates();
        let mut pairs = self.pairs.in_mesh([delta, c, m, tau], closing);
        let mut sum = Potential {
            out_of_range: pairs.all().iter().any(|pair| pair.potential.out_of_range),
            ..Potential::default()
        };
        pairs.drop_idle();
        if pairs.count == 0 {
            return (sum, Sliding::default());
        }
        if pairs.count > 1 && !self.pairs.settle(&mut pairs) {
            sum.value = f64::NAN;
            sum.gradient = [f64::NAN; COORDINATES];
            return (sum, Sliding::default());
        }
        // The same for all tooth pairs.
        let curvature = || {
            let passing = self.passing.as_ref();
            passing.map_or(0.0, |passing| passing.closing_curvature(counts, tau))
        };
        pairs.total(&mut sum, want_hessian.then(curvature));
        let sliding = self.pairs.sliding.as_ref();
        let sliding = sliding.map(|table| self.pairs.slide(table, &pairs, sum.gradient[0]));
        (sum, sliding.unwrap_or_default())
    }
}

/// Tooth pairs of one flank that are alike.
#[derive(Debug)]
struct PairTable {
    /// Of one tooth pair alone, over its approach, centre distance, misalignment and place; the place as a fraction of its range.
    pair: FlankTable,
    /// First place of the range and its length, base pitches.
    places: [f64; 2],
    coupling: Coupling,
    /// Step that is the last, m.
    last_step: f64,
    /// How the load of one slides, over its displacement in place of a force; `None`: friction is off.
    sliding: Option<LoadSpline>,
}

impl PairTable {
    fn new(record: &TeethRecord, flank: Flank, effects: &Effects) -> Result<Self, TableError> {
        let effects = Effects {
            interpolation: Interpolation::Spline,
            load: Load::Variable,
            ..*effects
        };
        let grid = record.grid(flank);
        let sliding = match (&grid.sliding, record.friction) {
            _ if !effects.friction => None,
            (None, _) | (_, None) => return Err(TableError::NO_FRICTION),
            (Some(samples), Some(_)) => {
                let (nodes, columns) = (grid.axes.nodes(), samples.columns());
                Some(LoadSpline::new(nodes, &columns, effects.axes())?)
            }
        };
        let [_, spans] = grid.fields();
        let span = spans.values.into_iter().fold(f64::INFINITY, f64::min);
        let mut coupling = Coupling::new(&grid.axes.misalignment, &record.coupling(flank))?;
        let (grid, pair) = flank_table(grid, &effects)?;
        if !effects.misalignment {
            coupling = coupling.aligned()?;
        }
        let places = [record.first_place, record.last_place - record.first_place];
        record.check_gain(flank, largest_gain(&grid, &pair, &coupling, places[1]))?;
        Ok(PairTable {
            pair,
            places,
            coupling,
            last_step: LAST_STEP * span,
            sliding,
        })
    }

    /// Where the table is looked up at `at` (approach, centre distance offset, misalignment, place).
    fn query(&self, &[delta, c, m, place]: &[f64; COORDINATES]) -> Query {
        let [first, length] = self.places;
        Query::from([delta, c, m, (place - first) / length])
    }

    /// How the loads of `pairs` slide in `table`, which add up to `force` (N).
    fn slide(&self, table: &LoadSpline, pairs: &Pairs, force: f64) -> Sliding {
        let mut sum = [0.0; 4];
        for pair in pairs.all() {
            let q = self.query(&pair.at);
            let [_, c, m, p] = q.coordinates();
            let jets = table.evaluate([self.pair.fraction(&q), c, m, p]);
            for (sum, LoadJet { value, .. }) in sum.iter_mut().zip::<[_; 4]>(jets) {
                *sum += value * pair.potential.gradient[0] / force;
            }
        }
        let [share, share_z, distance, weight] = sum;
        Sliding {
            weight,
            share,
            share_z,
            distance,
        }
    }

    /// W1 at `at` (approach, centre distance offset, misalignment, place) with its Hessian, slopes by the place.
    fn alone(&self, at: &[f64; COORDINATES]) -> Potential {
        let [_, length] = self.places;
        let mut w = self.pair.evaluate(&self.query(at), true);
        w.gradient[3] /= length;
        for i in 0..COORDINATES {
            w.hessian[i][3] /= length;
            w.hessian[3][i] /= length;
        }
        w
    }

    /// All tooth pairs within the table's places at (approach, centre distance offset, misalignment, mesh position), each as if
    /// it were alone; `closing`: what errors close of the gap of a pair, m, and its slope by mesh position.
    fn in_mesh(&self, at: [f64; COORDINATES], closing: impl Fn(i32) -> [f64; 2]) -> Pairs {
        let [delta, c, m, tau] = at;
        let [first, length] = self.places;
        let mut pairs = Pairs {
            all: [Pair::default(); MOST],
            count: 0,
            coupling: self.coupling.at(m),
        };
        for k in (first - tau).ceil() as i32.. {
            let place = tau + f64::from(k);
            // NaN ends it, too.
            if place.is_nan() || place >= first + length || pairs.count == MOST {
                break;
            }
            let [value, closing_rate] = closing(k);
            let free = [delta + value, c, m, place];
            pairs.all[pairs.count] = Pair {
                k,
                closing_rate,
                free,
                at: free,
                potential: self.alone(&free),
            };
            pairs.count += 1;
        }
        pairs
    }

    /// Finds the approach that remains to each of `pairs`; false if it does not.
    fn settle(&self, pairs: &mut Pairs) -> bool {
        let (mut remaining, mut energy) = pairs.remaining();
        for _ in 0..MOST_STEPS {
            let (step, largest, slope) = pairs.newton(&remaining);
            if largest <= self.last_step {
                pairs.correct(&step);
                return true;
            }
            let here: [f64; MOST] = std::array::from_fn(|n| pairs.all[n].at[0]);
            let mut part = 1.0;
            loop {
                for n in 0..pairs.count {
                    let pair = &mut pairs.all[n];
                    pair.at[0] = here[n] + part * step[n];
                    pair.potential = self.alone(&pair.at);
                }
                let (remaining_there, energy_there) = pairs.remaining();
                if energy_there.is_nan() {
                    return false;
                }
                let rounding = ROUNDING * (energy.abs() + energy_there.abs());
                let promised = LEAST_GAIN * part * slope;
                if energy_there <= energy + promised + rounding || part < LEAST_PART {
                    (remaining, energy) = (remaining_there, energy_there);
                    break;
                }
                part *= 0.5;
            }
        }
        false
    }
}

/// Part of itself by which the compliance changes at most beyond an end of the misalignments.
const BEYOND: f64 = 0.5;

/// Compliances between tooth pairs, over the misalignment.
///
/// The next one shares tooth roots and the rim next to it, all of them the body. Under misalignment they carry at the same end of
/// the face, where a force takes more from the others than a force at mid-face does. Each distance has a cubic spline over the
/// misalignment, continuous up to its second derivative; beyond the ends it goes on linearly and levels out, as tables do.
#[derive(Debug)]
struct Coupling {
    basis: Basis<4>,
    /// From the distance 1 on.
    coefficients: Vec<Vec<f64>>,
}

impl Coupling {
    /// Through `rows` (m/N), from the distance 1 on, at the `misalignments` (rad, ascending); one of each: the same everywhere.
    fn new(misalignments: &[f64], rows: &[Vec<f64>]) -> Result<Self, TableError> {
        let (basis, fit) = axis(misalignments, Ends::Bounded, "teeth.axes.misalignment_rad")?;
        let mut coupling = Coupling {
            basis,
            coefficients: rows.iter().map(|row| fit.coefficients(row)).collect(),
        };
        let ends = [misalignments[0], misalignments[misalignments.len() - 1]];
        for (end, node) in ends.into_iter().enumerate() {
            for [value, slope, _] in coupling.at(node) {
                // Its slope acts over half of the levelling length; NaN: nothing at this distance.
                let levelling_length = &mut coupling.basis.levelling_length[end];
                *levelling_length = levelling_length.min(2.0 * BEYOND * (value / slope).abs());
            }
        }
        Ok(coupling)
    }

    /// The same at all misalignments, as with parallel axes.
    fn aligned(&self) -> Result<Self, TableError> {
        let here = &self.at(0.0)[1..=self.coefficients.len()];
        let rows: Vec<Vec<f64>> = here.iter().map(|[value, ..]| vec![*value]).collect();
        Coupling::new(&[0.0], &rows)
    }

    /// At the misalignment `m`, rad.
    fn at(&self, m: f64) -> Compliances {
        let (w, _) = self.basis.weights(Lanes::COMMON, m, 2);
        let mut all = [[0.0; 3]; MOST];
        for (compliance, coefficients) in all[1..].iter_mut().zip(&self.coefficients) {
            *compliance = [&w.value, &w.slope, &w.curvature].map(|by| w.sum(by, coefficients));
        }
        all
    }
}

/// Largest part of the compliance of tooth pairs that others take, at the nodes of `grid`, whose places are `length` base pitches
/// long: minus the least eigenvalue of the compliances between all in mesh, each over the least compliance of both. NaN if one is.
fn largest_gain(grid: &FlankGrid, pair: &FlankTable, coupling: &Coupling, length: f64) -> f64 {
    let axes = &grid.axes;
    let places = &axes.mesh_position;
    let columns = places.len();
    let [nc, nm, nu, _] = axes.lengths();
    let nodes = (0..nc).flat_map(|c| (0..nm).map(move |m| (c, m)));
    let gains = nodes.map(|(c, m)| {
        let stiffness = |p: usize| {
            let potential = |u| pair.evaluate(&grid.query([c, m, u, p]), false);
            largest((0..nu).map(|u| potential(u).hessian[0][0]))
        };
        let stiffness: Vec<f64> = (0..columns).map(stiffness).collect();
        let compliances = coupling.at(axes.misalignment[m]);
        let first = places.iter().take_while(|p| **p * length < 1.0);
        largest(first.map(|p| {
            // Of the nodes on either side, and where they end.
            let roots: [f64; MOST] = std::array::from_fn(|n| {
                let after = places.partition_point(|q| *q < p + n as f64 / length - 1e-9);
                let either = &stiffness[after.saturating_sub(1)..(after + 1).min(columns)];
                match after < columns {
                    true => largest(either.iter().copied()).sqrt(),
                    false => 0.0,
                }
            });
            let between = SMatrix::<f64, MOST, MOST>::from_fn(|i, j| {
                compliances[i.abs_diff(j)][0] * roots[i] * roots[j]
            });
            -between.symmetric_eigenvalues().min()
        }))
    });
    largest(gains)
}

/// The largest of `values` and 0; NaN if one is.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a: f64, b| if b <= a { a } else { b })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [f64; 6] = [-3e-3, -1e-3, -4e-4, 5e-4, 1.2e-3, 3e-3];
    const VALUES: [f64; 6] = [1.1e-9, 9.7e-10, 9e-10, 9.2e-10, 1e-9, 1.2e-9];

    #[test]
    fn the_coupling_passes_through_its_nodes_with_its_own_slopes_and_levels_out() {
        let coupling = Coupling::new(&NODES, &[VALUES.to_vec()]).unwrap();
        for (node, value) in NODES.iter().zip(VALUES) {
            assert!((coupling.at(*node)[1][0] / value - 1.0).abs() < 1e-12);
        }
        // Across the nodes, the ends and where it levels out; the second derivative jumps at the last two.
        let step = 1e-7;
        for i in -900..=900 {
            let m = 1e-5 * f64::from(i) + 1e-8;
            let [below, here, above] = [m - step, m, m + step].map(|m| coupling.at(m)[1]);
            let by_differences = |k: usize| (above[k] - below[k]) / (2.0 * step);
            assert!((by_differences(0) - here[1]).abs() < 1e-10, "{m} {here:?}");
            if m.abs() < NODES[5] - step {
                assert!((by_differences(1) - here[2]).abs() < 1e-5, "{m} {here:?}");
            }
        }
        for (far, end) in [(-1.0, 1.1e-9), (1.0, 1.2e-9)] {
            let [value, slope, _] = coupling.at(far)[1];
            let change = (value / end - 1.0).abs();
            assert!(change < 1.001 * BEYOND && slope == 0.0, "{value}");
        }
        let aligned = coupling.aligned().unwrap();
        assert_eq!(aligned.at(2e-3)[1], [coupling.at(0.0)[1][0], 0.0, 0.0]);
    }

    #[test]
    fn every_distance_has_its_own_coupling_and_those_beyond_take_nothing() {
        let [near, far] = [1.0, 0.3].map(|share| VALUES.map(|v| share * v).to_vec());
        let here = Coupling::new(&NODES, &[near, far]).unwrap().at(7e-4);
        for (far, near) in here[2].iter().zip(here[1]) {
            assert!((far / near - 0.3).abs() < 1e-12);
        }
        assert_eq!([here[0], here[3]], [[0.0; 3]; 2]);
    }
}
