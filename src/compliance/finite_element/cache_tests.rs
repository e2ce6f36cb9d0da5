use super::*;
use crate::compliance::{Strip, ToothCompliance};
use crate::gear::{GearKind, samples};
use crate::pair::Refinement;

fn gear() -> Gear {
    samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
}

fn settings() -> Settings {
    Settings {
        plane_strain: true,
        ..Settings::new(Refinement::Coarse, 1)
    }
}

fn get(gear: &Gear, directory: &Path) -> (FiniteElementCompliance, Origin) {
    FiniteElementCompliance::cached(gear, &settings(), directory, &|_, _| true).unwrap()
}

fn bulk(model: &FiniteElementCompliance) -> DMatrix<f64> {
    let strip = |tooth, roll| Strip {
        tooth,
        z: [0.0, 1e-3],
        roll: [roll, roll],
    };
    model.bulk(&[strip(0, 14e-3), strip(1, 10e-3)]).unwrap()
}

#[test]
fn second_request_loads_the_same_numbers() {
    let directory = tempfile::tempdir().unwrap();
    let (first, origin) = get(&gear(), directory.path());
    assert_eq!(origin, Origin::Stored);
    let (second, origin) = get(&gear(), directory.path());
    assert_eq!(origin, Origin::Loaded);
    assert_eq!(bulk(&first), bulk(&second));
    assert_eq!(first.cost(), second.cost());
    assert_eq!(first.reach(), second.reach());
}

#[test]
fn hand_and_axial_position_share_a_model_and_everything_else_has_its_own() {
    let mut other = gear();
    (other.hand, other.face_offset) = (-1.0, 3e-3);
    assert_eq!(key(&gear(), &settings()), key(&other, &settings()));
    let changes: [fn(&mut Gear); 6] = [
        |g| g.held_radius *= 1.01,
        |g| g.poisson_ratio = 0.29,
        |g| g.tip_radius -= 1e-5,
        |g| g.tooth_thinning = 1e-5,
        |g| g.teeth = 21,
        |g| g.kind = GearKind::Ring,
    ];
    for change in changes {
        let mut changed = gear();
        change(&mut changed);
        assert_ne!(key(&gear(), &settings()), key(&changed, &settings()));
    }
    let mut finer = settings();
    finer.discretization.layer *= 0.9;
    let solid = Settings {
        plane_strain: false,
        ..settings()
    };
    let wider = Settings {
        reach: 2,
        ..settings()
    };
    for changed in [finer, solid, wider] {
        assert_ne!(key(&gear(), &settings()), key(&gear(), &changed));
    }
}

#[test]
fn another_kernel_width_loads_the_same_file_and_is_applied() {
    // The width follows the load range, which must not cost a computation.
    let directory = tempfile::tempdir().unwrap();
    get(&gear(), directory.path());
    let mut wider = settings();
    wider.discretization.kernel_half_width *= 1.3;
    let (loaded, origin) =
        FiniteElementCompliance::cached(&gear(), &wider, directory.path(), &|_, _| true).unwrap();
    assert_eq!(origin, Origin::Loaded);
    let computed = FiniteElementCompliance::new(&gear(), &wider, &|_, _| true).unwrap();
    assert_eq!(bulk(&loaded), bulk(&computed));
}

#[test]
fn damaged_files_are_recomputed_with_a_note() {
    let directory = tempfile::tempdir().unwrap();
    let expected = bulk(&get(&gear(), directory.path()).0);
    let path = file_path(directory.path(), &key(&gear(), &settings()));
    let sound = fs::read(&path).unwrap();
    let mut flipped = sound.clone();
    let middle = sound.len() / 2;
    flipped[middle] ^= 0x10;
    let mut longer = sound.clone();
    longer.push(0);
    let mut foreign = sound.clone();
    foreign[40] ^= 1;
    let cut = sound[..sound.len() - 9].to_vec();
    for damaged in [
        flipped,
        longer,
        foreign,
        cut,
        sound[..20].to_vec(),
        Vec::new(),
    ] {
        fs::write(&path, &damaged).unwrap();
        let (model, origin) = get(&gear(), directory.path());
        assert!(matches!(origin, Origin::Replaced(_)), "{origin:?}");
        assert_eq!(bulk(&model), expected);
        assert_eq!(fs::read(&path).unwrap().len(), sound.len());
        assert_eq!(get(&gear(), directory.path()).1, Origin::Loaded);
    }
}

#[test]
fn unwritable_cache_still_gives_the_model_and_leaves_no_part() {
    let directory = tempfile::tempdir().unwrap();
    // A file where the directory should be.
    let blocked = directory.path().join("file");
    fs::write(&blocked, b"").unwrap();
    let (_, origin) = get(&gear(), &blocked);
    assert!(matches!(origin, Origin::NotStored(_)), "{origin:?}");
    get(&gear(), directory.path());
    let parts = fs::read_dir(directory.path())
        .unwrap()
        .filter(|entry| {
            let name = entry.as_ref().unwrap().file_name();
            name.to_string_lossy().ends_with(".part")
        })
        .count();
    assert_eq!(parts, 0);
}
