//! Time and memory of the elastic models.

use crate::data::Data;
use crate::timing::timed;
use crate::{Context, Result, in_repository};
use gearmesh_preprocessor::finite_element::{PairCompliance, Settings, sector_unknowns};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::pair;
use std::process::{Command, Stdio};

const SHIPPED: &str = "resources/pairs";
const DRIVELINES: &str = "examples/drivelines/pairs";
const CASES: [(&str, &str, &str); 9] = [
    (SHIPPED, "palermo2013", "coarse"),
    (SHIPPED, "palermo2013", "normal"),
    (SHIPPED, "palermo2013", "fine"),
    (SHIPPED, "fzg-c", "normal"),
    (SHIPPED, "helical-25-47", "normal"),
    (SHIPPED, "planet-ring-27-84", "normal"),
    (DRIVELINES, "spur-50-50", "normal"),
    (DRIVELINES, "grc-sun-planet", "normal"),
    (DRIVELINES, "grc-planet-ring", "normal"),
];

/// A pair of a passenger car, with what holds its pinion in place of `BODY`.
const CAR: &str = r#"{
    "name": "car pair", "meshing": "external", "normal_module_mm": 2.0, "normal_pressure_angle_deg": 20.0,
    "helix_angle_deg": 24.0, "center_distance_mm": 137.0,
    "gear1": { "teeth": 37, "face_width_mm": 31.6, BODY },
    "gear2": { "teeth": 88, "face_width_mm": 31.6, "bore_diameter_mm": 60.0 },
    "operating": {
        "nominal_torque_nm": 250.0, "maximum_torque_nm": 500.0,
        "center_distance_offset_um": [-50.0, 50.0], "misalignment_mrad": [-1.0, 1.0]
    }
}"#;
const PINIONS: [(&str, &str); 2] = [
    ("car pair 37/88", r#""bore_diameter_mm": 38.0"#),
    (
        "the same on a pinion shaft",
        r#""shaft": {
            "lower": { "diameter_mm": 60, "length_mm": 20 }, "upper": { "diameter_mm": 50, "length_mm": 60 }, "held": "upper"
        }"#,
    ),
];

/// Prints unknowns, seconds, processor seconds and the largest memory (MB) of the elastic models of the pair file `path`, as the
/// cells of a row.
pub fn measure(path: &str, level: &str) -> Result<()> {
    let refinement: Refinement = serde_json::from_value(level.into())?;
    let pair = pair::read(path)?;
    let pair = Pair { refinement, ..pair };
    let settings = Settings::for_pair(&pair);
    let go_on = |_, _, _| true;
    let compute = || PairCompliance::new(&pair.geometry, &settings, None, &go_on);
    let (models, seconds) = timed(compute);
    models?;
    let gears = pair.geometry.gears.each_ref();
    let [first, second] = gears.map(|gear| sector_unknowns(gear, &settings));
    let unknowns = first?.max(second?);
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"));
    let kilobytes = line.and_then(|l| l.split_whitespace().nth(1));
    let kilobytes: f64 = kilobytes.ok_or("no VmHWM in /proc/self/status")?.parse()?;
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    // Fields 14 and 15, in hundredths of a second on Linux; the name in parentheses may hold spaces.
    let fields = stat.rsplit(')').next().unwrap_or_default();
    let times: Vec<&str> = fields.split_whitespace().skip(11).take(2).collect();
    let processor = (times[0].parse::<f64>()? + times[1].parse::<f64>()?) / 100.0;
    let megabytes = kilobytes / 1024.0;
    print!("{unknowns:.0} | {seconds:.1} | {processor:.1} | {megabytes:.0}");
    Ok(())
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let written = tempfile::tempdir()?;
    let mut cases = vec![];
    for (folder, pair, level) in CASES {
        let file = in_repository(&format!("{folder}/{pair}.json"));
        cases.push((file, pair, level));
    }
    for (pair, body) in PINIONS {
        let file = written.path().join(format!("{}.json", cases.len()));
        std::fs::write(&file, CAR.replace("BODY", body))?;
        cases.push((file, pair, "normal"));
    }
    if context.quick {
        cases.truncate(2);
    }
    let mut rows = vec![];
    for (file, pair, level) in cases {
        eprintln!("    {pair}, {level}");
        // In a process of its own, whose memory is that of the models alone.
        let mut command = Command::new(std::env::current_exe()?);
        command.arg("--measure").arg(file).arg(level);
        let output = command.stderr(Stdio::inherit()).output()?;
        if !output.status.success() {
            return Err(format!("{pair}, {level}: {}", output.status).into());
        }
        let cells = String::from_utf8(output.stdout)?;
        rows.push(format!("{pair}, {level} | {cells}"));
    }
    let head = "pair, level | unknowns of the larger sector | s | processor s | peak memory, MB";
    data.table("compliance-cost", head, &rows)
}
