//! Damping, effective mass and communication step that belong together.
//!
//! With `coupling` = automatic, sequential or parallel the FMU predicts what its loads do over a step, and accuracy decides on the
//! step: it is a part of the period of the mesh's own oscillation. With `coupling = held` stability decides: a master
//! that couples explicitly holds the mesh force over a step H while the bodies move. One body of mass m on the mesh
//! spring k and the mesh damper c, integrated exactly under the held force F, goes from step to step by
//!
//! ```text
//! x' = x + H v - H²/(2m) F,    v' = v - H/m F,    F = k x + c v
//! ```
//!
//! With a = k H²/(2m) and b = c H/m the sequential master (F of the start of the step) has the
//! characteristic polynomial z² - (2 - a - b) z + (1 + a - b): stable for a < b < 2, that is
//! H < 2c/k and H < 2m/c. The parallel master gets F one step late: z³ - 2z² + (1 + a + b) z + (a - b), by
//! Jury's criterion stable for b - 3a > (b - a)², the stricter of the two. At light damping it reads H < 2c/(3k), whatever
//! the mass: holding the force acts as a negative damper of 3kH/2 (sequential: kH/2), which the mesh damper must outweigh.
//! At heavy damping, where the mass counts, the least mass that the gears can offer is taken.

use std::f64::consts::PI;

use crate::gear::body;
use crate::iso_6336_1::NominalStiffness;
use gearmesh::gear::{Flank, Gear, PairGeometry};
use gearmesh::root::bisection;
use gearmesh::table::{Query, Table};
use gearmesh::words::to_digits;

/// Damping ratio that packing gives a pair: light among the 0.03 to 0.17 published for steel gears (quoted by
/// Amabili and Rivola, Mech. Syst. Signal Process. 11 (1997) 375-390), so that it hides no resonance.
pub const DAMPING_RATIO: f64 = 0.05;

/// Held loads: the default step over the longest stable one of the parallel master.
const STEP_SHARE: f64 = 0.5;

/// Predicted loads: angle sqrt(k/m) H of the default step with both gears spinning, and its most with all six freedoms of
/// both; stable under every master, with shafts, bearings and several meshes on one body, too.
const STEP_ANGLE: f64 = 0.4;
const STEP_ANGLE_FREE: f64 = 0.6;

/// A gear between the surface that is fixed (bore, rim of a ring) and the reference cylinder: a solid disc
/// over its face width, or the rim, web and hub that the pair file gives; without the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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
        let mut sum = Self::default();
        for ring in body::annuli(gear, gear.reference_radius()) {
            let [inner, outer] = ring.radii.map(|r| r * r);
            let width = ring.z[1] - ring.z[0];
            let mass = gear.density() * PI * (inner - outer).abs() * width;
            let axial = 0.5 * mass * (inner + outer);
            let arm = 0.5 * (ring.z[0] + ring.z[1] - gear.face_width);
            sum.mass += mass;
            sum.axial_inertia += axial;
            sum.transverse_inertia +=
                0.5 * axial + mass * width.powi(2) / 12.0 + mass * arm.powi(2);
        }
        sum
    }
}

/// What the pair says about the dynamics of its mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshDynamics {
    /// The gears' bodies.
    pub blanks: [Blank; 2],
    /// Reduced mass of both on the pitch circle, spinning alone, kg.
    pub reduced_mass: f64,
    /// Reduced mass of both with all freedoms, kg.
    pub free_mass: f64,
    /// Tangential stiffness.
    pub stiffness: Stiffness,
    /// `damping`, N s/m, tangential.
    pub damping: f64,
    /// That of `DAMPING_RATIO`, N s/m.
    pub(super) default_damping: f64,
    /// `effectiveMass`: the reduced mass along the line of action, kg.
    pub effective_mass: f64,
    /// Whether loads are held (`coupling = held`).
    pub held: bool,
}

impl MeshDynamics {
    /// Of a pair with this stiffness; `damping` in N s/m, by default that of `DAMPING_RATIO`; loads that are not held.
    pub fn new(pair: &PairGeometry, stiffness: Stiffness, damping: Option<f64>) -> Self {
        let blanks = [0, 1].map(|i| Blank::new(&pair.gears[i]));
        let radii = [0, 1].map(|i| pair.operating_pitch_radius(i, pair.center_distance));
        let phi = pair.operating_pressure_angle(pair.center_distance);
        // Velocity per impulse of a tangential force, about the axis alone and with all six freedoms: that force brings a
        // radial and an axial one along.
        let spinning = [0, 1].map(|i| radii[i].powi(2) / blanks[i].axial_inertia);
        let free = [0, 1].map(|i| {
            let (gear, blank) = (&pair.gears[i], &blanks[i]);
            let tan_beta = gear.helix_angle.tan() * radii[i] / gear.reference_radius();
            (1.0 + phi.tan().powi(2) + tan_beta.powi(2)) / blank.mass
                + spinning[i]
                + (radii[i] * tan_beta).powi(2) / blank.transverse_inertia
        });
        let reduced_mass = 1.0 / (spinning[0] + spinning[1]);
        let default_damping = 2.0 * DAMPING_RATIO * (stiffness.mean * reduced_mass).sqrt();
        Self {
            blanks,
            reduced_mass,
            free_mass: 1.0 / (free[0] + free[1]),
            stiffness,
            default_damping,
            damping: damping.unwrap_or_else(|| to_digits(default_damping, 3, f64::round)),
            effective_mass: to_digits(reduced_mass / phi.cos().powi(2), 3, f64::round),
            held: false,
        }
    }

    /// Undamped angular frequency of both gears on the mean stiffness, rad/s.
    pub fn frequency(&self) -> f64 {
        (self.stiffness.mean / self.reduced_mass).sqrt()
    }

    /// Damping ratio of that motion.
    pub fn damping_ratio(&self) -> f64 {
        0.5 * self.damping / (self.stiffness.mean * self.reduced_mass).sqrt()
    }

    /// Longest step of the sequential master, s, at the largest stiffness and the least mass.
    pub fn sequential_limit(&self) -> f64 {
        2.0 * (self.damping / self.stiffness.largest).min(self.free_mass / self.damping)
    }

    /// Longest step of the parallel master, s, likewise.
    pub fn parallel_limit(&self) -> f64 {
        let (k, c, m) = (self.stiffness.largest, self.damping, self.free_mass);
        // b - 3a - (b - a)² over H/m falls from c at H = 0 to below zero at 2c/(3k).
        bisection([0.0, 2.0 * c / (3.0 * k)], 60, |h| {
            c - 1.5 * k * h - h / m * (c - 0.5 * k * h).powi(2) > 0.0
        })
    }

    /// Communication step, s, to two digits. Held loads: half of the longest of the parallel master; without damping no
    /// held force is stable at any step: then that of the damping ratio `DAMPING_RATIO`.
    pub fn step(&self) -> f64 {
        let longest = if self.held {
            let mut damped = *self;
            if damped.damping == 0.0 {
                damped.damping = self.default_damping;
            }
            STEP_SHARE * damped.parallel_limit()
        } else {
            let [reduced, free] = [self.reduced_mass, self.free_mass]
                .map(|mass| (mass / self.stiffness.largest).sqrt());
            (STEP_ANGLE * reduced).min(STEP_ANGLE_FREE * free)
        };
        to_digits(longest, 2, f64::floor)
    }
}

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
        let file = &table.file;
        let geometry = &table.file.geometry;
        let force = file.nominal_torque_nm / geometry.gears[0].base_radius();
        let phi = geometry.operating_pressure_angle(geometry.center_distance);
        let tangential = phi.cos().powi(2);
        let [drive, coast] = [Flank::Drive, Flank::Coast].map(|flank| table.flank(flank).0);
        let positions = (0..POSITIONS).map(|i| i as f64 / POSITIONS as f64);
        let sum = positions.clone().map(|position| {
            let pose = nominal_pose(position);
            let delta = drive.approach_at(force, &pose);
            drive.evaluate(&Query { delta, ..pose }, false).hessian[0][0]
        });
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

    /// Without tables: the mean at `nominal_torque` (on gear 1, N m) by ISO 6336-1:2006, method B, N/m: c_gamma_alpha times the
    /// common face width. Rim and web lower it by the standard's blank factor, and line loads below 100 N/mm, at the reference circle, by
    /// their fourth root. It knows neither modifications nor bores; beyond the profile shifts of the standard and for helices above 30
    /// degrees it is an extrapolation.
    pub fn estimated(geometry: &PairGeometry, nominal_torque: f64) -> Self {
        let mesh = NominalStiffness::extrapolated(geometry, nominal_torque).mesh;
        let (_, width) = geometry.face_overlap();
        let phi = geometry.operating_pressure_angle(geometry.center_distance);
        Self::constant(mesh * width * phi.cos().powi(2))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::shipped_tables;
    use crate::samples::paper_pair;
    use approx::assert_relative_eq;
    use gearmesh::gear::Body;
    use nalgebra::Matrix3;

    fn coupling(damping: f64) -> MeshDynamics {
        MeshDynamics::new(&paper_pair(1.0), Stiffness::constant(2.5e8), Some(damping))
    }

    /// Logarithm of the largest multiplier of the maps at the top of this file: of state (x, v, F one step
    /// late), scaled to lengths of a step.
    fn growth(c: &MeshDynamics, h: f64, parallel: bool) -> f64 {
        let a = 0.5 * c.stiffness.largest * h * h / c.free_mass;
        let b = c.damping * h / c.free_mass;
        let now = [[1.0 - a, 1.0 - 0.5 * b, 0.0], [-2.0 * a, 1.0 - b, 0.0]];
        let rows = match parallel {
            true => [[1.0, 1.0, -0.5], [0.0, 1.0, -1.0], [2.0 * a, b, 0.0]],
            false => [now[0], now[1], [0.0; 3]],
        };
        let mut map = Matrix3::from_fn(|i, j| rows[i][j]);
        // Powers by squaring: the norm of the n-th power to the 1/n.
        let mut logarithm = 0.0;
        let mut power = 1.0;
        for _ in 0..40 {
            let size = map.norm();
            logarithm += size.ln() / power;
            map /= size;
            map *= map;
            power *= 2.0;
        }
        logarithm
    }

    #[test]
    fn every_step_below_the_limits_is_stable_and_none_just_above() {
        for damping in [10.0, 300.0, 1e3, 1e4, 1e5] {
            let c = coupling(damping);
            for (limit, parallel) in [(c.sequential_limit(), false), (c.parallel_limit(), true)] {
                let growth = |share: f64| growth(&c, share * limit, parallel);
                let mut stable = [0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99].into_iter();
                assert!(stable.all(|s| growth(s) < 0.0), "{damping} {parallel}");
                assert!(growth(1.01) > 0.0, "{damping} {parallel}");
            }
            assert!(c.parallel_limit() < c.sequential_limit());
        }
        // At light damping the mass does not count.
        let c = coupling(10.0);
        let light = 2.0 * c.damping / (3.0 * c.stiffness.largest);
        assert_relative_eq!(c.parallel_limit(), light, max_relative = 1e-2);
    }

    #[test]
    fn the_default_damping_is_a_twentieth_of_the_critical_one() {
        let c = MeshDynamics::new(&paper_pair(1.0), Stiffness::constant(2.5e8), None);
        assert_relative_eq!(c.damping_ratio(), DAMPING_RATIO, max_relative = 5e-3);
        let held = MeshDynamics { held: true, ..c };
        assert!(2.0 * held.step() <= c.parallel_limit() && 2.2 * held.step() > c.parallel_limit());
        assert!(c.step() >= 10.0 * held.step());
    }

    #[test]
    fn both_of_the_papers_gears_spinning_are_a_quarter_of_a_kilogram() {
        // The mass that fits Table 2 of the paper with both gears free.
        let c = coupling(1e3);
        assert_relative_eq!(c.reduced_mass, 0.25, max_relative = 0.05);
        // More freedoms leave less mass.
        assert!(c.free_mass < c.reduced_mass);
    }

    #[test]
    fn blanks_are_discs_or_rim_web_and_hub() {
        let pair = paper_pair(1.0);
        let gear = &pair.gears[0];
        let blank = Blank::new(gear);
        // A disc without a bore, thin: J = m r²/2 about the axis and m r²/4 across it.
        let disc = Blank::new(&Gear {
            held_radius: 0.0,
            face_width: 1e-9,
            ..gear.clone()
        });
        let square = gear.reference_radius().powi(2);
        // The same disc in three rings weighs the same; without most of its web it is lighter.
        let face = [0.0, gear.face_width];
        let [whole, webbed] = [face, [8e-3, 12e-3]].map(|web| {
            let body = Some(Body {
                rim_radius: 30e-3,
                web,
                hub_radius: 20e-3,
                hub: face,
                held_ends: [false; 2],
            });
            Blank::new(&Gear {
                body,
                ..gear.clone()
            })
        });
        let web = gear.density() * PI * 500e-6 * (gear.face_width - 4e-3);
        for (found, expected) in [
            (disc.axial_inertia, 0.5 * disc.mass * square),
            (disc.transverse_inertia, 0.25 * disc.mass * square),
            (whole.mass, blank.mass),
            (whole.transverse_inertia, blank.transverse_inertia),
            (blank.mass - webbed.mass, web),
        ] {
            assert_relative_eq!(found, expected, max_relative = 1e-9);
        }
        assert!(blank.mass > 0.8 && blank.mass < 1.0, "{} kg", blank.mass);
    }

    #[test]
    fn the_estimate_is_the_same_whichever_gear_is_gear_1() {
        let geometry = |teeth: [u32; 2], shifts: [f64; 2]| {
            let mut geometry = paper_pair(1.0);
            for (gear, (z, x)) in geometry.gears.iter_mut().zip(teeth.into_iter().zip(shifts)) {
                (gear.teeth, gear.profile_shift) = (z, x);
                gear.tip_radius = gear.reference_radius() + gear.normal_module * (1.0 + x);
            }
            geometry.center_distance = geometry.gears.iter().map(|g| g.reference_radius()).sum();
            geometry
        };
        let pinion_first = Stiffness::estimated(&geometry([23, 57], [0.3, -0.3]), 100.0);
        let torque = 100.0 * 57.0 / 23.0;
        let wheel_first = Stiffness::estimated(&geometry([57, 23], [-0.3, 0.3]), torque);
        assert_relative_eq!(pinion_first.mean, wheel_first.mean, max_relative = 1e-12);
    }

    #[test]
    fn the_estimate_falls_with_a_thin_web() {
        let mut geometry = paper_pair(1.0);
        let full = Stiffness::estimated(&geometry, 100.0).mean;
        let gear = &mut geometry.gears[0];
        gear.body = Some(Body {
            rim_radius: gear.root_radius() - 5.0 * gear.normal_module,
            web: [0.4 * gear.face_width, 0.6 * gear.face_width],
            hub_radius: gear.held_radius,
            hub: [0.0, gear.face_width],
            held_ends: [false; 2],
        });
        // C_R = 1 + ln(b_s / b) / (5 exp(s_R / 5 m)) of one gear, 1 of the other.
        let mean = 0.5 * (2.0 + f64::ln(0.2) / (5.0 * f64::exp(1.0)));
        let found = Stiffness::estimated(&geometry, 100.0).mean;
        assert_relative_eq!(found / full, mean, max_relative = 1e-9);
    }

    #[test]
    fn the_estimate_is_within_a_quarter_of_the_shipped_tables() {
        for name in ["fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84"] {
            let table = Table::from_file(shipped_tables(name)).unwrap();
            let found = Stiffness::of_table(&table);
            let torque = table.file.nominal_torque_nm;
            let estimate = Stiffness::estimated(&table.file.geometry, torque).mean;
            let ratio = estimate / found.mean;
            assert!((0.75..1.25).contains(&ratio), "{name}: {ratio}");
            assert!(found.largest > found.mean, "{name}: {found:?}");
            assert!(found.largest < 1.5 * found.mean, "{name}: {found:?}");
        }
    }
}
