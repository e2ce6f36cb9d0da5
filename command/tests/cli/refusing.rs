//! What the command refuses, by name and with a remedy, before it computes or writes.

use super::*;
use std::io::Write;

#[test]
fn files_options_and_numbers_that_cannot_be_are_refused_by_name_and_nothing_is_written() {
    let folder = Folder::new();
    let out = folder.path("out");
    refused!("inspect no-such-pair.json"; "no-such-pair.json");
    let pair = folder.pair(|pair| pair["helix_deg"] = 13.0.into());
    refused!("inspect {pair}"; "`helix_deg`");
    // Field = value: problem; remedy.
    let pair = folder.pair(|pair| pair["normal_module_mm"] = (-4.0).into());
    refused!("inspect {pair}"; "normal_module_mm", "-4", ";");

    let new = "new --teeth 23 81 --face-width-mm 30 28 --torque-nm 120 --module-mm";
    refused!("{new} 0.002"; "normal_module_mm", "0.002 m is 2 mm");
    refused!("{new} -1.75"; "'-1.75' for '--module-mm <MODULE_MM>': give a number above 0");
    refused!("{new} nan"; "'nan' for '--module-mm <MODULE_MM>': give a finite number");
    refused!("{new} 2 --pressure-angle-deg 0"; "`normal_pressure_angle_deg` = 0");
    let stages = format!("new --rexs {REXS}/stages.rexsj");
    refused!("{stages}"; "2 cylindrical stages: 1 (Planet and ring), 4 (Second)");
    refused!("{stages} --stage 7"; "--stage = 7");
    refused!("{stages} --stage 4"; "gear2.face_width_mm");
    refused!("new --rexs {REXS}/../../Cargo.toml"; "no REXS file");

    let solve = format!("solve {PAPER} {QUICK}");
    refused!("{solve} --compliance analytical"; "'--compliance'");
    // No option of this name, but a value.
    refused!("{solve} --torque-nm -10"; "'-10' for '--torque-nm", "--flank coast");
    // A torque that rounding outweighs, too.
    for torque in ["nan", "1e-20", "1e300", "much"] {
        refused!("{solve} --torque-nm={torque}"; &format!("'{torque}' for '--torque-nm <TORQUE_NM>': give 0 or a value from 1e-9 to 1e9"));
    }
    // Tips meet roots.
    refused!("{solve} --center-distance-offset-um -2500"; "--center-distance-offset-um = -2500", "root of its mate", "more than -");

    // However root stress is requested.
    refused!("build --contact --plane-strain --set rootStress=true {PAPER} -o {out}"; "leave out `rootStress`, --plane-strain or --contact");
    refused!("tables --max-error 0 {PAPER} -o {out}"; "--max-error");
    refused!("pack --tables {PAPER} -o {out}"; "`--pair`");

    let torque = "'-5' for '--torques-nm <TORQUES>': give 0 or a value from 1e-9 to 1e9\n";
    refused!("report {PAPER} -o {out} --torques-nm=50,-5"; torque);
    refused!("report {PAPER} -o {out} --largest-speed-rpm 0"; "'0' for '--largest-speed-rpm <SPEED>': give a value from 1");
    let study = format!("study {PAPER} -o {out}");
    refused!("{study} --torque-nm=-5"; torque);
    refused!("{study} --vary gear1.lead_slop_um=0..1"; "lead_slop_um");
    refused!("{study} --vary gear1.bore_diameter_mm=28..30"; "teeth");
    refused!("{study} --vary gear1.lead_crowning_um=-5..5"; "lead_crowning_um");
    refused!("{study} --vary misalignment_mrad=0..90"; "--vary misalignment_mrad = 90:");
    refused!("{study} --vary misalignment_mrad=0..1e300"; "--vary misalignment_mrad = 1e300: give");
    refused!("{study} --vary torque_nm=-5..5"; "--vary torque_nm = -5: give");
    refused!("{study} --vary torque_nm=50..100/3"; "give them as --torques-nm");
    refused!("{study} --vary operating.nominal_torque_nm=+-50"; "vary modifications");
    refused!("{study} --vary friction.coefficient=0.01..0.2"; "vary modifications");
    refused!("{study} --vary gear1.coast_flank.lead_slope_um=0..5"; "drive flank");
    refused!("{study}"; "--iso-1328-class");
    refused!("{study} --iso-1328-class Q6"; "'Q6' for '--iso-1328-class <CLASS>': give a class from 1 to 11, a bare number");
    // Two positions have no harmonic.
    refused!("{study} --iso-1328-class 6 --positions 2"; "'2' for '--positions <POSITIONS>': give a value from 3");
    assert!(!folder.exists("out"));
}

#[test]
fn what_is_read_is_not_written_over() {
    let folder = Folder::new();
    let pair = folder.pair(|_| ());
    let before = folder.read("pair.json");
    let tables = folder.write("tables.json", "tables");
    // By another name, too.
    let link = folder.path("link.json");
    std::os::unix::fs::symlink(&pair, &link).unwrap();
    for output in [&pair, &link] {
        for command in "pack --pair|tables|build|report|import none.csv --pair".split('|') {
            refused!("{command} {pair} -o {output}"; "which is read");
        }
    }
    refused!("report {PAPER} --tables {tables} -o {tables}"; "which is read");
    assert_eq!(folder.read("pair.json"), before);
    assert_eq!(folder.read("tables.json"), "tables");
}

#[test]
fn a_file_or_folder_that_cannot_be_made_is_named_with_what_was_tried() {
    let folder = Folder::new();
    let below = format!("{}/below", folder.write("file", ""));
    let page = folder.path("page.html");
    let failed = format!(" = {below}: making this folder failed: ");
    refused!("solve -o {below} {PAPER}"; "--output", &failed);
    refused!("study -o {below} --vary torque_nm=1..5 {PAPER}"; "--output", &failed);
    refused!("report -o {page} --figures {below} {PAPER}"; "--figures", &failed);
    refused!("report {PAPER} -o {below}/page.html"; &below);
    assert!(!folder.exists("page.html"));
}

#[test]
fn a_file_without_end_and_an_archive_that_unfolds_without_bound_are_refused() {
    let folder = Folder::new();
    let [long, bomb] = folder.paths(["long.json", "bomb.fmu"]);
    // A hole: nothing of it lies on the disk.
    let file = std::fs::File::create(&long).unwrap();
    file.set_len(1 << 40).unwrap();
    for command in ["inspect", "solve", "pack -o x.fmu --tables"] {
        refused!("{command} {long}"; "longer than");
    }
    let mut archive = zip::ZipWriter::new(std::fs::File::create(&bomb).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file("resources/unit.json", options).unwrap();
    // 300 MB of blanks in less than one.
    for _ in 0..300 {
        archive.write_all(&[b' '; 1 << 20]).unwrap();
    }
    archive.finish().unwrap();
    assert!(std::fs::metadata(&bomb).unwrap().len() < 1 << 20);
    refused!("inspect {bomb}"; "resources/unit.json unfolds into more than 256 MB");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_line_without_the_temporary_name() {
    let folder = Folder::new();
    let path = folder.path("pair.json");
    let full = std::fs::File::options().write(true).open("/dev/full");
    let mut new = command();
    let new = new.arg("new").args(NEW.split(' ')).stdout(full.unwrap());
    refusal(&new.output().unwrap(), &["standard output", "make room"]);
    // No file may grow; the signal that says so is ignored.
    let mut shell = Command::new("sh");
    let new = shell
        .args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$@\"", "sh"])
        .args([env!("CARGO_BIN_EXE_gearmesh"), "new", "-o", &path])
        .args(NEW.split(' '));
    let output = new.output().unwrap();
    refusal(&output, &["pair.json"]);
    assert!(!text(&output.stderr).contains(".gearmesh-"));
    assert_eq!(folder.count(""), 0);
}
