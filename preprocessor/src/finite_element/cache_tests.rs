use super::*;
use crate::finite_element::{Discretization, FiniteElementCompliance, PairCompliance, Settings};
use crate::samples;
use gearmesh::compliance::{Segment, ToothCompliance};
use gearmesh::gear::{Gear, GearKind, PairGeometry};
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

fn get(gear: &Gear, cache: &ModelCache) -> (FiniteElementCompliance, Origin) {
    FiniteElementCompliance::cached(gear, &settings(), Some(cache), &|_, _| true).unwrap()
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
fn hand_and_axial_position_share_a_model_and_everything_else_has_its_own() {
    let key_of = |gear: &Gear, settings: &Settings| key(&Model::new(gear, settings).unwrap(), "");
    let changed = |change: &dyn Fn(&mut Gear, &mut Settings)| {
        let (mut gear, mut settings) = (gear(), settings());
        change(&mut gear, &mut settings);
        key_of(&gear, &settings)
    };
    let own = changed(&|_, _| ());
    assert_eq!(own, changed(&|g, _| (g.hand, g.face_offset) = (-1.0, 3e-3)));
    // The width of the kernel follows the loads, which must not cost a computation.
    assert_eq!(
        own,
        changed(&|_, s| s.discretization.kernel_half_width *= 1.3)
    );
    let changes: [fn(&mut Gear, &mut Settings); 14] = [
        |g, _| g.held_radius *= 1.01,
        |g, _| g.poisson_ratio = 0.29,
        |g, _| g.youngs_modulus *= 1.01,
        |g, _| g.tip_radius -= 1e-5,
        |g, _| g.tooth_thinning = 1e-5,
        |g, _| g.tool_tip_radius_coefficient -= 0.01,
        |g, _| g.profile_shift += 0.01,
        |g, _| g.teeth = 21,
        |_, s| s.plane_strain = false,
        |_, s| s.reach = 2,
        |_, s| s.discretization.flank_element *= 0.9,
        |_, s| s.discretization.growth *= 0.9,
        |_, s| s.discretization.tooth_element *= 0.9,
        |_, s| s.discretization.root_element *= 0.9,
    ];
    for (i, change) in changes.iter().enumerate() {
        assert_ne!(own, changed(change), "change {i}");
    }
    let solid = |size: fn(&mut Discretization)| {
        changed(&|_, s| {
            s.plane_strain = false;
            size(&mut s.discretization);
        })
    };
    for size in [
        |d: &mut Discretization| d.layer *= 0.8,
        |d: &mut Discretization| d.end_layer *= 0.8,
    ] {
        assert_ne!(solid(|_| ()), solid(size));
    }
}

#[test]
fn a_moved_node_another_quantity_and_another_version_have_keys_of_their_own() {
    use super::super::{harmonics, influence, ring, root_stress};
    let mut model = Model::new(&gear(), &settings()).unwrap();
    let own = key(&model, "");
    assert_ne!(own, key(&model, "root stress, "));
    let code = format!("{:?}", (env!("CARGO_PKG_VERSION"), VERSION));
    let text = format!("{code} \"\" {}", model.identity());
    assert_eq!(own[..], Sha256::digest(text)[..]);
    let last = model.section.nodes.len() - 1;
    model.section.nodes[last][0] *= 1.0 + 1e-12;
    assert_ne!(own, key(&model, ""));
    // Whoever changes one of these gives VERSION another number, too: else models of before are found.
    let constants = [
        ring::LEFT_OUT,
        harmonics::TOLERANCE,
        influence::LARGEST,
        root_stress::LARGEST,
    ];
    assert_eq!(
        (VERSION, constants),
        (7, [1e-8, 1e-8, 1_073_741_824.0, 32_000.0])
    );
}

#[test]
fn a_pair_is_kept_once_both_models_are() {
    let directory = tempfile::tempdir().unwrap();
    let cache = cache(directory.path());
    let other = Gear {
        teeth: 21,
        ..gear()
    };
    let pair = PairGeometry {
        gears: [gear(), other.clone()],
        center_distance: 0.1,
    };
    let kept = || PairCompliance::is_kept(&pair, &settings(), &cache).unwrap();
    assert!(!kept());
    get(&gear(), &cache);
    assert!(!kept());
    get(&other, &cache);
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
    let teeth_in = |cache: &ModelCache| -> Vec<String> {
        let models = cache.models().unwrap();
        models
            .into_iter()
            .map(|m| m.gear.unwrap()[..8].to_owned())
            .collect()
    };
    let sizes = tempfile::tempdir().unwrap();
    gears
        .iter()
        .for_each(|gear| drop(get(gear, &cache(sizes.path()))));
    let sizes = cache(sizes.path()).models().unwrap();
    let total: u64 = sizes.iter().map(|model| model.bytes).sum();
    // Room for any two.
    let small = ModelCache::new(directory.path(), total - 1);
    for (i, origin) in [
        (0, Origin::Stored),
        (1, Origin::Stored),
        (0, Origin::Loaded),
        (2, Origin::Stored),
    ] {
        assert_eq!(get(&gears[i], &small).1, origin);
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert_eq!(teeth_in(&small), ["20 teeth", "22 teeth"]);
    // One that can never fit moves none out.
    let tiny = ModelCache::new(directory.path(), 100);
    let (_, origin) = get(&gears[1], &tiny);
    assert!(matches!(origin, Origin::NotStored(_)), "{origin:?}");
    assert_eq!(small.clear().unwrap(), 2);
    assert!(teeth_in(&small).is_empty());
    assert_eq!(cache(&directory.path().join("none")).models().unwrap(), []);
}

#[test]
fn a_model_is_read_back_and_a_damaged_file_is_replaced_with_a_note() {
    let directory = tempfile::tempdir().unwrap();
    let cache = cache(directory.path());
    let (computed, origin) = get(&gear(), &cache);
    assert_eq!(origin, Origin::Stored);
    let path = cache.models().unwrap()[0].path.clone();
    let sound = fs::read(&path).unwrap();
    let [mut flipped, mut longer] = [sound.clone(), sound.clone()];
    flipped[sound.len() / 2] ^= 0x10;
    longer.push(0);
    let renamed = |gear: &Gear| {
        let other = tempfile::tempdir().unwrap();
        get(gear, &self::cache(other.path()));
        fs::read(&self::cache(other.path()).models().unwrap()[0].path).unwrap()
    };
    let other = Gear {
        teeth: 21,
        ..gear()
    };
    let cut = sound[..sound.len() - 9].to_vec();
    for damaged in [flipped, longer, renamed(&other), cut, Vec::new()] {
        fs::write(&path, &damaged).unwrap();
        let (model, origin) = get(&gear(), &cache);
        assert!(matches!(origin, Origin::Replaced(_)), "{origin:?}");
        assert_eq!(bulk(&model), bulk(&computed));
        assert!(fs::read(&path).unwrap() == sound);
        let (model, origin) = get(&gear(), &cache);
        assert_eq!((bulk(&model), origin), (bulk(&computed), Origin::Loaded));
    }
}

#[test]
fn unwritable_cache_still_gives_the_model() {
    let directory = tempfile::tempdir().unwrap();
    // A file where the directory should be.
    let blocked = directory.path().join("file");
    fs::write(&blocked, b"").unwrap();
    let (_, origin) = get(&gear(), &cache(&blocked));
    assert!(matches!(origin, Origin::NotStored(_)), "{origin:?}");
}
