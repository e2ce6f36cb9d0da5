//! Elastic models that are kept.

use super::*;

#[test]
fn a_finite_element_model_is_kept_and_found_again() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let solve = || {
        let output = succeed(&[
            "solve",
            &paper(),
            "--refinement",
            "coarse",
            "--positions",
            "4",
            "--json",
            "--cache-dir",
            cache.to_str().unwrap(),
        ]);
        let json: serde_json::Value = serde_json::from_str(stdout(&output)).unwrap();
        assert_eq!(stderr(&output), "");
        numbers(&json["ste_loa_um"])
    };
    let first = solve();
    // Both gears are equal but for hand: one model.
    let kept: Vec<_> = std::fs::read_dir(&cache)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    assert_eq!(kept.len(), 1);
    // A file that is written anew is another one.
    let number = || std::fs::metadata(&kept[0]).unwrap().ino();
    let written = number();
    assert_eq!(first, solve());
    assert_eq!(number(), written);
    // Three-dimensional teeth on a held bore give way by some micrometres, not by none.
    assert!(mean(&first) > 5.0 && mean(&first) < 20.0);
}

/// `gearmesh tables` of the paper's pair after `change`, the smallest there are, in `folder`; returns what it
/// says about its elastic models.
fn elastic_model_of_tables(folder: &Path, change: impl Fn(&mut serde_json::Value)) -> String {
    let text = std::fs::read_to_string(paper()).unwrap();
    let mut pair: serde_json::Value = serde_json::from_str(&text).unwrap();
    pair["compliance"] = serde_json::json!({ "refinement": "coarse" });
    change(&mut pair);
    let file = folder.join("pair.json");
    std::fs::write(&file, pair.to_string()).unwrap();
    let tables = folder.join("tables.json");
    let output = succeed(&[
        "tables",
        file.to_str().unwrap(),
        "-o",
        tables.to_str().unwrap(),
        "--no-center-distance",
        "--no-misalignment",
        "--stations",
        "8",
        "--cache-dir",
        folder.join("cache").to_str().unwrap(),
    ]);
    let line = stdout(&output)
        .lines()
        .find(|line| line.contains("elastic model"));
    format!("{}{}", line.unwrap(), stderr(&output))
}

#[test]
fn an_elastic_model_serves_every_change_that_does_not_touch_it() {
    let folder = tempfile::tempdir().unwrap();
    let kept = folder.path().join("cache");
    let count = || std::fs::read_dir(&kept).unwrap().count();
    let of = |change: fn(&mut serde_json::Value)| elastic_model_of_tables(folder.path(), change);
    let place = format!("kept in {}", kept.display());

    assert!(of(|_| ()).contains(&place));
    assert_eq!(count(), 1);
    let unchanged: [fn(&mut serde_json::Value); 4] = [
        |pair| pair["gear1"]["tip_relief"]["amount_um"] = 9.0.into(),
        |pair| pair["gear2"]["lead_crowning_um"] = 0.0.into(),
        |pair| pair["operating"]["maximum_torque_nm"] = 170.0.into(),
        |pair| pair["operating"]["misalignment_mrad"] = serde_json::json!([-1.0, 2.0]),
    ];
    for change in unchanged {
        let said = of(change);
        assert!(
            said.contains("read from") && !said.contains("note"),
            "{said}"
        );
        assert_eq!(count(), 1);
    }
    let changed: [fn(&mut serde_json::Value); 2] = [
        |pair| {
            pair["gear1"]["bore_diameter_mm"] = 31.0.into();
            pair["gear2"]["bore_diameter_mm"] = 31.0.into();
        },
        |pair| pair["compliance"]["refinement"] = "normal".into(),
    ];
    for (change, files) in changed.into_iter().zip(2..) {
        assert!(of(change).contains("computed"));
        assert_eq!(count(), files);
    }

    for entry in std::fs::read_dir(&kept).unwrap() {
        let path = entry.unwrap().path();
        let cut = std::fs::read(&path).unwrap()[..40].to_vec();
        std::fs::write(path, cut).unwrap();
    }
    let said = of(|_| ());
    assert!(said.contains("computed"), "{said}");
    assert!(
        said.contains("note") && said.contains("the file is cut off"),
        "{said}"
    );
    assert!(of(|_| ()).contains("read from"));
    // Nothing but the files asked for lies beside the tables.
    assert!(!folder.path().join(".gearmesh-compliance").exists());
    let cache = |more: &[&str]| {
        let arguments = [&["cache", "--cache-dir", kept.to_str().unwrap()], more].concat();
        stdout(&succeed(&arguments)).to_owned()
    };
    let listed = cache(&[]);
    assert!(
        listed.contains("20 teeth, module 4 mm") && listed.contains("of 1000.0 MB"),
        "{listed}"
    );
    // A file that merely ends like a model stays, and is said to.
    let foreign = kept.join("notes.compliance");
    std::fs::write(&foreign, b"not a model").unwrap();
    let said = cache(&["--clear"]);
    let left = format!("left {}, which is no model", foreign.display());
    assert!(
        said.contains("removed 3 models") && said.contains(&left),
        "{said}"
    );
    assert_eq!(std::fs::read(&foreign).unwrap(), b"not a model");
    assert_eq!(count(), 1);
}
