//! Contact in the convention of programs that hold gear 2 and turn gear 1 under its own torque.

use gearmesh::gear::Flank;
use gearmesh_preprocessor::static_contact::{ContactError, ContactResult, ContactSolver};

/// Contact under the torque (N m) of gear 1 alone, where gear 2 stands at the mesh `position` with the centre distance `offset` (m) and the
/// `misalignment` (rad).
///
/// Here either gear turns half of the approach, under the mean of both torques over the base radii. Where tip edges bear, gear 2 is held
/// half of the approach on from the mesh position at which both have turned, and the torques are not in the ratio of the base radii.
///
/// # Errors
/// Those of the solver.
pub fn solve_torque_of_gear1(
    solver: &ContactSolver,
    [position, offset]: [f64; 2],
    [torque, misalignment]: [f64; 2],
) -> Result<ContactResult, ContactError> {
    let pair = solver.geometry();
    let base_radius = pair.gears[0].base_radius();
    let (mut at, mut mean) = (position, torque);
    // Three repetitions leave nothing; along the path alone both conventions are one.
    let mut left = 4;
    loop {
        let problem = solver.position(Flank::Drive, at, offset)?;
        let result = problem.solve_torque(mean, misalignment, None)?;
        if left == 0 || (result.torque_forces[0] / result.loa_force - 1.0).abs() < 1e-9 {
            return Ok(result);
        }
        left -= 1;
        at = position + 0.5 * result.approach / pair.base_pitch();
        mean *= torque / (result.torque_forces[0] * base_radius);
    }
}
