//! Contact at run time from the file in an FMU.

use super::*;

fn small_file(pair: &Pair) -> ContactFile {
    contact_file(pair, &coarse_solver(pair, with_stations(4))).unwrap()
}

fn read(file: &ContactFile) -> Result<ContactFile, String> {
    ContactFile::from_bytes(&file.to_bytes())
}

/// `file` with a change to its drive flank and its setup.
fn changed(
    file: &ContactFile,
    change: impl Fn(&mut CondensedFlank, &mut ContactSetup),
) -> ContactFile {
    let mut file = file.clone();
    change(
        Arc::make_mut(&mut file.drive),
        Arc::make_mut(&mut file.setup),
    );
    file
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let file = small_file(&pair::from_json(PAPER).unwrap());
    type Change = fn(&mut CondensedFlank, &mut ContactSetup);
    let changes: [(&str, Change); 6] = [
        ("more values than", |drive, _| drive.values.push(0.0)),
        ("are not there", |drive, _| drive.positions += 1),
        ("stations of a flank", |_, setup| {
            setup.settings.stations -= 1
        }),
        ("0 stations of", |_, setup| setup.settings.stations = 0),
        ("3 index errors of", |_, setup| {
            setup.teeth.drive[0].index = vec![1e-6; 3]
        }),
        ("stations of", |_, setup| {
            setup.geometry.gears[1].tip_radius = 1e6
        }),
    ];
    for (reason, change) in changes {
        let refused = read(&changed(&file, change)).unwrap_err();
        assert!(refused.contains(reason), "{refused}");
    }
    // One segment makes a contact, too; nodes that do not hold the segments of a pose say so.
    let one = changed(&file, |drive, setup| {
        (drive.pairs, drive.stations, setup.settings.stations) = (1, 1, 1);
        drive.values.truncate(drive.value_count().unwrap());
    });
    let far = changed(&file, |drive, _| drive.first_pair += 50);
    for file in [one, far] {
        let contact = read(&file).unwrap().flank(Flank::Drive).unwrap();
        for tau in [0.0, 0.3, 0.7] {
            assert!(ask(&contact, [2e-5, 0.0, 0.0, tau], [0; 2]).out_of_range);
        }
    }
}

#[test]
fn a_pose_that_no_solve_finds_says_why() {
    let file = small_file(&pair::from_json(PAPER).unwrap());
    let drive = file.flank(Flank::Drive).unwrap();
    assert!(ask(&drive, [1e-5, 0.0, 0.0, 0.2], [0; 2]).gradient[0] > 0.0);
    // Nearer than the base circles allow.
    let near = drive.potential([1e-5, -0.02, 0.0, 0.2], [0; 2], &mut Warm::default());
    let refusal = near.unwrap_err().to_string();
    assert!(refusal.contains("no path of contact"), "{refusal}");
}

#[test]
fn a_file_keeps_the_teeth_and_a_coast_flank_of_its_own_for_them() {
    let mut pair = pair::from_json(PAPER).unwrap();
    assert!(pair.coast_mirrors_drive() && small_file(&pair).coast.is_none());
    let (amount, angle) = (14e-6, 0.7);
    pair.teeth.coast[1].runout = Some(Runout { amount, angle });
    let file = small_file(&pair);
    assert_eq!(file.setup.teeth, pair.teeth);
    let read = read(&file).unwrap();
    assert_eq!(read, file);
    // The drive flank's teeth are alike, those of the coast flank are not.
    let [drive, coast] = [Flank::Drive, Flank::Coast].map(|flank| {
        let contact = read.flank(flank).unwrap();
        [0, 5].map(|cycle| ask(&contact, [2e-5, 0.0, 0.0, 0.3], [cycle; 2]).gradient[0])
    });
    assert_eq!(drive[0], drive[1]);
    assert_ne!(coast[0], coast[1]);
}
