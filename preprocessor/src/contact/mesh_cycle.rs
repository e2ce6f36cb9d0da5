//! Quasi-static contact over one mesh cycle.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use gearmesh::contact::{ContactError, ContactResult, ContactSolver, EdgeLoad, SegmentLoad};
use gearmesh::friction::{FrictionLaw, Sliding};
use gearmesh::gear::Flank;
use gearmesh::words::count;

/// Loaded segments along a contact line that tell its largest pressure to some 4 %; two of them tell it 25 % too low.
pub const ENOUGH_SEGMENTS: usize = 6;

/// Where a mesh cycle is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleInput {
    /// Loaded flank of gear 1.
    pub flank: Flank,
    /// Torque on gear 1, N m, >= 0.
    pub torque: f64,
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Misalignment in the plane of action, rad.
    pub misalignment: f64,
    /// Number of equidistant positions, from 0 on.
    pub positions: usize,
}

/// One mesh cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCycle {
    /// Mesh positions i / N, base pitches.
    pub mesh_position: Vec<f64>,
    /// The solution at each.
    pub results: Vec<ContactResult>,
    /// How the load slides at each, every segment counted alike.
    pub sliding: Vec<Sliding>,
    /// The same with the weights of the pair's law of friction.
    pub friction: Vec<Sliding>,
    /// What every segment carries at each.
    pub loads: Vec<Vec<SegmentLoad>>,
    /// Wall clock of the whole cycle, s; of cycles that were solved together their mean.
    pub solve_seconds: f64,
}

/// One load at one position.
struct Solved {
    result: ContactResult,
    loads: Vec<SegmentLoad>,
    sliding: Sliding,
    friction: Sliding,
}

/// A load at which a mesh cycle is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadCase {
    /// Torque on gear 1, N m, >= 0.
    pub torque: f64,
    /// Misalignment in the plane of action, rad.
    pub misalignment: f64,
}

impl MeshCycle {
    /// Solves all positions, in parallel.
    ///
    /// # Errors
    /// [`ContactError::Input`] for no positions, else the first error of a position.
    pub fn solve(solver: &ContactSolver, input: &CycleInput) -> Result<MeshCycle, ContactError> {
        let case = LoadCase {
            torque: input.torque,
            misalignment: input.misalignment,
        };
        let mut cycles = MeshCycle::solve_all(solver, input, &[case], &|_| ())?;
        cycles.pop().ok_or(ContactError::Input {
            field: "load cases",
            value: 0.0,
            remedy: "give at least 1",
        })
    }

    /// Solves `cases` in place of the load of `input`, a cycle for each in their order: the influence matrix of
    /// a position serves all of them. `progress` is told the share that is done, from any thread.
    ///
    /// # Errors
    /// As [`MeshCycle::solve`].
    pub fn solve_all(
        solver: &ContactSolver,
        input: &CycleInput,
        cases: &[LoadCase],
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<MeshCycle>, ContactError> {
        let n = input.positions;
        if n == 0 {
            return Err(ContactError::Input {
                field: "positions",
                value: 0.0,
                remedy: "give at least 1; 21 or more for ten harmonics",
            });
        }
        let begin = Instant::now();
        let mesh_position: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
        let done = AtomicUsize::new(0);
        let even = FrictionLaw::default();
        let solved = mesh_position
            .par_iter()
            .map(|&tau| {
                let at = solver.position(input.flank, tau, input.center_distance_offset)?;
                let mut results: Vec<ContactResult> = Vec::with_capacity(cases.len());
                for case in cases {
                    // The case before is a near one.
                    let warm = results.last();
                    results.push(at.solve_torque(case.torque, case.misalignment, warm)?);
                    let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                    progress(count as f64 / (n * cases.len()) as f64);
                }
                Ok(results
                    .into_iter()
                    .map(|result| Solved {
                        loads: at.segment_loads(&result),
                        sliding: solver.sliding(&at, &result, &even),
                        friction: solver.sliding(&at, &result, solver.friction()),
                        result,
                    })
                    .collect())
            })
            .collect::<Result<Vec<Vec<_>>, ContactError>>()?;
        let solve_seconds = begin.elapsed().as_secs_f64() / cases.len().max(1) as f64;
        let mut cycles: Vec<MeshCycle> = cases
            .iter()
            .map(|_| MeshCycle {
                mesh_position: mesh_position.clone(),
                results: Vec::with_capacity(n),
                loads: Vec::with_capacity(n),
                sliding: Vec::with_capacity(n),
                friction: Vec::with_capacity(n),
                solve_seconds,
            })
            .collect();
        for position in solved {
            for (cycle, solved) in cycles.iter_mut().zip(position) {
                cycle.results.push(solved.result);
                cycle.loads.push(solved.loads);
                cycle.sliding.push(solved.sliding);
                cycle.friction.push(solved.friction);
            }
        }
        Ok(cycles)
    }

    /// STE at each position, m on the line of action at mid-face.
    pub fn ste(&self) -> Vec<f64> {
        self.results.iter().map(|r| r.approach).collect()
    }

    /// Mean STE, m.
    pub fn mean_ste(&self) -> f64 {
        self.ste().iter().sum::<f64>() / self.results.len() as f64
    }

    /// Highest minus lowest STE, m.
    pub fn peak_to_peak_ste(&self) -> f64 {
        let ste = self.ste();
        ste.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - ste.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Mean of z_c, m in gear 1's frame.
    pub fn mean_contact_z(&self) -> f64 {
        self.results.iter().map(|r| r.contact_z).sum::<f64>() / self.results.len() as f64
    }

    /// Largest Hertz pressure of the cycle inside the flanks, Pa.
    pub fn max_pressure(&self) -> f64 {
        self.results
            .iter()
            .map(|r| r.max_pressure)
            .fold(0.0, f64::max)
    }

    /// Largest line load of the cycle at a tip edge, if contact reaches one.
    pub fn edge_load(&self) -> Option<EdgeLoad> {
        let loads = self.results.iter().filter_map(|r| r.edge_load);
        loads.reduce(|a, b| if b.line_load > a.line_load { b } else { a })
    }

    /// What rests on fewer than [`ENOUGH_SEGMENTS`] loaded segments of a contact line, and comes out too low for it; None where nothing does.
    pub fn note_on_segments(&self) -> Option<String> {
        let mut fewest = ENOUGH_SEGMENTS;
        let mut values = Vec::new();
        let pressure: fn(&SegmentLoad) -> f64 = |segment| segment.pressure;
        let edge: fn(&SegmentLoad) -> f64 =
            |segment| segment.edge.map_or(0.0, |edge| edge.line_load);
        for (of, name) in [
            (pressure, "the largest flank pressure"),
            (edge, "the largest line load at a tip edge"),
        ] {
            let all = self.loads.iter();
            let all =
                all.flat_map(|segments| segments.iter().map(move |segment| (segments, segment)));
            let top = all.max_by(|a, b| of(a.1).total_cmp(&of(b.1)));
            let Some((segments, top)) = top.filter(|(_, top)| of(top) > 0.0) else {
                continue;
            };
            let line = segments.iter().filter(|s| s.tooth_pair == top.tooth_pair);
            let loaded = line.filter(|segment| segment.force > 0.0).count();
            if loaded < ENOUGH_SEGMENTS {
                values.push(name);
                fewest = fewest.min(loaded);
            }
        }
        (!values.is_empty()).then(|| {
            format!(
                "{}: from only {} of a contact line ({ENOUGH_SEGMENTS} are enough), so too low; give more --stations",
                values.join(" and "),
                count(fewest, "loaded segment"),
            )
        })
    }

    /// Largest KKT residual of the cycle.
    pub fn kkt_residual(&self) -> f64 {
        self.results
            .iter()
            .map(|r| r.kkt_residual)
            .fold(0.0, f64::max)
    }
}
