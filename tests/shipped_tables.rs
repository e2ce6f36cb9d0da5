//! The tables that are shipped: whole, as accurate as they say, and of the pairs beside them.
use gearmesh::contact::ContactSettings;
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::table::{FlankTable, Interpolation, TableFile};
use gearmesh_preprocessor::finite_element::Settings;
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{Coverage, measure};

#[path = "common/solver.rs"]
mod solver;
use solver::solver;

const PAIRS: [&str; 4] = ["fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84"];

/// Reading verifies the checksum.
fn tables(name: &str) -> TableFile {
    let resources = concat!(env!("CARGO_MANIFEST_DIR"), "/resources");
    TableFile::read(format!("{resources}/tables/{name}.json")).unwrap()
}

fn pair(name: &str) -> Pair {
    let resources = concat!(env!("CARGO_MANIFEST_DIR"), "/resources");
    pair::read(format!("{resources}/pairs/{name}.json")).unwrap()
}

#[test]
fn each_has_its_pairs_geometry_and_range_and_the_error_that_was_asked_for() {
    for name in PAIRS {
        let (file, pair) = (tables(name), pair(name));
        assert_eq!(file.name, pair.name);
        assert_eq!(file.geometry, pair.geometry, "{name}");
        assert_eq!(file.maximum_torque_nm, pair.operating.maximum_torque);
        assert_eq!(file.nominal_torque_nm, pair.operating.nominal_torque);
        let ends = |axis: &[f64]| [axis[0], axis[axis.len() - 1]];
        assert_eq!(ends(&file.axes.misalignment), pair.operating.misalignment);
        assert_eq!(
            ends(&file.axes.center_distance_offset),
            pair.operating.center_distance_offset
        );
        assert_eq!(file.coast.is_none(), pair.coast_mirrors_drive(), "{name}");
        let error = file.interpolation_error.expect("measured when made");
        assert!(
            error.points >= 1000 && error.force_rms < 2e-3 && error.force_maximum < 1.5e-2,
            "{name}: {error:?}"
        );
        assert!(
            error.moment_rms < 4e-3 && error.moment_maximum < 3e-2,
            "{name}: {error:?}"
        );
    }
}

#[test]
fn no_solve_of_theirs_came_near_a_limit_of_iterations() {
    for name in PAIRS {
        let file = tables(name);
        let setting = |key: &str| file.solver[key].as_f64().unwrap();
        assert_eq!(file.solver["elastic_model"], "finite elements, normal");
        let nodes = file.drive.loa_force.len() as f64;
        assert!(setting("contact_solves") > nodes, "{name}");
        assert!(
            setting("most_newton_steps") < 0.2 * setting("newton_steps_allowed"),
            "{name}"
        );
        assert!(setting("largest_kkt_residual") < 1e-8, "{name}");
    }
}

/// Fresh solutions of today's pair file, modifications included, at points that had no part in the tables.
#[test]
fn each_agrees_with_fresh_solutions_within_its_stated_error() {
    for name in PAIRS {
        let (file, pair) = (tables(name), pair(name));
        let settings = Settings::for_pair(&pair);
        let solver = solver(&pair, &settings, None, ContactSettings::for_pair(&pair));
        let coverage = Coverage {
            // Just inside the ranges: other random points than those of the error in the file.
            center_distance_offset: Some(pair.operating.center_distance_offset.map(|c| 0.97 * c)),
            misalignment: Some(pair.operating.misalignment.map(|m| 0.97 * m)),
            nominal_torque: pair.operating.nominal_torque,
            maximum_torque: 0.97 * pair.operating.maximum_torque,
        };
        let found = |interpolation| {
            let table = FlankTable::new(&file.drive_grid(), interpolation).unwrap();
            let (geometry, flank) = (&pair.geometry, Flank::Drive);
            measure(&solver, geometry, flank, &coverage, &table, 100).unwrap()
        };
        let stated = file.interpolation_error.unwrap();
        let spline = found(Interpolation::Spline);
        assert!(
            spline.force_rms < 1.5 * stated.force_rms
                && spline.force_maximum < 1.2 * stated.force_maximum
                && spline.moment_rms < 1.5 * stated.moment_rms,
            "{name}: {spline:?}, stated {stated:?}"
        );
        assert!(spline.force_rms < found(Interpolation::Linear).force_rms);
    }
}
