//! `gearmesh new`: from options, and from REXS files.

use super::*;

/// Options for a few pairs.
const PAIRS: [&str; 7] = [
    "--teeth 23 81 --module-mm 1.75 --face-width-mm 30 28 --torque-nm 120 --helix-angle-deg -29.5",
    NEW,
    "--teeth 23 81 --module-mm 0.08 --face-width-mm 0.8 0.8 --torque-nm 0.0001",
    "--teeth 12 70 --module-mm 0.5 --face-width-mm 6 5 --torque-nm 0.4",
    "--teeth 27 84 --module-mm 2 --face-width-mm 20 24 --torque-nm 80 --internal",
    "--teeth 27 -84 --module-mm 2 --face-width-mm 20 24 --torque-nm 80",
    "--teeth 17 103 --module-mm 8 --face-width-mm 100 100 --torque-nm 9000 --pressure-angle-deg 25",
];

#[test]
fn a_new_pair_file_is_commented_and_accepted_as_it_stands() {
    let folder = Folder::new();
    for (i, options) in PAIRS.iter().enumerate() {
        let name = format!("pair-{i}.json");
        let path = folder.path(&name);
        succeed!("new -o {path} {options}");
        assert!(folder.read(&name).contains("// > 0: gear 1"));
        let seen = succeed!("inspect {path}");
        assert!(seen.starts_with(&format!("pair-{i}\n")), "{seen}");
        // The pinion's fillet asks for it, in whatever ring it turns. Bores are for the user to say.
        let is_known = |note: &str| {
            note.contains("tips of the ring are shortened")
                || note.contains("assumed: the diameter")
        };
        let mut notes = seen.lines().filter(|l| l.starts_with("note:"));
        assert!(notes.all(is_known), "{options}: {seen}");
    }
}

#[test]
fn a_new_pair_file_overwrites_nothing_and_without_a_name_goes_to_standard_output() {
    let folder = Folder::new();
    let path = folder.write("mine.json", "mine");
    refused!("new -o {path} {}", PAIRS[0]; "is there already");
    assert_eq!(folder.read("mine.json"), "mine");
    assert!(succeed!("new {}", PAIRS[0]).contains("\"teeth\": 23"));
}

#[test]
fn negative_teeth_make_a_ring_in_the_signs_of_iso_21771_and_the_same_pair() {
    let rest = "--module-mm 2 --face-width-mm 20 24 --torque-nm 80";
    // The smaller pinion has a profile shift, and the ring with it.
    for pinion in [14, 27] {
        let folder = Folder::new();
        let [one, two] = folder.paths(["one.json", "two.json"]);
        succeed!("new --internal --teeth {pinion} 84 {rest} --name ring -o {one}");
        succeed!("new --teeth {pinion} -84 {rest} --name ring -o {two}");
        assert_eq!(succeed!("inspect {one}"), succeed!("inspect {two}"));
    }
    refused!("new --teeth -84 27 {rest}"; "--teeth = -84 27", "27 -84");
    // No pinion of 40 teeth turns in a ring of 20.
    refused!("new --teeth -20 40 {rest}"; "--teeth = -20 40", "20 -40", "20 40");
    refused!("new --teeth -20 -40 {rest}"; "--teeth = -20 -40", "20 -40");
}

/// The file of the pair has the largest radius of the tool that fits.
#[test]
fn teeth_of_a_ring_with_little_room_at_their_roots_get_a_smaller_fillet() {
    let rest = "--internal --module-mm 2 --face-width-mm 20 20 --torque-nm 10";
    for teeth in ["17 30", "15 25", "17 24", "17 28"] {
        let file = succeed!("new {rest} --teeth {teeth}");
        let radii = file.match_indices("\"tool_tip_radius_coefficient\": ");
        let radii = radii.map(|(at, name)| file[at + name.len()..].split(',').next().unwrap());
        let radii: Vec<f64> = radii.map(|radius| radius.parse().unwrap()).collect();
        assert_eq!(radii[0], 0.38, "{file}");
        assert!((0.0..0.38).contains(&radii[1]), "{file}");
    }
    refused!("new {rest} --teeth 20 25"; "the tooth difference, 25 - 20 = 5, is too small");
}

#[test]
fn few_teeth_are_shortened_to_keep_a_tip() {
    let rest = "--module-mm 2 --face-width-mm 20 20 --torque-nm 5";
    for teeth in 6..=8 {
        let file = succeed!("new {rest} --teeth {teeth} 30");
        contains!(file, "\"addendum_coefficient\": 0.");
    }
    assert!(!succeed!("new {rest} --teeth 9 30").contains("\"addendum_coefficient\""));
    refused!("new {rest} --teeth 4 30"; "--teeth = 4 30", "contact ratio", "which have no option");
}

#[test]
fn an_internal_pair_with_few_teeth_between_becomes_an_fmu() {
    for teeth in ["30 50", "40 52", "60 68"] {
        let folder = Folder::new();
        let [pair, fmu] = folder.paths(["pair.json", "unit.fmu"]);
        let options = "--internal --module-mm 2 --face-width-mm 20 20 --torque-nm 50";
        succeed!("new {options} --teeth {teeth} -o {pair}");
        succeed!("pack --pair {pair} -o {fmu}");
    }
}

#[test]
fn a_stage_of_a_rexs_file_becomes_a_pair_file_that_says_what_it_took_assumed_and_left() {
    let folder = Folder::new();
    let pair = folder.path("pair.json");
    let listed = succeed!("new --rexs {REXS}/stage.rexs --torque-nm 90 -o {pair}");
    contains!(
        listed,
        "taken: gear1.teeth from number_of_teeth of cylindrical_gear 11",
        "taken: gear1.lower_end_relief from end_relief_datum_face 34",
        "taken: gear2.dedendum_coefficient from addendum_coefficient_reference_profile of rack_shaped_tool 41",
        "assumed: gear2: the left flank is the drive flank",
        "left: triangular_tip_relief 33 of the flank 24",
        "warning: gear2.root_diameter_mm = 70 of the file, but its tool cuts 72.1",
        "left: cylindrical_gear 11: u_coordinate_on_shaft = 20"
    );
    let shown = json(succeed!("inspect {pair} --json"));
    let flank = &shown["gear1"]["reliefs"]["drive_flank"];
    let flank2 = &shown["gear2"]["reliefs"]["drive_flank"];
    for (shown, value, within) in [
        (&shown["center_distance_mm"], 82.104, 1e-9),
        (&shown["gear1"]["span_measurement_mm"], 30.68, 1e-6),
        (&shown["gear2"]["dimension_over_balls_mm"], 91.9, 1e-6),
        (&flank["tip_relief"]["start"]["diameter_mm"], 86.0, 1e-6),
        (&flank["lower_end_relief"]["length_mm"], 3.0, 1e-9),
        (&flank["lead_slope_um"], 0.0, 1e-9),
        (&flank2["lead_crowning_um"], 4.0, 1e-9),
        (&shown["gear1"]["lead_mm"], 1117.2538, 1e-3),
    ] {
        assert!((number(shown) - value).abs() < within, "{shown} {value}");
    }
    assert_eq!(shown["gear2"]["hand"], "left");
}

#[test]
fn a_ring_in_rexs_json_keeps_the_sign_of_iso_21771() {
    let text = succeed!("new --rexs {REXS}/stages.rexsj --stage 1");
    let text = text.replace('"', "");
    contains!(text, "profile_shift_iso_21771: -0.2", "teeth: 84");
    contains!(text, "root_diameter_mm: 173.8", "meshing: internal");
}
