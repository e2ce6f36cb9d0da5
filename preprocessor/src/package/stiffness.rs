//! Mesh stiffness of a pair in the numbers that start values are made of.

use gearmesh::gear::{Flank, Gear, GearKind, PairGeometry};
use gearmesh::table::{Query, Table};

/// Young's modulus of ISO 6336-1's approximation, Pa.
const STEEL: f64 = 206e9;

/// Mesh positions that the mean and the largest stiffness are taken over.
const POSITIONS: usize = 64;

/// Displacements between zero and the largest of the table, for the largest stiffness.
const DISPLACEMENTS: usize = 32;

/// Tangential mesh stiffness dF_tt/dDTE of a pair, N/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness {
    /// Tangent at nominal torque, mean over the mesh cycle, drive flank, aligned, nominal centre distance: the
    /// one that small motions about the load feel.
    pub mean: f64,
    /// Largest tangent at any load, mesh position, centre distance and misalignment of the tables, both flanks.
    pub largest: f64,
}

impl Stiffness {
    /// From tables.
    pub fn of_table(table: &Table) -> Self {
        let file = table.file();
        let geometry = table.geometry();
        let force = file.nominal_torque_nm / geometry.gears[0].base_radius();
        let phi = geometry.operating_pressure_angle(geometry.center_distance);
        let tangential = phi.cos().powi(2);
        let [drive, coast] = [Flank::Drive, Flank::Coast].map(|flank| table.flank(flank).0);
        let positions = (0..POSITIONS).map(|i| i as f64 / POSITIONS as f64);
        let tangent = |position| {
            let pose = nominal_pose(position);
            let delta = drive.approach_at(force, &pose);
            drive.evaluate(&Query { delta, ..pose }, false).hessian[0][0]
        };
        let sum = positions.clone().map(tangent);
        let mean = sum.sum::<f64>() / POSITIONS as f64;
        let mut largest = mean;
        let coast_record = file.coast.as_ref().unwrap_or(&file.drive);
        for (flank, record) in [(drive, &file.drive), (coast, coast_record)] {
            let top = record.top_load_approach.iter().copied();
            let top = top.fold(0.0, f64::max);
            for query in positions.clone().map(nominal_pose) {
                for center_distance_offset in ends(&file.axes.center_distance_offset) {
                    for misalignment in ends(&file.axes.misalignment) {
                        let tangents = (1..=DISPLACEMENTS).map(|i| {
                            let query = Query {
                                delta: top * i as f64 / DISPLACEMENTS as f64,
                                center_distance_offset,
                                misalignment,
                                ..query
                            };
                            flank.evaluate(&query, false).hessian[0][0]
                        });
                        largest = tangents.fold(largest, f64::max);
                    }
                }
            }
        }
        Self {
            mean: tangential * mean,
            largest: tangential * largest,
        }
    }

    /// Without tables: [`estimated_stiffness`] for both.
    pub fn estimated(geometry: &PairGeometry, nominal_torque: f64) -> Self {
        Self::constant(estimated_stiffness(geometry, nominal_torque))
    }

    /// One stiffness everywhere.
    pub fn constant(stiffness: f64) -> Self {
        Self {
            mean: stiffness,
            largest: stiffness,
        }
    }
}

/// Both ends of an axis and its nominal value.
fn ends(axis: &[f64]) -> [f64; 3] {
    match axis {
        [] => [0.0; 3],
        [first, .., last] => [*first, 0.0, *last],
        [only] => [*only; 3],
    }
}

/// No approach, aligned, at the nominal centre distance.
pub(super) fn nominal_pose(mesh_position: f64) -> Query {
    Query {
        mesh_position,
        ..Query::default()
    }
}

/// Mean tangential mesh stiffness at `nominal_torque` (on gear 1, N m) by the approximation of ISO 6336-1:2006,
/// clause 9, N/m: c_gamma = c' (0.75 epsilon_alpha + 0.25) times the common face width, with c' of solid
/// discs from the teeth, their profile shifts, the basic rack, the helix and the Young's moduli. It knows
/// neither modifications nor bores, and what it gives for helices above 30 degrees is an extrapolation.
pub fn estimated_stiffness(geometry: &PairGeometry, nominal_torque: f64) -> f64 {
    const THEORY_TO_MEASUREMENT: f64 = 0.8;
    let distance = geometry.center_distance;
    let [g1, g2] = &geometry.gears;
    let dedendum = 0.5 * (g1.dedendum_coefficient + g2.dedendum_coefficient);
    let pressure_angle = g1.normal_pressure_angle.to_degrees();
    let rack = (1.0 + 0.5 * (1.2 - dedendum)) * (1.0 - 0.02 * (20.0 - pressure_angle));
    let [e1, e2] = [g1.youngs_modulus, g2.youngs_modulus];
    let modulus = 2.0 * e1 * e2 / (e1 + e2) / STEEL;
    let (_, width) = geometry.face_overlap();
    let load = nominal_torque / geometry.operating_pitch_radius(0, distance) / width;
    // Teeth that bear less than 100 N/mm touch on less of their face.
    let light = (load / 100e3).min(1.0).powf(0.25);
    let corrections = THEORY_TO_MEASUREMENT * rack * g1.helix_angle.cos() * modulus * light;
    let ratio = geometry.transverse_contact_ratio(distance).max(1.0);
    let loa = theoretical_pair_stiffness(geometry) * corrections * (0.75 * ratio + 0.25) * width;
    loa * geometry.operating_pressure_angle(distance).cos().powi(2)
}

/// Theoretical single stiffness c'_th of ISO 6336-1, N/m per m of face width: of one pair of steel teeth on solid discs
/// with a basic rack of dedendum 1.2, on the line of action in the normal section.
pub fn theoretical_pair_stiffness(geometry: &PairGeometry) -> f64 {
    let [g1, g2] = &geometry.gears;
    // The external gear first, as the standard counts; a ring has infinitely many teeth and no shift there.
    let (pinion, wheel) = if geometry.ring() == Some(0) {
        (g2, g1)
    } else {
        (g1, g2)
    };
    // z_n = z / (cos² beta_b cos beta).
    let per_virtual_teeth =
        |g: &Gear| g.base_helix_angle().cos().powi(2) * g.helix_angle.cos() / g.z();
    let (n1, x1) = (per_virtual_teeth(pinion), pinion.profile_shift);
    let (n2, x2) = match wheel.kind {
        GearKind::External => (per_virtual_teeth(wheel), wheel.profile_shift),
        GearKind::Ring => (0.0, 0.0),
    };
    // Least flexibility of a pair of teeth, mm um / N.
    let flexibility = 0.04723 + 0.15551 * n1 + 0.25791 * n2
        - 0.00635 * x1
        - 0.11654 * x1 * n1
        - 0.00193 * x2
        - 0.24188 * x2 * n2
        + 0.00529 * x1 * x1
        + 0.00182 * x2 * x2;
    1e9 / flexibility
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::shipped_tables;
    use crate::pair;

    #[test]
    fn the_theoretical_stiffness_of_a_tooth_pair_is_that_of_iso_tr_6336_30_example_1() {
        let text = include_str!("../../../tests/data/iso-tr-6336-30-example-1.json");
        let pair = pair::from_json(text).unwrap();
        let found = 1e-9 * theoretical_pair_stiffness(&pair.geometry);
        assert!((found - 17.8558).abs() < 1e-3, "{found}");
    }

    #[test]
    fn the_estimate_is_within_a_quarter_of_the_shipped_tables() {
        for name in ["fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84"] {
            let table = Table::from_file(shipped_tables(name)).unwrap();
            let found = Stiffness::of_table(&table);
            let estimate = estimated_stiffness(table.geometry(), table.file().nominal_torque_nm);
            let ratio = estimate / found.mean;
            assert!(
                (0.75..1.25).contains(&ratio),
                "{name}: {estimate:e} against {found:?}"
            );
            assert!(
                found.largest > found.mean && found.largest < 1.5 * found.mean,
                "{found:?}"
            );
        }
    }
}
