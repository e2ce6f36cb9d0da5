//! What a force on one tooth pair takes of the approach of the others, told from all of them under load.

use crate::table::plan::Coverage;
use crate::table::sweep::point;
use gearmesh::contact::{ContactError, ContactSolver, PositionProblem, Prescribed};
use gearmesh::gear::Flank;
use gearmesh::table::TableError;
use gearmesh::words::rounded;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};
use rayon::prelude::*;

/// Mesh positions at which all tooth pairs are looked at.
const POSITIONS: usize = 32;

/// Loads at each of them, evenly up to the largest: a greater load spreads over the face, where others take less.
const LOADS: usize = 4;

/// The least part of the force of all that a tooth pair carries where it is looked at.
const LEAST_SHARE: f64 = 0.05;

/// Part of the squares of the forces on neighbours that those farther away must have to tell anything.
const TOLD: f64 = 1e-4;

/// The coupling on `flank` of `solver`, distance by distance from neighbours on, at each of the `misalignments` (rad), m/N: the
/// least squares of what tooth pairs lack of their approach beside others, over loads up to the largest of `coverage`.
///
/// Neighbours share tooth roots and rim, which follows the misalignment; beyond them it is the body, and the same at all.
pub fn coupling(
    solver: &ContactSolver,
    coverage: &Coverage,
    flank: Flank,
    misalignments: &[f64],
) -> Result<Vec<Vec<f64>>, TableError> {
    let rows = (0..POSITIONS).into_par_iter().map(|i| {
        let tau = i as f64 / POSITIONS as f64;
        let failed = |m, error: ContactError| TableError::Solve {
            point: point(flank, 0.0, m, tau),
            message: error.to_string(),
        };
        let beside = Beside::new(solver, flank, tau).map_err(|error| failed(0.0, error))?;
        let look = |&m: &f64| {
            let mut sums = Sums::default();
            for load in 1..=LOADS {
                let torque = coverage.maximum_torque * load as f64 / LOADS as f64;
                let seen = beside.look(torque, m, &mut sums);
                seen.map_err(|error| failed(m, error))?;
            }
            Ok(sums)
        };
        misalignments.iter().map(look).collect()
    });
    let rows: Vec<Vec<Sums>> = rows.collect::<Result<_, TableError>>()?;
    let mut nodes = vec![Sums::default(); misalignments.len()];
    for row in &rows {
        for (sum, sums) in nodes.iter_mut().zip(row) {
            sum.squares += sums.squares;
            sum.products += sums.products;
            sum.farthest = sum.farthest.max(sums.farthest);
        }
    }
    if let Some(node) = nodes.iter().position(|sums| sums.squares[(0, 0)] <= 0.0) {
        return Err(TableError::Samples(format!(
            "no place where two tooth pairs carry at a misalignment of {} mrad: tooth pairs one by one need a contact \
             ratio above 1",
            rounded(1e3 * misalignments[node])
        )));
    }
    let far = Sums::far(&nodes);
    let near: Vec<f64> = nodes.iter().map(|sums| sums.near(far)).collect();
    let farthest = nodes.iter().map(|sums| sums.farthest).max().unwrap_or(1);
    let beyond = (2..=farthest).map(|apart| if apart == 2 { far[0] + far[1] } else { far[1] });
    let beyond = beyond.take_while(|c| *c > 0.0);
    Ok([near]
        .into_iter()
        .chain(beyond.map(|c| vec![c; misalignments.len()]))
        .collect())
}

/// Over tooth pairs and loads at one misalignment: forces on neighbours, on those two base pitches apart, and on all that are
/// two or more apart, among each other, N², and with what the pair lacks, N m.
#[derive(Clone, Default)]
struct Sums {
    squares: SMatrix<f64, 3, 3>,
    products: SVector<f64, 3>,
    /// Largest distance at which two carry, base pitches.
    farthest: usize,
}

impl Sums {
    /// What a force takes two base pitches away beyond what it takes farther away, and what it takes there, m/N: neither below 0,
    /// since what two tooth pairs share is less the farther they are apart, and both the same at all of `nodes`.
    fn far(nodes: &[Sums]) -> [f64; 2] {
        let (mut squares, mut products) = (Matrix2::zeros(), Vector2::zeros());
        for sums in nodes {
            // What neighbours do not explain.
            let (both, near) = (sums.squares.fixed_view::<2, 1>(1, 0), sums.squares[(0, 0)]);
            squares += sums.squares.fixed_view::<2, 2>(1, 1) - both * both.transpose() / near;
            products += sums.products.fixed_rows::<2>(1) - both * sums.products[0] / near;
        }
        let least = TOLD * nodes.iter().map(|sums| sums.squares[(0, 0)]).sum::<f64>();
        let alone = |k: usize| {
            let square = squares[(k, k)];
            if square > least {
                (products[k] / square).max(0.0)
            } else {
                0.0
            }
        };
        let both = squares.cholesky().map(|squares| squares.solve(&products));
        let both = both.filter(|both| both.min() >= 0.0 && squares.determinant() > least * least);
        let choices = [
            both.unwrap_or_default(),
            Vector2::new(0.0, alone(1)),
            Vector2::new(alone(0), 0.0),
        ];
        let left = |c: &Vector2<f64>| c.dot(&(squares * c)) - 2.0 * c.dot(&products);
        let best = choices
            .into_iter()
            .min_by(|a, b| left(a).total_cmp(&left(b)));
        best.unwrap_or_default().into()
    }

    /// What a force takes of the approach of neighbours, m/N, where it takes `far` beyond them.
    fn near(&self, far: [f64; 2]) -> f64 {
        let beyond = self.squares[(0, 1)] * far[0] + self.squares[(0, 2)] * far[1];
        (self.products[0] - beyond) / self.squares[(0, 0)]
    }
}

/// All tooth pairs at a mesh position, together and each alone.
struct Beside {
    base_radius: f64,
    whole: PositionProblem,
    alone: Vec<(i32, PositionProblem)>,
}

impl Beside {
    fn new(solver: &ContactSolver, flank: Flank, tau: f64) -> Result<Self, ContactError> {
        let whole = solver.position(flank, tau, 0.0)?;
        let mut pairs: Vec<i32> = whole.candidates().iter().map(|c| c.tooth_pair).collect();
        pairs.dedup();
        let alone = |k| -> Result<_, ContactError> {
            let problem = solver.tooth_pair(flank, tau + f64::from(k), 0.0)?;
            Ok((k, problem))
        };
        Ok(Beside {
            base_radius: solver.geometry().gears[0].base_radius(),
            alone: pairs.into_iter().map(alone).collect::<Result<_, _>>()?,
            whole,
        })
    }

    /// Adds to `sums` what each tooth pair lacks of its approach where all carry `torque`.
    fn look(&self, torque: f64, misalignment: f64, sums: &mut Sums) -> Result<(), ContactError> {
        let whole = self.whole.solve_torque(torque, misalignment, None)?;
        let force = |(k, share): &(i32, f64)| (*k, share * whole.loa_force);
        let forces: Vec<(i32, f64)> = whole.load_share.iter().map(force).collect();
        for (k, force) in &forces {
            let mut beside = SVector::<f64, 3>::zeros();
            for (other, force) in &forces {
                let apart = k.abs_diff(*other) as usize;
                beside += match apart {
                    0 => continue,
                    1 => Vector3::new(*force, 0.0, 0.0),
                    2 => Vector3::new(0.0, *force, *force),
                    _ => Vector3::new(0.0, 0.0, *force),
                };
                if *force > LEAST_SHARE * whole.loa_force {
                    sums.farthest = sums.farthest.max(apart);
                }
            }
            let alone = self.alone.iter().find(|(pair, _)| pair == k);
            let Some((_, alone)) = alone.filter(|_| *force > LEAST_SHARE * whole.loa_force) else {
                continue;
            };
            let own = Prescribed::Torque(force * self.base_radius);
            let own = alone.solve_beyond(own, misalignment, None)?;
            let lacks = whole.approach - own.approach;
            sums.squares += beside * beside.transpose();
            sums.products += beside * lacks;
        }
        Ok(())
    }
}
