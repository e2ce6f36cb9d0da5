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
//! The loads enter by the few modes in which they act on the sides ([`SideModes`]), and harmonics that follow from others
//! are not solved ([`super::harmonics`]).

use super::FiniteElementError;
use super::condensation::CondensedSector;
use super::dense::{eliminate, product};
use super::harmonics::Solved;
use gearmesh::random::Random;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// What is left out of the side loads over their largest product with a vector of random numbers.
pub(super) const LEFT_OUT: f64 = 1e-8;
const BLOCK: usize = 64;

/// Response of the functionals of `sector` (of its loads where it has none) to unit loads on sector 0, m/N: for each k of `sectors` a
/// matrix with functionals of sector k in rows, loads in columns. `solved` are the harmonics of the ring of `teeth` for these.
pub(super) fn response(
    sector: &CondensedSector,
    teeth: u32,
    sectors: RangeInclusive<i32>,
    solved: &[Solved],
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
    let g = &sector.side_loads;
    let loads = sector.held_influence.ncols();
    let functionals = g.ncols() - sector.held_influence.nrows()..g.ncols();
    let largest = |columns: std::ops::Range<usize>| {
        columns
            .map(|j| g.column(j).norm())
            .fold(f64::MIN_POSITIVE, f64::max)
    };
    // Modes leave out what is small: functionals are of another unit than loads.
    let unit = largest(functionals.clone()) / largest(0..loads);
    let mut alike = g.clone();
    alike.columns_range_mut(loads..).scale_mut(unit.recip());
    let SideModes { modes, shares } = SideModes::new(&alike);
    let of_loads = shares.columns_range(..loads);
    let of_functionals = shares.columns_range(functionals).transpose();
    let ring = of_modes(sector, &modes, teeth, solved, progress)?;
    let of_sector = |k: i32| {
        let ring = &ring[k.unsigned_abs() as usize];
        let half = match k < 0 {
            true => product(ring.transpose().as_view(), of_loads),
            false => product(ring.as_view(), of_loads),
        };
        let response = product(of_functionals.as_view(), half.as_view()) * unit;
        if k == 0 {
            response + &sector.held_influence
        } else {
            response
        }
    };
    Ok(sectors.map(of_sector).collect())
}

/// Response of the ring to the forces `modes` on the sides of sector 0: element k along those of sector k. Those of sector -k
/// are the transpose.
fn of_modes(
    sector: &CondensedSector,
    modes: &DMatrix<f64>,
    teeth: u32,
    solved: &[Solved],
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
    let few = modes.ncols();
    let matrices = solved.first().map_or(0, |s| s.weights.len());
    let mut ring = vec![DMatrix::<f64>::zeros(few, few); matrices];
    let mut done = 0;
    for batch in solved.chunks(at_once(sector)) {
        let found: Result<Vec<_>, _> = (batch.par_iter())
            .map(|s| 2.0 * PI * s.harmonic as f64 / f64::from(teeth))
            .map(|phi| of_harmonic(sector, modes, phi))
            .collect();
        for (harmonic, found) in batch.iter().zip(found?) {
            for (out, [even_weight, odd_weight]) in ring.iter_mut().zip(&harmonic.weights) {
                for j in 0..few {
                    for i in j..few {
                        let even = even_weight * found[(i, 2 * j)];
                        let odd = odd_weight * found[(i, 2 * j + 1)];
                        out[(i, j)] += even - odd;
                        if i != j {
                            out[(j, i)] += even + odd;
                        }
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
    let of_one = 2 * 2 * side * side;
    rayon::current_num_threads().clamp(1, (sector.numbers / of_one.max(1)).max(1))
}

/// q^H K^-1 q of the forces `modes` on the sides in the harmonic of the phase `phi`: the lower triangle, each column a real and an
/// imaginary one.
fn of_harmonic(
    sector: &CondensedSector,
    modes: &DMatrix<f64>,
    phi: f64,
) -> Result<DMatrix<f64>, FiniteElementError> {
    let m = sector.sides.nrows() / 2;
    let few = modes.ncols();
    let full = |i: usize, j: usize| sector.sides[(i.max(j), i.min(j))];
    let (sin, cos) = phi.sin_cos();
    let mut columns = DMatrix::zeros(m + few, 2 * m);
    for j in 0..m {
        for i in j..m {
            let (ahead, behind) = (full(i, m + j), full(m + i, j));
            let direct = full(i, j) + full(m + i, m + j);
            columns[(i, 2 * j)] = direct + cos * (ahead + behind);
            columns[(i, 2 * j + 1)] = sin * (ahead - behind);
        }
        for i in 0..few {
            columns[(m + i, 2 * j)] = modes[(j, i)] + cos * modes[(m + j, i)];
            columns[(m + i, 2 * j + 1)] = sin * modes[(m + j, i)];
        }
    }
    let mut rest = DMatrix::zeros(few, 2 * few);
    eliminate::<2>(&mut columns, &mut rest)?;
    Ok(-rest)
}

/// How loads on the flank act on the sides of their sector: G = `modes` * `shares`.
///
/// The flank is some way off the sides, so that loads on neighbouring nodes act on them nearly alike (Saint-Venant):
/// of two thousand flank nodes a third are told apart to nine digits. G = Q B with orthonormal columns of Q is found
/// from products of G with random vectors (Halko, Martinsson, Tropp, SIAM Review 53, 2011, algorithm 4.2), the same
/// ones in every run.
struct SideModes {
    modes: DMatrix<f64>,
    /// B: how much of each mode each load brings, modes by loads.
    shares: DMatrix<f64>,
}

impl SideModes {
    fn new(g: &DMatrix<f64>) -> SideModes {
        let (rows, loads) = (g.nrows(), g.ncols());
        let most = rows.min(loads);
        let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
        let mut modes = DMatrix::<f64>::zeros(rows, 0);
        let mut largest = 0.0;
        while modes.ncols() < most {
            let block = BLOCK.min(most - modes.ncols());
            let trial = DMatrix::from_fn(loads, block, |_, _| random.within([-1.0, 1.0]));
            let mut y = product(g.as_view(), trial.as_view());
            largest = longest(&y).max(largest);
            remove(&modes, &mut y);
            if longest(&y) <= LEFT_OUT * largest {
                break;
            }
            let mut new = y.qr().q();
            // Once more: what rounding left of the modes before.
            remove(&modes, &mut new);
            let new = new.qr().q();
            let old = modes.ncols();
            modes = modes.resize_horizontally(old + block, 0.0);
            modes.columns_range_mut(old..).copy_from(&new);
        }
        let shares = product(modes.transpose().as_view(), g.as_view());
        SideModes { modes, shares }
    }
}

/// y := y - Q Q^T y.
fn remove(modes: &DMatrix<f64>, y: &mut DMatrix<f64>) {
    let share = product(modes.transpose().as_view(), y.as_view());
    *y -= product(modes.as_view(), share.as_view());
}

fn longest(y: &DMatrix<f64>) -> f64 {
    y.column_iter().map(|c| c.norm()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finite_element::Settings;
    use crate::finite_element::condensation::condense;
    use crate::finite_element::harmonics;
    use crate::finite_element::mesh::{LoadColumn, Mesh};
    use crate::finite_element::model::Model;
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
                held_ends: [false; 2],
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
            // A few of the nodes tell of all.
            let mesh = Mesh::new(&model);
            let columns: Vec<LoadColumn> = mesh.loads().into_iter().step_by(7).collect();
            let material = model.material();
            let sector = condense(&mesh, material, &columns, columns.len(), &|_| true).unwrap();
            let of = |solved: &[Solved]| {
                response(&sector, gear.teeth, 0..=3, solved, &|_| true).unwrap()
            };
            let teeth = gear.teeth as usize;
            let (few, every) = (harmonics::solved(teeth, 3), harmonics::all(teeth, 3));
            assert!(few.len() < every.len() * 2 / 3);
            for (few, all) in of(&few).iter().zip(&of(&every)) {
                let largest = all.amax();
                let error = (few - all).amax();
                assert!(error < 1e-8 * largest, "{error:e} of {largest:e}");
            }
        }
    }

    #[test]
    fn smooth_loads_are_few_modes_and_come_back() {
        // Loads that act with a decay length of a few rows.
        let g = DMatrix::from_fn(300, 200, |i, j| {
            let apart = i as f64 / 300.0 - j as f64 / 200.0;
            1.0 / (1.0 + 4.0 * apart * apart)
        });
        let SideModes { modes, shares } = SideModes::new(&g);
        let few = modes.ncols();
        assert!(few < 100, "{few}");
        assert!((&modes * shares - g).amax() < 1e-7);
        assert!((modes.transpose() * modes - DMatrix::identity(few, few)).amax() < 1e-12);
        // Loads that are all different keep all their modes.
        let g = DMatrix::from_fn(40, 30, |i, j| f64::from(u8::from(i == j)));
        let SideModes { modes, shares } = SideModes::new(&g);
        assert!((modes * shares - g).amax() < 1e-12);
    }
}
