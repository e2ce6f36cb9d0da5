//! Masses of the gears, as far as a drawing of the teeth tells them.

use std::f64::consts::PI;

use gearmesh::gear::{Gear, PairGeometry};

/// Density of steel, kg/m³.
const STEEL: f64 = 7850.0;

/// A gear of steel between the surface that is held (bore, rim of a ring) and the reference cylinder: a solid disc
/// over its face width, or the rim, web and hub that the pair file gives; nothing of the shaft or the other gears
/// on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blank {
    /// kg.
    pub mass: f64,
    /// Moment of inertia about the axis, kg m².
    pub axial_inertia: f64,
    /// Moment of inertia about a transverse axis through mid-face, kg m².
    pub transverse_inertia: f64,
}

impl Blank {
    /// The body of `gear`.
    pub fn new(gear: &Gear) -> Self {
        let none = Self {
            mass: 0.0,
            axial_inertia: 0.0,
            transverse_inertia: 0.0,
        };
        gear.annuli(gear.reference_radius())
            .iter()
            .fold(none, |sum, ring| {
                let [inner, outer] = ring.radii.map(|r| r * r);
                let width = ring.z[1] - ring.z[0];
                let mass = STEEL * PI * (inner - outer).abs() * width;
                let axial_inertia = 0.5 * mass * (inner + outer);
                let arm = 0.5 * (ring.z[0] + ring.z[1] - gear.face_width);
                Self {
                    mass: sum.mass + mass,
                    axial_inertia: sum.axial_inertia + axial_inertia,
                    transverse_inertia: sum.transverse_inertia
                        + 0.5 * axial_inertia
                        + mass * width.powi(2) / 12.0
                        + mass * arm.powi(2),
                }
            })
    }
}

/// Reduced mass on the operating pitch circle of two blanks that can but spin, kg:
/// 1/m = r_w1²/J1 + r_w2²/J2.
pub fn reduced_mass(pair: &PairGeometry) -> f64 {
    let mobility = |i: usize| {
        let radius = pair.operating_pitch_radius(i, pair.center_distance);
        radius.powi(2) / Blank::new(&pair.gears[i]).axial_inertia
    };
    1.0 / (mobility(0) + mobility(1))
}

/// Reduced mass of two blanks that are free in all six freedoms each, kg, against a tangential force at
/// the pitch point with its radial and axial parts: the least that the mesh can meet on any support.
pub fn free_mass(pair: &PairGeometry) -> f64 {
    let distance = pair.center_distance;
    let tan_phi = pair.operating_pressure_angle(distance).tan();
    let mobility = |i: usize| {
        let gear = &pair.gears[i];
        let blank = Blank::new(gear);
        let radius = pair.operating_pitch_radius(i, distance);
        let tan_beta = gear.helix_angle.tan() * radius / gear.reference_radius();
        (1.0 + tan_phi.powi(2) + tan_beta.powi(2)) / blank.mass
            + radius.powi(2) / blank.axial_inertia
            + (radius * tan_beta).powi(2) / blank.transverse_inertia
    };
    1.0 / (mobility(0) + mobility(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::paper_pair;
    use approx::assert_relative_eq;
    use gearmesh::gear::Body;

    #[test]
    fn both_of_the_papers_gears_free_are_a_quarter_of_a_kilogram() {
        // The mass that fits Table 2 of the paper with both gears free.
        assert_relative_eq!(reduced_mass(&paper_pair(1.0)), 0.25, max_relative = 0.05);
    }

    #[test]
    fn more_freedoms_leave_less_mass() {
        let pair = paper_pair(1.0);
        assert!(free_mass(&pair) < reduced_mass(&pair));
        let gear = &pair.gears[0];
        let blank = Blank::new(gear);
        // A disc without a bore, thin: J = m r²/2 about the axis and m r²/4 across it.
        let disc = Blank::new(&Gear {
            held_radius: 0.0,
            face_width: 1e-9,
            ..gear.clone()
        });
        let square = gear.reference_radius().powi(2);
        assert_relative_eq!(
            disc.axial_inertia,
            0.5 * disc.mass * square,
            max_relative = 1e-12
        );
        assert_relative_eq!(
            disc.transverse_inertia,
            0.25 * disc.mass * square,
            max_relative = 1e-9
        );
        // The same disc in three rings weighs the same; without most of its web it is lighter.
        let face = [0.0, gear.face_width];
        let body = Body {
            rim_radius: 30e-3,
            web: face,
            hub_radius: 20e-3,
            hub: face,
            held_ends: [false; 2],
        };
        let [whole, webbed] = [face, [8e-3, 12e-3]].map(|web| {
            Blank::new(&Gear {
                body: Some(Body { web, ..body }),
                ..gear.clone()
            })
        });
        assert_relative_eq!(whole.mass, blank.mass, max_relative = 1e-12);
        assert_relative_eq!(
            whole.transverse_inertia,
            blank.transverse_inertia,
            max_relative = 1e-12
        );
        assert_relative_eq!(
            blank.mass - webbed.mass,
            STEEL * PI * 500e-6 * (gear.face_width - 4e-3),
            max_relative = 1e-9
        );
        assert!(blank.mass > 0.8 && blank.mass < 1.0, "{} kg", blank.mass);
    }
}
