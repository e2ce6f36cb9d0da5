//! What contact at run time costs, and how far it is from the full solve on that solve's stations: `cargo run --release --example
//! contact_at_run_time`. Elastic models are kept in target/finite-elements.

#[path = "common/runtime_contact.rs"]
mod runtime_contact;

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use gearmesh::contact::Warm;
use gearmesh::gear::Flank;
use gearmesh::random::Random;

const PAIRS: [&str; 4] = ["palermo2013", "fzg-c", "helical-25-47", "planet-ring-27-84"];

/// Random points of the range, and steps of a path along the mesh cycle.
const POINTS: usize = 200;
const STEPS: usize = 2000;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| pair | stations | condensed, MB | force error rms, % | largest, % | cold, us | warm, us |"
    );
    println!("|---|---|---|---|---|---|---|");
    for name in PAIRS {
        let (pair, solver, file) = runtime_contact::ready(name)?;
        let file = Arc::new(file);
        let contact = file.flank(Flank::Drive).ok_or("no drive flank")?;

        let mut random = Random::new(1);
        let (mut square, mut largest, mut cold) = (0.0, 0.0f64, 0.0);
        for _ in 0..POINTS {
            let o = &pair.operating;
            let offset = random.within(o.center_distance_offset);
            let misalignment = random.within(o.misalignment);
            let torque = random.within([0.1, 1.0]) * o.maximum_torque;
            let tau = random.within([0.0, 1.0]);
            let problem = solver.position(Flank::Drive, tau, offset)?;
            let full = problem.solve_torque(torque, misalignment, None)?;
            let begin = Instant::now();
            let at = [full.approach, offset, misalignment, tau];
            let found = contact.potential(at, [0; 2], &mut Warm::default())?;
            cold += begin.elapsed().as_secs_f64();
            let nominal = o.nominal_torque / pair.geometry.gears[0].base_radius();
            let error = (found.gradient[0] - full.loa_force) / nominal;
            square += error * error;
            largest = largest.max(error.abs());
        }

        // A step of a simulation turns the gears by a thousandth of a mesh cycle.
        let torque = pair.operating.nominal_torque;
        let mean = solver
            .position(Flank::Drive, 0.0, 0.0)?
            .solve_torque(torque, 0.0, None)?;
        let mut warm = Warm::default();
        let begin = Instant::now();
        for i in 0..STEPS {
            contact.potential(
                [mean.approach, 0.0, 0.0, i as f64 * 1e-3],
                [0; 2],
                &mut warm,
            )?;
        }
        let each = begin.elapsed().as_secs_f64() / STEPS as f64;
        println!(
            "| {name} | {} | {:.1} | {:.3} | {:.2} | {:.0} | {:.0} |",
            file.setup.settings.stations,
            file.to_bytes().len() as f64 / 1e6,
            100.0 * (square / POINTS as f64).sqrt(),
            100.0 * largest,
            1e6 * cold / POINTS as f64,
            1e6 * each
        );
    }
    Ok(())
}
