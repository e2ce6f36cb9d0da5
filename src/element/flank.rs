//! One flank under load.

use super::dual::{Scalar, lift};
use crate::gear::Flank;
use crate::table::{LoadJet, LoadSpline, Table};

/// Loads of one flank.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FlankLoad<T> {
    /// +1 drive, -1 coast.
    pub sign: f64,
    /// Penetration of the unmodified involutes that counts as transmission error, s x - H, m.
    pub penetration: T,
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
    /// Elastic energy U, J.
    pub energy: T,
    /// Elastic tangent stiffness on the line of action, N/m.
    pub stiffness: T,
}

impl<T: Scalar> FlankLoad<T> {
    /// Total force on the line of action, N, >= 0.
    #[inline(always)]
    pub(crate) fn force(&self) -> T {
        self.elastic + self.damping
    }

    /// Share, axial share, distance and weight of the load of this `flank` in `table`, `offset` (m) from the nominal centre distance;
    /// `None`: its law finds them.
    #[inline(always)]
    pub(crate) fn sliding(&self, table: &Table, flank: Flank, offset: T) -> Option<[T; 4]> {
        let (sliding, mirrored) = table.sliding(flank)?;
        let mut all = self.tabulated((sliding, mirrored), offset);
        if mirrored {
            all[1] = -all[1];
        }
        Some(all)
    }

    /// The quantities of a table over elastic force, centre distance offset (m), misalignment and mesh position. `mirrored`: the
    /// table is that of the drive flank, and this the coast flank.
    #[inline(always)]
    pub(crate) fn tabulated<const N: usize>(
        &self,
        (table, mirrored): (&LoadSpline, bool),
        center_distance_offset: T,
    ) -> [T; N] {
        let sign = if mirrored { -1.0 } else { 1.0 };
        let q = [
            self.elastic,
            center_distance_offset,
            self.misalignment * sign,
            self.mesh_position,
        ];
        let jets: [LoadJet; N] = table.evaluate(q.map(T::re));
        jets.map(|jet| lift(jet.value, &jet.gradient, &q))
    }
}
