//! The elastic law of `stiffnessModel = contact`: a static contact solve at every evaluation.

use std::sync::{Mutex, PoisonError};

use crate::contact::{ContactFile, ContactPotential, RuntimeContact, Warm};
use crate::element::{Elasticity, FlankLaws};
use crate::gear::Flank;
use crate::gear::teeth::Counts;
use crate::table::{COORDINATES, Potential, Query};
use std::sync::Arc;

/// Steps of the central differences of the slopes by centre distance, m, and by mesh position.
const STEPS: [(usize, f64); 2] = [(1, 1e-7), (3, 1e-4)];

/// Contact of one flank, with the forces of its last solve to start from.
struct ContactLaw {
    contact: RuntimeContact,
    warm: Mutex<Warm>,
}

/// The laws of both flanks of `file`.
pub fn laws(file: &ContactFile) -> FlankLaws {
    let of = |flank| -> Option<Arc<dyn Elasticity>> {
        let contact = file.flank(flank)?;
        let warm = Mutex::default();
        Some(Arc::new(ContactLaw { contact, warm }))
    };
    let drive = of(Flank::Drive).expect("there is always a drive flank");
    FlankLaws {
        drive,
        coast: of(Flank::Coast),
    }
}

impl ContactLaw {
    /// The potential at `at`.
    ///
    /// # Errors
    /// No solve succeeds: why.
    fn at(&self, at: [f64; COORDINATES], counts: Counts) -> Result<ContactPotential, String> {
        // The forces are whole even if a thread panicked while it held the lock.
        let mut warm = self.warm.lock().unwrap_or_else(PoisonError::into_inner);
        let found = self.contact.potential(at, counts, &mut warm);
        found.map_err(|error| format!("stiffnessModel = contact finds no loads: {error}"))
    }
}

impl Elasticity for ContactLaw {
    fn tells_teeth_apart(&self) -> bool {
        true
    }

    fn evaluate(
        &self,
        query: &Query,
        counts: Counts,
        want_hessian: bool,
    ) -> Result<Potential, String> {
        let at = [
            query.delta,
            query.center_distance_offset,
            query.misalignment,
            query.mesh_position,
        ];
        let here = self.at(at, counts)?;
        let mut out = Potential {
            value: here.energy,
            gradient: here.gradient,
            out_of_range: here.out_of_range,
            ..Potential::default()
        };
        out.hessian[0][0] = here.tangent.force_by_approach;
        if !want_hessian || here.gradient[0] == 0.0 {
            return Ok(out);
        }
        out.hessian[0][2] = here.tangent.force_by_misalignment;
        out.hessian[2][0] = here.tangent.force_by_misalignment;
        out.hessian[2][2] = here.tangent.moment_by_misalignment;
        for (axis, step) in STEPS {
            let side = |sign: f64| {
                let mut x = at;
                x[axis] += sign * step;
                self.at(x, counts).map(|potential| potential.gradient)
            };
            let (up, down) = (side(1.0)?, side(-1.0)?);
            for i in 0..COORDINATES {
                let slope = (up[i] - down[i]) / (2.0 * step);
                // Both mixed slopes of both axes are found: the last one counts for either.
                out.hessian[i][axis] = slope;
                out.hessian[axis][i] = slope;
            }
        }
        Ok(out)
    }
}

#[cfg(all(test, feature = "preprocess"))]
mod tests {
    use super::*;
    use crate::contact::ContactSettings;
    use crate::pair::Pair;
    use crate::testing::coarse_solver;

    #[test]
    fn a_pose_that_no_solve_finds_says_why() {
        let text = include_str!("../../resources/pairs/palermo2013.json");
        let pair = Pair::from_json(text).unwrap();
        let settings = ContactSettings {
            stations: 4,
            ..ContactSettings::default()
        };
        let file = ContactFile::new(&pair, &coarse_solver(&pair, settings)).unwrap();
        let drive = laws(&file).drive;
        let query = |center_distance_offset| Query {
            delta: 1e-5,
            center_distance_offset,
            misalignment: 0.0,
            mesh_position: 0.2,
        };
        let at = |offset| drive.evaluate(&query(offset), [0; 2], true);
        assert!(at(0.0).unwrap().gradient[0] > 0.0);
        // Nearer than the base circles allow.
        let said = at(-0.02).unwrap_err();
        assert!(said.contains("no path of contact"), "{said}");
    }
}
