//! `gearmesh report PAIR.json`: one HTML page with the static contact of a pair, in pictures.

pub mod chart;
mod flank_map;
pub mod page;
mod pressure;

use std::path::PathBuf;

use chart::{Axes, Curve, line_chart};
use clap::Args;
use gearmesh::contact::{ContactResult, CycleInput, MeshCycle};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::table::TableFile;
use page::Page;

use crate::Error;
use crate::limits;
use crate::model::{Model, ModelArgs};
use crate::output;
use crate::pair_summary::pair_summary;

/// Loads of the curves over the nominal torque.
const LOADS: [f64; 5] = [0.4, 0.7, 1.0, 1.3, 2.0];
/// Loads of the contact patterns over the nominal torque: 70, 100, 130 N m of the paper's Fig. 20.
const PATTERN_LOADS: [f64; 3] = [0.7, 1.0, 1.3];
/// Mesh positions whose contact lines are drawn.
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

    /// Number of positions over the mesh cycle
    #[arg(long, default_value_t = 64)]
    positions: usize,

    #[command(flatten)]
    model: ModelArgs,
}

impl Report {
    /// Solves, draws and writes.
    pub fn run(self) -> Result<(), Error> {
        limits::positions(self.positions)?;
        let pair = self.model.applied_to(Pair::read(&self.pair)?);
        output::check_writable(&self.output)?;
        self.model.use_threads()?;
        let job = self.model.job(&pair, "static contact")?;
        let model = self.model.solver(&pair, &job)?;
        let cycles = self.cycles(&pair, &model)?;

        let mut page = Page::new(&format!("Static tooth contact: {}", pair.name));
        page.section("Pair", &format!("Elastic model: {}.", model.description));
        page.preformatted(&pair_summary(&pair));
        if let Some(path) = &self.tables {
            let file = TableFile::read(path)?;
            if file.geometry.pair_geometry()? != pair.geometry {
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
        curves(&mut page, &cycles)?;
        table(&mut page, &cycles);
        pressures(&mut page, &pair, &model, self.positions)?;
        if let Some(folder) = &self.figures {
            std::fs::create_dir_all(folder)
                .map_err(|error| format!("--figures = {}: {error}", folder.display()))?;
            for figure in page.figures() {
                output::write_whole(&folder.join(&figure.file), figure.svg.as_bytes())?;
            }
        }
        output::write_whole(&self.output, page.finish().as_bytes())?;
        output::print(&format!("Wrote {}\n", self.output.display()))?;
        Ok(())
    }

    /// A mesh cycle for each load, the torque (N m) first.
    fn cycles(&self, pair: &Pair, model: &Model) -> Result<Vec<(f64, MeshCycle)>, Error> {
        let nominal = pair.operating.nominal_torque;
        LOADS
            .iter()
            .map(|load| load * nominal)
            .filter(|torque| *torque <= pair.operating.maximum_torque)
            .map(|torque| {
                let input = CycleInput {
                    flank: Flank::Drive,
                    torque,
                    center_distance_offset: 0.0,
                    misalignment: 0.0,
                    positions: self.positions,
                };
                Ok((torque, MeshCycle::solve(&model.solver, &input)?))
            })
            .collect()
    }
}

/// One quantity over the mesh cycle for every load; the first point is repeated at 1.
fn over_cycle(cycles: &[(f64, MeshCycle)], value: impl Fn(&ContactResult) -> f64) -> Vec<Curve> {
    cycles
        .iter()
        .map(|(torque, cycle)| {
            let mut points: Vec<(f64, f64)> = cycle
                .mesh_position
                .iter()
                .zip(&cycle.results)
                .map(|(tau, result)| (*tau, value(result)))
                .collect();
            points.push((1.0, points[0].1));
            Curve {
                label: format!("{torque:.0} N m"),
                points,
            }
        })
        .collect()
}

fn curves(page: &mut Page, cycles: &[(f64, MeshCycle)]) -> Result<(), Error> {
    page.section(
        "Static transmission error",
        "On the line of action at mid-face, over one mesh cycle; 0: a tooth pair touches at the pitch point.",
    );
    let axes = |y, from_zero| Axes {
        x: "mesh position",
        y,
        from_zero,
    };
    let ste = over_cycle(cycles, |r| r.approach * 1e6);
    page.pictures(&[line_chart(&axes("STE (um)", false), &ste)?]);

    page.section(
        "Load share of one tooth pair",
        "Of the pair that touches at the pitch point at mesh position 0, from the start of its contact to the end.",
    );
    let share: Vec<Curve> = cycles.iter().map(load_share).collect();
    page.pictures(&[line_chart(&axes("share of the load", true), &share)?]);

    page.section(
        "Contact position along the face",
        "Axial position of the resultant force, from gear 1's z = 0 face.",
    );
    let z = over_cycle(cycles, |r| r.contact_z * 1e3);
    page.pictures(&[line_chart(&axes("z_c (mm)", false), &z)?]);
    Ok(())
}

/// Share of one tooth pair as it moves through the mesh: pair k at position tau is pair 0 at tau + k.
fn load_share((torque, cycle): &(f64, MeshCycle)) -> Curve {
    let mut points: Vec<(f64, f64)> = cycle
        .mesh_position
        .iter()
        .zip(&cycle.results)
        .flat_map(|(tau, result)| {
            result
                .load_share
                .iter()
                .map(move |(k, share)| (tau + f64::from(*k), *share))
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Keep one point without load at either side.
    let first = points.iter().position(|p| p.1 > 0.0).unwrap_or(0);
    let last = points
        .iter()
        .rposition(|p| p.1 > 0.0)
        .unwrap_or(points.len() - 1);
    Curve {
        label: format!("{torque:.0} N m"),
        points: points[first.saturating_sub(1)..(last + 2).min(points.len())].to_vec(),
    }
}

fn table(page: &mut Page, cycles: &[(f64, MeshCycle)]) {
    page.section(
        "In numbers",
        "STE on the line of action; pressure after Hertz inside the flanks. Where contact reaches a sharp tip edge \
         pressure has no bound: there the load per length of contact line, with the gear whose edge it is.",
    );
    let rows: Vec<Vec<String>> = cycles
        .iter()
        .map(|(torque, cycle)| {
            vec![
                format!("{torque:.1}"),
                format!("{:.3}", cycle.mean_ste() * 1e6),
                format!("{:.3}", cycle.peak_to_peak_ste() * 1e6),
                format!("{:.3}", cycle.mean_contact_z() * 1e3),
                format!("{:.0}", cycle.max_pressure() * 1e-6),
                cycle.edge_load().map_or("none".into(), |edge| {
                    format!("{:.0} (gear {})", edge.line_load * 1e-3, edge.gear + 1)
                }),
                format!("{:.1e}", cycle.kkt_residual()),
            ]
        })
        .collect();
    page.table(
        &[
            "torque (N m)",
            "mean STE (um)",
            "p-p STE (um)",
            "mean z_c (mm)",
            "max. flank pressure (MPa)",
            "tip edge (N/mm)",
            "KKT residual",
        ],
        &rows,
    );
}

fn pressures(page: &mut Page, pair: &Pair, model: &Model, positions: usize) -> Result<(), Error> {
    let nominal = pair.operating.nominal_torque;
    page.section(
        "Contact pattern on gear 1",
        "Largest pressure that each place of the flank sees over the mesh cycle (Fig. 20 of the paper). \
         Blue: contact reaches the tip edge of gear 1, or of gear 2 where it meets the root; at a sharp edge \
         pressure has no bound, so it is not on the scale.",
    );
    let patterns = PATTERN_LOADS
        .iter()
        .map(|load| load * nominal)
        .filter(|torque| *torque <= pair.operating.maximum_torque)
        .map(|torque| {
            let patches = pressure::pattern(&model.solver, torque, 0.0, positions)?;
            Ok((format!("{torque:.0} N m"), patches))
        })
        .collect::<Result<Vec<_>, Error>>()?;
    page.pictures(&maps(pair, patterns)?);

    let limits = pair.operating.misalignment;
    let tilted: Vec<f64> = limits.into_iter().filter(|m| *m != 0.0).collect();
    if !tilted.is_empty() {
        page.section(
            "Contact pattern under misalignment",
            "At the nominal torque and the limits of the misalignment in the plane of action.",
        );
        let patterns = tilted
            .into_iter()
            .map(|m| {
                let patches = pressure::pattern(&model.solver, nominal, m, positions)?;
                Ok((format!("{:+.2} mrad", m * 1e3), patches))
            })
            .collect::<Result<Vec<_>, Error>>()?;
        page.pictures(&maps(pair, patterns)?);
    }

    page.section(
        "Pressure along the contact lines",
        "At the nominal torque and four positions of the mesh; one curve for each tooth pair in contact, up to \
         where contact reaches a tip edge.",
    );
    let charts = LINE_POSITIONS
        .iter()
        .map(|&tau| {
            let lines = pressure::contact_lines(&model.solver, nominal, tau)?;
            let label = format!("z (mm), mesh position {tau}");
            let axes = Axes {
                x: &label,
                y: "pressure (MPa)",
                from_zero: true,
            };
            line_chart(&axes, &lines)
        })
        .collect::<Result<Vec<_>, Error>>()?;
    page.pictures(&charts);
    Ok(())
}

/// Maps on one common scale, that of the contact inside the flanks.
fn maps(pair: &Pair, patterns: Vec<(String, Vec<flank_map::Patch>)>) -> Result<Vec<String>, Error> {
    let top = patterns
        .iter()
        .flat_map(|(_, patches)| patches.iter().filter(|p| !p.at_edge).map(|p| p.pressure))
        .fold(1.0, f64::max);
    let view = pressure::view(pair);
    patterns
        .into_iter()
        .map(|(title, patches)| flank_map::flank_map(&title, &view, patches, top))
        .collect()
}
