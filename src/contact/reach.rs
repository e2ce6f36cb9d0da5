//! How far tip edges are followed beyond the path of contact: up to the approach that loads can cause.

use super::complementarity::Target;
use super::error::ContactError;
use super::local::constants::STIFFNESS_OVER_MODULUS;
use super::position::Excess;
use super::solver::ContactSolver;
use crate::gear::Flank;
use crate::pair::Pair;

/// Positions of the mesh at which the largest load is tried.
const TRIED: [f64; 2] = [0.0, 0.5];
/// Reach over the approach that was found there, for other positions and centre distances.
const MARGIN: f64 = 1.25;
/// Farther edges take up load, so that approaches fall: one more trial as a rule.
const TRIALS: usize = 8;

/// Approach that the pair's largest load and misalignment can cause, with a margin, m: twice that of a stiff
/// tooth pair, how both bodies give way, what misalignment adds at the ends of the face and of the path, and what
/// modifications take off at most.
pub(super) fn estimate(pair: &Pair, form_rolls: [f64; 2]) -> f64 {
    let g = &pair.geometry;
    let force = pair.operating.maximum_torque / g.gears[0].base_radius();
    let modulus = g.gears[0].youngs_modulus.min(g.gears[1].youngs_modulus);
    let width = g.face_overlap().1;
    let misalignment = pair
        .operating
        .misalignment
        .iter()
        .fold(0.0f64, |m, v| m.max(v.abs()));
    let gears = || g.gears.iter().enumerate();
    let removal: f64 = gears()
        .map(|(i, gear)| {
            let rolls = [form_rolls[i], gear.tip_form_roll()];
            let flanks = [&pair.microgeometry.drive[i], &pair.microgeometry.coast[i]];
            let largest = flanks.map(|flank| flank.largest_removal(gear, rolls));
            largest[0].max(largest[1])
        })
        .sum();
    let bodies: f64 = gears()
        .map(|(_, gear)| {
            let twist = force * gear.base_radius().powi(2) * gear.body_twist();
            twist + force * gear.body_tilt_and_foundation()
        })
        .sum();
    let cos_beta_b = g.base_helix_angle().cos();
    // Force and displacement along the normal are those on the line of action over cos beta_b, the contact line
    // is the face over it.
    2.0 * force / (STIFFNESS_OVER_MODULUS * modulus * width * cos_beta_b)
        + bodies
        + 0.5 * misalignment * (width + g.base_helix_angle().tan() * g.base_pitch())
        + removal / cos_beta_b
}

/// `solver`, with edges followed farther where the largest load and misalignment of `pair` bring the teeth nearer to each
/// other than [`estimate`] thinks, as bodies that tilt under the axial force of a steep helix do.
///
/// What cannot be solved here is refused by name when it is asked for; edges that only more teeth than the elastic models
/// hold could reach are not followed.
pub(super) fn followed_as_needed(mut solver: ContactSolver, pair: &Pair) -> ContactSolver {
    let mut followed = solver.setup().reach;
    for _ in 0..TRIALS {
        let Ok(needed) = beyond(&solver, pair) else {
            break;
        };
        followed = solver.setup().reach;
        match needed {
            Some(needed) => solver = solver.followed_to(MARGIN * needed),
            None => break,
        }
    }
    solver.followed_to(followed)
}

/// Largest approach, m, beyond the reach of `solver` at the positions tried.
fn beyond(solver: &ContactSolver, pair: &Pair) -> Result<Option<f64>, ContactError> {
    let force = pair.operating.maximum_torque / pair.geometry.gears[0].base_radius();
    let flanks = [Flank::Drive, Flank::Coast];
    let differ = !pair.coast_mirrors_drive();
    let mut largest: Option<f64> = None;
    for flank in &flanks[..1 + usize::from(differ)] {
        for position in TRIED {
            let problem = solver.position(*flank, position, 0.0)?;
            for misalignment in pair.operating.misalignment {
                let found = problem.solution(Target::Force(force), misalignment, None)?;
                if let Some(Excess::Reach { needed, .. }) = found.excess {
                    largest = Some(largest.map_or(needed, |l| l.max(needed)));
                }
            }
        }
    }
    Ok(largest)
}
