//! Claims about tooth pairs one by one (`stiffnessModel = teeth`), on a real pair with coarse finite elements.

use super::*;
use gearmesh_preprocessor::gear::tolerance::random_index_errors;

/// That of the pair file.
const MISALIGNMENT: [f64; 2] = [-3e-3, 3e-3];

/// A pair on coarse finite elements, and its contact at run time as a file has it.
pub(super) struct Ready {
    pub(super) pair: Pair,
    pub(super) solver: ContactSolver,
    pub(super) coverage: Coverage,
    pub(super) contact: ContactFile,
}

impl Ready {
    pub(super) fn new(pair: Pair, settings: ContactSettings, tilt: Option<[f64; 2]>) -> Self {
        let solver = coarse_solver(&pair, settings);
        let contact = contact_file(&pair, &solver).unwrap();
        Ready {
            contact: ContactFile::from_bytes(&contact.to_bytes()).unwrap(),
            coverage: Coverage {
                center_distance_offset: None,
                misalignment: tilt,
                nominal_torque: pair.operating.nominal_torque,
                maximum_torque: pair.operating.maximum_torque,
            },
            pair,
            solver,
        }
    }

    fn axes(&self) -> Axes {
        Axes {
            displacement_fraction: displacement_nodes(10, 1.6),
            ..default_teeth_axes(&self.coverage)
        }
    }

    pub(super) fn record(&self, axes: &Axes, points: usize) -> TeethRecord {
        let sweep = TeethSweep {
            solver: &self.solver,
            contact: &self.contact,
            coverage: &self.coverage,
            coast_mirrors_drive: true,
            friction: true,
        };
        sweep.record(axes, points, QUIET).unwrap()
    }
}

/// The paper's pair with class 6 errors on gear 1 and run-out of gear 2.
static READY: LazyLock<Ready> = LazyLock::new(|| {
    let mut pair = pair::from_json(PAPER).unwrap();
    let (amount, angle) = (10e-6, 0.4);
    let mut errors = [ToothErrors::default(), ToothErrors::default()];
    errors[0].index = random_index_errors(&pair.geometry.gears[0], 6, 1);
    errors[1].runout = Some(Runout { amount, angle });
    pair.teeth = PairTeeth {
        drive: errors.clone(),
        coast: errors,
    };
    Ready::new(pair, with_stations(12), Some(MISALIGNMENT))
});

static RECORD: LazyLock<TeethRecord> = LazyLock::new(|| READY.record(&READY.axes(), 400));

const EFFECTS: Effects = Effects {
    interpolation: Interpolation::Spline,
    load: Load::Variable,
    center_distance: false,
    misalignment: true,
    shuttling: true,
    friction: false,
    root_stress: false,
    teeth: true,
};

fn level(record: &TeethRecord) -> TeethFlank {
    TeethFlank::new(record, &READY.pair.geometry, Flank::Drive, &EFFECTS).unwrap()
}

fn alike() -> TeethRecord {
    TeethRecord {
        drive_errors: Default::default(),
        coast_errors: Default::default(),
        ..RECORD.clone()
    }
}

/// Approaches from before the first touch up to nearly that of the largest load.
fn query(random: &mut Random) -> Query {
    let share = random.next();
    let misalignment = random.within(MISALIGNMENT);
    let tilt = misalignment.abs();
    let [low, high] = [-5e-6 - 1e-2 * tilt, 20e-6 - 3e-3 * tilt];
    let turn = random.within([-200.0, 200.0]);
    Query::from([low + share * (high - low), 0.0, misalignment, turn])
}

/// Mesh cycles of both gears at which levels are compared.
const CYCLES: [i64; 2] = [3, -2];

/// Contact at run time there.
fn exact(contact: &RuntimeContact, q: &Query) -> ContactPotential {
    ask(contact, q.coordinates(), CYCLES)
}

/// Nominal force, N, and moment of it at an end of the face, N m.
fn nominal() -> [f64; 2] {
    let geometry = &READY.pair.geometry;
    let force = READY.coverage.nominal_torque / geometry.gears[0].base_radius();
    [force, 0.5 * force * geometry.face_overlap().1]
}

#[test]
fn the_force_with_class_6_errors_is_that_of_contact_at_run_time() {
    let error = RECORD.error;
    assert_eq!(error.points, 400);
    // What the record says is what is found at other points.
    let level = level(&RECORD);
    let contact = READY.contact.flank(Flank::Drive).unwrap();
    let (mut random, scales) = (Random::new(5), nominal());
    let mut errors = [vec![], vec![]];
    for _ in 0..300 {
        let q = query(&mut random);
        let (found, exact) = (level.evaluate(&q, CYCLES, false), exact(&contact, &q));
        for (i, k) in [0, 2].into_iter().enumerate() {
            errors[i].push((found.gradient[k] - exact.gradient[k]) / scales[i]);
        }
    }
    let [force, moment] = errors.map(|errors| rms(&errors));
    for rms in [force, error.force_rms, moment, error.moment_rms] {
        assert!(rms < 1e-2, "{force} {moment} {error:?}");
    }
    assert!(force < 1.5 * error.force_rms, "{force} {error:?}");
}

#[test]
fn the_loss_with_class_6_errors_is_that_of_contact_at_run_time() {
    let effects = Effects {
        friction: true,
        ..EFFECTS
    };
    let geometry = &READY.pair.geometry;
    let level = TeethFlank::new(&RECORD, geometry, Flank::Drive, &effects).unwrap();
    let contact = READY.contact.flank(Flank::Drive).unwrap().with_friction();
    let mut random = Random::new(11);
    for misalignment in [[-3e-3, -5e-4], [-5e-4, 5e-4], [5e-4, 3e-3]] {
        for load in [0.05, 0.3, 0.7, 1.1] {
            // Sum of the distances that the load slides by, on average 1 to 2 mm.
            let (mut found, mut known, mut n) = (0.0, 0.0, 0);
            while n < 100 {
                let mut q = query(&mut random);
                q.misalignment = random.within(misalignment);
                let (w, sliding) = level.evaluate_sliding(&q, CYCLES, false);
                if !(load..2.0 * load).contains(&(w.gradient[0] / nominal()[0])) {
                    continue;
                }
                found += sliding.distance;
                known += exact(&contact, &q).sliding.distance;
                n += 1;
            }
            let error = found / known - 1.0;
            assert!(error.abs() < 0.02, "{misalignment:?} {load}: {error}");
        }
    }
}

#[test]
fn under_small_loads_the_transmission_error_is_that_of_contact_at_run_time() {
    let level = level(&READY.record(&default_teeth_axes(&READY.coverage), 1));
    let contact = READY.contact.flank(Flank::Drive).unwrap();
    let mut random = Random::new(6);
    for part in [0.1, 0.25] {
        let force = part * nominal()[0];
        let error = |_| {
            let mesh_position = random.within([-200.0, 200.0]);
            let approach = |carried: &dyn Fn(&Query) -> f64| {
                bisection([-60e-6, 60e-6], 40, |delta| {
                    carried(&Query::from([delta, 0.0, 0.0, mesh_position])) < force
                })
            };
            let found = approach(&|q| level.evaluate(q, CYCLES, false).gradient[0]);
            1e6 * (found - approach(&|q| exact(&contact, q).gradient[0]))
        };
        let errors: Vec<f64> = (0..200).map(error).collect();
        let (bias, most) = (mean(&errors), most(&errors));
        assert!(bias.abs() < 0.02 && most < 0.04, "{part}: {bias} {most} um");
    }
}

/// The record of a pair file with few nodes.
fn record_of(text: &str) -> TeethRecord {
    let nodes = vec![-5e-4, -2e-4, 0.0, 2e-4, 5e-4];
    let (pair, ends) = (pair::from_json(text).unwrap(), [nodes[0], nodes[4]]);
    let ready = Ready::new(pair, with_stations(16), Some(ends));
    let axes = Axes {
        misalignment: nodes,
        ..ready.axes()
    };
    ready.record(&axes, 200)
}

#[test]
fn spur_teeth_of_a_short_path_of_contact_are_told_one_by_one() {
    // Approach and recess are shorter than a base pitch each.
    let record = record_of(SPUR);
    assert_eq!(record.coupling_m_per_n.len(), 1);
    assert!(record.error.force_rms < 5e-3, "{:?}", record.error);
}

#[test]
fn tooth_pairs_on_a_soft_body_share_it_however_far_they_are_apart() {
    // Of a narrow reduction gear with a long path of contact on a small bore.
    let record = record_of(&reduction([14.0, 13.0], 75.0).to_string());
    let rows = &record.coupling_m_per_n;
    assert!(rows[1][2] > 0.9 * rows[0][2], "{rows:?}");
    assert!(record.error.force_rms < 1e-2, "{:?}", record.error);
}

/// The table of all teeth alike with so many mesh positions.
fn swept(positions: usize) -> FlankGrid {
    let axes = Axes {
        mesh_position: mesh_positions(positions),
        ..READY.axes()
    };
    let torque = READY.coverage.maximum_torque;
    sweep(&READY.solver, Flank::Drive, &axes, torque, QUIET).unwrap()
}

#[test]
fn equal_teeth_carry_what_the_table_of_all_teeth_says() {
    let level = level(&alike());
    let table = FlankTable::new(&swept(32), Interpolation::Spline).unwrap();
    let (solver, geometry) = (&READY.solver, &READY.pair.geometry);
    let (flank, coverage) = (Flank::Drive, &READY.coverage);
    let of_table = measure(solver, geometry, flank, coverage, &table, 200);
    let stated = RECORD.error.force_rms + of_table.unwrap().force_rms;
    let mut random = Random::new(6);
    let differences: Vec<f64> = (0..1000)
        .map(|_| {
            let q = query(&mut random);
            let [a, b] = [level.evaluate(&q, [0; 2], false), table.evaluate(&q, false)];
            (a.gradient[0] - b.gradient[0]) / nominal()[0]
        })
        .collect();
    let rms = rms(&differences);
    assert!(rms < stated, "{rms} {stated}");
}

/// With bodies that deflect: tooth pairs two and three base pitches apart take of each other, too, by the misalignment.
fn on_soft_bodies() -> TeethRecord {
    let mut record = RECORD.clone();
    let misalignments = &record.axes.misalignment;
    let row = |c: f64| {
        misalignments
            .iter()
            .map(|m| c * (1.0 + 1e4 * m * m))
            .collect()
    };
    record.coupling_m_per_n = [1.1e-9, 0.9e-9, 0.8e-9].map(row).to_vec();
    record
}

#[test]
fn loads_and_their_slopes_are_those_of_one_potential() {
    for record in [&*RECORD, &on_soft_bodies()] {
        let level = level(record);
        let mut random = Random::new(7);
        let (mut loaded, mut shared) = (0, 0);
        while loaded < 200 {
            let q = query(&mut random);
            let w = level.evaluate(&q, [5, 5], true);
            if w.gradient[0] < 100.0 {
                continue;
            }
            loaded += 1;
            shared += usize::from(w.hessian[0][0] > 2.5e8);
            let x = q.coordinates();
            for (k, step) in [(0, 1e-8), (2, 2e-7), (3, 5e-5)] {
                let at = |by: f64| {
                    let mut x = x;
                    x[k] += by;
                    level.evaluate(&Query::from(x), [5, 5], false)
                };
                // Third derivatives jump at the knots.
                let bound = 2e-6 * w.gradient[k].abs() + 1e-9 * w.value / step;
                let by_energy = slope(step, |by| at(by).value);
                assert_abs_diff_eq!(by_energy, w.gradient[k], epsilon = bound);
                for i in [0, 2, 3] {
                    let by_load = slope(step, |by| at(by).gradient[i]);
                    let bound = 1e-3 * (w.hessian[i][i] * w.hessian[k][k]).abs().sqrt();
                    assert_abs_diff_eq!(by_load, w.hessian[i][k], epsilon = bound);
                }
            }
        }
        assert!(shared > 20);
    }
}

#[test]
fn loads_are_found_everywhere() {
    let level = level(&RECORD);
    let mut random = Random::new(8);
    let mut most = 0.0f64;
    for _ in 0..100_000 {
        let mut q = query(&mut random);
        // A third of the points lies far beyond the table: up to some thirty times the nominal force.
        if random.next() < 0.33 {
            q.delta *= 10.0;
            q.misalignment *= 10.0;
        }
        let w = level.evaluate(&q, [1, 4], false);
        assert!(w.value.is_finite(), "{q:?} {w:?}");
        for number in [w.value, w.gradient[0], w.hessian[0][0]] {
            assert!(number >= 0.0, "{q:?} {w:?}");
        }
        most = most.max(w.gradient[0]);
    }
    assert!(most > 5.0 * nominal()[0]);
}

#[test]
fn neighbours_lift_off_and_touch_without_a_jump() {
    let level = level(&RECORD);
    for position in [0.1, 4.4, 7.8] {
        let along = (0..4000).map(|i| {
            let delta = -20e-6 + 12.5e-9 * f64::from(i);
            level.evaluate(&Query::from([delta, 0.0, 0.0, position]), [0; 2], false)
        });
        let along: Vec<Potential> = along.collect();
        for (before, w) in along.iter().zip(&along[1..]) {
            // No spring of the mesh gives more over 12.5 nm than this.
            let step = w.gradient[0] - before.gradient[0];
            assert!((0.0..12.5e-9 * 1e9).contains(&step), "{w:?} {step}");
        }
        assert!(along[100].hessian[0][0] == 0.0 && along[3999].hessian[0][0] > 1e8);
    }
}

#[test]
fn a_record_that_makes_no_sense_and_teeth_that_are_not_told_apart_are_refused_by_field() {
    let geometry = &READY.pair.geometry;
    RECORD.check(geometry).unwrap();
    let (coupling, distances) = ("teeth.coupling_m_per_n", "1 to 7 base pitches");
    let on_coast = "teeth.coast_coupling_m_per_n";
    type Change = fn(&mut TeethRecord);
    let changes: [(&str, Change); 14] = [
        ("teeth.first_place", |r| r.last_place = r.first_place),
        ("teeth.first_place", |r| r.last_place = f64::NAN),
        (coupling, |r| r.coupling_m_per_n = vec![vec![f64::NAN]]),
        (coupling, |r| r.coupling_m_per_n = vec![vec![-1e-9]]),
        (on_coast, |r| {
            r.coast_coupling_m_per_n = Some(vec![vec![f64::NAN; 17]])
        }),
        (on_coast, |r| {
            r.coast_coupling_m_per_n = Some(vec![vec![1e-10; 17], vec![-1e-9; 17]])
        }),
        (distances, |r| r.coupling_m_per_n.clear()),
        (distances, |r| r.coupling_m_per_n = vec![vec![1e-10; 17]; 8]),
        ("there are 17 misalignments", |r| {
            r.coupling_m_per_n = vec![vec![1e-9; 6]]
        }),
        ("teeth.drive_errors[0].index_m", |r| {
            r.drive_errors[0].index_m.truncate(3)
        }),
        ("teeth.coast_errors[1].runout_m", |r| {
            r.coast_errors[1].runout_m = f64::NAN
        }),
        ("teeth.drive_errors[1].runout_angle_rad", |r| {
            r.drive_errors[1].runout_angle_rad = f64::INFINITY
        }),
        ("teeth.drive.loa_force_n", |r| r.drive.loa_force.truncate(3)),
        ("teeth.drive.sliding.share", |r| {
            r.drive.sliding.as_mut().unwrap().share.truncate(3)
        }),
    ];
    let changed = |change: Change| {
        let mut record = RECORD.clone();
        change(&mut record);
        record
    };
    for (field, change) in changes {
        let error = changed(change).check(geometry).unwrap_err().to_string();
        assert!(error.contains(field), "{error}");
    }
    // A coupling beyond the deflection of tooth pairs has no single solution; friction asks for how loads slide.
    let friction = Effects {
        friction: true,
        ..EFFECTS
    };
    let beyond: Change = |r| r.coupling_m_per_n = vec![vec![1e-8]];
    let bare: Change = |r| r.drive.sliding = None;
    for (change, effects, words) in [
        (beyond, EFFECTS, "teeth.coupling"),
        (bare, friction, "gearmesh tables --friction"),
    ] {
        let record = changed(change);
        record.check(geometry).unwrap();
        let error = TeethFlank::new(&record, geometry, Flank::Drive, &effects).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    }
    let (mut weak, mut own) = (PairTeeth::default(), PairTeeth::default());
    let (tooth, factor) = (3, 2.0);
    weak.coast[1].weak.push(WeakTooth { tooth, factor });
    let microgeometry = READY.pair.microgeometry.drive[0].clone();
    own.coast[1].flanks.push(OwnFlank {
        tooth,
        microgeometry,
    });
    for (teeth, field) in [(weak, "compliance_factor"), (own, "topography_file")] {
        let error = TeethRecord::takes(&teeth).unwrap_err().to_string();
        let names = [field, "gear2", "contact"];
        assert!(names.iter().all(|name| error.contains(name)), "{error}");
    }
    TeethRecord::takes(&READY.pair.teeth).unwrap();
}

#[test]
fn a_file_with_tooth_pairs_is_read_as_it_was_written() {
    let geometry = &READY.pair.geometry;
    let grid = swept(8);
    let mut file = TableFile::new("pair", "test", geometry, [100.0, 200.0], &grid, None);
    let bare = file.to_json();
    assert!(!bare.contains("\"teeth\":{"));
    file.teeth = Some(RECORD.clone());
    file.seal();
    let again = TableFile::from_json(&file.to_json()).unwrap();
    assert_eq!(again, file);
    let both = TeethFlank::both(again.teeth.as_ref().unwrap(), geometry, &EFFECTS);
    assert!(both.unwrap().iter().all(|flank| flank.tells_teeth_apart()));
}

#[test]
fn one_coupling_of_a_distance_holds_at_all_misalignments() {
    let [one, everywhere] = [1, RECORD.axes.misalignment.len()].map(|count| TeethRecord {
        coupling_m_per_n: vec![vec![9e-10; count]],
        ..RECORD.clone()
    });
    one.check(&READY.pair.geometry).unwrap();
    assert!(
        gearmesh_preprocessor::table::teeth_in_words(&one).contains("neighbours first, 0.90 um/kN")
    );
    let levels = [&one, &everywhere].map(level);
    let mut random = Random::new(9);
    for _ in 0..100 {
        let q = query(&mut random);
        let [a, b] = levels
            .each_ref()
            .map(|level| level.evaluate(&q, [2, 3], true));
        for (a, b) in a.gradient.into_iter().zip(b.gradient) {
            assert_relative_eq!(a, b, max_relative = 1e-9);
        }
    }
}

#[test]
fn a_flank_of_its_own_has_a_coupling_of_its_own() {
    let drive = alike();
    let coast = TeethRecord {
        coast: Some(drive.drive.clone()),
        ..drive.clone()
    };
    let apart = TeethRecord {
        coast_coupling_m_per_n: Some(vec![vec![0.0]]),
        ..coast.clone()
    };
    let q = Query::from([13e-6, 0.0, 0.0, 0.5]);
    let geometry = &READY.pair.geometry;
    let force = |record: &TeethRecord, flank| {
        let level = TeethFlank::new(record, geometry, flank, &EFFECTS).unwrap();
        level.evaluate(&q, [0; 2], false).gradient[0]
    };
    for flank in [Flank::Drive, Flank::Coast] {
        assert_eq!(force(&coast, flank), force(&drive, flank));
    }
    assert_eq!(force(&apart, Flank::Drive), force(&drive, Flank::Drive));
    assert!(force(&apart, Flank::Coast) > 1.05 * force(&coast, Flank::Coast));
}
