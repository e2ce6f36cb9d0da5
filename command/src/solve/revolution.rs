//! `--revolution`: the transmission error over a turn of a body that is no solid of revolution, as text, JSON and CSV.

use gearmesh_preprocessor::contact::{MeshCycle, Order, Revolution};
use serde_json::Value;

use crate::case::Case;
use crate::columns::{Column, Listing, columns, list, object, table};

/// Orders that text shows, the largest ones.
const SHOWN: usize = 12;

/// What a turn says in one number each, beside the mesh cycle of the mean body.
fn summary<'r>() -> Vec<Column<'static, (&'r Revolution, &'r MeshCycle)>> {
    columns! { |(turn, mean): &(&Revolution, &MeshCycle)|
        "gear", ["turn of gear", "", None] => turn.gear + 1;
        "peak_to_peak_ste_loa_um", ["p-p STE over the turn", "um", 4] => 1e6 * turn.peak_to_peak();
        "mean_body_peak_to_peak_ste_loa_um", ["p-p STE on the mean body", "um", 4] => 1e6 * mean.peak_to_peak_ste();
        "modulation_of_mean_ste_loa_um", ["p-p mean STE of the mesh cycles", "um", 4] => 1e6 * turn.modulation();
    }
}

pub fn orders<'r>() -> Vec<Column<'static, (&'r Revolution, Order)>> {
    columns! { |(turn, order): &(&Revolution, Order)|
        "gear" => turn.gear + 1;
        "order", ["order", "", None] => order.order;
        "amplitude_loa_um", ["amplitude", "um", 4] => 1e6 * order.amplitude;
        "mesh_harmonic", ["next harmonic of the mesh", "", None] => order.mesh_harmonic;
        "sideband", ["order less that", "", None] => order.sideband;
    }
}

pub fn all_orders(case: &Case) -> Vec<(&Revolution, Order)> {
    let mut all = Vec::new();
    for turn in &case.revolutions {
        all.extend(turn.orders().into_iter().map(|order| (turn, order)));
    }
    all
}

/// Gear, mesh cycles since the beginning of the turn, and STE, m.
type AtTurn = (usize, f64, f64);

pub fn positions() -> Vec<Column<'static, AtTurn>> {
    columns! { |(gear, cycles, ste): &AtTurn|
        "gear" => *gear;
        "mesh_cycles" => *cycles;
        "ste_loa_um" => 1e6 * ste;
    }
}

pub fn all_positions(case: &Case) -> Vec<AtTurn> {
    let mut all = Vec::new();
    for turn in &case.revolutions {
        for (i, ste) in turn.ste.iter().enumerate() {
            all.push((turn.gear + 1, i as f64 / turn.positions as f64, *ste));
        }
    }
    all
}

pub fn json(case: &Case) -> Value {
    let mut all = Vec::new();
    for turn in &case.revolutions {
        let mut json = object(&summary(), &(turn, &case.cycle));
        let ste: Vec<f64> = turn.ste.iter().map(|ste| 1e6 * ste).collect();
        let amplitudes = turn.orders();
        let amplitudes: Vec<f64> = amplitudes.iter().map(|o| 1e6 * o.amplitude).collect();
        json.insert("positions_per_mesh_cycle".into(), turn.positions.into());
        json.insert("ste_loa_um".into(), ste.into());
        json.insert("order_amplitudes_loa_um".into(), amplitudes.into());
        all.push(Value::from(json));
    }
    all.into()
}

pub fn text(case: &Case) -> String {
    let mut text = String::new();
    for turn in &case.revolutions {
        let mut rows = Listing::default();
        list(&mut rows, &summary(), &(turn, &case.cycle));
        let mut largest = turn.orders();
        largest.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        largest.truncate(SHOWN);
        let largest = largest.into_iter().map(|order| (turn, order));
        text += &format!("\n{rows}\n{}", table(&orders(), largest));
    }
    text
}
