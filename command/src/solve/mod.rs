//! `gearmesh solve PAIR.json`: mesh cycles, quasi-static, for one load or a matrix of loads.

mod results;

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::words::{count, rounded};
use gearmesh_preprocessor::contact::{CycleInput, LoadCase};
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::shaft::misalignment_range;
use gearmesh_preprocessor::static_contact::Deflection;
use gearmesh_preprocessor::storage::csv_reader;
use serde::Deserialize;
use serde_json::json;

use crate::case::{
    Case, LEGEND, SHAFT_LEGEND, bearing_columns, bearings, details, load, on_shafts, summary,
    torque_in_words,
};
use crate::columns::{Column, Listing, columns, list, rows, table};
use crate::error::Result;
use crate::model::{Model, ModelArgs, ShaftArgs, widen};
use crate::output::{self, Job};
use crate::{limits, revolution};
use results::{
    at_positions, largest_tooth, losses, nominal, nominal_stress, notes, positions, root_stress,
};

/// Solve the static contact over the mesh cycle, for one load or for every torque with every misalignment.
#[derive(Debug, Args)]
pub struct Solve {
    /// Pair file
    pair: PathBuf,

    /// Torques on gear 1, N m, separated by commas [default: the pair's nominal torque]
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = torque)]
    torque_nm: Vec<f64>,

    /// Number of positions over the mesh cycle
    #[arg(long, default_value_t = limits::POSITIONS, value_parser = limits::within(1..=limits::MOST_POSITIONS))]
    positions: usize,

    /// Actual minus nominal centre distance, um
    #[arg(long, default_value_t = 0.0, value_parser = limits::within(limits::CENTER_DISTANCE_OFFSETS))]
    center_distance_offset_um: f64,

    /// Misalignments in the plane of action, mrad, separated by commas; > 0 closes the large-z side
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, default_values_t = [0.0], value_parser = limits::within(limits::MISALIGNMENTS))]
    misalignment_mrad: Vec<f64>,

    /// Loaded flank of gear 1; drive: in contact when gear 1 turns in its + sense and drives; coast: the other one
    #[arg(long, default_value = "drive", value_parser = PossibleValuesParser::new(["drive", "coast"]).map(|name| if name == "coast" { Flank::Coast } else { Flank::Drive }))]
    flank: Flank,

    #[command(flatten)]
    shafts: ShaftArgs,

    #[command(flatten)]
    deflection: DeflectionArgs,

    /// Speeds of gear 1 at which loss and efficiency are given, rpm, separated by commas
    #[arg(long, value_delimiter = ',', value_parser = limits::within(0.0..=1e6))]
    speed_rpm: Vec<f64>,

    /// Follow the transmission error over a turn of each gear whose body is no solid of revolution, a mesh cycle for each tooth; for one load
    #[arg(long)]
    revolution: bool,

    /// Solve with finite elements of another refinement, too, and print how far the results differ
    #[arg(long, conflicts_with = "json")]
    estimate_error: bool,

    /// Print JSON
    #[arg(long)]
    json: bool,

    /// Folder for load distribution, mesh cycle, stiffness, load along the face and a summary as CSV files, made if it is not there
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    #[command(flatten)]
    model: ModelArgs,
}

fn torque(text: &str) -> Result<f64, String> {
    limits::torque(text)
        .map_err(|error| format!("{error}; for the other flank say `--flank coast`"))
}

struct Solved {
    pair: Pair,
    model: Model,
    cases: Vec<Case>,
}

impl Solve {
    pub fn run(self) -> Result<()> {
        let pair = self.model.applied_to(pair::read(&self.pair)?);
        let mut pair = self.shafts.applied_to(pair);
        let loads = self.loads(&pair)?;
        let deflection = self.deflection.read(&pair.geometry)?;
        let has_shafts = pair.shafts.iter().any(Option::is_some);
        if has_shafts && deflection.is_some() {
            let option = self.deflection.option();
            refuse!(
                "{option}: it says how the shafts bend, and so do the shafts of the pair file; leave it out, or add --shafts off"
            );
        }
        if self.revolution && pair.bodies.iter().all(Option::is_none) {
            refuse!(
                "--revolution: the body of neither gear changes over a turn; give web_holes, rim_pins, rim_supports or body_matrix \
                 in the pair file, or leave it out"
            );
        }
        if self.revolution && loads.len() > 1 {
            refuse!(
                "--revolution: {} loads; give one torque and one misalignment",
                loads.len()
            );
        }
        if let Some(folder) = &self.output {
            results::check(folder, self.model.root_stress, has_shafts, self.revolution)?;
        }
        let bent = deflection.as_ref().map_or(0.0, |deflection| {
            let (low, width) = pair.geometry.face_overlap();
            let [least, largest] = deflection.range([low, low + width], 0.0);
            (largest - least) / width
        });
        let offset = self.center_distance_offset_um * 1e-6;
        let geometry = &pair.geometry;
        let clearance =
            [0, 1].map(|i| geometry.tip_clearance(i, geometry.center_distance + offset));
        let clearance = 1e6 * clearance[0].min(clearance[1]);
        if clearance <= 0.0 {
            // A gear in a ring nears its root with the centre distance.
            let (side, sign) = geometry.ring().map_or(("more", -1.0), |_| ("less", 1.0));
            refuse!(
                "--center-distance-offset-um = {}: a tip reaches the root of its mate; give {side} than {:.1}",
                self.center_distance_offset_um,
                self.center_distance_offset_um + sign * clearance
            );
        }
        for load in &loads {
            // A deflection gathers the load as the misalignment of its range does.
            let tilts = [load.misalignment - bent, load.misalignment + bent];
            widen(&mut pair, load.torque, tilts, [offset; 2]);
        }
        let job = self.model.start()?;
        let solved = self.solve(pair, &loads, deflection.as_ref(), &job)?;
        let solver = &solved.model.solver;
        if let Some(folder) = &self.output {
            results::write(folder, solver, &solved.pair, &solved.cases)?;
        }
        let mut text = if self.json {
            let cases: Vec<_> = (solved.cases.iter())
                .map(|case| results::json(solver, &solved.pair, case, &self.speed_rpm))
                .collect();
            let json = match &cases[..] {
                [case] => json!(case),
                cases => json!({ "cases": cases }),
            };
            format!("{json:#}\n")
        } else {
            text(&solved, &self.speed_rpm)
        };
        if self.estimate_error {
            let other = ModelArgs::reference(&solved.pair);
            let other = self.solve(other, &loads, deflection.as_ref(), &job)?;
            text += &difference(&solved, &other);
        }
        drop(job);
        output::print(&text)
    }

    fn loads(&self, pair: &Pair) -> Result<Vec<LoadCase>> {
        let mut torques = self.torque_nm.clone();
        if torques.is_empty() {
            torques.push(pair.operating.nominal_torque);
        }
        let count = torques.len() * self.misalignment_mrad.len();
        // More results would not fit into memory.
        limits::check(Some(count), &(1..=10_000))
            .map_err(|error| format!("torques times misalignments = {count}: {error}"))?;
        let misalignments = self.misalignment_mrad.iter().map(|mrad| mrad * 1e-3);
        Ok(LoadCase::matrix(
            &torques,
            &misalignments.collect::<Vec<_>>(),
        ))
    }

    /// A cycle of `pair` for each of `loads`, with the stress in the roots where it is requested.
    fn solve(
        &self,
        pair: Pair,
        loads: &[LoadCase],
        deflection: Option<&Deflection>,
        job: &Job,
    ) -> Result<Solved> {
        let roots = self.model.root_stress.then_some(self.flank);
        let mut model = self.model.model(&pair, roots, job)?;
        if let Some(deflection) = deflection {
            model.solver = model.solver.with_deflection(deflection.clone());
        }
        let input = CycleInput {
            flank: self.flank,
            center_distance_offset: self.center_distance_offset_um * 1e-6,
            positions: self.positions,
        };
        let fillets = model.fillets.as_ref();
        let mut cases = Case::solve_all(
            (&model.solver, &pair.shafts),
            fillets,
            &input,
            loads,
            &|share| job.show("static contact", share),
        )?;
        for case in cases.iter_mut().filter(|_| self.revolution) {
            revolution::solve(case, &model.solver, &pair, job)?;
        }
        Ok(Solved { pair, model, cases })
    }
}

/// All cycles, a line for each; of a single one every position, and the losses at `speeds` of gear 1, rpm.
fn text(solved: &Solved, speeds: &[f64]) -> String {
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
    let pair = &solved.pair;
    let torque = pair.operating.maximum_torque;
    if let Some(range) = misalignment_range(&pair.geometry, &pair.shafts, torque) {
        let [low, high] = range.map(|m| rounded(1e3 * m));
        rows! { rows; "misalignment that tables of this pair need" => "{low} to {high} mrad, for {} on either flank", torque_in_words(torque); }
    }
    text + &format!("\n{rows}") + &all_notes(solved)
}

fn one(solved: &Solved, case: &Case, speeds: &[f64], rows: &mut Listing) -> String {
    let solver = &solved.model.solver;
    let harmonics = case.cycle.harmonics().map(|h| h.map(|h| 1e6 * h.amplitude));
    let harmonics = harmonics.map(|h| h.map_or("-".into(), |h| format!("{h:.4}")));
    let mut first = Listing::default();
    for columns in [load(), summary(solver), on_shafts(Some(case))] {
        list(&mut first, &columns, &case);
    }
    rows! { first; "harmonics 1 to 10" => "{} um", harmonics.join(" "); }
    let mut text = format!("{first}\n");
    text += &table(&positions(&case.cycle.tooth_pairs()), at_positions(case));
    text += "\nz_c: axial position of the resulting force, from the z = 0 face of gear 1.\n\
         pair k: share of a tooth pair in the load. Pair 0 touches at the pitch point at mid-face at mesh position 0;\n\
         pair 1 is ahead of it by one pitch and leaves the mesh first, pair -1 comes into mesh after it.\n";
    text += LEGEND;
    if let Some(state) = &case.shafts {
        let all = bearings(&solved.pair, state);
        text += &format!("{SHAFT_LEGEND}\n{}", table(&bearing_columns(), all));
        text += "Forces of the housing on the shaft: x from gear 1 to gear 2, y across it, z along the axes.\n";
    }
    text += &revolution::text(case);
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
            rows! { rows; format!("ISO 6336-3, gear {}", i + 1) => "{}", terms.joined("; ", " "); }
        }
    }
    text
}

fn many(solved: &Solved, cases: &[Case]) -> String {
    let mut columns = load();
    columns.extend(summary(&solved.model.solver));
    columns.extend(on_shafts(cases.first()));
    let mut text = format!("{}\n{LEGEND}", table(&columns, cases));
    if cases[0].shafts.is_some() {
        text += SHAFT_LEGEND;
    }
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

fn largest_root_stress<'r>() -> Vec<Column<'static, &'r Case>> {
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
        let torque = torque_in_words(case.load.torque);
        let load = format!("{torque}, {} mrad", rounded(case.load.misalignment * 1e3));
        for note in notes(&solved.pair, case) {
            match about.iter_mut().find(|(other, _)| *other == note) {
                Some((_, loads)) => loads.push(load.clone()),
                None => about.push((note, vec![load.clone()])),
            }
        }
    }
    about
        .into_iter()
        .map(|(note, loads)| match loads.len() < solved.cases.len() {
            true => format!("\nnote: {note} ({})\n", loads.join("; ")),
            false => format!("\nnote: {note}\n"),
        })
        .collect()
}

/// How far the results of `solved` are from those of the `other` refinement, at the load where they differ most.
fn difference(solved: &Solved, other: &Solved) -> String {
    let model = &other.model;
    let mut rows = Listing::default();
    rows! { rows; "compared with" => "{}", model.description; }
    let mut columns = summary(&model.solver);
    if model.fillets.is_some() {
        columns.extend(largest_root_stress());
    }
    for column in &columns {
        let both = solved.cases.iter().zip(&other.cases);
        let shares = both
            .filter_map(|(a, b)| Some(column.number(&a)? / column.number(&b)? - 1.0))
            .filter(|share| share.is_finite());
        let worst = shares.max_by(|a, b| a.abs().total_cmp(&b.abs()));
        match worst {
            Some(worst) => rows! { rows; &column.head => "{:+.2} %", 100.0 * worst; },
            None => rows.row(&column.head, "none to give: it is zero"),
        }
    }
    rows! { rows; "time for its elastic model" => "{}", model.effort; }
    if let Some(f) = &model.fillets {
        rows! { rows; "time for its model of the fillets" => "{}", f.effort; }
    }
    format!("\nestimated error, from the difference to another refinement\n{rows}")
}

/// How shafts and housing bend, in addition to the misalignment.
#[derive(Debug, Args)]
#[command(next_help_heading = "Deflection along the face")]
struct DeflectionArgs {
    /// CSV with z_mm (from gear 1's z = 0 face) and closing_um: how far the flanks come closer there before they bear load
    #[arg(long, value_name = "CSV", conflicts_with = "bow_um")]
    deflection: Option<PathBuf>,

    /// How much less both ends of the face close than its middle, um, parabolic, 0 at mid-face; at most half a module
    #[arg(long, default_value_t = 0.0, value_parser = limits::within(-LARGEST_UM..=LARGEST_UM))]
    bow_um: f64,
}

/// Largest closing that is read, um: a hundred times what shafts do.
const LARGEST_UM: f64 = 1e4;

impl DeflectionArgs {
    /// The option that is given.
    fn option(&self) -> &'static str {
        match self.deflection {
            Some(_) => "--deflection",
            None => "--bow-um",
        }
    }

    /// The deflection; None where none is requested.
    fn read(&self, geometry: &PairGeometry) -> Result<Option<Deflection>> {
        if let Some(path) = &self.deflection {
            let curve = curve(path).map_err(|error| format!("{}: {error}", path.display()))?;
            return Ok(Some(curve));
        }
        let most = 0.5e6 * geometry.gears[0].normal_module;
        if self.bow_um.abs() > most {
            refuse!(
                "--bow-um = {}: more than half of the module, {} um, beyond what shafts of gears deflect; give it in um",
                self.bow_um,
                rounded(most)
            );
        }
        let (low, width) = geometry.face_overlap();
        let bow = Deflection::bow(self.bow_um * 1e-6, [low, low + width])?;
        Ok((self.bow_um != 0.0).then_some(bow))
    }
}

fn curve(path: &Path) -> Result<Deflection> {
    #[derive(Deserialize)]
    struct Row {
        z_mm: f64,
        closing_um: f64,
    }
    let mut points = Vec::new();
    for row in csv_reader(&output::read_text(path)?).deserialize() {
        let Row { z_mm, closing_um } = row?;
        limits::check(Some(closing_um), &(-LARGEST_UM..=LARGEST_UM))
            .map_err(|e| format!("closing_um = {closing_um} at z_mm = {z_mm}: {e}"))?;
        points.push([z_mm * 1e-3, closing_um * 1e-6]);
    }
    Ok(Deflection::new(points)?)
}
