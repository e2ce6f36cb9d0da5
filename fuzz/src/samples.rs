//! Samples for `import`: refused by line, or tables that give numbers.

use gearmesh::table::TableFile;
use gearmesh_preprocessor::table::import::{COLUMNS, import_csv};

use super::{Target, change, gears::spur_pair, tables};

/// Linear springs with one and with two axes are where it starts.
pub const TARGET: Target = Target {
    seeds: || vec![springs(&[0.0]), springs(&[-50.0, 0.0, 50.0, 100.0])],
    change: change::csv,
    check,
};

/// Samples of a spring at these centre distances, um.
fn springs(offsets: &[f64]) -> Vec<u8> {
    let arm = spur_pair().gears[0].base_radius();
    let mut text = COLUMNS.join(",") + "\n";
    for torque in [10.0, 50.0, 120.0, 200.0] {
        for position in 0..8 {
            for offset in offsets {
                let position = f64::from(position) / 8.0;
                let approach = 1e6 * torque / arm / 2e8 * (1.0 + 1e-3 * offset + 0.1 * position);
                text += &format!("{torque},{position},{offset},0,{approach},13.5\n");
            }
        }
    }
    text.into_bytes()
}

/// See [`Target::check`].
pub fn check(data: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(data) else {
        return false;
    };
    let geometry = spur_pair();
    match import_csv(text, &geometry) {
        Ok(imported) => {
            // What is odd about them is said, or refused by the command.
            let _ = imported.doubt(&geometry, 100.0);
            let torques = [0.5 * imported.maximum_torque, imported.maximum_torque];
            let file = TableFile::new(
                "samples",
                "a formula",
                &geometry,
                torques,
                &imported.grid,
                None,
            );
            tables::check_file(file)
        }
        Err(error) => {
            tables::report(&error);
            false
        }
    }
}
