//! Pairs, their solvers, operating points that no table has seen, and tables.

#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/gears.rs"]
mod gears;

use crate::{Result, in_repository};
use gearmesh::contact::{ContactFile, ContactSettings, Prescribed};
use gearmesh::gear::{Flank, GearKind, PairGeometry};
use gearmesh::random::Random;
use gearmesh::table::{Axes, FlankGrid, Query, Table, TableFile, TeethRecord};
use gearmesh_preprocessor::compliance::ToothCompliance;
use gearmesh_preprocessor::contact::{
    CycleInput, ElasticModels, LoadCase, MeshCycle, ModelSettings, contact_file,
};
use gearmesh_preprocessor::finite_element::{ModelCache, PairCompliance, Settings};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::static_contact::{ContactResult, ContactSolver};
use gearmesh_preprocessor::table::{
    Coverage, TeethSweep, default_teeth_axes, displacement_nodes, mesh_positions, sweep,
};
use gears::{gear, paper_pair, thinned};
use rayon::prelude::*;
use std::sync::Arc;

/// The pairs in resources/pairs.
pub const SHIPPED: [&str; 5] = [
    "palermo2013",
    "palermo2013-unmodified",
    "fzg-c",
    "helical-25-47",
    "planet-ring-27-84",
];

/// The pair file resources/pairs/`name`.json.
pub fn shipped(name: &str) -> Result<Pair> {
    Ok(pair::read(in_repository(&format!(
        "resources/pairs/{name}.json"
    )))?)
}

/// The same at another level of refinement.
pub fn shipped_at(name: &str, refinement: Refinement) -> Result<Pair> {
    Ok(Pair {
        refinement,
        ..shipped(name)?
    })
}

/// The paper's pair, each tooth thinned by 30 um on the base circle, and a ring of 61 teeth as its gear 2.
pub fn external_and_internal() -> [PairGeometry; 2] {
    let external = gear(GearKind::External, 20, 1.0, 13.0, 0.0);
    let ring = gear(GearKind::Ring, 61, 1.0, 13.0, 0.0);
    let center_distance = ring.reference_radius() - external.reference_radius();
    let gears = [external, ring];
    let internal = PairGeometry {
        gears,
        center_distance,
    };
    [paper_pair(1.0), internal].map(|pair| thinned(pair, 30e-6))
}

/// Angle of gear 2 over that of gear 1 in mesh.
pub fn ratio(pair: &PairGeometry) -> f64 {
    -pair.e() * pair.gears[0].z() / pair.gears[1].z()
}

/// Elastic models of `pair` with `settings`, cached in target/finite-elements.
pub fn models(pair: &Pair, settings: &Settings) -> Result<PairCompliance> {
    Ok(PairCompliance::new(
        &pair.geometry,
        settings,
        Some(&cache()),
        &|_, _, _| true,
    )?)
}

/// Where elastic models are kept.
pub fn cache() -> ModelCache {
    let folder = in_repository("target/finite-elements");
    ModelCache::new(folder, ModelCache::DEFAULT_LIMIT)
}

/// Solver of `pair` on `models`.
pub fn solver(
    pair: &Pair,
    models: &PairCompliance,
    contact: ContactSettings,
) -> Result<ContactSolver> {
    let gears = models.gears.clone();
    let compliance = gears.map(|gear| gear as Arc<dyn ToothCompliance>);
    Ok(ContactSolver::new(pair, compliance, contact)?)
}

/// A mesh cycle of the drive flank at nominal centre distance with parallel axes: mean and peak-to-peak STE, um.
pub fn ste(solver: &ContactSolver, torque: f64, positions: usize) -> Result<[f64; 2]> {
    let input = CycleInput {
        flank: Flank::Drive,
        center_distance_offset: 0.0,
        positions,
    };
    let load = LoadCase {
        torque,
        misalignment: 0.0,
    };
    let cycle = MeshCycle::solve(solver, &input, load)?;
    Ok([1e6 * cycle.mean_ste(), 1e6 * cycle.peak_to_peak_ste()])
}

/// The point at `delta` (m) and the mesh position `tau`, else nominal.
pub fn query(delta: f64, tau: f64) -> Query {
    Query::from([delta, 0.0, 0.0, tau])
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
    /// `pair` as `gearmesh build` has it, or with so many `stations` along the face.
    pub fn new(pair: Pair, stations: Option<usize>) -> Result<Self> {
        let settings = ModelSettings {
            stations,
            cache: Some(cache()),
            ..ModelSettings::default()
        };
        let ElasticModels { pair, solver, .. } = ElasticModels::new(&pair, &settings, &|_, _| ())?;
        Ok(Self { pair, solver })
    }

    /// What an FMU packs for contact at run time.
    pub fn contact_file(&self) -> Result<ContactFile> {
        Ok(contact_file(
            &self.pair,
            &self.solver.clone().at_run_time(),
        )?)
    }

    /// What an FMU packs for tooth pairs one by one, measured at so many random `points`.
    pub fn teeth_record(&self, contact: &ContactFile, points: usize) -> Result<TeethRecord> {
        let coverage = self.coverage();
        let sweep = TeethSweep {
            solver: &self.solver,
            contact,
            coverage: &coverage,
            coast_mirrors_drive: true,
            friction: false,
        };
        Ok(sweep.record(&default_teeth_axes(&coverage), points, &|_, _| ())?)
    }

    /// Nominal transverse force on the line of action, N: what errors are related to.
    pub fn nominal_force(&self) -> f64 {
        self.pair.operating.nominal_torque / self.pair.geometry.gears[0].base_radius()
    }

    /// Half the common face width, m.
    pub fn half_face(&self) -> f64 {
        0.5 * self.pair.geometry.face_overlap().1
    }

    /// The nominal torque at the mesh position `tau`, parallel axes.
    pub fn nominal(&self, tau: f64) -> Result<ContactResult> {
        self.solve(self.pair.operating.nominal_torque, &query(0.0, tau))
    }

    /// The whole operating range.
    pub fn coverage(&self) -> Coverage {
        Coverage::new(&self.pair, true, true)
    }

    /// A random operating point of the drive flank: the torque, N m, from a tenth of the largest one on, and the pose.
    pub fn draw(&self, random: &mut Random) -> (f64, Query) {
        let operating = &self.pair.operating;
        let offset = random.within(operating.center_distance_offset);
        let misalignment = random.within(operating.misalignment);
        let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
        let tau = random.within([0.0, 1.0]);
        (torque, Query::from([0.0, offset, misalignment, tau]))
    }

    /// Contact under `torque` at `query`, of which the approach follows.
    pub fn solve(&self, torque: f64, query: &Query) -> Result<ContactResult> {
        let [_, offset, misalignment, tau] = query.coordinates();
        let position = self.solver.position(Flank::Drive, tau, offset)?;
        Ok(position.solve_torque(torque, misalignment, None)?)
    }

    /// Direct solutions at `n` random points of the operating range.
    pub fn exact(&self, n: usize) -> Result<Vec<Exact>> {
        let operating = &self.pair.operating;
        let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
        let mut draw = |_| {
            let torque = random.within([0.0, operating.maximum_torque]);
            let offset = random.within(operating.center_distance_offset);
            let misalignment = random.within(operating.misalignment);
            (
                torque,
                Query::from([0.0, offset, misalignment, random.next()]),
            )
        };
        self.exact_at((0..n).map(&mut draw).collect())
    }

    /// Direct solutions under torques (N m) at points of which the approach follows, beyond the operating range, too.
    pub fn exact_at(&self, points: Vec<(f64, Query)>) -> Result<Vec<Exact>> {
        let solve = |(torque, query): (f64, Query)| {
            let [_, offset, misalignment, tau] = query.coordinates();
            let position = self.solver.position(Flank::Drive, tau, offset)?;
            let solved = position.solve_beyond(Prescribed::Torque(torque), misalignment, None)?;
            let (delta, force, moment) = (solved.approach, solved.loa_force, solved.moment);
            let query = Query { delta, ..query };
            Ok(Exact {
                query,
                force,
                moment,
            })
        };
        points.into_par_iter().map(solve).collect()
    }

    /// The default axes thinned to `counts` (displacement, centre distance, misalignment, mesh position) nodes; 1 leaves
    /// an axis out.
    pub fn axes(&self, counts: [usize; 4]) -> Axes {
        let coverage = self.coverage();
        let along = |n: usize, nodes: &dyn Fn(usize) -> Vec<f64>| match n {
            1 => vec![0.0],
            _ => nodes(n),
        };
        Axes {
            displacement_fraction: displacement_nodes(counts[0], 1.6),
            center_distance_offset: along(counts[1], &|n| coverage.offsets(n)),
            misalignment: along(counts[2], &|n| coverage.graded_misalignments(n, 2.0)),
            mesh_position: mesh_positions(counts[3]),
        }
    }

    /// Samples on [`Self::axes`].
    pub fn samples(&self, counts: [usize; 4]) -> Result<FlankGrid> {
        let torque = self.pair.operating.maximum_torque;
        let axes = self.axes(counts);
        Ok(sweep(
            &self.solver,
            Flank::Drive,
            &axes,
            torque,
            &|_, _| (),
        )?)
    }

    /// A tables file around `grid`.
    pub fn file(&self, grid: &FlankGrid) -> TableFile {
        let pair = &self.pair;
        let operating = &pair.operating;
        let torques = [operating.nominal_torque, operating.maximum_torque];
        TableFile::new(
            &pair.name,
            "validation",
            &pair.geometry,
            torques,
            grid,
            None,
        )
    }

    /// The same as a table.
    pub fn table(&self, grid: &FlankGrid) -> Result<Arc<Table>> {
        Ok(Arc::new(Table::from_file(self.file(grid))?))
    }
}
