use super::*;
use crate::finite_element::{Discretization, FiniteElementCompliance, Settings};
use crate::samples;
use gearmesh::compliance::{Segment, ToothCompliance};
use gearmesh::gear::GearKind;
use gearmesh::pair::Refinement;
use nalgebra::DMatrix;

fn gear() -> Gear {
    samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
}

fn settings() -> Settings {
    Settings {
        plane_strain: true,
        ..Settings::new(Refinement::Coarse, 1)
    }
}

fn cache(directory: &Path) -> ModelCache {
    ModelCache::new(directory, ModelCache::DEFAULT_LIMIT)
}

fn get(gear: &Gear, directory: &Path) -> (FiniteElementCompliance, Origin) {
    get_from(gear, &cache(directory))
}

fn get_from(gear: &Gear, cache: &ModelCache) -> (FiniteElementCompliance, Origin) {
    FiniteElementCompliance::cached(gear, &settings(), Some(cache), &|_, _| true).unwrap()
}

fn key_of(gear: &Gear, settings: &Settings) -> [u8; 32] {
    key(&Model::new(gear, settings).unwrap(), settings.reach, "")
}

fn bulk(model: &FiniteElementCompliance) -> DMatrix<f64> {
    let segment = |tooth, roll| Segment {
        tooth,
        z: [0.0, 1e-3],
        roll: [roll, roll],
    };
    model.bulk(&[segment(0, 14e-3), segment(1, 10e-3)]).unwrap()
}

#[test]
fn second_request_loads_the_same_numbers() {
    let directory = tempfile::tempdir().unwrap();
    let (first, origin) = get(&gear(), directory.path());
    assert_eq!(origin, Origin::Stored);
    let (second, origin) = get(&gear(), directory.path());
    assert_eq!(origin, Origin::Loaded);
    assert_eq!(bulk(&first), bulk(&second));
    assert_eq!(first.reach(), second.reach());
}

#[test]
fn hand_and_axial_position_share_a_model_and_everything_else_has_its_own() {
    let own = key_of(&gear(), &settings());
    let mut other = gear();
    (other.hand, other.face_offset) = (-1.0, 3e-3);
    assert_eq!(own, key_of(&other, &settings()));
    let changes: [fn(&mut Gear); 8] = [
        |g| g.held_radius *= 1.01,
        |g| g.poisson_ratio = 0.29,
        |g| g.youngs_modulus *= 1.01,
        |g| g.tip_radius -= 1e-5,
        |g| g.tooth_thinning = 1e-5,
        |g| g.tool_tip_radius_coefficient -= 0.01,
        |g| g.profile_shift += 0.01,
        |g| g.teeth = 21,
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut changed = gear();
        change(&mut changed);
        assert_ne!(own, key_of(&changed, &settings()), "change {i}");
    }
    let mut settings_of_others = vec![
        Settings {
            plane_strain: false,
            ..settings()
        },
        Settings {
            reach: 2,
            ..settings()
        },
    ];
    let sizes: [fn(&mut Discretization); 4] = [
        |d| d.flank_element *= 0.9,
        |d| d.growth *= 0.9,
        |d| d.tooth_element *= 0.9,
        |d| d.root_element *= 0.9,
    ];
    for size in sizes {
        let mut finer = settings();
        size(&mut finer.discretization);
        settings_of_others.push(finer);
    }
    for (i, changed) in settings_of_others.iter().enumerate() {
        assert_ne!(own, key_of(&gear(), changed), "settings {i}");
    }
    let solid = settings_of_others[0];
    for size in [(|d| d.layer *= 0.8) as fn(&mut Discretization), |d| {
        d.end_layer *= 0.8
    }] {
        let mut finer = solid;
        size(&mut finer.discretization);
        assert_ne!(key_of(&gear(), &solid), key_of(&gear(), &finer));
    }
}

#[test]
fn a_constant_of_the_code_that_moves_one_node_gives_another_key() {
    let sound = Model::new(&gear(), &settings()).unwrap();
    let mut moved = Model::new(&gear(), &settings()).unwrap();
    let last = moved.section.nodes.len() - 1;
    moved.section.nodes[last][0] *= 1.0 + 1e-12;
    assert_ne!(key(&sound, 1, ""), key(&moved, 1, ""));
    assert_ne!(key(&sound, 1, ""), key(&sound, 1, "root stress"));
}

#[test]
fn constants_that_no_mesh_shows_belong_to_one_version() {
    use super::super::{harmonics, influence, ring, root_stress};
    // Whoever changes one of them here gives VERSION another number, too: else models of before are found.
    let constants = [
        ring::LEFT_OUT,
        harmonics::TOLERANCE,
        influence::LARGEST,
        root_stress::LARGEST,
    ];
    assert_eq!(
        (VERSION, constants),
        (6, [1e-8, 1e-8, 1_073_741_824.0, 32_000.0])
    );
}

#[test]
fn the_version_is_part_of_the_key() {
    let model = Model::new(&gear(), &settings()).unwrap();
    let rest = format!("\"root stress\" 1 {}", model.identity());
    let code = format!("{:?}", (env!("CARGO_PKG_VERSION"), VERSION));
    let own = key(&model, 1, "root stress");
    assert_eq!(own[..], Sha256::digest(format!("{code} {rest}"))[..]);
}

#[test]
fn a_pair_is_kept_once_both_models_are() {
    let directory = tempfile::tempdir().unwrap();
    let cache = cache(directory.path());
    let other = Gear {
        teeth: 21,
        ..gear()
    };
    let pair = gearmesh::gear::PairGeometry {
        gears: [gear(), other.clone()],
        center_distance: 0.1,
    };
    let kept = || {
        let found = super::super::PairCompliance::is_kept(&pair, &settings(), &cache);
        found.unwrap()
    };
    assert!(!kept());
    get_from(&gear(), &cache);
    assert!(!kept());
    get_from(&other, &cache);
    assert!(kept());
}

#[test]
fn a_solid_model_takes_a_third_of_its_numbers() {
    let directory = tempfile::tempdir().unwrap();
    let solid = Settings {
        plane_strain: false,
        reach: 4,
        ..settings()
    };
    let narrow = Gear {
        face_width: 4.0 * gear().normal_module,
        ..gear()
    };
    let cache = cache(directory.path());
    let (model, _) =
        FiniteElementCompliance::cached(&narrow, &solid, Some(&cache), &|_, _| true).unwrap();
    let numbers = 5 * model.grid.len().pow(2);
    let bytes = cache.models().unwrap()[0].bytes as usize;
    assert!(bytes < 8 * numbers / 3, "{bytes} bytes for {numbers}");
}

#[test]
fn the_least_recently_used_models_make_room_for_new_ones() {
    let directory = tempfile::tempdir().unwrap();
    let gears = [20, 21, 22].map(|teeth| Gear { teeth, ..gear() });
    let models = |cache: &ModelCache| -> Vec<String> {
        let models = cache.models().unwrap();
        models.into_iter().map(|m| m.gear.unwrap()).collect()
    };
    let teeth = |count: u32| move |name: &String| name.starts_with(&format!("{count} teeth"));
    let all = tempfile::tempdir().unwrap();
    for gear in &gears {
        get(gear, all.path());
    }
    let sizes = cache(all.path()).models().unwrap();
    let total: u64 = sizes.iter().map(|model| model.bytes).sum();
    // Room for any two.
    let small = ModelCache::new(directory.path(), total - 1);
    let wait = || std::thread::sleep(std::time::Duration::from_millis(20));
    assert_eq!(get_from(&gears[0], &small).1, Origin::Stored);
    wait();
    assert_eq!(get_from(&gears[1], &small).1, Origin::Stored);
    wait();
    assert_eq!(get_from(&gears[0], &small).1, Origin::Loaded);
    wait();
    assert_eq!(get_from(&gears[2], &small).1, Origin::Stored);
    let kept = models(&small);
    assert_eq!(kept.len(), 2, "{kept:?}");
    assert!(
        kept.iter().any(teeth(20)) && kept.iter().any(teeth(22)),
        "{kept:?}"
    );
    // One that can never fit is told and moves none out.
    let tiny = ModelCache::new(directory.path(), 100);
    let (_, origin) = get_from(&gears[1], &tiny);
    assert!(matches!(origin, Origin::NotStored(_)), "{origin:?}");
    assert_eq!(models(&small).len(), 2);
    assert_eq!(small.clear().unwrap(), 2);
    assert_eq!(models(&small), Vec::<String>::new());
    assert_eq!(
        ModelCache::new(directory.path().join("none"), 1)
            .models()
            .unwrap(),
        []
    );
}

#[test]
fn another_kernel_width_loads_the_same_file_and_is_applied() {
    // The width follows the load range, which must not cost a computation.
    let directory = tempfile::tempdir().unwrap();
    get(&gear(), directory.path());
    let mut wider = settings();
    wider.discretization.kernel_half_width *= 1.3;
    let (loaded, origin) = FiniteElementCompliance::cached(
        &gear(),
        &wider,
        Some(&cache(directory.path())),
        &|_, _| true,
    )
    .unwrap();
    assert_eq!(origin, Origin::Loaded);
    let computed = FiniteElementCompliance::new(&gear(), &wider, &|_, _| true).unwrap();
    assert_eq!(bulk(&loaded), bulk(&computed));
}

#[test]
fn damaged_files_are_recomputed_with_a_note() {
    let directory = tempfile::tempdir().unwrap();
    let expected = bulk(&get(&gear(), directory.path()).0);
    let path = cache(directory.path()).models().unwrap()[0].path.clone();
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
