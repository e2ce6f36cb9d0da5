//! Grids and samples within tolerances.

use super::*;

#[test]
fn a_study_goes_on_where_it_was_and_depends_on_nothing_but_its_seed() {
    let folder = Folder::new();
    let study = |out: &str, options: &str| {
        let out = folder.path(out);
        let vary = "--vary gear1.lead_slope_um=+-6 --vary misalignment_mrad=-0.2..0.2";
        format!("study {PAPER} --positions 6 -o {out} {vary} {QUICK} {options}")
    };
    let table = |out: &str| folder.read(&format!("{out}/samples.csv"));
    let page = |out: &str| folder.read(&format!("{out}/study.html"));
    let charts = |out: &str| page(out).matches("<svg").count();
    let shown = succeed(study("whole", "--samples 10"));
    contains!(shown, "10 samples, 0 refused");
    succeed(study("parts", "--samples 3"));
    succeed(study("parts", "--samples 10"));
    assert_eq!(table("whole"), table("parts"));

    // What a refused sample says is read back as it was written; a row that lacks a number is refused.
    let solved = table("parts");
    let last = solved.trim_end().lines().next_back().unwrap();
    let keys = last.splitn(5, ',').take(4).collect::<Vec<_>>().join(",");
    let row = |results: &str| solved.replace(last, &format!("{keys}{results}"));
    let quoted = row(",,,,,,,,\"too much, \"\"far\"\"\"");
    folder.write("parts/samples.csv", &quoted);
    contains!(succeed(study("parts", "--samples 10")), "1 refused");
    succeed(study("parts", "--samples 11"));
    assert!(table("parts").starts_with(&quoted));
    // Rows that cannot be the program's own are refused by file and line, and read as nothing else.
    let zero = |results: &str| row(&format!(",{results},,"));
    for (damaged, words) in [
        (row(",,,,,,,,"), ["line 12: ", "not a finite number"]),
        (
            zero("1,2,3,4,5,NaN"),
            ["face_load_factor = NaN", "not a finite number"],
        ),
        (
            zero("inf,2,3,4,5,6"),
            ["line 12: ", "_um = inf: not a finite number"],
        ),
        (row(",1"), ["line: 12", "fields"]),
        (
            solved.replace("\n3,", "\n-3,"),
            ["line 5: sample = -3", "whole number"],
        ),
        (
            format!("{solved}{last}\n"),
            ["line 13: sample = 10", "more rows"],
        ),
        (
            solved.replace(&format!("\n{keys}"), &format!("\n{keys}1")),
            ["sample 10 of point 0", "values of another study"],
        ),
    ] {
        let file = folder.write("parts/samples.csv", damaged);
        let line = study("parts", "--samples 10");
        refused(line, &[&file, words[0], words[1], "--restart"]);
    }
    folder.write("parts/samples.csv", &solved);

    // The pair as drawn is sample 0; slope and misalignment gather the load at an end of the face.
    let samples = folder.rows("whole/samples.csv");
    assert_eq!(samples.len(), 11);
    assert_eq!(samples[0]["gear1.lead_slope_um"], 0.0);
    let factors = samples.iter().map(|s| s["face_load_factor"]);
    assert!(largest(factors) > 1.03 * samples[0]["face_load_factor"]);
    let heads = "   p-p STE 1st harm.  pressure   K_Hbeta\n";
    for head in ["correlation with", "of the distance from drawn"] {
        contains!(shown, &format!("{head}{heads}"));
    }
    // Slope and misalignment gather the load to either side.
    let summary = json(folder.read("whole/study.json"));
    let factor = &summary["statistics"][5];
    assert_eq!(factor["result"], "face_load_factor");
    let distance = numbers(&factor["correlation_of_distance"]);
    assert!(distance.iter().any(|c| *c > 0.5), "{distance:?}");
    let [least, median, most] =
        ["least", "median", "percentile_95"].map(|name| number(&summary["statistics"][0][name]));
    assert!(least <= median && median <= most);
    assert_eq!(charts("whole"), 4);

    refused(study("whole", "--samples 10 --seed 2"), &["another study"]);
    // Stopped before its first samples, it leaves none of the other study beside its own name.
    let before = folder.read("whole/study.json");
    let line = study("whole", "--samples 10 --seed 2 --restart").replace(QUICK, "--no-cache");
    let mut child = command().args(line.split_whitespace()).spawn().unwrap();
    while folder.read("whole/study.json") == before {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(table("whole").lines().count(), 1);
    succeed(study("whole", "--samples 10 --seed 2 --restart"));
    assert_ne!(table("whole"), table("parts"));

    // With root stress: the same samples with two columns more.
    let roots = "--samples 3 --root-stress";
    refused(study("parts", roots), &["another study"]);
    let shown = succeed(study("parts", &format!("{roots} --restart")));
    contains!(shown, "root_stress_2_mpa");
    for sample in folder.rows("parts/samples.csv") {
        assert!(sample["root_stress_1_mpa"] > 20.0 && sample["root_stress_2_mpa"] > 20.0);
    }
    assert_eq!(charts("parts"), 6);
}

#[test]
fn tooth_thickness_is_varied_within_its_tolerance_whatever_measure_of_it_the_drawing_has() {
    let folder = Folder::new();
    let drawing = r#"{"name": "drawing", "meshing": "internal", "normal_module_mm": 2.5, "normal_pressure_angle_deg": 20,
        "center_distance_mm": -71.3542, THICKNESS
        "gear1": {"teeth": 27, "face_width_mm": 10, "profile_shift": 0.1, "tip_diameter_mm": 73, MEASURE},
        "gear2": {"teeth": -84, "face_width_mm": 10, "profile_shift": -0.15, "tip_diameter_mm": -206.25,
            "root_diameter_mm": -217, "tool_tip_radius_coefficient": 0.25, RING},
        "operating": {"nominal_torque_nm": 30, "maximum_torque_nm": 60, "center_distance_offset_um": [-10, 10],
            "misalignment_mrad": [0, 0]}}"#;
    for (field, limits, other) in [
        (
            "gear1.span_measurement_mm",
            "[26.7, 26.94]",
            "\"span_teeth\": 4",
        ),
        (
            "gear1.dimension_over_balls_mm",
            "[74.03, 74.41]",
            "\"ball_diameter_mm\": 4.5",
        ),
        (
            "gear1.normal_tooth_thickness_mm",
            "[3.85, 4.1]",
            "\"bore_diameter_mm\": 30",
        ),
        (
            "gear2.dimension_over_balls_mm",
            "[-205.4, -204.9]",
            "\"ball_diameter_mm\": 4.25",
        ),
        ("normal_backlash_um", "[40, 250]", ""),
    ] {
        let (part, name) = field.rsplit_once('.').unwrap_or(("", field));
        let given = format!("\"{name}\": {limits}");
        let gear = format!("{given}, {other}");
        let plain = "\"poisson_ratio\": 0.3";
        let text = drawing
            .replace(
                "THICKNESS",
                &if part.is_empty() {
                    format!("{given},")
                } else {
                    String::new()
                },
            )
            .replace("MEASURE", if part == "gear1" { &gear } else { plain })
            .replace("RING", if part == "gear2" { &gear } else { plain });
        let pair = folder.write("pair.json", text);
        let out = folder.path(field);
        let shown =
            succeed!("study {pair} --positions 3 --samples 3 --vary {field} -o {out} {QUICK}");
        contains!(shown, "elastic model of its own");
        let samples = folder.rows(&format!("{field}/samples.csv"));
        let ends: Vec<f64> = serde_json::from_str(limits).unwrap();
        assert!(
            samples
                .iter()
                .all(|s| (ends[0]..=ends[1]).contains(&s[field])),
            "{field}"
        );
        // Thinner teeth deflect farther.
        let mut stes: Vec<[f64; 2]> = (samples.iter())
            .map(|s| [s[field], s["mean_ste_loa_um"]])
            .collect();
        stes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (first, last) = (stes[0][1], stes[3][1]);
        let thicker_is_more = field != "normal_backlash_um";
        assert!(
            stes[0][0] < stes[3][0] && first != last,
            "{field}: {stes:?}"
        );
        assert_eq!(last < first, thicker_is_more, "{field}: {stes:?}");
    }
    refused!("study {PAPER} --vary gear1.tip_diameter_mm -o {} {QUICK}", folder.path("no"); "has no limits of it", "LOW..HIGH");
    refused!("study {PAPER} --vary gear1.tip_diameter_mm=90..91 -o {} {QUICK}", folder.path("no"); "elastic model of");
}

#[test]
fn the_start_of_a_relief_is_varied_in_any_form_that_the_pair_file_allows() {
    let folder = Folder::new();
    let out = folder.path("study");
    // The file has it at the pitch point.
    let vary = "--vary gear1.tip_relief.start.diameter_mm=83..87/3";
    succeed!("study {PAPER} --positions 4 -o {out} {vary} {QUICK}");
    let swings = folder.rows("study/samples.csv");
    let swings = swings
        .iter()
        .map(|s| s["peak_to_peak_ste_loa_um"].to_bits());
    assert_eq!(swings.collect::<std::collections::HashSet<_>>().len(), 4);
    let best = json(folder.read("study/best.json"));
    let start = number(&best["gear1"]["tip_relief"]["start"]["diameter_mm"]);
    assert!([83.0, 85.0, 87.0].contains(&start), "{start}");
}

#[test]
fn a_grid_begins_at_zero_of_a_relief_that_the_pair_file_does_not_have() {
    let folder = Folder::new();
    let pair = folder.pair(|pair| {
        for gear in ["gear1", "gear2"] {
            pair[gear].as_object_mut().unwrap().remove("tip_relief");
        }
    });
    let out = folder.path("study");
    let vary = "--vary gear1.tip_relief.amount_um=0..10/2 --vary gear1.tip_relief.start.diameter_mm=84..86/2";
    let shown = succeed!("study {pair} --positions 4 -o {out} {vary} {QUICK}");
    contains!(shown, "4 points of a grid, 0 refused");
    // Without an amount the start says nothing.
    let swings = folder.rows("study/samples.csv");
    let swings: Vec<f64> = swings
        .iter()
        .map(|s| s["peak_to_peak_ste_loa_um"])
        .collect();
    assert!(
        swings[1] == swings[0] && swings[3] == swings[0] && swings[2] != swings[4],
        "{swings:?}"
    );
}

#[test]
fn a_drawing_that_is_better_than_every_point_is_said() {
    let folder = Folder::new();
    let out = folder.path("study");
    let vary = "--vary gear1.tip_relief.amount_um,gear2.tip_relief.amount_um=70..80/2";
    let study = format!("study {PAPER} --positions 8 -o {out} {vary} {QUICK}");
    let note = "no point tried is better than the drawing";
    contains!(succeed!("{study}"), note);
    // A drawing that violates a requirement is no better one.
    let best = json(folder.read("study/study.json"))["best"].take();
    let [drawn, value] = ["as_drawn", "value"].map(|key| number(&best[key]));
    assert!(drawn < value, "{drawn} {value}");
    let between = 0.5 * (drawn + value);
    let shown = succeed!("{study} --require harmonic_1_loa_um>{between}");
    assert!(!shown.contains(note), "{shown}");
}

#[test]
fn a_grid_finds_the_relief_whose_point_is_best_and_writes_it_as_a_pair_file_with_bands_over_torque()
{
    let folder = Folder::new();
    let [out, page] = folder.paths(["study", "report.html"]);
    let reliefs = "--vary gear1.tip_relief.amount_um,gear2.tip_relief.amount_um=1..13/3";
    let options = format!("--positions 8 --torques-nm 60,100 {reliefs} {QUICK}");
    let study = format!("study {PAPER} -o {out} {options}");
    let more = "--vary gear1.lead_slope_um=+-6 --samples 2 --weights 1,3";
    let shown = succeed!("{study} {more}");
    contains!(shown, "3 points of a grid, 2 samples each");

    // Every point, as drawn first, with its samples at both torques; both gears share the relief.
    let samples = folder.rows("study/samples.csv");
    assert_eq!(samples.len(), 4 * 3 * 2);
    let [one, two] = ["gear1.tip_relief.amount_um", "gear2.tip_relief.amount_um"];
    assert!(samples.iter().all(|s| s[one] == s[two]));
    let measure = |point: f64, sample: f64| {
        let is_own = |s: &&HashMap<_, _>| s["point"] == point && s["sample"] == sample;
        let weight = |torque| if torque == 60.0 { 0.25 } else { 0.75 };
        let own = samples.iter().filter(is_own);
        own.map(|s| s["harmonic_1_loa_um"] * weight(s["torque_nm"]))
            .sum::<f64>()
    };
    let worst = |point| largest([0.0, 1.0, 2.0].map(|sample| measure(point, sample)));
    let mut points = [1.0, 2.0, 3.0];
    points.sort_by(|a, b| worst(*a).total_cmp(&worst(*b)));
    let best = points[0];
    let summary = json(folder.read("study/study.json"));
    assert_eq!(number(&summary["best"]["point"]), best);
    assert_eq!(shown.contains("at an end of the grid"), best != 2.0);
    assert!((number(&summary["best"]["value"]) - worst(best)).abs() < 1e-12);
    let written = json(folder.read("study/best.json"));
    let amount = number(&written["gear2"]["tip_relief"]["amount_um"]);
    assert_eq!(amount, 6.0 * best - 5.0);
    succeed!("inspect {out}/best.json");

    succeed!("report {PAPER} -o {page} --positions 4 --study {out} {QUICK}");
    contains!(folder.read("report.html"), "Band of 1st harm. over torque");

    refused!("{study} --best noise"; "give one of peak_to_peak_ste_loa_um");
    refused!("{study} --weights 1,2,3"; "one for each torque");
}

/// Both tip reliefs of the paper's pair within ranges about the best one.
const RELIEFS: [&str; 2] = [
    "gear1.tip_relief.amount_um,gear2.tip_relief.amount_um=0..30",
    "gear1.tip_relief.start.diameter_mm,gear2.tip_relief.start.diameter_mm=81..88",
];
const SWING: &str = "--best peak_to_peak_ste_loa_um --positions 16";

#[test]
fn the_optimizer_finds_the_relief_of_a_fine_grid_and_stopped_goes_on_the_same_way() {
    let folder = Folder::new();
    let [grid, whole, parts] = folder.paths(["grid", "whole", "parts"]);
    let fine = "--vary gear1.tip_relief.amount_um,gear2.tip_relief.amount_um=7..10/16 \
                --vary gear1.tip_relief.start.diameter_mm,gear2.tip_relief.start.diameter_mm=84..85.5/16";
    succeed!("study {PAPER} -o {grid} {fine} {SWING} {QUICK}");
    let [amount, start] = RELIEFS;
    let optimize = |out: &str, options: &str| {
        format!(
            "study {PAPER} -o {out} --vary {amount}/optimize --vary {start}/optimize {SWING} {QUICK} {options}"
        )
    };
    let output = run(optimize(&whole, ""));
    assert!(output.status.success());
    // The forecast comes before the work.
    contains!(
        text(&output.stderr),
        "at most 300 of 301 samples to solve",
        " s each",
        "Ctrl-C"
    );
    let best =
        |folder: &Folder, out: &str| json(folder.read(&format!("{out}/study.json")))["best"].take();
    let [on_grid, found] = ["grid", "whole"].map(|out| best(&folder, out));
    // The grid's own best point is a step away from the true one.
    let [least, value] = [&on_grid, &found].map(|best| number(&best["value"]));
    assert!(
        value < 1.02 * least && value > 0.8 * least,
        "{value} {least}"
    );
    assert!(number(&found["as_drawn"]) > 2.0 * value);
    for (field, step) in [("amount_um", 0.2), ("start.diameter_mm", 0.1)] {
        let field = format!("gear1.tip_relief.{field}");
        let [a, b] = [&on_grid, &found].map(|best| number(&best["fields"][&field]));
        assert!((a - b).abs() <= 2.5 * step, "{field}: {a} on the grid, {b}");
    }
    let written = json(folder.read("whole/best.json"));
    assert_eq!(
        number(&written["gear2"]["tip_relief"]["amount_um"]),
        number(&found["fields"]["gear2.tip_relief.amount_um"])
    );
    assert!(
        folder
            .read("whole/study.html")
            .contains("Measure of the points in their order")
    );

    contains!(
        succeed(optimize(&parts, "--points 25")),
        "25 points tried",
        "had not settled"
    );
    let few = folder.read("parts/samples.csv");
    assert!(folder.read("whole/samples.csv").starts_with(&few));
    succeed(optimize(&parts, ""));
    assert_eq!(
        folder.read("parts/samples.csv"),
        folder.read("whole/samples.csv")
    );
    refused(optimize(&parts, "--seed 2"), &["another study"]);
    refused(
        optimize(&parts, "--require edge_line_load_n_per_mm<=0"),
        &["another study"],
    );
    // A point that the optimizer never tried.
    folder.write(
        "parts/samples.csv",
        folder
            .read("parts/samples.csv")
            .replacen("\n1,0,100,", "\n1,0,100,9", 1),
    );
    refused(
        optimize(&parts, ""),
        &["point 1 is not the one", "--restart"],
    );
}

#[test]
fn requirements_hold_at_the_best_point_and_mark_samples_that_violate_them() {
    let folder = Folder::new();
    let [out, page] = folder.paths(["study", "study/study.html"]);
    let [amount, _] = RELIEFS;
    let study = |how: &str, options: &str| {
        format!(
            "study {PAPER} -o {out} --vary {amount}{how} --torques-nm 60,100 {SWING} {QUICK} {options}"
        )
    };
    let results = |point: f64, name: &str| {
        let rows = folder.rows("study/samples.csv").into_iter();
        let own = rows.filter(|row| row["point"] == point);
        largest(own.map(|row| row[name]))
    };
    // Without it the best point presses harder at 100 N m.
    let best = |line: String| {
        succeed(line);
        number(&json(folder.read("study/study.json"))["best"]["point"])
    };
    let free = results(best(study("/16", "")), "maximum_pressure_mpa");
    let limit = 0.99 * free;
    let require =
        format!("--require maximum_pressure_mpa<{limit} --require edge_line_load_n_per_mm<=200");
    // The samples are those of before, with other marks.
    let held = best(study("/16", &require));
    assert!(results(held, "maximum_pressure_mpa") < limit);
    let marked = |row: &csv::StringRecord| {
        row.iter()
            .any(|field| field.starts_with("maximum_pressure_mpa<"))
    };
    let mut table = csv::Reader::from_path(folder.path("study/samples.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.unwrap()).collect();
    for (row, numbers) in rows.iter().zip(folder.rows("study/samples.csv")) {
        let violates = results(numbers["point"], "maximum_pressure_mpa") >= limit;
        assert_eq!(marked(row), violates, "{row:?}");
    }
    let shown = succeed(study("/16", &require));
    contains!(
        shown,
        "violate it",
        &format!("maximum_pressure_mpa<{limit}")
    );

    // The optimizer on the same range keeps within the limit and is no worse.
    let measure = |summary: &str| number(&json(folder.read(summary))["best"]["value"]);
    let on_grid = measure("study/study.json");
    let restart = format!("{require} --restart");
    let found = best(study("/optimize", &restart));
    assert!(results(found, "maximum_pressure_mpa") < limit);
    assert!(measure("study/study.json") <= 1.001 * on_grid);

    // Nothing meets this: all is written but the best point, that of before included.
    let output = run(study("/3", "--require maximum_pressure_mpa<100 --restart"));
    assert_eq!(output.status.code(), Some(1));
    contains!(
        text(&output.stdout),
        "no point meets all requirements; point "
    );
    contains!(
        text(&output.stderr),
        "violates maximum_pressure_mpa<100",
        "relax a requirement"
    );
    assert!(!folder.exists("study/best.json") && Path::new(&page).exists());

    refused(
        study("/3", "--require pressure<3"),
        &[
            "--require = pressure",
            "give one of peak_to_peak_ste_loa_um, ",
        ],
    );
    refused(
        study("/3", "--require root_stress_1_mpa<300"),
        &["no result of this study", "--root-stress"],
    );
    refused(
        study("/3", "--require maximum_pressure_mpa"),
        &["RESULT<=LIMIT", "finite number"],
    );
    refused(study("/3", "--points 7"), &["--points = 7", "/optimize"]);
    let mixed = "--vary gear1.lead_crowning_um=0..5/optimize";
    refused(study("/3", mixed), &["on a grid beside fields to optimize"]);
    refused(study("/optimise", ""), &["/optimize", "/POINTS"]);
}
