//! Pairs and poses for the tests of the element.

use super::{Elasticity, Element, FlankLaws, Inputs, Motion};
use crate::gear::{Gear, GearKind, PairGeometry};
use crate::table::{Potential, Query};
use nalgebra::{Rotation3, Vector3};
use num_dual::{DualNum, HyperDual64};
use std::f64::consts::TAU;

fn gear(kind: GearKind, teeth: u32, hand: f64, shift: f64) -> Gear {
    let kappa = if kind == GearKind::Ring { -1.0 } else { 1.0 };
    let helix = 13f64.to_radians();
    let reference = 0.5 * f64::from(teeth) * 4e-3 / helix.cos();
    Gear {
        kind,
        teeth,
        hand,
        normal_module: 4e-3,
        normal_pressure_angle: 20f64.to_radians(),
        helix_angle: helix,
        profile_shift: shift,
        face_width: 25e-3,
        face_offset: 0.0,
        tip_radius: reference + (kappa + shift) * 4.105e-3,
        dedendum_coefficient: 1.25,
        tool_tip_radius_coefficient: 0.38,
        held_radius: if kappa > 0.0 {
            15e-3
        } else {
            reference + 20e-3
        },
        tooth_thinning: 0.0,
        youngs_modulus: 206e9,
        poisson_ratio: 0.3,
    }
}

/// The paper's pair, Table 1, with gear 1 of `hand`.
pub(crate) fn paper_pair(hand: f64) -> PairGeometry {
    PairGeometry {
        gears: [
            gear(GearKind::External, 20, hand, 0.0),
            gear(GearKind::External, 20, -hand, 0.0),
        ],
        center_distance: 82.104e-3,
    }
}

/// External, internal and ring as gear 1, helical, with profile shifts and tooth thinning, gear 1 of
/// `hand`; the centre distances leave backlash.
pub(crate) fn three_pairs(hand: f64) -> [PairGeometry; 3] {
    use GearKind::{External, Ring};
    let mut pairs = [
        [
            gear(External, 20, hand, 0.2),
            gear(External, 31, -hand, 0.1),
        ],
        [gear(External, 20, hand, 0.2), gear(Ring, 61, hand, 0.25)],
        [gear(Ring, 61, hand, 0.25), gear(External, 20, hand, 0.2)],
    ]
    .map(|gears| PairGeometry {
        gears,
        center_distance: 0.0,
    });
    for pair in &mut pairs {
        for g in &mut pair.gears {
            g.tooth_thinning = 20e-6;
        }
        // inv phi = inv phi_0 by bisection: the centre distance without backlash but for the thinning.
        let target = pair.backlash_free_involute();
        let (mut low, mut high) = (0.2f64, 0.6f64);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if crate::gear::involute(middle) < target {
                low = middle;
            } else {
                high = middle;
            }
        }
        pair.center_distance = pair.base_radius_sum() / low.cos();
    }
    pairs
}

/// Deterministic numbers in [-1, 1).
pub(crate) struct Noise(u64);

impl Noise {
    /// A sequence of its own for every seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// The next number.
    pub(crate) fn next(&mut self) -> f64 {
        // xorshift64* (Vigna 2016).
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11;
        bits as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A vector with every component in [-scale, scale).
    pub(crate) fn vector(&mut self, scale: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| scale * self.next())
    }
}

/// The rigid motion of the world: everything in `inputs` turned by `r` and moved by `p`.
pub(crate) fn moved(inputs: &Inputs, r: &Rotation3<f64>, p: &Vector3<f64>) -> Inputs {
    let turn = |m: &Motion| Motion {
        p: r * m.p + p,
        r: r.matrix() * m.r,
        v: r * m.v,
        w: r * m.w,
    };
    Inputs {
        gears: [turn(&inputs.gears[0]), turn(&inputs.gears[1])],
        carrier: turn(&inputs.carrier),
    }
}

/// Gear `i` turned by `angle` about its own axis.
pub(crate) fn spun(inputs: &Inputs, i: usize, angle: f64) -> Inputs {
    let mut out = *inputs;
    out.gears[i].r *= Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix();
    out
}

/// The nominal pose with gear 1 turned so far that its flank `s` is compressed by `delta` (m, line of
/// action) against the touching pose.
pub(crate) fn compressed(element: &Element, s: f64, delta: f64) -> Inputs {
    spun(
        &element.nominal_inputs(),
        0,
        s * delta / element.constants.rb[0],
    )
}

/// A pose with tilts of +-3 mrad, +-0.3 mm radial and +-1 mm axial displacement and arbitrary spins.
pub(crate) fn random_pose(element: &Element, noise: &mut Noise) -> Inputs {
    let mut inputs = element.nominal_inputs();
    for m in &mut inputs.gears {
        let shift = noise.vector(1.0);
        m.p += Vector3::new(0.15e-3 * shift.x, 0.15e-3 * shift.y, 0.5e-3 * shift.z);
        let tilt = Rotation3::from_euler_angles(3e-3 * noise.next(), 3e-3 * noise.next(), 0.0);
        let spin = Rotation3::from_axis_angle(&Vector3::z_axis(), 3.0 * noise.next());
        m.r = *(tilt * spin).matrix();
    }
    inputs
}

/// A smooth potential in all four coordinates with closed derivatives, near a real table in size:
/// with x = delta + M z(tau) - d(tau, M) and k = k0 (1 + a sin 2 pi tau)(1 - b C),
/// W = k x^3 / (3 l) for x > 0.
pub(crate) struct Smooth;

impl Elasticity for Smooth {
    fn evaluate(&self, q: &Query, _want_hessian: bool) -> Potential {
        type D = HyperDual64;
        let at = [
            q.delta,
            q.center_distance_offset,
            q.misalignment,
            q.mesh_position,
        ];
        let energy = |v: [D; 4]| {
            let [delta, c, m, tau] = v;
            let (sine, cosine) = (tau * TAU).sin_cos();
            let x = delta + m * (cosine * 4e-3 + 1e-3) - (sine * 0.5e-6 + m * m * 0.2 + 1e-6);
            let k = (sine * 0.2 + 1.0) * (-c * 500.0 + 1.0) * 4.7e8;
            if x.re > 0.0 {
                k * x * x * x / (3.0 * 10e-6)
            } else {
                D::from(0.0)
            }
        };
        let mut w = Potential::default();
        for i in 0..4 {
            for j in 0..4 {
                let mut v = at.map(D::from_re);
                v[i].eps1 = 1.0;
                v[j].eps2 = 1.0;
                let y = energy(v);
                w.value = y.re;
                w.gradient[i] = y.eps1;
                w.hessian[i][j] = y.eps1eps2;
            }
        }
        w
    }
}

/// [`Smooth`] on both flanks, mirrored on the coast flank.
pub(crate) fn smooth_laws() -> FlankLaws {
    FlankLaws {
        drive: std::sync::Arc::new(Smooth),
        coast: None,
    }
}
