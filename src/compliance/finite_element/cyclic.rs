//! From one sector to the whole gear: all teeth are equal, so a discrete Fourier transform over the
//! sectors splits the ring of condensed sectors into independent harmonics (Thomas, Int. J. Numer.
//! Methods Eng. 14, 1979).
//!
//! x_s are the displacements of the side between sectors s - 1 and s, S the condensed stiffness of a
//! sector with blocks for its side 0 and side 1, g the side loads of a unit load on sector 0. With
//! phi = 2 pi n / z each harmonic reads
//!
//! ```text
//! [S_00 + S_11 + S_01 e^{i phi} + S_10 e^{-i phi}] X_n = g_0 + e^{-i phi} g_1 =: q_n ,
//! ```
//!
//! and the displacement along the loads of sector k per load on sector 0 is
//!
//! ```text
//! C_k = delta_k0 C_held + (1/z) sum_n e^{i k phi} q_n^H K_n^-1 q_n .
//! ```

use super::FiniteElementError;
use super::condensation::{CondensedSector, product};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, Par, Side, c64};
use std::f64::consts::PI;

/// Influence of unit loads on sector 0 on the displacements of sectors 0 to `reach`, m/N: element k
/// has displacements of sector k in rows, loads on sector 0 in columns. C_-k is the transpose of C_k.
pub(super) fn ring_influence(
    sector: &CondensedSector,
    teeth: usize,
    reach: usize,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<Mat<f64>>, FiniteElementError> {
    let n = sector.side_loads.ncols();
    let par = Par::rayon(0);
    let mut influence = vec![Mat::<f64>::zeros(n, n); reach + 1];
    let harmonics = teeth / 2;
    for harmonic in 0..=harmonics {
        // w^H w = even + i odd, a symmetric and a skew part.
        let Wave {
            phi,
            weight,
            re,
            im,
        } = Wave::new(sector, teeth, harmonic)?;
        let mut even = Mat::<f64>::zeros(n, n);
        for part in [&re, &im] {
            triangular::matmul(
                even.as_mut(),
                BlockStructure::TriangularLower,
                Accum::Add,
                part.transpose(),
                BlockStructure::Rectangular,
                part,
                BlockStructure::Rectangular,
                1.0,
                par,
            );
        }
        let mut cross = Mat::<f64>::zeros(n, n);
        faer::linalg::matmul::matmul(
            cross.as_mut(),
            Accum::Replace,
            re.transpose(),
            &im,
            1.0,
            par,
        );
        for (k, out) in influence.iter_mut().enumerate() {
            let (sin, cos) = (k as f64 * phi).sin_cos();
            for j in 0..n {
                for i in 0..n {
                    let odd = cross[(i, j)] - cross[(j, i)];
                    out[(i, j)] += weight * (cos * even[(i.max(j), i.min(j))] - sin * odd);
                }
            }
        }
        if !progress((harmonic + 1) as f64 / (harmonics + 1) as f64) {
            return Err(FiniteElementError::Cancelled);
        }
    }
    for j in 0..n {
        for i in 0..n {
            influence[0][(i, j)] += sector.held_influence[(i.max(j), i.min(j))];
        }
    }
    Ok(influence)
}

/// One harmonic of the ring: w = L^-1 q_n with L L^H = K_n.
struct Wave {
    /// 2 pi n / z.
    phi: f64,
    /// Its share in the sum over all harmonics; n and z - n are conjugate and count together.
    weight: f64,
    re: Mat<f64>,
    im: Mat<f64>,
}

impl Wave {
    fn new(
        sector: &CondensedSector,
        teeth: usize,
        harmonic: usize,
    ) -> Result<Wave, FiniteElementError> {
        let m = sector.sides.nrows() / 2;
        let n = sector.side_loads.ncols();
        let full = |i: usize, j: usize| sector.sides[(i.max(j), i.min(j))];
        let phi = 2.0 * PI * harmonic as f64 / teeth as f64;
        let wave = c64::new(phi.cos(), phi.sin());
        let stiffness = Mat::<c64>::from_fn(m, m, |i, j| {
            let direct = full(i, j) + full(m + i, m + j);
            c64::new(direct, 0.0) + wave * full(i, m + j) + wave.conj() * full(m + i, j)
        });
        let factor = stiffness
            .llt(Side::Lower)
            .map_err(|_| FiniteElementError::NotPositiveDefinite)?;
        let mut w = Mat::<c64>::from_fn(m, n, |i, j| {
            c64::new(sector.side_loads[(i, j)], 0.0) + wave.conj() * sector.side_loads[(m + i, j)]
        });
        solve_lower_triangular_in_place(factor.L(), w.as_mut(), Par::rayon(0));
        let alone = harmonic == 0 || 2 * harmonic == teeth;
        Ok(Wave {
            phi,
            weight: if alone { 1.0 } else { 2.0 } / teeth as f64,
            re: Mat::from_fn(m, n, |i, j| w[(i, j)].re),
            im: Mat::from_fn(m, n, |i, j| w[(i, j)].im),
        })
    }
}

/// Response of the functionals behind the first `loads` columns of `sector` (from
/// [`super::condensation::condense_observed`]) to unit loads on sector 0: element `reach` + k has functionals of
/// sector k in rows, loads in columns, for k from -`reach` to `reach`.
pub(super) fn ring_response(
    sector: &CondensedSector,
    loads: usize,
    teeth: usize,
    reach: usize,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<Mat<f64>>, FiniteElementError> {
    let observed = sector.side_loads.ncols() - loads;
    let mut response = vec![Mat::<f64>::zeros(observed, loads); 2 * reach + 1];
    response[reach] += &sector.held_influence;
    let harmonics = teeth / 2;
    for harmonic in 0..=harmonics {
        let wave = Wave::new(sector, teeth, harmonic)?;
        let (re_load, re) = wave.re.as_ref().split_at_col(loads);
        let (im_load, im) = wave.im.as_ref().split_at_col(loads);
        let even = product(re, re_load) + product(im, im_load);
        let odd = product(re, im_load) - product(im, re_load);
        for (place, out) in response.iter_mut().enumerate() {
            let (sin, cos) = ((place as f64 - reach as f64) * wave.phi).sin_cos();
            let (cos, sin) = (wave.weight * cos, wave.weight * sin);
            faer::zip!(out, &even, &odd).for_each(|faer::unzip!(out, even, odd)| {
                *out += cos * *even - sin * *odd;
            });
        }
        if !progress((harmonic + 1) as f64 / (harmonics + 1) as f64) {
            return Err(FiniteElementError::Cancelled);
        }
    }
    Ok(response)
}
