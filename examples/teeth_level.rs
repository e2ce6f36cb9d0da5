//! How near tooth pairs that are coupled by one number come to contact at run time: `cargo run --release --example
//! teeth_level`. Prints the table of "Tooth pair by tooth pair" in docs/contact-at-run-time.md. Elastic models are kept in
//! target/finite-elements.
//!
//! Pair k carries F_k = f(delta + e_k - sum of c F_j over the pairs beside it, place k), f the force of one tooth pair alone at its
//! place along the path, all others lifted off: what a table per tooth pair would hold, here without its interpolation. The
//! coupling c is what gives the force of two pairs under the nominal load.

#[path = "common/runtime_contact.rs"]
mod runtime_contact;

use std::error::Error;
use std::sync::Arc;

use gearmesh::contact::{ContactFile, ContactSetup, RuntimeContact, Warm};
use gearmesh::gear::tolerance::random_index_errors;
use gearmesh::gear::{Flank, PairTeeth, ToothErrors};
use gearmesh::random::Random;

type Failure = Box<dyn Error>;

const PAIR: &str = "palermo2013";
/// Flank tolerance class of ISO 1328-1 and seed of the index errors of gear 1.
const CLASS: u8 = 6;
const SEED: u32 = 1;
/// Random poses over a turn.
const POSES: usize = 200;
/// Index error that keeps a tooth out of any contact, m.
const LIFTED: f64 = -1e-3;
/// Relative error at which forces of the model are found.
const TOLERANCE: f64 = 1e-6;

/// The pair with the index errors `index` on gear 1.
fn with_errors(file: &ContactFile, index: Vec<f64>) -> Result<RuntimeContact, Failure> {
    let first = ToothErrors {
        index,
        ..ToothErrors::default()
    };
    let teeth = PairTeeth {
        drive: [first, ToothErrors::default()],
        ..PairTeeth::default()
    };
    let with = ContactFile {
        setup: Arc::new(ContactSetup {
            teeth,
            ..(*file.setup).clone()
        }),
        ..file.clone()
    };
    Ok(with.flank(Flank::Drive).ok_or("no drive flank")?)
}

/// Numbers of tooth pairs that may touch.
const NEAR: std::ops::RangeInclusive<i64> = -3..=3;
/// Places at which couplings are told, and the least part of the force of two pairs that the lesser one carries there.
const PLACES: usize = 32;
const LEAST_SHARE: f64 = 0.05;

/// Force and shuttling moment.
type Load = [f64; 2];

/// Tooth pairs and what couples them.
struct Model {
    /// All teeth but number 0 lifted off.
    alone: RuntimeContact,
    /// Compliance of the coupling of neighbours, m/N.
    coupling: f64,
}

fn load(
    contact: &RuntimeContact,
    [delta, misalignment]: [f64; 2],
    place: f64,
) -> Result<Load, Failure> {
    let cycle = place.floor();
    let at = [delta, 0.0, misalignment, place - cycle];
    let found = contact.potential(at, [cycle as i64; 2], &mut Warm::default())?;
    Ok([found.gradient[0], found.gradient[2]])
}

impl Model {
    /// Of teeth that are alike, at the approach `delta`, with the couplings found: least and largest.
    fn new(file: &ContactFile, teeth: usize, delta: f64) -> Result<(Model, [f64; 2]), Failure> {
        let but = |kept: &[usize]| {
            let mut index = vec![LIFTED; teeth];
            kept.iter().for_each(|&tooth| index[tooth] = 0.0);
            with_errors(file, index)
        };
        let two = but(&[0, 1])?;
        let mut model = Model {
            alone: but(&[0])?,
            coupling: 0.0,
        };
        let mut found = vec![];
        for place in 0..PLACES {
            let place = -1.0 + place as f64 / PLACES as f64;
            let [wanted, _] = load(&two, [delta, 0.0], place)?;
            let places = [place, place + 1.0];
            let both = |coupling: f64| model.solve(&[delta; 2], 0.0, &places, coupling);
            let [first, second] = both(0.0)?[..] else {
                return Err("two tooth pairs".into());
            };
            if first[0].min(second[0]) < LEAST_SHARE * (first[0] + second[0]) {
                continue;
            }
            let (mut low, mut high) = (0.0, 1e-8);
            for _ in 0..30 {
                let middle = 0.5 * (low + high);
                if both(middle)?.iter().map(|load| load[0]).sum::<f64>() > wanted {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            found.push(0.5 * (low + high));
        }
        if found.is_empty() {
            return Err("no place where two tooth pairs carry".into());
        }
        model.coupling = found.iter().sum::<f64>() / found.len() as f64;
        let least = found.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = found.iter().copied().fold(0.0, f64::max);
        Ok((model, [least, largest]))
    }

    /// Loads of tooth pairs, neighbours in this order, that close by `closing` at `places`.
    fn solve(
        &self,
        closing: &[f64],
        misalignment: f64,
        places: &[f64],
        coupling: f64,
    ) -> Result<Vec<Load>, Failure> {
        let mut loads = vec![[0.0; 2]; closing.len()];
        for _ in 0..200 {
            let mut change = 0.0f64;
            for i in 0..closing.len() {
                let beside = [i.checked_sub(1), Some(i + 1)];
                let beside = beside.into_iter().flatten().filter_map(|j| loads.get(j));
                let given = coupling * beside.map(|load: &Load| load[0]).sum::<f64>();
                let found = load(&self.alone, [closing[i] - given, misalignment], places[i])?;
                change = change.max((found[0] - loads[i][0]).abs());
                loads[i] = found;
            }
            if change <= TOLERANCE * loads.iter().map(|load| load[0]).sum::<f64>() {
                return Ok(loads);
            }
        }
        Err("coupled tooth pairs do not settle".into())
    }
}

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
    let (model, [least, largest]) = Model::new(&file, teeth, delta)?;
    println!(
        "Coupling of neighbours: {:.3e} m/N, between {least:.3e} and {largest:.3e} over the path; approach under the nominal load {:.2} um",
        model.coupling,
        1e6 * delta
    );

    println!(
        "| teeth | misalignment, mrad | approach, um | force without coupling | force | moment |"
    );
    println!("|---|---|---|---|---|---|");
    for (name, class) in [("alike", None), ("class 6", Some(CLASS))] {
        let errors = class.map_or(vec![0.0; teeth], |class| {
            random_index_errors(gear, class, SEED)
        });
        let contact = with_errors(&file, errors.clone())?;
        for (misalignment, share) in [0.0, 5e-4]
            .into_iter()
            .flat_map(|m| [0.7, 1.0, 1.3].map(|s| (m, s)))
        {
            let mut random = Random::new(1);
            let mut squares = [0.0; 3];
            for _ in 0..POSES {
                let place = random.within([0.0, teeth as f64]);
                let (cycle, tau) = (place.floor(), place.fract());
                let [force, moment] = load(&contact, [share * delta, misalignment], place)?;
                let places: Vec<f64> = NEAR.map(|k| tau + k as f64).collect();
                let closing: Vec<f64> = NEAR
                    .map(|k| {
                        let tooth = (k - cycle as i64).rem_euclid(teeth as i64);
                        share * delta + errors[tooth as usize]
                    })
                    .collect();
                let sums = |coupling: f64| -> Result<Load, Failure> {
                    let loads = model.solve(&closing, misalignment, &places, coupling)?;
                    Ok([0, 1].map(|i| loads.iter().map(|load| load[i]).sum()))
                };
                let [alone, _] = sums(0.0)?;
                let [by_force, by_moment] = sums(model.coupling)?;
                let errors = [
                    (alone - force) / nominal,
                    (by_force - force) / nominal,
                    (by_moment - moment) / (nominal * half_face),
                ];
                for (square, error) in squares.iter_mut().zip(errors) {
                    *square += error * error;
                }
            }
            let [alone, force, moment] =
                squares.map(|square| format!("{:.2}", 100.0 * (square / POSES as f64).sqrt()));
            println!(
                "| {name} | {:.1} | {:.2} | {alone} | {force} | {moment} |",
                1e3 * misalignment,
                1e6 * share * delta
            );
        }
    }
    Ok(())
}
