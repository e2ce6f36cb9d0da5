//! `gearmesh report PAIR.json`: one HTML page with the static contact of a pair, in pictures.

mod sections;
mod shafts;

use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::gear::Flank;
use gearmesh::table::{Table, TableFile};
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::static_contact::ContactSolver;
use gearmesh_preprocessor::{pair, table};

use crate::bands::bands_of;
use crate::case::{Case, LEGEND, Variant, details, load, summary, torque_in_words};
use crate::columns::{Column, Listing, columns, lines, list};
use crate::error::Result;
use crate::model::{ModelArgs, ShaftArgs, widen};
use crate::output::{self, Job};
use crate::page::{Page, Section, origin};
use crate::pair_summary::pair_summary;
use crate::{limits, revolution};
use sections::{Loads, evenly};

/// Loads of the curves over the nominal torque; 70, 100, 130 N m of the paper's Fig. 20 are among them.
const LOADS: [f64; 5] = [0.4, 0.7, 1.0, 1.3, 2.0];
/// Torques up to the largest one, speeds, and misalignments of the survey.
const TORQUES: usize = 12;
const SPEEDS: usize = 12;
const MISALIGNMENTS: usize = 9;

/// Write one HTML page with the contact of a pair in pictures; it opens without a network.
#[derive(Debug, Args)]
pub struct Report {
    /// Pair file
    pair: PathBuf,

    /// HTML file to write
    #[arg(short, long)]
    output: PathBuf,

    /// Another variant in the same charts, dashed: a pair file, or tables
    #[arg(long, value_name = "OTHER")]
    compare: Option<PathBuf>,

    /// Tables of this pair, whose size and error are then reported, too
    #[arg(long)]
    tables: Option<PathBuf>,

    /// Folder of a study of this pair, whose bands over torque are then shown, too
    #[arg(long, value_name = "FOLDER")]
    study: Option<PathBuf>,

    /// Folder for every chart as an SVG and a CSV file, too; it is made if it is not there
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,

    /// Torques of curves and contact patterns, N m, with commas between them [default: 0.4, 0.7, 1, 1.3 and 2 times the nominal one]
    #[arg(long, value_name = "TORQUES", value_delimiter = ',', value_parser = limits::torque)]
    torques_nm: Vec<f64>,

    /// Number of positions over the mesh cycle
    #[arg(long, default_value_t = limits::POSITIONS, value_parser = limits::within(1..=limits::MOST_POSITIONS))]
    positions: usize,

    /// Speed of gear 1 up to which losses are drawn, rpm
    #[arg(long, value_name = "SPEED", default_value_t = 3000.0, value_parser = limits::within(1.0..=1e6))]
    largest_speed_rpm: f64,

    #[command(flatten)]
    shafts: ShaftArgs,

    #[command(flatten)]
    model: ModelArgs,
}

impl Report {
    pub fn run(self) -> Result<()> {
        let (pair, gauges) = pair::read_with_gauges(&self.pair)?;
        let origin = origin(&self.pair)?;
        let others = self.tables.iter().chain(&self.compare);
        output::check_writable(&self.output, others.chain([&self.pair]))?;
        if let Some(folder) = &self.figures {
            output::make_folder("--figures", folder)?;
        }
        let job = self.model.start()?;
        let drawn = self.model.applied_to(pair);
        let pair = self.shafts.applied_to(drawn.clone());
        let loads = self.loads(&pair);
        let summary = pair_summary(&drawn, gauges);
        let tables = self.tables.as_ref();
        let tables = tables.map(|path| self.tables_section(path, &drawn));
        let tables = tables.transpose()?;
        let (description, sections) = self.pair_sections(pair.clone(), &loads, &job)?;
        let note = format!("Elastic model: {description}.");
        let mut page = Page {
            title: format!("Static tooth contact: {}", pair.name),
            origin,
            sections,
        };
        page.sections
            .push(Section::new("Pair", note, vec![]).with_text(summary));
        page.sections.extend(tables);
        if let Some(folder) = &self.study {
            page.sections.push(bands_of(folder, &pair.name)?);
        }
        if let Some(other) = &self.compare {
            let described = self.other(other, &loads, &job);
            let (name, sections) =
                described.map_err(|error| format!("--compare = {}: {error}", other.display()))?;
            page.title += &format!(", compared with {name} (dashed)");
            compare(&mut page.sections, sections, &name);
        }
        page.write(&self.output, self.figures.as_deref())?;
        output::print(&format!("Wrote {}\n", self.output.display()))
    }

    fn loads(&self, pair: &Pair) -> Loads {
        let operating = &pair.operating;
        let (nominal, largest) = (operating.nominal_torque, operating.maximum_torque);
        let [low, high] = operating.misalignment;
        let speed = self.largest_speed_rpm;
        let mut torques = self.torques_nm.clone();
        if torques.is_empty() {
            let usual = LOADS.map(|load| load * nominal);
            torques.extend(usual.iter().filter(|torque| **torque <= largest));
        }
        Loads {
            nominal,
            torques,
            survey: evenly(largest / TORQUES as f64, largest, TORQUES),
            tilts: evenly(low, high, if low < high { MISALIGNMENTS } else { 0 }),
            speeds: evenly(speed / SPEEDS as f64, speed, SPEEDS),
        }
    }

    /// The elastic model of `pair` in words, and the sections on its contact.
    fn pair_sections(&self, mut pair: Pair, loads: &Loads, job: &Job) -> Described {
        let ends = [loads.tilts.first(), loads.tilts.last()].map(|end| end.copied().unwrap_or(0.0));
        for &torque in loads.torques.iter().chain(&loads.survey) {
            widen(&mut pair, torque, ends, [0.0; 2]);
        }
        let roots = self.model.root_stress.then_some(Flank::Drive);
        let model = self.model.model(&pair, roots, job)?;
        let solver = &model.solver;
        let with_roots = Variant::Pair(solver, &pair.shafts, model.fillets.as_ref());
        let aligned = with_roots.cases(&loads.torques, &[0.0], self.positions)?;
        let variant = Variant::Pair(solver, &pair.shafts, None);
        let mut tilts = vec![0.0];
        tilts.extend(ends.into_iter().filter(|tilt| *tilt != 0.0));
        let nominal = variant.cases(&[loads.nominal], &tilts, self.positions)?;
        let survey = variant.cases(&loads.survey, &[0.0], sections::POSITIONS)?;
        let mut all = variant_sections(&variant, loads, &aligned, &survey)?;
        complete_overview(&mut all[0], &pair, &nominal[0]);
        all.insert(1, table(solver, &aligned));
        if let Some(section) = shafts::section(&pair, &variant, loads)? {
            all.insert(2, section);
        }
        if let Some(section) = revolution::section(&nominal[0], solver, &pair, job)? {
            all.insert(2, section);
        }
        if self.model.root_stress {
            all.push(sections::roots(&aligned, loads.nominal));
        }
        let others: Vec<Case> = aligned
            .into_iter()
            .filter(|case| case.load.torque != loads.nominal)
            .collect();
        all.extend(sections::carried(
            &pair,
            &others,
            &nominal[0],
            &nominal[1..],
        ));
        all.push(sections::losses(&pair, solver, loads, &survey));
        all.push(sections::modifications(&pair));
        Ok((model.description, all))
    }

    fn tables_section(&self, path: &Path, pair: &Pair) -> Result<Section> {
        let file = TableFile::read(path)?;
        let [path, own] = [path, &self.pair].map(Path::display);
        if file.geometry != pair.geometry {
            refuse!(
                "--tables = {path}: made for another gear geometry than {own}; name this pair's tables"
            );
        }
        if let Some(difference) = table::other_flanks(&file, pair) {
            refuse!(
                "--tables = {path}: made for other flanks than {own}: {difference}; name this pair's tables"
            );
        }
        Ok(
            Section::new("Tables", path.to_string(), vec![])
                .with_text(table::size_and_error(&file)),
        )
    }

    /// Name and sections of the variant in the file `path`.
    fn other(&self, path: &Path, loads: &Loads, job: &Job) -> Described {
        if !output::is_tables(&output::read_text(path)?) {
            let pair = self.model.applied_to(pair::read(path)?);
            let pair = self.shafts.applied_to(pair);
            let (_, sections) = self.pair_sections(pair.clone(), loads, job)?;
            return Ok((pair.name, sections));
        }
        let table = Table::from_file(TableFile::read(path)?)?;
        let name = format!("tables of {}", table.file.name);
        let variant = Variant::Tables(Box::new(table));
        let cases = variant.cases(&loads.torques, &[0.0], self.positions)?;
        let survey = variant.cases(&loads.survey, &[0.0], sections::POSITIONS)?;
        Ok((name, variant_sections(&variant, loads, &cases, &survey)?))
    }
}

/// What something is in words, and the sections on it.
type Described = Result<(String, Vec<Section>)>;

/// Adds to the `overview` what the pair is and carries at its `nominal` torque, in numbers and pictures.
fn complete_overview(overview: &mut Section, pair: &Pair, nominal: &Case) {
    let mut rows = Listing::default();
    list(&mut rows, &key_numbers(pair), &nominal);
    overview.text = rows.to_string();
    overview.note += &format!(" {}", sections::PATTERN_NOTE);
    overview
        .figures
        .extend(sections::teeth_in_mesh(&pair.geometry));
    overview.figures.extend(sections::contact_patterns(
        &pair.geometry,
        std::slice::from_ref(nominal),
        |case| torque_in_words(case.load.torque),
    ));
}

/// The pair and its mesh cycle in the numbers that are looked at first.
fn key_numbers(pair: &Pair) -> Vec<Column<'_, &Case>> {
    let g = &pair.geometry;
    let c = g.center_distance;
    let [one, two] = &g.gears;
    let backlash = 1e6 * g.backlash(c) / g.operating_pressure_angle(c).cos();
    columns! { |case: &&Case|
        "", ["teeth", "", None] => format!("{} / {}", one.teeth, two.teeth);
        "", ["normal module", "mm", 4] => 1e3 * one.normal_module;
        "", ["helix angle", "deg", 3] => one.helix_angle.to_degrees();
        "", ["centre distance", "mm", 4] => 1e3 * c;
        "", ["common face width", "mm", 3] => 1e3 * g.face_overlap().1;
        "", ["transverse contact ratio", "", 3] => g.transverse_contact_ratio(c);
        "", ["overlap ratio", "", 3] => g.overlap_ratio();
        "", ["backlash at the operating pitch circle", "um", 1] => backlash;
        "", ["nominal torque on gear 1", "N m", None] => case.load.torque;
        "", ["STE, mean", "um", 3] => 1e6 * case.cycle.mean_ste();
        "", ["STE, peak to peak", "um", 3] => 1e6 * case.cycle.peak_to_peak_ste();
        "", ["largest flank pressure", "MPa", 0] => 1e-6 * case.cycle.max_pressure();
        "", ["largest line load at a tip edge", "N/mm", 1] => case.cycle.edge_load().map_or(0.0, |edge| 1e-3 * edge.line_load);
        "", ["face load factor K_Hbeta", "", 3] => case.face_load.face_load_factor();
        "", ["mean mesh stiffness, tangent", "N/um", 1] => 1e-6 * case.cycle.mean_stiffness();
    }
}

/// What pair files and tables both show: `cases` at the torques of the curves, and those of the aligned `survey`.
fn variant_sections(
    variant: &Variant,
    loads: &Loads,
    cases: &[Case],
    survey: &[Case],
) -> Result<Vec<Section>> {
    let mut all = vec![sections::overview(cases), sections::cycle(variant, cases)];
    all.push(sections::torque(variant, loads, survey));
    if !loads.tilts.is_empty() {
        all.push(sections::misalignment(variant, loads)?);
    }
    Ok(all)
}

/// Adds to `sections` what those of the variant `name` show; its table becomes a section of its own.
fn compare(sections: &mut Vec<Section>, others: Vec<Section>, name: &str) {
    for other in others {
        let Some(i) = sections.iter().position(|s| s.heading == other.heading) else {
            continue;
        };
        if !other.table.is_empty() {
            let heading = format!("{}: {name}", other.heading);
            sections.insert(i + 1, Section { heading, ..other });
            continue;
        }
        for figure in other.figures {
            let figures = &mut sections[i].figures;
            let own = figures.iter().position(|own| own.title == figure.title);
            let apart = own.and_then(|k| Some((k, figures[k].compare(figure, name)?)));
            if let Some((k, figure)) = apart {
                figures.insert(k + 1, figure);
            }
        }
    }
}

/// Section with the results of `cases` in numbers.
fn table(solver: &ContactSolver, cases: &[Case]) -> Section {
    let mut notes = String::new();
    for case in cases {
        let elasticity = case.cycle.note_on_elasticity(solver.geometry());
        let torque = torque_in_words(case.load.torque);
        for note in elasticity.into_iter().chain(case.cycle.note_on_segments()) {
            notes += &format!(" {torque}: {note}.");
        }
    }
    let residuals = cases.iter().map(|case| case.cycle.kkt_residual());
    let residual = residuals.fold(0.0, f64::max);
    let note = format!(
        "{LEGEND} Pressure after Hertz inside the flanks. Where contact reaches a sharp tip edge pressure has no bound: there \
         the load per length of contact line, with the gear whose edge it is. Largest residual of the contact conditions {residual:.1e}.{notes}"
    );
    let mut columns = load();
    columns.extend(summary(solver));
    columns.extend(details(solver));
    Section {
        table: lines(&columns, cases),
        ..Section::new("In numbers", note, vec![])
    }
}
