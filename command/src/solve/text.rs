//! Mesh cycles as text.

use gearmesh::gear::Flank;
use gearmesh::words::{count, rounded};

use super::Solved;
use super::results::{
    at_positions, largest_tooth, losses, nominal, nominal_stress, notes, positions, root_stress,
};
use crate::case::{Case, LEGEND, details, load, summary, torque_in_words};
use crate::columns::{Column, columns, list, table};
use crate::output::{Listing, rows};

/// All cycles, a line for each; of a single one every position, and the losses at `speeds` of gear 1, rpm.
pub fn text(solved: &Solved, speeds: &[f64]) -> String {
    let cases = &solved.cases;
    let input = &cases[0].input;
    let flank = match input.flank {
        Flank::Drive => "drive",
        Flank::Coast => "coast",
    };
    let mut text = format!(
        "{}: {}, {flank} flank, centre distance offset {} um\n\n",
        solved.pair.name,
        count(cases.len(), "load"),
        rounded(input.center_distance_offset * 1e6)
    );
    let mut rows = Listing::default();
    match &cases[..] {
        [case] => text += &one(solved, case, speeds, &mut rows),
        cases => text += &many(solved, cases),
    }
    let seconds: f64 = cases.iter().map(|case| case.cycle.solve_seconds).sum();
    rows! { rows;
        "elastic model" => "{}", solved.model.description;
        "time for the elastic model" => "{}", solved.model.effort;
    }
    if let Some(f) = &solved.model.fillets {
        rows! { rows; "time for the model of the fillets" => "{}", f.effort; }
    }
    rows! { rows; "time for the contact" => "{seconds:.3} s"; }
    text + &format!("\n{rows}") + &all_notes(solved)
}

fn one(solved: &Solved, case: &Case, speeds: &[f64], rows: &mut Listing) -> String {
    let solver = &solved.model.solver;
    let harmonics = case.cycle.harmonics().map(|h| h.map(|h| 1e6 * h.amplitude));
    let harmonics = harmonics.map(|h| h.map_or("-".into(), |h| format!("{h:.4}")));
    let mut first = Listing::default();
    for columns in [load(), summary(solver)] {
        list(&mut first, &columns, &case);
    }
    rows! { first; "harmonics 1 to 10" => "{} um", harmonics.join(" "); }
    let mut text = format!("{first}\n");
    text += &table(&positions(&case.cycle.tooth_pairs()), at_positions(case));
    text += "\nz_c: axial position of the resulting force, from the z = 0 face of gear 1.\n\
         pair k: share of a tooth pair in the load. Pair 0 touches at the pitch point at mid-face at mesh position 0;\n\
         pair 1 is ahead of it by one pitch and leaves the mesh first, pair -1 comes into mesh after it.\n";
    text += LEGEND;
    list(rows, &details(solver), &case);
    rows! { rows; "residual of the contact conditions" => "{:.1e}", case.cycle.kkt_residual(); }
    if !speeds.is_empty() {
        text += "\n";
        text += &table(&losses(&solved.pair, case), speeds.iter().copied());
    }
    if case.roots.is_some() {
        let largest = (0..2).filter_map(|i| largest_tooth(case, i));
        text += &format!("\n{}", table(&root_stress(), largest));
        for i in 0..2 {
            let mut terms = Listing::default();
            match nominal_stress(solver, case, i) {
                Some(stress) => list(&mut terms, &nominal(), &stress),
                None => terms.row("beyond the standard", "(rim or notch)"),
            }
            rows.row(format!("ISO 6336-3, gear {}", i + 1), terms.in_one_line());
        }
    }
    text
}

fn many(solved: &Solved, cases: &[Case]) -> String {
    let mut columns = load();
    columns.extend(summary(&solved.model.solver));
    let mut text = format!("{}\n{LEGEND}", table(&columns, cases));
    if solved.model.fillets.is_some() {
        let mut columns = load();
        columns.extend(largest_root_stress());
        text += &format!("\n{}\n{ROOT_LEGEND}", table(&columns, cases));
    }
    text
}

const ROOT_LEGEND: &str = "\
root stress: largest principal stress in the fillets of a gear over the mesh cycle; at tangent: the same at the
30 degree tangent (ring: 60 degrees).
";

pub fn largest_root_stress<'r>() -> Vec<Column<'static, &'r Case>> {
    columns! { |c: &&Case|
        "", ["root stress 1", "MPa", 1] => c.root_stress(0);
        "", ["at tangent 1", "MPa", 1] => c.root_stress_at_tangent(0);
        "", ["root stress 2", "MPa", 1] => c.root_stress(1);
        "", ["at tangent 2", "MPa", 1] => c.root_stress_at_tangent(1);
    }
}

/// What is to be known of the results, each sentence with the loads that it is about if it is not about all.
fn all_notes(solved: &Solved) -> String {
    let mut about: Vec<(String, Vec<String>)> = vec![];
    for case in &solved.cases {
        let torque = torque_in_words(case.input.torque);
        let load = format!("{torque}, {} mrad", rounded(case.input.misalignment * 1e3));
        for note in notes(&solved.pair, case) {
            match about.iter_mut().find(|(other, _)| *other == note) {
                Some((_, loads)) => loads.push(load.clone()),
                None => about.push((note, vec![load.clone()])),
            }
        }
    }
    let line = |(note, loads): (String, Vec<String>)| match loads.len() < solved.cases.len() {
        true => format!("\nnote: {note} ({})\n", loads.join("; ")),
        false => format!("\nnote: {note}\n"),
    };
    about.into_iter().map(line).collect()
}
