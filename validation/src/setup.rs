//! Pairs, their solvers, operating points that no table has seen, and tables.

#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/gears.rs"]
mod gears;

use crate::data::even;
use crate::{Result, in_repository};
use gearmesh::compliance::ToothCompliance;
use gearmesh::contact::{ContactFile, ContactSettings, ContactSolver};
use gearmesh::gear::{Flank, GearKind, PairGeometry};
use gearmesh::pair::{Pair, Refinement};
use gearmesh::random::Random;
use gearmesh::table::{Axes, FlankGrid, Query, Table, TableFile};
use gearmesh_preprocessor::contact::contact_file;
use gearmesh_preprocessor::contact::{CycleInput, MeshCycle};
use gearmesh_preprocessor::finite_element::{ModelCache, PairCompliance, Settings};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{Coverage, Watch, default_axes, displacement_nodes, mesh_positions, sweep};
use gears::{gear, paper_pair, thinned};
use rayon::prelude::*;
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The pairs in resources/pairs.
pub const SHIPPED: [&str; 5] = ["palermo2013", "palermo2013-unmodified", "fzg-c", "helical-25-47", "planet-ring-27-84"];

/// The pair file resources/pairs/`name`.json.
pub fn shipped(name: &str) -> Result<Pair> {
    Ok(pair::read(in_repository(&format!("resources/pairs/{name}.json")))?)
}

/// The same at another level of refinement.
pub fn shipped_at(name: &str, refinement: Refinement) -> Result<Pair> {
    Ok(Pair { refinement, ..shipped(name)? })
}

/// The paper's pair, each tooth thinned by 30 um on the base circle, and a ring of 61 teeth as its gear 2.
pub fn external_and_internal() -> [PairGeometry; 2] {
    let gears = [gear(GearKind::External, 20, 1.0, 13.0, 0.0), gear(GearKind::Ring, 61, 1.0, 13.0, 0.0)];
    let center_distance = gears[1].reference_radius() - gears[0].reference_radius();
    [paper_pair(1.0), PairGeometry { gears, center_distance }].map(|pair| thinned(pair, 30e-6))
}

/// Elastic models computed so far in this run.
#[derive(Default)]
pub struct Models(RefCell<Vec<(PairGeometry, Settings, PairCompliance)>>);

impl Models {
    /// The models of `pair` with `settings`.
    pub fn get(&self, pair: &Pair, settings: &Settings) -> Result<PairCompliance> {
        let known = self.0.borrow().iter().find(|k| k.0 == pair.geometry && k.1 == *settings).map(|k| k.2.clone());
        if let Some(models) = known {
            return Ok(models);
        }
        let models = compute(pair, settings)?;
        self.0.borrow_mut().push((pair.geometry.clone(), *settings, models.clone()));
        Ok(models)
    }

    /// Solver of `pair` at its level of refinement.
    pub fn solver(&self, pair: &Pair) -> Result<ContactSolver> {
        solver(pair, &self.get(pair, &Settings::for_pair(pair))?, ContactSettings::for_pair(pair))
    }
}

/// Elastic models of both gears, computed here.
pub fn compute(pair: &Pair, settings: &Settings) -> Result<PairCompliance> {
    Ok(PairCompliance::new(&pair.geometry, settings, None, &|_, _, _| true)?)
}

/// Solver of `pair` on `models`.
pub fn solver(pair: &Pair, models: &PairCompliance, contact: ContactSettings) -> Result<ContactSolver> {
    let compliance = models.gears.clone().map(|gear| gear as Arc<dyn ToothCompliance>);
    Ok(ContactSolver::new(pair, compliance, contact)?)
}

/// A mesh cycle of the drive flank at nominal centre distance with parallel axes: mean and peak-to-peak STE, um.
pub fn ste(solver: &ContactSolver, torque: f64, positions: usize) -> Result<[f64; 2]> {
    let flank = Flank::Drive;
    let input = CycleInput { flank, torque, center_distance_offset: 0.0, misalignment: 0.0, positions };
    let cycle = MeshCycle::solve(solver, &input)?;
    Ok([1e6 * cycle.mean_ste(), 1e6 * cycle.peak_to_peak_ste()])
}

/// A sweep that nobody watches.
pub fn quiet() -> Watch<'static> {
    static GO_ON: AtomicBool = AtomicBool::new(false);
    Watch { progress: &|_, _| (), cancel: &GO_ON }
}

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
pub struct Setup {
    pub pair: Pair,
    pub solver: ContactSolver,
}

impl Setup {
    /// `pair` on finite elements that are computed here, its contact discretised by `contact`.
    pub fn new(pair: Pair, contact: ContactSettings) -> Result<Self> {
        let solver = solver(&pair, &compute(&pair, &Settings::for_pair(&pair))?, contact)?;
        Ok(Self { pair, solver })
    }

    /// The shipped pair `name` on elements whose models are kept in target/finite-elements, and what a unit packs of its
    /// contact.
    pub fn packed(name: &str) -> Result<(Self, ContactFile)> {
        let pair = shipped(name)?;
        let setup = Self::kept(pair)?;
        let file = contact_file(&setup.pair, &setup.solver.clone().at_run_time())?;
        Ok((setup, file))
    }

    /// `pair` on elements whose models are kept in target/finite-elements.
    pub fn kept(pair: Pair) -> Result<Self> {
        let cache = ModelCache::new(in_repository("target/finite-elements"), ModelCache::DEFAULT_LIMIT);
        let settings = Settings::for_pair(&pair);
        let models = PairCompliance::new(&pair.geometry, &settings, Some(&cache), &|_, _, _| true)?;
        let solver = solver(&pair, &models, ContactSettings::for_pair(&pair))?;
        Ok(Self { pair, solver })
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
    pub fn exact(&self, ranges: &Ranges, n: usize) -> Result<Vec<Exact>> {
        let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
        let Ranges { torque, center_distance_offset, misalignment, mesh_position } = *ranges;
        let mut point = || [torque, center_distance_offset, misalignment, mesh_position].map(|r| random.within(r));
        let points: Vec<[f64; 4]> = (0..n).map(|_| point()).collect();
        let solve = |[torque, c, m, p]: [f64; 4]| {
            let solved = self.solver.position(Flank::Drive, p, c)?.solve_torque(torque, m, None)?;
            let delta = solved.approach;
            let query = Query { delta, center_distance_offset: c, misalignment: m, mesh_position: p };
            Ok(Exact { query, force: solved.loa_force, moment: solved.moment })
        };
        points.into_par_iter().map(solve).collect()
    }

    /// Samples with `counts` (displacement, centre distance, misalignment, mesh position) nodes, of the default axes;
    /// 1 leaves an axis out.
    pub fn samples(&self, counts: [usize; 4]) -> Result<FlankGrid> {
        let full = default_axes(&self.coverage());
        let thinned = |nodes: &[f64], n: usize| -> Vec<f64> {
            match n {
                1 => vec![0.0],
                _ => nodes.iter().copied().step_by((nodes.len() - 1) / (n - 1)).collect(),
            }
        };
        self.sweep(counts, thinned(&full.center_distance_offset, counts[1]), thinned(&full.misalignment, counts[2]))
    }

    /// Samples with evenly spaced centre distances and misalignments over the whole range.
    pub fn even_samples(&self, counts: [usize; 4]) -> Result<FlankGrid> {
        let operating = &self.pair.operating;
        let [c, m] = [operating.center_distance_offset, operating.misalignment];
        self.sweep(counts, even(c, counts[1]), even(m, counts[2]))
    }

    fn sweep(&self, counts: [usize; 4], center_distance_offset: Vec<f64>, misalignment: Vec<f64>) -> Result<FlankGrid> {
        let axes = Axes {
            displacement_fraction: displacement_nodes(counts[0], 1.6),
            center_distance_offset,
            misalignment,
            mesh_position: mesh_positions(counts[3]),
        };
        Ok(sweep(&self.solver, Flank::Drive, &axes, self.pair.operating.maximum_torque, &quiet())?)
    }

    /// A tables file around `grid`.
    pub fn file(&self, grid: &FlankGrid) -> TableFile {
        let operating = &self.pair.operating;
        let torques = [operating.nominal_torque, operating.maximum_torque];
        TableFile::new(&self.pair.name, "validation", &self.pair.geometry, torques, grid, None)
    }

    /// The same as a table.
    pub fn table(&self, grid: &FlankGrid) -> Result<Arc<Table>> {
        Ok(Arc::new(Table::from_file(self.file(grid))?))
    }
}
