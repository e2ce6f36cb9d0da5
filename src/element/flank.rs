//! One flank under load: elastic slopes, the damper, and the stress in the tooth roots.

use super::constants::{Constants, FLANKS};
use super::engagement::Engagement;
use super::law::Response;
use super::map::Coordinates;
use super::scalar::{Scalar, lift};
use crate::table::{Effects, LoadJet, Table};

/// Damper on the line of action.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Damper {
    /// Rises with the elastic force: teeth that meet feel no jump. N s/m, and the force, N, from which on it
    /// acts in full.
    Rising { coefficient: f64, full_at: f64 },
    /// The constant c of the paper's (8), N s/m tangential.
    Constant { tangential: f64 },
}

impl Damper {
    /// Force of the damper, N, on the line of action, beside the elastic force `elastic` > 0 while the flanks approach at
    /// `rate`, m/s. It has the sign of the rate at every state, so that its power -f rate is never positive,
    /// and never pulls by more than the flanks press: the sum of both forces is >= 0.
    ///
    /// Rising: r c rate, r the cubic step of Adams' IMPACT function (MSC Software, Adams/Solver guide, "IMPACT")
    /// with force in place of penetration. Where the flanks part so fast that it would take off more than
    /// half of the elastic force, it takes off y - (y - 1/2)^2 / 2 of it in place of y, and all from y = 3/2
    /// on: the force has a continuous slope. Constant: c rate / cos^2(phi), cut off as in the paper.
    pub(crate) fn force<T: Scalar>(&self, elastic: T, rate: T, cos_phi: T) -> T {
        match *self {
            Damper::Rising {
                coefficient,
                full_at,
            } => {
                let share = elastic * (1.0 / full_at);
                let ramp = if share.re() < 1.0 {
                    share * share * (-share * 2.0 + 3.0)
                } else {
                    T::from(1.0)
                };
                let force = ramp * rate * coefficient;
                if force.re() >= -0.5 * elastic.re() {
                    return force;
                }
                let taken = -force / elastic;
                if taken.re() >= 1.5 {
                    return -elastic;
                }
                let beyond = taken - 0.5;
                -elastic * (taken - beyond * beyond * 0.5)
            }
            Damper::Constant { tangential } => {
                let force = rate * tangential / (cos_phi * cos_phi);
                if force.re() > -elastic.re() {
                    force
                } else {
                    -elastic
                }
            }
        }
    }
}

/// Loads of one flank.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlankLoad<T> {
    /// +1 drive, -1 coast.
    pub sign: f64,
    /// Elongation of the unmodified involutes that counts as transmission error, s x - H, m.
    pub elongation: T,
    /// Misalignment, rad.
    pub misalignment: T,
    /// Position on the mesh cycle, 0..1.
    pub mesh_position: T,
    /// Elastic force on the line of action dU/d delta, N, >= 0; zero: no contact.
    pub elastic: T,
    /// z_c - z_ref, m; zero out of contact.
    pub arm: T,
    /// Force of the damper on the line of action, N, >= -`elastic`.
    pub damping: T,
    /// Lever of M in the rate that the damper opposes, m.
    pub damping_arm: T,
    /// dU/dC, N.
    pub by_center_distance: T,
    /// dU/dPMC, J.
    pub by_mesh_position: T,
    /// dU/d lambda, N.
    pub by_axial_position: T,
    /// Elastic energy U, J.
    pub energy: T,
    /// Elastic tangent stiffness on the line of action, N/m.
    pub stiffness: T,
}

impl<T: Scalar> FlankLoad<T> {
    /// Flank `sign` at these conditions, without load.
    pub(crate) fn unloaded(sign: f64, elongation: T, misalignment: T, mesh_position: T) -> Self {
        let zero = T::from(0.0);
        Self {
            sign,
            elongation,
            misalignment,
            mesh_position,
            elastic: zero,
            arm: zero,
            damping: zero,
            damping_arm: zero,
            by_center_distance: zero,
            by_mesh_position: zero,
            by_axial_position: zero,
            energy: zero,
            stiffness: zero,
        }
    }

    /// Takes the slopes of the potential U = (engagement) W.
    pub(crate) fn press(&mut self, response: &Response<T>, mesh: &Engagement<T>) {
        let elastic = response.gradient[0] * mesh.factor;
        if elastic.re() <= 0.0 {
            return;
        }
        self.elastic = elastic;
        self.arm = response.gradient[2] / response.gradient[0];
        self.energy = response.energy * mesh.factor;
        self.stiffness = response.stiffness * mesh.factor;
        self.by_center_distance =
            response.gradient[1] * mesh.factor + response.energy * mesh.by_center_distance;
        self.by_mesh_position = response.gradient[3] * mesh.factor;
        self.by_axial_position = response.energy * mesh.by_axial_position;
    }

    /// Rate of approach that the damper opposes, m/s, out of the rates of the coordinates:
    /// s x' - H' + `damping_arm` M'.
    pub(crate) fn approach(&self, rates: &Coordinates<T>) -> T {
        let [even, odd] = rates.misalignment;
        rates.turn * self.sign - rates.half_gap + (even + odd * self.sign) * self.damping_arm
    }

    /// All slopes of this flank by the coordinates, damper included.
    #[inline(always)]
    pub(crate) fn all_slopes(&self, per_pitch_angle: f64) -> Coordinates<T> {
        let moment = self.elastic * self.arm + self.damping * self.damping_arm;
        Coordinates {
            center_distance: self.by_center_distance,
            mesh_angle: self.by_mesh_position * (-self.sign * per_pitch_angle),
            axial: self.by_axial_position,
            misalignment: [moment, moment * self.sign],
            ..along_approach(self.sign, self.damping_arm, self.force())
        }
    }

    /// Where tables over the load are asked: elastic force, centre distance offset (m), misalignment and mesh position,
    /// without the `effects` that are off; `mirrored`: those of the drive flank, for the coast flank.
    #[inline(always)]
    pub(crate) fn table_coordinates(
        &self,
        effects: &Effects,
        center_distance_offset: T,
        mirrored: bool,
    ) -> [T; 4] {
        let zero = T::from(0.0);
        let on = |effect: bool, x: T| if effect { x } else { zero };
        let misalignment = on(effects.misalignment, self.misalignment);
        [
            self.elastic,
            on(effects.center_distance, center_distance_offset),
            if mirrored {
                -misalignment
            } else {
                misalignment
            },
            self.mesh_position,
        ]
    }

    /// Total force on the line of action, N, >= 0.
    pub(crate) fn force(&self) -> T {
        self.elastic + self.damping
    }
}

/// Slopes by the coordinates of a `force` along the rate [`FlankLoad::approach`] of flank `sign`: its transpose.
pub(crate) fn along_approach<T: Scalar>(sign: f64, arm: T, force: T) -> Coordinates<T> {
    let zero = T::from(0.0);
    let moment = force * arm;
    Coordinates {
        turn: force * sign,
        half_gap: -force,
        center_distance: zero,
        misalignment: [moment, moment * sign],
        mesh_angle: zero,
        axial: zero,
    }
}

/// Stress in the roots of gear 1 and gear 2 under the loads of both `flanks`, Pa: the larger one.
///
/// The table must have it among its effects. Apart from the loads, which most units compute alone.
#[inline(never)]
pub(crate) fn root_stress<T: Scalar>(
    table: &Table,
    k: &Constants,
    center_distance: T,
    flanks: &[FlankLoad<T>; 2],
) -> [T; 2] {
    let mut largest = [T::from(0.0); 2];
    for (load, flank) in flanks.iter().zip(FLANKS) {
        if load.elastic.re() <= 0.0 {
            continue;
        }
        let Some((stress, mirrored)) = table.root_stress(flank) else {
            continue;
        };
        let offset = center_distance - k.center_distance;
        let q = load.table_coordinates(table.effects(), offset, mirrored);
        let jets: [LoadJet; 2] = stress.evaluate(q.map(T::re));
        for (largest, jet) in largest.iter_mut().zip(&jets) {
            let here = lift(jet.value, &jet.gradient, &q);
            if here.re() > largest.re() {
                *largest = here;
            }
        }
    }
    largest
}
