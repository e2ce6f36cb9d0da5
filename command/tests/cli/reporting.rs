//! The page of pictures.

use super::*;

#[test]
fn the_report_is_one_file_with_the_torques_asked_for_that_asks_for_nothing_from_a_network() {
    let folder = Folder::new();
    let [page, figures] = folder.paths(["report.html", "figures"]);
    succeed!("report {PAPER} --torques-nm 55,90 -o {page} --figures {figures} {QUICK}");
    let html = folder.read("report.html");
    // The torques that were named, and the pressure that `solve` gives by default.
    let pressures = numbers(&solve_json("--torque-nm 90")["maximum_pressure_mpa"]);
    for cell in ["55", "90", &format!("{:.1}", largest(pressures))] {
        contains!(html, &format!("<td>{cell}</td>"));
    }
    assert!(!html.contains("<td>100</td>"));
    let charts = html.matches("<svg").count();
    assert!(charts >= 8);
    contains!(html, "Power lost over that transmitted", "loss factor");
    contains!(html, "prefers-color-scheme:dark");
    // What is looked at first stands first, with what made it.
    let places = [
        "SHA-256",
        "nominal torque on gear 1",
        ">Teeth in mesh<",
        ">Contact pattern on gear 1 at 100 N m<",
        "<h2 id=\"in-numbers\"",
        "<h2 id=\"pair\"",
    ];
    let places = places.map(|text| html.find(text).unwrap_or_else(|| panic!("{text}")));
    assert!(places.is_sorted(), "{places:?}");
    contains!(html, "\ntip\n", "\nroot\n");
    assert!(html.len() < 3 << 20, "{} bytes", html.len());
    for reference in ["src=", "url(", "@import"] {
        assert!(!html.contains(reference), "{reference}");
    }
    // The table of contents leads to places of the page.
    let links = |start: &str| html.matches(start).count();
    assert_eq!(links("href="), links("href=\"#"));
    // The name space of SVG is a name, not an address to be loaded.
    let addresses = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http"), "an address in the page");
    // The page and the folder; in it every picture as SVG, without what only browsers know, and as CSV.
    assert_eq!((folder.count(""), folder.count("figures")), (2, 2 * charts));
    for figure in std::fs::read_dir(&figures).unwrap() {
        let path = figure.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let is_whole = match path.extension().unwrap().to_str() {
            Some("svg") => text.starts_with("<svg") && !text.contains("<style"),
            _ => text.lines().count() > 2 && text.contains(','),
        };
        assert!(is_whole, "{}", path.display());
    }
}

#[test]
fn a_report_compares_pair_files_and_tables_in_the_same_charts() {
    let folder = Folder::new();
    let [page, figures, tables] = folder.paths(["report.html", "figures", "tables.json"]);
    succeed!("tables {PAPER} -o {tables} {SMALL} --stations 8 {QUICK}");
    let stiffness = |other: &str| -> Vec<(String, f64)> {
        let options = format!("--positions 8 --torques-nm 100 --compare {other} {QUICK}");
        succeed!("report {PAPER} -o {page} --figures {figures} {options}");
        let csv = folder.read("figures/mesh-stiffness.csv");
        let mut csv = csv::Reader::from_reader(csv.as_bytes());
        let rows = csv.records().map(Result::unwrap);
        rows.map(|row| (row[0].to_owned(), row[2].parse().unwrap()))
            .collect()
    };
    let rows = stiffness(concat!(pairs!(), "palermo2013-unmodified.json"));
    let name = "100 N m (palermo2013-unmodified)";
    assert_eq!(rows.iter().filter(|(curve, _)| curve == name).count(), 9);
    let html = folder.read("report.html");
    contains!(html, "In numbers: palermo2013-unmodified", "K-chart");
    contains!(html, "Harris map", "gear 2 at 100 N m (palermo2013-unm");
    // Tables are those of the pair itself.
    let rows = stiffness(&tables);
    let (own, table) = rows.split_at(9);
    for (own, table) in own.iter().zip(table) {
        assert!(table.0.contains("tables of palermo2013"), "{}", table.0);
        assert!((own.1 / table.1 - 1.0).abs() < 0.1, "{} {}", own.1, table.1);
    }
    let other = concat!(pairs!(), "palermo2013-unmodified.json");
    refused!("report {other} --tables {tables} -o {page} {QUICK}";
        "made for other flanks than", "gear 1 has `", "and `modifications none` here");
}

#[test]
fn a_report_of_a_pair_on_shafts_draws_them_with_both_senses_of_the_torque() {
    let folder = Folder::new();
    let pair = super::solving::on_bearings(&folder);
    let page = folder.path("report.html");
    succeed!("report {pair} --torques-nm 100 --positions 8 -o {page} {QUICK}");
    let html = folder.read("report.html");
    contains!(
        html,
        "Shafts and bearings to scale",
        "K_Hbeta over torque",
        "Radial forces on the bearings",
        "coast flank"
    );
    succeed!("report {pair} --torques-nm 100 --positions 8 --shafts off -o {page} {QUICK}");
    assert!(!folder.read("report.html").contains("Shafts and bearings"));
}
