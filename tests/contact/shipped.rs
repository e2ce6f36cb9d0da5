//! The tables that are shipped: whole, as accurate as they say, and of the pairs beside them.

use super::*;

/// Tables and pair of this name; reading verifies the checksum.
fn shipped(name: &str) -> (TableFile, Pair) {
    let pair = pair::read(format!("{RESOURCES}/pairs/{name}.json"));
    (tables(name), pair.unwrap())
}

#[test]
fn each_has_its_pairs_geometry_and_range_the_error_that_was_asked_for_and_solves_far_from_a_limit()
{
    for name in TABLES {
        let (file, pair) = shipped(name);
        assert_eq!((&file.name, &file.geometry), (&pair.name, &pair.geometry));
        let operating = &pair.operating;
        assert_eq!(file.maximum_torque_nm, operating.maximum_torque);
        assert_eq!(file.nominal_torque_nm, operating.nominal_torque);
        for (axis, range) in [
            (&file.axes.misalignment, operating.misalignment),
            (
                &file.axes.center_distance_offset,
                operating.center_distance_offset,
            ),
        ] {
            assert_eq!([axis[0], axis[axis.len() - 1]], range);
        }
        assert_eq!(file.coast.is_none(), pair.coast_mirrors_drive(), "{name}");
        let error = file.interpolation_error.expect("measured when made");
        let force = error.force_rms < 2e-3 && error.force_maximum < 1.5e-2;
        let moment = error.moment_rms < 4e-3 && error.moment_maximum < 3e-2;
        assert!(error.points >= 1000 && force && moment, "{name}: {error:?}");

        let setting = |key: &str| file.solver[key].as_f64().unwrap();
        assert_eq!(file.solver["elastic_model"], "finite elements, normal");
        assert!(setting("contact_solves") > file.drive.loa_force.len() as f64);
        assert!(setting("most_newton_steps") < 0.2 * setting("newton_steps_allowed"));
        assert!(setting("largest_kkt_residual") < 1e-8, "{name}");
    }
}

/// Fresh solutions of today's pair file, modifications included, at points that had no part in the tables.
#[test]
fn each_agrees_with_fresh_solutions_within_its_stated_error() {
    for name in TABLES {
        let (file, pair) = shipped(name);
        let settings = Settings::for_pair(&pair);
        let solver = solver(&pair, &settings, None, contact_settings(&pair));
        let coverage = Coverage {
            // Just inside the ranges: other random points than those of the error in the file.
            center_distance_offset: Some(pair.operating.center_distance_offset.map(|c| 0.97 * c)),
            misalignment: Some(pair.operating.misalignment.map(|m| 0.97 * m)),
            nominal_torque: pair.operating.nominal_torque,
            maximum_torque: 0.97 * pair.operating.maximum_torque,
        };
        let found = |interpolation| {
            let table = FlankTable::new(&file.drive.on(&file.axes), interpolation).unwrap();
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
