//! What a new user's first files meet: `gearmesh new`, and files that are too large or hostile to be looked into.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};

fn gearmesh(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gearmesh"))
        .args(arguments)
        .output()
        .expect("the command starts")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

/// Options of `gearmesh new` for a few pairs.
const PAIRS: [&str; 5] = [
    "--teeth 23 81 --module-mm 1.75 --face-width-mm 30 28 --torque-nm 120 --helix-angle-deg -29.5",
    "--teeth 24 36 --module-mm 3 --face-width-mm 20 20 --torque-nm 100",
    "--teeth 12 70 --module-mm 0.5 --face-width-mm 6 5 --torque-nm 0.4",
    "--teeth 27 84 --module-mm 2 --face-width-mm 20 24 --torque-nm 80 --internal",
    "--teeth 17 103 --module-mm 8 --face-width-mm 100 100 --torque-nm 9000 --pressure-angle-deg 25",
];

#[test]
fn a_new_pair_file_is_commented_and_accepted_as_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    for (i, options) in PAIRS.iter().enumerate() {
        let path = folder.path().join(format!("pair-{i}.json"));
        let path = path.to_str().unwrap();
        let mut arguments = vec!["new", "-o", path];
        arguments.extend(options.split(' '));
        let made = gearmesh(&arguments);
        assert!(made.status.success(), "{options}: {}", text(&made.stderr));
        assert!(
            std::fs::read_to_string(path)
                .unwrap()
                .contains("// > 0: gear 1")
        );
        let seen = gearmesh(&["inspect", path]);
        assert!(seen.status.success(), "{options}: {}", text(&seen.stderr));
        let seen = text(&seen.stdout);
        assert!(seen.starts_with(&format!("pair-{i}\n")), "{seen}");
        let notes: Vec<&str> = seen.lines().filter(|l| l.starts_with("note:")).collect();
        // The pinion's fillet asks for it, in whatever ring it turns.
        let is_known = |note: &&str| note.contains("tips of the ring are shortened");
        assert!(notes.iter().all(is_known), "{options}: {seen}");
    }
}

#[test]
fn a_new_pair_file_overwrites_nothing_and_without_a_name_goes_to_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.json");
    std::fs::write(&path, "mine").unwrap();
    let mut arguments = vec!["new", "-o", path.to_str().unwrap()];
    arguments.extend(PAIRS[0].split(' '));
    let refused = gearmesh(&arguments);
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused.stderr).contains("is there already"));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    arguments.drain(1..3);
    let printed = gearmesh(&arguments);
    assert!(printed.status.success());
    assert!(text(&printed.stdout).contains("\"teeth\": 23"));
}

#[test]
fn a_new_pair_that_cannot_work_is_refused_by_field() {
    let options = "new --teeth 23 81 --module-mm 0.002 --face-width-mm 30 28 --torque-nm 120";
    let refused = gearmesh(&options.split(' ').collect::<Vec<_>>());
    assert_eq!(refused.status.code(), Some(1));
    let error = text(&refused.stderr);
    assert!(
        error.contains("normal_module_mm") && error.contains("0.002 m is 2 mm"),
        "{error}"
    );
}

/// An archive with these entries.
fn archive(path: &Path, entries: &[(&str, &[u8], usize)]) {
    let mut archive = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    for (name, part, times) in entries {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(*name, options).unwrap();
        for _ in 0..*times {
            archive.write_all(part).unwrap();
        }
    }
    archive.finish().unwrap();
}

#[test]
fn an_archive_that_unfolds_without_bound_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.fmu");
    // 300 MB of blanks in less than one.
    archive(&path, &[("resources/unit.json", &[b' '; 1 << 20], 300)]);
    assert!(path.metadata().unwrap().len() < 1 << 20);
    let refused = gearmesh(&["inspect", path.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(1));
    let error = text(&refused.stderr);
    assert!(
        error.contains("resources/unit.json unfolds into more than 256 MB"),
        "{error}"
    );
}

#[test]
fn a_file_without_end_is_refused_by_its_length() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.json");
    let file = std::fs::File::create(&path).unwrap();
    // A hole: nothing of it lies on the disk.
    file.set_len(1 << 40).unwrap();
    for arguments in [
        vec!["inspect", path.to_str().unwrap()],
        vec!["solve", path.to_str().unwrap()],
        vec!["pack", "-o", "x.fmu", "--tables", path.to_str().unwrap()],
    ] {
        let refused = gearmesh(&arguments);
        assert_eq!(refused.status.code(), Some(1));
        let error = text(&refused.stderr);
        assert!(error.contains("longer than"), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_line() {
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let mut arguments = vec!["new"];
    arguments.extend(PAIRS[1].split(' '));
    let output = Command::new(env!("CARGO_BIN_EXE_gearmesh"))
        .args(arguments)
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let error = text(&output.stderr);
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(
        error.contains("standard output") && error.contains("make room"),
        "{error}"
    );
}
