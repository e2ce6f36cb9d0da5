//! `gearmesh solve PAIR.json`: one mesh cycle, quasi-static.

use std::fmt::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gearmesh::contact::{CycleInput, MeshCycle};
use gearmesh::gear::{self, PairGeometry};
use gearmesh::pair::{Operating, Pair};
use serde::Serialize;

use gearmesh::words::{fixed, rounded};

use crate::limits;
use crate::losses::{Losses, SpeedArgs};
use crate::model::{Model, ModelArgs};
use crate::output::{self, Listing};

/// The loaded flank of gear 1 on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Flank {
    /// In contact when gear 1 turns in its + sense and drives
    Drive,
    /// The other one
    Coast,
}

impl From<Flank> for gear::Flank {
    fn from(flank: Flank) -> Self {
        match flank {
            Flank::Drive => gear::Flank::Drive,
            Flank::Coast => gear::Flank::Coast,
        }
    }
}

/// Solve the static contact over one mesh cycle.
#[derive(Debug, Args)]
pub struct Solve {
    /// Pair file
    pair: PathBuf,

    /// Torque on gear 1, N m [default: the pair's nominal torque]
    #[arg(long, allow_negative_numbers = true)]
    torque_nm: Option<f64>,

    /// Number of positions over the mesh cycle
    #[arg(long, default_value_t = limits::POSITIONS)]
    positions: usize,

    /// Actual minus nominal centre distance, um
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    center_distance_offset_um: f64,

    /// Misalignment in the plane of action, mrad; > 0: more penetration at larger z
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    misalignment_mrad: f64,

    /// Loaded flank of gear 1
    #[arg(long, value_enum, default_value_t = Flank::Drive)]
    flank: Flank,

    /// Solve with finite elements of another refinement, too, and print how far the results differ
    #[arg(long, conflicts_with = "json")]
    estimate_error: bool,

    /// Print JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    speeds: SpeedArgs,

    #[command(flatten)]
    model: ModelArgs,
}

impl Solve {
    /// Solves and prints.
    pub fn run(self) -> Result<(), crate::Error> {
        limits::positions(self.positions)?;
        limits::operating_point(
            self.torque_nm,
            self.center_distance_offset_um,
            self.misalignment_mrad,
        )?;
        let mut pair = self.model.applied_to(Pair::read(&self.pair)?);
        self.widen(&mut pair.operating);
        self.model.use_threads()?;
        let model = self.model.solver(&pair, None)?;
        let input = CycleInput {
            flank: self.flank.into(),
            torque: self.torque_nm.unwrap_or(pair.operating.nominal_torque),
            center_distance_offset: self.center_distance_offset_um * 1e-6,
            misalignment: self.misalignment_mrad * 1e-3,
            positions: self.positions,
        };
        let cycle = MeshCycle::solve(&model.solver, &input)?;
        let losses = Losses::new(&pair, &input, &cycle, &self.speeds)?;
        let report = Report::new(&pair.geometry, &input, &cycle, losses);
        let text = if self.json {
            serde_json::to_string_pretty(&report)? + "\n"
        } else {
            let mut text = text(&pair, &model, &input, &cycle, &report);
            if self.estimate_error {
                text += &self.difference(&pair, &input, &cycle)?;
            }
            text
        };
        output::print(&text)?;
        Ok(())
    }

    /// Widens the ranges of the pair file to what is asked here: they decide how wide a contact the elastic
    /// model resolves and how far tip corners are followed.
    fn widen(&self, operating: &mut Operating) {
        let torque = self.torque_nm.unwrap_or(operating.nominal_torque);
        operating.maximum_torque = operating.maximum_torque.max(torque);
        let include = |range: &mut [f64; 2], value: f64| {
            *range = [range[0].min(value), range[1].max(value)];
        };
        include(&mut operating.misalignment, self.misalignment_mrad * 1e-3);
        include(
            &mut operating.center_distance_offset,
            self.center_distance_offset_um * 1e-6,
        );
    }

    /// How far the elastic model of another refinement is from this one.
    fn difference(
        &self,
        pair: &Pair,
        input: &CycleInput,
        cycle: &MeshCycle,
    ) -> Result<String, crate::Error> {
        let model = self.model.solver(&ModelArgs::reference(pair), None)?;
        let other = MeshCycle::solve(&model.solver, input)?;
        let percent = |a: f64, b: f64| format!("{:+.2} %", 100.0 * (a / b - 1.0));
        let mut rows = Listing::default();
        rows.row("compared with", &model.description)
            .row("mean STE", percent(cycle.mean_ste(), other.mean_ste()))
            .row(
                "peak-to-peak STE",
                percent(cycle.peak_to_peak_ste(), other.peak_to_peak_ste()),
            )
            .row(
                "time for its elastic model",
                format!("{:.3} s, {}", model.compliance_seconds, model.origin),
            );
        Ok(format!(
            "\nestimated error, from the difference to another refinement\n{rows}"
        ))
    }
}

/// What `--json` prints. Arrays run over the positions.
#[derive(Debug, Serialize)]
struct Report {
    /// Base pitches; 0: a tooth pair touches at the pitch point at mid-face.
    mesh_position: Vec<f64>,
    /// Static transmission error on the line of action at mid-face.
    ste_loa_um: Vec<f64>,
    /// Resultant force, from gear 1's z = 0 face.
    contact_z_mm: Vec<f64>,
    /// Share of each of `tooth_pairs` in the load, one list per position.
    load_share: Vec<Vec<f64>>,
    /// Largest Hertz pressure inside the flanks.
    maximum_pressure_mpa: Vec<f64>,
    /// Largest normal force per length of contact line where contact reaches a tip edge; zero where none does.
    edge_line_load_n_per_mm: Vec<f64>,
    /// Where that is, from gear 1's z = 0 face.
    edge_z_mm: Vec<Option<f64>>,
    /// The gear whose tip edge it is, 1 or 2.
    edge_gear: Vec<Option<usize>>,
    /// The tooth pairs of `load_share`; number 0 touches at the pitch point at mesh position 0, the
    /// next one to come into mesh has the number below.
    tooth_pairs: Vec<i32>,
    mean_ste_loa_um: f64,
    peak_to_peak_ste_loa_um: f64,
    /// Amplitudes of harmonics 1 to 5; null where the positions are too few.
    harmonics_loa_um: Vec<Option<f64>>,
    transverse_contact_ratio: f64,
    overlap_ratio: f64,
    #[serde(flatten)]
    losses: Losses,
    /// Wall clock of the contact solves.
    solve_seconds: f64,
}

impl Report {
    fn new(
        geometry: &PairGeometry,
        input: &CycleInput,
        cycle: &MeshCycle,
        losses: Losses,
    ) -> Report {
        let shares = |result: &gearmesh::contact::ContactResult, pair: i32| {
            let of_pair = result.load_share.iter().find(|(k, _)| *k == pair);
            of_pair.map_or(0.0, |(_, share)| *share)
        };
        let mut tooth_pairs: Vec<i32> = cycle
            .results
            .iter()
            .flat_map(|r| r.load_share.iter().filter(|(_, share)| *share > 0.0))
            .map(|(k, _)| *k)
            .collect();
        tooth_pairs.sort_unstable();
        tooth_pairs.dedup();
        let edges = || cycle.results.iter().map(|r| r.edge_load);
        let um = |values: Vec<f64>| values.into_iter().map(|v| v * 1e6).collect();
        Report {
            mesh_position: cycle.mesh_position.clone(),
            ste_loa_um: um(cycle.ste()),
            contact_z_mm: cycle.results.iter().map(|r| r.contact_z * 1e3).collect(),
            load_share: cycle
                .results
                .iter()
                .map(|r| tooth_pairs.iter().map(|&k| shares(r, k)).collect())
                .collect(),
            maximum_pressure_mpa: cycle
                .results
                .iter()
                .map(|r| r.max_pressure * 1e-6)
                .collect(),
            edge_line_load_n_per_mm: edges()
                .map(|edge| edge.map_or(0.0, |edge| edge.line_load * 1e-3))
                .collect(),
            edge_z_mm: edges().map(|edge| Some(edge?.z * 1e3)).collect(),
            edge_gear: edges().map(|edge| Some(edge?.gear + 1)).collect(),
            tooth_pairs,
            mean_ste_loa_um: cycle.mean_ste() * 1e6,
            peak_to_peak_ste_loa_um: cycle.peak_to_peak_ste() * 1e6,
            harmonics_loa_um: cycle
                .harmonics()
                .iter()
                .map(|h| h.is_finite().then_some(h * 1e6))
                .collect(),
            transverse_contact_ratio: geometry
                .transverse_contact_ratio(geometry.center_distance + input.center_distance_offset),
            overlap_ratio: geometry.overlap_ratio(),
            losses,
            solve_seconds: cycle.solve_seconds,
        }
    }
}

fn text(
    pair: &Pair,
    model: &Model,
    input: &CycleInput,
    cycle: &MeshCycle,
    report: &Report,
) -> String {
    let mut text = format!(
        "{}: {} N m on gear 1, {} flank, centre distance offset {} um, misalignment {} mrad\n\n",
        pair.name,
        rounded(input.torque),
        if input.flank.sign() > 0.0 {
            "drive"
        } else {
            "coast"
        },
        rounded(input.center_distance_offset * 1e6),
        rounded(input.misalignment * 1e3),
    );
    let _ = write!(
        text,
        "{:>9} {:>11} {:>9} {:>9} {:>9}",
        "mesh", "STE (loa)", "z_c", "p_max", "tip edge"
    );
    for k in &report.tooth_pairs {
        let _ = write!(text, " {:>8}", format!("pair {k}"));
    }
    let _ = write!(
        text,
        "\n{:>9} {:>11} {:>9} {:>9} {:>9}",
        "position", "um", "mm", "MPa", "N/mm"
    );
    for _ in &report.tooth_pairs {
        let _ = write!(text, " {:>8}", "share");
    }
    text.push('\n');
    for i in 0..report.mesh_position.len() {
        let _ = write!(
            text,
            "{:>9.4} {:>11} {:>9} {:>9.1} {:>9.1}",
            report.mesh_position[i],
            fixed(report.ste_loa_um[i], 4),
            fixed(report.contact_z_mm[i], 4),
            report.maximum_pressure_mpa[i],
            report.edge_line_load_n_per_mm[i]
        );
        for share in &report.load_share[i] {
            let _ = write!(text, " {share:>8.4}");
        }
        text.push('\n');
    }
    text.push_str(
        "\nSTE: static transmission error on the line of action at mid-face, from unmodified flanks that just touch.\n\
         z_c: axial position of the resulting force, from the z = 0 face of gear 1.\n\
         pair k: share of a tooth pair in the load. Pair 0 touches at the pitch point at mid-face at mesh position 0;\n\
         pair 1 is ahead of it by one pitch and leaves the mesh first, pair -1 comes into mesh after it.\n",
    );
    let harmonics: Vec<String> = report
        .harmonics_loa_um
        .iter()
        .map(|h| h.map_or("-".into(), |h| format!("{h:.4}")))
        .collect();
    let mut rows = Listing::default();
    rows.row("mean STE", format!("{:.4} um", report.mean_ste_loa_um))
        .row(
            "peak-to-peak STE",
            format!("{:.4} um", report.peak_to_peak_ste_loa_um),
        )
        .row(
            "largest flank pressure",
            format!("{:.1} MPa", cycle.max_pressure() * 1e-6),
        )
        .row(
            "largest line load at a tip edge",
            cycle.edge_load().map_or("none".into(), |edge| {
                format!(
                    "{:.1} N/mm, gear {} at z = {:.2} mm",
                    edge.line_load * 1e-3,
                    edge.gear + 1,
                    edge.z * 1e3
                )
            }),
        )
        .row("harmonics 1 to 5", format!("{} um", harmonics.join(" ")))
        .row(
            "transverse contact ratio",
            format!("{:.4}", report.transverse_contact_ratio),
        )
        .row("overlap ratio", format!("{:.4}", report.overlap_ratio));
    report.losses.list(&mut rows);
    rows.row(
        "largest KKT residual",
        format!("{:.1e}", cycle.kkt_residual()),
    )
    .row("elastic model", &model.description)
    .row(
        "time for the elastic model",
        format!("{:.3} s, {}", model.compliance_seconds, model.origin),
    )
    .row(
        "time for the contact",
        format!("{:.3} s", report.solve_seconds),
    );
    let _ = write!(text, "\n{rows}");
    text
}
