//! Elastic ring under boundary traction, harmonic by harmonic, in closed form.

use nalgebra::{Matrix2, Matrix4, Vector4};

/// A ring whose one edge is loaded and whose other edge is held, in plane strain, plane stress or a state
/// between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Annulus {
    /// Radius of the loaded edge, m.
    pub loaded: f64,
    /// Radius of the held edge, m: smaller for an external gear, larger for a ring.
    pub held: f64,
    /// Shear modulus, Pa.
    pub shear_modulus: f64,
    /// Kolosov's constant: 3 - 4 nu in plane strain, (3 - nu) / (1 + nu) in plane stress.
    pub kolosov: f64,
}

impl Annulus {
    /// Edge displacement per traction of the harmonic n, m/Pa, symmetric: the traction (P cos n theta
    /// radially outward, Q sin n theta in +theta) moves the edge by (U cos n theta, V sin n theta),
    /// (U, V) = C (P, Q). For n = 0 the second row stands for uniform shear and twist (Q, V without the
    /// sine).
    ///
    /// Displacements of Michell's solution (Barber, Elasticity, table 9.1). Every power is scaled to one
    /// on the edge where it is largest, so that no n overflows.
    pub fn flexibility(&self, n: u32) -> Matrix2<f64> {
        let loaded: Vec<Edge> = (0..4).map(|i| self.solution(n, i, self.loaded)).collect();
        let held: Vec<Edge> = (0..4).map(|i| self.solution(n, i, self.held)).collect();
        let outward = (self.loaded - self.held).signum();
        let system = Matrix4::from_fn(|row, column| match row {
            0 => outward * self.radial_stress(n, &loaded[column]),
            1 => outward * shear_stress(n, &loaded[column], self.loaded),
            2 => held[column].u,
            _ => held[column].v,
        });
        let factor = system.lu();
        let mut c = Matrix2::zeros();
        for column in 0..2 {
            let mut load = Vector4::zeros();
            load[column] = 1.0;
            // Distinct edges make the four solutions independent.
            let a = factor
                .solve(&load)
                .unwrap_or_else(|| Vector4::repeat(f64::NAN));
            for i in 0..4 {
                c[(0, column)] += a[i] * loaded[i].u / (2.0 * self.shear_modulus);
                c[(1, column)] += a[i] * loaded[i].v / (2.0 * self.shear_modulus);
            }
        }
        c
    }

    /// Solution `i` of the four of harmonic n at radius `r`: 2 G times displacement.
    fn solution(&self, n: u32, i: usize, r: f64) -> Edge {
        let k = self.kolosov;
        let order = f64::from(n);
        let outer = self.loaded.max(self.held);
        let inner = self.loaded.min(self.held);
        // (u, v) r^exponent, scaled.
        let power = |u: f64, v: f64, exponent: f64| {
            let scale = if exponent >= 0.0 { outer } else { inner };
            let value = (r / scale).powf(exponent);
            Edge {
                u: u * value,
                v: v * value,
                du: u * exponent * value / r,
                dv: v * exponent * value / r,
                r,
            }
        };
        match (n, i) {
            (0, 0) => power(1.0, 0.0, 1.0),
            (0, 1) => power(1.0, 0.0, -1.0),
            (0, 2) => power(0.0, 1.0, 1.0),
            (0, _) => power(0.0, 1.0, -1.0),
            // The two of r^0 coincide for n = 1; the second is that of a force at the centre.
            (1, 3) => {
                let log = (r / outer).ln();
                Edge {
                    u: 2.0 * k * log - 1.0,
                    v: -2.0 * k * log - 1.0,
                    du: 2.0 * k / r,
                    dv: -2.0 * k / r,
                    r,
                }
            }
            (_, 0) => power(-order, order, order - 1.0),
            (_, 1) => power(k - order - 1.0, k + order + 1.0, order + 1.0),
            (_, 2) => power(order, order, -order - 1.0),
            (_, _) => power(k + order - 1.0, -(k - order + 1.0), 1.0 - order),
        }
    }

    /// sigma_r = 2 G eps_r + lambda (eps_r + eps_theta).
    fn radial_stress(&self, n: u32, e: &Edge) -> f64 {
        let lame = (3.0 - self.kolosov) / (2.0 * (self.kolosov - 1.0));
        e.du + lame * (e.du + (e.u + f64::from(n) * e.v) / e.r)
    }
}

/// sigma_r_theta.
fn shear_stress(n: u32, e: &Edge, r: f64) -> f64 {
    0.5 * (e.dv - e.v / r - f64::from(n) * e.u / r)
}

/// 2 G times displacement and its radial derivative.
struct Edge {
    u: f64,
    v: f64,
    du: f64,
    dv: f64,
    r: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn rings() -> [Annulus; 2] {
        let ring = |loaded, held| Annulus {
            loaded,
            held,
            shear_modulus: 80e9,
            kolosov: 1.8,
        };
        [ring(0.036, 0.015), ring(0.060, 0.072)]
    }

    #[test]
    fn flexibility_is_symmetric_and_positive_definite() {
        for ring in rings() {
            for n in [0, 1, 2, 3, 7, 40, 300, 2000] {
                let c = ring.flexibility(n);
                let scale = c[(0, 0)].max(c[(1, 1)]);
                assert!((c[(0, 1)] - c[(1, 0)]).abs() < 1e-9 * scale, "{n}: {c}");
                assert!(c[(0, 0)] > 0.0 && c.determinant() > 0.0, "{n}: {c}");
            }
        }
    }

    #[test]
    fn twist_is_that_of_a_disc_under_torque() {
        // v = T r / (4 pi G) (1 / held^2 - 1 / loaded^2), T = 2 pi r^2 q.
        for ring in rings() {
            let (r, i) = (ring.loaded, ring.held);
            let v = r.powi(3) / (2.0 * ring.shear_modulus) * (i.powi(-2) - r.powi(-2)).abs();
            assert_relative_eq!(ring.flexibility(0)[(1, 1)], v, max_relative = 1e-12);
        }
    }

    #[test]
    fn short_waves_see_a_half_plane() {
        // 2 (1 - nu^2) / (E k) = (kappa + 1) / (4 G k) on the diagonal.
        for ring in rings() {
            let n = 4000;
            let half_plane = 2.8 / (4.0 * 80e9) * ring.loaded / f64::from(n);
            let c = ring.flexibility(n);
            assert_relative_eq!(c[(0, 0)], half_plane, max_relative = 1e-3);
            assert_relative_eq!(c[(1, 1)], half_plane, max_relative = 1e-3);
        }
    }
}
