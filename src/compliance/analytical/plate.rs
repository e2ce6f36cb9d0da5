//! The tooth as a tapered Mindlin plate that stands on its root, by Ritz's method.
//!
//! Height x from the root, length s along the tooth. Deflection w in the sense of the push, rotations psi_x
//! and psi_s of the normal, compression u towards the root (a membrane of its own, uncoupled). The trial
//! functions are powers of the height times Legendre polynomials along the face. Some of them move the root:
//! w = P_j, (w, psi_x) = (x P_j, P_j) and u = P_j, the root motions conjugate to the root loads of
//! [`super::base`]; in the others it stands still.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::base::ROOT_LOADS;
use super::legendre::{Legendre, gauss_points};

/// Powers of the height in each field.
const POWERS: usize = 4;
/// Gauss points over the height: the thickness is smooth but for the end of the fillet.
const HEIGHT_POINTS: usize = 24;
/// Shear correction of a rectangular section.
const SHEAR_CORRECTION: f64 = 5.0 / 6.0;

/// Elastic constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson ratio.
    pub poisson_ratio: f64,
}

impl Material {
    /// Shear modulus, Pa.
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.youngs_modulus / (1.0 + self.poisson_ratio)
    }
}

/// A point load on the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateLoad {
    /// Height above the root section, m; the part below acts on the root alone.
    pub height: f64,
    /// Fraction of the length.
    pub fraction: f64,
    /// Component normal to the plate.
    pub push: f64,
    /// Component towards the root.
    pub press: f64,
}

/// What a load does to the tooth, ready for products.
#[derive(Debug, Clone)]
pub struct LoadVector {
    /// Two loads' product is the deflection of one under the other over a fixed root.
    pub tooth: DVector<f64>,
    /// Generalised root loads (load x polynomial).
    pub root: DVector<f64>,
}

/// The factored plate.
#[derive(Debug, Clone)]
pub struct Plate {
    legendre: Legendre,
    scale: f64,
    /// Height of the root load V above the root section, m (slightly below zero).
    root_offset: f64,
    factor: Cholesky<f64, Dyn>,
    /// Root loads that a unit of each clamped function's load passes on.
    passed_on: DMatrix<f64>,
    /// Stiffness of the plate against root motions that vary along the face.
    root_stiffness: DMatrix<f64>,
}

/// Fields of the clamped functions, in this order, each with its lowest power.
const CLAMPED_FIELDS: [(Field, usize); 4] = [
    (Field::Deflection, 1),
    (Field::RotationX, 1),
    (Field::RotationS, 0),
    (Field::Compression, 1),
];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Field {
    Deflection,
    RotationX,
    RotationS,
    Compression,
    /// w = x, psi_x = 1.
    RootTurn,
}

/// Strains: curvatures xx, ss, xs, shears x, s, compressions x, s.
const STRAINS: usize = 7;

/// Factor of each strain for a function of the height (value, slope), and whether it goes with the
/// polynomial (0) or its derivative (1).
fn strains(field: Field, value: f64, slope: f64, x: f64) -> [[f64; STRAINS]; 2] {
    let mut s = [[0.0; STRAINS]; 2];
    match field {
        Field::Deflection => {
            s[0][3] = slope;
            s[1][4] = value;
        }
        Field::RotationX => {
            s[0][0] = slope;
            s[1][2] = value;
            s[0][3] = -value;
        }
        Field::RotationS => {
            s[1][1] = value;
            s[0][2] = slope;
            s[0][4] = -value;
        }
        Field::Compression => {
            s[0][5] = slope;
            s[1][6] = value;
        }
        // Slope of w and rotation cancel in the shear.
        Field::RootTurn => {
            s[1][2] = 1.0;
            s[1][4] = x;
        }
    }
    s
}

impl Plate {
    /// A plate of `height` (m) and `thickness(x)` (m), along the polynomials of `legendre`. The root load V
    /// acts `root_offset` above the root section.
    pub fn new(
        height: f64,
        thickness: impl Fn(f64) -> f64,
        root_offset: f64,
        material: &Material,
        legendre: Legendre,
    ) -> Plate {
        let n = legendre.len();
        let mut functions: Vec<(Field, Option<usize>)> = CLAMPED_FIELDS
            .iter()
            .flat_map(|&(field, low)| (low..low + POWERS).map(move |power| (field, Some(power))))
            .collect();
        let clamped = functions.len();
        functions.push((Field::Deflection, Some(0)));
        functions.push((Field::RootTurn, None));
        functions.push((Field::Compression, Some(0)));
        let products = legendre.products();
        let mut k = DMatrix::<f64>::zeros(functions.len() * n, functions.len() * n);
        for (point, weight) in gauss_points(HEIGHT_POINTS) {
            let x = 0.5 * height * (1.0 + point);
            let w = 0.5 * height * weight;
            let c = elasticity(thickness(x), material);
            let strain: Vec<_> = functions
                .iter()
                .map(|&(field, power)| {
                    let (value, slope) =
                        power.map_or((0.0, 0.0), |p| height_function(x / height, p));
                    strains(field, value, slope / height, x - root_offset)
                })
                .collect();
            for (a, ea) in strain.iter().enumerate() {
                for (b, eb) in strain.iter().enumerate() {
                    for (i, ei) in ea.iter().enumerate() {
                        for (j, ej) in eb.iter().enumerate() {
                            let energy = w * contract(&c, ei, ej);
                            if energy != 0.0 {
                                let mut block = k.view_mut((a * n, b * n), (n, n));
                                block += &products[i][j] * energy;
                            }
                        }
                    }
                }
            }
        }
        let (nc, nr) = (clamped * n, ROOT_LOADS * n);
        let factor = Cholesky::new(k.view((0, 0), (nc, nc)).into_owned())
            .expect("a clamped plate of positive thickness is stiff");
        let coupling = k.view((0, nc), (nc, nr)).into_owned();
        let relaxed = factor.solve(&coupling);
        let root_stiffness = k.view((nc, nc), (nr, nr)) - coupling.transpose() * &relaxed;
        Plate {
            legendre,
            scale: height,
            root_offset,
            factor,
            passed_on: relaxed.transpose(),
            root_stiffness: 0.5 * (&root_stiffness + root_stiffness.transpose()),
        }
    }

    /// Stiffness against root motions, N/m: load x polynomial. Zero where the whole tooth moves rigidly.
    pub fn root_stiffness(&self) -> &DMatrix<f64> {
        &self.root_stiffness
    }

    /// The load vector of `load`.
    pub fn load(&self, load: &PlateLoad) -> LoadVector {
        let along = self.legendre.at(load.fraction);
        let n = along.len();
        let x = (load.height / self.scale).max(0.0);
        let mut clamped = DVector::zeros(self.passed_on.ncols());
        let mut function = 0;
        for (field, low) in CLAMPED_FIELDS {
            for power in low..low + POWERS {
                let component = match field {
                    Field::Deflection => load.push,
                    Field::Compression => load.press,
                    _ => 0.0,
                };
                if component != 0.0 {
                    let value = component * height_function(x, power).0;
                    for (j, (p, _)) in along.iter().enumerate() {
                        clamped[function * n + j] = value * p;
                    }
                }
                function += 1;
            }
        }
        let lever = load.push * (load.height - self.root_offset);
        let mut root = -(&self.passed_on * &clamped);
        for (j, (p, _)) in along.iter().enumerate() {
            root[j] += load.push * p;
            root[n + j] += lever * p;
            root[2 * n + j] += load.press * p;
        }
        self.factor
            .l_dirty()
            .solve_lower_triangular_mut(&mut clamped);
        LoadVector {
            tooth: clamped,
            root,
        }
    }
}

/// x^power over the relative height, and its slope.
fn height_function(x: f64, power: usize) -> (f64, f64) {
    if power == 0 {
        return (1.0, 0.0);
    }
    let low = x.powi(power as i32 - 1);
    (low * x, power as f64 * low)
}

/// Stiffness of each strain at the thickness `t`; index 7 couples the two curvatures.
fn elasticity(t: f64, material: &Material) -> [f64; STRAINS + 1] {
    let nu = material.poisson_ratio;
    let plane = material.youngs_modulus / (1.0 - nu * nu);
    let g = material.shear_modulus();
    let bending = plane * t.powi(3) / 12.0;
    let shear = SHEAR_CORRECTION * g * t;
    [
        bending,
        bending,
        0.5 * (1.0 - nu) * bending,
        shear,
        shear,
        plane * t,
        g * t,
        nu * bending,
    ]
}

fn contract(c: &[f64; STRAINS + 1], a: &[f64; STRAINS], b: &[f64; STRAINS]) -> f64 {
    let mut sum = c[STRAINS] * (a[0] * b[1] + a[1] * b[0]);
    for i in 0..STRAINS {
        sum += c[i] * a[i] * b[i];
    }
    sum
}
