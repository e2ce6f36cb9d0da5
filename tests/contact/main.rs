//! Claims about contact on real pairs: solved on finite elements, at run time, in tables and in the element.

#[path = "../common/element.rs"]
mod element;
#[path = "../common/fzg.rs"]
mod fzg;
#[path = "../common/gears.rs"]
mod gears;
#[path = "../common/solver.rs"]
mod solver;

mod energy;
mod file;
mod flanks;
mod levels;
mod mechanics;
mod paper;
mod realistic;
mod root_stress;
mod runtime;
mod shaft;
mod shipped;
mod sliding;
mod symmetry;
mod teeth;
mod tilt;
mod tooth_pairs;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use gearmesh::contact::*;
use gearmesh::friction::{FrictionLaw, Loss, Sliding, loss_factor_of};
use gearmesh::gear::*;
use gearmesh::random::Random;
use gearmesh::root::{bisection, bracket};
use gearmesh::table::*;
use gearmesh_preprocessor::contact::*;
use gearmesh_preprocessor::finite_element::{ModelCache, RootStress, Settings, pair_root_stress};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::static_contact::*;
use gearmesh_preprocessor::table::*;
use serde_json::{Value, json};
use solver::{QUIET, coarse_solver, solver, with_stations};
use std::f64::consts::TAU;
use std::sync::{Arc, LazyLock};

const PAPER: &str = include_str!("../../resources/pairs/palermo2013.json");
const UNMODIFIED: &str = include_str!("../../resources/pairs/palermo2013-unmodified.json");
const HELICAL: &str = include_str!("../../resources/pairs/helical-25-47.json");
const RING: &str = include_str!("../../resources/pairs/planet-ring-27-84.json");
const SPUR: &str = include_str!("../../resources/pairs/fzg-c.json");

const RESOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/resources");

/// Names of the shipped tables, which are those of their pairs.
const TABLES: [&str; 4] = ["fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84"];

fn tables(name: &str) -> TableFile {
    TableFile::read(format!("{RESOURCES}/tables/{name}.json")).unwrap()
}

/// The pair file of a reduction gear with a steep helix, a long path of contact and faces of these widths, mm, for a nominal torque in N m.
fn reduction(faces: [f64; 2], torque: f64) -> Value {
    let gear = |teeth: u32, face: f64, bore: f64| {
        json!({
            "teeth": teeth, "face_width_mm": face, "bore_diameter_mm": bore, "addendum_coefficient": 1.2,
            "dedendum_coefficient": 1.5, "tool_tip_radius_coefficient": 0.3,
        })
    };
    let mut file = json!({
        "name": "reduction", "meshing": "external", "normal_module_mm": 1.75, "normal_pressure_angle_deg": 17.5,
        "helix_angle_deg": 29.5, "backlash_um": 90.0, "face_offset_mm": 0.5 * (faces[0] - faces[1]),
        "gear1": gear(23, faces[0], 28.0), "gear2": gear(81, faces[1], 60.0),
        "operating": {
            "nominal_torque_nm": torque, "maximum_torque_nm": 2.0 * torque,
            "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [-0.5, 0.5],
        },
    });
    file["gear1"]["profile_shift"] = 0.3.into();
    file["gear1"]["lead_crowning_um"] = 4.0.into();
    file
}

/// `geometry` without modifications, with the operating range of the paper's pair.
fn pair_of(geometry: PairGeometry) -> Pair {
    Pair {
        geometry,
        ..pair::from_json(UNMODIFIED).unwrap()
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn rms(errors: &[f64]) -> f64 {
    let squares = errors.iter().map(|error| error * error);
    (squares.sum::<f64>() / errors.len() as f64).sqrt()
}

/// Slope at zero of `values` over steps of this size, of fourth order.
fn slope(step: f64, values: impl Fn(f64) -> f64) -> f64 {
    let side = |h: f64| values(h * step) - values(-h * step);
    (8.0 * side(1.0) - side(2.0)) / (12.0 * step)
}

/// The largest size of `errors`.
fn most(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |most, error| error.abs().max(most))
}

fn mesh_cycle(
    solver: &ContactSolver,
    torque: f64,
    misalignment: f64,
    positions: usize,
) -> MeshCycle {
    let input = CycleInput {
        flank: Flank::Drive,
        center_distance_offset: 0.0,
        positions,
    };
    let load = LoadCase {
        torque,
        misalignment,
    };
    MeshCycle::solve(solver, &input, load).unwrap()
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
