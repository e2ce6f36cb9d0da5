//! Ctrl-C while the command computes.

use super::*;
use std::io::Write;
use std::process::Stdio;

/// What lies in `folder`; nothing where it is not there.
fn names(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn an_interrupt_ends_long_work_and_leaves_no_file() {
    for signal in ["INT", "TERM"] {
        let folder = Folder::new();
        let [out, cache] = folder.paths(["out", "cache"]);
        std::fs::create_dir(&out).unwrap();
        // Tables to a small error take minutes once the elastic model is there.
        let line = format!(
            "tables {PAPER} --refinement coarse --max-error 0.0005 --threads 1 -o {out}/tables.json --cache-dir {cache}"
        );
        let mut child = command();
        let child = child.args(line.split_whitespace()).stderr(Stdio::piped());
        let mut child = child.spawn().unwrap();
        // The shell's own `kill`: the program of this name is not everywhere.
        let mut kill = Command::new("sh")
            .args(["-c", &format!("read line; kill -{signal} {}", child.id())])
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        // In the middle of the model's file as a rule, without which this would prove little.
        while names(&cache).is_empty() {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        }
        kill.stdin.take().unwrap().write_all(b"now\n").unwrap();
        assert!(kill.wait().unwrap().success());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(130), "{:?}", ended.status);
        let error = text(&ended.stderr);
        contains!(error, "stopped");
        assert_eq!(names(&out), Vec::<String>::new());
        let is_model = |name: &String| name.ends_with(".compliance");
        assert!(names(&cache).iter().all(is_model), "{:?}", names(&cache));
    }
}
