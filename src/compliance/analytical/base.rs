//! The base under the teeth: an elastic ring, harmonics around it and cosine waves along the face.

use nalgebra::{DMatrix, Matrix2, Vector2};

use super::annulus::Annulus;
use super::legendre::Legendre;

/// Root loads of one tooth per length of face, and the root motions conjugate to them.
///
/// 0: V, force in the sense of the push; 1: M, couple that turns the tooth in that sense; 2: N, force into
/// the base. All are tractions of fixed direction on the arc on which the tooth stands, V and N uniform, M
/// linear.
pub const ROOT_LOADS: usize = 3;

/// Multiples of the number of teeth up to which harmonics are summed on either side: traction on an
/// arc of half a pitch falls like 1/n, its displacement by another 1/n.
const ALIASES: i32 = 12;

/// Base of a gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    /// The ring under the teeth.
    pub annulus: Annulus,
    /// Number of teeth.
    pub teeth: u32,
    /// Half of the angle on which a tooth stands, rad.
    pub half_angle: f64,
    /// +1 external, -1 ring.
    pub kappa: f64,
    /// cos beta: the push of a helical tooth in the transverse plane over that normal to its trace.
    pub cos_beta: f64,
    /// Poisson ratio.
    pub poisson_ratio: f64,
}

impl Base {
    /// Distance from the axis at which the uniform root load V acts, m.
    pub fn load_radius(&self) -> f64 {
        self.annulus.loaded * self.half_angle.sin() / self.half_angle
    }

    /// Flexibility of the root motions under root loads that vary from tooth to tooth like
    /// exp(2 pi i p t / z), t counted in the sense of the push, in `legendre` polynomials along the
    /// face: rows and columns load x polynomial. With i N in place of N it is real and symmetric.
    /// `waves` cosine waves resolve the face.
    pub fn flexibility(&self, p: u32, legendre: &Legendre, waves: usize) -> DMatrix<f64> {
        let size = legendre.len();
        let mut sum = DMatrix::zeros(ROOT_LOADS * size, ROOT_LOADS * size);
        let z = self.teeth as i32;
        let mut per_wave = vec![[[0.0; ROOT_LOADS]; ROOT_LOADS]; waves];
        for alias in -ALIASES..=ALIASES {
            let n = p as i32 + alias * z;
            let v = self.shapes(n);
            let c = self.annulus.flexibility(n.unsigned_abs());
            for (wave, target) in per_wave.iter_mut().enumerate() {
                let k = std::f64::consts::PI * wave as f64 / legendre.length();
                let c = self.along_the_face(&c, k);
                for a in 0..ROOT_LOADS {
                    for b in 0..ROOT_LOADS {
                        target[a][b] += v[a].dot(&(c * v[b]));
                    }
                }
            }
        }
        let around = f64::from(self.teeth) * 2.0 * std::f64::consts::PI * self.annulus.loaded;
        for (wave, target) in per_wave.iter().enumerate() {
            let projected = legendre.cosine(wave);
            for a in 0..ROOT_LOADS {
                for b in 0..ROOT_LOADS {
                    for i in 0..size {
                        for j in 0..size {
                            sum[(a * size + i, b * size + j)] +=
                                around * target[a][b] * projected[i] * projected[j];
                        }
                    }
                }
            }
        }
        sum
    }

    /// Fourier coefficients of the three root loads of a tooth at theta = 0, arranged so that the
    /// displacement conjugate to a under b is v_a' C v_b (N with the factor i).
    fn shapes(&self, n: i32) -> [Vector2<f64>; ROOT_LOADS] {
        let a = self.half_angle;
        let r = self.annulus.loaded;
        let order = f64::from(n.abs());
        // Integrals over -a..a of cos(m t), and from them of the products below.
        let c = |m: f64| {
            if m == 0.0 {
                2.0 * a
            } else {
                2.0 * (m * a).sin() / m
            }
        };
        let cos_cos = 0.5 * (c(order - 1.0) + c(order + 1.0));
        let sin_sin = 0.5 * (c(order - 1.0) - c(order + 1.0));
        // cos t sin t sin nt and sin^2 t cos nt.
        let half_sin2_sin = 0.25 * (c(order - 2.0) - c(order + 2.0));
        let sin2_cos = 0.5 * c(order) - 0.25 * (c(order - 2.0) + c(order + 2.0));
        let uniform = 1.0 / (2.0 * a * r * 2.0 * std::f64::consts::PI);
        let linear = 1.0 / (r * r * (a - 0.5 * (2.0 * a).sin()) * 2.0 * std::f64::consts::PI);
        let sign = if n < 0 { -1.0 } else { 1.0 };
        [
            // Traction along +theta of the tooth: (sin t, cos t) radially and tangentially.
            self.cos_beta * uniform * Vector2::new(sin_sin, -cos_cos),
            // Traction -kappa sin t along the tooth: radially times cos t, tangentially times -sin t.
            self.cos_beta * -self.kappa * linear * Vector2::new(half_sin2_sin, sin2_cos),
            // Traction -kappa along the tooth: (cos t, -sin t).
            sign * self.kappa * uniform * Vector2::new(cos_cos, -sin_sin),
        ]
    }

    /// Flexibility for the wave number `k` (rad/m) along the face. Long waves are those of the plane
    /// problem, short ones those of a half-space, where normal flexibility is (1 - nu) / (G q) for the
    /// wave number q = sqrt(q_n^2 + k^2) and tangential the same times
    /// (1 + nu / (1 - nu) (k / q)^2). q_n is the wave number of the half-plane as flexible as the
    /// ring at this harmonic.
    fn along_the_face(&self, c: &Matrix2<f64>, k: f64) -> Matrix2<f64> {
        let half_plane = (self.annulus.kolosov + 1.0) / (4.0 * self.annulus.shear_modulus);
        let ratio = |flexibility: f64| (k * flexibility / half_plane).powi(2);
        let (radial, tangential) = (ratio(c[(0, 0)]), ratio(c[(1, 1)]));
        let nu = self.poisson_ratio;
        let scale = Vector2::new(
            (1.0 + radial).powf(-0.25),
            ((1.0 + nu / (1.0 - nu) * tangential / (1.0 + tangential)) / (1.0 + tangential).sqrt())
                .sqrt(),
        );
        Matrix2::from_fn(|i, j| c[(i, j)] * scale[i] * scale[j])
    }
}
