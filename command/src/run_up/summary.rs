//! What is said and drawn of a run-up.

use std::f64::consts::TAU;

use gearmesh::words::{fixed, rounded, significant};
use gearmesh_preprocessor::run_up::{History, RunUp, Sweep};
use serde_json::{Value, json};

use crate::columns::{Listing, rows};
use crate::page::{Curve, Figure, Height, Map, Section, Style, charts};

/// One revolution per minute, rad/s.
pub const RPM: f64 = TAU / 60.0;
const SPEED: &str = "speed of gear 1 (rpm)";
/// Harmonics of the mesh frequency that are drawn.
const HARMONICS: usize = 3;
/// Mesh cycles in a window of the swings at the lowest speed, and windows over the speed, at most.
const CYCLES: f64 = 3.0;
const WINDOWS: f64 = 150.0;
/// Rows of the map of spectra, and how far below the largest level it begins, dB.
const FREQUENCIES: usize = 120;
const DEPTH: f64 = 70.0;

/// Radial forces of one bearing.
struct BearingForces {
    gear: usize,
    bearing: usize,
    /// N.
    mean: f64,
    /// Of run-up and run-down, N, with its speed, rpm.
    largest: [[f64; 2]; 2],
}

impl BearingForces {
    fn name(&self) -> String {
        format!("gear {}, bearing {}", self.gear + 1, self.bearing + 1)
    }

    fn json(&self) -> Value {
        let [up, down] = self
            .largest
            .map(|[force, speed]| json!({ "largest_radial_force_n": force, "largest_rpm": speed }));
        json!({ "gear": self.gear + 1, "bearing": self.bearing + 1, "mean_radial_force_n": self.mean, "up": up, "down": down })
    }
}

/// What is said of a run-up.
pub struct Summary<'a> {
    sweep: &'a Sweep,
    run: &'a RunUp,
    /// Length of the windows of swings, s.
    window: f64,
}

impl<'a> Summary<'a> {
    pub fn new(sweep: &'a Sweep, run: &'a RunUp) -> Self {
        let lowest = sweep.speeds[0].max(0.02 * sweep.speeds[1]);
        let mesh = TAU / (lowest * run.resonance_speed.recip() * run.natural_frequency * TAU);
        Summary {
            sweep,
            run,
            window: (CYCLES * mesh)
                .max(run.duration / WINDOWS)
                .min(run.duration),
        }
    }

    fn ways(&self) -> [(&'static str, &'a History); 2] {
        [("run-up", &self.run.up), ("run-down", &self.run.down)]
    }

    /// Half of the peak-to-peak transmission error in um, largest, with its speed in rpm.
    fn largest_swing(&self, history: &History) -> (f64, f64) {
        let swings = history.swing(&history.transmission_error, self.window);
        let largest = swings.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        largest.map_or((f64::NAN, f64::NAN), |(speed, swing)| {
            (speed / RPM, 1e6 * swing)
        })
    }

    /// Speeds, rpm, between which poses or loads lie outside the tables, and the share of the time.
    fn out_of_range(&self, history: &History) -> Option<([f64; 2], f64)> {
        let outside = &history.out_of_range;
        let count = outside.iter().filter(|out| **out).count();
        let between = speeds_between(history, |k| outside[k])?;
        Some((between, count as f64 / outside.len() as f64))
    }

    /// Lowest and highest speed, rpm, at which the teeth part.
    fn parted(&self, history: &History) -> Option<[f64; 2]> {
        speeds_between(history, |k| history.tangential_force[k] == 0.0)
    }

    /// Largest radial force of each bearing in a way, N, with the speed in rpm; the mean over both ways beside it.
    fn bearings(&self) -> Vec<BearingForces> {
        let ways = self.ways().map(|(_, history)| history);
        let counts = [0, 1].map(|gear| (gear, ways[0].bearing_force[gear].len()));
        let all = counts
            .into_iter()
            .flat_map(|(gear, count)| (0..count).map(move |bearing| (gear, bearing)));
        let found = all.map(|(gear, bearing)| {
            let forces = ways.map(|history| &history.bearing_force[gear][bearing]);
            let sum: f64 = forces.iter().map(|force| force.iter().sum::<f64>()).sum();
            BearingForces {
                gear,
                bearing,
                mean: sum / (forces[0].len() + forces[1].len()) as f64,
                largest: [0, 1].map(|way| {
                    let all = forces[way].iter().copied().enumerate();
                    let (k, force) = all.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
                    [force, ways[way].speed[k] / RPM]
                }),
            }
        });
        found.collect()
    }

    pub fn listing(&self) -> Listing {
        let (run, sweep) = (self.run, self.sweep);
        let [j1, j2] = sweep.inertia.map(|inertia| significant(inertia, 4));
        let [low, high] = sweep.speeds.map(|speed| fixed(speed / RPM, 0));
        let mut rows = Listing::default();
        rows! { rows;
            "moments of inertia" => "{j1} and {j2} kg m2";
            "mean torque on gear 1" => "{} N m", rounded(sweep.torque);
            "damping ratio" => "{}, {} N s/m along the pitch circle", sweep.damping_ratio, significant(run.damping, 4);
            "speeds of gear 1" => "{low} to {high} rpm, {} s each way", significant(run.duration, 4);
            "natural frequency on the mean stiffness" => "{:.1} Hz", run.natural_frequency;
            "mesh frequency meets it at" => "{:.0} rpm", run.resonance_speed / RPM;
        }
        for (name, history) in self.ways() {
            let (speed, swing) = self.largest_swing(history);
            rows.row(
                format!("{name}: transmission error, half of peak to peak"),
                format!("at most {swing:.2} um, at {speed:.0} rpm"),
            );
            let parted = self.parted(history);
            rows.row(
                format!("{name}: teeth part"),
                parted.map_or("nowhere".into(), |[low, high]| {
                    format!("between {low:.0} and {high:.0} rpm")
                }),
            );
            if let Some(([low, high], share)) = self.out_of_range(history) {
                rows.row(
                    format!("{name}: outside the range of the tables"),
                    format!(
                        "{:.1} % of the time, between {low:.0} and {high:.0} rpm",
                        100.0 * share
                    ),
                );
            }
        }
        let ways = self.ways();
        if ways
            .iter()
            .any(|(_, history)| self.out_of_range(history).is_some())
        {
            rows.row(
                "loads outside the tables are extrapolated",
                "build tables for larger loads (maximum_torque_nm)",
            );
        }
        for forces in self.bearings() {
            let [up, down] = forces.largest;
            rows.row(
                format!("radial force, {}", forces.name()),
                format!(
                    "at most {:.0} N at {:.0} rpm up, {:.0} N at {:.0} rpm down; mean {:.0} N",
                    up[0], up[1], down[0], down[1], forces.mean
                ),
            );
        }
        rows
    }

    pub fn json(&self) -> Value {
        let (run, sweep) = (self.run, self.sweep);
        let [up, down] = self.ways().map(|(_, history)| {
            let (speed, swing) = self.largest_swing(history);
            let out = self.out_of_range(history);
            json!({
                "largest_swing_um": swing, "largest_swing_rpm": speed, "parted_rpm": self.parted(history),
                "out_of_range_share": out.map_or(0.0, |out| out.1), "out_of_range_rpm": out.map(|out| out.0),
            })
        });
        json!({
            "inertia_kg_m2": sweep.inertia.map(|j| j.is_finite().then_some(j)), "torque_nm": sweep.torque,
            "damping_ratio": sweep.damping_ratio, "damping_n_s_per_m": run.damping, "step_s": run.step, "sweep_s": run.duration,
            "natural_frequency_hz": run.natural_frequency, "resonance_rpm": run.resonance_speed / RPM,
            "up": up, "down": down,
            "bearings": self.bearings().iter().map(BearingForces::json).collect::<Vec<_>>(),
        })
    }

    pub fn sections(&self, teeth: u32) -> Vec<Section> {
        let ways = self.ways();
        let mut swings = Vec::new();
        for (name, history) in ways {
            let swing = history.swing(&history.transmission_error, self.window);
            let swing = swing
                .into_iter()
                .map(|(speed, swing)| (speed / RPM, 1e6 * swing));
            let swing: Vec<(f64, f64)> = swing.collect();
            let windows = history.windows(self.window);
            let outside = swing
                .iter()
                .zip(windows)
                .map(|((speed, swing), (_, rows))| {
                    let is_outside = history.out_of_range[rows].contains(&true);
                    (*speed, if is_outside { *swing } else { f64::NAN })
                });
            let outside = Curve {
                style: Style::Dots,
                ..Curve::new(format!("{name}, outside the tables"), outside)
            };
            swings.push(Curve::new(name, swing));
            swings.extend((!outside.points.is_empty()).then_some(outside));
        }
        let nominal = self.sweep.torque.abs();
        let largest = ways.map(|(name, history)| {
            let force = &history.tangential_force;
            let mean = force.iter().sum::<f64>() / force.len().max(1) as f64;
            let ratios = self.largest(history, force).into_iter();
            Curve::new(name, ratios.map(|(rpm, force)| (rpm, force / mean)))
        });
        let mut sections = vec![
            Section::new(
                "Overview",
                format!(
                    "Both discs turn freely about fixed axes under {} N m on gear 1. Where teeth part, run-up and run-down differ. \
                     Transmission error: on the operating pitch circle, half of the peak-to-peak in windows of {:.1} ms. Dynamic factor: \
                     largest tangential force in a window over the mean one.",
                    rounded(nominal),
                    1e3 * self.window
                ),
                charts! {
                    "Transmission error in run-up and run-down", [SPEED, "half of peak to peak (um)"], Height::FromZero(1e-3)
                        => swings;
                    "Dynamic factor", [SPEED, "largest over mean force"], Height::FromZero(0.0) => largest.into();
                },
            )
            .with_text(self.listing().to_string()),
        ];
        if !self.bearings().is_empty() {
            sections.push(self.bearing_section());
        }
        for (name, history) in ways {
            let figures = vec![
                orders(name, history, teeth),
                self.campbell(name, history, teeth),
            ];
            let heading = match name {
                "run-up" => "Orders and spectra in the run-up",
                _ => "Orders and spectra in the run-down",
            };
            let note = "Angular acceleration of gear 2 (of gear 1 where gear 2 turns as imposed). Orders: amplitudes at multiples of the mesh \
                        frequency, in windows of one turn of gear 1. Spectra: orders are straight lines through the origin, resonances of \
                        the mesh lie where they are bright.";
            sections.push(Section::new(heading, note, figures));
        }
        sections
    }

    /// The largest of `values` in each window, 0 at least, with the speed, rpm.
    fn largest(&self, history: &History, values: &[f64]) -> Vec<(f64, f64)> {
        let windows = history.windows(self.window).into_iter();
        windows
            .map(|(speed, rows)| {
                let largest = values[rows].iter().copied().fold(0.0, f64::max);
                (speed / RPM, largest)
            })
            .collect()
    }

    /// Radial forces of the bearings over the speed.
    fn bearing_section(&self) -> Section {
        let mut figures = Vec::new();
        for gear in 0..2 {
            let mut curves = Vec::new();
            for (name, history) in self.ways() {
                for (bearing, force) in history.bearing_force[gear].iter().enumerate() {
                    let label = format!("bearing {}, {name}", bearing + 1);
                    curves.push(Curve::new(label, self.largest(history, force)));
                }
            }
            if !curves.is_empty() {
                figures.extend(charts! {
                    format!("Bearings of gear {}", gear + 1), [SPEED, "largest radial force (N)"], Height::FromZero(0.0) => curves;
                });
            }
        }
        let note = "Largest radial force in a window. At each time the bearings of the pair file hold the force and moment that the mesh exerts on its gear, without clearances; what gears and shafts weigh, and their inertia across the axes, are left out.";
        Section::new("Bearing forces", note, figures)
    }

    /// Levels of the acceleration over speed and frequency.
    fn campbell(&self, name: &str, history: &History, teeth: u32) -> Figure {
        let (gear, signal) = moving(history);
        let highest = self.sweep.speeds[1] / TAU * f64::from(teeth) * (HARMONICS as f64 + 0.5);
        let frequencies: Vec<f64> = (1..=FREQUENCIES)
            .map(|k| highest * k as f64 / FREQUENCIES as f64)
            .collect();
        let window = (4.0 * FREQUENCIES as f64 / highest).max(2.0 * self.run.duration / WINDOWS);
        let mut spectra =
            history.spectra(signal, &frequencies, window.min(0.5 * self.run.duration));
        spectra.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all = spectra.iter().flat_map(|(_, row)| row);
        let least = level(all.copied().fold(0.0, f64::max)) - DEPTH;
        let speeds: Vec<f64> = spectra.iter().map(|(speed, _)| speed / RPM).collect();
        let khz: Vec<f64> = frequencies.iter().map(|f| 1e-3 * f).collect();
        let values = (0..FREQUENCIES).flat_map(|k| {
            spectra
                .iter()
                .map(move |row| (level(row.1[k]) - least).max(0.0))
                .collect::<Vec<_>>()
        });
        let map = Map::on_nodes([&speeds, &khz], values, DEPTH);
        let label = format!("gear {gear}, dB re {:.2e} rad/s2", 10f64.powf(least / 20.0));
        charts! { format!("Spectra in the {name}"), [SPEED, "frequency (kHz)", &label] => map; }
            .remove(0)
    }
}

/// An amplitude in dB re 1.
fn level(amplitude: f64) -> f64 {
    20.0 * amplitude.max(f64::MIN_POSITIVE).log10()
}

/// Lowest and highest speed, rpm, of the samples of `history` for which `holds`; None: it holds nowhere.
fn speeds_between(history: &History, holds: impl Fn(usize) -> bool) -> Option<[f64; 2]> {
    let samples = history.speed.iter().enumerate();
    samples
        .filter(|(k, _)| holds(*k))
        .map(|(_, speed)| [speed / RPM; 2])
        .reduce(|[low, high], [speed, _]| [low.min(speed), high.max(speed)])
}

/// Number and acceleration of gear 2, or of gear 1 where gear 2 turns as imposed.
fn moving(history: &History) -> (usize, &[f64]) {
    let [one, two] = &history.acceleration;
    if two.iter().all(|acceleration| *acceleration == 0.0) {
        (1, one)
    } else {
        (2, two)
    }
}

fn orders(name: &str, history: &History, teeth: u32) -> Figure {
    let (gear, signal) = moving(history);
    let curves = (1..=HARMONICS)
        .map(|k| {
            let order = f64::from(teeth) * k as f64;
            let found = history.order(signal, order, 1.0).into_iter();
            Curve::new(
                format!("order {order}"),
                found.map(|(speed, amplitude)| (speed / RPM, 20.0 * amplitude.log10())),
            )
        })
        .collect();
    let label = format!("acceleration of gear {gear} (dB re 1 rad/s2)");
    charts! { format!("Orders in the {name}"), [SPEED, &label], Height::Curves(1.0) => curves; }
        .remove(0)
}
