//! `gearmesh report PAIR.json`: one HTML page with the static contact of a pair, in pictures.

pub mod chart;
pub mod page;
mod picture;
mod pressure;
mod roots;
mod survey;

use std::path::PathBuf;

use clap::Args;
use gearmesh::contact::{ContactResult, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::table::TableFile;
use gearmesh_preprocessor::pair;

use crate::Error;
use crate::case::{Case, LEGEND, details, load, summary, torque_in_words};
use crate::columns::lines;
use crate::limits;
use crate::model::{ModelArgs, widen};
use crate::output;
use crate::pair_summary::pair_summary;
use chart::{Curve, Height, line_chart};
use page::Page;
use pressure::{LINE_LOAD, PRESSURE, Quantity};

/// Loads of the curves over the nominal torque.
const LOADS: [f64; 5] = [0.4, 0.7, 1.0, 1.3, 2.0];
/// Loads of the contact patterns over the nominal torque: 70, 100, 130 N m of the paper's Fig. 20.
const PATTERN_LOADS: [f64; 3] = [0.7, 1.0, 1.3];
/// Least height of the axis of transmission errors, um: what lies below is rounding and the solver's tolerance.
const LEAST_ERROR: f64 = 1e-3;
/// Least height of the axis of the contact's position, over the face width.
const LEAST_PLACE: f64 = 0.1;
const LINE_POSITIONS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// Write one HTML page with the contact of a pair in pictures; it opens without a network.
#[derive(Debug, Args)]
pub struct Report {
    /// Pair file
    pair: PathBuf,

    /// HTML file to write
    #[arg(short, long)]
    output: PathBuf,

    /// Tables of this pair, whose size and error are then reported, too
    #[arg(long)]
    tables: Option<PathBuf>,

    /// Folder for the pictures as SVG files, too; it is made if it is not there
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,

    /// Torques of curves and contact patterns, N m, with commas between them [default: 0.4, 0.7, 1, 1.3 and 2 times
    /// the nominal torque up to the largest of the pair file]
    #[arg(long, value_name = "TORQUES", value_delimiter = ',', value_parser = limits::torque)]
    torques_nm: Vec<f64>,

    /// Number of positions over the mesh cycle
    #[arg(long, default_value_t = limits::POSITIONS, value_parser = limits::within(1..=limits::MOST_POSITIONS))]
    positions: usize,

    /// Speed of gear 1 up to which losses are drawn, rpm
    #[arg(long, value_name = "SPEED", default_value_t = 3000.0, value_parser = limits::within(1.0..=1e6))]
    largest_speed_rpm: f64,

    /// Stress in the tooth roots, too; its elastic model takes two to three times as long as that of the contact
    #[arg(long, conflicts_with = "plane_strain")]
    root_stress: bool,

    #[command(flatten)]
    model: ModelArgs,
}

impl Report {
    pub fn run(self) -> Result<(), Error> {
        let (pair, gauges) = pair::read_with_gauges(&self.pair)?;
        let mut pair = self.model.applied_to(pair);
        for &torque in &self.torques_nm {
            widen(&mut pair, torque, [0.0; 2], [0.0; 2]);
        }
        output::check_writable(&self.output, self.tables.iter().chain([&self.pair]))?;
        if let Some(folder) = &self.figures {
            output::make_folder("--figures", folder)?;
        }
        self.model.use_threads()?;
        let job = self.model.job();
        let model = self.model.solver(&pair, &job)?;
        let torques = self.torques(&pair, &LOADS);
        let mut cases = survey::cases(&model.solver, &torques, &[0.0], self.positions)?;

        let mut page = Page::new(&format!("Static tooth contact: {}", pair.name));
        page.section("Pair", &format!("Elastic model: {}.", model.description));
        page.preformatted(&pair_summary(&pair, gauges));
        if let Some(path) = &self.tables {
            let file = TableFile::read(path)?;
            if file.geometry != pair.geometry {
                return Err(format!(
                    "--tables = {}: made for another gear geometry than {}; name this pair's tables",
                    path.display(),
                    self.pair.display()
                )
                .into());
            }
            page.section("Tables", &path.display().to_string());
            page.preformatted(&file.size_and_error());
        }
        curves(&mut page, &pair, &cases)?;
        table(&mut page, &model.solver, &cases);
        survey::survey(&mut page, &pair, &model.solver, self.largest_speed_rpm)?;
        self.patterns(&mut page, &pair, &model.solver)?;
        if self.root_stress {
            let fillets = self.model.fillets(&pair, Flank::Drive, &job)?;
            for case in &mut cases {
                case.solve_roots(&model.solver, Some(&fillets))?;
            }
            roots::roots(&mut page, &pair, &cases)?;
        }
        if let Some(folder) = &self.figures {
            for figure in page.figures() {
                output::write_whole(&folder.join(&figure.file), figure.svg.as_bytes())?;
            }
        }
        output::write_whole(&self.output, page.finish().as_bytes())?;
        output::print(&format!("Wrote {}\n", self.output.display()))?;
        Ok(())
    }

    /// The torques asked for, or `loads` times the nominal one, N m.
    fn torques(&self, pair: &Pair, loads: &[f64]) -> Vec<f64> {
        if !self.torques_nm.is_empty() {
            return self.torques_nm.clone();
        }
        let torques = loads
            .iter()
            .map(|load| load * pair.operating.nominal_torque);
        let largest = pair.operating.maximum_torque;
        torques.filter(|torque| *torque <= largest).collect()
    }

    /// Where on the flank the load is carried.
    fn patterns(&self, page: &mut Page, pair: &Pair, solver: &ContactSolver) -> Result<(), Error> {
        let nominal = pair.operating.nominal_torque;
        let torques = self.torques(pair, &PATTERN_LOADS);
        let aligned = torques
            .iter()
            .map(|&torque| (torque_in_words(torque), torque, 0.0));
        let aligned: Vec<(String, f64, f64)> = aligned.collect();
        // Maps on one common scale, that of the contact inside the flanks, each of a load with its title.
        let maps = |quantity: &Quantity,
                    loads: &[(String, f64, f64)]|
         -> Result<Vec<String>, Error> {
            let mut patterns = Vec::new();
            for (title, torque, misalignment) in loads {
                let patches =
                    pressure::pattern(solver, quantity, *torque, *misalignment, self.positions)?;
                patterns.push((title.clone(), patches));
            }
            let inside = patterns
                .iter()
                .flat_map(|(_, patches)| patches)
                .filter(|p| !p.apart);
            let top = inside.map(|p| p.value).fold(1.0, f64::max);
            let patterns = patterns.into_iter();
            patterns
                .map(|(title, patches)| pressure::flank_map(pair, quantity, title, patches, top))
                .collect()
        };
        page.section(
            "Contact pattern on gear 1",
            "Largest pressure that each place of the flank sees over the mesh cycle (Fig. 20 of the paper). \
             Blue: contact reaches the tip edge of gear 1, or of gear 2 where it meets the root; at a sharp edge \
             pressure has no bound, so it is not on the scale.",
        );
        page.pictures(&maps(&PRESSURE, &aligned)?);

        page.section(
            "Load distribution on gear 1",
            "Largest normal force per length of contact line that each place of the flank carries over the mesh cycle.",
        );
        page.pictures(&maps(&LINE_LOAD, &aligned)?);

        let limits = pair.operating.misalignment.into_iter();
        let tilted = limits
            .filter(|m| *m != 0.0)
            .map(|m| (format!("{:+.2} mrad", m * 1e3), nominal, m));
        let tilted: Vec<(String, f64, f64)> = tilted.collect();
        if !tilted.is_empty() {
            page.section(
                "Contact pattern under misalignment",
                "At the nominal torque and the limits of the misalignment in the plane of action.",
            );
            page.pictures(&maps(&PRESSURE, &tilted)?);
        }

        page.section(
            "Pressure along the contact lines",
            "At the nominal torque and four positions of the mesh; one curve for each tooth pair in contact, up to \
             where contact reaches a tip edge.",
        );
        let charts = LINE_POSITIONS.iter().map(|&tau| {
            let lines = pressure::contact_lines(solver, nominal, tau)?;
            let label = format!("z (mm), mesh position {tau}");
            line_chart([&label, "pressure (MPa)"], Height::FromZero(0.0), &lines)
        });
        page.pictures(&charts.collect::<Result<Vec<_>, Error>>()?);
        Ok(())
    }
}

/// One quantity over the mesh cycle for every load; the first point is repeated at 1.
fn over_cycle(cases: &[Case], value: impl Fn(&Case, &ContactResult) -> f64) -> Vec<Curve> {
    let curve = |case: &Case| {
        let values = case.cycle.results.iter().map(|result| value(case, result));
        let points = case.cycle.mesh_position.iter().copied().zip(values);
        let mut curve = Curve::new(torque_in_words(case.input.torque), points);
        curve.points.push((1.0, curve.points[0].1));
        curve
    };
    cases.iter().map(curve).collect()
}

fn curves(page: &mut Page, pair: &Pair, cases: &[Case]) -> Result<(), Error> {
    let mut chart = |label: &str, height: Height, curves: &[Curve], heading: &str, note: &str| {
        page.section(heading, note);
        page.pictures(&[line_chart(["mesh position", label], height, curves)?]);
        Ok::<(), Error>(())
    };
    chart(
        "STE less its mean (um)",
        Height::Curves(LEAST_ERROR),
        &over_cycle(cases, |case, r| 1e6 * (r.approach - case.cycle.mean_ste())),
        "Static transmission error about its mean",
        "On the line of action at mid-face, over one mesh cycle, less the mean of the cycle, which the table below has. At \
         mesh position 0 a tooth pair touches at the pitch point.",
    )?;
    chart(
        "stiffness (N/um)",
        Height::FromZero(0.0),
        &over_cycle(cases, |_, r| r.tangent.force_by_approach * 1e-6),
        "Mesh stiffness",
        "Tangent stiffness dF/d(STE) under the load, on the line of action.",
    )?;
    chart(
        "share of the load",
        Height::FromZero(0.0),
        &cases.iter().map(load_share).collect::<Vec<_>>(),
        "Load share of one tooth pair",
        "Of the pair that touches at the pitch point at mesh position 0, from the start of its contact to the end.",
    )?;
    chart(
        "z_c (mm)",
        Height::Curves(LEAST_PLACE * 1e3 * pair.geometry.face_overlap().1),
        &over_cycle(cases, |_, r| r.contact_z * 1e3),
        "Contact position along the face",
        "Axial position of the resultant force, from gear 1's z = 0 face. The axis shows a tenth of the common face at least.",
    )
}

/// Share of one tooth pair as it moves through the mesh: pair k at position tau is pair 0 at tau + k.
fn load_share(case: &Case) -> Curve {
    let results = case.cycle.mesh_position.iter().zip(&case.cycle.results);
    let shares = results.flat_map(|(tau, result)| {
        let shares = result.load_share.iter();
        shares.map(move |(k, share)| (tau + f64::from(*k), *share))
    });
    let mut points: Vec<(f64, f64)> = shares.collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Keep one point without load at either side.
    let is_loaded = |p: &(f64, f64)| p.1 > 0.0;
    let first = points.iter().position(is_loaded).unwrap_or(0);
    let last = points
        .iter()
        .rposition(is_loaded)
        .unwrap_or(points.len() - 1);
    points.truncate(last + 2);
    Curve::new(
        torque_in_words(case.input.torque),
        points.split_off(first.saturating_sub(1)),
    )
}

/// Section with the results of `cases` in numbers.
fn table(page: &mut Page, solver: &ContactSolver, cases: &[Case]) {
    let notes = cases.iter().filter_map(|case| {
        let note = case.cycle.note_on_segments()?;
        Some(format!(" {}: {note}.", torque_in_words(case.input.torque)))
    });
    let notes: String = notes.collect();
    let residual = cases
        .iter()
        .map(|case| case.cycle.kkt_residual())
        .fold(0.0, f64::max);
    page.section(
        "In numbers",
        &format!(
            "{LEGEND} Pressure after Hertz inside the flanks. Where contact reaches a sharp tip edge pressure has no bound: there \
             the load per length of contact line, with the gear whose edge it is. Largest KKT residual {residual:.1e}.{notes}"
        ),
    );
    let mut columns = load();
    columns.extend(summary(solver));
    columns.extend(details(solver));
    let mut rows = lines(&columns, cases);
    let units = rows.remove(1);
    for (head, unit) in rows[0]
        .iter_mut()
        .zip(units)
        .filter(|(_, unit)| !unit.is_empty())
    {
        *head = format!("{head} ({unit})");
    }
    page.table(&rows);
}
