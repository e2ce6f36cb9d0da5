//! Contact at run time from the file in an FMU.

use super::*;

fn small_file() -> ContactFile {
    let pair = pair::from_json(PAPER).unwrap();
    contact_file(&pair, &coarse_solver(&pair, with_stations(4))).unwrap()
}

#[test]
fn sizes_that_do_not_fit_each_other_are_refused() {
    let file = small_file();
    assert!(ContactFile::from_bytes(&file.to_bytes()).is_ok());
    let with = |change: &dyn Fn(&mut CondensedFlank, &mut ContactSetup)| {
        let mut changed = file.clone();
        let (drive, setup) = (
            Arc::make_mut(&mut changed.drive),
            Arc::make_mut(&mut changed.setup),
        );
        change(drive, setup);
        ContactFile::from_bytes(&changed.to_bytes())
    };
    // One segment makes a contact, too.
    let one = with(&|drive, setup| {
        (drive.pairs, drive.stations, setup.settings.stations) = (1, 1, 1);
        drive.values.truncate(drive.value_count().unwrap());
    });
    let one = one.unwrap().flank(Flank::Drive).unwrap();
    for tau in [0.0, 0.3, 0.7] {
        let found = one.potential([1e-5, 0.0, 0.0, tau], [0; 2], &mut Warm::default());
        assert!(found.is_ok_and(|found| found.out_of_range));
    }
    let with = |change: &dyn Fn(&mut CondensedFlank, &mut ContactSetup)| with(change).unwrap_err();
    let refusal = with(&|drive, _| drive.values.push(0.0));
    assert!(refusal.contains("more values than"), "{refusal}");
    let refusal = with(&|drive, _| drive.positions += 1);
    assert!(refusal.contains("are not there"), "{refusal}");
}

#[test]
fn a_pose_that_no_solve_finds_says_why() {
    let file = small_file();
    let drive = file.flank(Flank::Drive).unwrap();
    let at = |offset| drive.potential([1e-5, offset, 0.0, 0.2], [0; 2], &mut Warm::default());
    assert!(at(0.0).unwrap().gradient[0] > 0.0);
    // Nearer than the base circles allow.
    let refusal = at(-0.02).unwrap_err().to_string();
    assert!(refusal.contains("no path of contact"), "{refusal}");
}
