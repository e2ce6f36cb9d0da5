//! Damping, effective mass and communication step that belong together.
//!
//! With `coupling` = sequential or parallel the unit predicts what its loads do over a step, and accuracy decides on the
//! step: it is a part of the period of the mesh's own oscillation. With `coupling = held` stability decides:
//! a master that couples explicitly holds the mesh force over a step H while the bodies move. One body of
//! mass m on the mesh spring k and the mesh damper c, integrated exactly under the held force F, goes from
//! step to step by
//!
//! ```text
//! x' = x + H v - H²/(2m) F,    v' = v - H/m F,    F = k x + c v
//! ```
//!
//! With a = k H²/(2m) and b = c H/m the sequential master (element first, F of the start of the step) has the
//! characteristic polynomial z² - (2 - a - b) z + (1 + a - b): stable for a < b < 2, that is
//! H < 2c/k and H < 2m/c. The parallel master gets F one step late: z³ - 2z² + (1 + a + b) z + (a - b), by
//! Jury's criterion stable for
//!
//! ```text
//! b - 3a > (b - a)²
//! ```
//!
//! which is the stricter of the two. At light damping it reads H < 2c/(3k): the mass does not enter, since
//! holding the force acts as a negative damper of kH/2 (parallel: 3kH/2), and the mesh damper must outweigh
//! it. So it holds for any body and any mode that works on the mesh through its elongation; at heavy damping, where
//! the mass counts, the least mass that the gears can offer is taken.

use super::mass::{Blank, free_mass, reduced_mass};
use super::stiffness::Stiffness;
use gearmesh::gear::PairGeometry;
use gearmesh::root::bisection;

/// Damping ratio that packing gives a pair: light among the 0.03 to 0.17 published for steel gears (quoted by
/// Amabili and Rivola, Mech. Syst. Signal Process. 11 (1997) 375-390), so that it hides no resonance.
pub const DAMPING_RATIO: f64 = 0.05;

/// Held loads: the default step over the longest stable one of the parallel master.
pub const STEP_SHARE: f64 = 0.5;

/// Predicted loads: angle sqrt(k/m) H of the default step with both gears spinning, and its most with all six freedoms of
/// both; stable up to 0.7 however far too large the effective mass is taken.
pub const STEP_ANGLE: f64 = 0.4;
const STEP_ANGLE_FREE: f64 = 0.6;

/// What the pair says about the dynamics of its mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// The gears as solid discs.
    pub blanks: [Blank; 2],
    /// Reduced mass of both on the pitch circle, spinning alone, kg.
    pub reduced_mass: f64,
    /// Reduced mass of both with all freedoms, kg.
    pub free_mass: f64,
    /// Tangential stiffness.
    pub stiffness: Stiffness,
    /// `damping`, N s/m, tangential.
    pub damping: f64,
    /// `effectiveMass`: the reduced mass along the line of action, kg.
    pub effective_mass: f64,
    /// Whether loads are held (`coupling = held`).
    pub held: bool,
}

impl Coupling {
    /// Of a pair with this stiffness; `damping` in N s/m, by default that of [`DAMPING_RATIO`]; loads that are not held.
    pub fn new(pair: &PairGeometry, stiffness: Stiffness, damping: Option<f64>) -> Self {
        let reduced_mass = reduced_mass(pair);
        let cos_phi = pair.operating_pressure_angle(pair.center_distance).cos();
        let derived = 2.0 * DAMPING_RATIO * (stiffness.mean * reduced_mass).sqrt();
        Self {
            blanks: [0, 1].map(|i| Blank::new(&pair.gears[i])),
            reduced_mass,
            free_mass: free_mass(pair),
            stiffness,
            damping: damping.unwrap_or_else(|| digits(derived, 3, f64::round)),
            effective_mass: digits(reduced_mass / cos_phi.powi(2), 3, f64::round),
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
        let margin = |h: f64| c - 1.5 * k * h - h / m * (c - 0.5 * k * h).powi(2);
        bisection([0.0, 2.0 * c / (3.0 * k)], 60, |h| margin(h) > 0.0)
    }

    /// Communication step, s, to two digits. Held loads: half of the longest of the parallel master; without damping no
    /// held force is stable at any step: then that of the damping ratio [`DAMPING_RATIO`].
    pub fn step(&self) -> f64 {
        if !self.held {
            let angular = |mass: f64| (self.stiffness.largest / mass).sqrt();
            let longest = (STEP_ANGLE / angular(self.reduced_mass))
                .min(STEP_ANGLE_FREE / angular(self.free_mass));
            return digits(longest, 2, f64::floor);
        }
        let damped = if self.damping > 0.0 {
            *self
        } else {
            Self {
                damping: 2.0 * DAMPING_RATIO * (self.stiffness.mean * self.reduced_mass).sqrt(),
                ..*self
            }
        };
        digits(STEP_SHARE * damped.parallel_limit(), 2, f64::floor)
    }
}

/// `value` > 0 to `count` significant digits.
pub(super) fn digits(value: f64, count: i32, round: fn(f64) -> f64) -> f64 {
    let exponent = value.log10().floor() as i32 - count + 1;
    // Through the decimals, so that what is written is what is meant.
    format!("{:.0}e{exponent}", round(value / 10f64.powi(exponent)))
        .parse()
        .unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::paper_pair;
    use nalgebra::Matrix3;

    fn coupling(damping: f64) -> Coupling {
        Coupling::new(&paper_pair(1.0), Stiffness::constant(2.5e8), Some(damping))
    }

    /// Logarithm of the largest multiplier of the maps at the top of this file: of state (x, v, F one step
    /// late), scaled to lengths of a step.
    fn growth(c: &Coupling, h: f64, parallel: bool) -> f64 {
        let (a, b) = (
            0.5 * c.stiffness.largest * h * h / c.free_mass,
            c.damping * h / c.free_mass,
        );
        let mut map = if parallel {
            Matrix3::new(1.0, 1.0, -0.5, 0.0, 1.0, -1.0, 2.0 * a, b, 0.0)
        } else {
            Matrix3::new(
                1.0 - a,
                1.0 - 0.5 * b,
                0.0,
                -2.0 * a,
                1.0 - b,
                0.0,
                0.0,
                0.0,
                0.0,
            )
        };
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
    fn the_limits_are_where_the_multipliers_leave_the_unit_circle() {
        for damping in [10.0, 300.0, 1e3, 1e4, 1e5] {
            let c = coupling(damping);
            for (limit, parallel) in [(c.sequential_limit(), false), (c.parallel_limit(), true)] {
                let [below, above] = [0.99, 1.01].map(|f| growth(&c, f * limit, parallel));
                assert!(
                    below < 0.0 && above > 0.0,
                    "{damping} {parallel}: {below} {above}"
                );
            }
            assert!(c.parallel_limit() < c.sequential_limit());
        }
    }

    #[test]
    fn every_shorter_step_is_stable_too() {
        let c = coupling(1e3);
        for parallel in [false, true] {
            for i in 1..100 {
                let h = 0.01 * f64::from(i) * c.parallel_limit();
                assert!(growth(&c, h, parallel) < 0.0, "{i} {parallel}");
            }
        }
    }

    #[test]
    fn at_light_damping_the_mass_does_not_count() {
        let heavy = Coupling {
            free_mass: 10.0,
            ..coupling(100.0)
        };
        let light = Coupling {
            free_mass: 0.1,
            ..heavy
        };
        approx::assert_relative_eq!(
            heavy.parallel_limit(),
            light.parallel_limit(),
            max_relative = 1e-2
        );
    }

    #[test]
    fn the_default_damping_is_a_twentieth_of_the_critical_one() {
        let c = Coupling::new(&paper_pair(1.0), Stiffness::constant(2.5e8), None);
        approx::assert_relative_eq!(c.damping_ratio(), DAMPING_RATIO, max_relative = 5e-3);
        let held = Coupling { held: true, ..c };
        assert!(2.0 * held.step() <= c.parallel_limit() && 2.2 * held.step() > c.parallel_limit());
        assert!(c.step() >= 10.0 * held.step());
    }

    #[test]
    fn digits_are_cut_in_decimals() {
        assert_eq!(digits(1.2999e-6, 2, f64::floor), 1.2e-6);
        assert_eq!(digits(1034.6, 3, f64::round), 1030.0);
        assert_eq!(digits(9.996, 3, f64::round), 10.0);
    }
}
