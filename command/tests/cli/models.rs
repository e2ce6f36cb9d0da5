//! Elastic models that are kept.

use super::*;
use std::os::unix::fs::MetadataExt;

#[test]
fn no_model_is_kept_where_none_shall_be_whatever_the_environment_says() {
    let folder = Folder::new();
    let line = format!("solve {PAPER} --refinement coarse --positions 1 --no-cache");
    let mut command = command();
    let command = command
        .args(line.split(' '))
        .env("GEARMESH_CACHE_DIR", folder.path(""));
    assert!(command.output().unwrap().status.success());
    assert_eq!(folder.count(""), 0);
}

/// `gearmesh tables` of the paper's pair after `change`, the smallest there are, in `folder`; returns the line on the
/// elastic model, and standard error.
fn elastic_model_of_tables(folder: &Folder, change: fn(&mut Value)) -> String {
    let pair = folder.pair(|pair| {
        pair["compliance"] = serde_json::json!({ "refinement": "coarse" });
        change(pair);
    });
    let [tables, cache] = folder.paths(["tables.json", "cache"]);
    let options = format!("{SMALL} --stations 8 --cache-dir {cache}");
    let output = run(format!("tables {pair} -o {tables} {options}"));
    let shown = text(&output.stdout);
    line(&shown, "elastic model").to_owned() + &text(&output.stderr)
}

#[test]
fn an_elastic_model_serves_every_change_that_does_not_touch_it() {
    let folder = Folder::new();
    let kept = folder.path("cache");
    let count = || folder.count("cache");
    let model = |change| elastic_model_of_tables(&folder, change);

    assert!(model(|_| ()).contains(&format!("kept in {kept}")));
    // Both gears are equal but for hand: one model.
    assert_eq!(count(), 1);
    // A file that is written anew has another inode.
    let inode = || {
        let entry = std::fs::read_dir(&kept).unwrap().next().unwrap();
        entry.unwrap().metadata().unwrap().ino()
    };
    let written = inode();
    let unchanged: [fn(&mut Value); 4] = [
        |pair| pair["gear1"]["tip_relief"]["amount_um"] = 9.0.into(),
        |pair| pair["gear2"]["lead_crowning_um"] = 0.0.into(),
        |pair| pair["operating"]["maximum_torque_nm"] = 170.0.into(),
        |pair| pair["operating"]["misalignment_mrad"] = serde_json::json!([-1.0, 2.0]),
    ];
    for change in unchanged {
        let words = model(change);
        contains!(words, "read from");
        assert!(!words.contains("note"), "{words}");
        assert_eq!((count(), inode()), (1, written));
    }
    for entry in std::fs::read_dir(&kept).unwrap() {
        let path = entry.unwrap().path();
        let cut = std::fs::read(&path).unwrap()[..40].to_vec();
        std::fs::write(path, cut).unwrap();
    }
    let words = model(|_| ());
    contains!(words, "computed", "note", "it was cut or altered");
    assert!(model(|_| ()).contains("read from"));
    // No other folder than the one that was named.
    assert!(!folder.exists(".gearmesh-compliance"));
    let listed = succeed!("cache --cache-dir {kept}");
    contains!(listed, "20 teeth, module 4 mm", "of 1000.0 MB");
    // A file that merely ends like a model stays, and is named.
    let foreign = folder.write("cache/notes.compliance", b"not a model");
    let words = succeed!("cache --clear --cache-dir {kept}");
    let left = format!("left {foreign}, which is no model");
    contains!(words, "removed 1 model", &left);
    assert_eq!(folder.read("cache/notes.compliance"), "not a model");
    assert_eq!(count(), 1);
}

#[test]
fn the_cache_of_a_user_lies_where_the_system_says_by_a_whole_path() {
    let folder = Folder::new();
    let home = folder.path("home");
    let other = folder.path("other");
    for (base, expected) in [
        ("relative", format!("{home}/.cache")),
        (&*other, other.clone()),
    ] {
        let mut command = command();
        command.env_remove("GEARMESH_CACHE_DIR").env("HOME", &home);
        let output = command.env("XDG_CACHE_HOME", base).arg("cache").output();
        contains!(
            text(&output.unwrap().stdout),
            &format!("{expected}/gearmesh: ")
        );
    }
}
