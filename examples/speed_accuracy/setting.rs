//! The pair, its solver, its samples, and operating points that no table has seen.

use crate::document::Error;
use gearmesh::compliance::finite_element::{PairCompliance, Settings};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::random::Random;
use gearmesh::table::plan::{Coverage, default_axes, displacement_nodes, mesh_positions};
use gearmesh::table::sweep::{Watch, sweep};
use gearmesh::table::{Axes, Axis, FlankGrid, Query, TableFile};
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

/// Ranges of random operating points: torque N m, centre distance offset m, misalignment rad, mesh position.
#[derive(Debug, Clone, Copy)]
pub struct Ranges {
    pub torque: [f64; 2],
    pub center_distance_offset: [f64; 2],
    pub misalignment: [f64; 2],
    pub mesh_position: [f64; 2],
}

/// One solution of the contact solver: at `query.delta` the force and the shuttling moment are these.
#[derive(Debug, Clone, Copy)]
pub struct Exact {
    pub query: Query,
    pub force: f64,
    pub moment: f64,
}

/// A pair and its solver.
pub struct Setting {
    pub pair: Pair,
    pub solver: ContactSolver,
}

impl Setting {
    /// The pair file at `path` on finite elements, computed here.
    pub fn new(path: &str, refinement: Refinement) -> Result<Self, Error> {
        let pair = Pair {
            refinement,
            ..Pair::read(path)?
        };
        let settings = ContactSettings {
            tip_corner_contact: pair.tip_corner_contact,
            ..ContactSettings::default()
        };
        Self::of(pair, settings)
    }

    /// `pair` on finite elements, computed here, its contact discretised by `contact`.
    pub fn of(pair: Pair, contact: ContactSettings) -> Result<Self, Error> {
        let settings = Settings::for_pair(&pair);
        let [first, second] =
            PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)?.gears;
        let solver = ContactSolver::new(&pair, [first, second], contact)?;
        Ok(Setting { pair, solver })
    }

    /// Nominal transverse force on the line of action, N: what errors are related to.
    pub fn nominal_force(&self) -> f64 {
        self.pair.operating.nominal_torque / self.pair.geometry.gears[0].base_radius()
    }

    /// Half the common face width, m.
    pub fn half_face(&self) -> f64 {
        0.5 * self.pair.geometry.face_overlap().1
    }

    /// The whole operating range in the first `dimensions` of displacement, mesh position,
    /// misalignment, centre distance; the others nominal.
    pub fn ranges(&self, dimensions: usize) -> Ranges {
        let operating = &self.pair.operating;
        let on = |d: usize, range: [f64; 2]| if dimensions >= d { range } else { [0.0; 2] };
        Ranges {
            torque: [0.0, operating.maximum_torque],
            center_distance_offset: on(4, operating.center_distance_offset),
            misalignment: on(3, operating.misalignment),
            mesh_position: on(2, [0.0, 1.0]),
        }
    }

    /// The whole operating range.
    pub fn coverage(&self) -> Coverage {
        let operating = &self.pair.operating;
        Coverage {
            center_distance_offset: Some(operating.center_distance_offset),
            misalignment: Some(operating.misalignment),
            nominal_torque: operating.nominal_torque,
            maximum_torque: operating.maximum_torque,
        }
    }

    /// Direct solutions at `n` random points of `ranges`.
    pub fn exact(&self, ranges: &Ranges, n: usize) -> Result<Vec<Exact>, Error> {
        let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
        let points: Vec<[f64; 4]> = (0..n)
            .map(|_| {
                [
                    random.within(ranges.torque),
                    random.within(ranges.center_distance_offset),
                    random.within(ranges.misalignment),
                    random.within(ranges.mesh_position),
                ]
            })
            .collect();
        points
            .into_par_iter()
            .map(|[torque, c, m, p]| {
                let solved = self
                    .solver
                    .position(Flank::Drive, p, c)?
                    .solve_torque(torque, m, None)?;
                Ok(Exact {
                    query: Query {
                        delta: solved.approach,
                        center_distance_offset: c,
                        misalignment: m,
                        mesh_position: p,
                    },
                    force: solved.loa_force,
                    moment: solved.moment,
                })
            })
            .collect()
    }

    /// Samples with `counts` (displacement, centre distance, misalignment, mesh position) nodes; 1 leaves
    /// an axis out.
    pub fn samples(&self, counts: [usize; 4]) -> Result<FlankGrid, Error> {
        let full = default_axes(&self.coverage());
        let thinned = |nodes: &[f64], n: usize| -> Vec<f64> {
            if n == 1 {
                return vec![0.0];
            }
            let step = (nodes.len() - 1) / (n - 1);
            nodes.iter().copied().step_by(step).collect()
        };
        let axes = Axes {
            displacement_fraction: displacement_nodes(counts[0], 1.6),
            center_distance_offset: thinned(&full.center_distance_offset, counts[1]),
            misalignment: thinned(&full.misalignment, counts[2]),
            mesh_position: mesh_positions(counts[3]),
        };
        let cancel = AtomicBool::new(false);
        let watch = Watch {
            progress: &|_, _| {},
            cancel: &cancel,
        };
        Ok(sweep(
            &self.solver,
            Flank::Drive,
            &axes,
            self.pair.operating.maximum_torque,
            &watch,
        )?)
    }

    /// A tables file around `grid`.
    pub fn file(&self, grid: &FlankGrid) -> TableFile {
        let operating = &self.pair.operating;
        TableFile::new(
            &self.pair.name,
            "speed_accuracy",
            &self.pair.geometry,
            [operating.nominal_torque, operating.maximum_torque],
            grid,
            None,
        )
    }
}

/// Every `step`-th node of `grid` along (displacement, centre distance, misalignment, mesh position),
/// ends kept; a step of 0 takes the nominal node alone.
pub fn thinned(grid: &FlankGrid, steps: [usize; 4]) -> FlankGrid {
    let axes = [
        Axis::Displacement,
        Axis::CenterDistance,
        Axis::Misalignment,
        Axis::MeshPosition,
    ];
    let mut thin = grid.clone();
    for (axis, step) in axes.into_iter().zip(steps) {
        let nodes = thin.axes.along_mut(axis).clone();
        let nominal = (0..nodes.len()).min_by(|&i, &j| nodes[i].abs().total_cmp(&nodes[j].abs()));
        // The last displacement, the top load, is the one that must stay.
        let first = if axis == Axis::Displacement {
            step - 1
        } else {
            0
        };
        let chosen: Vec<usize> = match step {
            0 => nominal.into_iter().collect(),
            _ => (first..nodes.len()).step_by(step).collect(),
        };
        thin = thin.with_nodes(axis, &chosen);
    }
    thin
}
