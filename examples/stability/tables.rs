//! The tables of the experiments: one of a real pair, one imported from samples of a textbook spring.

use crate::pair;
use gearmesh::compliance::finite_element::{PairCompliance, Settings};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::table::sweep::{Watch, sweep};
use gearmesh::table::{Axes, FlankTable, Interpolation, Table, TableFile, import, plan};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The paper's modified pair with a table made here.
pub fn palermo() -> Result<(Pair, Arc<Table>)> {
    coarse(include_str!("../../resources/pairs/palermo2013.json"))
}

/// The shipped planet and ring with a table made here.
pub fn planet_and_ring() -> Result<(Pair, Arc<Table>)> {
    coarse(include_str!("../../resources/pairs/planet-ring-27-84.json"))
}

/// The paper's modified pair with its shipped table, from finite elements.
pub fn shipped_palermo() -> Result<(Pair, Arc<Table>)> {
    let pair = Pair::from_json(include_str!("../../resources/pairs/palermo2013.json"))?;
    let table = Table::from_json(include_str!("../../resources/tables/palermo2013.json"))?;
    Ok((pair, Arc::new(table)))
}

/// Table over all four dimensions of a pair file, on coarse finite elements and a grid that takes seconds.
fn coarse(pair_file: &str) -> Result<(Pair, Arc<Table>)> {
    let pair = Pair {
        refinement: Refinement::Coarse,
        ..Pair::from_json(pair_file)?
    };
    let settings = Settings::for_pair(&pair);
    let [first, second] =
        PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)?.gears;
    let solver = ContactSolver::new(&pair, [first, second], ContactSettings::for_pair(&pair))?;
    let even = |[low, high]: [f64; 2], n: usize| -> Vec<f64> {
        (0..n)
            .map(|i| low + (high - low) * i as f64 / (n - 1) as f64)
            .collect()
    };
    let axes = Axes {
        displacement_fraction: plan::displacement_nodes(8, 1.6),
        center_distance_offset: even(pair.operating.center_distance_offset, 5),
        misalignment: even(pair.operating.misalignment, 9),
        mesh_position: plan::mesh_positions(12),
    };
    let watch = Watch {
        progress: &|_, _| (),
        cancel: &AtomicBool::new(false),
    };
    let torque = pair.operating.maximum_torque;
    let drive = sweep(&solver, Flank::Drive, &axes, torque, &watch)?;
    let mut file = TableFile::new(
        &pair.name,
        "stability report",
        &pair.geometry,
        [pair.operating.nominal_torque, torque],
        &drive,
        None,
    );
    file.seal();
    Ok((pair, Arc::new(Table::from_file(file)?)))
}

/// k (1 + `depth` cos 2 pi PMC) by way of a CSV file of static solutions, imported like those of any other program.
pub fn imported_spring(stiffness: f64, depth: f64, positions: usize) -> Result<Arc<FlankTable>> {
    let geometry = pair::external();
    let mut csv = import::COLUMNS.join(",");
    for torque in [0.0, 0.1, 1.0, 10.0, 100.0, 1000.0] {
        for n in 0..positions {
            let position = n as f64 / positions as f64;
            let k = stiffness * (1.0 + depth * (TAU * position).cos());
            let ste_um = 1e6 * torque / geometry.gears[0].base_radius() / k;
            let z_mm = 1e3 * geometry.z_ref();
            write!(csv, "\n{torque},{position},0,0,{ste_um},{z_mm}")?;
        }
    }
    let imported = import::import_csv(&csv, &geometry)?;
    Ok(Arc::new(FlankTable::new(
        &imported.grid,
        Interpolation::Spline,
    )?))
}
