//! Makes the table of one tooth pair, finds what couples neighbours, and measures both against contact at run time.

use super::coverage::{
    Coverage, Nominal, SEED, displacement_nodes, mesh_positions, no_coast_flank,
};
use super::sweep::{Progress, failed, sweep};
use super::tooth_pair::ToothPair;
use crate::static_contact::{ContactError, ContactSolver, PositionProblem};
use gearmesh::contact::{ContactFile, Prescribed, Warm};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::root::bisection;
use gearmesh::table::{
    Axes, Effects, GearTeethRecord, InterpolationError, Query, TableError, TeethFlank, TeethRecord,
};
use gearmesh::words::rounded;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};
use rayon::prelude::*;

/// Approach beyond all loads, m.
const FARTHEST: f64 = 1e-2;

/// Places of a tooth pair per base pitch.
const PLACES: f64 = 32.0;

/// Places before and after those at which a tooth pair can touch, so that the periodic spline does not carry what happens at one
/// end to the other.
const BEYOND: f64 = 3.0;

/// Nodes for `coverage` but for the places, whose nodes follow from the pair: 12 displacements, 5 centre distances and 17
/// misalignments. Displacements are dense at the first touch: of pairs that share a load unevenly, or lose contact, some bear
/// little, and all of the approach of the pair depends on them under small loads.
pub fn default_teeth_axes(coverage: &Coverage) -> Axes {
    Axes {
        displacement_fraction: displacement_nodes(12, 2.4),
        center_distance_offset: coverage.offsets(5),
        misalignment: coverage.graded_misalignments(17, 2.0),
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
    /// Whether to keep how the load slides, for friction.
    pub friction: bool,
}

impl TeethSweep<'_> {
    /// The record with the nodes of `axes`, its error measured at `points` random operating points.
    ///
    /// # Errors
    /// Teeth with flanks or compliances of their own; the first solve that fails, with its operating point; a coupling that is too
    /// large.
    pub fn record(
        &self,
        axes: &Axes,
        points: usize,
        progress: Progress,
    ) -> Result<TeethRecord, TableError> {
        let teeth = &self.contact.setup.teeth;
        TeethRecord::takes(teeth)?;
        let (solver, coverage) = (self.solver, self.coverage);
        let on_flank = |flank| ToothPair::new(solver, flank, coverage, axes, teeth.spread());
        let drive = on_flank(Flank::Drive)?;
        let own_coast = !self.coast_mirrors_drive;
        let coast = own_coast.then(|| on_flank(Flank::Coast)).transpose()?;
        // Both flanks share places: those that serve either.
        let ends = [&drive].into_iter().chain(&coast).map(|pair| pair.places);
        let [first, last] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |a, b| {
            [a[0].min(b[0]), a[1].max(b[1])]
        });
        let [first, last] = [first - BEYOND / PLACES, last + BEYOND / PLACES];
        let axes = Axes {
            mesh_position: mesh_positions((PLACES * (last - first)).ceil() as usize),
            ..axes.clone()
        };
        let sampled = |mut pair: ToothPair, flank| {
            pair.places = [first, last];
            let mut grid = sweep(&pair, flank, &axes, coverage.maximum_torque, progress)?;
            grid.sliding = grid.sliding.filter(|_| self.friction);
            let coupling = coupling(solver, coverage, flank, &axes.misalignment)?;
            Ok::<_, TableError>((grid.for_file(solver.geometry()), coupling))
        };
        let (drive, coupling_m_per_n) = sampled(drive, Flank::Drive)?;
        let coast = coast.map(|pair| sampled(pair, Flank::Coast)).transpose()?;
        let (coast, coast_coupling_m_per_n) = coast.unzip();
        let [drive_errors, coast_errors] =
            [&teeth.drive, &teeth.coast].map(|gears| gears.each_ref().map(GearTeethRecord::from));
        let mut record = TeethRecord {
            axes: axes.clone(),
            first_place: first,
            last_place: last,
            coupling_m_per_n,
            drive,
            coast,
            coast_coupling_m_per_n,
            friction: self.friction.then(|| solver.friction()),
            drive_errors,
            coast_errors,
            error: InterpolationError::default(),
        };
        let mut error = self.measure(&record, Flank::Drive, points)?;
        if own_coast {
            error = error.with(self.measure(&record, Flank::Coast, points)?);
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
    ) -> Result<InterpolationError, TableError> {
        let geometry = self.solver.geometry();
        let effects = Effects {
            shuttling: true,
            ..Effects::of_axes(&record.axes)
        };
        let teeth = TeethFlank::new(record, geometry, flank, &effects)?;
        let exact = self.contact.flank(flank).ok_or_else(no_coast_flank)?;
        let rb = geometry.gears[0].base_radius();
        let nominal = Nominal::new(geometry, self.coverage);
        let mut random = Random::new(SEED);
        let turn = f64::from(geometry.gears[0].teeth) * f64::from(geometry.gears[1].teeth);
        let points = (0..points).map(|_| {
            let query = self.coverage.draw_query(&mut random, turn);
            (self.coverage.maximum_torque * random.next(), query)
        });
        let points: Vec<(f64, Query)> = points.collect();
        let errors = points.into_par_iter().map(|(torque, mut q)| {
            q.delta = approach(&teeth, &q, torque / rb);
            let found = teeth.evaluate(&q, [0; 2], false);
            let at @ [_, c, m, p] = q.coordinates();
            let exact = exact
                .potential(at, [0; 2], &mut Warm::default())
                .map_err(failed(flank, [c, m, p]))?;
            Ok(nominal.errors(&found.gradient, exact.gradient[0], exact.gradient[2]))
        });
        let errors = errors.collect::<Result<Vec<_>, TableError>>()?;
        Ok(InterpolationError::of(&errors))
    }
}

/// Approach at which `teeth` carries `force` (N) at `query`: bisection, which needs no more than that the force rises.
fn approach(teeth: &TeethFlank, query: &Query, force: f64) -> f64 {
    bisection([-FARTHEST, FARTHEST], 50, |delta| {
        let query = Query { delta, ..*query };
        teeth.evaluate(&query, [0; 2], false).gradient[0] < force
    })
}

const POSITIONS: usize = 32;

/// Loads at each of them, evenly up to the largest: a greater load spreads over the face, where others take less.
const LOADS: usize = 4;

/// The least part of the force of all that a tooth pair carries where it is looked at.
const LEAST_SHARE: f64 = 0.05;

/// Part of the squares of the forces on neighbours that those farther away must have to say anything.
const LEAST_SQUARES: f64 = 1e-4;

/// The coupling on `flank` of `solver`, distance by distance from neighbours on, at each of the `misalignments` (rad), m/N: the
/// least squares of what tooth pairs lack of their approach among others, over loads up to the largest of `coverage`.
///
/// Neighbours share tooth roots and rim, which follows the misalignment; beyond them it is the body, and the same at all.
fn coupling(
    solver: &ContactSolver,
    coverage: &Coverage,
    flank: Flank,
    misalignments: &[f64],
) -> Result<Vec<Vec<f64>>, TableError> {
    let rows = (0..POSITIONS).into_par_iter().map(|i| {
        let tau = i as f64 / POSITIONS as f64;
        let pairs = Together::new(solver, flank, tau).map_err(failed(flank, [0.0, 0.0, tau]))?;
        misalignments
            .iter()
            .map(|&m| {
                let mut sums = Sums::default();
                for load in 1..=LOADS {
                    let torque = coverage.maximum_torque * load as f64 / LOADS as f64;
                    let added = pairs.add(torque, m, &mut sums);
                    added.map_err(failed(flank, [0.0, m, tau]))?;
                }
                Ok(sums)
            })
            .collect()
    });
    let rows: Vec<Vec<Sums>> = rows.collect::<Result<_, TableError>>()?;
    let mut nodes = vec![Sums::default(); misalignments.len()];
    for row in &rows {
        for (sum, sums) in nodes.iter_mut().zip(row) {
            sum.squares += sums.squares;
            sum.products += sums.products;
            sum.farthest = sum.farthest.max(sums.farthest);
        }
    }
    if let Some(node) = nodes.iter().position(|sums| sums.squares[(0, 0)] <= 0.0) {
        return Err(TableError::Failed(format!(
            "no place where two tooth pairs carry at a misalignment of {} mrad: tooth pairs one by one need a contact \
             ratio above 1",
            rounded(1e3 * misalignments[node])
        )));
    }
    let far = Sums::far(&nodes);
    let near: Vec<f64> = nodes.iter().map(|sums| sums.near(far)).collect();
    let farthest = nodes.iter().map(|sums| sums.farthest).max().unwrap_or(1);
    let beyond = (2..=farthest).map(|apart| if apart == 2 { far[0] + far[1] } else { far[1] });
    let beyond = beyond
        .take_while(|c| *c > 0.0)
        .map(|c| vec![c; misalignments.len()]);
    Ok([near].into_iter().chain(beyond).collect())
}

/// Over tooth pairs and loads at one misalignment: forces on neighbours, on those two base pitches apart, and on all that are
/// two or more apart, among each other, N², and with what the pair lacks, N m.
#[derive(Clone, Default)]
struct Sums {
    squares: SMatrix<f64, 3, 3>,
    products: SVector<f64, 3>,
    /// Largest distance at which two carry, base pitches.
    farthest: usize,
}

impl Sums {
    /// What a force takes two base pitches away beyond what it takes farther away, and what it takes there, m/N: neither below 0,
    /// since what two tooth pairs share is less the farther they are apart, and both the same at all of `nodes`.
    fn far(nodes: &[Sums]) -> [f64; 2] {
        let (mut squares, mut products) = (Matrix2::zeros(), Vector2::zeros());
        for sums in nodes {
            // What neighbours do not explain.
            let (both, near) = (sums.squares.fixed_view::<2, 1>(1, 0), sums.squares[(0, 0)]);
            squares += sums.squares.fixed_view::<2, 2>(1, 1) - both * both.transpose() / near;
            products += sums.products.fixed_rows::<2>(1) - both * sums.products[0] / near;
        }
        let least = LEAST_SQUARES * nodes.iter().map(|sums| sums.squares[(0, 0)]).sum::<f64>();
        let alone = [0, 1].map(|k| {
            let square = squares[(k, k)];
            if square > least {
                (products[k] / square).max(0.0)
            } else {
                0.0
            }
        });
        let both = squares.cholesky().map(|squares| squares.solve(&products));
        let both = both.filter(|both| both.min() >= 0.0 && squares.determinant() > least * least);
        let choices = [
            both.unwrap_or_default(),
            Vector2::new(0.0, alone[1]),
            Vector2::new(alone[0], 0.0),
        ];
        let left = choices.map(|c| (c.dot(&(squares * c)) - 2.0 * c.dot(&products), c));
        let best = left.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, choice)| choice).unwrap_or_default().into()
    }

    /// What a force takes of the approach of neighbours, m/N, where it takes `far` beyond them.
    fn near(&self, far: [f64; 2]) -> f64 {
        let beyond = self.squares[(0, 1)] * far[0] + self.squares[(0, 2)] * far[1];
        (self.products[0] - beyond) / self.squares[(0, 0)]
    }
}

struct Together {
    base_radius: f64,
    whole: PositionProblem,
    alone: Vec<(i32, PositionProblem)>,
}

impl Together {
    fn new(solver: &ContactSolver, flank: Flank, tau: f64) -> Result<Self, ContactError> {
        let whole = solver.position(flank, tau, 0.0)?;
        let mut pairs: Vec<i32> = whole.candidates().iter().map(|c| c.tooth_pair).collect();
        pairs.dedup();
        let alone = pairs.into_iter().map(|k| {
            let problem = solver.tooth_pair(flank, tau + f64::from(k), 0.0)?;
            Ok::<_, ContactError>((k, problem))
        });
        Ok(Together {
            base_radius: solver.geometry().gears[0].base_radius(),
            alone: alone.collect::<Result<_, _>>()?,
            whole,
        })
    }

    /// Adds to `sums` what each tooth pair lacks of its approach where all carry `torque`.
    fn add(&self, torque: f64, misalignment: f64, sums: &mut Sums) -> Result<(), ContactError> {
        let whole = self.whole.solve_torque(torque, misalignment, None)?;
        let shares = whole.load_share.iter();
        let forces: Vec<(i32, f64)> = shares
            .map(|(k, share)| (*k, share * whole.loa_force))
            .collect();
        for (k, force) in &forces {
            let mut others = SVector::<f64, 3>::zeros();
            for (other, force) in &forces {
                let apart = k.abs_diff(*other) as usize;
                others += match apart {
                    0 => continue,
                    1 => Vector3::new(*force, 0.0, 0.0),
                    2 => Vector3::new(0.0, *force, *force),
                    _ => Vector3::new(0.0, 0.0, *force),
                };
                if *force > LEAST_SHARE * whole.loa_force {
                    sums.farthest = sums.farthest.max(apart);
                }
            }
            let alone = self.alone.iter().find(|(pair, _)| pair == k);
            let Some((_, alone)) = alone.filter(|_| *force > LEAST_SHARE * whole.loa_force) else {
                continue;
            };
            let own = Prescribed::Torque(force * self.base_radius);
            let own = alone.solve_beyond(own, misalignment, None)?;
            let lacks = whole.approach - own.approach;
            sums.squares += others * others.transpose();
            sums.products += others * lacks;
        }
        Ok(())
    }
}
