//! The innermost loop: contraction of a block of coefficients with the weights of each coordinate.
//!
//! The mesh position is the fastest index, so its neighbouring coefficients fill vector registers and
//! nothing is summed across a register until the very end.

use super::basis::Weights;
use wide::f64x2;

/// Value and derivatives over (centre distance, misalignment, mesh position).
#[derive(Debug, Clone, Copy, Default)]
pub struct Jet {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; 3],
    /// Second derivatives: CC, CM, CP, MM, MP, PP.
    pub second: [f64; 6],
}

/// Where the second derivative by coordinates i and j stands in [`Jet::second`].
pub const SECOND: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

/// `sum` += `factor` `row`, two lanes at a time, in the vector registers that every x86-64 has.
#[inline(always)]
pub fn add<const N: usize>(sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
    let (pairs, single) = sum.as_chunks_mut::<2>();
    let (row_pairs, row_single) = row.as_chunks::<2>();
    for (s, r) in pairs.iter_mut().zip(row_pairs) {
        *s = (f64x2::new(*s) + f64x2::splat(factor) * f64x2::new(*r)).to_array();
    }
    for (s, r) in single.iter_mut().zip(row_single) {
        *s += factor * r;
    }
}

#[inline(always)]
fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = a[0] * b[0];
    for k in 1..N {
        sum += a[k] * b[k];
    }
    sum
}

/// Contracts K quantities, given as rows over the mesh position for each (c, m), at once.
///
/// What the caller does not use of the result costs nothing once inlined. `H`: second derivatives.
#[inline(always)]
pub fn contract<
    const K: usize,
    const NC: usize,
    const NM: usize,
    const NP: usize,
    const H: bool,
>(
    rows: impl Fn(usize, usize) -> [[f64; NP]; K],
    wc: &Weights<NC>,
    wm: &Weights<NM>,
    wp: &Weights<NP>,
) -> [Jet; K] {
    let zero = [[0.0; NP]; K];
    let (mut v, mut c, mut m) = (zero, zero, zero);
    let (mut cc, mut cm, mut mm) = (zero, zero, zero);
    for i in 0..NC {
        let (mut a, mut a_m, mut a_mm) = (zero, zero, zero);
        for j in 0..NM {
            let row = rows(i, j);
            for k in 0..K {
                add(&mut a[k], wm.value[j], &row[k]);
                add(&mut a_m[k], wm.slope[j], &row[k]);
                if H {
                    add(&mut a_mm[k], wm.curvature[j], &row[k]);
                }
            }
        }
        for k in 0..K {
            add(&mut v[k], wc.value[i], &a[k]);
            add(&mut c[k], wc.slope[i], &a[k]);
            add(&mut m[k], wc.value[i], &a_m[k]);
            if H {
                add(&mut cc[k], wc.curvature[i], &a[k]);
                add(&mut cm[k], wc.slope[i], &a_m[k]);
                add(&mut mm[k], wc.value[i], &a_mm[k]);
            }
        }
    }
    let mut out = [Jet::default(); K];
    for k in 0..K {
        out[k].value = dot(&v[k], &wp.value);
        out[k].gradient = [
            dot(&c[k], &wp.value),
            dot(&m[k], &wp.value),
            dot(&v[k], &wp.slope),
        ];
        if H {
            out[k].second = [
                dot(&cc[k], &wp.value),
                dot(&cm[k], &wp.value),
                dot(&c[k], &wp.slope),
                dot(&mm[k], &wp.value),
                dot(&m[k], &wp.slope),
                dot(&v[k], &wp.curvature),
            ];
        }
    }
    out
}

/// A block of coefficients `[c][m][row][mesh position]`.
#[derive(Debug, Clone)]
pub struct Coefficients {
    pub(super) values: Vec<f64>,
    /// Distances from one c, m and row to the next.
    pub(super) strides: [usize; 3],
}

impl Coefficients {
    /// From the array of a fit with lengths (c, m, row, mesh position).
    pub fn new(block: super::fit::Block) -> Self {
        Coefficients {
            strides: [block.stride(0), block.stride(1), block.stride(2)],
            values: block.values,
        }
    }

    /// Rows `first_row..first_row + R` at (c, m), from mesh-position coefficient `p` on.
    #[inline(always)]
    pub fn rows<const R: usize, const NP: usize>(
        &self,
        [c, m, first_row, p]: [usize; 4],
    ) -> [&[f64; NP]; R] {
        let start = c * self.strides[0] + m * self.strides[1] + first_row * self.strides[2] + p;
        let window = &self.values[start..start + (R - 1) * self.strides[2] + NP];
        std::array::from_fn(|r| {
            window[r * self.strides[2]..]
                .first_chunk()
                .expect("the window holds every row")
        })
    }
}

/// Value, first and second derivative over the displacement, each with its derivatives by the other
/// coordinates; and the third one, only with `H`, zero otherwise.
#[inline(always)]
pub fn over_displacement<
    const NU: usize,
    const NC: usize,
    const NM: usize,
    const NP: usize,
    const H: bool,
>(
    coefficients: &Coefficients,
    wu: &Weights<NU>,
    wc: &Weights<NC>,
    wm: &Weights<NM>,
    wp: &Weights<NP>,
) -> ([Jet; 3], f64) {
    let rows = |i, j| -> [&[f64; NP]; NU] {
        coefficients.rows([wc.first + i, wm.first + j, wu.first, wp.first])
    };
    if H {
        let over_u = [&wu.value, &wu.slope, &wu.curvature, &wu.third];
        let [w, f, k, third] =
            contract::<4, NC, NM, NP, H>(|i, j| summed(&rows(i, j), over_u), wc, wm, wp);
        ([w, f, k], third.value)
    } else {
        let over_u = [&wu.value, &wu.slope, &wu.curvature];
        let shape = contract::<3, NC, NM, NP, H>(|i, j| summed(&rows(i, j), over_u), wc, wm, wp);
        (shape, 0.0)
    }
}

/// K sums over `rows`.
#[inline(always)]
fn summed<const K: usize, const R: usize, const NP: usize>(
    rows: &[&[f64; NP]; R],
    weights: [&[f64; R]; K],
) -> [[f64; NP]; K] {
    let mut sums = [[0.0; NP]; K];
    for r in 0..R {
        for k in 0..K {
            add(&mut sums[k], weights[k][r], rows[r]);
        }
    }
    sums
}

/// The no-load approach (row 0) and the span up to the top load (row 1).
#[inline(always)]
pub fn fields<const NC: usize, const NM: usize, const NP: usize, const H: bool>(
    coefficients: &Coefficients,
    wc: &Weights<NC>,
    wm: &Weights<NM>,
    wp: &Weights<NP>,
) -> [Jet; 2] {
    contract::<2, NC, NM, NP, H>(
        #[inline(always)]
        |i, j| {
            let rows: [&[f64; NP]; 2] =
                coefficients.rows([wc.first + i, wm.first + j, 0, wp.first]);
            [*rows[0], *rows[1]]
        },
        wc,
        wm,
        wp,
    )
}
