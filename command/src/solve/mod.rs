//! `gearmesh solve PAIR.json`: mesh cycles, quasi-static, for one load or a matrix of loads.

mod deflection;
mod files;
mod report;
mod roots;
mod text;

use gearmesh_preprocessor::pair;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gearmesh::contact::Deflection;
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh_preprocessor::contact::{CycleInput, GearRoots, LoadCase, MeshCycle};
use serde::Serialize;

use crate::limits;
use crate::losses::{Losses, SpeedArgs};
use crate::model::{Fillets, Model, ModelArgs, widen};
use crate::output::{self, Listing, rows};
use deflection::DeflectionArgs;
use report::Report;
use roots::Roots;

/// Solve the static contact over the mesh cycle, for one load or for every torque with every misalignment.
#[derive(Debug, Args)]
pub struct Solve {
    /// Pair file
    pair: PathBuf,

    /// Torques on gear 1, N m, separated by commas [default: the pair's nominal torque]
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    torque_nm: Vec<f64>,

    /// Number of positions over the mesh cycle
    #[arg(long, default_value_t = limits::POSITIONS)]
    positions: usize,

    /// Actual minus nominal centre distance, um
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    center_distance_offset_um: f64,

    /// Misalignments in the plane of action, mrad, separated by commas; > 0: more penetration at larger z
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, default_values_t = [0.0])]
    misalignment_mrad: Vec<f64>,

    /// Loaded flank of gear 1; drive: in contact when gear 1 turns in its + sense and drives; coast: the other one
    #[arg(long, default_value = "drive", value_parser = PossibleValuesParser::new(["drive", "coast"]).map(flank))]
    flank: Flank,

    #[command(flatten)]
    deflection: DeflectionArgs,

    /// Stress in the tooth roots of both gears, too, with the nominal one of ISO 6336-3 beside it; its elastic
    /// model takes two to three times as long as that of the contact
    #[arg(long, conflicts_with = "plane_strain")]
    root_stress: bool,

    #[command(flatten)]
    speeds: SpeedArgs,

    /// Solve with finite elements of another refinement, too, and print how far the results differ
    #[arg(long, conflicts_with = "json")]
    estimate_error: bool,

    /// Print JSON
    #[arg(long)]
    json: bool,

    /// Folder for load distribution, mesh cycle, stiffness, load along the face and a summary as CSV files, too; it
    /// is made if it is not there
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    #[command(flatten)]
    model: ModelArgs,
}

fn flank(name: String) -> Flank {
    match name.as_str() {
        "coast" => Flank::Coast,
        _ => Flank::Drive,
    }
}

/// Cycles and what it took to solve them.
struct Solved {
    model: Model,
    /// One for each load.
    cycles: Vec<MeshCycle>,
    /// For the stress in the roots, where it is asked for.
    fillets: Option<Fillets>,
    /// The stress of both gears for each load, likewise.
    roots: Vec<Option<[GearRoots; 2]>>,
}

/// What `--json` prints of more than one load.
#[derive(Serialize)]
struct Matrix<'a> {
    cases: &'a [Report],
}

impl Solve {
    /// Solves and prints.
    pub fn run(self) -> Result<(), crate::Error> {
        limits::within("positions", self.positions, 1..=limits::MOST_POSITIONS)?;
        let mut pair = self.model.applied_to(pair::read(&self.pair)?);
        let cases = self.cases(&pair)?;
        let deflection = self.deflection.read(&pair.geometry)?;
        if let Some(folder) = &self.output {
            files::check(folder, self.root_stress)?;
        }
        let input = CycleInput {
            flank: self.flank,
            torque: cases[0].torque,
            center_distance_offset: self.center_distance_offset_um * 1e-6,
            misalignment: cases[0].misalignment,
            positions: self.positions,
        };
        let bent = deflection.as_ref().map_or(0.0, |deflection| {
            let (low, width) = pair.geometry.face_overlap();
            let [least, largest] = deflection.range([low, low + width], 0.0);
            (largest - least) / width
        });
        for LoadCase {
            torque,
            misalignment,
        } in &cases
        {
            // A deflection gathers the load as the misalignment of its range does.
            let tilts = [misalignment - bent, misalignment + bent];
            widen(&mut pair, *torque, tilts, [input.center_distance_offset; 2]);
        }
        self.model.use_threads()?;
        let solved = |pair: &Pair| self.solve(pair, &input, &cases, deflection.as_ref());
        let Solved {
            model,
            cycles,
            fillets,
            roots,
        } = solved(&pair)?;
        let stresses = largest_stresses(&roots);
        let reports: Vec<Report> = cases
            .iter()
            .zip(cycles.iter().zip(roots))
            .map(|(case, (cycle, gears))| {
                let input = of_case(&input, case);
                let roots = gears.map(|gears| Roots::new(&pair.geometry, &input, cycle, gears));
                let stations = model.solver.settings().stations;
                let losses = Losses::new(&pair, &input, cycle, &self.speeds)?;
                Ok(Report {
                    roots,
                    ..Report::new(&pair, &input, stations, cycle, losses)
                })
            })
            .collect::<Result<_, crate::Error>>()?;
        if let Some(folder) = &self.output {
            files::write(folder, &pair.geometry, &cycles, &reports)?;
        }
        let mut text = match (&cycles[..], &reports[..]) {
            (_, [report]) if self.json => serde_json::to_string_pretty(report)? + "\n",
            _ if self.json => serde_json::to_string_pretty(&Matrix { cases: &reports })? + "\n",
            ([cycle], [report]) => text::one(&pair, (&model, &fillets), &input, cycle, report),
            _ => text::many(&pair, (&model, &fillets), &input, &reports),
        };
        if self.estimate_error {
            let other = solved(&ModelArgs::reference(&pair))?;
            text += &difference(&other, &cycles, &stresses);
        }
        output::print(&text)?;
        Ok(())
    }

    /// Every torque with every misalignment, refused where no pair file may cover it.
    fn cases(&self, pair: &Pair) -> Result<Vec<LoadCase>, crate::Error> {
        let nominal = [pair.operating.nominal_torque];
        let torques = match &self.torque_nm[..] {
            [] => &nominal[..],
            given => given,
        };
        let offset = self.center_distance_offset_um;
        limits::within(
            "center-distance-offset-um",
            offset,
            limits::CENTER_DISTANCE_OFFSETS,
        )?;
        let mut cases = Vec::new();
        for &torque in torques {
            limits::torque("torque-nm", torque)
                .map_err(|error| format!("{error}; for the other flank say `--flank coast`"))?;
            for &misalignment in &self.misalignment_mrad {
                limits::within("misalignment-mrad", misalignment, limits::MISALIGNMENTS)?;
                cases.push(LoadCase {
                    torque,
                    misalignment: misalignment * 1e-3,
                });
            }
        }
        // More results would not fit into memory.
        limits::within(
            "torque-nm times --misalignment-mrad",
            cases.len(),
            1..=10_000,
        )?;
        Ok(cases)
    }

    /// The solver of `pair`, and a cycle for each of `cases`, with the stress in the roots where it is asked for.
    fn solve(
        &self,
        pair: &Pair,
        input: &CycleInput,
        cases: &[LoadCase],
        deflection: Option<&Deflection>,
    ) -> Result<Solved, crate::Error> {
        let job = self.model.job();
        let mut model = self.model.solver(pair, &job)?;
        if let Some(deflection) = deflection {
            model.solver = model.solver.with_deflection(deflection.clone());
        }
        let total = self.positions * cases.len();
        let told = |share: f64| {
            let done = (share * total as f64).round();
            job.tell(
                "static contact",
                share,
                &format!("{done} of {total} solves"),
            );
        };
        let cycles = MeshCycle::solve_all(&model.solver, input, cases, &told)?;
        let fillets = match self.root_stress {
            true => Some(self.model.fillets(pair, input.flank, &job)?),
            false => None,
        };
        let roots = cases
            .iter()
            .zip(&cycles)
            .map(|(case, cycle)| {
                let input = of_case(input, case);
                let stress = |of: &Fillets| cycle.root_stress(&model.solver, &input, &of.maps);
                fillets.as_ref().map(stress).transpose()
            })
            .collect::<Result<_, _>>()?;
        Ok(Solved {
            model,
            cycles,
            fillets,
            roots,
        })
    }
}

/// `input` at the load of `case`.
fn of_case(input: &CycleInput, case: &LoadCase) -> CycleInput {
    CycleInput {
        torque: case.torque,
        misalignment: case.misalignment,
        ..*input
    }
}

/// The largest stress in the roots of gear 1 and gear 2, Pa, for each load; nothing where it is not asked for.
fn largest_stresses(roots: &[Option<[GearRoots; 2]>]) -> Vec<[f64; 2]> {
    let largest = |gear: &GearRoots| gear.largest().map_or(0.0, |tooth| tooth.largest.stress);
    let of = |gears: &[GearRoots; 2]| gears.each_ref().map(largest);
    roots.iter().flatten().map(of).collect()
}

/// How far the first of a pair of results is from the second where they differ most, in words.
fn worst(results: impl Iterator<Item = (f64, f64)>) -> String {
    let shares = results.map(|(a, b)| a / b - 1.0);
    let worst = shares
        .filter(|share| share.is_finite())
        .max_by(|a, b| a.abs().total_cmp(&b.abs()));
    worst.map_or("none to tell: it is zero".into(), |worst| {
        format!("{:+.2} %", 100.0 * worst)
    })
}

/// How far `cycles` and `stresses` of the roots are from those of `other` refinement, at the load where they differ most.
fn difference(other: &Solved, cycles: &[MeshCycle], stresses: &[[f64; 2]]) -> String {
    let largest = |of: fn(&MeshCycle) -> f64| {
        let both = cycles.iter().zip(&other.cycles);
        worst(both.map(|(a, b)| (of(a), of(b))))
    };
    let model = &other.model;
    let mut rows = Listing::default();
    rows! { rows;
        "compared with" => "{}", model.description;
        "mean STE" => "{}", largest(MeshCycle::mean_ste);
        "peak-to-peak STE" => "{}", largest(MeshCycle::peak_to_peak_ste);
    }
    if other.fillets.is_some() {
        let others = largest_stresses(&other.roots);
        for i in 0..2 {
            let both = stresses.iter().zip(&others);
            let largest = worst(both.map(|(a, b)| (a[i], b[i])));
            rows.row(format!("root stress of gear {}", i + 1), largest);
        }
    }
    rows! { rows; "time for its elastic model" => "{:.3} s, {}", model.compliance_seconds, model.origin; }
    if let Some(f) = &other.fillets {
        rows! { rows; "time for its model of the fillets" => "{:.3} s, {}", f.seconds, f.origin; }
    }
    format!("\nestimated error, from the difference to another refinement\n{rows}")
}
