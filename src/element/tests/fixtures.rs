//! Pairs and poses for the tests of the element.

use super::*;
use crate::friction::{FrictionLaw, Sliding};
use crate::gear::samples::{gear, thinned};
use crate::gear::teeth::Counts;
use crate::gear::{BodyOrder, BodyOrders, GearKind, PairGeometry, involute};
use crate::random::Random;
use crate::root::bisection;
use crate::table::samples::Spring;
use crate::table::{
    FrictionRecord, LoadAxes, Potential, Query, RootStressError, RootStressRecord,
    RootStressSamples, SlidingSamples, TableFile,
};

#[path = "../../../tests/common/element.rs"]
mod shared;
pub(crate) use shared::*;

/// External, internal and ring as gear 1, helical, with profile shifts and tooth thinning, gear 1 of
/// `hand`; the centre distances leave backlash.
pub(crate) fn three_pairs(hand: f64) -> [PairGeometry; 3] {
    use GearKind::{External, Ring};
    let mut pairs = [
        [(External, 20, hand, 0.2), (External, 31, -hand, 0.1)],
        [(External, 20, hand, 0.2), (Ring, 61, hand, 0.25)],
        [(Ring, 61, hand, 0.25), (External, 20, hand, 0.2)],
    ]
    .map(|both| {
        let gears = both.map(|(kind, teeth, hand, shift)| gear(kind, teeth, hand, 13.0, shift));
        let pair = PairGeometry {
            gears,
            center_distance: 0.0,
        };
        thinned(pair, 20e-6)
    });
    for pair in &mut pairs {
        // inv phi = inv phi_0: the centre distance without backlash but for the thinning.
        let target = pair.backlash_free_involute();
        let phi = bisection([0.2, 0.6], 80, |phi| involute(phi) < target);
        pair.center_distance = pair.base_radius_sum() / phi.cos();
    }
    pairs
}

/// Deterministic numbers in [-1, 1).
pub(crate) struct Noise(Random);

impl Noise {
    /// A sequence of its own for every seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self(Random::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1))
    }

    /// The next number.
    pub(crate) fn next(&mut self) -> f64 {
        self.0.within([-1.0, 1.0])
    }

    /// A vector with every component in [-scale, scale).
    pub(crate) fn vector(&mut self, scale: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| scale * self.next())
    }
}

/// Both formulations with [`three_pairs`] each.
pub(crate) fn formulations_and_pairs(hand: f64) -> Vec<(Formulation, PairGeometry)> {
    let with_pairs = |f| three_pairs(hand).map(|pair| (f, pair));
    FORMULATIONS.into_iter().flat_map(with_pairs).collect()
}

/// One flank alone, with the sign and the index of it.
pub(crate) const SINGLE_FLANKS: [(LoadedFlank, f64, usize); 2] =
    [(LoadedFlank::Drive, 1.0, 0), (LoadedFlank::Coast, -1.0, 1)];

/// The element of `pair` with them.
pub(crate) fn constant(
    pair: &PairGeometry,
    formulation: Formulation,
    flank: LoadedFlank,
) -> Element {
    Element::new(pair, &undamped(formulation, flank), None).unwrap()
}

/// The element of `pair` with `parameters`, which need no table.
pub(crate) fn made(pair: &PairGeometry, parameters: &Parameters) -> Element {
    Element::new(pair, parameters, None).unwrap()
}

/// The element of `pair` under [`DRIVE`], mirrored on the coast flank, with all effects, undamped.
pub(crate) fn smooth(pair: &PairGeometry, formulation: Formulation, flank: LoadedFlank) -> Element {
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        ..undamped(formulation, flank)
    };
    Element::with_laws(pair, &parameters, Arc::new(DRIVE), None).unwrap()
}

/// Orders of both bodies of a pair that change the compliance of a [`Spring`] by up to `share` of itself, other ones on either flank.
pub(crate) fn body_orders(share: f64) -> BodyOrders {
    let part = |order: u32, size: f64| BodyOrder {
        order,
        approach_m_per_n: [4e-9, 3e-9].map(|x| x * share * size),
        tilt_rad_per_n: [20e-9, -10e-9].map(|x| x * share * size),
        tilt_rad_per_nm: [-3e-6, 2e-6].map(|x| x * share * size),
    };
    BodyOrders {
        drive: [vec![part(3, 1.0), part(20, 0.3)], vec![part(2, -0.8)]],
        coast: [vec![part(3, 0.9)], vec![part(2, 0.5), part(4, 0.7)]],
    }
}

/// The element of `pair` on a table of [`Spring`]s with these bodies, undamped.
pub(crate) fn with_bodies(
    pair: &PairGeometry,
    bodies: BodyOrders,
    formulation: Formulation,
    flank: LoadedFlank,
) -> Element {
    let mut file = spring_file(pair, [100.0, 200.0], [8, 5, 5, 12]);
    file.bodies = Some(bodies);
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        body_effect: true,
        ..undamped(formulation, flank)
    };
    Element::new(pair, &parameters, Some(sealed(file))).unwrap()
}

/// That of the paper's pair on one flank, with `damping`.
pub(crate) fn damped(formulation: Formulation, damping: f64) -> Element {
    let mut element = constant(&paper_pair(1.0), formulation, LoadedFlank::Drive);
    element.set_damping(damping);
    element
}

/// What is refused, in words.
pub(crate) fn refusal(made: Result<Element, ElementError>) -> String {
    made.err().map(|error| error.to_string()).expect("accepted")
}

/// The phases of the nominal pose.
pub(crate) fn nominal_phase(element: &Element) -> PhaseOffset {
    element.phase_offset(&element.nominal_inputs()).unwrap()
}

/// Random velocities of both gears up to `v` and `w`.
pub(crate) fn set_velocities(inputs: &mut Inputs, noise: &mut Noise, v: f64, w: f64) {
    for m in &mut inputs.gears {
        (m.v, m.w) = (noise.vector(v), noise.vector(w));
    }
}

/// Work of the contact over the elliptic loop in the freedoms `i` and `j` (0-11: translation and
/// rotation of gear 1, then of gear 2) with these amplitudes, and the mean energy on it.
pub(crate) fn loop_work(
    element: &Element,
    start: &Inputs,
    i: usize,
    j: usize,
    size: [f64; 2],
) -> (f64, f64) {
    let phase = nominal_phase(element);
    let points = 96;
    let (mut work, mut energy) = (0.0, 0.0);
    for n in 0..points {
        // Trapezoidal rule: of spectral accuracy on a smooth closed loop.
        let t = TAU * f64::from(n) / f64::from(points);
        let mut x = [0.0; 12];
        let mut rate = [0.0; 12];
        x[i] += size[0] * t.cos();
        rate[i] -= size[0] * t.sin();
        x[j] += size[1] * t.sin();
        rate[j] += size[1] * t.cos();
        let mut inputs = *start;
        for (body, m) in inputs.gears.iter_mut().enumerate() {
            let part =
                |v: &[f64; 12], k: usize| Vector3::from_column_slice(&v[6 * body + k..][..3]);
            m.p += part(&x, 0);
            let turn = part(&x, 3);
            m.r = Rotation3::new(turn).matrix() * m.r;
            m.v = part(&rate, 0);
            // Rate of a rotation vector to angular velocity, to third order in it (1e-16 here).
            let turn_rate = part(&rate, 3);
            let bracket = turn.cross(&turn_rate);
            m.w = turn_rate + bracket / 2.0 + turn.cross(&bracket) / 6.0;
        }
        let out = element.evaluate(&phase, &inputs).unwrap();
        assert_ne!(out.flank, 0, "the loop must stay in contact");
        work += power(&out, &inputs);
        energy += out.energy;
    }
    let step = TAU / f64::from(points);
    (work * step, energy / f64::from(points))
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

/// The nominal pose with gear 1 turned so far that its flank `s` is compressed by `delta` (m, line of
/// action) against the touching pose.
pub(crate) fn compressed(element: &Element, s: f64, delta: f64) -> Inputs {
    spun(
        &element.nominal_inputs(),
        0,
        s * delta / element.constants.base_radius[0],
    )
}

/// A pose with tilts of +-3 mrad, +-0.3 mm radial and +-1 mm axial displacement, turned to anywhere in mesh: the
/// flanks are at most a tenth of a pitch from the middle of the gap.
pub(crate) fn random_pose(element: &Element, noise: &mut Noise) -> Inputs {
    let mut inputs = element.nominal_inputs();
    let k = &element.constants;
    let turn = 3.0 * noise.next();
    let spins = [
        turn,
        (0.1 * TAU * noise.next() - k.z[0] * turn) * k.e / k.z[1],
    ];
    for (m, spin) in inputs.gears.iter_mut().zip(spins) {
        let shift = noise.vector(1.0);
        m.p += Vector3::new(0.15e-3 * shift.x, 0.15e-3 * shift.y, 0.5e-3 * shift.z);
        let tilt = Rotation3::from_euler_angles(3e-3 * noise.next(), 3e-3 * noise.next(), 0.0);
        let spin = Rotation3::from_axis_angle(&Vector3::z_axis(), spin);
        m.r = *(tilt * spin).matrix();
    }
    inputs
}

/// A smooth potential in all four coordinates with closed derivatives, near a real table in size:
/// with x = delta + M z(tau) - d(tau, M) and k = k0 (1 + a sin 2 pi tau)(1 - b C),
/// W = k x^3 / (3 l) for x > 0.
pub(crate) struct Smooth {
    /// Mean of z(tau), m.
    pub lever: f64,
    /// k0, N/m.
    pub stiffness: f64,
}

impl Elasticity for Smooth {
    fn evaluate(&self, q: &Query, _: Counts, _: bool) -> Result<Potential, String> {
        const LENGTH: f64 = 10e-6;
        let (m, c) = (q.misalignment, q.center_distance_offset);
        let (sine, cosine) = (TAU * q.mesh_position).sin_cos();
        let lever = 4e-3 * cosine + self.lever;
        let x = (q.delta + m * lever - (0.5e-6 * sine + 0.2 * m * m + 1e-6)).max(0.0);
        let [swing, nearness] = [1.0 + 0.2 * sine, 1.0 - 500.0 * c];
        let k = self.stiffness * swing * nearness;
        let (force, cubic) = (k * x * x / LENGTH, x * x * x / (3.0 * LENGTH));
        let mut w = Potential {
            value: k * cubic,
            gradient: [
                force,
                -500.0 * self.stiffness * swing * cubic,
                force * (lever - 0.4 * m),
                TAU * (0.2 * cosine * self.stiffness * nearness * cubic
                    - force * (4e-3 * m * sine + 0.5e-6 * cosine)),
            ],
            ..Potential::default()
        };
        w.hessian[0][0] = 2.0 * k * x / LENGTH;
        Ok(w)
    }
}

/// The law of one flank.
pub(crate) const DRIVE: Smooth = Smooth {
    lever: 1e-3,
    stiffness: 4.7e8,
};

/// Another, for the flank across.
pub(crate) const COAST: Smooth = Smooth {
    lever: -2.5e-3,
    stiffness: 3.8e8,
};

/// Stress in the roots, Pa, of gear 1 and gear 2 at (force, centre distance offset, misalignment, mesh
/// position) in [`rubbing_table`]; of the drive flank with `k` = 1.
pub(crate) fn stress_by_formula([f, c, m, p]: [f64; 4], k: f64) -> [f64; 2] {
    let near = 1.0 + 500.0 * c + 40.0 * k * m + 1e-5 * f;
    [0.0, 1.0].map(|gear| 2e4 * f * near * (1.0 + 0.3 * k * (TAU * p + gear).cos()))
}

/// `f` at (force, centre distance offset, misalignment, mesh position) everywhere on `axes`, in the order of tables.
fn over<R>(axes: &LoadAxes, f: impl Fn([f64; 4]) -> R) -> Vec<R> {
    let mut all = vec![];
    for &c in &axes.center_distance_offset_m {
        for &m in &axes.misalignment_rad {
            for &force in &axes.loa_force_n {
                all.extend(axes.mesh_position.iter().map(|p| f([force, c, m, *p])));
            }
        }
    }
    all
}

/// The table of a spring known by formula with `counts` nodes, for `pair`; its torques are those given.
pub(crate) fn spring_file(pair: &PairGeometry, torques: [f64; 2], counts: [usize; 4]) -> TableFile {
    let grid = Spring::grid(counts);
    TableFile::new("spring", "a formula", pair, torques, &grid, None)
}

/// The sealed table of `file`.
pub(crate) fn sealed(mut file: TableFile) -> Arc<Table> {
    file.seal();
    Arc::new(Table::from_file(file).unwrap())
}

/// Springs as in [`crate::table::samples`], and sliding and root stress by smooth functions, of `pair`; whether the
/// coast flank has its own.
pub(crate) fn rubbing_table(pair: &PairGeometry, law: FrictionLaw, own_coast: bool) -> Arc<Table> {
    const COUNTS: [usize; 4] = [8, 5, 5, 12];
    let grid = Spring::grid(COUNTS);
    let mut file = spring_file(pair, [100.0, 200.0], COUNTS);
    let mut axes = LoadAxes {
        center_distance_offset_m: grid.axes.center_distance_offset.clone(),
        misalignment_rad: grid.axes.misalignment.clone(),
        loa_force_n: [0.05, 0.2, 0.5, 1.0].map(|x| x * grid.top_force()).to_vec(),
        mesh_position: (0..24).map(|i| f64::from(i) / 24.0).collect(),
    };
    let samples = |k: f64| {
        let all = over(&axes, |[f, c, m, p]| {
            let near = 1.0 + 500.0 * c + 40.0 * m + 0.1 * f / grid.top_force();
            let (sin, cos) = (TAU * p).sin_cos();
            Sliding {
                weight: 0.04 + 0.01 * k * cos * near,
                share: 0.8 * k * cos * near,
                share_z: 2e-3 * sin * near,
                distance: 3e-3 + 1e-3 * k * sin * near,
            }
        });
        SlidingSamples::new(&all, law.is_local())
    };
    file.friction = Some(FrictionRecord {
        law,
        drive: samples(1.0),
        coast: own_coast.then(|| samples(-0.7)),
        axes: axes.clone(),
    });
    axes.loa_force_n[0] = 0.0;
    let stresses = |k| RootStressSamples::new(&over(&axes, |x| stress_by_formula(x, k)));
    file.root_stress = Some(RootStressRecord {
        drive: stresses(1.0),
        coast: own_coast.then(|| stresses(-0.7)),
        axes: axes.clone(),
        interpolation_error: RootStressError::default(),
    });
    sealed(file)
}

/// A law of each kind.
pub(crate) const LAWS: [FrictionLaw; 3] = [
    FrictionLaw::Constant { coefficient: 0.07 },
    FrictionLaw::Schlenk {
        dynamic_viscosity_pa_s: 20e-3,
        roughness_ra_m: 0.4e-6,
        lubricant_factor: 0.846,
    },
    FrictionLaw::XuKahraman {
        dynamic_viscosity_pa_s: 20e-3,
        roughness_rms_m: 0.5e-6,
    },
];

/// Parameters of an element with friction.
pub(crate) fn rubbing(formulation: Formulation, loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        stiffness_model: StiffnessModel::Table,
        friction: true,
        ..undamped(formulation, loaded_flank)
    }
}
