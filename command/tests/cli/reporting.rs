//! The page of pictures.

use super::*;

#[test]
fn the_report_is_one_file_that_asks_for_nothing_from_a_network() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    let figures = folder.path().join("figures");
    let (page, drawn) = (file.to_str().unwrap(), figures.to_str().unwrap());
    let pair = paper();
    let asked = [
        "report",
        &pair,
        "--positions",
        "8",
        "-o",
        page,
        "--figures",
        drawn,
    ];
    let output = gearmesh(&[&asked, &QUICK[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let html = std::fs::read_to_string(&file).unwrap();
    assert!(html.matches("<svg").count() >= 8);
    for picture in [
        "Power lost",
        "Power lost over that transmitted",
        "loss factor",
    ] {
        assert!(html.contains(picture), "{picture}");
    }
    assert!(html.contains("prefers-color-scheme:dark"));
    for reference in ["src=", "url(", "@import"] {
        assert!(!html.contains(reference), "{reference}");
    }
    // The table of contents leads to places of the page.
    assert_eq!(
        html.matches("href=").count(),
        html.matches("href=\"#").count()
    );
    // The name space of SVG is a name, not an address to be loaded.
    let addresses = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http"), "an address in the page");
    let files = |folder| std::fs::read_dir(folder).unwrap().count();
    assert_eq!(
        files(folder.path()),
        2,
        "the page and the folder of figures"
    );
    // Every picture as SVG, without what only browsers know, and as CSV.
    assert_eq!(files(&figures), 2 * html.matches("<svg").count());
    for figure in std::fs::read_dir(&figures).unwrap() {
        let path = figure.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        match path.extension().unwrap().to_str() {
            Some("svg") => assert!(text.starts_with("<svg") && !text.contains("<style")),
            _ => assert!(
                text.lines().count() > 2 && text.contains(','),
                "{}",
                path.display()
            ),
        }
    }
}

#[test]
fn a_report_compares_pair_files_and_tables_in_the_same_charts() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (page, figures, tables) = (path("report.html"), path("figures"), path("tables.json"));
    let other = pair_file("palermo2013-unmodified.json")
        .display()
        .to_string();
    let pair = paper();
    let small = [
        "--no-center-distance",
        "--no-misalignment",
        "--stations",
        "8",
    ];
    succeed(&[&["tables", &pair, "-o", &tables], &small[..], &QUICK].concat());
    let of = |other: &str| -> Vec<(String, f64)> {
        let asked = [
            "report",
            &pair,
            "-o",
            &page,
            "--figures",
            &figures,
            "--positions",
            "8",
            "--compare",
            other,
        ];
        succeed(&[&asked[..], &["--torques-nm", "100"], &QUICK].concat());
        let mut csv =
            csv::Reader::from_path(Path::new(&figures).join("mesh-stiffness.csv")).unwrap();
        let rows = csv.records().map(|row| row.unwrap());
        rows.map(|row| (row[0].to_owned(), row[2].parse().unwrap()))
            .collect()
    };
    let rows = of(&other);
    let name = "100 N m (palermo2013-unmodified)";
    assert_eq!(rows.iter().filter(|(curve, _)| curve == name).count(), 9);
    let html = std::fs::read_to_string(&page).unwrap();
    for shown in [
        "In numbers: palermo2013-unmodified",
        "Contact pattern on gear 2 at 100 N m (palermo2013-unmodified)",
        "Harris map",
        "K-chart",
    ] {
        assert!(html.contains(shown), "{shown}");
    }
    // Tables are those of the pair itself.
    let rows = of(&tables);
    let (own, table) = rows.split_at(9);
    for (own, table) in own.iter().zip(table) {
        assert!(table.0.contains("tables of palermo2013"), "{}", table.0);
        assert!((own.1 / table.1 - 1.0).abs() < 0.1, "{} {}", own.1, table.1);
    }
}

#[test]
fn the_report_shows_the_torques_asked_for_and_the_pressure_that_solve_gives() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    let pair = paper();
    let asked = ["report", &pair, "--torques-nm", "55,90", "-o"];
    let page = file.to_str().unwrap();
    let output = gearmesh(&[&asked[..], &[page], &QUICK[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let html = std::fs::read_to_string(&file).unwrap();
    assert!(html.contains("<td>55</td>") && html.contains("<td>90</td>"));
    assert!(!html.contains("<td>100</td>"));
    let json = solve_json(&["--torque-nm", "90"]);
    let pressures = numbers(&json["maximum_pressure_mpa"]);
    let largest = pressures.into_iter().fold(0.0, f64::max);
    assert!(
        html.contains(&format!("<td>{largest:.1}</td>")),
        "{largest}"
    );
}

#[test]
fn losses_up_to_a_speed_of_nothing_are_refused_by_name() {
    let pair = paper();
    let asked = [
        "report",
        &pair,
        "--largest-speed-rpm",
        "0",
        "-o",
        "none.html",
    ];
    let output = gearmesh(&asked);
    assert!(!output.status.success());
    let said = stderr(&output);
    assert!(
        said.contains("'0' for '--largest-speed-rpm <SPEED>': give a value from 1"),
        "{said}"
    );
}

#[test]
fn a_torque_is_refused_by_the_option_that_gave_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").to_str().unwrap().to_owned();
    let pair = paper();
    for (asked, said) in [
        (
            &["report", &pair, "-o", &out, "--torques-nm=50,-5"][..],
            "'-5' for '--torques-nm <TORQUES>': give 0 or",
        ),
        (
            &["study", &pair, "-o", &out, "--torque-nm=-5"],
            "'-5' for '--torques-nm <TORQUES>': give 0 or",
        ),
        (
            &["study", &pair, "-o", &out, "--vary", "torque_nm=-5..5"],
            "--vary torque_nm = -5: give",
        ),
        (
            &[
                "study",
                &pair,
                "-o",
                &out,
                "--vary",
                "misalignment_mrad=0..1e300",
            ],
            "--vary misalignment_mrad = 1e300: give",
        ),
    ] {
        let output = gearmesh(asked);
        assert!(!output.status.success());
        let message = stderr(&output);
        assert!(
            message.contains(said) && !message.contains("--flank"),
            "{message}"
        );
    }
    assert!(!Path::new(&out).exists());
}

#[test]
fn a_folder_that_cannot_be_made_is_named_with_what_was_tried() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let below = file.join("below").to_str().unwrap().to_owned();
    let page = folder.path().join("page.html").to_str().unwrap().to_owned();
    let pair = paper();
    for (asked, option) in [
        (&["solve", &pair, "-o", &below][..], "--output"),
        (
            &["study", &pair, "-o", &below, "--vary", "torque_nm=1..5"],
            "--output",
        ),
        (
            &["report", &pair, "-o", &page, "--figures", &below],
            "--figures",
        ),
    ] {
        let output = gearmesh(asked);
        assert_eq!(output.status.code(), Some(1));
        let said = format!("{option} = {below}: making this folder failed: ");
        assert!(stderr(&output).contains(&said), "{}", stderr(&output));
    }
    assert!(!Path::new(&page).exists());
}

#[test]
fn a_report_that_cannot_be_written_is_a_failure_that_names_the_file() {
    let page = "/no/such/folder/report.html";
    let pair = paper();
    let output = gearmesh(
        &[
            &["report", &pair, "--positions", "2", "-o", page],
            &QUICK[..],
        ]
        .concat(),
    );
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("/no/such/folder/report.html"));
}
