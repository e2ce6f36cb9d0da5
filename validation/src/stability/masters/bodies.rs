//! What hangs on the gears: linear bodies along the line of action.

use super::packed::Packed;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Linear bodies and the meshes between them.
#[derive(Clone)]
pub struct Bodies {
    pub name: &'static str,
    pub(super) mass: DVector<f64>,
    pub(super) stiffness: DMatrix<f64>,
    pub(super) damping: DMatrix<f64>,
    /// Columns: meshes.
    pub(super) meshes: DMatrix<f64>,
    pub(super) load: DVector<f64>,
    /// Mesh frequency, or those between which a sweep goes up and down, over that of the mode.
    pub(super) sweep: Option<[f64; 2]>,
    /// More than both gears hangs on the meshes: errors may be larger.
    pub train: bool,
}

impl Bodies {
    fn new(name: &'static str, mass: &[f64], meshes: &[(usize, &[(usize, f64)])]) -> Self {
        let n = mass.len();
        let mut all = DMatrix::zeros(n, meshes.len());
        for (mesh, parts) in meshes {
            for (body, sign) in *parts {
                all[(*body, *mesh)] = *sign;
            }
        }
        Self {
            name,
            mass: DVector::from_row_slice(mass),
            stiffness: DMatrix::zeros(n, n),
            damping: DMatrix::zeros(n, n),
            meshes: all,
            load: DVector::zeros(n),
            sweep: None,
            train: false,
        }
    }

    /// A spring of `stiffness`, N/m, and a damping ratio with the `mass` it carries, kg, between two bodies or to the ground.
    fn spring(mut self, ends: &[(usize, f64)], stiffness: f64, zeta: f64, mass: f64) -> Self {
        let mut row = DVector::zeros(self.mass.len());
        for (body, sign) in ends {
            row[*body] = *sign;
        }
        let square = &row * row.transpose();
        self.damping += &square * (2.0 * zeta * (stiffness * mass).sqrt());
        self.stiffness += square * stiffness;
        self
    }

    fn loaded(mut self, loads: &[(usize, f64)]) -> Self {
        for (body, load) in loads {
            self.load[*body] = *load;
        }
        self
    }

    /// Both gears alone.
    pub fn pair(p: &Packed) -> Self {
        let (m, load) = (p.gear(), p.load);
        Self::new("pair", &[m, m], &[(0, &[(0, 1.0), (1, -1.0)])]).loaded(&[(0, load), (1, -load)])
    }

    /// The same of `share` of the packed mass.
    pub fn weighing(p: &Packed, share: f64) -> Self {
        let mut bodies = Self::pair(p);
        bodies.mass *= share;
        bodies
    }

    /// The same through the resonance with separation and back.
    pub fn swept(p: &Packed) -> Self {
        let mut bodies = Self::pair(p);
        (bodies.name, bodies.sweep) = ("run-up and run-down", Some([0.6, 1.1]));
        bodies
    }

    /// Two stages with a shaft of `torsion` N m/rad between them.
    pub fn stages(p: &Packed, name: &'static str, torsion: f64, zeta: f64) -> Self {
        let (m, load) = (p.gear(), p.load);
        let meshes: [(usize, &[(usize, f64)]); 2] =
            [(0, &[(0, 1.0), (1, -1.0)]), (1, &[(2, 1.0), (3, -1.0)])];
        let shaft = torsion / p.base_radius.powi(2);
        let mut bodies = Self::new(name, &[m; 4], &meshes)
            .spring(&[(1, 1.0), (2, -1.0)], shaft, zeta, 0.5 * m)
            .loaded(&[(0, load), (3, -load)]);
        bodies.train = true;
        bodies
    }

    /// Both gears spin, and modes on bearings of damping ratio 0.0006 move the mesh besides.
    pub fn bearings(p: &Packed) -> Self {
        let (m, load) = (p.gear(), p.load);
        let masses = [m, m, 2.0 * m, 2.0 * m, 2.0 * m, 2.0 * m, 2.0 * m];
        let parts = [1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let parts: Vec<(usize, f64)> = parts.into_iter().enumerate().collect();
        let mut bodies =
            Self::new("bearings", &masses, &[(0, &parts)]).loaded(&[(0, load), (1, -load)]);
        for (body, hertz) in [(2, 2e3), (3, 5e3), (4, 9e3), (5, 20e3), (6, 33e3)] {
            let stiffness = 2.0 * m * (TAU * hertz).powi(2);
            bodies = bodies.spring(&[(body, 1.0)], stiffness, 6e-4, 2.0 * m);
        }
        bodies.train = true;
        bodies
    }

    /// A sun, three planets on pins in a heavy carrier, and a ring that stands: six meshes, which start with the flanks in touch
    /// that will carry, or at the ring with the others, so that the planets first cross the backlash.
    pub fn planetary(p: &Packed, name: &'static str, crossing: bool) -> Self {
        const PLANETS: usize = 3;
        let (m, load) = (p.gear(), p.load);
        // Sun, spin of the planets, their way with the carrier, carrier.
        let carrier = 2 * PLANETS + 1;
        let mut masses = vec![m; 1 + PLANETS];
        masses.extend([1.4 * m; PLANETS]);
        masses.push(10.0 * m);
        let ring = if crossing { -1.0 } else { 1.0 };
        let parts: Vec<Vec<(usize, f64)>> = (0..PLANETS)
            .map(|i| vec![(0, 1.0), (1 + i, -1.0), (1 + PLANETS + i, -1.0)])
            .chain((0..PLANETS).map(|i| vec![(1 + i, ring), (1 + PLANETS + i, -ring)]))
            .collect();
        let meshes: Vec<(usize, &[(usize, f64)])> = parts
            .iter()
            .enumerate()
            .map(|(j, parts)| (j, &parts[..]))
            .collect();
        let loads = [(0, 3.0 * load), (carrier, -6.0 * load)];
        let mut bodies = Self::new(name, &masses, &meshes).loaded(&loads);
        for i in 0..PLANETS {
            let ends = [(1 + PLANETS + i, 1.0), (carrier, -1.0)];
            bodies = bodies.spring(&ends, 2e8, 2e-3, 1.4 * m);
        }
        bodies.train = true;
        bodies
    }
}

/// Everything that hangs on the gears.
pub fn systems(p: &Packed) -> Vec<Bodies> {
    vec![
        Bodies::pair(p),
        Bodies::swept(p),
        Bodies::stages(p, "two stages, 3.35e5 N m/rad, 0.5 %", 3.35e5, 5e-3),
        Bodies::stages(p, "two stages, 1e7 N m/rad, 0.1 %", 1e7, 1e-3),
        Bodies::stages(p, "two stages, 2e7 N m/rad, 2 %", 2e7, 2e-2),
        Bodies::bearings(p),
        Bodies::planetary(p, "planetary", false),
        Bodies::planetary(p, "planetary across its backlash", true),
    ]
}
