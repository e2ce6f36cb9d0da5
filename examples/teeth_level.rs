//! How near `stiffnessModel = teeth` comes to contact at run time, and what it costs: `cargo run --release --example teeth_level`.
//! Prints the tables of "Tooth pair by tooth pair" in docs/contact-at-run-time.md. Elastic models are kept in
//! target/finite-elements.

#[path = "common/runtime_contact.rs"]
mod runtime_contact;
#[path = "common/teeth.rs"]
mod teeth;

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use gearmesh::contact::Warm;
use gearmesh::gear::Flank;
use gearmesh::gear::tolerance::random_index_errors;
use gearmesh::random::Random;
use gearmesh::table::plan::default_axes;
use gearmesh::table::sweep::sweep;
use gearmesh::table::{CouplingRecord, FlankTable, Interpolation, Query, TeethFlank, TeethRecord};
use teeth::{coverage, level, quiet, record};

type Failure = Box<dyn Error>;

const PAIR: &str = "palermo2013";
/// Flank tolerance class of ISO 1328-1 and seed of the index errors of gear 1.
const CLASS: u8 = 6;
const SEED: u32 = 1;
/// Random poses over a turn.
const POSES: usize = 200;
/// Rounds that are timed.
const ROUNDS: usize = 200;

fn main() -> Result<(), Failure> {
    let (pair, solver, file) = runtime_contact::ready(PAIR)?;
    let gear = &pair.geometry.gears[0];
    let teeth = gear.teeth as usize;
    let nominal = pair.operating.nominal_torque / gear.base_radius();
    let half_face = 0.5 * pair.geometry.face_overlap().1;
    let delta = solver
        .position(Flank::Drive, 0.0, 0.0)?
        .solve_torque(pair.operating.nominal_torque, 0.0, None)?
        .approach;
    let mut levels = vec![];
    for (name, index) in [
        ("alike", vec![0.0; teeth]),
        ("class 6", random_index_errors(gear, CLASS, SEED)),
    ] {
        let begin = Instant::now();
        let (record, contact) = record(&pair, &solver, &file, index)?;
        println!(
            "{name}: {} ({:.0} s)",
            record.in_words(),
            begin.elapsed().as_secs_f64()
        );
        levels.push((name, record, contact));
    }

    println!(
        "\n| teeth | misalignment, mrad | approach, um | load | force without coupling | force | moment |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, record, contact) in &levels {
        let contact = contact.flank(Flank::Drive).ok_or("no drive flank")?;
        let without = TeethRecord {
            coupling_m_per_n: CouplingRecord::Same(0.0),
            ..record.clone()
        };
        let without = level(&without, &pair)?;
        let whole = level(record, &pair)?;
        for (misalignment, share) in [0.0, 5e-4, 2e-3]
            .into_iter()
            .flat_map(|m| [0.7, 1.0, 1.3].map(|s| (m, s)))
        {
            let mut random = Random::new(1);
            let (mut squares, mut load) = ([0.0; 3], 0.0);
            for _ in 0..POSES {
                let query = Query {
                    delta: share * delta,
                    center_distance_offset: 0.0,
                    misalignment,
                    mesh_position: random.within([0.0, teeth as f64]),
                };
                let at = [query.delta, 0.0, misalignment, query.mesh_position];
                let exact = contact
                    .potential(at, [0; 2], &mut Warm::default())?
                    .gradient;
                load += exact[0] / nominal / POSES as f64;
                let of = |level: &TeethFlank| level.evaluate(&query, [0; 2], false).gradient;
                let found = of(&whole);
                let errors = [
                    (of(&without)[0] - exact[0]) / nominal,
                    (found[0] - exact[0]) / nominal,
                    (found[2] - exact[2]) / (nominal * half_face),
                ];
                for (square, error) in squares.iter_mut().zip(errors) {
                    *square += error * error;
                }
            }
            let [without, force, moment] =
                squares.map(|square| format!("{:.2}", 100.0 * (square / POSES as f64).sqrt()));
            println!(
                "| {name} | {:.1} | {:.2} | {load:.2} | {without} | {force} | {moment} |",
                1e3 * misalignment,
                1e6 * share * delta
            );
        }
    }

    let axes = default_axes(&coverage(&pair));
    let torque = pair.operating.maximum_torque;
    let grid = sweep(&solver, Flank::Drive, &axes, torque, &quiet())?;
    let table = FlankTable::new(&grid, Interpolation::Spline)?;
    let class_6 = level(&levels[1].1, &pair)?;
    let mut random = Random::new(2);
    let queries: Vec<Query> = (0..1000)
        .map(|_| Query {
            delta: delta * random.within([0.5, 1.5]),
            center_distance_offset: random.within([-5e-5, 5e-5]),
            misalignment: random.within([-5e-4, 5e-4]),
            mesh_position: random.within([0.0, teeth as f64]),
        })
        .collect();
    // The fastest round counts: others were interrupted.
    let timed = |of: &dyn Fn(&Query) -> f64| {
        let round = || {
            let begin = Instant::now();
            for query in &queries {
                black_box(of(black_box(query)));
            }
            1e9 * begin.elapsed().as_secs_f64() / queries.len() as f64
        };
        (0..ROUNDS).map(|_| round()).fold(f64::INFINITY, f64::min)
    };
    println!("\n| evaluation, ns | loads | with second derivatives |\n|---|---|---|");
    for (name, of) in [
        (
            "4-D table",
            &(|q: &Query, h| table.evaluate(q, h).gradient[0]) as &dyn Fn(&Query, bool) -> f64,
        ),
        (
            "tooth pair by tooth pair",
            &(|q: &Query, h| class_6.evaluate(q, [0; 2], h).gradient[0]),
        ),
    ] {
        println!(
            "| {name} | {:.0} | {:.0} |",
            timed(&|q| of(q, false)),
            timed(&|q| of(q, true))
        );
    }
    Ok(())
}
