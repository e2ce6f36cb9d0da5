//! From one sector to the whole gear: all teeth are equal, so a discrete Fourier transform over the sectors splits the ring of
//! condensed sectors into independent harmonics (Thomas, Int. J. Numer. Methods Eng. 14, 1979). With S the condensed stiffness
//! of a sector, in blocks for its side 0 and side 1, g the side loads of a unit load on sector 0 and phi = 2 pi n / z each reads
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
//! The loads enter by the few modes in which they act on the sides ([`side_modes`]).

use super::condensation::CondensedSector;
use super::dense::{eliminate, product};
use super::error::FiniteElementError;
use super::harmonics::Solved;
use gearmesh::random::Random;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// What is left out of the side loads over their largest product with a vector of random numbers: forces that alternate from node to
/// node, under which the ring hardly moves. On the shipped pairs transmission errors change by 9e-8 at most, contact pressures by 7e-7,
/// root stresses by 5e-5.
pub(super) const LEFT_OUT: f64 = 1e-5;
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
    response_of(
        &Sides::new(sector, LEFT_OUT),
        sector,
        teeth,
        sectors,
        solved,
        progress,
    )
}

fn response_of(
    sides: &Sides,
    sector: &CondensedSector,
    teeth: u32,
    sectors: RangeInclusive<i32>,
    solved: &[Solved],
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
    let ring = of_modes(sector, &sides.modes, teeth, solved, progress)?;
    let mut responses = Vec::new();
    for k in sectors {
        let ring = &ring[k.unsigned_abs() as usize];
        let half = match k < 0 {
            true => product(ring.transpose().as_view(), sides.loads.as_view()),
            false => product(ring.as_view(), sides.loads.as_view()),
        };
        let mut response = product(sides.functionals.as_view(), half.as_view()) * sides.unit;
        if k == 0 {
            response += &sector.held_influence;
        }
        responses.push(response);
    }
    Ok(responses)
}

/// How loads and functionals of a sector act on its sides.
struct Sides {
    modes: DMatrix<f64>,
    /// Modes by loads.
    loads: DMatrix<f64>,
    /// Functionals by modes, over `unit`.
    functionals: DMatrix<f64>,
    unit: f64,
}

impl Sides {
    fn new(sector: &CondensedSector, left_out: f64) -> Sides {
        let g = &sector.side_loads;
        let loads = sector.held_influence.ncols();
        let functionals = g.ncols() - sector.held_influence.nrows()..g.ncols();
        // Modes leave out what is small: functionals are of another unit than loads.
        let [of_functionals, of_loads] = [functionals.clone(), 0..loads].map(|columns| {
            let norms = columns.map(|j| g.column(j).norm());
            norms.fold(f64::MIN_POSITIVE, f64::max)
        });
        let unit = of_functionals / of_loads;
        let mut alike = g.clone();
        alike.columns_range_mut(loads..).scale_mut(unit.recip());
        let (modes, shares) = side_modes(&alike, left_out);
        Sides {
            loads: shares.columns_range(..loads).into_owned(),
            functionals: shares.columns_range(functionals).transpose(),
            modes,
            unit,
        }
    }
}

/// A ring of condensed sectors under loads that go around it in waves.
pub(super) struct Waves<'a> {
    sector: &'a CondensedSector,
    teeth: usize,
    sides: Sides,
    /// Of the harmonics from 0 on, as [`of_harmonic`] gives them.
    harmonics: Vec<DMatrix<f64>>,
}

impl<'a> Waves<'a> {
    /// For waves up to the order `orders`.
    pub fn new(
        sector: &'a CondensedSector,
        teeth: u32,
        orders: usize,
    ) -> Result<Waves<'a>, FiniteElementError> {
        let sides = Sides::new(sector, LEFT_OUT);
        let harmonics = (0..=orders.min(teeth as usize / 2)).into_par_iter();
        let harmonics = harmonics.map(|n| of_harmonic(sector, &sides.modes, n, teeth));
        Ok(Waves {
            harmonics: harmonics.collect::<Result<_, _>>()?,
            sector,
            teeth: teeth as usize,
            sides,
        })
    }

    /// Response of the functionals of sector 0 (of the loads where there are none) where on sector k the real and the imaginary part of
    /// `e^{2 pi i n k / teeth}` times the complex load act, n the `order`: by functionals and columns, m/N. The loads are columns of the
    /// sector: those from `real` on in their real part, those from `imaginary` on, if any, in their imaginary part, `count` of each.
    pub fn response(
        &self,
        order: usize,
        parts: [Option<usize>; 2],
        count: usize,
    ) -> DMatrix<Complex<f64>> {
        // Harmonics n and z - n are conjugate.
        let harmonic = order % self.teeth;
        let folded = harmonic.min(self.teeth - harmonic);
        let turned = if folded == harmonic { 1.0 } else { -1.0 };
        let few = self.sides.modes.ncols();
        let lower = &self.harmonics[folded];
        let ring = DMatrix::from_fn(few, few, |i, j| {
            let (row, column, sense) = if i >= j {
                (i, j, turned)
            } else {
                (j, i, -turned)
            };
            let [re, im] = [0, 1].map(|part| lower[(row, 2 * column + part)]);
            Complex::new(re, sense * im)
        });
        let [loads, held] = [&self.sides.loads, &self.sector.held_influence].map(|matrix| {
            let [real, imaginary] = parts.map(|first| match first {
                Some(first) => matrix.columns(first, count).into_owned(),
                None => DMatrix::zeros(matrix.nrows(), count),
            });
            real.zip_map(&imaginary, Complex::new)
        });
        let half = ring * loads;
        let by_parts = |part: fn(&Complex<f64>) -> f64| {
            let half = half.map(|x| part(&x));
            product(self.sides.functionals.as_view(), half.as_view()) * self.sides.unit
        };
        let response = by_parts(|x| x.re).zip_map(&by_parts(|x| x.im), Complex::new);
        response + held
    }
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
    // Harmonics are solved at once, each on a thread of its own, which a single factorization does not keep busy; they take no more
    // memory than the sector's elimination took.
    let of_one = sector.sides.nrows().pow(2);
    let at_once = rayon::current_num_threads().clamp(1, (sector.numbers / of_one.max(1)).max(1));
    let mut done = 0;
    for batch in solved.chunks(at_once) {
        let found: Result<Vec<_>, _> = (batch.par_iter())
            .map(|s| of_harmonic(sector, modes, s.harmonic, teeth))
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

/// q^H K^-1 q of the forces `modes` on the sides in a harmonic of the ring of `teeth`: the lower triangle, each column a real and an
/// imaginary one.
fn of_harmonic(
    sector: &CondensedSector,
    modes: &DMatrix<f64>,
    harmonic: usize,
    teeth: u32,
) -> Result<DMatrix<f64>, FiniteElementError> {
    // Unknowns of side 0, and from `half` on those between the sides.
    let half = sector.of_side;
    let m = sector.sides.nrows() - half;
    let few = modes.ncols();
    let full = |i: usize, j: usize| sector.sides[(i.max(j), i.min(j))];
    let phase = Complex::from_polar(1.0, 2.0 * PI * harmonic as f64 / f64::from(teeth));
    let (sin, cos) = (phase.im, phase.re);
    let mut columns = DMatrix::zeros(m + few, 2 * m);
    for j in 0..half {
        for i in j..half {
            let (ahead, behind) = (full(i, half + j), full(half + i, j));
            let direct = full(i, j) + full(half + i, half + j);
            columns[(i, 2 * j)] = direct + cos * (ahead + behind);
            columns[(i, 2 * j + 1)] = sin * (ahead - behind);
        }
        for i in half..m {
            let (direct, ahead) = (full(half + i, j), full(half + i, half + j));
            columns[(i, 2 * j)] = direct + cos * ahead;
            columns[(i, 2 * j + 1)] = sin * ahead;
        }
        for i in 0..few {
            columns[(m + i, 2 * j)] = modes[(j, i)] + cos * modes[(half + j, i)];
            columns[(m + i, 2 * j + 1)] = sin * modes[(half + j, i)];
        }
    }
    for j in half..m {
        for i in j..m {
            columns[(i, 2 * j)] = full(half + i, half + j);
        }
        for i in 0..few {
            columns[(m + i, 2 * j)] = modes[(half + j, i)];
        }
    }
    if let Some(body) = &sector.body {
        let stiffness = body.stiffness(phase)?;
        for (at, j) in body.shared.iter().enumerate() {
            for (i, row) in body.shared.iter().enumerate().skip(at) {
                for part in 0..2 {
                    columns[(*row, 2 * j + part)] += stiffness[(i, 2 * at + part)];
                }
            }
        }
    }
    let mut rest = DMatrix::zeros(few, 2 * few);
    eliminate::<2>(&mut columns, &mut rest)?;
    Ok(-rest)
}

/// How the loads `g` on the flank act on the sides of their sector: G = Q B, the modes Q orthonormal, and B how much of each mode each
/// load brings, modes by loads.
///
/// The flank is some way off the sides, so that loads on neighbouring nodes act on them nearly alike (Saint-Venant):
/// a few hundred modes tell a thousand flank nodes apart to five digits. Q is found from products of G with random vectors (Halko,
/// Martinsson, Tropp, SIAM Review 53, 2011, algorithm 4.2), the same ones in every run; `left_out` as [`LEFT_OUT`].
fn side_modes(g: &DMatrix<f64>, left_out: f64) -> (DMatrix<f64>, DMatrix<f64>) {
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
        if longest(&y) <= left_out * largest {
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
    (modes, shares)
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
    use crate::finite_element::harmonics::{all, solved};
    use crate::finite_element::mesh::LoadColumn;
    use crate::finite_element::model::Model;
    use crate::gear::Refinement;
    use crate::gear::body::{self, Stub};
    use crate::samples;
    use gearmesh::gear::{Body, Gear, GearKind};

    #[test]
    fn harmonics_left_out_change_influences_by_less_than_a_ten_millionth() {
        // A disc, a thin rim on a thin web and a thin ring on a soft foundation.
        let mut disc = samples::gear(GearKind::External, 81, 1.0, 20.0, 0.0);
        disc.face_width = 8e-3;
        let mut webbed = disc.clone();
        webbed.body = Some(Body {
            rim_radius: disc.root_radius() - 4e-3,
            web: [3e-3, 4e-3],
            hub_radius: disc.held_radius,
            hub: [3e-3, 4e-3],
            held_ends: [false; 2],
        });
        let mut ring = samples::gear(GearKind::Ring, 90, 1.0, 0.0, 0.0);
        ring.face_width = 8e-3;
        ring.foundation = Some(1e9);
        ring.held_radius = ring.root_radius() + 4e-3;
        for gear in [disc, webbed, ring] {
            let model = Model::new(&gear, &Settings::new(Refinement::Coarse, 0)).unwrap();
            // A few of the nodes tell of all.
            let mesh = model.mesh();
            let columns: Vec<LoadColumn> = mesh.loads.iter().step_by(7).cloned().collect();
            let sector = condense(&mesh, &columns, columns.len(), 1.0, &|_| true).unwrap();
            let of = |solved: &[Solved]| {
                response(&sector, gear.teeth, 0..=3, solved, &|_| true).unwrap()
            };
            let teeth = gear.teeth as usize;
            let (few, every) = (solved(teeth, 3), all(teeth, 3));
            assert!(few.len() < every.len() * 2 / 3);
            for (found, all) in of(&few).iter().zip(&of(&every)) {
                let largest = all.amax();
                let error = (found - all).amax();
                assert!(error < 1e-7 * largest, "{error:e} of {largest:e}");
            }
        }
    }

    #[test]
    fn side_loads_left_out_change_influences_by_less_than_a_millionth() {
        let gear = samples::gear(GearKind::External, 20, 1.0, 20.0, 0.0);
        let model = Model::new(&gear, &Settings::new(Refinement::Coarse, 0)).unwrap();
        let mesh = model.mesh();
        let sector = condense(&mesh, &mesh.loads, mesh.loads.len(), 1.0, &|_| true).unwrap();
        let solved = all(20, 1);
        let [(few, found), (every, expected)] = [LEFT_OUT, 1e-12].map(|left_out| {
            let sides = Sides::new(&sector, left_out);
            let found = response_of(&sides, &sector, 20, 0..=1, &solved, &|_| true);
            (sides.modes.ncols(), found.unwrap())
        });
        assert!(few < every, "{few} of {every}");
        for (found, expected) in found.iter().zip(&expected) {
            let (error, largest) = ((found - expected).amax(), expected.amax());
            assert!(error < 1e-6 * largest, "{error:e} of {largest:e}");
        }
    }

    fn pinion_shaft() -> Gear {
        let mut pinion = samples::gear(GearKind::External, 37, 1.0, 20.0, 0.0);
        let stub = |radius, held| Stub {
            radius,
            length: 30e-3,
            held,
        };
        let stubs = [stub(30e-3, true), stub(50e-3, false)];
        pinion.body = Some(body::shaft(stubs, pinion.face_width));
        pinion.held_radius = 3e-3;
        pinion
    }

    #[test]
    fn a_body_of_two_elements_in_a_pitch_changes_influences_by_a_ten_thousandth_and_deeper_by_less()
    {
        let mut ring = samples::gear(GearKind::Ring, 90, 1.0, 0.0, 0.0);
        (ring.foundation, ring.held_radius) = (Some(1e9), ring.root_radius() + 50e-3);
        for gear in [pinion_shaft(), ring] {
            let of = |deeper: f64| {
                let mut settings = Settings::new(Refinement::Coarse, 2);
                settings.discretization.fine_depth *= deeper;
                let model = Model::new(&gear, &settings).unwrap();
                let mesh = model.mesh();
                assert_eq!(mesh.body < mesh.elements.len(), deeper.is_finite());
                // A load on a single node moves that as the elements beside it let it.
                let columns: Vec<LoadColumn> = mesh.loads.chunks(30).map(<[_]>::concat).collect();
                let all = columns.len();
                let found = model.response(&mesh, &columns, all, 0..=2, &|_, _| true);
                found.unwrap()
            };
            let fine = of(f64::INFINITY);
            for (deeper, bound) in [(1.0, 1.5e-4), (1.5, 5e-6)] {
                for (found, fine) in of(deeper).iter().zip(&fine) {
                    let (error, largest) = ((found - fine).amax(), fine.amax());
                    assert!(error < bound * largest, "{error:e} of {largest:e}");
                }
            }
        }
    }

    #[test]
    fn one_condensation_does_for_a_pinion_shaft_turned_end_for_end() {
        let gear = pinion_shaft();
        let turned = body::turned(&gear).unwrap();
        let settings = Settings::new(Refinement::Coarse, 1);
        let mut condensed = None;
        let mut influence = |gear: &Gear, anew: bool| {
            if anew {
                condensed = None;
            }
            let model = Model::new(gear, &settings).unwrap();
            model.influence(&mut condensed, &|_, _| true).unwrap()
        };
        let first = influence(&gear, true);
        let shared = influence(&turned, false);
        let alone = influence(&turned, true);
        for ((first, shared), alone) in first.iter().zip(&shared).zip(&alone) {
            assert!((shared - alone).amax() < 1e-12 * alone.amax());
            assert!((shared - first).amax() > 1e-3 * alone.amax());
        }
        // Other teeth have a condensation of their own.
        let mut other = gear.clone();
        other.tip_radius -= 1e-4;
        let after = influence(&other, false);
        assert_eq!(after, influence(&other, true));
    }

    #[test]
    fn smooth_loads_are_few_modes_and_come_back() {
        // Loads that act with a decay length of a few rows.
        let g = DMatrix::from_fn(300, 200, |i, j| {
            let apart = i as f64 / 300.0 - j as f64 / 200.0;
            1.0 / (1.0 + 4.0 * apart * apart)
        });
        let (modes, shares) = side_modes(&g, LEFT_OUT);
        let few = modes.ncols();
        assert!(few < 100, "{few}");
        assert!((&modes * shares - g).amax() < 1e-5);
        assert!((modes.transpose() * modes - DMatrix::identity(few, few)).amax() < 1e-12);
        // Loads that are all different keep all their modes.
        let g = DMatrix::from_fn(40, 30, |i, j| f64::from(u8::from(i == j)));
        let (modes, shares) = side_modes(&g, LEFT_OUT);
        assert!((modes * shares - g).amax() < 1e-12);
    }
}
