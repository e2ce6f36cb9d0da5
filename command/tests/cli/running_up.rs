//! Run-ups of an FMU.

use super::*;

/// A sweep that takes a moment.
const SHORT: &str =
    "--inertia-kg-m2 4e-3 4e-3 --damping-ratio 0.05 --speed-rpm 2000 9000 --sweep-s 0.05";

#[test]
fn a_run_up_is_a_page_with_swings_orders_and_spectra_of_both_ways_and_signals_for_numpy() {
    let folder = Folder::new();
    let [fmu, page, figures, signals] = folder.paths(["p.fmu", "p.html", "figures", "signals"]);
    succeed!("pack --pair {PAPER} -o {fmu}");
    let text =
        succeed!("run-up {fmu} -o {page} --figures {figures} --signals {signals} {SHORT} --json");
    let found: Value = serde_json::from_str(&text).unwrap();
    // sqrt(k (r1^2/J1 + r2^2/J2)) of the stiffness that the FMU starts with.
    let listing = succeed!("inspect {fmu}");
    let line = listing
        .lines()
        .find(|line| line.contains("constantStiffness"));
    let stiffness: f64 = line
        .unwrap()
        .split_whitespace()
        .rev()
        .nth(1)
        .unwrap()
        .parse()
        .unwrap();
    let radius = 0.5 * 82.104e-3;
    let expected = (stiffness * 2.0 * radius * radius / 4e-3).sqrt() / std::f64::consts::TAU;
    let frequency = found["natural_frequency_hz"].as_f64().unwrap();
    assert!(
        (frequency / expected - 1.0).abs() < 1e-3,
        "{frequency} {expected}"
    );
    let html = folder.read("p.html");
    for heading in [
        "Transmission error in run-up and run-down",
        "Dynamic factor",
        "Orders in the run-down",
        "Spectra in the run-up",
    ] {
        contains!(html, heading);
    }
    contains!(html, "acceleration of gear 2 (dB re 1 rad/s2)");
    assert_eq!(folder.count("figures"), 2 * html.matches("<svg").count());
    let array = std::fs::read(format!("{signals}/up.npy")).unwrap();
    let steps = (0.05 / found["step_s"].as_f64().unwrap()).round() as usize;
    assert!(array.starts_with(b"\x93NUMPY\x01\x00"));
    let head = 10 + usize::from(u16::from_le_bytes([array[8], array[9]]));
    assert_eq!((head % 64, array.len()), (0, head + steps * 8 * 8));
}

#[test]
fn what_cannot_be_swept_is_refused() {
    let folder = Folder::new();
    let [fmu, page] = folder.paths(["p.fmu", "p.html"]);
    succeed!("pack --pair {PAPER} -o {fmu}");
    refused!("run-up {} -o {} --torque-nm 0", fmu, page; "torque", "other than 0");
    refused!("run-up {} -o {} --step-s 1e-4", fmu, page; "rad of the natural frequency");
    refused!("run-up {} -o {} --speed-rpm 9000 2000", fmu, page; "--speed-rpm 9000 2000", "higher");
    refused!("run-up {} -o {} --inertia-kg-m2 0 1", fmu, page; "--inertia-kg-m2", "> 0");
    refused!("run-up {} -o {} --damping-ratio 0", fmu, page; "nothing decays");
    refused!("run-up {} -o {}", PAPER, page; "palermo2013.json");
    assert_eq!(folder.count(""), 1);
    for (set, reason) in [
        ("damping=500", "--damping-ratio"),
        ("effectiveMass=1", "--inertia-kg-m2"),
        ("coupling=held", "sequential"),
        ("gear1.angularVelocity[3]=9", "--speed-rpm"),
    ] {
        refused!("run-up {fmu} -o {page} --set {set}"; format!("--set {set}: "), reason);
    }
    let twice = "--set backlash=0.0001 --set backlash=0.0002";
    let both = "--set backlash=0.0001 and --set backlash=0.0002: give one";
    refused!("run-up {fmu} -o {page} {twice}"; both);
    refused!("pack --pair {PAPER} -o {page} {twice}"; both);
    // What is read or in the way is known before the run.
    let pair = super::solving::on_bearings(&folder);
    refused!("run-up {fmu} -o {pair} --shafts {pair}"; "on-bearings.json, which is read");
    let signals = folder.path("signals");
    std::fs::create_dir_all(folder.path("signals/down.npy")).unwrap();
    refused!("run-up {fmu} -o {page} --signals {signals} --torque-nm 0"; "cannot write", "down.npy");
}
