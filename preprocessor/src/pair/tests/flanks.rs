//! Flanks as drawn and as measured.

use approx::assert_abs_diff_eq;

use super::*;
use gearmesh::gear::{Flank, Microgeometry};

/// Removal of gear 1 of `pair` in um at the diameter and z in mm.
fn removal(pair: &Pair, flank: Flank, diameter_mm: f64, z_mm: f64) -> f64 {
    let gear = &pair.geometry.gears[0];
    let m: &Microgeometry = &pair.microgeometry.flank(flank)[0];
    1e6 * m.removal(gear, gear.roll_length(0.5e-3 * diameter_mm), 1e-3 * z_mm)
}

#[test]
fn a_flank_replaces_what_the_gear_says_for_both_field_by_field() {
    let pair = pair(
        PAPER,
        r#"{"gear1": {"lead_slope_um": 2, "coast_flank": {
            "tip_relief": {"amount_um": 11}, "lead_slope_um": -2,
            "lower_end_relief": {"amount_um": 6, "length_mm": 3}}}}"#,
    );
    // Relief, crowning and slope of both flanks; those of the coast flank, the crowning still that of both.
    for (flank, z, expected) in [
        (Flank::Drive, 25.0, 7.0 + 4.5 + 1.0),
        (Flank::Drive, 0.0, 7.0 + 4.5 - 1.0),
        (Flank::Coast, 25.0, 11.0 + 4.5 - 1.0),
        (Flank::Coast, 0.0, 11.0 + 4.5 + 1.0 + 6.0),
    ] {
        let found = removal(&pair, flank, 90.315, z);
        assert_abs_diff_eq!(found, expected, epsilon = 1e-9);
    }
    assert!(!pair.coast_mirrors_drive());
}

#[test]
fn profile_slope_and_bias_run_from_the_start_of_the_active_profile_to_the_tip() {
    let pair = pair(
        UNMODIFIED,
        r#"{"gear1": {"profile_slope_um": 6, "bias_um": 4}}"#,
    );
    let g = &pair.geometry;
    let start = 2e3 * g.gears[0].radius_at_roll(g.active_start_roll(0, g.center_distance));
    for (z, expected) in [(12.5, 6.0), (25.0, 8.0), (0.0, 4.0)] {
        let [tip, start] = [90.315, start].map(|mm| removal(&pair, Flank::Drive, mm, z));
        assert_abs_diff_eq!(tip - start, expected, epsilon = 1e-9);
    }
}

/// A folder with the unmodified pair and a topography of gear 1 with these lines.
fn with_topography(csv: &str) -> Result<Pair, PairError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("flank.csv"), csv).unwrap();
    let path = folder.path().join("pair.json");
    let patch = r#"{"gear1": {"topography_file": "flank.csv"}}"#;
    std::fs::write(&path, patched(UNMODIFIED, patch)).unwrap();
    read(&path)
}

const HEAD: &str = "roll_mm,z_mm,removal_um";

/// Samples of lead crowning by 4.5 um and a bend over the diameter, under this header and in this order.
fn samples(header: &str, row: impl Fn(f64, f64, f64) -> String) -> String {
    let mut text = format!("# of a measuring machine\n{header}\n");
    for i in 0..6 {
        for z in [0.0, 5.0, 10.0, 20.0, 25.0] {
            let roll = 5.5 + 3.5 * f64::from(i);
            let um = 4.5 * (z / 12.5 - 1.0f64).powi(2) + 0.03 * (roll - 14.0).powi(2);
            text += &row(roll, z, um);
        }
    }
    text
}

#[test]
fn a_topography_is_the_flank_that_was_sampled_whatever_the_order_of_columns() {
    let gear = pair(UNMODIFIED, "{}").geometry.gears[0].clone();
    let diameter = |roll: f64| 2e3 * gear.radius_at_roll(1e-3 * roll);
    for csv in [
        samples(HEAD, |r, z, um| format!("{r},{z},{um}\n")),
        samples("removal_um, z_mm, roll_mm", |r, z, um| {
            format!("\"{um}\", {z}, {r}\n")
        }),
        samples("\u{feff}diameter_mm,z_mm,removal_um", |r, z, um| {
            format!("{},{z},{um}\n", diameter(r))
        }),
    ] {
        let csv = csv.replacen("# of a measuring machine\n\u{feff}", "\u{feff}", 1);
        let pair = with_topography(&csv).unwrap();
        for roll in [6.0, 11.3, 19.9] {
            for z in [0.0, 7.0, 24.0] {
                let expected = 4.5 * (z / 12.5 - 1.0f64).powi(2) + 0.03 * (roll - 14.0f64).powi(2);
                let found = removal(&pair, Flank::Drive, diameter(roll), z);
                assert_abs_diff_eq!(found, expected, epsilon = 1e-6);
            }
        }
    }
}

#[test]
fn a_topography_that_is_none_is_refused_by_line_or_size() {
    let good = samples(HEAD, |r, z, um| format!("{r},{z},{um}\n"));
    #[rustfmt::skip]
    let cases = [
        (good.replace("removal_um", "deviation"), "has the columns roll_mm,z_mm,deviation"),
        ("roll_mm,z_mm,removal_um\n".into(), "has 0 points"),
        (good.replacen("5.5,0,", "5.5,zero,", 1), "line 3: z_mm = zero: not a finite number"),
        (good.replacen("5.5,0,", "5.5,zero,", 1) .replace('\n', "\r\n"), "line 3: z_mm = zero: not a finite number"),
        (good.replace(',', ";"), "has semicolons between its columns"),
        (good.replacen("5.5,5,", "5.5,0,", 1), "line 4: roll_mm = 5.5, z_mm = 0 stands in an earlier line"),
        (good.lines().take(20).collect::<Vec<_>>().join("\n"), "has 18 points, and 4 x 5 lines; roll_mm = 16, z_mm = 20 is missing"),
        (good.lines().take(12).collect::<Vec<_>>().join("\n"), "has 2 x 5 lines; give"),
        (good.replacen("5.5,0,", "-5.5,0,", 1), "line 3: roll_mm = -5.5, z_mm = 0: outside of involute and face"),
        (samples("diameter_mm,z_mm,removal_um", |r, z, um| format!("{},{z},{um}\n", 40.0 + r)), "line 3: diameter_mm = 45.5, z_mm = 0: outside of involute and face, which begin at the base circle, 7"),
        (good.replacen("5.5,5,", "5.5,5,999", 1), "line 4: removal_um = 9993.7875 takes off more than a twentieth of the normal module, 200 um"),
        (samples(HEAD, |r, z, um| format!("{},{z},{um}\n", 1e-3 * r)), "roll_mm runs from 0.006 to 0.023, and the flank from"),
        (samples(HEAD, |r, z, um| if r < 13.0 { format!("{r},{z},{um}\n") } else { String::new() }), "roll_mm runs from 5.5 to 12.5, and the flank from"),
        (samples(HEAD, |r, z, um| format!("{r},{z},{}\n", 1e3 * um)), "a twentieth of the normal module, 200 um"),
    ];
    for (csv, words) in cases {
        assert_has(&problem(&csv), &[words]);
    }
}

#[test]
fn a_topography_that_may_be_in_millimetres_is_noted_with_its_largest_removal() {
    let in_mm = samples(HEAD, |r, z, um| format!("{r},{z},{}\n", 1e-3 * um));
    let pair = with_topography(&in_mm).unwrap();
    let notes: Vec<_> = (pair.warnings.iter())
        .filter(|note| note.contains("topography_file"))
        .collect();
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert_has(
        notes[0],
        &[
            "`gear1.topography_file`: removal_um = 0.0",
            "suspicious value: 0.0",
            " mm is ",
        ],
    );
    for csv in [
        samples(HEAD, |r, z, um| format!("{r},{z},{um}\n")),
        samples(HEAD, |r, z, _| format!("{r},{z},0\n")),
    ] {
        assert!(!is_noted(
            &with_topography(&csv).unwrap(),
            "topography_file"
        ));
    }
}

fn assert_has(text: &str, words: &[&str]) {
    assert!(words.iter().all(|words| text.contains(words)), "{text}");
}

/// Why a topography with these lines is refused.
fn problem(csv: &str) -> String {
    match with_topography(csv) {
        Err(PairError::Refused(refusal)) => {
            assert_eq!(refusal.all()[0].field, "gear1.topography_file");
            refusal.to_string()
        }
        other => panic!("{csv}: {other:?}"),
    }
}

/// A topography with `um` on the lines `rolls`, mm.
fn lines(rolls: [f64; 5], um: [f64; 5]) -> String {
    let mut text = "roll_mm,z_mm,removal_um\n".to_owned();
    for (roll, um) in rolls.into_iter().zip(um) {
        for z in [0.0, 12.5, 25.0] {
            text += &format!("{roll},{z},{um}\n");
        }
    }
    text
}

#[test]
fn a_topography_that_swings_out_between_its_lines_or_beyond_them_is_refused_by_place() {
    // Active from 5.06 to 23.67 mm.
    let step = [0.0, 20.0, 0.0, 0.0, 0.0];
    assert!(with_topography(&lines([5.0, 9.0, 14.0, 19.0, 24.0], step)).is_ok());
    for close in [1e-3, 1e-6] {
        let close = problem(&lines([6.0, 6.0 + close, 14.0, 19.0, 24.0], step));
        // 4/27 of the slope of 20 um over the distance of the lines, times 8 mm.
        assert_has(
            &close,
            &[
                "takes off 2.3",
                "roll_mm = 9.2",
                "lines at about equal distances",
            ],
        );
    }
    let beyond = lines([5.0, 8.0, 13.0, 18.0, 19.2], [0.0, 0.0, 0.0, 0.0, 60.0]);
    assert_has(
        &problem(&beyond),
        &["roll_mm = 23", "covers the whole active profile"],
    );
    // The limit holds for what is added, too.
    let added = lines([5.0, 9.0, 14.0, 19.0, 24.0], step.map(|um| -20.0 * um));
    assert_has(&problem(&added), &["adds "]);
}

#[test]
fn a_chamfer_ends_the_flank_and_shortens_the_path_of_contact() {
    let sharp = pair(PAPER, "{}");
    let blunt = pair(PAPER, r#"{"gear1": {"tip_form_diameter_mm": 89.715}}"#);
    let [a, b] = [&sharp, &blunt].map(|pair| pair.geometry.path_of_contact(82.104e-3));
    let gear = &blunt.geometry.gears[0];
    assert_abs_diff_eq!(gear.tip_chamfer, 0.3e-3, epsilon = 1e-12);
    assert_abs_diff_eq!(gear.tip_radius, 45.1575e-3, epsilon = 1e-12);
    assert_eq!(a.start, b.start);
    let shorter = gear.roll_length(gear.tip_radius) - gear.roll_length(gear.tip_radius - 0.3e-3);
    assert_abs_diff_eq!(a.end - b.end, shorter, epsilon = 1e-12);
    // Relief is whole where the chamfer begins.
    let whole = removal(&blunt, Flank::Drive, 89.715, 12.5);
    assert_abs_diff_eq!(whole, 7.0, epsilon = 1e-9);
}
