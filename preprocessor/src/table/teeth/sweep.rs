//! Makes the table of one tooth pair, tells what couples neighbours, and measures both against contact at run time.

use super::alone::Alone;
use super::coupling::coupling;
use crate::table::measure::{self, drawn, errors};
use crate::table::plan::{Coverage, displacement_nodes, graded, mesh_positions};
use crate::table::sweep::{Watch, point, sweep};
use gearmesh::contact::{ContactFile, ContactSolver, Warm};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::root::bisection;
use gearmesh::table::{
    Axes, Effects, GearTeethRecord, Interpolation, InterpolationError, Load, Query, TableError,
    TeethFlank, TeethRecord,
};

/// Approach beyond all loads, m.
const FARTHEST: f64 = 1e-2;

/// Places of a tooth pair per base pitch.
const PLACES: f64 = 32.0;

/// Places before and after those at which a tooth pair can touch, so that the periodic spline does not carry what happens at one
/// end to the other.
const BEYOND: f64 = 3.0;

/// Nodes of a tooth pair's displacement, and how much denser they are at its first touch: of pairs that share a load unevenly,
/// or lose contact, some bear little, and all of the approach of the pair depends on them under small loads.
const DISPLACEMENTS: (usize, f64) = (12, 2.4);

/// Nodes for `coverage` but for the places, whose nodes follow from the pair: 12 displacements, 5 centre distances and 17
/// misalignments.
pub fn default_teeth_axes(coverage: &Coverage) -> Axes {
    let range = |r: Option<[f64; 2]>, n, grading| r.map_or(vec![0.0], |r| graded(r, n, grading));
    Axes {
        displacement_fraction: displacement_nodes(DISPLACEMENTS.0, DISPLACEMENTS.1),
        center_distance_offset: range(coverage.center_distance_offset, 5, 0.0),
        misalignment: range(coverage.misalignment, 17, 2.0),
        mesh_position: vec![0.0],
    }
}

/// Tooth pairs of a pair of gears one by one.
pub struct TeethSweep<'a> {
    /// Static contact.
    pub solver: &'a ContactSolver,
    /// The same at run time, with the errors of the teeth, to measure against.
    pub contact: &'a ContactFile,
    /// What is to be covered.
    pub coverage: &'a Coverage,
    /// Whether the coast flank is the drive flank mirrored.
    pub coast_mirrors_drive: bool,
}

impl TeethSweep<'_> {
    /// The record with the nodes of `axes`, its error measured at `points` random operating points.
    ///
    /// # Errors
    /// Teeth with flanks or compliances of their own; the first solve that fails, with its operating point; a coupling that is too
    /// large; cancellation.
    pub fn record(
        &self,
        axes: &Axes,
        points: usize,
        watch: &Watch,
    ) -> Result<TeethRecord, TableError> {
        let teeth = &self.contact.setup.teeth;
        TeethRecord::takes(teeth)?;
        let flanks: &[Flank] = if self.coast_mirrors_drive {
            &[Flank::Drive]
        } else {
            &[Flank::Drive, Flank::Coast]
        };
        // Both flanks share places: those that hold for either.
        let sources = flanks
            .iter()
            .map(|&flank| Alone::new(self.solver, flank, self.coverage, axes, teeth.spread()))
            .collect::<Result<Vec<_>, _>>()?;
        let ends = sources.iter().map(Alone::ends);
        let [first, last] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |a, b| {
            [a[0].min(b[0]), a[1].max(b[1])]
        });
        let [first, last] = [first - BEYOND / PLACES, last + BEYOND / PLACES];
        let count = (PLACES * (last - first)).ceil();
        let axes = Axes {
            mesh_position: mesh_positions(count as usize),
            ..axes.clone()
        };
        let torque = self.coverage.maximum_torque;
        let (mut grids, mut couplings) = (vec![], vec![]);
        for (source, &flank) in sources.iter().zip(flanks) {
            let source = source.over([first, last - first]);
            grids.push(sweep(&source, flank, &axes, torque, watch)?.for_file());
            let told = coupling(self.solver, self.coverage, flank, &axes.misalignment)?;
            couplings.push(told);
        }
        let (mut grids, mut couplings) = (grids.into_iter(), couplings.into_iter());
        let errors = |gears: &[_; 2]| gears.each_ref().map(GearTeethRecord::from);
        let mut record = TeethRecord {
            axes,
            first_place: first,
            last_place: last,
            coupling_m_per_n: couplings.next().expect("there is always a drive flank"),
            drive: grids.next().expect("there is always a drive flank"),
            coast: grids.next(),
            coast_coupling_m_per_n: couplings.next(),
            drive_errors: errors(&teeth.drive),
            coast_errors: errors(&teeth.coast),
            error: InterpolationError::default(),
        };
        let mut error = self.measure(&record, Flank::Drive, points, watch)?;
        if !self.coast_mirrors_drive {
            error = error.with(self.measure(&record, Flank::Coast, points, watch)?);
        }
        record.error = error;
        Ok(record)
    }

    /// Error of `record` on `flank` at `points` random operating points: teeth and mesh positions over all turns, torques
    /// even in (0, maximum), the other coordinates even in their ranges.
    fn measure(
        &self,
        record: &TeethRecord,
        flank: Flank,
        points: usize,
        watch: &Watch,
    ) -> Result<InterpolationError, TableError> {
        let geometry = self.solver.geometry();
        let effects = Effects {
            interpolation: Interpolation::Spline,
            load: Load::Variable,
            center_distance: record.axes.center_distance_offset.len() > 1,
            misalignment: record.axes.misalignment.len() > 1,
            shuttling: true,
            friction: false,
            root_stress: false,
            teeth: true,
        };
        let level = TeethFlank::new(record, geometry, flank, &effects)?;
        let exact = self.contact.flank(flank).ok_or_else(|| {
            TableError::Samples("the contact at run time has no coast flank of its own".into())
        })?;
        let rb = geometry.gears[0].base_radius();
        let force = self.coverage.nominal_torque / rb;
        let nominal = [force, 0.5 * force * geometry.face_overlap().1];
        let mut random = Random::new(measure::SEED);
        let turn = f64::from(geometry.gears[0].teeth) * f64::from(geometry.gears[1].teeth);
        let points = (0..points)
            .map(|_| {
                let query = Query {
                    delta: 0.0,
                    center_distance_offset: drawn(
                        &mut random,
                        self.coverage.center_distance_offset,
                    ),
                    misalignment: drawn(&mut random, self.coverage.misalignment),
                    mesh_position: turn * random.next(),
                };
                (self.coverage.maximum_torque * random.next(), query)
            })
            .collect();
        let errors = errors(points, watch, |(torque, mut q)| {
            q.delta = approach(&level, &q, torque / rb);
            let (c, m, p) = (q.center_distance_offset, q.misalignment, q.mesh_position);
            let found = level.evaluate(&q, [0; 2], false);
            let exact = exact
                .potential([q.delta, c, m, p], [0; 2], &mut Warm::default())
                .map_err(|error| TableError::Solve {
                    point: point(flank, c, m, p),
                    message: error.to_string(),
                })?;
            Ok([0, 2].map(|i| (found.gradient[i] - exact.gradient[i]) / nominal[i / 2]))
        })?;
        Ok(InterpolationError::of(&errors))
    }
}

/// Approach at which `level` carries `force` (N) at `query`: bisection, which needs no more than that the force rises.
fn approach(level: &TeethFlank, query: &Query, force: f64) -> f64 {
    let carried = |delta: f64| {
        let query = Query { delta, ..*query };
        level.evaluate(&query, [0; 2], false).gradient[0]
    };
    bisection([-FARTHEST, FARTHEST], 50, |delta| carried(delta) < force)
}
