//! Tables of version 0.1.0 (`tests/data/version-0.1.0`, made and evaluated by that version): those of helical gears, whose law of
//! misalignment was another, are refused by name; evaluated all the same they give the values that they gave then.

use gearmesh::table::{FlankTable, Interpolation, Query, TableFile};
use serde::Deserialize;
use std::path::PathBuf;

fn recorded(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/version-0.1.0")
        .join(name)
}

/// One evaluation by version 0.1.0, SI.
#[derive(Deserialize)]
struct Row {
    flank: String,
    interpolation: String,
    load: String,
    /// Elongation, centre distance offset, misalignment, mesh position.
    query: [f64; 4],
    potential_j: f64,
    gradient: [f64; 4],
    stiffness: f64,
    out_of_range: bool,
}

#[test]
fn a_tables_file_of_version_0_1_0_gives_the_potential_it_gave_then() {
    let refused = TableFile::read(recorded("tables.json"))
        .unwrap_err()
        .to_string();
    assert!(
        refused.starts_with("version = 1: tables of helical gears"),
        "{refused}"
    );
    let text = std::fs::read_to_string(recorded("tables.json")).unwrap();
    let file: TableFile = serde_json::from_str(&text).unwrap();
    // The checksum is right, so every digit of the file is the one that was written.
    let mut sealed = file.clone();
    sealed.seal();
    assert_eq!(sealed, file);
    assert_eq!(file.generator, "gearmesh 0.1.0");
    let force = file.nominal_torque_nm / file.geometry.gears[0].base_radius();
    let text = std::fs::read_to_string(recorded("potentials.json")).unwrap();
    let rows: Vec<Row> = serde_json::from_str(&text).unwrap();
    assert_eq!(rows.len(), 72);
    for (n, row) in rows.iter().enumerate() {
        let grid = match row.flank.as_str() {
            "drive" => file.drive_grid(),
            _ => file.coast_grid().unwrap(),
        };
        let interpolation = match row.interpolation.as_str() {
            "linear" => Interpolation::Linear,
            "spline" => Interpolation::Spline,
            _ => Interpolation::Shepard,
        };
        let table = match row.load.as_str() {
            "variable" => FlankTable::new(&grid, interpolation),
            _ => FlankTable::constant_load(&grid, interpolation, force),
        };
        let [delta, center_distance_offset, misalignment, mesh_position] = row.query;
        let query = Query {
            delta,
            center_distance_offset,
            misalignment,
            mesh_position,
        };
        let found = table.unwrap().evaluate(&query, false);
        // Rounding of sums that are taken in another order; a derivative is measured by the largest of its kind.
        let near = |a: f64, b: f64, scale: f64| {
            assert!((a - b).abs() <= 1e-12 * scale, "row {n}: {a} for {b}")
        };
        near(found.value, row.potential_j, row.potential_j);
        near(found.hessian[0][0], row.stiffness, row.stiffness);
        let work = row.gradient[0] * 10e-6;
        for (i, unit) in [(0, 10e-6), (1, 10e-6), (2, 1e-3), (3, 1.0)] {
            near(
                found.gradient[i],
                row.gradient[i],
                row.gradient[i].abs().max(work / unit),
            );
        }
        assert_eq!(found.out_of_range, row.out_of_range, "row {n}");
    }
}
