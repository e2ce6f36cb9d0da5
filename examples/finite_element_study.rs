//! Measures the finite-element level of detail: `cargo run --release --example finite_element_study
//! [independent] [plane] [convergence] [bore]`; without arguments everything. Writes the comparison with the
//! independent finite-element program as docs/finite-elements/independent.csv and prints the other tables of
//! docs/finite-elements.md.

use gearmesh::compliance::finite_element::{Discretization, PairCompliance, Settings};
use gearmesh::contact::{ContactSettings, ContactSolver, CycleInput, MeshCycle};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use serde_json::Value;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    let wants = |name: &str| chosen.is_empty() || chosen.iter().any(|c| c == name);
    if wants("independent") {
        let path = Path::new("docs/finite-elements/independent.csv");
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
        let unfinished = path.with_extension("csv.part");
        std::fs::write(&unfinished, independent()?)?;
        std::fs::rename(&unfinished, path)?;
    }
    if wants("plane") {
        plane()?;
    }
    if wants("convergence") {
        for (name, text, torque) in [
            ("spur", spur(0.5), 100.0),
            ("reference", reference(30.0), 100.0),
        ] {
            convergence(name, &text, torque)?;
        }
    }
    if wants("bore") {
        bore()?;
    }
    Ok(())
}

/// A spur pair with the plane-strain data of the documentation.
fn plane_pair(teeth: [u32; 2], module: f64, tool: f64, bore_ratio: f64) -> String {
    let gear = |z: u32| {
        let bore = bore_ratio * module * (f64::from(z) - 2.5);
        format!(
            r#"{{"teeth": {z}, "profile_shift": 0.0, "face_width_mm": 10.0, "dedendum_coefficient": 1.25,
            "tool_tip_radius_coefficient": {tool}, "bore_diameter_mm": {bore}}}"#
        )
    };
    format!(
        r#"{{"name": "plane", "meshing": "external", "normal_module_mm": {module}, "normal_pressure_angle_deg": 20.0,
        "helix_angle_deg": 0.0, "gear1": {}, "gear2": {},
        "operating": {{"nominal_torque_nm": 100.0, "maximum_torque_nm": 400.0,
        "center_distance_offset_um": [0, 0], "misalignment_mrad": [0, 0]}}}}"#,
        gear(teeth[0]),
        gear(teeth[1])
    )
}

fn spur(bore_ratio: f64) -> String {
    plane_pair([20, 20], 4.0, 0.38, bore_ratio)
        .replace("\"face_width_mm\": 10.0", "\"face_width_mm\": 25.0")
}

fn reference(bore_mm: f64) -> String {
    let gear = format!(
        r#"{{"teeth": 20, "profile_shift": 0.0, "face_width_mm": 25.0, "tip_diameter_mm": 90.315, "bore_diameter_mm": {bore_mm}}}"#
    );
    format!(
        r#"{{"name": "reference", "meshing": "external", "normal_module_mm": 4.0, "normal_pressure_angle_deg": 20.0,
        "helix_angle_deg": 13.0, "center_distance_mm": 82.104, "gear1": {gear}, "gear2": {gear},
        "operating": {{"nominal_torque_nm": 100.0, "maximum_torque_nm": 200.0,
        "center_distance_offset_um": [-100, 100], "misalignment_mrad": [-3, 3]}}}}"#
    )
}

/// Mean and peak-to-peak STE, um, and the seconds of compliance and contact.
fn solve(
    pair: &Pair,
    settings: &Settings,
    contact: ContactSettings,
    torque: f64,
    positions: usize,
) -> Outcome<[f64; 4]> {
    let begin = Instant::now();
    let compliance = PairCompliance::new(&pair.geometry, settings, None, &|_, _, _| true)?;
    let elastic = begin.elapsed().as_secs_f64();
    let [first, second] = compliance.gears;
    let solver = ContactSolver::new(pair, [first, second], contact)?;
    let cycle = MeshCycle::solve(
        &solver,
        &CycleInput {
            flank: Flank::Drive,
            torque,
            center_distance_offset: 0.0,
            misalignment: 0.0,
            positions,
        },
    )?;
    Ok([
        1e6 * cycle.mean_ste(),
        1e6 * cycle.peak_to_peak_ste(),
        elastic,
        cycle.solve_seconds,
    ])
}

/// Every case of tests/data/finite_element_contact.json at every position and torque; prints the largest
/// error, those of the mean and of the peak-to-peak value per torque.
fn independent() -> Outcome<String> {
    let text = std::fs::read_to_string("tests/data/finite_element_contact.json")?;
    let data: Value = serde_json::from_str(&text)?;
    let mut csv = String::from("case,torque_nm,mesh_position,ste_um,independent_ste_um\n");
    println!("independent finite elements: errors in % of mean, p-p, largest of a position");
    for (name, case) in data["cases"].as_object().ok_or("no cases")? {
        let mut description = case["pair"].clone();
        // The ring's tip is longer than pair files may have it.
        let long_tip = description["gear2"]["tip_diameter_mm"] == 175.2;
        if long_tip {
            description["gear2"]["tip_diameter_mm"] = 174.8.into();
        }
        let mut pair = Pair::from_json(&description.to_string())?;
        if long_tip {
            pair.geometry.gears[1].tip_radius = 87.6e-3;
        }
        let plane_strain = case["plane_strain"] == true;
        let settings = Settings {
            plane_strain,
            ..Settings::for_pair(&pair)
        };
        let begin = Instant::now();
        let compliance = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)?;
        let seconds = begin.elapsed().as_secs_f64();
        let contact = ContactSettings {
            stations: if plane_strain { 1 } else { 40 },
            ..ContactSettings::default()
        };
        let [first, second] = compliance.gears;
        let solver = ContactSolver::new(&pair, [first, second], contact)?;
        let list = |v: &Value| v.as_array().cloned().unwrap_or_default();
        let number = |v: &Value| v.as_f64().ok_or("not a number");
        println!("{name}: {} ({seconds:.1} s)", case["title"]);
        for (n, torque) in list(&case["torque_nm"]).iter().enumerate() {
            let torque = number(torque)?;
            let (mut found, mut expected) = (Vec::new(), Vec::new());
            for at in list(&case["positions"]) {
                let mesh_position = number(&at["mesh_position"])?;
                let problem = solver.position(Flank::Drive, mesh_position, 0.0)?;
                let ste = 1e6 * problem.solve_torque(torque, 0.0, None)?.approach;
                let reference = number(&at["ste_um"][n])?;
                writeln!(csv, "{name},{torque},{mesh_position},{ste:.4},{reference}")?;
                found.push(ste);
                expected.push(reference);
            }
            let sum = |v: &[f64]| v.iter().sum::<f64>();
            let spread = |v: &[f64]| {
                let ends = v
                    .iter()
                    .fold([f64::MAX, f64::MIN], |e, x| [e[0].min(*x), e[1].max(*x)]);
                ends[1] - ends[0]
            };
            let error = |a: f64, b: f64| 100.0 * (a / b - 1.0);
            let largest = found
                .iter()
                .zip(&expected)
                .map(|(a, b)| error(*a, *b))
                .fold(0.0, |m: f64, e| if e.abs() > m.abs() { e } else { m });
            println!(
                "  {torque:5} N m  {:+.2}  {:+.2}  {largest:+.2}",
                error(sum(&found), sum(&expected)),
                error(spread(&found), spread(&expected))
            );
        }
    }
    Ok(csv)
}

fn plane() -> Outcome<()> {
    println!("plane strain, contact on the path only: STE mean and p-p, um");
    for (teeth, module, tool, load, bore, mean, p_p) in [
        ([28, 28], 3.175, 0.3, 250.0, 1.0 / 1.4, 12.222, 5.854),
        ([28, 28], 3.175, 0.3, 250.0, 0.5, 14.529, 5.949),
        ([50, 50], 3.0, 0.38, 177.0, 1.0 / 1.4, 8.110, 3.803),
        ([50, 50], 3.0, 0.38, 177.0, 0.5, 9.639, 3.818),
        ([17, 43], 1.0, 0.38, 100.0, 1.0 / 1.4, 4.947, 2.373),
        ([17, 43], 1.0, 0.38, 100.0, 0.5, 5.890, 2.427),
    ] {
        let mut pair = Pair::from_json(&plane_pair(teeth, module, tool, bore))?;
        // Line load in N/mm on a face of 10 mm.
        let torque = load * 10.0 * pair.geometry.gears[0].base_radius();
        pair.operating.maximum_torque = torque;
        let settings = Settings {
            plane_strain: true,
            ..Settings::for_pair(&pair)
        };
        let contact = ContactSettings {
            stations: 1,
            tip_corner_contact: false,
            reach: None,
        };
        let found = solve(&pair, &settings, contact, torque, 20)?;
        println!(
            "{teeth:?} m {module} bore {bore:.3}: {:.3} ({:+.2} %)  {:.3} ({:+.2} %)",
            found[0],
            100.0 * (found[0] / mean - 1.0),
            found[1],
            100.0 * (found[1] / p_p - 1.0)
        );
    }
    Ok(())
}

fn convergence(name: &str, text: &str, torque: f64) -> Outcome<()> {
    println!("{name}: STE mean, p-p um, compliance s, cycle s");
    let pair = Pair::from_json(text)?;
    let normal = Discretization::of(Refinement::Normal);
    let stations = |n| ContactSettings {
        stations: n,
        ..ContactSettings::default()
    };
    let variants: Vec<(&str, Discretization, usize)> = vec![
        ("coarse", Discretization::of(Refinement::Coarse), 40),
        ("normal", normal, 40),
        ("fine", Discretization::of(Refinement::Fine), 40),
        (
            "section x 2/3",
            Discretization {
                flank_element: 0.08,
                tooth_element: 0.3,
                root_element: 0.17,
                growth: 1.25,
                ..normal
            },
            40,
        ),
        (
            "layers x 1/2",
            Discretization {
                layer: 0.375,
                end_layer: 0.15,
                ..normal
            },
            40,
        ),
        (
            "kernel 0.12",
            Discretization {
                kernel_half_width: 0.12,
                ..normal
            },
            40,
        ),
        (
            "kernel 0.25",
            Discretization {
                kernel_half_width: 0.25,
                ..normal
            },
            40,
        ),
        ("20 stations", normal, 20),
        ("80 stations", normal, 80),
    ];
    for (label, discretization, n) in variants {
        let settings = Settings {
            discretization,
            ..Settings::for_pair(&pair)
        };
        let [mean, p_p, elastic, contact] = solve(&pair, &settings, stations(n), torque, 32)?;
        println!("{label:16} {mean:8.4} {p_p:8.4} {elastic:7.2} {contact:7.2}");
    }
    Ok(())
}

fn bore() -> Outcome<()> {
    println!("reference pair, bore diameter mm: STE mean, p-p um at 100 N m");
    for bore in [20.0, 30.0, 40.0, 50.0, 60.0] {
        let pair = Pair::from_json(&reference(bore))?;
        let settings = Settings::for_pair(&pair);
        let [mean, p_p, ..] = solve(&pair, &settings, ContactSettings::default(), 100.0, 32)?;
        println!("{bore:5.1} {mean:8.4} {p_p:8.4}");
    }
    Ok(())
}
