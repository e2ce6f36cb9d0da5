//! `gearmesh run-up PAIR.fmu`: two discs through the resonances of the mesh and back, as a page.

use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::gear::PairGeometry;
use gearmesh::table::TableFile;
use gearmesh_preprocessor::package::{self, Blank, Setting};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::run_up::{History, Sweep, decided_by};
use gearmesh_preprocessor::shaft::BearingShares;

use crate::error::Result;
use crate::limits;
use crate::output::{self, Job};
use crate::page::{Page, origin};
use summary::{RPM, Summary};

mod summary;

/// Sweep the speed of two discs that an FMU couples up and down, and draw swings, orders and spectra.
#[derive(Debug, Args)]
pub struct RunUpCommand {
    /// FMU of the pair
    fmu: PathBuf,

    /// HTML file to write
    #[arg(short, long)]
    output: PathBuf,

    /// Moments of inertia about their axes, kg m2, of gear 1 and of gear 2 with all that turns with them; inf: it turns as imposed
    /// [default: the gears alone]
    #[arg(long, value_name = "J", num_args = 2, value_parser = inertia)]
    inertia_kg_m2: Vec<f64>,

    /// Damping ratio of both discs on the mean mesh stiffness
    #[arg(long, value_name = "RATIO", default_value_t = 0.05, value_parser = limits::within(0.0..=0.99))]
    damping_ratio: f64,

    /// Mean torque on gear 1, N m; < 0: on the coast flank [default: the nominal one]
    #[arg(long, value_name = "T", value_parser = limits::finite)]
    torque_nm: Option<f64>,

    /// Lowest and highest speed of gear 1, rpm [default: 0.3 and 1.4 times the resonance of the mean stiffness]
    #[arg(long, value_names = ["LOW", "HIGH"], num_args = 2, value_parser = limits::within(0.0..=1e7))]
    speed_rpm: Vec<f64>,

    /// Time of each way, s [default: twenty decay times while the mesh frequency crosses the resonance]
    #[arg(long, value_name = "S", value_parser = limits::within(1e-6..=1e4))]
    sweep_s: Option<f64>,

    /// Communication step, s [default: 0.07 rad of the natural frequency, or a twentieth of the shortest mesh cycle]
    #[arg(long, value_name = "S", value_parser = limits::within(1e-12..=1e4))]
    step_s: Option<f64>,

    /// Pair file of these gears with their shafts on bearings: draws what the bearings bear
    #[arg(long, value_name = "PAIR")]
    shafts: Option<PathBuf>,

    /// Value of another parameter, such as backlash=8e-5; repeatable
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Setting>,

    /// Folder for every chart as an SVG and a CSV file, too; it is made if it is not there
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,

    /// Folder for the signals of both ways, up.npy and down.npy: arrays of NumPy with a field for each signal
    #[arg(long, value_name = "DIR")]
    signals: Option<PathBuf>,

    /// Print JSON instead of text
    #[arg(long)]
    json: bool,

    /// Show no progress
    #[arg(short, long)]
    quiet: bool,
}

/// A moment of inertia, kg m².
fn inertia(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().unwrap_or(f64::NAN);
    (value > 0.0)
        .then_some(value)
        .ok_or_else(|| "give a number > 0, or inf for a gear that turns as imposed".to_owned())
}

/// How the bearings in the pair file at `path` share the loads on gears that are those of `geometry`.
fn on_bearings(path: &Path, geometry: &PairGeometry) -> Result<[Option<BearingShares>; 2]> {
    let pair = pair::read(path)?;
    let file = path.display();
    for ((name, here), (_, there)) in lengths(&pair.geometry).into_iter().zip(lengths(geometry)) {
        if (here - there).abs() > 1e-9 * there.abs().max(1e-3) {
            refuse!(
                "--shafts {file}: its gears are not those of the FMU: {name} {here} in SI, not {there}; give the file that the FMU was \
                 built from"
            );
        }
    }
    if pair.shafts.iter().all(Option::is_none) {
        refuse!(
            "--shafts {file}: no gear has a shaft on bearings; give `shaft` with `sections` and `bearings`"
        );
    }
    Ok([0, 1].map(|i| BearingShares::new(pair.shafts[i].as_ref()?, &pair.geometry.gears[i])))
}

/// What gears on the same shafts have in common, SI, by its name.
fn lengths(pair: &PairGeometry) -> Vec<(&'static str, f64)> {
    let mut all = vec![("centre distance", pair.center_distance)];
    for gear in &pair.gears {
        all.extend([
            ("teeth", gear.z()),
            ("normal module", gear.normal_module),
            ("helix angle", gear.helix_angle),
            ("face width", gear.face_width),
            ("offset of the faces", gear.face_offset),
        ]);
    }
    all
}

impl RunUpCommand {
    /// Files of the signals in run-up and run-down, where they are wanted.
    fn signal_files(&self) -> Option<[PathBuf; 2]> {
        let folder = self.signals.as_ref()?;
        Some(["up.npy", "down.npy"].map(|name| folder.join(name)))
    }

    /// Refuses start values that the sweep would overwrite, and those given twice.
    fn check_settings(&self) -> Result<()> {
        Setting::check_once(&self.set)?;
        for setting in &self.set {
            if let Some(decides) = decided_by(&setting.start().0) {
                refuse!("--set {setting}: {decides}");
            }
        }
        Ok(())
    }

    pub fn run(self) -> Result<()> {
        self.check_settings()?;
        let read: Vec<&PathBuf> = [&self.fmu].into_iter().chain(&self.shafts).collect();
        output::check_writable(&self.output, &read)?;
        for (option, folder) in [("--figures", &self.figures), ("--signals", &self.signals)] {
            if let Some(folder) = folder {
                output::make_folder(option, folder)?;
            }
        }
        // What cannot be written shall not cost the time of the run.
        for file in self.signal_files().into_iter().flatten() {
            output::check_writable(&file, &read)?;
        }
        let origin = origin(&self.fmu)?;
        let found = package::inspect(&self.fmu)?;
        let mut unit = found.unit;
        unit.starts.extend(self.set.iter().map(Setting::start));
        let tables = found
            .tables
            .as_deref()
            .map(TableFile::from_json)
            .transpose()?;
        let geometry = &unit.geometry;
        let shafts = match &self.shafts {
            Some(path) => on_bearings(path, geometry)?,
            None => [None, None],
        };
        let given = <[f64; 2]>::try_from(&self.inertia_kg_m2[..]);
        let inertia = given.unwrap_or_else(|_| {
            let gears = geometry.gears.each_ref();
            gears.map(|gear| Blank::new(gear).axial_inertia)
        });
        let mut sweep = Sweep {
            inertia,
            damping_ratio: self.damping_ratio,
            torque: self
                .torque_nm
                .unwrap_or_else(|| unit.start(&VARIABLES[index::NOMINAL_TORQUE])),
            speeds: [0.0; 2],
            duration: self.sweep_s,
            step: self.step_s,
        };
        let resonance = sweep.resonance_speed(&unit);
        let speeds = self
            .speed_rpm
            .iter()
            .map(|rpm| rpm * RPM)
            .collect::<Vec<_>>();
        sweep.speeds =
            <[f64; 2]>::try_from(&speeds[..]).unwrap_or([0.3 * resonance, 1.4 * resonance]);
        if let [low, high] = self.speed_rpm[..]
            && low >= high
        {
            refuse!("--speed-rpm {low} {high}: give the lower speed first, and a higher one");
        }
        let job = Job::new(self.quiet);
        let contact = found.contact.as_ref();
        let run = sweep
            .run(&unit, tables.as_ref(), contact, shafts, &|share| {
                job.show("sweeping the speed", share)
            })
            .map_err(|refusal| format!("{}: {}", self.fmu.display(), refusal.message))?;
        drop(job);
        for (file, history) in self
            .signal_files()
            .iter()
            .flatten()
            .zip([&run.up, &run.down])
        {
            output::write_whole(file, &npy(history))?;
        }
        let summary = Summary::new(&sweep, &run);
        let page = Page {
            title: format!("Run-up: {}", unit.name),
            origin,
            sections: summary.sections(geometry.gears[0].teeth),
        };
        page.write(&self.output, self.figures.as_deref())?;
        output::print(&match self.json {
            true => format!("{:#}\n", summary.json()),
            false => format!("{}\nWrote {}\n", summary.listing(), self.output.display()),
        })
    }
}

/// The signals as a structured array in the format of NumPy, version 1.0.
fn npy(history: &History) -> Vec<u8> {
    let [one, two] = &history.acceleration;
    let outside: Vec<f64> = history
        .out_of_range
        .iter()
        .map(|out| f64::from(u8::from(*out)))
        .collect();
    let mut columns: Vec<(String, &[f64], f64)> = [
        ("time_s", &history.time[..], 1.0),
        ("angle_rad", &history.angle, 1.0),
        ("speed_rpm", &history.speed, 1.0 / RPM),
        ("transmission_error_um", &history.transmission_error, 1e6),
        ("tangential_force_n", &history.tangential_force, 1.0),
        ("acceleration_gear1_rad_per_s2", one, 1.0),
        ("acceleration_gear2_rad_per_s2", two, 1.0),
        ("out_of_range", &outside, 1.0),
    ]
    .map(|(name, values, scale)| (name.to_owned(), values, scale))
    .into();
    for (gear, bearings) in history.bearing_force.iter().enumerate() {
        for (bearing, force) in bearings.iter().enumerate() {
            let name = format!("gear{}_bearing{}_radial_force_n", gear + 1, bearing + 1);
            columns.push((name, force, 1.0));
        }
    }
    let fields: Vec<String> = columns
        .iter()
        .map(|(name, ..)| format!("('{name}', '<f8')"))
        .collect();
    let fields = fields.join(", ");
    let rows = history.time.len();
    let mut head = format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': ({rows},), }}");
    // Magic, version and length take 10 bytes; the head ends on a multiple of 64 with a line break.
    let padding = 63 - (head.len() + 10) % 64;
    head.push_str(&" ".repeat(padding));
    head.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((head.len() as u16).to_le_bytes());
    out.extend(head.as_bytes());
    for i in 0..rows {
        for (_, values, scale) in &columns {
            out.extend((values[i] * scale).to_le_bytes());
        }
    }
    out
}
