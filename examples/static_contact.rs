//! Solves static tooth contact at one position of the mesh cycle.
//!
//! What it shows, in order: a pair file becomes a [`Pair`]; finite elements become the compliance of its teeth; a solver
//! takes both; one position of the cycle, loaded by a torque, gives the static transmission error, the force, where it acts
//! along the face, and how tooth pairs share it. `cargo run --release --example static_contact [PAIR.json]`

use gearmesh::gear::Flank;
use gearmesh_preprocessor::finite_element::{PairCompliance, Settings};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::static_contact::{ContactSolver, contact_settings};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shipped = "resources/pairs/palermo2013.json".to_owned();
    let path = std::env::args().nth(1).unwrap_or(shipped);
    let pair = Pair {
        refinement: Refinement::Coarse, // seconds; errors of each level stand in docs/choosing.md
        ..pair::read(path)?
    };

    // The elastic models take nearly all of the time. A ModelCache in place of None keeps them.
    let settings = Settings::for_pair(&pair);
    let models = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)?;
    let [gear1, gear2] = models.gears;
    let solver = ContactSolver::new(&pair, [gear1, gear2], contact_settings(&pair))?;

    // Mesh position 0: contact at the pitch point at mid-face. Centre distance nominal (m), axes parallel (rad).
    let (mesh_position, center_distance_offset, misalignment) = (0.0, 0.0, 0.0);
    let torque = pair.operating.nominal_torque; // N m, on gear 1
    let position = solver.position(Flank::Drive, mesh_position, center_distance_offset)?;
    let result = position.solve_torque(torque, misalignment, None)?;

    println!("{}: {torque} N m on gear 1", pair.name);
    println!("static transmission error {:.3} um", 1e6 * result.approach);
    println!("force on the line of action {:.1} N", result.loa_force);
    println!("acts at z = {:.3} mm", 1e3 * result.contact_z);
    println!("largest pressure {:.0} MPa", 1e-6 * result.max_pressure);
    for (tooth_pair, share) in &result.load_share {
        println!("tooth pair {tooth_pair:+} carries {:.1} %", 100.0 * share);
    }
    Ok(())
}
