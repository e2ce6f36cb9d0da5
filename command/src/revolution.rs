//! The transmission error over a turn of a body that is no solid of revolution: solved, as text, JSON and CSV for `solve --revolution`, and
//! drawn for `report`.

use gearmesh_preprocessor::contact::{CycleInput, MeshCycle, Order, Revolution};
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::static_contact::{ContactError, ContactSolver};
use serde_json::Value;

use crate::case::{Case, torque_in_words};
use crate::columns::{Column, Listing, columns, list, object, table};
use crate::output::Job;
use crate::page::{Curve, Figure, Height, Section, charts};

/// Positions of a mesh cycle of which a report shows a turn: orders up to four times the number of teeth are drawn.
const POSITIONS: usize = 12;
/// Multiples of the number of teeth up to which a report draws orders.
const DRAWN_HARMONICS: usize = 3;

/// Adds a turn of each gear of `pair` whose body is no solid of revolution to `case`.
pub fn solve(
    case: &mut Case,
    solver: &ContactSolver,
    pair: &Pair,
    job: &Job,
) -> Result<(), ContactError> {
    for gear in (0..2).filter(|gear| pair.bodies[*gear].is_some()) {
        let (input, load) = (&case.input, case.load);
        let turn = Revolution::solve(solver, &pair.shafts, input, load, gear, &|share| {
            job.show(&format!("turn of gear {}", gear + 1), share);
        });
        case.revolutions.push(turn?);
    }
    Ok(())
}

/// The section of a report on the turns of the bodies of `pair` under the load of `nominal`; None of bodies that are solids of revolution.
pub fn section(
    nominal: &Case,
    solver: &ContactSolver,
    pair: &Pair,
    job: &Job,
) -> Result<Option<Section>, ContactError> {
    if pair.bodies.iter().all(Option::is_none) {
        return Ok(None);
    }
    let input = CycleInput {
        positions: POSITIONS,
        ..nominal.input
    };
    let loads = [nominal.load];
    let mut cases = Case::solve_all((solver, &pair.shafts), None, &input, &loads, &|_| {})?;
    solve(&mut cases[0], solver, pair, job)?;
    let figures = cases[0].revolutions.iter().flat_map(drawn).collect();
    let note = format!(
        "A mesh cycle for each tooth with the body at its angle, at {}; the other gear has its mean body. The turn begins with tooth 0 at the pitch \
         point. Orders: periods over the turn; the number of teeth and its multiples are the harmonics of the mesh, what lies beside them are sidebands.",
        torque_in_words(nominal.load.torque)
    );
    let text = text(&cases[0]);
    Ok(Some(
        Section::new("Over a turn of the body", note, figures)
            .with_text(text.trim_start().to_owned()),
    ))
}

fn drawn(turn: &Revolution) -> Vec<Figure> {
    let gear = turn.gear + 1;
    let ste = turn.ste.iter().enumerate();
    let ste = ste.map(|(i, ste)| (i as f64 / turn.positions as f64, 1e6 * ste));
    let ste = Curve::new("STE", ste);
    let means = turn.ste.chunks(turn.positions).enumerate();
    let means = Curve::new(
        "mean of each mesh cycle",
        means.map(|(i, cycle)| {
            let mean = cycle.iter().sum::<f64>() / cycle.len() as f64;
            (i as f64 + 0.5, 1e6 * mean)
        }),
    );
    let teeth = turn.ste.len() / turn.positions;
    let stems = turn
        .orders()
        .into_iter()
        .take((DRAWN_HARMONICS * teeth) + teeth / 2);
    let stems = stems.flat_map(|part| {
        let order = part.order as f64;
        [0.0, 1e6 * part.amplitude, 0.0].map(|height| (order, height))
    });
    charts! {
        format!("Transmission error over a turn of gear {gear}"), ["mesh cycles", "STE (um)"], Height::Curves(LEAST_ERROR)
            => vec![ste, means];
        format!("Orders over a turn of gear {gear}"), ["order", "amplitude (um)"], Height::FromZero(LEAST_ERROR)
            => vec![Curve::new("amplitude", stems)];
    }
}

/// Least height of an axis of transmission errors, um: what lies below is the solver's tolerance.
const LEAST_ERROR: f64 = 1e-3;

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
