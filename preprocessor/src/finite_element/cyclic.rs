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
//!
//! The loads enter by the few modes in which they act on the sides ([`super::side_modes`]), and harmonics that others
//! tell are not solved ([`super::harmonics`]).

use super::FiniteElementError;
use super::condensation::CondensedSector;
use super::dense::{add_gram, factor, product, solve};
use super::harmonics::{self, Solved};
use super::side_modes::SideModes;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Influence of unit loads on sector 0 on the displacements of sectors 0 to `reach`, m/N: element k
/// has displacements of sector k in rows, loads on sector 0 in columns. C_-k is the transpose of C_k.
pub(super) fn ring_influence(
    sector: &CondensedSector,
    teeth: usize,
    reach: usize,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
    let solved = harmonics::solved(teeth, reach);
    influence_of(sector, teeth, &solved, progress)
}

/// As [`ring_influence`], by the harmonics `solved`.
fn influence_of(
    sector: &CondensedSector,
    teeth: usize,
    solved: &[Solved],
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
    let n = sector.side_loads.ncols();
    let SideModes { modes, shares } = SideModes::new(&sector.side_loads);
    let ring = of_modes(sector, &modes, teeth, solved, progress)?;
    let mut influence: Vec<DMatrix<f64>> = (ring.iter())
        .map(|of_modes| {
            let half = product(of_modes.as_view(), shares.as_view());
            product(shares.transpose().as_view(), half.as_view())
        })
        .collect();
    for j in 0..n {
        for i in 0..n {
            influence[0][(i, j)] += sector.held_influence[(i.max(j), i.min(j))];
        }
    }
    Ok(influence)
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
) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
    let g = &sector.side_loads;
    let largest = |columns: std::ops::Range<usize>| {
        columns
            .map(|j| g.column(j).norm())
            .fold(f64::MIN_POSITIVE, f64::max)
    };
    // Modes leave out what is small: functionals are of another unit than loads.
    let unit = largest(loads..g.ncols()) / largest(0..loads);
    let scale = |j: usize| if j < loads { 1.0 } else { 1.0 / unit };
    let alike = DMatrix::from_fn(g.nrows(), g.ncols(), |i, j| g[(i, j)] * scale(j));
    let SideModes { modes, shares } = SideModes::new(&alike);
    let of_loads = shares.columns_range(..loads);
    let of_functionals = shares.columns_range(loads..).transpose();
    let solved = harmonics::solved(teeth, reach);
    let ring = of_modes(sector, &modes, teeth, &solved, progress)?;
    let mut response: Vec<DMatrix<f64>> = (0..=2 * reach)
        .map(|place| {
            // C_-k is the transpose of C_k.
            let half = match place.checked_sub(reach) {
                Some(k) => product(ring[k].as_view(), of_loads),
                None => product(ring[reach - place].transpose().as_view(), of_loads),
            };
            product(of_functionals.as_view(), half.as_view()) * unit
        })
        .collect();
    response[reach] += &sector.held_influence;
    Ok(response)
}

/// Response of the ring to the forces `modes` on the sides of sector 0: element k along those of sector k. Those of sector -k
/// are the transpose.
fn of_modes(
    sector: &CondensedSector,
    modes: &DMatrix<f64>,
    teeth: usize,
    solved: &[Solved],
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
    let few = modes.ncols();
    let matrices = solved.first().map_or(0, |s| s.weights.len());
    let mut ring = vec![DMatrix::<f64>::zeros(few, few); matrices];
    let mut done = 0;
    for batch in solved.chunks(at_once(sector)) {
        let found: Result<Vec<_>, _> = (batch.par_iter())
            .map(|s| 2.0 * PI * s.harmonic as f64 / teeth as f64)
            .map(|phi| response(sector, modes, phi))
            .collect();
        for (harmonic, [even, odd]) in batch.iter().zip(found?) {
            for (out, [even_weight, odd_weight]) in ring.iter_mut().zip(&harmonic.weights) {
                for j in 0..few {
                    for i in 0..few {
                        out[(i, j)] += even_weight * even[(i, j)] - odd_weight * odd[(i, j)];
                    }
                }
            }
        }
        done += batch.len();
        if !progress(done as f64 / solved.len() as f64) {
            return Err(FiniteElementError::Cancelled);
        }
    }
    Ok(ring)
}

/// How many harmonics are solved at once, each on a thread of its own: which keeps all of them busy, as a single
/// factorization does not. They take no more memory than the sector's elimination took.
fn at_once(sector: &CondensedSector) -> usize {
    let side = sector.sides.nrows() / 2;
    // The matrix, its factor and the forces, complex.
    let of_one = 3 * 2 * side * side;
    rayon::current_num_threads().clamp(1, (sector.numbers / of_one.max(1)).max(1))
}

/// q^H K^-1 q of the forces `modes` on the sides in the harmonic of the phase `phi`: its symmetric real part and its
/// skew imaginary part.
fn response(
    sector: &CondensedSector,
    modes: &DMatrix<f64>,
    phi: f64,
) -> Result<[DMatrix<f64>; 2], FiniteElementError> {
    let m = sector.sides.nrows() / 2;
    let few = modes.ncols();
    let full = |i: usize, j: usize| sector.sides[(i.max(j), i.min(j))];
    let (sin, cos) = phi.sin_cos();
    // Only the lower triangle is read.
    let mut stiffness = [(); 2].map(|()| DMatrix::zeros(m, m));
    for j in 0..m {
        for i in j..m {
            let (ahead, behind) = (full(i, m + j), full(m + i, j));
            let direct = full(i, j) + full(m + i, m + j);
            stiffness[0][(i, j)] = direct + cos * (ahead + behind);
            stiffness[1][(i, j)] = sin * (ahead - behind);
        }
    }
    factor(stiffness.each_mut().map(|part| part.as_view_mut()))?;
    // X = (L^-1 q)^H from X L^H = q^H, and X X^H.
    let mut x = [
        DMatrix::from_fn(few, m, |i, j| modes[(j, i)] + cos * modes[(m + j, i)]),
        DMatrix::from_fn(few, m, |i, j| sin * modes[(m + j, i)]),
    ];
    let l = stiffness.each_ref().map(|part| part.as_view());
    solve(l, x.each_mut().map(|part| part.as_view_mut()));
    drop(stiffness);
    let mut found = [(); 2].map(|()| DMatrix::zeros(few, few));
    let parts = found.each_mut().map(|part| part.as_view_mut());
    add_gram(parts, 1.0, x.each_ref().map(|part| part.as_view()));
    for (part, sign) in found.iter_mut().zip([1.0, -1.0]) {
        for j in 0..few {
            (0..j).for_each(|i| part[(i, j)] = sign * part[(j, i)]);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finite_element::condensation::condense;
    use crate::finite_element::dissection::Elimination;
    use crate::finite_element::model::Model;
    use crate::finite_element::{Settings, assembly};
    use crate::samples;
    use gearmesh::gear::{Body, Gear, GearKind};
    use gearmesh::pair::Refinement;

    #[test]
    fn harmonics_left_out_change_influences_by_less_than_a_hundred_millionth() {
        // A disc, a thin rim on a thin web and a thin ring on a soft foundation.
        let face_width = 8e-3;
        let disc = Gear {
            face_width,
            ..samples::gear(GearKind::External, 81, 1.0, 20.0, 0.0)
        };
        let root = disc.root_radius();
        let webbed = Gear {
            body: Some(Body {
                rim_radius: root - 4e-3,
                web: [3e-3, 4e-3],
                hub_radius: disc.held_radius,
                hub: [3e-3, 4e-3],
            }),
            ..disc.clone()
        };
        let mut ring = Gear {
            face_width,
            foundation: Some(1e9),
            ..samples::gear(GearKind::Ring, 90, 1.0, 0.0, 0.0)
        };
        ring.held_radius = ring.root_radius() + 4e-3;
        for gear in [disc, webbed, ring] {
            let model = Model::new(&gear, &Settings::new(Refinement::Coarse, 0)).unwrap();
            let elimination = Elimination::new(&model.mesh);
            let first = assembly::number_unknowns(&model.mesh, &elimination.order);
            let material = [gear.youngs_modulus, gear.poisson_ratio];
            let stiffness = assembly::assemble(&model.mesh, &elimination.order, material);
            // A few of the nodes tell of all.
            let columns: Vec<_> = (model.mesh.flank.iter().step_by(7))
                .map(|flank| {
                    (0..3)
                        .map(|d| (first[flank.node] + d, flank.normal[d]))
                        .collect()
                })
                .collect();
            let sector = condense(&stiffness, &elimination.parts, &columns, &|_| true).unwrap();
            let teeth = gear.teeth as usize;
            let few = ring_influence(&sector, teeth, 3, &|_| true).unwrap();
            let every = harmonics::all(teeth, 3);
            assert!(harmonics::solved(teeth, 3).len() < every.len() * 2 / 3);
            let all = influence_of(&sector, teeth, &every, &|_| true).unwrap();
            for (few, all) in few.iter().zip(&all) {
                let largest = all.amax();
                let error = (few - all).amax();
                assert!(error < 1e-8 * largest, "{error:e} of {largest:e}");
            }
        }
    }
}
