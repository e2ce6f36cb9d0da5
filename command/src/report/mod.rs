//! `gearmesh report PAIR.json`: one HTML page with the static contact of a pair, in pictures.

pub mod chart;
mod losses;
mod map;
pub mod page;
mod picture;
mod pressure;
mod roots;
mod survey;

use gearmesh_preprocessor::pair;
use std::path::{Path, PathBuf};

use chart::{Curve, Height, line_chart};
use clap::Args;
use gearmesh::contact::ContactResult;
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::table::TableFile;
use gearmesh_preprocessor::contact::{LoadCase, MeshCycle};
use map::{Patch, map};
use page::Page;
use pressure::Quantity;

use crate::Error;
use crate::limits;
use crate::model::{Model, ModelArgs, widen};
use crate::output;
use crate::pair_summary::pair_summary;

/// Loads of the curves over the nominal torque.
const LOADS: [f64; 5] = [0.4, 0.7, 1.0, 1.3, 2.0];
/// Loads of the contact patterns over the nominal torque: 70, 100, 130 N m of the paper's Fig. 20.
const PATTERN_LOADS: [f64; 3] = [0.7, 1.0, 1.3];
/// Least height of the axis of transmission errors, um: what lies below is rounding and the solver's tolerance.
const LEAST_ERROR: f64 = 1e-3;
/// Least height of the axis of the contact's position, over the face width.
const LEAST_PLACE: f64 = 0.1;
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

    /// Torques of curves and contact patterns, N m, with commas between them [default: 0.4, 0.7, 1, 1.3 and 2 times
    /// the nominal torque up to the largest of the pair file]
    #[arg(long, value_name = "TORQUES", value_delimiter = ',')]
    torques_nm: Vec<f64>,

    /// Number of positions over the mesh cycle
    #[arg(long, default_value_t = limits::POSITIONS)]
    positions: usize,

    /// Speed of gear 1 up to which losses are drawn, rpm
    #[arg(long, value_name = "SPEED", default_value_t = 3000.0)]
    largest_speed_rpm: f64,

    /// Stress in the tooth roots, too; its elastic model takes two to three times as long as that of the contact
    #[arg(long, conflicts_with = "plane_strain")]
    root_stress: bool,

    #[command(flatten)]
    model: ModelArgs,
}

impl Report {
    /// Solves, draws and writes.
    pub fn run(self) -> Result<(), Error> {
        limits::within("positions", self.positions, 1..=limits::MOST_POSITIONS)?;
        limits::within("largest-speed-rpm", self.largest_speed_rpm, 1.0..=1e6)?;
        let mut pair = self.model.applied_to(pair::read(&self.pair)?);
        for &torque in &self.torques_nm {
            limits::torque("torques-nm", torque)?;
            widen(&mut pair, torque, [0.0; 2], [0.0; 2]);
        }
        let read: Vec<&Path> = (self.tables.iter().chain([&self.pair]))
            .map(PathBuf::as_path)
            .collect();
        output::check_writable(&self.output, &read)?;
        if let Some(folder) = &self.figures {
            output::make_folder("--figures", folder)?;
        }
        self.model.use_threads()?;
        let job = self.model.job();
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
        curves(&mut page, &pair, &cycles)?;
        table(&mut page, &cycles);
        let aligned = survey::survey(&mut page, &pair, &model.solver)?;
        losses::losses(&mut page, &pair, &aligned, self.largest_speed_rpm)?;
        self.patterns(&mut page, &pair, &model)?;
        if self.root_stress {
            let models = self.model.fillets(&pair, Flank::Drive, &job)?.maps;
            roots::roots(&mut page, &pair, &model.solver, &models, &cycles)?;
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
        torques
            .filter(|torque| *torque <= pair.operating.maximum_torque)
            .collect()
    }

    /// A mesh cycle for each load, the torque (N m) first.
    fn cycles(&self, pair: &Pair, model: &Model) -> Result<Vec<(f64, MeshCycle)>, Error> {
        let torques = self.torques(pair, &LOADS);
        let cases: Vec<LoadCase> = torques
            .iter()
            .map(|&torque| LoadCase {
                torque,
                misalignment: 0.0,
            })
            .collect();
        let cycles = survey::cycles(&model.solver, &cases, self.positions)?;
        Ok(torques.into_iter().zip(cycles).collect())
    }

    /// Where on the flank the load is carried.
    fn patterns(&self, page: &mut Page, pair: &Pair, model: &Model) -> Result<(), Error> {
        let nominal = pair.operating.nominal_torque;
        let torques = self.torques(pair, &PATTERN_LOADS);
        let of = |quantity, torques: &[f64], misalignments: &[f64]| {
            let mut maps = Vec::new();
            for &torque in torques {
                for &m in misalignments {
                    let title = if torques.len() > 1 || misalignments == [0.0] {
                        torque_in_words(torque)
                    } else {
                        format!("{:+.2} mrad", m * 1e3)
                    };
                    let patches =
                        pressure::pattern(&model.solver, quantity, torque, m, self.positions)?;
                    maps.push((title, patches));
                }
            }
            flank_maps(pair, quantity, maps)
        };
        page.section(
            "Contact pattern on gear 1",
            "Largest pressure that each place of the flank sees over the mesh cycle (Fig. 20 of the paper). \
             Blue: contact reaches the tip edge of gear 1, or of gear 2 where it meets the root; at a sharp edge \
             pressure has no bound, so it is not on the scale.",
        );
        page.pictures(&of(Quantity::Pressure, &torques, &[0.0])?);

        page.section(
            "Load distribution on gear 1",
            "Largest normal force per length of contact line that each place of the flank carries over the mesh cycle.",
        );
        page.pictures(&of(Quantity::LineLoad, &torques, &[0.0])?);

        let limits = pair.operating.misalignment;
        let tilted: Vec<f64> = limits.into_iter().filter(|m| *m != 0.0).collect();
        if !tilted.is_empty() {
            page.section(
                "Contact pattern under misalignment",
                "At the nominal torque and the limits of the misalignment in the plane of action.",
            );
            page.pictures(&of(Quantity::Pressure, &[nominal], &tilted)?);
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
                line_chart([&label, "pressure (MPa)"], Height::FromZero(0.0), &lines)
            })
            .collect::<Result<Vec<_>, Error>>()?;
        page.pictures(&charts);
        Ok(())
    }
}

fn torque_in_words(torque: f64) -> String {
    format!("{} N m", gearmesh::words::rounded(torque))
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
                label: torque_in_words(*torque),
                points,
            }
        })
        .collect()
}

fn curves(page: &mut Page, pair: &Pair, cycles: &[(f64, MeshCycle)]) -> Result<(), Error> {
    let mut chart = |label: &str, height: Height, curves: &[Curve], heading: &str, note: &str| {
        page.section(heading, note);
        page.pictures(&[line_chart(["mesh position", label], height, curves)?]);
        Ok::<(), Error>(())
    };
    let mut ste = over_cycle(cycles, |r| r.approach * 1e6);
    for (curve, (_, cycle)) in ste.iter_mut().zip(cycles) {
        let mean = 1e6 * cycle.mean_ste();
        curve.points.iter_mut().for_each(|p| p.1 -= mean);
    }
    chart(
        "STE less its mean (um)",
        Height::Curves(LEAST_ERROR),
        &ste,
        "Static transmission error about its mean",
        "On the line of action at mid-face, over one mesh cycle, less the mean of the cycle, which the table below has. At \
         mesh position 0 a tooth pair touches at the pitch point.",
    )?;
    chart(
        "stiffness (N/um)",
        Height::FromZero(0.0),
        &over_cycle(cycles, |r| r.tangent.force_by_approach * 1e-6),
        "Mesh stiffness",
        "Tangent stiffness dF/d(STE) under the load, on the line of action.",
    )?;
    chart(
        "share of the load",
        Height::FromZero(0.0),
        &cycles.iter().map(load_share).collect::<Vec<_>>(),
        "Load share of one tooth pair",
        "Of the pair that touches at the pitch point at mesh position 0, from the start of its contact to the end.",
    )?;
    chart(
        "z_c (mm)",
        Height::Curves(LEAST_PLACE * 1e3 * pair.geometry.face_overlap().1),
        &over_cycle(cycles, |r| r.contact_z * 1e3),
        "Contact position along the face",
        "Axial position of the resultant force, from gear 1's z = 0 face. The axis shows a tenth of the common face at least.",
    )
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
        label: torque_in_words(*torque),
        points: points[first.saturating_sub(1)..(last + 2).min(points.len())].to_vec(),
    }
}

fn table(page: &mut Page, cycles: &[(f64, MeshCycle)]) {
    let notes = cycles.iter().filter_map(|(torque, cycle)| {
        let note = cycle.note_on_segments()?;
        Some(format!(" {}: {note}.", torque_in_words(*torque)))
    });
    let notes: String = notes.collect();
    page.section(
        "In numbers",
        &format!(
            "STE on the line of action; pressure after Hertz inside the flanks. Where contact reaches a sharp tip edge \
             pressure has no bound: there the load per length of contact line, with the gear whose edge it is.{notes}"
        ),
    );
    type Cell = fn(f64, &MeshCycle) -> String;
    let columns: [(&str, Cell); 7] = [
        ("torque (N m)", |torque, _| format!("{torque:.1}")),
        ("mean STE (um)", |_, c| format!("{:.3}", c.mean_ste() * 1e6)),
        ("p-p STE (um)", |_, c| {
            format!("{:.3}", c.peak_to_peak_ste() * 1e6)
        }),
        ("mean z_c (mm)", |_, c| {
            format!("{:.3}", c.mean_contact_z() * 1e3)
        }),
        ("max. flank pressure (MPa)", |_, c| {
            format!("{:.0}", c.max_pressure() * 1e-6)
        }),
        ("tip edge (N/mm)", |_, c| {
            c.edge_load().map_or("none".into(), |edge| {
                format!("{:.0} (gear {})", edge.line_load * 1e-3, edge.gear + 1)
            })
        }),
        ("KKT residual", |_, c| format!("{:.1e}", c.kkt_residual())),
    ];
    let row = |(torque, cycle): &(f64, MeshCycle)| {
        columns
            .iter()
            .map(|(_, cell)| cell(*torque, cycle))
            .collect()
    };
    let rows: Vec<Vec<String>> = cycles.iter().map(row).collect();
    page.table(&columns.map(|(head, _)| head), &rows);
}

/// Maps on one common scale, that of the contact inside the flanks.
fn flank_maps(
    pair: &Pair,
    quantity: Quantity,
    patterns: Vec<(String, Vec<Patch>)>,
) -> Result<Vec<String>, Error> {
    let top = patterns
        .iter()
        .flat_map(|(_, patches)| patches.iter().filter(|p| !p.apart).map(|p| p.value))
        .fold(1.0, f64::max);
    let view = pressure::view(pair, quantity);
    patterns
        .into_iter()
        .map(|(title, patches)| map(&title, &view, patches, top))
        .collect()
}
