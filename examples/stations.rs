//! How exact static contact is on so many stations along the face: `cargo run --release --example stations`. Coarse elements, random
//! poses in the ranges of the shipped pairs, at the approach that 160 stations find for the torque, against these.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use gearmesh::compliance::ToothCompliance;
use gearmesh::compliance::finite_element::{ModelCache, PairCompliance, Settings};
use gearmesh::contact::{ContactResult, ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::random::Random;

const PAIRS: [&str; 4] = ["palermo2013", "fzg-c", "helical-25-47", "planet-ring-27-84"];
/// Stations, and the share of a strip's own contact in what changes along it.
const CASES: [(usize, f64); 5] = [(20, 1.0), (40, 1.0), (20, 0.45), (22, 0.45), (40, 0.45)];
const MOST: usize = 160;
const POSES: usize = 400;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| pair | stations | own share | force rms, % | largest, % | moment rms, % | stiffness rms, % |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for name in PAIRS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let pair = Pair {
            refinement: Refinement::Coarse,
            ..Pair::read(folder.join(format!("resources/pairs/{name}.json")))?
        };
        let kept = folder.join("target/finite-elements");
        let cache = ModelCache::new(kept, ModelCache::DEFAULT_LIMIT);
        let settings = Settings::for_pair(&pair);
        let models = PairCompliance::new(&pair.geometry, &settings, Some(&cache), &|_, _, _| true)?;
        let gears: [Arc<dyn ToothCompliance>; 2] = models.gears.map(|gear| gear as _);
        let solver = |stations: usize, own_share: f64| {
            let settings = ContactSettings {
                stations,
                own_share,
                ..ContactSettings::for_pair(&pair)
            };
            ContactSolver::new(&pair, gears.clone(), settings)
        };
        let most = solver(MOST, 0.45)?;
        let coarser = CASES.map(|(stations, own_share)| solver(stations, own_share));
        let coarser = coarser.into_iter().collect::<Result<Vec<_>, _>>()?;
        // Sums of squares and the largest.
        let mut sums = [[0.0f64; 4]; CASES.len()];
        let operating = &pair.operating;
        let nominal = operating.nominal_torque / pair.geometry.gears[0].base_radius();
        let half_face = 0.5 * pair.geometry.face_overlap().1;
        let mut random = Random::new(1);
        for _ in 0..POSES {
            let offset = random.within(operating.center_distance_offset);
            let misalignment = random.within(operating.misalignment);
            let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
            let tau = random.within([0.0, 1.0]);
            let exact = most.position(Flank::Drive, tau, offset)?.solve_torque(
                torque,
                misalignment,
                None,
            )?;
            for (solver, sums) in coarser.iter().zip(&mut sums) {
                let found = solver.position(Flank::Drive, tau, offset)?.solve_approach(
                    exact.approach,
                    misalignment,
                    None,
                )?;
                let by = |of: fn(&ContactResult) -> f64| of(&found) - of(&exact);
                let force = by(|r| r.loa_force) / nominal;
                let moment = by(|r| r.moment) / (nominal * half_face);
                let stiffness = by(|r| r.tangent.force_by_approach);
                let stiffness = stiffness / exact.tangent.force_by_approach;
                sums[0] += force * force;
                sums[1] = sums[1].max(force.abs());
                sums[2] += moment * moment;
                sums[3] += stiffness * stiffness;
            }
        }
        for ((stations, own_share), sums) in CASES.iter().zip(sums) {
            let rms = |sum: f64| 100.0 * (sum / POSES as f64).sqrt();
            println!(
                "| {name} | {stations} | {own_share} | {:.3} | {:.2} | {:.3} | {:.2} |",
                rms(sums[0]),
                100.0 * sums[1],
                rms(sums[2]),
                rms(sums[3])
            );
        }
    }
    Ok(())
}
