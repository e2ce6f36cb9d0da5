use super::*;
use crate::compliance::ToothCompliance;
use crate::finite_element::tests::{plane, segment};
use crate::finite_element::{FiniteElementCompliance, Settings};
use crate::gear::Refinement;
use crate::samples;
use gearmesh::gear::{Gear, GearKind};
use nalgebra::DMatrix;

fn gear(teeth: u32) -> Gear {
    samples::gear(GearKind::External, teeth, 1.0, 0.0, 0.0)
}

fn settings() -> Settings {
    plane(Refinement::Coarse, 1)
}

fn cache(directory: &Path) -> ModelCache {
    ModelCache::new(directory, ModelCache::DEFAULT_LIMIT)
}

fn get(gear: &Gear, cache: &ModelCache) -> (FiniteElementCompliance, Origin) {
    FiniteElementCompliance::new(gear, &settings(), Some(cache), &|_, _| true).unwrap()
}

fn bulk(model: &FiniteElementCompliance) -> DMatrix<f64> {
    let segments = [(0, 40e-3), (1, 39e-3)]
        .map(|(tooth, radius)| segment(&gear(20), tooth, [0.0, 1e-3], radius));
    model.bulk(&segments).unwrap()
}

#[test]
fn hand_axial_position_and_kernel_share_a_model_and_everything_else_has_its_own() {
    let key_of = |plane_strain: bool, change: fn(&mut Gear, &mut Settings)| {
        let (mut gear, mut settings) = (gear(20), settings());
        settings.plane_strain = plane_strain;
        change(&mut gear, &mut settings);
        key(&Model::new(&gear, &settings).unwrap(), "")
    };
    let [own, solid] = [true, false].map(|plane_strain| key_of(plane_strain, |_, _| ()));
    assert_ne!(own, solid);
    let same: [fn(&mut Gear, &mut Settings); 2] = [
        |g, _| (g.hand, g.face_offset) = (-1.0, 3e-3),
        // The width of the kernel follows the loads, which must not cost a computation.
        |_, s| s.discretization.kernel_half_width *= 1.3,
    ];
    for change in same {
        assert_eq!(own, key_of(true, change));
    }
    let others: [fn(&mut Gear, &mut Settings); 15] = [
        |g, _| g.held_radius *= 1.01,
        |g, _| g.poisson_ratio = 0.29,
        |g, _| g.youngs_modulus *= 1.01,
        |g, _| g.tip_radius -= 1e-5,
        |g, _| g.tooth_thinning = 1e-5,
        |g, _| g.tool_tip_radius_coefficient -= 0.01,
        |g, _| g.profile_shift += 0.01,
        |g, _| g.teeth = 21,
        |_, s| s.reach = 2,
        |_, s| s.discretization.flank_element *= 0.9,
        |_, s| s.discretization.growth *= 0.9,
        |_, s| s.discretization.tooth_element *= 0.9,
        |_, s| s.discretization.root_element *= 0.9,
        |_, s| s.discretization.layer *= 0.8,
        |_, s| s.discretization.end_layer *= 0.8,
    ];
    for (i, change) in others.into_iter().enumerate() {
        assert_ne!(solid, key_of(false, change), "change {i}");
    }
}

#[test]
fn a_moved_node_another_quantity_and_another_version_have_keys_of_their_own() {
    use super::super::{harmonics, influence::LARGEST_ENTRY, ring, root_stress, uneven};
    let mut model = Model::new(&gear(20), &settings()).unwrap();
    let own = key(&model, "");
    assert_ne!(own, key(&model, "root stress, "));
    let code = format!("{:?}", (env!("CARGO_PKG_VERSION"), VERSION));
    let text = format!("{code} \"\" {}", model.identity());
    assert_eq!(own[..], Sha256::digest(text)[..]);
    let last = model.section.nodes.len() - 1;
    model.section.nodes[last][0] *= 1.0 + 1e-12;
    assert_ne!(own, key(&model, ""));
    // Whoever changes one of these gives VERSION another number, too: else models of before are found.
    let [left_out, tolerance] = [ring::LEFT_OUT, harmonics::TOLERANCE];
    let constants = [left_out, tolerance, LARGEST_ENTRY, root_stress::LARGEST];
    assert_eq!(constants, [1e-5, 1e-7, 1_073_741_824.0, 32_000.0]);
    let of_body = [uneven::ELEMENTS, uneven::FINE, uneven::GROWTH];
    assert_eq!(of_body, [5.0, 1.1, 1.6]);
    assert_eq!(VERSION, 12);
}

#[test]
fn a_solid_model_takes_a_third_of_its_numbers() {
    let directory = tempfile::tempdir().unwrap();
    let solid = Settings::new(Refinement::Coarse, 4);
    let mut narrow = gear(20);
    narrow.face_width = 4.0 * narrow.normal_module;
    let cache = cache(directory.path());
    let (model, _) =
        FiniteElementCompliance::new(&narrow, &solid, Some(&cache), &|_, _| true).unwrap();
    let numbers = 5 * model.grid.len().pow(2);
    let bytes = cache.models().unwrap()[0].bytes as usize;
    assert!(bytes < 8 * numbers / 3, "{bytes} bytes for {numbers}");
}

#[test]
fn the_least_recently_used_models_make_room_for_new_ones() {
    let directory = tempfile::tempdir().unwrap();
    let gears = [20, 21, 22].map(gear);
    let all = tempfile::tempdir().unwrap();
    for gear in &gears {
        get(gear, &cache(all.path()));
    }
    let all = cache(all.path()).models().unwrap();
    let total: u64 = all.iter().map(|model| model.bytes).sum();
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
    let teeth_in = || -> Vec<String> {
        let models = small.models().unwrap().into_iter();
        models.map(|m| m.gear.unwrap()[..8].to_owned()).collect()
    };
    assert_eq!(teeth_in(), ["20 teeth", "22 teeth"]);
    // One that can never fit moves none out.
    let tiny = ModelCache::new(directory.path(), 100);
    let (_, origin) = get(&gears[1], &tiny);
    assert!(matches!(origin, Origin::NotStored(_)), "{origin:?}");
    assert_eq!(small.clear().unwrap(), 2);
    assert!(teeth_in().is_empty());
    assert_eq!(cache(&directory.path().join("none")).models().unwrap(), []);
}

#[test]
fn a_model_is_read_back_and_a_damaged_file_is_replaced_with_a_note() {
    let directory = tempfile::tempdir().unwrap();
    let cache = cache(directory.path());
    get(&gear(21), &cache);
    let path_of = |cache: &ModelCache| cache.models().unwrap().pop().unwrap().path;
    let other = fs::read(path_of(&cache)).unwrap();
    let (computed, origin) = get(&gear(20), &cache);
    assert_eq!(origin, Origin::Stored);
    let path = path_of(&cache);
    let sound = fs::read(&path).unwrap();
    let mut flipped = sound.clone();
    flipped[sound.len() / 2] ^= 0x10;
    for damaged in [flipped, other, Vec::new()] {
        fs::write(&path, &damaged).unwrap();
        let (model, origin) = get(&gear(20), &cache);
        assert!(matches!(origin, Origin::Replaced(_)), "{origin:?}");
        assert_eq!(bulk(&model), bulk(&computed));
        assert!(fs::read(&path).unwrap() == sound);
        let (model, origin) = get(&gear(20), &cache);
        assert_eq!((bulk(&model), origin), (bulk(&computed), Origin::Loaded));
    }
}

#[test]
fn a_pipe_or_a_huge_file_in_place_of_a_model_holds_nobody_up() {
    let directory = tempfile::tempdir().unwrap();
    let cache = cache(directory.path());
    let (computed, _) = get(&gear(20), &cache);
    let path = cache.models().unwrap().pop().unwrap().path;
    let sound = fs::read(&path).unwrap();
    // Ten gigabytes that begin as a model; holes take no room on the disk.
    let file = File::options().write(true).open(&path).unwrap();
    file.set_len(10_000_000_000).unwrap();
    let (model, origin) = get(&gear(20), &cache);
    let words = format!("{origin:?}");
    assert!(
        words.contains("10000 MB") && matches!(origin, Origin::Replaced(_)),
        "{words}"
    );
    assert_eq!(bulk(&model), bulk(&computed));
    assert!(fs::read(&path).unwrap() == sound);
    #[cfg(unix)]
    {
        fs::remove_file(&path).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.unwrap().success());
        let (model, origin) = get(&gear(20), &cache);
        let words = format!("{origin:?}");
        assert!(
            words.contains("pipe") && matches!(origin, Origin::NotStored(_)),
            "{words}"
        );
        assert_eq!(bulk(&model), bulk(&computed));
        assert_eq!(cache.models().unwrap(), []);
        assert_eq!(cache.others().unwrap(), [path]);
    }
}

#[test]
fn unwritable_cache_still_gives_the_model() {
    let directory = tempfile::tempdir().unwrap();
    // A file where the directory should be.
    let blocked = directory.path().join("file");
    fs::write(&blocked, b"").unwrap();
    let (_, origin) = get(&gear(20), &cache(&blocked));
    assert!(matches!(origin, Origin::NotStored(_)), "{origin:?}");
}
