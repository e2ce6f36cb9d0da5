//! How the compliance of the mesh changes with the angle of gear bodies that are no solids of revolution.
//!
//! Under the force F on the line of action at mid-face and the shuttling moment M, bodies at the angles psi add to approach and
//! misalignment what their mean over all angles does not,
//!
//! ```text
//! [delta, theta] = c(psi_1, psi_2) [F, M] ,    c = c_1(psi_1) + c_2(psi_2) symmetric,
//! ```
//!
//! each as a short Fourier series. Angles are counted as teeth are ([`super::teeth`]): psi_i = 2 pi (n_i + tau) / z_i with the mesh cycles n_i
//! that have passed on gear i and the mesh position tau. The series holds all that comes again with a turn of the gear: also what the
//! place of the load on the teeth changes.

use nalgebra::Matrix2;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::teeth::Counts;
use super::{BothFlanks, PairGeometry};

/// A part of c_i that comes again so many times a turn of the gear: cosine and sine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyOrder {
    /// Times a turn, 1 or more.
    pub order: u32,
    /// Approach by force.
    pub approach_m_per_n: [f64; 2],
    /// Misalignment by force, which is approach by moment.
    pub tilt_rad_per_n: [f64; 2],
    /// Misalignment by moment.
    pub tilt_rad_per_nm: [f64; 2],
}

impl BodyOrder {
    /// Cosine and sine of approach by force, of what couples it with the moment, and of misalignment by moment.
    pub fn parts(&self) -> [[f64; 2]; 3] {
        [
            self.approach_m_per_n,
            self.tilt_rad_per_n,
            self.tilt_rad_per_nm,
        ]
    }
}

/// Orders of gear 1 and gear 2 on both flanks; none of a gear whose body is a solid of revolution.
pub type BodyOrders = BothFlanks<Vec<BodyOrder>>;

/// More orders than any series needs.
const MOST_ORDERS: usize = 1000;

impl BodyOrders {
    /// Errors: the first series that no body has, and what is wrong with it.
    pub(crate) fn check(&self) -> Result<(), (String, String)> {
        for (flank, gears) in [("drive", &self.drive), ("coast", &self.coast)] {
            for (gear, orders) in gears.iter().enumerate() {
                let refused = |value: String, reason: String| {
                    Err((
                        format!("{value} of gear {}, {flank} flank", gear + 1),
                        reason,
                    ))
                };
                if orders.len() > MOST_ORDERS {
                    let reason = format!("up to {MOST_ORDERS} make sense");
                    return refused(format!("{} orders", orders.len()), reason);
                }
                for part in orders {
                    let numbers = part.parts();
                    if part.order == 0 || !numbers.as_flattened().iter().all(|x| x.is_finite()) {
                        let reason = "orders count from 1 and have finite numbers".into();
                        return refused(format!("order {} with {numbers:?}", part.order), reason);
                    }
                }
            }
        }
        Ok(())
    }
}

/// c at a place and its first and second derivative by the mesh position, in m/N, rad/N and rad/(N m).
pub type CompliancePath = [Matrix2<f64>; 3];

/// Those of one flank of a pair, ready to be evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct TurningBodies {
    gears: [Vec<BodyOrder>; 2],
    teeth: [f64; 2],
}

impl TurningBodies {
    /// The bodies of a pair of `geometry` under loads on a flank with the orders `gears`.
    pub fn new(geometry: &PairGeometry, gears: &[Vec<BodyOrder>; 2]) -> TurningBodies {
        TurningBodies {
            gears: gears.clone(),
            teeth: geometry.gears.each_ref().map(super::Gear::z),
        }
    }

    /// c after the mesh cycles `counts` at the mesh position `tau`.
    pub fn compliance(&self, counts: Counts, tau: f64) -> CompliancePath {
        let mut path = CompliancePath::default();
        for ((orders, teeth), count) in self.gears.iter().zip(self.teeth).zip(counts) {
            // Whole turns taken off before the small part is added: no digit of it is lost.
            let turn = ((count as f64).rem_euclid(teeth) + tau) / teeth;
            for part in orders {
                let order = f64::from(part.order);
                let (sin, cos) = (TAU * order * turn).sin_cos();
                let per_cycle = TAU * order / teeth;
                let of_angle =
                    |[a, b]: [f64; 2]| [a * cos + b * sin, per_cycle * (b * cos - a * sin)];
                let [by_force, tilt, by_moment] = part.parts().map(of_angle);
                for (derivative, sum) in path.iter_mut().take(2).enumerate() {
                    *sum += Matrix2::new(
                        by_force[derivative],
                        tilt[derivative],
                        tilt[derivative],
                        by_moment[derivative],
                    );
                }
                path[2] -=
                    Matrix2::new(by_force[0], tilt[0], tilt[0], by_moment[0]) * per_cycle.powi(2);
            }
        }
        path
    }
}
