//! Samples within tolerances.

use super::*;

#[test]
fn a_study_goes_on_where_it_was_and_depends_on_nothing_but_its_seed() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let study = |out: &str, samples: &str, more: &[&str]| {
        let pair = paper();
        let asked = [
            "study",
            &pair,
            "--positions",
            "6",
            "--samples",
            samples,
            "-o",
            out,
            "--vary",
            "gear1.lead_slope_um=+-6",
            "--vary",
            "misalignment_mrad=-0.2..0.2",
        ];
        gearmesh(&[&asked, &QUICK[..], more].concat())
    };
    let (whole, parts) = (path("whole"), path("parts"));
    let output = study(&whole, "10", &[]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("10 samples, 0 refused"),
        "{}",
        stdout(&output)
    );
    assert!(study(&parts, "3", &[]).status.success());
    assert!(study(&parts, "10", &[]).status.success());
    let table = |folder: &str| std::fs::read(Path::new(folder).join("samples.csv")).unwrap();
    assert_eq!(table(&whole), table(&parts));

    // The pair as drawn is sample 0; slope and misalignment gather the load at an end of the face.
    let samples = rows(&Path::new(&whole).join("samples.csv"));
    assert_eq!(samples.len(), 11);
    assert_eq!(samples[0]["gear1.lead_slope_um"], 0.0);
    let factors = samples.iter().map(|s| s["face_load_factor"]);
    assert!(factors.fold(0.0, f64::max) > 1.03 * samples[0]["face_load_factor"]);
    let summary = std::fs::read_to_string(Path::new(&whole).join("study.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let shown = stdout(&output);
    let heads = "   p-p STE 1st harm.  pressure   K_Hbeta\n";
    for head in ["correlation with", "of the distance from drawn"] {
        assert!(shown.contains(&format!("{head}{heads}")), "{shown}");
    }
    // Slope and misalignment gather the load to either side.
    let factor = &summary["statistics"][5];
    assert_eq!(factor["result"], "face_load_factor");
    let distance = numbers(&factor["correlation_of_distance"]);
    assert!(distance.iter().any(|c| *c > 0.5), "{distance:?}");
    let of = |name: &str| summary["statistics"][0][name].as_f64().unwrap();
    assert!(of("least") <= of("median") && of("median") <= of("percentile_95"));
    let page = std::fs::read_to_string(Path::new(&whole).join("study.html")).unwrap();
    assert_eq!(page.matches("<svg").count(), 4);

    let output = study(&whole, "10", &["--seed", "2"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("another study"),
        "{}",
        stderr(&output)
    );
    assert!(
        study(&whole, "10", &["--seed", "2", "--restart"])
            .status
            .success()
    );
    assert_ne!(table(&whole), table(&parts));

    // With root stress: the same samples with two columns more.
    let output = study(&parts, "3", &["--root-stress"]);
    assert!(
        stderr(&output).contains("another study"),
        "{}",
        stderr(&output)
    );
    let output = study(&parts, "3", &["--root-stress", "--restart"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("root_stress_2_mpa"),
        "{}",
        stdout(&output)
    );
    let stressed = rows(&Path::new(&parts).join("samples.csv"));
    for sample in &stressed {
        assert!(sample["root_stress_1_mpa"] > 20.0 && sample["root_stress_2_mpa"] > 20.0);
    }
    let page = std::fs::read_to_string(Path::new(&parts).join("study.html")).unwrap();
    assert_eq!(page.matches("<svg").count(), 6);
}

#[test]
fn a_study_refuses_what_it_cannot_vary_before_it_computes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("study");
    for (vary, said) in [
        ("gear1.lead_slop_um=0..1", "lead_slop_um"),
        ("gear1.bore_diameter_mm=28..30", "teeth"),
        ("gear1.lead_crowning_um=-5..5", "lead_crowning_um"),
        ("misalignment_mrad=0..90", "--vary misalignment_mrad = 90:"),
        ("operating.nominal_torque_nm=+-50", "vary modifications"),
        ("friction.coefficient=0.01..0.2", "vary modifications"),
        ("gear1.coast_flank.lead_slope_um=0..5", "drive flank"),
    ] {
        let output = gearmesh(&[
            "study",
            &paper(),
            "--vary",
            vary,
            "-o",
            out.to_str().unwrap(),
        ]);
        assert_eq!(output.status.code(), Some(1), "{vary}");
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
        assert!(!out.exists());
    }
    let output = gearmesh(&[
        "study",
        &paper(),
        "--iso-1328-class",
        "6",
        "--positions",
        "2",
        "-o",
        out.to_str().unwrap(),
    ]);
    let refused = stderr(&output);
    // Two positions have no harmonic.
    assert!(
        refused.contains("'2' for '--positions <POSITIONS>': give a value from 3"),
        "{refused}"
    );
    let output = gearmesh(&[
        "study",
        &paper(),
        "--iso-1328-class",
        "Q6",
        "-o",
        out.to_str().unwrap(),
    ]);
    assert!(
        stderr(&output).contains(
            "'Q6' for '--iso-1328-class <CLASS>': give a class from 1 to 11, a bare number"
        ),
        "{}",
        stderr(&output)
    );
    let output = gearmesh(&["study", &paper(), "-o", out.to_str().unwrap()]);
    assert!(
        stderr(&output).contains("--iso-1328-class"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_grid_finds_the_relief_whose_point_is_best_and_writes_it_as_a_pair_file_with_bands_over_torque()
{
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (out, page) = (path("study"), path("report.html"));
    let pair = paper();
    let reliefs = "gear1.tip_relief.amount_um,gear2.tip_relief.amount_um=1..13/3";
    let asked = [
        "study",
        &pair,
        "-o",
        &out,
        "--positions",
        "8",
        "--torques-nm",
        "60,100",
        "--vary",
        reliefs,
    ];
    let more = [
        "--vary",
        "gear1.lead_slope_um=+-6",
        "--samples",
        "2",
        "--weights",
        "1,3",
    ];
    let output = succeed(&[&asked[..], &more, &QUICK].concat());
    assert!(
        stdout(&output).contains("3 points of a grid, 2 samples"),
        "{}",
        stdout(&output)
    );

    // Every point, as drawn first, with its samples at both torques; both gears share the relief.
    let samples = rows(&Path::new(&out).join("samples.csv"));
    assert_eq!(samples.len(), 4 * 3 * 2);
    assert!(
        samples
            .iter()
            .all(|s| s["gear1.tip_relief.amount_um"] == s["gear2.tip_relief.amount_um"])
    );
    let measure = |point: f64, sample: f64| {
        let own = samples
            .iter()
            .filter(|s| s["point"] == point && s["sample"] == sample);
        let weighted =
            own.map(|s| s["harmonic_1_loa_um"] * if s["torque_nm"] == 60.0 { 0.25 } else { 0.75 });
        weighted.sum::<f64>()
    };
    let worst = |point| {
        [0.0, 1.0, 2.0]
            .map(|sample| measure(point, sample))
            .into_iter()
            .fold(0.0, f64::max)
    };
    let best = [1.0, 2.0, 3.0]
        .into_iter()
        .min_by(|a, b| worst(*a).total_cmp(&worst(*b)))
        .unwrap();
    let text = std::fs::read_to_string(Path::new(&out).join("study.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["best"]["point"].as_f64(), Some(best));
    assert!((summary["best"]["value"].as_f64().unwrap() - worst(best)).abs() < 1e-12);
    let text = std::fs::read_to_string(Path::new(&out).join("best.json")).unwrap();
    let written: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        written["gear2"]["tip_relief"]["amount_um"].as_f64(),
        Some(6.0 * best - 5.0)
    );
    succeed(&["inspect", &format!("{out}/best.json")]);

    let report = [
        "report",
        &pair,
        "-o",
        &page,
        "--positions",
        "4",
        "--study",
        &out,
    ];
    succeed(&[&report[..], &QUICK].concat());
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("Band of 1st harm. over torque"));

    for (option, value, said) in [
        ("--best", "noise", "give one of peak_to_peak_ste_loa_um"),
        ("--weights", "1,2,3", "one for each torque"),
    ] {
        let refused = gearmesh(&[&asked[..], &[option, value]].concat());
        assert_eq!(refused.status.code(), Some(1));
        assert!(stderr(&refused).contains(said), "{}", stderr(&refused));
    }
}
