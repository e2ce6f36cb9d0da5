use super::*;
use crate::package::{Starts, shipped_tables};
use gearmesh::fmi::resources::UNIT_VERSION;

const SWEEP: Sweep = Sweep {
    inertia: [4e-3; 2],
    damping_ratio: 0.03,
    torque: 100.0,
    speeds: [200.0, 1000.0],
    duration: Some(0.05),
    step: None,
};

fn unit(tables: &TableFile) -> UnitFile {
    let geometry = tables.geometry.clone();
    let mut starts = Starts::of_tables(tables).unwrap().of_variables(&geometry);
    starts.insert("backlash".into(), 80e-6);
    UnitFile {
        version: UNIT_VERSION,
        guid: String::new(),
        name: "pair".into(),
        starts,
        geometry,
    }
}

fn run(sweep: &Sweep) -> Result<RunUp, Refusal> {
    let tables = shipped_tables("palermo2013");
    sweep.run(&unit(&tables), Some(&tables), None, [None, None], &|_| {})
}

#[test]
fn the_teeth_carry_the_mean_torque_on_either_flank_at_every_speed() {
    for torque in [100.0, -100.0] {
        let run = run(&Sweep { torque, ..SWEEP }).unwrap();
        for history in [&run.up, &run.down] {
            let force = &history.tangential_force;
            let quarter = &force[force.len() / 2..];
            let mean = quarter.iter().sum::<f64>() / quarter.len() as f64;
            let radius = 0.5 * 82.104e-3;
            assert!((mean * radius / 100.0 - 1.0).abs() < 0.02, "{mean}");
        }
        let sign = torque.signum();
        let errors = run.up.transmission_error.iter();
        assert!(
            errors
                .skip(run.up.time.len() / 2)
                .all(|error| sign * error > 0.0)
        );
    }
}

#[test]
fn bearings_bear_on_average_what_the_mean_torque_loads_them_with() {
    let tables = shipped_tables("palermo2013");
    // Gear 1 in the middle between two bearings, and beside both of them.
    for (places, shares) in [
        ([-0.05, 0.075], [0.5, 0.5]),
        ([-0.15, -0.05], [0.625, 1.625]),
    ] {
        let bearing = |z| crate::gear::Bearing {
            z,
            radial_stiffness: 1e9,
            axial_stiffness: 1e8,
            tilt_stiffness: 0.0,
            free_radius: 0.0,
        };
        let shaft = crate::gear::Shaft {
            start: -0.15,
            sections: vec![crate::gear::ShaftSection {
                radii: [0.0, 0.015],
                length: 0.25,
            }],
            bearings: places.map(bearing).into(),
            torque_at_upper_end: false,
            youngs_modulus: 206e9,
            poisson_ratio: 0.3,
            seat: [0.0, 0.025],
            seat_radius: 0.015,
        };
        let geometry = &tables.geometry;
        let shares_of_shaft = BearingShares::new(&shaft, &geometry.gears[0]);
        let run = SWEEP
            .run(
                &unit(&tables),
                Some(&tables),
                None,
                [shares_of_shaft, None],
                &|_| {},
            )
            .unwrap();
        let force = 100.0 / geometry.gears[0].base_radius();
        // The axial force on the pitch radius adds to the moment.
        let lean = geometry.base_helix_angle().tan();
        let span = places[1] - places[0];
        let couple = force * lean * 0.5 * 82.104e-3 / span;
        let phi = geometry.operating_pressure_angle(geometry.center_distance);
        for (k, share) in shares.into_iter().enumerate() {
            let radial = [1.0, -1.0].map(|sign| {
                let x = force * share * phi.sin() + sign * couple;
                x.hypot(force * share * phi.cos())
            });
            let history = &run.up.bearing_force[0][k];
            let half = &history[history.len() / 2..];
            let mean = half.iter().sum::<f64>() / half.len() as f64;
            assert!(
                radial.iter().any(|right| (mean / right - 1.0).abs() < 0.02),
                "{k}: {mean} {radial:?}"
            );
        }
        assert!(run.up.bearing_force[1].is_empty());
    }
}

#[test]
fn a_constant_stiffness_rings_at_its_natural_frequency() {
    let tables = shipped_tables("palermo2013");
    let mut unit = unit(&tables);
    unit.starts.insert("stiffnessModel".into(), 1.0);
    let sweep = Sweep {
        speeds: [0.0, 1e-6],
        duration: Some(0.02),
        ..SWEEP
    };
    let resources = Arc::new(Resources::new(unit.clone(), None, None).unwrap());
    let run = sweep.run(&unit, None, None, [None, None], &|_| {}).unwrap();
    // Let go without load, both discs swing about the equilibrium.
    let pitch: [f64; 2] = [0.5 * 82.104e-3; 2];
    let stiffness = run.natural_frequency.powi(2) * TAU.powi(2) / (2.0 * pitch[0].powi(2) / 4e-3);
    let mut discs = Discs::new(&resources, &sweep, stiffness, pitch, run.step).unwrap();
    discs.offset = [0.0; 2];
    let history = discs.sweep([0.0, 0.0], 0.02, &|_| {}).unwrap();
    let error = &history.transmission_error;
    let static_error = 100.0 / pitch[0] / stiffness;
    let crossings = error
        .windows(2)
        .filter(|w| w[0] < static_error && w[1] >= static_error);
    let expected = 0.02 * run.natural_frequency;
    assert!(
        (crossings.count() as f64 - expected).abs() <= 1.0,
        "{expected}"
    );
}

#[test]
fn what_cannot_be_swept_is_refused_with_its_value() {
    for (sweep, part) in [
        (
            Sweep {
                speeds: [100.0, 50.0],
                ..SWEEP
            },
            "100",
        ),
        (
            Sweep {
                inertia: [f64::INFINITY; 2],
                ..SWEEP
            },
            "inf",
        ),
        (
            Sweep {
                torque: 0.0,
                ..SWEEP
            },
            "torque 0",
        ),
        (
            Sweep {
                damping_ratio: f64::NAN,
                ..SWEEP
            },
            "NaN",
        ),
        (
            Sweep {
                damping_ratio: 0.0,
                duration: None,
                ..SWEEP
            },
            "decays",
        ),
        (
            Sweep {
                duration: Some(1e4),
                ..SWEEP
            },
            "steps",
        ),
        (
            Sweep {
                step: Some(1.0),
                ..SWEEP
            },
            "step 1 s",
        ),
        (
            Sweep {
                step: Some(1e-4),
                ..SWEEP
            },
            "rad of the natural frequency",
        ),
        (
            Sweep {
                torque: -1e4,
                ..SWEEP
            },
            "the tables end at",
        ),
    ] {
        let refusal = run(&sweep).unwrap_err();
        assert!(refusal.message.contains(part), "{}", refusal.message);
    }
}
