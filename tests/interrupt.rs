//! Ctrl-C while the command computes.

#![cfg(unix)]

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

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
        "/resources/pairs/palermo2013.json"
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
        let kept = |name: &String| name.ends_with(".compliance");
        while !cache.exists() || !names(&cache).iter().any(kept) {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
            std::thread::sleep(Duration::from_millis(20));
        }
        // The shell's own `kill`: the program of this name is not everywhere.
        let kill = Command::new("sh")
            .args(["-c", &format!("kill -{signal} {}", child.id())])
            .status()
            .unwrap();
        assert!(kill.success());
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
    }
}
