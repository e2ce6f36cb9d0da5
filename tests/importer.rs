//! A packed FMU driven by the importer of the crate `fmi`: a host of another family than fmpy.

use gearmesh_preprocessor::pair;
use std::path::Path;

use ::fmi::fmi2::import::Fmi2Import;
use ::fmi::fmi2::instance::{CoSimulation, Common};
use ::fmi::traits::FmiStatus;
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::pair::Pair;
use gearmesh_preprocessor::package::{self, Contents, Starts};

/// Packs the FMU of a shipped pair, with constant stiffness, into `folder` and imports it.
fn import(pair: &str, folder: &Path) -> (Pair, Fmi2Import) {
    let file = format!("{}/resources/pairs/{pair}.json", env!("CARGO_MANIFEST_DIR"));
    let pair = pair::read(file).unwrap();
    let starts = Starts::constant_stiffness(&pair.geometry, pair.operating.nominal_torque);
    let contents = Contents {
        name: &pair.name,
        geometry: &pair.geometry,
        tables: None,
        contact: None,
        starts: &starts,
    };
    // The library that cargo built for this test is in the folder of the test's program.
    let libraries = package::libraries_beside(&std::env::current_exe().unwrap()).unwrap();
    let fmu = folder.join("pair.fmu");
    package::pack(&contents, &libraries, &fmu).unwrap();
    (pair, ::fmi::import::from_path(&fmu).unwrap())
}

fn reference(i: usize) -> u32 {
    VARIABLES[i].value_reference
}

#[test]
fn the_importer_drives_two_pairs_at_once() {
    let folder = tempfile::tempdir().unwrap();
    for (name, turn) in [("palermo2013", 1e-3), ("planet-ring-27-84", 2e-3)] {
        let (pair, unit) = import(name, folder.path());
        let mut one = unit.instantiate_cs("one", false, true).unwrap();
        let mut other = unit.instantiate_cs("other", false, true).unwrap();
        assert_eq!(one.get_version(), "2.0");
        for instance in [&mut one, &mut other] {
            instance.setup_experiment(None, 0.0, None).unwrap();
            instance.enter_initialization_mode().unwrap();
            let damping = [reference(index::DAMPING)];
            instance.set_real(&damping, &[0.0]).unwrap();
            instance.exit_initialization_mode().unwrap();
        }
        let spin = [reference(index::GEAR1_ANGLES_3)];
        one.set_real(&spin, &[turn]).unwrap();
        one.do_step(0.0, 1e-5, true).unwrap();
        other.do_step(0.0, 1e-5, true).unwrap();
        let outputs = [
            index::MESH_TRANSMISSION_ERROR,
            index::GEAR1_MOMENT_3,
            index::GEAR2_MOMENT_3,
            index::MESH_STIFFNESS,
        ]
        .map(reference);
        let mut values = [0.0; 4];
        one.get_real(&outputs, &mut values).unwrap();
        let [error, moment1, moment2, stiffness] = values;

        let geometry = &pair.geometry;
        let radius = geometry.operating_pitch_radius(0, geometry.center_distance);
        assert!((error - turn * radius).abs() < 1e-12, "{error}");
        let expected = -stiffness * error * radius;
        assert!(
            (moment1 / expected - 1.0).abs() < 1e-9,
            "{moment1} {expected}"
        );
        let ratio = geometry.e() * geometry.gears[1].z() / geometry.gears[0].z();
        assert!((moment2 / moment1 / ratio - 1.0).abs() < 1e-10);
        // The other instance has not moved.
        other.get_real(&outputs, &mut values).unwrap();
        assert!(values[0].abs() < 1e-15);
    }
}

#[test]
fn the_importer_keeps_and_carries_states() {
    let folder = tempfile::tempdir().unwrap();
    let (_, unit) = import("palermo2013", folder.path());
    let mut one = unit.instantiate_cs("one", false, true).unwrap();
    one.setup_experiment(None, 0.0, None).unwrap();
    one.enter_initialization_mode().unwrap();
    one.exit_initialization_mode().unwrap();
    let (spin, moment) = (
        [reference(index::GEAR1_ANGLES_3)],
        [reference(index::GEAR1_MOMENT_3)],
    );
    one.set_real(&spin, &[1e-4]).unwrap();
    one.do_step(0.0, 1e-5, true).unwrap();
    let state = one.get_fmu_state().unwrap();
    let bytes = one.serialize_fmu_state(&state).unwrap();
    let mut before = [0.0];
    one.get_real(&moment, &mut before).unwrap();

    let mut other = unit.instantiate_cs("other", false, true).unwrap();
    let carried = other.deserialize_fmu_state(&bytes).unwrap();
    other.set_fmu_state(&carried).ok().unwrap();
    let mut after = [0.0];
    other.get_real(&moment, &mut after).unwrap();
    assert_eq!(before, after);
    assert_ne!(before[0], 0.0);
    other.do_step(1e-5, 1e-5, true).unwrap();
}
