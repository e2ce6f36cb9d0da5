//! `gearmesh solve PAIR.json`: mesh cycles, quasi-static, for one load or a matrix of loads.

mod results;
mod text;

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use gearmesh::contact::Deflection;
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::pair::Pair;
use gearmesh_preprocessor::contact::{CycleInput, LoadCase};
use gearmesh_preprocessor::pair;
use serde::Deserialize;
use serde_json::json;

use crate::Error;
use crate::case::{Case, load_matrix, summary};
use crate::limits;
use crate::model::{Model, ModelArgs, widen};
use crate::output::{self, Listing, rows};
use crate::progress::Job;

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

    /// Misalignments in the plane of action, mrad, separated by commas; > 0: more penetration at larger z
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, default_values_t = [0.0], value_parser = limits::within(limits::MISALIGNMENTS))]
    misalignment_mrad: Vec<f64>,

    /// Loaded flank of gear 1; drive: in contact when gear 1 turns in its + sense and drives; coast: the other one
    #[arg(long, default_value = "drive", value_parser = PossibleValuesParser::new(["drive", "coast"]))]
    flank: String,

    #[command(flatten)]
    deflection: DeflectionArgs,

    /// Speeds of gear 1 at which loss and efficiency are given, rpm, separated by commas
    #[arg(long, value_delimiter = ',', value_parser = limits::within(0.0..=1e6))]
    speed_rpm: Vec<f64>,

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
    pub fn run(self) -> Result<(), Error> {
        let mut pair = self.model.applied_to(pair::read(&self.pair)?);
        let loads = self.loads(&pair)?;
        let deflection = self.deflection.read(&pair.geometry)?;
        if let Some(folder) = &self.output {
            results::check(folder, self.model.root_stress)?;
        }
        let bent = deflection.as_ref().map_or(0.0, |deflection| {
            let (low, width) = pair.geometry.face_overlap();
            let [least, largest] = deflection.range([low, low + width], 0.0);
            (largest - least) / width
        });
        let offset = self.center_distance_offset_um * 1e-6;
        for load in &loads {
            // A deflection gathers the load as the misalignment of its range does.
            let tilts = [load.misalignment - bent, load.misalignment + bent];
            widen(&mut pair, load.torque, tilts, [offset; 2]);
        }
        let job = self.model.start()?;
        let solved = self.solve(pair, &loads, deflection.as_ref(), &job)?;
        let solver = &solved.model.solver;
        if let Some(folder) = &self.output {
            results::write(folder, solver, &solved.cases)?;
        }
        let mut text = if self.json {
            let json = |case| results::json(solver, &solved.pair, case, &self.speed_rpm);
            let json = match &solved.cases[..] {
                [case] => json(case).into(),
                cases => json!({ "cases": cases.iter().map(json).collect::<Vec<_>>() }),
            };
            format!("{json:#}\n")
        } else {
            text::text(&solved, &self.speed_rpm)
        };
        if self.estimate_error {
            let other = ModelArgs::reference(&solved.pair);
            let other = self.solve(other, &loads, deflection.as_ref(), &job)?;
            text += &difference(&solved, &other);
        }
        drop(job);
        Ok(output::print(&text)?)
    }

    fn flank(&self) -> Flank {
        match &*self.flank {
            "coast" => Flank::Coast,
            _ => Flank::Drive,
        }
    }

    fn loads(&self, pair: &Pair) -> Result<Vec<LoadCase>, Error> {
        let mut torques = self.torque_nm.clone();
        if torques.is_empty() {
            torques.push(pair.operating.nominal_torque);
        }
        let count = torques.len() * self.misalignment_mrad.len();
        // More results would not fit into memory.
        limits::check(Some(count), &(1..=10_000))
            .map_err(|error| format!("torques times misalignments = {count}: {error}"))?;
        let misalignments = self.misalignment_mrad.iter().map(|mrad| mrad * 1e-3);
        Ok(load_matrix(&torques, &misalignments.collect::<Vec<_>>()))
    }

    /// A cycle of `pair` for each of `loads`, with the stress in the roots where it is requested.
    fn solve(
        &self,
        pair: Pair,
        loads: &[LoadCase],
        deflection: Option<&Deflection>,
        job: &Job,
    ) -> Result<Solved, Error> {
        let roots = self.model.root_stress.then_some(self.flank());
        let mut model = self.model.model(&pair, roots, job)?;
        if let Some(deflection) = deflection {
            model.solver = model.solver.with_deflection(deflection.clone());
        }
        let input = CycleInput {
            flank: self.flank(),
            torque: loads[0].torque,
            center_distance_offset: self.center_distance_offset_um * 1e-6,
            misalignment: loads[0].misalignment,
            positions: self.positions,
        };
        let progress = |share| job.show("static contact", share);
        let fillets = model.fillets.as_ref();
        let cases = Case::solve_all(&model.solver, fillets, &input, loads, &progress)?;
        Ok(Solved { pair, model, cases })
    }
}

/// How far the results of `solved` are from those of the `other` refinement, at the load where they differ most.
fn difference(solved: &Solved, other: &Solved) -> String {
    let model = &other.model;
    let mut rows = Listing::default();
    rows! { rows; "compared with" => "{}", model.description; }
    let mut columns = summary(&model.solver);
    if model.fillets.is_some() {
        columns.extend(text::largest_root_stress());
    }
    for column in &columns {
        let both = solved.cases.iter().zip(&other.cases);
        let share = |(a, b)| Some(column.number(&a)? / column.number(&b)? - 1.0);
        let shares = both.filter_map(share).filter(|share| share.is_finite());
        let worst = shares.max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let words = worst.map_or("none to give: it is zero".into(), |worst| {
            format!("{:+.2} %", 100.0 * worst)
        });
        rows.row(&column.head, words);
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

    /// How much less both ends of the face close than its middle, um, parabolic, 0 at mid-face
    #[arg(long, default_value_t = 0.0, value_parser = limits::within(-LARGEST_UM..=LARGEST_UM))]
    bow_um: f64,
}

/// Largest closing that is read, um: a hundred times what shafts do.
const LARGEST_UM: f64 = 1e4;

impl DeflectionArgs {
    /// The deflection; None where none is requested.
    fn read(&self, geometry: &PairGeometry) -> Result<Option<Deflection>, Error> {
        if let Some(path) = &self.deflection {
            let curve = curve(path).map_err(|error| format!("{}: {error}", path.display()))?;
            return Ok(Some(curve));
        }
        let (low, width) = geometry.face_overlap();
        let bow = Deflection::bow(self.bow_um * 1e-6, [low, low + width])?;
        Ok((self.bow_um != 0.0).then_some(bow))
    }
}

fn curve(path: &Path) -> Result<Deflection, Error> {
    #[derive(Deserialize)]
    struct Row {
        z_mm: f64,
        closing_um: f64,
    }
    // The reader counts a line only at its \n, after the position of the next one.
    let text = output::read_text(path)?.replace("\r\n", "\n");
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let mut points = Vec::new();
    for row in reader.deserialize() {
        let Row { z_mm, closing_um } = row?;
        limits::check(Some(closing_um), &(-LARGEST_UM..=LARGEST_UM))
            .map_err(|e| format!("closing_um = {closing_um} at z_mm = {z_mm}: {e}"))?;
        points.push([z_mm * 1e-3, closing_um * 1e-6]);
    }
    Ok(Deflection::new(points)?)
}
