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
        let ends = |axis: &[f64]| [axis[0], axis[axis.len() - 1]];
        let axes = &file.axes;
        assert_eq!(
            ends(&axes.center_distance_offset),
            operating.center_distance_offset
        );
        // Misalignment goes on beyond its limits, so that the moment is right at them.
        let [low, high] = operating.misalignment;
        assert_eq!(ends(&axes.misalignment), [1.6 * low, 1.6 * high]);
        assert_eq!(file.coast.is_none(), pair.coast_mirrors_drive(), "{name}");
        let error = file.interpolation_error.expect("measured when made");
        let force = error.force_rms < 2e-3 && error.force_maximum < 1.5e-2;
        let moment = error.moment_rms < 4e-3 && error.moment_maximum < 3e-2;
        assert!(error.points >= 1000 && force && moment, "{name}: {error:?}");

        let setting = |key: &str| file.solver[key].as_f64().unwrap();
        assert_eq!(file.solver["elastic_model"], "finite elements, normal");
        assert!(setting("contact_solves") > file.drive.loa_force.len() as f64);
        assert!(setting("most_newton_steps") <= 12.0);
        // Solves of tables end with a step along the tangents of their laws.
        assert!(setting("largest_kkt_residual") < 1e-5, "{name}");
    }
}

/// Errors over the nominal force of `table` against fresh solutions at independent random points: of the force, and of the moment at
/// an end of the face.
fn fresh_errors(pair: &Pair, solver: &ContactSolver, table: &FlankTable) -> Vec<[f64; 3]> {
    let (geometry, operating) = (&pair.geometry, &pair.operating);
    let nominal = operating.nominal_torque / geometry.gears[0].base_radius();
    let mut random = Random::new(7);
    let error = |_| {
        let [c, m] = [operating.center_distance_offset, operating.misalignment]
            .map(|range| random.within(range));
        let (p, torque) = (random.next(), operating.maximum_torque * random.next());
        let position = solver.position(Flank::Drive, p, c).unwrap();
        let exact = position.solve_torque(torque, m, None).unwrap();
        let query = Query::from([exact.approach, c, m, p]);
        let [force, _, moment, _] = table.evaluate(&query, false).gradient;
        let half_face = 0.5 * geometry.face_overlap().1;
        [
            (force - exact.loa_force) / nominal,
            (moment - exact.moment) / (nominal * half_face),
            exact.loa_force / nominal,
        ]
    };
    (0..400).map(error).collect()
}

/// Solutions of today's pair file, modifications included, at points that had no part in the tables.
#[test]
fn each_agrees_with_fresh_solutions_within_its_stated_error() {
    for name in TABLES {
        let (file, pair) = shipped(name);
        let settings = Settings::for_pair(&pair);
        let solver = solver(&pair, &settings, None, contact_settings(&pair));
        let found = |interpolation| {
            let table = FlankTable::new(&file.drive.on(&file.axes), interpolation).unwrap();
            InterpolationError::of(&fresh_errors(&pair, &solver, &table))
        };
        let stated = file.interpolation_error.unwrap();
        let spline = found(Interpolation::Spline);
        assert!(
            (spline.force_rms / stated.force_rms - 1.0).abs() < 0.3
                && spline.force_maximum < 1.2 * stated.force_maximum
                && (spline.moment_rms / stated.moment_rms - 1.0).abs() < 0.2,
            "{name}: {spline:?}, stated {stated:?}"
        );
        assert!(spline.force_rms < found(Interpolation::Linear).force_rms);
    }
}
