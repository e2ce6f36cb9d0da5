//! Force of one flank: elastic part, damping, and what follows them.

use super::engagement::Engagement;
use super::law::Response;
use super::scalar::Scalar;

/// Damping on the line of action.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Damping {
    /// Coefficient on the line of action, N s/m.
    pub coefficient: f64,
    /// Elastic force on the line of action from which on it acts in full, N.
    pub full_at: f64,
}

/// Operating condition and loads of one flank.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlankLoad<T> {
    /// Elongation on the line of action at z_ref, m.
    pub delta: T,
    /// Misalignment, rad.
    pub misalignment: T,
    /// Position on the mesh cycle, 0..1.
    pub mesh_position: T,
    /// Total force on the line of action, N, >= 0.
    pub force: T,
    /// Moment F (z_c - z_ref), N m.
    pub tilt_moment: T,
    /// dU/dC, N.
    pub by_center_distance: T,
    /// dU/dPMC, J.
    pub by_mesh_position: T,
    /// dU/d lambda, N.
    pub by_axial_position: T,
    /// Elastic energy, J.
    pub energy: T,
    /// Elastic tangent stiffness on the line of action, N/m.
    pub stiffness: T,
}

impl<T: Scalar> FlankLoad<T> {
    /// No load.
    pub(crate) fn none(zero: T) -> Self {
        Self {
            delta: zero,
            misalignment: zero,
            mesh_position: zero,
            force: zero,
            tilt_moment: zero,
            by_center_distance: zero,
            by_mesh_position: zero,
            by_axial_position: zero,
            energy: zero,
            stiffness: zero,
        }
    }

    /// Take the load of an elastic `response` at the rates of elongation and misalignment.
    ///
    /// The damper sits where the resultant acts, so it works on delta' + (z_c - z_ref) M'; its power is
    /// -c r (that rate)^2 <= 0, and the resultant stays at z_c. r rises from 0 at no force to 1 at
    /// `damping.full_at` with the cubic step of Adams' IMPACT function (MSC Software, Adams/Solver
    /// guide, "IMPACT"): teeth that meet feel no jump. Where it would pull, the total is zero, and the
    /// side terms fade with it.
    pub(crate) fn carry(
        &mut self,
        response: &Response<T>,
        mesh: &Engagement<T>,
        rate: T,
        tilt_rate: T,
        damping: &Damping,
    ) {
        let elastic = response.gradient[0] * mesh.factor;
        if elastic.re() <= 0.0 {
            return;
        }
        self.energy = response.energy * mesh.factor;
        self.stiffness = response.stiffness * mesh.factor;
        let axial = response.gradient[2] / response.gradient[0];
        let share = elastic / damping.full_at;
        let ramp = if share.re() < 1.0 {
            share * share * (-share * 2.0 + 3.0)
        } else {
            T::from(1.0)
        };
        let total = elastic + ramp * (rate + axial * tilt_rate) * damping.coefficient;
        if total.re() <= 0.0 {
            return;
        }
        self.force = total;
        self.tilt_moment = total * axial;
        let fading = if total.re() < elastic.re() {
            total / elastic
        } else {
            T::from(1.0)
        };
        let scale = mesh.factor * fading;
        self.by_center_distance =
            response.gradient[1] * scale + response.energy * mesh.by_center_distance * fading;
        self.by_mesh_position = response.gradient[3] * scale;
        self.by_axial_position = response.energy * mesh.by_axial_position * fading;
    }

    /// As [`FlankLoad::carry`] with the paper's constant damping `c` (8), N s/m on the line of action:
    /// it acts in full as soon as the teeth touch.
    pub(crate) fn carry_constant(
        &mut self,
        response: &Response<T>,
        mesh: &Engagement<T>,
        rate: T,
        c: f64,
    ) {
        let elastic = response.gradient[0] * mesh.factor;
        if elastic.re() <= 0.0 {
            return;
        }
        self.energy = response.energy * mesh.factor;
        self.stiffness = response.stiffness * mesh.factor;
        let total = elastic + rate * c;
        if total.re() <= 0.0 {
            return;
        }
        self.force = total;
        self.tilt_moment = total * response.gradient[2] / response.gradient[0];
    }

    /// z_c - z_ref, m; zero out of contact.
    pub(crate) fn axial_offset(&self) -> T {
        if self.force.re() > 0.0 {
            self.tilt_moment / self.force
        } else {
            T::from(0.0)
        }
    }
}

/// Index of the flank that carries the larger force and its sign; the `reference` flank and 0 where
/// none does.
pub(crate) fn carrying_flank<T: Scalar>(
    loads: &[FlankLoad<T>; 2],
    reference: usize,
) -> (usize, i32) {
    let [drive, coast] = [loads[0].force.re(), loads[1].force.re()];
    if drive <= 0.0 && coast <= 0.0 {
        (reference, 0)
    } else if drive >= coast {
        (0, 1)
    } else {
        (1, -1)
    }
}
