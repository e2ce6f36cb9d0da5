//! Bearings with clearance under a shaft that bends.

use nalgebra::{DMatrix, DVector};

use crate::gear::Bearing;

/// Bearings with clearance.
///
/// With the radial displacements r of all bearings, r_0 without clearance and S the stiffness of the shaft at its bearings,
/// r minimises (r - r_0)' S (r - r_0) / 2 - sum of G(r), G' = k min(|r|, c) r / |r|, k the stiffness and c half of the clearance:
/// convex, since S contains k. Displacements have the x of all bearings, m, then the y.
pub(super) struct Clearances {
    pub bearings: Vec<Bearing>,
    /// S, N/m.
    pub stiffness: DMatrix<f64>,
    /// r_0, m, of which at least one is not 0.
    pub displacements: DVector<f64>,
}

impl Clearances {
    /// Force (N, in both planes) that each bearing bears less than it would without clearance: Newton's iteration with a line search.
    pub fn lost(&self) -> Vec<[f64; 2]> {
        let mut r = self.start();
        let scale = (&self.stiffness * &self.displacements).norm();
        for _ in 0..200 {
            let slope = self.slope(&r);
            if slope.norm() <= 1e-12 * scale {
                break;
            }
            let Some(factor) = self.curvature(&r).cholesky() else {
                break;
            };
            let step = factor.solve(&slope);
            let (before, falls) = (self.energy(&r), slope.dot(&step));
            let mut part = 1.0;
            while part > 1e-15 && self.energy(&(&r - part * &step)) > before - 1e-4 * part * falls {
                part *= 0.5;
            }
            if part <= 1e-15 {
                break;
            }
            r -= part * step;
        }
        (0..self.bearings.len())
            .map(|i| self.lost_at(&r, i))
            .collect()
    }

    /// Every clearance used up in the direction of the force.
    fn start(&self) -> DVector<f64> {
        let mut r = self.displacements.clone();
        for (i, bearing) in self.bearings.iter().enumerate() {
            let radius = self.radius(&self.displacements, i);
            if radius > 0.0 {
                r[i] *= 1.0 + bearing.free_radius / radius;
                r[self.bearings.len() + i] *= 1.0 + bearing.free_radius / radius;
            }
        }
        r
    }

    /// |r| of bearing `i`.
    fn radius(&self, r: &DVector<f64>, i: usize) -> f64 {
        r[i].hypot(r[self.bearings.len() + i])
    }

    /// G' of bearing `i`, N.
    fn lost_at(&self, r: &DVector<f64>, i: usize) -> [f64; 2] {
        let (radius, bearing) = (self.radius(r, i), &self.bearings[i]);
        let k = bearing.radial_stiffness;
        let share = if radius > bearing.free_radius {
            bearing.free_radius / radius
        } else {
            1.0
        };
        [k * share * r[i], k * share * r[self.bearings.len() + i]]
    }

    /// What r minimises, J.
    fn energy(&self, r: &DVector<f64>) -> f64 {
        let apart = r - &self.displacements;
        let gained = self.bearings.iter().enumerate().map(|(i, bearing)| {
            let (radius, free, k) = (
                self.radius(r, i),
                bearing.free_radius,
                bearing.radial_stiffness,
            );
            match radius > free {
                true => k * free * (radius - 0.5 * free),
                false => 0.5 * k * radius * radius,
            }
        });
        0.5 * apart.dot(&(&self.stiffness * &apart)) - gained.sum::<f64>()
    }

    /// Derivatives of the energy, N.
    fn slope(&self, r: &DVector<f64>) -> DVector<f64> {
        let mut slope = &self.stiffness * (r - &self.displacements);
        for i in 0..self.bearings.len() {
            let [x, y] = self.lost_at(r, i);
            slope[i] -= x;
            slope[self.bearings.len() + i] -= y;
        }
        slope
    }

    /// Second derivatives of the energy, N/m.
    fn curvature(&self, r: &DVector<f64>) -> DMatrix<f64> {
        let count = self.bearings.len();
        let mut bend = self.stiffness.clone();
        for (i, bearing) in self.bearings.iter().enumerate() {
            let k = bearing.radial_stiffness;
            let (x, y) = (r[i], r[count + i]);
            let radius = x.hypot(y);
            let (along, across) = match radius > bearing.free_radius {
                true => (0.0, k * bearing.free_radius / radius),
                false => (k, k),
            };
            let (u, v) = if radius > 0.0 {
                (x / radius, y / radius)
            } else {
                (1.0, 0.0)
            };
            bend[(i, i)] -= along * u * u + across * v * v;
            bend[(count + i, count + i)] -= along * v * v + across * u * u;
            bend[(i, count + i)] -= (along - across) * u * v;
            bend[(count + i, i)] -= (along - across) * u * v;
            // A shaft that floats in its clearances has no stiffness there.
            bend[(i, i)] += 1e-9 * k;
            bend[(count + i, count + i)] += 1e-9 * k;
        }
        bend
    }
}
