//! Whatever a file says, it is read or refused; what is read is sound.

use proptest::prelude::*;
use serde_json::Value;

use super::*;

/// All numbers of a JSON value, as pointers into it.
fn numbers(value: &mut Value) -> Vec<&mut Value> {
    match value {
        Value::Number(_) => vec![value],
        Value::Array(items) => items.iter_mut().flat_map(numbers).collect(),
        Value::Object(fields) => fields.values_mut().flat_map(numbers).collect(),
        _ => Vec::new(),
    }
}

fn shipped() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![PAPER, SPUR, HELICAL, INTERNAL])
}

/// Factors near one give pairs that are often accepted, the others reach into the odd corners.
fn factor() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.8..1.25f64,
        1 => -3.0..3.0f64,
        1 => prop::sample::select(vec![0.0, 1e-9, 1e9, 1e-300, 1e300]),
    ]
}

/// A pair that is accepted can be meshed: finite geometry, teeth, contact.
fn assert_sound(pair: &Pair) {
    let g = &pair.geometry;
    let total = g.transverse_contact_ratio(g.center_distance) + g.overlap_ratio();
    assert!(total.is_finite() && total >= 1.0);
    assert!(g.backlash(g.center_distance) > -1e-12);
    for i in 0..2 {
        let gear = &g.gears[i];
        let profile = crate::gear::ToothProfile::new(gear).unwrap();
        assert!(profile.root_angle() <= profile.half_pitch());
        assert!(profile.tip_land() > 0.0 && gear.held_radius > 0.0);
        let start = g.active_start_roll(i, g.center_distance);
        let tip = gear.roll_length(gear.tip_radius);
        for roll in [start, tip] {
            for z in [0.0, gear.face_width] {
                let removal = pair.microgeometry.coast[i].removal(gear, roll, z);
                // At most six modifications of a twentieth of a module each.
                assert!(removal.abs() <= 0.3 * gear.normal_module, "{removal}");
            }
        }
    }
}

fn check(text: &str) {
    match Pair::from_json(text) {
        Ok(pair) => assert_sound(&pair),
        Err(error) => assert!(error.to_string().contains('`'), "{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn other_numbers_are_accepted_soundly_or_refused(
        text in shipped(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), factor()), 1..5),
    ) {
        let mut json: Value = serde_json::from_str(text).unwrap();
        for (index, factor) in changes {
            let mut all = numbers(&mut json);
            let at = index.index(all.len());
            let old = all[at].clone();
            let new = old.as_f64().unwrap() * factor;
            *all[at] = if old.is_u64() { Value::from(new as i64) } else { Value::from(new) };
        }
        check(&json.to_string());
    }

    #[test]
    fn fields_left_out_take_defaults_or_are_named(
        text in shipped(),
        gear in prop::sample::select(vec!["gear1", "gear2", "operating", ""]),
        index in any::<prop::sample::Index>(),
    ) {
        let mut json: Value = serde_json::from_str(text).unwrap();
        let part = if gear.is_empty() { &mut json } else { &mut json[gear] };
        let fields = part.as_object_mut().unwrap();
        let names: Vec<String> = fields.keys().cloned().collect();
        fields.remove(&names[index.index(names.len())]);
        check(&json.to_string());
    }

    #[test]
    fn damaged_text_is_refused_without_a_panic(
        text in shipped(),
        at in any::<prop::sample::Index>(),
        with in any::<char>(),
        cut in any::<bool>(),
    ) {
        let mut chars: Vec<char> = text.chars().collect();
        let at = at.index(chars.len());
        if cut {
            chars.truncate(at);
        } else {
            chars[at] = with;
        }
        let damaged: String = chars.into_iter().collect();
        if let Ok(pair) = Pair::from_json(&damaged) {
            // A changed letter of a text or digit of a number.
            assert_sound(&pair);
        }
    }
}
