use super::*;
use crate::pair;
use approx::assert_abs_diff_eq;
use gearmesh::gear::Body;

/// A rim of 1.5 modules, a web off mid-face, a hub that sticks out; the root circle of the paper's gear has 72.1 mm.
const WEBBED: &str = r#"{"gear1": {"rim_thickness_mm": 6, "web_thickness_mm": 5, "web_offset_mm": -4,
    "hub_diameter_mm": 42, "hub_width_mm": 32, "hub_offset_mm": 1}}"#;

fn with(patch: &str) -> Result<Pair, PairError> {
    pair::from_json(&patched(&patched(PAPER, WEBBED), patch))
}

#[test]
fn rim_web_and_hub_stand_where_the_file_puts_them() {
    let gear = &with("{}").unwrap().geometry.gears[0];
    let Some(Body {
        rim_radius,
        web,
        hub_radius,
        hub,
        ..
    }) = gear.body
    else {
        panic!("no body");
    };
    for (found, expected) in [
        (rim_radius, gear.root_radius() - 6e-3),
        (web[0], 6e-3),
        (web[1], 11e-3),
        (hub_radius, 21e-3),
        (hub[0], -2.5e-3),
        (hub[1], 29.5e-3),
    ] {
        assert_abs_diff_eq!(found, expected, epsilon = 1e-12);
    }
    // Without a hub the web reaches the bore.
    let plain =
        r#"{"gear1": {"hub_diameter_mm": null, "hub_width_mm": null, "hub_offset_mm": null}}"#;
    let gear = &with(plain).unwrap().geometry.gears[0];
    let body = gear.body.unwrap();
    assert_eq!((body.hub_radius, body.hub), (gear.held_radius, body.web));
    // A hub as wide as the face, if nothing else is said.
    let short = r#"{"gear1": {"hub_width_mm": null, "hub_offset_mm": null}}"#;
    let hub = with(short).unwrap().geometry.gears[0].body.unwrap().hub;
    assert_abs_diff_eq!(hub[0], 0.0, epsilon = 1e-12);
    assert_abs_diff_eq!(hub[1], 25e-3, epsilon = 1e-12);
}

/// The paper's pair with gear 1 cut from a shaft.
const SHAFT: &str = r#"{"gear1": {"bore_diameter_mm": null, "shaft": {
    "lower": {"diameter_mm": 40, "length_mm": 15}, "upper": {"diameter_mm": 30, "length_mm": 50}, "held": "upper"}}}"#;

#[test]
fn a_pinion_shaft_has_its_pieces_beside_the_face_and_is_solid_unless_it_has_a_bore() {
    let gear = |patch: &str| {
        let pair = pair::from_json(&patched(&patched(PAPER, SHAFT), patch)).unwrap();
        pair.geometry.gears[0].clone()
    };
    let solid = gear("{}");
    let body = solid.body.unwrap();
    assert_eq!((body.rim_radius, body.hub_radius), (20e-3, 15e-3));
    assert_eq!((body.web, body.held_ends), ([-15e-3, 25e-3], [false, true]));
    assert_abs_diff_eq!(body.hub[1], 75e-3, epsilon = 1e-12);
    assert_abs_diff_eq!(solid.held_radius, 1.5e-3, epsilon = 1e-12);
    let bored = gear(r#"{"gear1": {"bore_diameter_mm": 12}}"#);
    assert_abs_diff_eq!(bored.held_radius, 6e-3, epsilon = 1e-12);
    assert!(bored.body_twist() > solid.body_twist());
    // Of one piece alone the end is held.
    let one = gear(r#"{"gear1": {"shaft": {"upper": null, "held": null}}}"#);
    assert_eq!(one.body.unwrap().held_ends, [true, false]);
    assert_eq!(one.body.unwrap().hub, [-15e-3, 25e-3]);
}

#[test]
fn a_web_off_mid_face_asks_for_a_coast_table() {
    let central = r#"{"gear1": {"web_offset_mm": 0, "hub_offset_mm": 0}}"#;
    assert!(with(central).unwrap().coast_mirrors_drive());
    assert!(!with("{}").unwrap().coast_mirrors_drive());
    assert!(
        !with(r#"{"gear1": {"web_offset_mm": 0}}"#)
            .unwrap()
            .coast_mirrors_drive()
    );
}

#[test]
fn a_ring_may_rest_on_a_foundation() {
    let on = |value: &str| {
        let patch = format!(r#"{{"gear2": {{"rim_foundation_n_per_mm3": {value}}}}}"#);
        pair::from_json(&patched(INTERNAL, &patch)).map(|pair| pair.geometry.gears[1].foundation)
    };
    assert_eq!(on("null").unwrap(), None);
    assert_eq!(on("25").unwrap(), Some(25e9));
}

/// What is put over the webbed pair, and the field, value and words of the problem that must be named.
#[rustfmt::skip]
const CASES: &[[&str; 4]] = &[
    [r#"{"gear1": {"web_thickness_mm": null}}"#, "gear1.rim_thickness_mm", "6", "not both"],
    [r#"{"gear1": {"rim_thickness_mm": null}}"#, "gear1.web_thickness_mm", "5", "not both"],
    [r#"{"gear2": {"web_offset_mm": 2}}"#, "gear2.web_offset_mm", "2", "not both"],
    [r#"{"gear2": {"hub_width_mm": 20}}"#, "gear2.hub_width_mm", "20", "not both"],
    [r#"{"gear1": {"rim_thickness_mm": 1.9}}"#, "gear1.rim_thickness_mm", "1.9", "half a normal module"],
    [r#"{"gear1": {"rim_thickness_mm": -6}}"#, "gear1.rim_thickness_mm", "-6", "half a normal module"],
    [r#"{"gear1": {"web_thickness_mm": 26}}"#, "gear1.web_thickness_mm", "26", "face width"],
    [r#"{"gear1": {"web_thickness_mm": 0.3}}"#, "gear1.web_thickness_mm", "0.3", "tenth"],
    [r#"{"gear1": {"web_offset_mm": 11}}"#, "gear1.web_offset_mm", "11", "beyond the face"],
    [r#"{"gear1": {"hub_diameter_mm": 61}}"#, "gear1.hub_diameter_mm", "61", "no web"],
    [r#"{"gear1": {"hub_diameter_mm": 30.5}}"#, "gear1.hub_diameter_mm", "30.5", "wall"],
    [r#"{"gear1": {"hub_width_mm": 0}}"#, "gear1.hub_width_mm", "0", "above 0"],
    [r#"{"gear1": {"hub_width_mm": 401}}"#, "gear1.hub_width_mm", "401", "hundred"],
    [r#"{"gear1": {"hub_width_mm": 4, "hub_offset_mm": null}}"#, "gear1.hub_width_mm", "4", "beyond the hub"],
    [r#"{"gear1": {"hub_offset_mm": 20}}"#, "gear1.hub_offset_mm", "20", "beyond the hub"],
    [r#"{"gear1": {"hub_diameter_mm": null}}"#, "gear1.hub_width_mm", "32", "not given"],
    [r#"{"gear1": {"rim_thickness_mm": 22, "hub_diameter_mm": null, "hub_width_mm": null, "hub_offset_mm": null}}"#,
        "gear1.rim_thickness_mm", "22", "no web"],
    [r#"{"gear1": {"rim_foundation_n_per_mm3": 5}}"#, "gear1.rim_foundation_n_per_mm3", "5", "no ring"],
];

/// The same over [`SHAFT`].
#[rustfmt::skip]
const SHAFTS: &[[&str; 4]] = &[
    [r#"{"gear1": {"shaft": {"lower": {"diameter_mm": 71}}}}"#, "gear1.shaft.lower.diameter_mm", "71", "root circle"],
    [r#"{"gear1": {"shaft": {"upper": {"diameter_mm": 0.5}}}}"#, "gear1.shaft.upper.diameter_mm", "0.5", "wall"],
    [r#"{"gear1": {"bore_diameter_mm": 29.5}}"#, "gear1.shaft.upper.diameter_mm", "30", "bore"],
    [r#"{"gear1": {"shaft": {"upper": {"length_mm": 0}}}}"#, "gear1.shaft.upper.length_mm", "0", "modules"],
    [r#"{"gear1": {"shaft": {"held": null}}}"#, "gear1.shaft", "no `held`", "two pieces"],
    [r#"{"gear1": {"shaft": {"upper": null}}}"#, "gear1.shaft.held", "upper", "no `upper` piece"],
    [r#"{"gear1": {"rim_thickness_mm": 5}}"#, "gear1.rim_thickness_mm", "5", "cut from it"],
];

fn refused(result: Result<Pair, PairError>, field: &str, value: &str, problem: &str) {
    let Err(PairError::Refused(refusal)) = result else {
        panic!("{field} = {value}: {result:?}");
    };
    assert_eq!(
        (refusal.field.as_str(), refusal.value.as_str()),
        (field, value)
    );
    assert!(refusal.problem.contains(problem), "{}", refusal.problem);
    assert!(!refusal.remedy.is_empty());
}

#[test]
fn bodies_that_cannot_be_are_refused_with_field_value_and_remedy() {
    for [patch, field, value, problem] in CASES {
        refused(with(patch), field, value, problem);
    }
    for [patch, field, value, problem] in SHAFTS {
        let text = patched(&patched(PAPER, SHAFT), patch);
        refused(pair::from_json(&text), field, value, problem);
    }
    #[rustfmt::skip]
    let rings = [
        (r#"{"gear2": {"shaft": {"lower": {"diameter_mm": 9, "length_mm": 9}}}}"#, "gear2.shaft", "a shaft", "ring"),
        (r#"{"gear2": {"web_thickness_mm": 5}}"#, "gear2.web_thickness_mm", "5", "ring"),
        (r#"{"gear2": {"rim_foundation_n_per_mm3": 0}}"#, "gear2.rim_foundation_n_per_mm3", "0", "outside"),
        (r#"{"gear2": {"rim_foundation_n_per_mm3": 1e10}}"#, "gear2.rim_foundation_n_per_mm3", "10000000000", "outside"),
    ];
    for (patch, field, value, problem) in rings {
        let pair = pair::from_json(&patched(INTERNAL, patch));
        refused(pair, field, value, problem);
    }
}
