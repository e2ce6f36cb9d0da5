//! Files that are accepted: what they mean, what is filled in, what is noted.

use approx::assert_abs_diff_eq;

use super::*;
use crate::gear::ToothProfile;
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::GearKind;

#[test]
fn the_papers_pair_has_its_relief_on_both_gears_and_flanks() {
    let pair = pair(PAPER, "{}");
    for (gear, m) in pair.geometry.gears.iter().zip(&pair.microgeometry.drive) {
        let removal = |radius: f64| m.removal(gear, gear.roll_length(radius), 12.5e-3);
        assert_abs_diff_eq!(removal(41.052e-3), 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(removal(gear.tip_radius), 7e-6, epsilon = 1e-12);
    }
    assert!(pair.coast_mirrors_drive());
}

#[test]
fn the_papers_rounded_centre_distance_is_free_of_backlash() {
    let g = pair(PAPER, "{}").geometry;
    // 80 / cos 13 deg = 82.10433 mm is rounded to 82.104 mm.
    assert_abs_diff_eq!(g.backlash(g.center_distance), 0.0, epsilon = 1e-15);
    assert!(g.gears.iter().all(|gear| gear.tooth_thinning < 0.2e-6));
}

#[test]
fn whole_numbers_may_be_written_with_a_fraction_of_zero() {
    let errors = r#""tooth_errors": {"drive_flank": {"pitch_class": 6.0, "seed": 3.0}, "teeth": [{"tooth": 2.0, "compliance_factor": 2}]}"#;
    let g = pair(
        PAPER,
        &format!(r#"{{"gear1": {{"teeth": 20.0, {errors}}}}}"#),
    );
    assert_eq!(g.geometry.gears[0].teeth, 20);
    let whole = pair(
        PAPER,
        &format!(r#"{{"gear1": {{{}}}}}"#, errors.replace(".0", "")),
    );
    assert_eq!(g.teeth, whole.teeth);
    let drawing = named("drawing");
    let teeth = serde_json::from_str::<Value>(&drawing).unwrap()["gear1"]["span_teeth"].clone();
    let patch = format!(r#"{{"gear1": {{"span_teeth": {}.0}}}}"#, teeth);
    assert_eq!(
        pair(&drawing, &patch).geometry,
        pair(&drawing, "{}").geometry
    );
}

#[test]
fn shipped_pairs_are_accepted_and_nothing_of_them_is_suspicious() {
    for text in [PAPER, UNMODIFIED, SPUR, HELICAL, INTERNAL] {
        let mut notes = pair(text, "{}").warnings;
        // The paper's pair has no backlash, so that it must warn of its range of centre distance.
        notes.retain(|note| !note.contains("both flanks press"));
        assert!(notes.is_empty(), "{notes:?}");
    }
}

#[test]
fn the_backlash_of_the_file_is_left_at_the_default_centre_distance() {
    for text in [SPUR, HELICAL, INTERNAL] {
        let g = pair(text, r#"{"center_distance_mm": null}"#).geometry;
        let (c, file) = (g.center_distance, serde_json::from_str::<Value>(text));
        let backlash = 1e-6 * file.unwrap()["backlash_um"].as_f64().unwrap();
        let cos_phi = g.operating_pressure_angle(c).cos();
        assert_abs_diff_eq!(g.backlash(c), backlash * cos_phi, epsilon = 1e-12);
    }
}

#[test]
fn stated_defaults_are_those_that_are_filled_in() {
    let sparse = r#"{
        "name": "sparse", "meshing": "external",
        "normal_module_mm": 2.0, "normal_pressure_angle_deg": 20.0,
        "gear1": { "teeth": 30, "face_width_mm": 20.0 },
        "gear2": { "teeth": 40, "face_width_mm": 20.0 },
        "operating": { "nominal_torque_nm": 50.0, "maximum_torque_nm": 50.0,
            "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0] }
    }"#;
    let pair = pair(sparse, "{}");
    let [a, b] = &pair.geometry.gears;
    for (found, expected) in [
        (pair.geometry.center_distance, 70e-3),
        (a.tip_radius, 32e-3),
        (a.root_radius(), 27.5e-3),
        (a.held_radius, 13.75e-3),
        (a.youngs_modulus, 206e9),
        (a.poisson_ratio, 0.3),
        (a.profile_shift, 0.0),
        (a.helix_angle, 0.0),
        (b.face_offset, 0.0),
        (a.tool_tip_radius_coefficient, 0.38),
        (a.tooth_thinning, 0.0),
    ] {
        assert_abs_diff_eq!(found, expected, epsilon = 1e-15);
    }
    assert_eq!(pair.microgeometry, Default::default());
    assert_eq!(pair.refinement, crate::gear::Refinement::Normal);
    assert_eq!(pair.friction, FrictionLaw::default());
    assert!(pair.tip_corner_contact);
    let assumed = "`gear1.bore_diameter_mm` = 27.5 and `gear2.bore_diameter_mm` = 37.5 assumed";
    assert!(
        pair.warnings.len() == 1 && is_noted(&pair, assumed),
        "{:?}",
        pair.warnings
    );
}

#[test]
fn a_ring_may_be_gear_1_and_its_default_tip_clears_the_pinion() {
    let mut swapped: Value = serde_json::from_str(INTERNAL).unwrap();
    let [pinion, ring] = ["gear1", "gear2"].map(|gear| swapped[gear].take());
    (swapped["gear1"], swapped["gear2"]) = (ring, pinion);
    let patch = r#"{"gear1": {"tip_diameter_mm": null, "tip_relief": null}, "gear2": {"tip_relief": null}}"#;
    let g = pair(&swapped.to_string(), patch).geometry;
    assert_eq!((g.ring(), g.sc()), (Some(0), 1.0));
    assert_eq!(g.gears[1].kind, GearKind::External);
    // Few teeth in a small ring: an addendum of one module would reach the pinion's fillet.
    let patch = r#"{"center_distance_mm": null,
        "gear1": {"teeth": 18, "bore_diameter_mm": 12, "tip_diameter_mm": null, "tip_relief": null},
        "gear2": {"teeth": 36, "rim_diameter_mm": null, "tip_diameter_mm": null, "tip_relief": null}}"#;
    let pair = pair(INTERNAL, patch);
    assert!(is_noted(&pair, "tips of the ring are shortened from"));
    let g = pair.geometry;
    let form = ToothProfile::new(&g.gears[0]).unwrap().form_roll();
    // Over the range of centre distance.
    let above = [-50e-6, 50e-6].map(|by| g.active_start_roll(0, g.center_distance + by) - form);
    assert_abs_diff_eq!(above[0].min(above[1]), 0.02 * 2e-3, epsilon = 1e-12);
}

#[test]
fn the_coast_flank_needs_its_own_table_where_anything_differs_from_end_to_end() {
    assert!(pair(HELICAL, "{}").coast_mirrors_drive());
    for patch in [
        r#"{"gear2": {"lead_slope_um": -4.0}}"#,
        r#"{"face_offset_mm": 2.0}"#,
        r#"{"gear2": {"coast_flank": {"lead_crowning_um": 5}}}"#,
        r#"{"gear2": {"bias_um": 5}}"#,
        r#"{"gear2": {"upper_end_relief": {"amount_um": 6, "length_mm": 3}}}"#,
    ] {
        assert!(!pair(HELICAL, patch).coast_mirrors_drive(), "{patch}");
    }
    for patch in [
        r#"{"gear2": {"profile_slope_um": 5}}"#,
        // No relief is none, whatever its start.
        r#"{"gear2": {"tip_relief": {"amount_um": 0}, "coast_flank": {"tip_relief": {"amount_um": 0,
            "start": {"diameter_mm": 88}}}}}"#,
        r#"{"gear2": {"coast_flank": {"lead_crowning_um": 4.5}}}"#,
        r#"{"gear2": {"end_relief": {"amount_um": 6, "length_mm": 3, "shape": "arc"}}}"#,
    ] {
        assert!(pair(PAPER, patch).coast_mirrors_drive(), "{patch}");
    }
}

/// A rim of 1.5 modules, a web off mid-face, a hub that sticks out; the root circle of the paper's gear has 72.1 mm.
pub const WEBBED: &str = r#"{"gear1": {"rim_thickness_mm": 6, "web_thickness_mm": 5, "web_offset_mm": -4,
    "hub_diameter_mm": 42, "hub_width_mm": 32, "hub_offset_mm": 1}}"#;

#[test]
fn rim_web_and_hub_stand_where_the_file_puts_them() {
    let webbed = patched(PAPER, WEBBED);
    let with = |patch: &str| pair(&webbed, patch);
    let gear = |patch: &str| with(patch).geometry.gears[0].clone();
    let (off, body) = (gear("{}"), gear("{}").body.unwrap());
    assert_abs_diff_eq!(body.rim_radius, off.root_radius() - 6e-3, epsilon = 1e-12);
    assert_abs_diff_eq!(body.web[..], [6e-3, 11e-3], epsilon = 1e-12);
    assert_abs_diff_eq!(body.hub_radius, 21e-3, epsilon = 1e-12);
    assert_abs_diff_eq!(body.hub[..], [-2.5e-3, 29.5e-3], epsilon = 1e-12);
    // Without a hub the web reaches the bore; one of no given width is as wide as the face.
    let plain = gear(
        r#"{"gear1": {"hub_diameter_mm": null, "hub_width_mm": null, "hub_offset_mm": null}}"#,
    );
    let body = plain.body.unwrap();
    assert_eq!((body.hub_radius, body.hub), (plain.held_radius, body.web));
    let short = gear(r#"{"gear1": {"hub_width_mm": null, "hub_offset_mm": null}}"#);
    assert_abs_diff_eq!(short.body.unwrap().hub[..], [0.0, 25e-3], epsilon = 1e-12);
    // A web or hub off mid-face asks for a coast table.
    let mirrors = |patch: &str| with(patch).coast_mirrors_drive();
    assert!(mirrors(
        r#"{"gear1": {"web_offset_mm": 0, "hub_offset_mm": 0}}"#
    ));
    assert!(!mirrors(r#"{"gear1": {"web_offset_mm": 0}}"#) && !mirrors("{}"));
}

/// The paper's pair with gear 1 cut from a shaft.
pub const SHAFT: &str = r#"{"gear1": {"bore_diameter_mm": null, "shaft": {
    "lower": {"diameter_mm": 40, "length_mm": 15}, "upper": {"diameter_mm": 30, "length_mm": 50}, "held": "upper"}}}"#;

#[test]
fn a_pinion_shaft_has_its_pieces_beside_the_face_and_is_solid_unless_it_has_a_bore() {
    let gear = |patch: &str| pair(&patched(PAPER, SHAFT), patch).geometry.gears[0].clone();
    let solid = gear("{}");
    let body = solid.body.unwrap();
    assert_eq!((body.rim_radius, body.hub_radius), (20e-3, 15e-3));
    assert_eq!((body.web, body.held_ends), ([-15e-3, 25e-3], [false, true]));
    assert_abs_diff_eq!(body.hub[1], 75e-3, epsilon = 1e-12);
    assert_abs_diff_eq!(solid.held_radius, 1.5e-3, epsilon = 1e-12);
    let bored = gear(r#"{"gear1": {"bore_diameter_mm": 12}}"#);
    assert_abs_diff_eq!(bored.held_radius, 6e-3, epsilon = 1e-12);
    assert!(crate::gear::body::twist(&bored) > crate::gear::body::twist(&solid));
    // Of one piece alone the end is held.
    let one = gear(r#"{"gear1": {"shaft": {"upper": null, "held": null}}}"#);
    assert_eq!(one.body.unwrap().held_ends, [true, false]);
    assert_eq!(one.body.unwrap().hub, [-15e-3, 25e-3]);
}

/// The paper's pair with gear 1 on a shaft with two bearings.
pub const ON_BEARINGS: &str = r#"{"gear1": {"bore_diameter_mm": null, "shaft": {"start_mm": -60, "torque_end": "upper",
    "sections": [{"diameter_mm": 30, "length_mm": 55}, {"diameter_mm": 36, "length_mm": 95, "inner_diameter_mm": 10}],
    "bearings": [
        {"z_mm": -50, "radial_stiffness_n_per_um": 200, "axial_stiffness_n_per_um": 80, "radial_clearance_um": 12},
        {"z_mm": 70, "radial_stiffness_n_per_um": 300, "tilt_stiffness_nm_per_mrad": 1.5}]}}}"#;

#[test]
fn a_shaft_on_bearings_is_read_in_si_and_gives_bore_and_range_of_misalignment() {
    let found = pair(PAPER, ON_BEARINGS);
    let shaft = found.shafts[0].as_ref().unwrap();
    assert_abs_diff_eq!(
        shaft.section_ends()[..],
        [-60e-3, -5e-3, 90e-3],
        epsilon = 1e-12
    );
    assert_abs_diff_eq!(shaft.sections[1].radii[..], [5e-3, 18e-3], epsilon = 1e-12);
    let [first, second] = &shaft.bearings[..] else {
        panic!()
    };
    assert_abs_diff_eq!(first.free_radius, 6e-6, epsilon = 1e-15);
    assert_eq!(
        (second.tilt_stiffness, second.axial_stiffness),
        (1500.0, 0.0)
    );
    assert!(shaft.torque_at_upper_end && found.shafts[1].is_none());
    // Full disc.
    let root = found.geometry.gears[0].root_radius();
    assert_eq!((shaft.seat, shaft.seat_radius), ([0.0, 25e-3], root));
    let bore = found.geometry.gears[0].held_radius;
    assert_abs_diff_eq!(bore, 18e-3, epsilon = 1e-12);
    assert!(is_noted(&found, "belong to the multibody model"));
    // Tables are of the gears alone.
    assert_eq!(
        found.geometry,
        pair(PAPER, r#"{"gear1": {"bore_diameter_mm": 36}}"#).geometry
    );
    let text = patched(PAPER, ON_BEARINGS);
    let [low, high] = pair(&text, r#"{"operating": {"misalignment_mrad": null}}"#)
        .operating
        .misalignment;
    assert!(
        -2e-3 < low && low < -0.9e-4 && 1e-4 < high && high < 2e-3,
        "{low} {high}"
    );
    // A hub stiffens the shaft where it sits.
    let webbed = pair(
        &text,
        r#"{"gear1": {"rim_thickness_mm": 6, "web_thickness_mm": 8, "hub_diameter_mm": 50, "hub_width_mm": 30}}"#,
    );
    let shaft = webbed.shafts[0].as_ref().unwrap();
    assert_abs_diff_eq!(shaft.seat_radius, 25e-3, epsilon = 1e-12);
    assert_abs_diff_eq!(shaft.seat[..], [-2.5e-3, 27.5e-3], epsilon = 1e-12);
}

#[test]
fn a_ring_may_rest_on_a_foundation() {
    let bedded = r#"{"gear2": {"rim_foundation_n_per_mm3": 25}}"#;
    let stiffness = |patch| pair(INTERNAL, patch).geometry.gears[1].foundation;
    assert_eq!((stiffness("{}"), stiffness(bedded)), (None, Some(25e9)));
}

#[test]
fn laws_of_friction_take_what_they_need_and_ignore_the_rest() {
    let law = |text: &str| pair(PAPER, &format!(r#"{{"friction": {text}}}"#)).friction;
    assert_eq!(law("{}"), FrictionLaw::default());
    let constant = law(r#"{ "coefficient": 0.07, "dynamic_viscosity_mpa_s": 30.0 }"#);
    assert_eq!(constant, FrictionLaw::Constant { coefficient: 0.07 });
    let schlenk =
        r#"{ "law": "schlenk", "dynamic_viscosity_mpa_s": 13.28, "roughness_ra_um": [0.4, 0.31] }"#;
    let same = FrictionLaw::schlenk(13.28e-3, [0.4e-6, 0.31e-6], 0.846);
    assert_eq!(law(schlenk), same);
}

#[test]
fn what_is_legal_but_odd_is_accepted_with_a_note() {
    for [base, patch, words] in rows(include_str!("notes.txt")) {
        let pair = pair(&named(base), patch);
        let (is_expected, words) = match words.strip_prefix("not ") {
            None => (true, words),
            Some(words) => (false, words),
        };
        let is_right = is_noted(&pair, words.trim()) == is_expected;
        assert!(is_right, "{words}: {:?}", pair.warnings);
    }
}

#[test]
fn every_amount_in_um_that_would_be_usual_in_mm_draws_a_note() {
    let amounts = |flank: &str| {
        let fields = "tip_relief.amount_um root_relief.amount_um profile_crowning_um profile_slope_um bias_um lead_crowning_um \
            lead_slope_um end_relief.amount_um lower_end_relief.amount_um upper_end_relief.amount_um";
        let fields = fields
            .split(' ')
            .map(move |field| format!("gear2.{flank}{field}"));
        fields.collect::<Vec<_>>()
    };
    let mut fields = ["", "drive_flank.", "coast_flank."].map(amounts).concat();
    fields.extend(
        [
            "backlash_um",
            "normal_backlash_um",
            "gear2.tooth_errors.runout_um",
        ]
        .map(String::from),
    );
    let bearings = named("bearings");
    for field in fields {
        // Reliefs of an end have a length, too.
        let value = if field.contains("end_relief") {
            let start = field.rsplit_once('.').unwrap().0;
            refused::setting(start, r#"{"amount_um": 0.018, "length_mm": 3}"#)
        } else {
            refused::setting(&field, "0.018")
        };
        let pair = pair(PAPER, &value);
        let words = format!("`{field}` = 0.018 is a suspicious value: 0.018 mm is 18 um");
        assert!(is_noted(&pair, &words), "{words}: {:?}", pair.warnings);
    }
    let clearance = "radial_clearance_um";
    let text = bearings.replace(
        &format!("\"{clearance}\":12"),
        &format!("\"{clearance}\":0.012"),
    );
    assert!(is_noted(&pair(&text, "{}"), "0.012 mm is 12 um"), "{text}");
}

#[test]
fn comments_a_byte_order_mark_and_last_commas_change_nothing() {
    let commented = PAPER
        .replace("{\n", "{ // of the drawing, with a \" in it\n")
        .replace("\"gear1\"", "/* the pinion\n, on two lines */ \"gear1\"")
        .replace("4.5\n", "4.5, # measured\n");
    assert_ne!(commented, PAPER);
    let read = from_json(&format!("\u{feff}{commented}")).unwrap();
    assert_eq!(read, from_json(PAPER).unwrap());
    // In a text they are no comments.
    pair(PAPER, r#"{"source": "https://example.org /* 1 */"}"#);
    pair(PAPER, &format!(r#"{{"name": "{}"}}"#, "齿".repeat(100)));
}

fn draft() -> PairDraft {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    PairDraft::read(&root.join("resources/pairs/palermo2013.json")).unwrap()
}

#[test]
fn fields_of_a_draft_are_changed_by_their_path_made_where_they_are_missing_and_written() {
    let mut draft = draft();
    assert_eq!(draft.pair().unwrap(), from_json(PAPER).unwrap());
    assert_eq!(draft.number("gear1.tip_relief.amount_um"), Some(7.0));
    assert_eq!(draft.number("gear1.lead_slope_um"), None);
    for (field, value) in [
        ("gear1.tip_relief.amount_um", 9.0),
        ("gear1.lead_slope_um", -3.0),
        ("gear2.drive_flank.profile_slope_um", 2.0),
    ] {
        draft.set(field, value).unwrap();
    }
    draft.rename("other");
    let pair = draft.pair().unwrap();
    let drive = &pair.microgeometry.drive;
    assert_eq!(drive[0].tip_relief.unwrap().amount, 9e-6);
    assert_eq!(drive[0].lead_slope, -3e-6);
    assert_eq!(drive[1].profile_slope.unwrap().amount, 2e-6);
    assert_eq!(pair.name, "other");
    assert_eq!(pair, from_json(&draft.to_json()).unwrap());
}

#[test]
fn a_name_that_is_no_field_of_a_draft_is_refused() {
    let mut draft = draft();
    draft.set("gear1.lead_slop_um", 1.0).unwrap();
    let error = draft.pair().unwrap_err().to_string();
    assert!(error.contains("lead_slop_um"), "{error}");
    let error = draft.set("name.length", 1.0).unwrap_err().to_string();
    assert!(error.contains("`name`"), "{error}");
}

/// Published ring stages whose profile shifts are printed with four digits.
#[test]
fn shifts_that_rounding_leaves_short_of_play_are_noted_and_mesh_without_backlash() {
    for (teeth, module, distance, shifts) in [
        ([36, 93], 21.0, 584.0, [0.5039, 0.1171]),
        ([17, 56], 45.0, 863.0, [0.8021, -0.5013]),
    ] {
        let text = format!(
            r#"{{"name": "ring", "meshing": "internal", "normal_module_mm": {module}, "normal_pressure_angle_deg": 20,
            "center_distance_mm": {distance},
            "gear1": {{"teeth": {}, "face_width_mm": 200, "profile_shift": {}}},
            "gear2": {{"teeth": {}, "face_width_mm": 200, "profile_shift_iso_21771": {}}},
            "operating": {{"nominal_torque_nm": 10000, "maximum_torque_nm": 20000,
            "center_distance_offset_um": [0, 0], "misalignment_mrad": [0, 0]}}}}"#,
            teeth[0], shifts[0], teeth[1], shifts[1]
        );
        let pair = from_json(&text).unwrap();
        let g = &pair.geometry;
        assert!(g.backlash(g.center_distance) > -1e-9, "{distance}");
        // A hundredth is no rounding.
        let far = text.replace(&shifts[0].to_string(), &(shifts[0] + 0.01).to_string());
        assert!(from_json(&far).unwrap_err().to_string().contains("jam"));
    }
    let jamming = pair(
        PAPER,
        r#"{"center_distance_mm": 82.101, "backlash_um": null}"#,
    );
    assert!(is_noted(&jamming, "the profile shifts lack"));
}

/// A plastic gear as drawn against a rigid one.
#[test]
fn plastic_and_rigid_gears_with_half_a_module_of_backlash_are_accepted() {
    let patch = r#"{"normal_module_mm": 1, "center_distance_mm": null, "backlash_um": 485,
        "gear1": {"tip_diameter_mm": null, "bore_diameter_mm": 8, "youngs_modulus_gpa": 0.5, "tip_relief": null, "face_width_mm": 10},
        "gear2": {"tip_diameter_mm": null, "bore_diameter_mm": 8, "youngs_modulus_gpa": 206000, "tip_relief": null, "face_width_mm": 10},
        "operating": {"nominal_torque_nm": 0.1, "maximum_torque_nm": 0.2}}"#;
    let pair = pair(PAPER, patch);
    let g = &pair.geometry;
    let phi = g.operating_pressure_angle(g.center_distance);
    assert_abs_diff_eq!(
        g.backlash(g.center_distance) / phi.cos(),
        485e-6,
        epsilon = 1e-9
    );
    assert_abs_diff_eq!(g.gears[1].youngs_modulus, 206e12, epsilon = 1.0);
}

#[test]
fn the_usable_involute_begins_at_the_root_form_diameter_and_contact_must_begin_above_it() {
    let free = pair(PAPER, "{}");
    let fillet = ToothProfile::new(&free.geometry.gears[0]).unwrap();
    let given = 2e3 * fillet.form_radius() + 0.1;
    let patch = format!(r#"{{"gear1": {{"root_form_diameter_mm": {given}}}}}"#);
    let profile = ToothProfile::new(&pair(PAPER, &patch).geometry.gears[0]).unwrap();
    assert_abs_diff_eq!(2e3 * profile.usable_radius(), given, epsilon = 1e-9);
    assert_eq!(profile.form_roll(), fillet.form_roll());
    let refused = refusal(PAPER, r#"{"gear1": {"root_form_diameter_mm": 80}}"#);
    assert!(
        refused.problem.contains("contact begins below it"),
        "{refused}"
    );
    let refused = refusal(PAPER, r#"{"gear1": {"root_form_diameter_mm": 70}}"#);
    assert!(
        refused.problem.contains("from the fillet at diameter"),
        "{refused}"
    );
}

#[test]
fn a_file_whose_lines_end_in_carriage_returns_alone_is_read() {
    let text = PAPER.replace("\r\n", "\n").replace('\n', "\r");
    assert_eq!(
        from_json(&format!("// a comment\r{text}")).unwrap(),
        pair(PAPER, "{}")
    );
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_by_name_and_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe.json");
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&path)
            .status()
            .unwrap()
            .success()
    );
    let message = read(&path).unwrap_err().to_string();
    assert!(
        message.contains("pipe.json") && message.contains("pipe or a device"),
        "{message}"
    );
}
