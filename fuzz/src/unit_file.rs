//! The file of a unit with its pair and start values: refused, or a unit that goes with numbers, or refuses to.

use gearmesh_preprocessor::pair;
use std::sync::Arc;

use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::{Function, Interface};
use gearmesh::fmi::resources::{Resources, UNIT_VERSION, UnitFile, parse_unit};
use gearmesh::fmi::variables::{FIRST_PARAMETER, INPUTS, Kind, VARIABLES, index};
use gearmesh::gear::PairGeometry;

use super::{Target, accepted, change};

/// Units of constant stiffness, external and internal.
pub const TARGET: Target = Target {
    seeds: || {
        let pairs = [
            include_str!("../../resources/pairs/helical-25-47.json"),
            include_str!("../../resources/pairs/planet-ring-27-84.json"),
        ];
        let geometry = |text| pair::from_json(text).expect("a shipped pair").geometry;
        let units = pairs.map(|text| unit("constant", geometry(text), &[]));
        units
            .map(|unit| serde_json::to_vec(&unit).expect("JSON"))
            .to_vec()
    },
    change: change::json,
    check,
};

/// Both.
pub const INTERFACES: [Interface; 2] = [Interface::CoSimulation, Interface::ModelExchange];

/// A unit of `geometry`, whose gears start in contact, with `starts` beside that.
pub fn unit(name: &str, geometry: PairGeometry, starts: &[(&str, f64)]) -> UnitFile {
    let touching = [("gear2.position[1]", geometry.center_distance)];
    let starts = starts.iter().chain(&touching);
    UnitFile {
        version: UNIT_VERSION,
        guid: "{00000000-0000-0000-0000-000000000001}".into(),
        name: name.into(),
        starts: starts
            .map(|(name, value)| ((*name).to_owned(), *value))
            .collect(),
        geometry,
    }
}

/// See [`Target::check`].
pub fn check(data: &[u8]) -> bool {
    let read = parse_unit(data).and_then(|unit| Resources::new(unit, None, None));
    accepted(read, |resources| run(&Arc::new(resources)))
}

/// A start, turned a little, and two steps through both interfaces: numbers, or refusals.
pub fn run(resources: &Arc<Resources>) {
    for interface in INTERFACES {
        let mut instance = Instance::new(Arc::clone(resources), interface);
        if instance.setup(0.0, None).is_err() || instance.exit_initialization().is_err() {
            continue;
        }
        let turned = [VARIABLES[index::GEAR1_ANGLES_3].value_reference];
        for step in 0..3 {
            outputs(&mut instance);
            let angle = [2e-4 * f64::from(step)];
            if instance.set(Kind::Real, &turned, &angle).is_err() {
                break;
            }
            outputs(&mut instance);
            if instance.admit(Function::fmi2DoStep).is_ok()
                && instance.do_step(instance.time(), 1e-5).is_err()
            {
                break;
            }
        }
    }
}

/// Every output is a number, or refused.
pub fn outputs(instance: &mut Instance) {
    if instance.admit(Function::fmi2GetReal).is_err() {
        return;
    }
    for variable in &VARIABLES[INPUTS..FIRST_PARAMETER] {
        let finite = |x: &[f64]| assert!(x[0].is_finite(), "{} = {}", variable.name, x[0]);
        if let Err(refusal) = instance.get(Kind::Real, &[variable.value_reference], finite) {
            assert!(!refusal.message.is_empty());
        }
    }
}
