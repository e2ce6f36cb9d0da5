//! Static solutions: where they come from, and the sweep that fills a grid with them.

use crate::static_contact::{ContactError, ContactSolver, PositionProblem, Resultant};
use gearmesh::accuracy::is_beyond;
use gearmesh::contact::Prescribed;
use gearmesh::friction::{FrictionLaw, Sliding};
use gearmesh::gear::Flank;
use gearmesh::table::{Axes, FlankGrid, SlidingSamples, TableError};
use gearmesh::words::rounded;
use rayon::prelude::*;
use std::fmt::Display;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// One static equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// STE on the line of action at mid-face, m.
    pub approach: f64,
    /// F_bt, N.
    pub loa_force: f64,
    /// F_bt (z_c - z_ref), N m.
    pub moment: f64,
    /// How the load slides; zero unless the source has a law of friction.
    pub sliding: Sliding,
}

impl From<&Resultant> for Sample {
    fn from(result: &Resultant) -> Self {
        Sample {
            approach: result.approach,
            loa_force: result.loa_force,
            moment: result.moment,
            sliding: Sliding::default(),
        }
    }
}

impl Sample {
    /// Mirrored at mid-face.
    fn mirrored(&self) -> Sample {
        Sample {
            moment: -self.moment,
            sliding: self.sliding.mirrored(),
            ..*self
        }
    }
}

/// Static contact at one mesh position and centre distance.
pub trait StaticPosition {
    /// Approach at the first touch, m.
    fn no_load_approach(&mut self, misalignment: f64) -> f64;
    /// Equilibrium under a torque on gear 1 or at an approach.
    fn solve(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, ContactError>;
    /// Equilibrium up to which a table for this largest torque (N m) goes: that under the torque itself.
    fn top(&mut self, torque: f64, misalignment: f64) -> Result<Sample, ContactError> {
        self.solve(Prescribed::Torque(torque), misalignment)
    }
}

/// Some static contact at one mesh position and centre distance.
pub type Position<'a> = Box<dyn StaticPosition + 'a>;

/// Static contact of a pair.
pub trait StaticSource: Sync {
    /// The contact at the mesh position `p` and the centre distance offset `c` (m).
    fn position(&self, flank: Flank, p: f64, c: f64) -> Result<Position<'_>, ContactError>;
    /// Whether mid-face mirrors the pair, so that misalignments of one sign tell of both.
    fn is_mirrored_at_mid_face(&self) -> bool {
        false
    }
    /// Law of friction that weights the sliding of its samples; `None`: they have none.
    fn friction(&self) -> Option<FrictionLaw> {
        None
    }
}

/// How well the solves of a source went.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SolveQuality {
    /// Number of solves.
    pub solves: usize,
    /// Most Newton steps that one of them took.
    pub most_iterations: usize,
    /// Largest KKT residual, see [`Resultant::kkt_residual`].
    pub kkt_residual: f64,
}

/// A contact solver that keeps account of its solves. Beyond the misalignments of a pair it accepts pressures that no flank bears:
/// nodes there only say how a table goes on.
pub struct WatchedSolver<'a> {
    solver: &'a ContactSolver,
    /// rad; None: parallel axes only.
    misalignments: Option<[f64; 2]>,
    quality: Mutex<SolveQuality>,
}

impl<'a> WatchedSolver<'a> {
    /// Nothing solved yet, for a pair with these `misalignments` (rad; None: parallel axes only).
    pub fn new(solver: &'a ContactSolver, misalignments: Option<[f64; 2]>) -> Self {
        WatchedSolver {
            solver,
            misalignments,
            quality: Mutex::default(),
        }
    }

    /// Of all solves so far.
    pub fn quality(&self) -> SolveQuality {
        *self.quality.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl StaticSource for WatchedSolver<'_> {
    fn position(&self, flank: Flank, p: f64, c: f64) -> Result<Position<'_>, ContactError> {
        let problem = self.solver.position(flank, p, c)?;
        Ok(Box::new(SolverPosition::new(problem, Some(self))))
    }

    fn is_mirrored_at_mid_face(&self) -> bool {
        self.solver.is_mirrored_at_mid_face()
    }
}

impl StaticSource for ContactSolver {
    fn position(&self, flank: Flank, p: f64, c: f64) -> Result<Position<'_>, ContactError> {
        Ok(Box::new(SolverPosition::new(
            self.position(flank, p, c)?,
            None,
        )))
    }

    fn is_mirrored_at_mid_face(&self) -> bool {
        self.is_mirrored_at_mid_face()
    }
}

/// Residual from which on a step along tangents ends a solve. Measured on three shipped pairs: samples within 4e-6 of the largest, where tables
/// are off by 6e-4 to 1.5e-3 between them.
const LAST_STEP_FROM: f64 = 3e-3;

/// A position of the contact solver with the last solution, from which the next one starts.
struct SolverPosition<'a> {
    problem: PositionProblem,
    last: Option<Resultant>,
    /// The one before it, where both are at one misalignment.
    before: Option<Resultant>,
    /// The last one under a torque.
    top: Option<Resultant>,
    watched: Option<&'a WatchedSolver<'a>>,
}

impl<'a> SolverPosition<'a> {
    fn new(mut problem: PositionProblem, watched: Option<&'a WatchedSolver<'a>>) -> Self {
        problem.contact.last_step_from = LAST_STEP_FROM;
        SolverPosition {
            problem,
            top: None,
            last: None,
            before: None,
            watched,
        }
    }
}

impl StaticPosition for SolverPosition<'_> {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        self.problem.no_load_approach(misalignment)
    }

    fn solve(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, ContactError> {
        let known = match prescribed {
            Prescribed::Torque(_) => [self.top.as_ref(), None],
            Prescribed::Approach(_) => [self.last.as_ref(), self.before.as_ref()],
        };
        let problem = &self.problem;
        let result = problem.resultant(prescribed, misalignment, known)?;
        let range = self.watched.and_then(|watched| watched.misalignments);
        let is_inside = !range.is_some_and(|range| is_beyond(range, misalignment));
        if let Some(failure) = result.excess.filter(|_| is_inside) {
            let contact = &problem.contact;
            return Err(contact.unsolved(prescribed, misalignment, failure).into());
        }
        if let Some(watched) = self.watched {
            let quality = &watched.quality;
            let mut sum = quality.lock().unwrap_or_else(PoisonError::into_inner);
            sum.solves += 1;
            sum.most_iterations = sum.most_iterations.max(result.iterations);
            sum.kkt_residual = sum.kkt_residual.max(result.kkt_residual);
        }
        let sample = Sample::from(&result);
        if let Prescribed::Torque(_) = prescribed {
            self.top = Some(result.clone());
        }
        let before = self.last.replace(result);
        self.before = before.filter(|before| before.misalignment == misalignment);
        Ok(sample)
    }
}

/// Called with the parts of a sweep that are done and their number, from any thread: columns of one centre distance and mesh position, or
/// lines of them.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// What `column` gives at each of `offsets` of the centre distance and each of the mesh `positions`, in parallel, in the order
/// of tables: the mesh position fastest.
pub(super) fn sweep_columns<S: Copy + Send>(
    [offsets, positions]: [&[f64]; 2],
    progress: Progress,
    column: impl Fn(f64, f64) -> Result<Vec<S>, TableError> + Sync,
) -> Result<Vec<S>, TableError> {
    let done = AtomicUsize::new(0);
    let np = positions.len();
    let total = offsets.len() * np;
    let columns = (0..total).into_par_iter().map(|k| {
        let column = column(offsets[k / np], positions[k % np])?;
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        Ok(column)
    });
    let columns: Vec<Vec<S>> = columns.collect::<Result<_, TableError>>()?;
    let in_order = columns.chunks(np).flat_map(|row| {
        (0..row[0].len()).flat_map(move |k| row.iter().map(move |column| column[k]))
    });
    Ok(in_order.collect())
}

/// Rows of `length` samples, one for each of `misalignments` (rad, ascending), which `row` fills. Where mid-face mirrors the pair, it is
/// not asked for those below zero whose opposite is among them: they become the opposite's, `mirrored`.
pub(super) fn rows_over_misalignment<S: Copy + Default>(
    misalignments: &[f64],
    is_mirrored: bool,
    length: usize,
    mirrored: impl Fn(&S) -> S,
    mut row: impl FnMut(f64, &mut [S]) -> Result<(), TableError>,
) -> Result<Vec<S>, TableError> {
    let largest = misalignments.iter().fold(0.0f64, |a, m| a.max(m.abs()));
    let mut rows = vec![S::default(); misalignments.len() * length];
    for (k, &m) in misalignments.iter().enumerate() {
        let mut others = misalignments.iter();
        let opposite = others.position(|other| (other + m).abs() <= 1e-12 * largest);
        let opposite = opposite.filter(|_| is_mirrored).unwrap_or(k);
        if opposite > k {
            continue;
        }
        let (below, here) = rows[..(k + 1) * length].split_at_mut(k * length);
        row(m, here)?;
        for (value, of) in below[opposite * length..].iter_mut().zip(here) {
            *value = mirrored(of);
        }
    }
    Ok(rows)
}

/// Solves at every node of `axes` for one flank: the displacements are imposed, so nothing is inverted.
/// The top load is `maximum_torque`, N m on gear 1.
///
/// # Errors
/// The first solve that fails, with its operating point.
pub fn sweep(
    source: &dyn StaticSource,
    flank: Flank,
    axes: &Axes,
    maximum_torque: f64,
    progress: Progress,
) -> Result<FlankGrid, TableError> {
    let [_, _, nu, np] = axes.lengths();
    let outer = [&axes.center_distance_offset[..], &axes.mesh_position];
    // For each misalignment first touch and displacements.
    let samples = sweep_columns(outer, progress, |c, p| {
        let mut position = (source.position(flank, p, c)).map_err(failed(flank, [c, 0.0, p]))?;
        let is_mirrored = source.is_mirrored_at_mid_face();
        let nodes = &axes.misalignment;
        rows_over_misalignment(
            nodes,
            is_mirrored,
            nu + 1,
            Sample::mirrored,
            |m, samples| {
                let low = position.no_load_approach(m);
                let top = (position.top(maximum_torque, m)).map_err(failed(flank, [c, m, p]))?;
                samples[0].approach = low;
                samples[nu] = top;
                // From the top down each solution starts from a near one; the top itself is known.
                for k in (0..nu - 1).rev() {
                    let delta = low + axes.displacement_fraction[k] * (top.approach - low);
                    let solved = position.solve(Prescribed::Approach(delta), m);
                    samples[k + 1] = solved.map_err(failed(flank, [c, m, p]))?;
                }
                Ok(())
            },
        )
    })?;
    // Of all `samples` in the order of the table, those with the indices `rows` of a column.
    let rows = |rows: std::ops::Range<usize>| {
        let blocks = samples.chunks((nu + 1) * np);
        blocks.flat_map(move |block| &block[rows.start * np..rows.end * np])
    };
    let loaded = rows(1..nu + 1);
    let sliding = source.friction().map(|law| {
        let sliding: Vec<Sliding> = loaded.clone().map(|s| s.sliding).collect();
        SlidingSamples::new(&sliding, law.is_local())
    });
    Ok(FlankGrid {
        axes: axes.clone(),
        no_load_approach: rows(0..1).map(|s| s.approach).collect(),
        top_load_approach: rows(nu..nu + 1).map(|s| s.approach).collect(),
        loa_force: loaded.clone().map(|s| s.loa_force).collect(),
        moment: Some(loaded.map(|s| s.moment).collect()),
        sliding,
    })
}

/// What an error becomes of a solve that failed at (centre distance offset, misalignment, mesh position).
pub(super) fn failed<E: Display>(flank: Flank, [c, m, p]: [f64; 3]) -> impl Fn(E) -> TableError {
    move |error| {
        let [c, m] = [1e6 * c, 1e3 * m].map(rounded);
        TableError::Failed(format!(
            "the operating range of the pair file cannot be covered: static solve at {flank:?} flank, center_distance_offset_um {c}, misalignment_mrad {m}, mesh_position {p}: {error}"
        ))
    }
}
