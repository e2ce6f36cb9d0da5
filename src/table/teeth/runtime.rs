//! One flank of a pair whose teeth may differ, from the record in the tables file.

use std::sync::Arc;

use nalgebra::SMatrix;

use super::compliance::Coupling;
use super::coupled::{Closing, TeethTable};
use super::pairs::MOST;
use super::record::TeethRecord;
use crate::gear::teeth::{Counts, Passing};
use crate::gear::{Flank, PairGeometry};
use crate::table::runtime::flank_table;
use crate::table::{
    Effects, FlankGrid, FlankTable, Interpolation, Load, Potential, Query, TableError,
};

/// The potential of one flank, and which teeth are in mesh.
#[derive(Debug, Clone)]
pub struct TeethFlank {
    table: Arc<TeethTable>,
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
            table: Arc::new(table(record, flank, effects)?),
            passing: Passing::new(geometry, &record.teeth(), flank),
        })
    }

    /// Both flanks of `record`, as [`TeethFlank::new`]; with the drive flank's samples for both they share them.
    ///
    /// # Errors
    /// As there.
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
                table: drive.table.clone(),
                passing: Passing::new(geometry, &record.teeth(), Flank::Coast),
            }
        };
        Ok([drive, coast])
    }

    /// Whether its teeth differ.
    pub fn tells_teeth_apart(&self) -> bool {
        self.passing.is_some()
    }

    /// As [`TeethTable::evaluate`] with the mesh cycles that passed on gear 1 and gear 2 since the pair of teeth 0.
    pub fn evaluate(&self, query: &Query, counts: Counts, want_hessian: bool) -> Potential {
        let turns = query.mesh_position.floor();
        let tau = query.mesh_position - turns;
        let at = Query {
            mesh_position: tau,
            ..*query
        };
        let counts = counts.map(|count| count + turns as i64);
        // The same for all tooth pairs, and of use for second derivatives alone.
        let curvature = match &self.passing {
            Some(passing) if want_hessian => passing.closing_curvature(counts, tau),
            _ => 0.0,
        };
        let closing = |k| {
            self.passing.as_ref().map_or(Closing::default(), |passing| {
                let [value, rate] = passing.closing(counts, k, tau);
                Closing {
                    value,
                    rate,
                    curvature,
                }
            })
        };
        self.table.evaluate(&at, closing, want_hessian)
    }
}

fn table(record: &TeethRecord, flank: Flank, effects: &Effects) -> Result<TeethTable, TableError> {
    let effects = Effects {
        interpolation: Interpolation::Spline,
        load: Load::Variable,
        ..*effects
    };
    let grid = record.grid(flank);
    let spans = grid.top_load_approach.iter().zip(&grid.no_load_approach);
    let span = spans
        .map(|(top, low)| top - low)
        .fold(f64::INFINITY, f64::min);
    let (_, rows) = record.coupling(flank);
    let mut coupling = Coupling::new(&grid.axes.misalignment, &rows)?;
    let (grid, pair) = flank_table(grid, &effects)?;
    if !effects.misalignment {
        coupling = coupling.aligned();
    }
    let places = [record.first_place, record.last_place - record.first_place];
    record.check_gain(flank, largest_gain(&grid, &pair, &coupling, places[1]))?;
    Ok(TeethTable::new(pair, places, coupling, span))
}

/// Largest part of what tooth pairs give way that others take, at the nodes of `grid`, whose places are `length` base pitches
/// long: minus the least eigenvalue of the compliances between all in mesh, each over what both give way at least. Not a number
/// if one is not.
fn largest_gain(grid: &FlankGrid, pair: &FlankTable, coupling: &Coupling, length: f64) -> f64 {
    let axes = &grid.axes;
    let places = &axes.mesh_position;
    let columns = places.len();
    let [nc, nm, nu, _] = axes.lengths();
    let nodes = (0..nc).flat_map(|c| (0..nm).map(move |m| (c, m)));
    let gains = nodes.map(|(c, m)| {
        let stiffness = |p: usize| {
            let at = |u| pair.evaluate(&grid.query([c, m, u, p]), false);
            largest((0..nu).map(|u| at(u).hessian[0][0]))
        };
        let stiffness: Vec<f64> = (0..columns).map(stiffness).collect();
        let taken = coupling.at(axes.misalignment[m]);
        let first = places.iter().take_while(|p| **p * length < 1.0);
        largest(first.map(|p| {
            // Of the nodes on either side, and where they end.
            let roots: [f64; MOST] = std::array::from_fn(|n| {
                let after = places.partition_point(|q| *q < p + n as f64 / length - 1e-9);
                let beside = [after.checked_sub(1), Some(after)].into_iter().flatten();
                let beside = beside.filter_map(|i| stiffness.get(i)).copied();
                if after < columns {
                    largest(beside).sqrt()
                } else {
                    0.0
                }
            });
            let between = SMatrix::<f64, MOST, MOST>::from_fn(|i, j| {
                taken[i.abs_diff(j)][0] * roots[i] * roots[j]
            });
            -between.symmetric_eigenvalues().min()
        }))
    });
    largest(gains)
}

/// The largest of `values` and 0; not a number if one is not.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a: f64, b| if b <= a { a } else { b })
}
