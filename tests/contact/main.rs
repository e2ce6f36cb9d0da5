//! Claims about static contact and contact at run time, on real pairs with coarse finite elements.

#[path = "../common/fzg.rs"]
mod fzg;
#[path = "../common/gears.rs"]
mod gears;
#[path = "../common/solver.rs"]
mod solver;

mod file;
mod flanks;
mod mechanics;
mod paper;
mod root_stress;
mod runtime;
mod sliding;
mod symmetry;
mod teeth;
mod tilt;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use gearmesh::contact::*;
use gearmesh::gear::{Flank, PairTeeth, ToothErrors};
use gearmesh::pair::{Pair, Refinement};
use gearmesh::random::Random;
use gearmesh_preprocessor::contact::*;
use gearmesh_preprocessor::finite_element::{RootStress, Settings, pair_root_stress};
use gearmesh_preprocessor::pair;
use solver::{coarse_solver, with_stations};
use std::sync::Arc;

const PAPER: &str = include_str!("../../resources/pairs/palermo2013.json");
const UNMODIFIED: &str = include_str!("../../resources/pairs/palermo2013-unmodified.json");
const HELICAL: &str = include_str!("../../resources/pairs/helical-25-47.json");
const RING: &str = include_str!("../../resources/pairs/planet-ring-27-84.json");
const SPUR: &str = include_str!("../../resources/pairs/fzg-c.json");

fn mesh_cycle(
    solver: &ContactSolver,
    torque: f64,
    misalignment: f64,
    positions: usize,
) -> MeshCycle {
    let input = CycleInput {
        flank: Flank::Drive,
        torque,
        center_distance_offset: 0.0,
        misalignment,
        positions,
    };
    MeshCycle::solve(solver, &input).unwrap()
}

/// The elastic models of the tooth roots of `pair` on coarse finite elements.
fn root_models(pair: &Pair, flank: Flank) -> [Arc<RootStress>; 2] {
    let coarse = Pair {
        refinement: Refinement::Coarse,
        ..pair.clone()
    };
    let settings = Settings::for_pair(&coarse);
    let models = pair_root_stress(&pair.geometry, flank, &settings, None, &|_, _, _| true);
    models.unwrap().gears
}

/// A pair, its solver on coarse finite elements and what `flank` is condensed to.
struct Ready {
    pair: Pair,
    solver: ContactSolver,
    flank: Flank,
    condensed: Arc<CondensedFlank>,
}

impl Ready {
    fn new(text: &str, flank: Flank, solver: impl Fn(&Pair) -> ContactSolver) -> Ready {
        let pair = pair::from_json(text).unwrap();
        let solver = solver(&pair);
        let [low, high] = pair.operating.center_distance_offset;
        let condensed = condensed_flank(&solver, flank, &[low, 0.5 * (low + high), high]);
        Ready {
            condensed: Arc::new(condensed.unwrap()),
            pair,
            solver,
            flank,
        }
    }

    /// Its contact at run time with the tooth errors of gear 1 and gear 2 on the drive flank.
    fn with_errors(&self, drive: [ToothErrors; 2]) -> RuntimeContact {
        let setup = ContactSetup {
            teeth: PairTeeth {
                drive,
                ..PairTeeth::default()
            },
            ..self.solver.setup().clone()
        };
        RuntimeContact::new(Arc::new(setup), self.condensed.clone(), self.flank)
    }

    /// The same with teeth that are alike.
    fn alike(&self) -> RuntimeContact {
        self.with_errors(Default::default())
    }
}

/// The potential at the pose `at`, solved from no other.
fn ask(contact: &RuntimeContact, at: [f64; 4], counts: [i64; 2]) -> ContactPotential {
    contact.potential(at, counts, &mut Warm::default()).unwrap()
}
