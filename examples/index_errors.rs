//! Orders of the transmission error of a pair whose teeth differ, by contact at run time: `cargo run --release --example
//! index_errors`. Prints the tables of docs/contact-at-run-time.md and draws docs/img/index-errors.svg. Elastic models are
//! kept in target/finite-elements.

#[path = "common/runtime_contact.rs"]
mod runtime_contact;
#[path = "common/teeth.rs"]
mod teeth;

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

use gearmesh::contact::{RuntimeContact, Warm};
use gearmesh::gear::tolerance::{random_index_errors, total_pitch};
use gearmesh::gear::{Flank, Runout, ToothErrors, WeakTooth};
use gearmesh::table::{Query, TeethFlank};
use plotters::prelude::*;

const PAIR: &str = "palermo2013";
/// Flank tolerance class of ISO 1328-1 and seed of the index errors of gear 1.
const CLASS: u8 = 6;
const SEED: u32 = 1;
/// Mesh positions of a cycle.
const STEPS: usize = 32;

/// Static transmission error (m) under the force `force` (N) over a turn of gear 1, `teeth` mesh cycles. `loads` gives force and
/// stiffness (N, N/m) at the approach (m), the mesh position and the mesh cycle.
fn transmission_error(
    mut loads: impl FnMut(f64, f64, i64) -> Result<[f64; 2], Box<dyn Error>>,
    force: f64,
    teeth: usize,
) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut approach = 1e-5;
    let mut all = Vec::with_capacity(teeth * STEPS);
    for i in 0..teeth * STEPS {
        let (cycle, tau) = ((i / STEPS) as i64, (i % STEPS) as f64 / STEPS as f64);
        let mut missing = f64::INFINITY;
        for _ in 0..50 {
            let [found, stiffness] = loads(approach, tau, cycle)?;
            missing = force - found;
            if missing.abs() <= 1e-9 * force {
                break;
            }
            approach += if found > 0.0 {
                missing / stiffness
            } else {
                5e-6
            };
        }
        if missing.abs() > 1e-9 * force {
            return Err(format!("no approach for {force} N at {tau} of cycle {cycle}").into());
        }
        all.push(approach);
    }
    Ok(all)
}

/// That of contact at run time.
fn by_contact(
    contact: &RuntimeContact,
    force: f64,
    teeth: usize,
) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut warm = Warm::default();
    let loads = |approach, tau, cycle| {
        let found = contact.potential([approach, 0.0, 0.0, tau], [cycle; 2], &mut warm)?;
        Ok([found.gradient[0], found.tangent.force_by_approach])
    };
    transmission_error(loads, force, teeth)
}

/// That of the level `teeth`.
fn by_teeth(level: &TeethFlank, force: f64, teeth: usize) -> Result<Vec<f64>, Box<dyn Error>> {
    let loads = |delta, mesh_position, cycle| {
        let query = Query {
            delta,
            center_distance_offset: 0.0,
            misalignment: 0.0,
            mesh_position,
        };
        let found = level.evaluate(&query, [cycle; 2], true);
        Ok([found.gradient[0], found.hessian[0][0]])
    };
    transmission_error(loads, force, teeth)
}

/// Amplitude of each shaft order, m, up to `orders`.
fn spectrum(signal: &[f64], orders: usize) -> Vec<f64> {
    let n = signal.len();
    let amplitude = |order: usize| {
        let part = |f: fn(f64) -> f64| -> f64 {
            let terms = signal.iter().enumerate();
            terms
                .map(|(i, x)| x * f(TAU * ((order * i) % n) as f64 / n as f64))
                .sum()
        };
        2.0 / n as f64 * part(f64::cos).hypot(part(f64::sin))
    };
    (0..=orders).map(amplitude).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let (pair, solver, file) = runtime_contact::ready(PAIR)?;
    let gear = &pair.geometry.gears[0];
    let (z, torque) = (gear.teeth as usize, pair.operating.nominal_torque);
    let force = torque / gear.base_radius();

    let errors = random_index_errors(gear, CLASS, SEED);
    let index = ToothErrors {
        index: errors.clone(),
        ..ToothErrors::default()
    };
    // F_r is about nine tenths of F_p in one class.
    let runout = ToothErrors {
        runout: Some(Runout {
            amount: 0.9 * total_pitch(gear, CLASS),
            angle: 0.0,
        }),
        ..ToothErrors::default()
    };
    let weak = ToothErrors {
        weak: vec![WeakTooth {
            tooth: 0,
            factor: 2.0,
        }],
        ..ToothErrors::default()
    };
    let cases = [
        ("alike", ToothErrors::default()),
        ("index errors", index),
        ("run-out", runout),
        ("weak tooth", weak),
    ];
    let orders = 3 * z + 4;
    let mut spectra = vec![];
    for (name, first) in cases {
        let with = teeth::with_errors(&file, first);
        let contact = with.flank(Flank::Drive).ok_or("no drive flank")?;
        let signal = by_contact(&contact, force, z)?;
        spectra.push((name, spectrum(&signal, orders)));
    }

    let (record, _) = teeth::record(&pair, &solver, &file, errors.clone())?;
    let level = teeth::level(&record, &pair)?;
    let of_level = spectrum(&by_teeth(&level, force, z)?, orders);

    // To first order a tooth that stands out by E takes its share of the load off the transmission error: the errors' own
    // orders, which repeat every z, times those of the share over the way of a tooth pair.
    let mut share = vec![];
    for i in 0..STEPS {
        let tau = i as f64 / STEPS as f64;
        let result = solver
            .position(Flank::Drive, tau, 0.0)?
            .solve_torque(torque, 0.0, None)?;
        let parts = result.load_share.iter();
        share.extend(parts.map(|(k, part)| (tau + f64::from(*k), *part)));
    }
    let expected = |order: usize| {
        let complex = |f: fn(f64) -> f64, terms: &mut dyn Iterator<Item = (f64, f64)>| -> f64 {
            terms.map(|(x, y)| y * f(TAU * x * order as f64)).sum()
        };
        let amplitude = |terms: Vec<(f64, f64)>| {
            complex(f64::cos, &mut terms.iter().copied())
                .hypot(complex(f64::sin, &mut terms.into_iter()))
        };
        let of_errors = errors.iter().enumerate();
        let of_errors = amplitude(of_errors.map(|(j, e)| (j as f64 / z as f64, *e)).collect());
        let of_share = share.iter().map(|(x, part)| (x / z as f64, *part));
        2.0 / (z * STEPS) as f64 * of_errors * amplitude(of_share.collect())
    };

    println!(
        "Pair {PAIR}, {torque} N m; gear 1 of class {CLASS} (seed {SEED}), or with run-out, or tooth 0 twice as compliant.\n"
    );
    println!("Amplitudes, um, by shaft order of gear 1:\n");
    let names: Vec<&str> = spectra.iter().map(|(name, _)| *name).collect();
    println!(
        "| order | {} | index errors by `teeth` | index errors by load share |",
        names.join(" | ")
    );
    println!("|---|{}---|---|", "---|".repeat(names.len()));
    let shown = [
        1,
        2,
        3,
        z - 2,
        z - 1,
        z,
        z + 1,
        z + 2,
        2 * z - 1,
        2 * z,
        2 * z + 1,
        3 * z,
    ];
    for order in shown {
        let row: Vec<String> = (spectra.iter())
            .map(|(_, amplitudes)| format!("{:.3}", 1e6 * amplitudes[order]))
            .collect();
        let mesh = order % z == 0;
        let by_share = if mesh {
            String::new()
        } else {
            format!("{:.3}", 1e6 * expected(order))
        };
        let of_level = 1e6 * of_level[order];
        println!(
            "| {order} | {} | {of_level:.3} | {by_share} |",
            row.join(" | ")
        );
    }
    draw(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/img/index-errors.svg"),
        &spectra[..2],
        z,
    )
}

/// Both spectra, order by order.
fn draw(path: &Path, spectra: &[(&str, Vec<f64>)], z: usize) -> Result<(), Box<dyn Error>> {
    let area = SVGBackend::new(path, (760, 380)).into_drawing_area();
    area.fill(&WHITE)?;
    let last = spectra[0].1.len() as f64;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "Static transmission error over a turn of gear 1",
            ("sans-serif", 18),
        )
        .margin(10)
        .x_label_area_size(45)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..last, -3.5..2.3)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_desc(format!("shaft order ({z}: one mesh cycle)"))
        .y_desc("amplitude, um")
        .y_label_formatter(&|exponent: &f64| format!("{:.3}", 10f64.powf(*exponent)))
        .draw()?;
    let colors = [RGBColor(90, 90, 90), RGBColor(200, 60, 40)];
    for (k, ((name, amplitudes), color)) in spectra.iter().zip(colors).enumerate() {
        let aside = 0.35 * (k as f64 - 0.5);
        let bars = amplitudes.iter().enumerate().skip(1).map(|(order, m)| {
            let x = order as f64 + aside;
            let y = (1e6 * m).max(1e-9).log10().max(-3.5);
            PathElement::new(vec![(x, -3.5), (x, y)], color.stroke_width(2))
        });
        chart
            .draw_series(bars)?
            .label(*name)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], color));
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .draw()?;
    area.present()?;
    Ok(())
}
