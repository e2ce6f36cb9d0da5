//! Makes the tables of a pair: static contact at every node of a grid, sealed in a file that FMUs carry.
//!
//! The four axes are the displacement along the line of action (as a share of that under the largest load), the centre
//! distance, the misalignment and the mesh position; one node leaves an axis out.
//! `cargo run --release --example make_tables [TABLES.json]`; `gearmesh tables` plans its own grid and says what it does.

use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::Refinement;
use gearmesh::table::{Axes, Query, Table, TableFile};
use gearmesh_preprocessor::finite_element::{PairCompliance, Settings};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{displacement_nodes, mesh_positions, sweep};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut pair = pair::read("resources/pairs/palermo2013.json")?;
    pair.refinement = Refinement::Coarse;
    let settings = Settings::for_pair(&pair);
    let models = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)?;
    let [gear1, gear2] = models.gears;
    let solver = ContactSolver::new(&pair, [gear1, gear2], ContactSettings::for_pair(&pair))?;
    let axes = Axes {
        displacement_fraction: displacement_nodes(12, 1.6),
        center_distance_offset: vec![0.0],
        misalignment: (-4..=4).map(|i| 5e-4 * f64::from(i)).collect(), // rad
        mesh_position: mesh_positions(16),
    };
    let progress = |done, all| eprint!("\r{done} of {all} ");
    let [nominal, largest] = [pair.operating.nominal_torque, pair.operating.maximum_torque];
    let drive = sweep(&solver, Flank::Drive, &axes, largest, &progress)?;
    // No coast flank: it mirrors the drive flank.
    let file = TableFile::new(
        &pair.name,
        "examples/make_tables.rs",
        &pair.geometry,
        [nominal, largest],
        &drive,
        None,
    );
    if let Some(path) = std::env::args().nth(1) {
        std::fs::write(path, file.to_json())?;
    }

    // What an FMU does with it in each of its steps.
    let table = Table::from_file(file)?;
    let (flank, _) = table.flank(Flank::Drive);
    let query = Query {
        delta: 15e-6, // m, on the line of action
        center_distance_offset: 0.0,
        misalignment: 1e-3,
        mesh_position: 0.3,
    };
    let [force, ..] = flank.evaluate(&query, false).gradient;
    println!("15 um, 1 mrad, position 0.3: {force:.0} N on the line of action");
    Ok(())
}
