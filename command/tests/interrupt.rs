//! Ctrl-C while the command computes.

#![cfg(unix)]

use std::io::Write;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};

/// What lies in `folder`.
fn names(folder: &Path) -> Vec<String> {
    std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect()
}

#[test]
fn an_interrupt_ends_long_work_and_leaves_no_file() {
    let pair = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../resources/pairs/palermo2013.json"
    );
    for signal in ["INT", "TERM"] {
        let folder = tempfile::tempdir().unwrap();
        let (out, cache) = (folder.path().join("out"), folder.path().join("cache"));
        std::fs::create_dir(&out).unwrap();
        // Tables to a small error take minutes once the elastic model is there.
        let mut child = Command::new(env!("CARGO_BIN_EXE_gearmesh"))
            .args(["tables", pair, "--refinement", "coarse"])
            .args(["--max-error", "0.0005", "--threads", "1", "-o"])
            .arg(out.join("tables.json"))
            .arg("--cache-dir")
            .arg(&cache)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // The shell's own `kill`: the program of this name is not everywhere.
        let mut kill = Command::new("sh")
            .args(["-c", &format!("read line; kill -{signal} {}", child.id())])
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        // In the middle of the model's file as a rule, without which this would prove little.
        while !cache.exists() || names(&cache).is_empty() {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        }
        kill.stdin.take().unwrap().write_all(b"now\n").unwrap();
        assert!(kill.wait().unwrap().success());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(
            ended.status.code(),
            Some(130),
            "{:?}",
            ended.status.signal()
        );
        let text = String::from_utf8(ended.stderr).unwrap();
        assert!(text.contains("stopped"), "{text}");
        assert_eq!(names(&out), Vec::<String>::new());
        let kept = |name: &String| name.ends_with(".compliance");
        assert!(names(&cache).iter().all(kept), "{:?}", names(&cache));
    }
}
