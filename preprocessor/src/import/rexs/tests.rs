use std::io::Write;

use approx::assert_abs_diff_eq;
use gearmesh::gear::Flank;

use super::teeth::GENERATED_SHIFT;
use super::*;
use serde_json::Map;

/// Attributes of one component: name and value.
type Attributes<'a> = &'a [(&'a str, Value)];

/// A stage of helical gears with 27 and 51 teeth; later attributes take the place of earlier ones.
struct File<'a> {
    version: &'a str,
    stage: Attributes<'a>,
    gears: [Attributes<'a>; 2],
    flanks: [Attributes<'a>; 2],
    tool: Attributes<'a>,
    settings: [Attributes<'a>; 2],
    tool_kind: &'a str,
    /// Roles of gears with 27 and 51 teeth in the relation of the stage.
    roles: [&'a str; 2],
}

const NONE: Attributes = &[];

impl Default for File<'_> {
    fn default() -> Self {
        File {
            version: "1.5",
            stage: NONE,
            gears: [NONE; 2],
            flanks: [NONE; 2],
            tool: NONE,
            settings: [NONE; 2],
            tool_kind: "rack_shaped_tool",
            roles: ["gear_1", "gear_2"],
        }
    }
}

impl File<'_> {
    fn bytes(&self) -> Vec<u8> {
        let component = |id: u32, kind: &str, attributes: Vec<(&str, Value)>| {
            let mut map = Map::new();
            map.extend(
                attributes
                    .into_iter()
                    .map(|(name, value)| (name.to_owned(), value)),
            );
            let attributes = map.into_iter().filter(|(_, value)| !value.is_null());
            let attributes = attributes.map(|(name, value)| {
                let key = if value.is_array() {
                    "floating_point_array"
                } else {
                    "floating_point"
                };
                json!({"id": name, "unit": "none", key: value})
            });
            json!({"id": id, "type": kind, "attributes": attributes.collect::<Vec<_>>()})
        };
        let mut components = vec![component(
            1,
            "cylindrical_stage",
            [&[("center_distance", json!(190.0))], self.stage].concat(),
        )];
        let mut relations = vec![json!({"type": "stage", "refs": [
            {"role": "stage", "id": 1}, {"role": self.roles[0], "id": 2}, {"role": self.roles[1], "id": 3}]})];
        for i in 0..2 {
            let [gear, flank, tool, settings] = [2, 4, 6, 8].map(|id| id + i as u32);
            let given = [
                ("number_of_teeth", json!([27, 51][i])),
                ("normal_module", json!(4.5)),
                ("helix_angle_reference_diameter", json!([21.0, -21.0][i])),
                ("face_width", json!(50.0)),
                (
                    "tip_diameter",
                    json!([141.84411672689902, 256.2932478270232][i]),
                ),
            ];
            components.push(component(
                gear,
                "cylindrical_gear",
                [&given, self.gears[i]].concat(),
            ));
            let given = [
                ("normal_pressure_angle", json!(20.0)),
                (
                    "addendum_modification_coefficient",
                    json!([0.3, 0.1628301985916763][i]),
                ),
            ];
            components.push(component(
                flank,
                "cylindrical_gear_flank",
                [&given, self.flanks[i]].concat(),
            ));
            let given = [
                ("addendum_coefficient_reference_profile", json!(1.25)),
                ("tip_radius_factor", json!(0.25)),
            ];
            components.push(component(
                tool,
                self.tool_kind,
                [&given, self.tool].concat(),
            ));
            components.push(component(settings, SETTINGS, self.settings[i].to_vec()));
            relations.push(json!({"type": "flank", "refs": [
                {"role": "gear", "id": gear}, {"role": "left", "id": flank}, {"role": "right", "id": flank}]}));
            relations.push(
                json!({"type": "manufacturing_step", "refs": [{"role": "workpiece", "id": flank},
                {"role": "tool", "id": tool}, {"role": "manufacturing_settings", "id": settings}]}),
            );
        }
        let model =
            json!({"version": self.version, "components": components, "relations": relations});
        json!({"model": model}).to_string().into_bytes()
    }

    /// The pair and the account.
    fn import(&self) -> (Pair, String) {
        let imported = from_bytes(self.bytes(), "stage").unwrap();
        (pair::from_json(&imported.text).unwrap(), imported.account)
    }

    fn refusal(&self) -> String {
        from_bytes(self.bytes(), "stage").unwrap_err().to_string()
    }
}

fn says(account: &str, words: &str) {
    assert!(account.contains(words), "{account}");
}

/// Results of a gearbox program for the same gears.
#[test]
fn a_shift_that_is_not_given_follows_from_that_of_the_mate_and_the_centre_distance() {
    let (pair, account) = File {
        flanks: [NONE, &[("addendum_modification_coefficient", Value::Null)]],
        ..File::default()
    }
    .import();
    let gear = &pair.geometry.gears[1];
    assert_abs_diff_eq!(gear.profile_shift, 0.1628301985916763, epsilon = 1e-8);
    assert_abs_diff_eq!(2e3 * gear.root_radius(), 236.043, epsilon = 1e-3);
    says(
        &account,
        "derived: gear2.profile_shift_iso_21771 = 0.162830",
    );
}

#[test]
fn the_centre_distance_follows_from_the_positions_and_without_them_is_said_to_be_assumed() {
    let at = |z: f64| {
        [
            ("support_vector", json!([47.0, 0.0, z])),
            ("u_axis_vector", json!([1.0, 0.0, 0.0])),
        ]
    };
    let (one, two) = (at(0.0), at(-190.1));
    let stage: Attributes = &[("center_distance", Value::Null)];
    let file = File {
        stage,
        gears: [&one, &two],
        ..File::default()
    };
    let (pair, account) = file.import();
    assert_abs_diff_eq!(pair.geometry.center_distance, 0.1901, epsilon = 1e-12);
    says(
        &account,
        "derived: center_distance_mm = 190.1 from support_vector",
    );
    let (pair, account) = File {
        stage,
        ..File::default()
    }
    .import();
    assert_abs_diff_eq!(pair.geometry.center_distance, 0.19, epsilon = 1e-8);
    says(
        &account,
        "assumed: center_distance_mm = 190.0000: without backlash",
    );
    let (_, account) = File {
        gears: [&one, &two],
        ..File::default()
    }
    .import();
    says(
        &account,
        "warning: center_distance_mm = 190 of the stage, but the positions of the gears are 190.1 mm apart",
    );
}

/// Root and root form diameters and backlash of a gearbox program.
#[test]
fn generated_shifts_give_root_circle_and_backlash_whether_the_root_diameter_is_given_or_not() {
    let x = |nominal: f64, lower: f64| {
        [
            (GENERATED_SHIFT, json!(nominal)),
            (
                "generated_addendum_modification_coefficient_lower_deviation",
                json!(lower),
            ),
            (
                "generated_addendum_modification_coefficient_upper_deviation",
                json!(nominal),
            ),
        ]
    };
    let one = x(0.26489334408474646, 0.24962958064333188);
    let two = x(0.12772354267642277, 0.11245977923500822);
    let roots = [121.27815682366175, 235.72728792378598];
    let given = roots.map(|root| [("root_diameter", json!(root))]);
    for gears in [[NONE; 2], [&given[0], &given[1]]] {
        let (pair, _) = File {
            gears,
            settings: [&one, &two],
            ..File::default()
        }
        .import();
        let g = &pair.geometry;
        for (i, form) in [124.2117, 238.2360].into_iter().enumerate() {
            let profile = crate::gear::ToothProfile::new(&g.gears[i]).unwrap();
            assert_abs_diff_eq!(2e3 * g.gears[i].root_radius(), roots[i], epsilon = 1e-4);
            assert_abs_diff_eq!(2e3 * profile.usable_radius(), form, epsilon = 1e-3);
        }
        let normal = 1e6 * g.backlash(g.center_distance) * g.base_helix_angle().cos();
        assert_abs_diff_eq!(normal, 263.0, epsilon = 0.5);
    }
}

#[test]
fn a_tip_chamfer_ends_the_involute_twice_its_height_below_the_tip_diameter() {
    let chamfer: Attributes = &[("tooth_tip_chamfer", json!(0.4))];
    let (pair, account) = File {
        flanks: [chamfer, NONE],
        ..File::default()
    }
    .import();
    let form = 2e3 * pair.geometry.gears[0].tip_form_radius();
    assert_abs_diff_eq!(form, 141.84411672689902 - 0.8, epsilon = 1e-6);
    says(&account, "derived: gear1.tip_form_diameter_mm = 141.044");
}

/// Diameters from a sweep of the tool's round in steps of four thousandths of a degree.
#[test]
fn a_protuberance_deeper_than_the_allowance_ends_the_usable_involute_above_the_fillet() {
    let tool: Attributes = &[
        ("protuberance_amount", json!(0.1)),
        ("protuberance_angle", json!(10.0)),
    ];
    let short = [140.0, 254.0].map(|tip| [("tip_diameter", json!(tip))]);
    for (allowance, form, words) in [
        (
            0.02,
            Some(125.9413),
            "derived: gear1.root_form_diameter_mm = 125.941",
        ),
        (
            0.06,
            Some(125.6142),
            "derived: gear1.root_form_diameter_mm = 125.614",
        ),
        (0.1, None, "derived: gear1: no undercut is left"),
    ] {
        let settings = [("machining_allowance", json!(allowance))];
        let settings: [Attributes; 2] = [&settings; 2];
        let file = File {
            tool,
            settings,
            gears: [&short[0], &short[1]],
            ..File::default()
        };
        let (pair, account) = file.import();
        let found = pair.geometry.gears[0].root_form_radius;
        assert_eq!(found.is_some(), form.is_some(), "{account}");
        assert_abs_diff_eq!(
            2e3 * found.unwrap_or(0.0),
            form.unwrap_or(0.0),
            epsilon = 1e-3
        );
        says(&account, words);
        if allowance == 0.02 {
            // Longer teeth would begin below it.
            let (_, account) = File {
                gears: [NONE; 2],
                ..file
            }
            .import();
            says(&account, "warning: gear1.root_form_diameter_mm = 125.941");
            says(&account, "is left out: contact begins below it");
        }
    }
}

#[test]
fn names_of_version_2_are_read_and_other_versions_noted() {
    let tool: Attributes = &[
        ("tip_radius_factor", Value::Null),
        ("tip_corner_radius_factor_reference_profile", json!(0.25)),
    ];
    let (pair, account) = File {
        version: "2.0.0",
        tool,
        ..File::default()
    }
    .import();
    assert_eq!(pair.geometry.gears[0].tool_tip_radius_coefficient, 0.25);
    assert!(!account.contains("warning"), "{account}");
    for version in ["1.3", "2.1", "new", ""] {
        let (_, account) = File {
            version,
            ..File::default()
        }
        .import();
        says(&account, "warning: the file has version");
    }
}

/// The schema of REXS 2.0.0 has `profile_tool`, and lengths beside their parts of the module.
#[test]
fn tools_of_any_kind_give_their_profile_as_part_of_the_module_or_in_mm() {
    let tool: Attributes = &[
        ("addendum_coefficient_reference_profile", Value::Null),
        ("addendum_reference_profile", json!(1.3 * 4.5)),
        ("tip_radius_factor", Value::Null),
    ];
    for (version, tool_kind, radius) in [
        ("1.7", "rack_shaped_tool", "tip_radius"),
        (
            "2.0.0",
            "profile_tool",
            "tip_corner_radius_reference_profile",
        ),
    ] {
        let (pair, account) = File {
            version,
            tool_kind,
            tool: &[tool, &[(radius, json!(0.9))]].concat(),
            ..File::default()
        }
        .import();
        let gear = &pair.geometry.gears[0];
        assert_abs_diff_eq!(gear.dedendum_coefficient, 1.3, epsilon = 1e-9);
        assert_abs_diff_eq!(gear.tool_tip_radius_coefficient, 0.2, epsilon = 1e-9);
        says(&account, "5.85 mm over the module");
        assert!(!account.contains("warning"), "{account}");
    }
}

#[test]
fn a_ring_is_the_same_in_either_sign_and_as_gear_1_or_2_of_its_stage() {
    let ring = |sign: f64, helix: f64| {
        [
            ("number_of_teeth", json!(-51)),
            ("tip_diameter", json!(sign * 238.6)),
            ("helix_angle_reference_diameter", json!(helix)),
            ("root_diameter", json!(sign * 257.08)),
        ]
    };
    let pinion: Attributes = &[("tip_diameter", json!(139.1))];
    let flank: Attributes = &[("addendum_modification_coefficient", json!(0.0))];
    let read = |sign: f64, helix: f64, roles| {
        File {
            stage: &[("center_distance", json!(sign * 57.84))],
            gears: [pinion, &ring(sign, helix)],
            flanks: [flank; 2],
            roles,
            ..File::default()
        }
        .import()
    };
    let roles = ["gear_1", "gear_2"];
    let right = format!("{:?}", read(1.0, 21.0, roles).0);
    assert!(right.contains("kind: Ring"));
    assert_eq!(format!("{:?}", read(-1.0, -21.0, roles).0), right);
    let (swapped, account) = read(-1.0, 21.0, ["gear_2", "gear_1"]);
    assert_eq!(format!("{swapped:?}"), right);
    says(
        &account,
        "assumed: the ring, gear_1 of stage 1, is gear 2 of the pair",
    );
    let both = [("number_of_teeth", json!(-27))];
    let refused = File {
        gears: [&both, &ring(1.0, 21.0)],
        ..File::default()
    }
    .refusal();
    says(&refused, "are both rings");
}

#[test]
fn what_changes_the_geometry_and_is_left_out_is_a_warning_with_its_value() {
    let flank: Attributes = &[
        ("tooth_root_chamfer_height", json!(1.5)),
        ("quality", json!(6)),
    ];
    let (_, account) = File {
        flanks: [flank, NONE],
        ..File::default()
    }
    .import();
    says(
        &account,
        "warning: cylindrical_gear_flank 4: tooth_root_chamfer_height = 1.5 is left out",
    );
    says(&account, "left: cylindrical_gear_flank 4: quality = 6");
}

#[test]
fn gears_that_contradict_each_other_are_refused_with_both_values() {
    let angle: Attributes = &[("normal_pressure_angle", json!(25.0))];
    let refused = File {
        flanks: [NONE, angle],
        ..File::default()
    }
    .refusal();
    says(
        &refused,
        "= 20, but normal_pressure_angle of cylindrical_gear_flank 5 = 25",
    );
    let module: Attributes = &[("normal_module", json!(4.0))];
    says(
        &File {
            gears: [NONE, module],
            ..File::default()
        }
        .refusal(),
        "= 4.5, but",
    );
    let helix: Attributes = &[("helix_angle_reference_diameter", json!(21.0))];
    says(
        &File {
            gears: [NONE, helix],
            ..File::default()
        }
        .refusal(),
        "opposite hands",
    );
}

#[test]
fn an_archive_with_one_model_is_read_and_one_with_two_refused() {
    let model = File::default().bytes();
    let [one, two] = ["1.rexsj", "2.rexsj"].map(|name| (name, &model[..]));
    assert!(from_bytes(archive(&[one]), "stage").is_ok());
    assert!(from_bytes(archive(&[one, two]), "stage").is_err());
}

/// A zip archive of `files`.
fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for (name, bytes) in files {
        archive.start_file(*name, options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn elements_with_more_xml_attributes_than_any_of_rexs_are_refused_before_they_are_compared() {
    let many: String = (0..2000).map(|i| format!(" a{i}=\"1\"")).collect();
    let refused = from_bytes(format!("<model{many}/>").into_bytes(), "stage").unwrap_err();
    says(&refused.to_string(), "XML attributes");
}

/// JSON, XML and an archive, cut off or with bytes changed: refused with words, or a pair; nothing panics.
#[test]
fn damaged_files_are_refused_or_become_pairs() {
    let json = File::default().bytes();
    let xml = include_bytes!("../../../../command/tests/rexs/stage.rexs").to_vec();
    let zipped = archive(&[("stage.rexsj", &json)]);
    for whole in [json, xml, zipped] {
        for i in (0..whole.len()).step_by(1 + whole.len() / 200) {
            let mut bytes = whole.clone();
            bytes[i] = [b'9', b'-', b'"', b'<', 0xff][i % 5];
            for damaged in [bytes, whole[..i].to_vec()] {
                if let Err(error) = from_bytes(damaged, "stage") {
                    assert!(!error.to_string().is_empty());
                }
            }
        }
    }
}

#[test]
fn what_is_not_set_or_zero_is_as_if_it_did_not_stand_there() {
    let plain = File::default().import();
    let file = File {
        gears: [&[("tip_form_diameter", json!("not-set"))], NONE],
        flanks: [NONE, &[("machining_allowance", json!(0.0))]],
        ..File::default()
    };
    let (pair, account) = file.import();
    assert_eq!(pair.geometry, plain.0.geometry);
    assert!(!account.contains("changes the geometry"), "{account}");
    let file = File {
        flanks: [NONE, &[("machining_allowance", json!(0.1))]],
        ..File::default()
    };
    says(
        &file.import().1,
        "machining_allowance = 0.1 is left out and changes the geometry",
    );
}

#[test]
fn arrays_in_base64_are_their_numbers_and_teeth_are_whole() {
    let axis = json!({"code": "float64", "value": "AAAAAAAA8D8AAAAAAAAAAAAAAAAAAAAA"});
    let file = |axis: Value| {
        let text = String::from_utf8(
            File {
                gears: [&[("u_axis_vector", axis)], NONE],
                ..File::default()
            }
            .bytes(),
        );
        text.unwrap()
    };
    let [coded, plain] = [axis, json!([1.0, 0.0, 0.0])].map(file);
    let [coded, plain] = [coded, plain].map(|text| from_bytes(text.into_bytes(), "stage").unwrap());
    assert_eq!(coded.text, plain.text);
    let cut = file(json!({"code": "float64", "value": "AAAAAAAA8D8A"}));
    let error = from_bytes(cut.into_bytes(), "stage")
        .unwrap_err()
        .to_string();
    assert!(error.contains("u_axis_vector"), "{error}");
    let uneven = file(json!([1.0, 0.0, 0.0]))
        .replace(":27,", ":27.4,")
        .replace(":27}", ":27.4}");
    let error = from_bytes(uneven.into_bytes(), "stage")
        .unwrap_err()
        .to_string();
    assert!(error.contains("number_of_teeth = 27.4"), "{error}");
}

#[test]
fn a_unit_of_another_quantity_is_refused_with_those_that_are_right() {
    let text = String::from_utf8(File::default().bytes()).unwrap();
    for (id, unit, words) in [
        ("normal_module", "rad", "a length; give it in one of mm"),
        ("number_of_teeth", "m", "a number; give it without a unit"),
        ("face_width", "MPa", "a length; give it in one of mm"),
        (
            "normal_pressure_angle",
            "mm",
            "an angle; give it in one of °",
        ),
    ] {
        let mut model: Value = serde_json::from_str(&text).unwrap();
        let components = model["model"]["components"].as_array_mut().unwrap();
        let attributes = components
            .iter_mut()
            .filter_map(|component| component["attributes"].as_array_mut())
            .flatten();
        for attribute in attributes.filter(|attribute| attribute["id"] == id) {
            attribute["unit"] = json!(unit);
        }
        let refused = from_bytes(model.to_string().into_bytes(), "stage").unwrap_err();
        says(
            &refused.to_string(),
            &format!("unit `{unit}`, and it is {words}"),
        );
    }
}

/// Thinner by 60 and 40 um than the profile shifts 0.3 and 0.16283 give: backlash at the pitch circle is 0.1 mm but for the centre distance.
#[test]
fn the_thickness_on_the_reference_circle_and_its_deviations_are_the_thickness_of_the_pair() {
    let tan = f64::to_radians(20.0).tan();
    let nominal =
        [0.3, 0.1628301985916763].map(|x| 4.5 * (0.5 * std::f64::consts::PI + 2.0 * x * tan));
    let file = |first: Attributes, second: Attributes| {
        let gears = [first, second];
        File {
            gears,
            ..File::default()
        }
        .import()
    };
    let name = "normal_tooth_thickness_at_reference_diameter";
    let (pair, account) = file(
        &[(name, json!(nominal[0] - 0.06))],
        &[
            (name, json!(nominal[1])),
            ("chordal_tooth_thickness_lower_deviation", json!(-0.05)),
            ("chordal_tooth_thickness_upper_deviation", json!(-0.03)),
        ],
    );
    let thinning = pair.geometry.gears.each_ref().map(|gear| {
        gear.tooth_thinning * gear.helix_angle.cos() / gear.transverse_pressure_angle().cos()
    });
    assert_abs_diff_eq!(thinning[0], 60e-6, epsilon = 1e-8);
    assert_abs_diff_eq!(thinning[1], 40e-6, epsilon = 1e-8);
    says(&account, "gear1.normal_tooth_thickness_mm = ");
    says(
        &account,
        "and chordal_tooth_thickness_lower_deviation, chordal_tooth_thickness_upper_deviation",
    );
    // In the transverse section.
    let transverse = "transverse_tooth_thickness_at_reference_diameter";
    let value = (nominal[0] - 0.06) / f64::to_radians(21.0).cos();
    let (same, _) = file(&[(transverse, json!(value))], NONE);
    assert_abs_diff_eq!(
        same.geometry.gears[0].tooth_thinning,
        pair.geometry.gears[0].tooth_thinning,
        epsilon = 1e-9
    );
}

#[test]
fn backlash_of_the_stage_is_that_of_the_pair_also_beside_the_thickness_of_the_profile_shift() {
    let limits: Attributes = &[
        ("minimum_normal_backlash", json!(0.1)),
        ("maximum_normal_backlash", json!(0.2)),
        ("maximum_normal_backlash_variation", json!(0.03)),
    ];
    let tan = f64::to_radians(20.0).tan();
    let thickness = 4.5 * (0.5 * std::f64::consts::PI + 0.6 * tan);
    let of_shift = [(
        "normal_tooth_thickness_at_reference_diameter",
        json!(thickness),
    )];
    for gear in [NONE, &of_shift] {
        let (pair, account) = File {
            stage: limits,
            gears: [gear, NONE],
            ..File::default()
        }
        .import();
        let g = &pair.geometry;
        let normal = g.backlash(g.center_distance) * g.base_helix_angle().cos();
        assert_abs_diff_eq!(normal, 150e-6, epsilon = 1e-9);
        says(
            &account,
            "normal_backlash_um = [100.0,200.0] from minimum_normal_backlash",
        );
        says(
            &account,
            "left: cylindrical_stage 1: maximum_normal_backlash_variation",
        );
        assert!(!account.contains("warning"), "{account}");
    }
    // At the operating pitch circle.
    let transverse: Attributes = &[
        ("minimum_transverse_backlash", json!(0.1)),
        ("maximum_transverse_backlash", json!(0.2)),
    ];
    let (pair, _) = File {
        stage: transverse,
        ..File::default()
    }
    .import();
    let g = &pair.geometry;
    let cos = g.operating_pressure_angle(g.center_distance).cos();
    assert_abs_diff_eq!(g.backlash(g.center_distance) / cos, 150e-6, epsilon = 1e-9);
}

#[test]
fn one_limit_of_the_backlash_alone_is_assumed_to_be_the_backlash() {
    for (name, field) in [
        ("minimum_normal_backlash", "normal_backlash_um"),
        ("maximum_normal_backlash", "normal_backlash_um"),
        ("minimum_transverse_backlash", "backlash_um"),
    ] {
        let (_, account) = File {
            stage: &[(name, json!(0.1))],
            ..File::default()
        }
        .import();
        says(
            &account,
            &format!(
                "assumed: {field} = 100.0 from {name} of cylindrical_stage 1, as the other limit is not given"
            ),
        );
    }
}

#[test]
fn backlash_that_both_thicknesses_contradict_is_left_out_with_a_warning() {
    let thinner: Attributes = &[
        ("chordal_tooth_thickness_lower_deviation", json!(-0.06)),
        ("chordal_tooth_thickness_upper_deviation", json!(-0.06)),
    ];
    let (pair, account) = File {
        stage: &[("minimum_normal_backlash", json!(0.8))],
        gears: [thinner; 2],
        ..File::default()
    }
    .import();
    let g = &pair.geometry;
    assert!(g.backlash(g.center_distance) < 0.2e-3);
    says(
        &account,
        "warning: normal_backlash_um = 800.0 is left out: ",
    );
}

#[test]
fn allowances_of_a_span_are_its_limits_and_thickness_that_cannot_be_taken_is_a_warning() {
    let span: Attributes = &[
        ("span_measurement", json!(62.2)),
        ("number_of_teeth_for_span_measurement", json!(4)),
        ("lower_backlash_allowance_referenced_to_span", json!(-0.12)),
        ("upper_backlash_allowance_referenced_to_span", json!(-0.08)),
    ];
    let chord: Attributes = &[("normal_chordal_tooth_thickness", json!(7.5))];
    let file = File {
        gears: [NONE, chord],
        ..File::default()
    };
    let (_, account) = file.import();
    says(
        &account,
        "warning: cylindrical_gear 3: normal_chordal_tooth_thickness = 7.5 is left out",
    );
    let nominal = 1e3 * {
        let (pair, _) = File::default().import();
        crate::pair::drawing::Measure::Span(4)
            .of(&pair.geometry.gears[0])
            .unwrap()
    };
    let mut given = span.to_vec();
    given[0].1 = json!(nominal);
    let (_, account) = File {
        gears: [&given, NONE],
        ..File::default()
    }
    .import();
    says(&account, "gear1.span_measurement_mm = [");
    says(
        &account,
        "and lower_backlash_allowance_referenced_to_span, upper_backlash_allowance_referenced_to_span",
    );
    assert!(!account.contains("warning"), "{account}");
}

/// The file with data of both gears in the stage, `torques` (N m) in the components, and `cases` of them in a load spectrum.
fn under_load(torques: [Option<f64>; 2], cases: &[[f64; 2]]) -> Vec<u8> {
    let relief = |id: u32, um: f64| {
        json!({"id": id, "type": "profile_crowning", "attributes": [
            {"id": "profile_crowning_at_tip", "unit": "mum", "floating_point": um}]})
    };
    let data = |id: u32, torque: Option<f64>| {
        let torque =
            torque.map(|value| json!({"id": "torque", "unit": "N m", "floating_point": value}));
        let rest = json!({"id": "active_root_diameter", "unit": "mm", "floating_point": 115.0});
        let flank = json!({"id": "loaded_tooth_flank", "unit": "none", "enum": "right"});
        let all: Vec<Value> = torque.into_iter().chain([rest, flank]).collect();
        json!({"id": id, "type": "cylindrical_stage_gear_data", "attributes": all})
    };
    let mut file: Value = serde_json::from_slice(&File::default().bytes()).unwrap();
    let model = &mut file["model"];
    for i in 0..2 {
        let [gear, id] = [2 + i, 20 + i];
        let components = model["components"].as_array_mut().unwrap();
        components.push(data(id, torques[i as usize]));
        let refs = json!([{"role": "stage", "id": 1}, {"role": "gear", "id": gear}, {"role": "stage_gear_data", "id": id}]);
        let relations = model["relations"].as_array_mut().unwrap();
        relations.push(json!({"type": "stage_gear_data", "refs": refs}));
    }
    // Flanks of gear 1 that differ.
    let components = model["components"].as_array_mut().unwrap();
    let mut right = components.iter().find(|c| c["id"] == 4).unwrap().clone();
    right["id"] = json!(30);
    components.extend([right, relief(31, 3.0), relief(32, 5.0)]);
    let relations = model["relations"].as_array_mut().unwrap();
    for relation in relations.iter_mut() {
        for r in relation["refs"].as_array_mut().unwrap() {
            if r["role"] == "right" && r["id"] == 4 {
                r["id"] = json!(30);
            }
        }
    }
    for (flank, part) in [(4, 31), (30, 32)] {
        let refs = json!([{"role": "origin", "id": flank}, {"role": "referenced", "id": part}]);
        relations.push(json!({"type": "reference", "refs": refs}));
    }
    let cases = cases.iter().zip(1..).map(|(torques, id)| {
        let components = [data(20, Some(torques[0])), data(21, Some(torques[1]))];
        json!({"id": id, "components": components})
    });
    model["load_spectrum"] = json!({"id": 1, "load_cases": cases.collect::<Vec<_>>()});
    file.to_string().into_bytes()
}

#[test]
fn the_torque_of_a_gear_of_the_stage_is_the_nominal_one_and_its_loaded_flank_the_drive_flank() {
    for (torques, cases, nominal) in [
        ([Some(250.0), Some(-470.0)], &[][..], 250.0),
        ([None, Some(-510.0)], &[], 270.0),
        ([None, None], &[[-300.0, 560.0]], 300.0),
    ] {
        let imported = from_bytes(under_load(torques, cases), "stage").unwrap();
        let pair = pair::from_json(&imported.text).unwrap();
        assert_abs_diff_eq!(pair.operating.nominal_torque, nominal, epsilon = 1e-9);
        let account = &imported.account;
        says(account, "operating.nominal_torque_nm = ");
        says(
            account,
            "gear1: the right flank is the drive flank, from loaded_tooth_flank of cylindrical_stage_gear_data 20",
        );
        says(account, "left: cylindrical_stage_gear_data 21: ");
        says(account, "active_root_diameter = 115");
        assert!(!account.contains("warning"), "{account}");
        let flanks = [Flank::Drive, Flank::Coast].map(|flank| &pair.microgeometry.flank(flank)[0]);
        let crowning = flanks.map(|flank| flank.profile_crowning.as_ref().unwrap().amount);
        assert_abs_diff_eq!(crowning[..], [5e-6, 3e-6][..], epsilon = 1e-12);
    }
}

#[test]
fn of_several_load_cases_none_is_taken_and_each_is_listed() {
    let bytes = under_load([None; 2], &[[100.0, -189.0], [200.0, -378.0]]);
    let account = from_bytes(bytes, "stage").unwrap().account;
    says(&account, "assumed: operating.nominal_torque_nm = ");
    says(
        &account,
        "left: load case 1 (torque = 100.0 of cylindrical_stage_gear_data 20, torque = -189.0",
    );
    says(
        &account,
        "load case 2 (torque = 200.0 of cylindrical_stage_gear_data 20, torque = -378.0 of cylindrical_stage_gear_data 21): of several",
    );
    let account = from_bytes(under_load([None; 2], &[[100.0, -189.0]; 300]), "stage")
        .unwrap()
        .account;
    says(&account, "load case 5 (");
    says(
        &account,
        " and 295 more: of several load cases none is taken",
    );
    assert!(!account.contains("load case 6 ("), "{account}");
}

#[test]
fn load_spectra_of_another_form_are_left_out_with_the_reason_and_geometry_is_taken() {
    let (plain, _) = File::default().import();
    for spectrum in [
        json!("see sheet 2"),
        json!({"load_cases": {"1": {}}}),
        json!([{"load_cases": [{"id": 1, "components": 7}]}]),
    ] {
        let mut file: Value = serde_json::from_slice(&File::default().bytes()).unwrap();
        file["model"]["load_spectrum"] = spectrum;
        let imported = from_bytes(file.to_string().into_bytes(), "stage").unwrap();
        let pair = pair::from_json(&imported.text).unwrap();
        assert_eq!(
            pair.geometry.center_distance,
            plain.geometry.center_distance
        );
        says(
            &imported.account,
            "left: load_spectrum: not in the form of REXS: invalid type: ",
        );
        says(&imported.account, ", expected ");
    }
}
