//! What is left of a sector when its inside is eliminated.
//!
//! A part of the mesh after the other is eliminated in the dense matrix of its front ([`super::fronts`]), which leaves
//! the stiffness of the unknowns around it, the forces that the loads bring to these, and the displacement along the
//! loads with these held. The unknowns around the last part are the sides of the sector. No factor is kept: no backward
//! solution is needed.

use super::FiniteElementError;
use super::assembly::LowerTriangle;
use super::dense::{add_gram, add_product, factor, solve};
use super::dissection::Part;
use super::fronts::{Front, Fronts, positions};
use super::memory;
use nalgebra::DMatrix;
use std::sync::{Mutex, PoisonError};

/// A sector seen from its sides and its loaded flank.
pub(super) struct CondensedSector {
    /// Stiffness of both sides, side 0 first, N/m; lower triangle valid.
    pub sides: DMatrix<f64>,
    /// Forces on the held sides from each unit load column; as many rows as `sides`.
    pub side_loads: DMatrix<f64>,
    /// Displacements along the load columns with the sides held, m/N; lower triangle valid.
    pub held_influence: DMatrix<f64>,
    /// Entries of the factor.
    pub factor_entries: usize,
    /// Numbers kept at most at a time.
    pub numbers: usize,
}

/// A sparse load vector: (unknown, value).
pub(super) type LoadColumn = Vec<(usize, f64)>;

/// Parts of less than this share of all the work are eliminated on one thread, next to others.
const SHARE_OF_A_THREAD: f64 = 0.1;
/// Multiplications below which a part is not worth a task of its own.
const TASK: f64 = 1e8;

/// Eliminates `parts`, the inside of the sector with the stiffness `a`, under the load `columns`. `progress` is told the
/// share done and may stop the work.
pub(super) fn condense(
    a: &LowerTriangle,
    parts: &[Part],
    columns: &[LoadColumn],
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<CondensedSector, FiniteElementError> {
    condense_observed(a, parts, columns, columns.len(), progress)
}

/// As [`condense`] with the first `loads` of `columns` as loads and the others as functionals of the displacement
/// that are observed under them: `held_influence` has a row for each functional and a column for each load.
pub(super) fn condense_observed(
    a: &LowerTriangle,
    parts: &[Part],
    columns: &[LoadColumn],
    loads: usize,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<CondensedSector, FiniteElementError> {
    let fronts = Fronts::new(a, parts, columns);
    let condensation = Condensation {
        a,
        fronts: &fronts,
        loads,
        functionals: loads < columns.len(),
        work: fronts.work(),
        progress,
        done: Mutex::new(0.0),
    };
    condensation.condensed(columns.len())
}

struct Condensation<'a> {
    a: &'a LowerTriangle,
    fronts: &'a Fronts,
    loads: usize,
    /// Whether the other columns are functionals.
    functionals: bool,
    work: f64,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
    /// Multiplications done.
    done: Mutex<f64>,
}

/// What a part leaves to those around it.
struct Remainder {
    /// Stiffness of the unknowns around, lower triangle.
    stiffness: DMatrix<f64>,
    /// Forces on them if they are held, by load.
    forces: DMatrix<f64>,
    /// Displacement along the loads if they are held: lower triangle, or functionals by loads.
    held: DMatrix<f64>,
}

/// A front before its own unknowns are eliminated.
struct Assembled {
    /// Stiffness of the own unknowns, lower triangle.
    own: DMatrix<f64>,
    /// Stiffness between those around (rows) and the own ones.
    below: DMatrix<f64>,
    /// Forces on the own unknowns, a row for each load.
    forces: DMatrix<f64>,
    /// The same of those around, without what the own ones will add.
    rest: Remainder,
}

impl Condensation<'_> {
    fn condensed(&self, columns: usize) -> Result<CondensedSector, FiniteElementError> {
        let numbers = self.fronts.numbers();
        // The sides are the own unknowns of the last front.
        let sides = self.fronts.last(self.a.column_starts.len() - 1, columns);
        memory::check(size_of::<f64>() * numbers.max((sides.own + columns).pow(2)))?;
        let found = self.assembled(&sides)?;
        Ok(CondensedSector {
            sides: found.own,
            side_loads: found.forces.transpose(),
            held_influence: found.rest.held,
            factor_entries: self.fronts.factor_entries,
            numbers,
        })
    }

    /// Eliminates `front` and all that it encloses.
    fn eliminate(&self, front: &Front) -> Result<Remainder, FiniteElementError> {
        let assembled = self.assembled(front)?;
        let left = self.reduced(front, assembled)?;
        self.told(front)?;
        Ok(left)
    }

    /// Whether `front` with all that it encloses is left to one thread, next to others.
    fn is_small(&self, front: &Front) -> bool {
        front.work < SHARE_OF_A_THREAD * self.work
    }

    /// The front with all that it encloses eliminated.
    fn assembled(&self, front: &Front) -> Result<Assembled, FiniteElementError> {
        let enclosed: Vec<&Front> = (front.separates.iter())
            .map(|part| &self.fronts.fronts[*part])
            .collect();
        let apart = enclosed.iter().all(|inner| self.is_small(inner)) && front.work > TASK;
        let left: Vec<Remainder> = match enclosed[..] {
            [first, second] if apart => {
                let both = rayon::join(|| self.eliminate(first), || self.eliminate(second));
                vec![both.0?, both.1?]
            }
            _ => (enclosed.iter().map(|inner| self.eliminate(inner))).collect::<Result<_, _>>()?,
        };
        let (p, b, l) = (front.own, front.around.len(), front.loads.len());
        let loads = front.split(self.loads);
        let rows = if self.functionals { l - loads } else { loads };
        let mut found = Assembled {
            own: DMatrix::zeros(p, p),
            below: DMatrix::zeros(b, p),
            forces: DMatrix::zeros(l, p),
            rest: Remainder {
                stiffness: DMatrix::zeros(b, b),
                forces: DMatrix::zeros(b, l),
                held: DMatrix::zeros(rows, loads),
            },
        };
        for (inner, left) in enclosed.into_iter().zip(left) {
            found.add((front, inner), &left, (self.loads, self.functionals));
        }
        self.add_own(front, &mut found);
        Ok(found)
    }

    /// Adds the stiffness and the loads of the own unknowns of `front`.
    fn add_own(&self, front: &Front, to: &mut Assembled) {
        let end = front.start + front.own;
        for j in 0..front.own {
            let column = front.start + j;
            let range = self.a.column_starts[column]..self.a.column_starts[column + 1];
            let mut at = 0;
            for (row, value) in self.a.rows[range.clone()].iter().zip(&self.a.values[range]) {
                if *row < end {
                    to.own[(row - front.start, j)] += value;
                } else {
                    while front.around[at] < *row {
                        at += 1;
                    }
                    to.below[(at, j)] += value;
                }
            }
        }
        for (unknown, column, value) in self.fronts.entries_of(front) {
            if let Ok(at) = front.loads.binary_search(column) {
                to.forces[(at, unknown - front.start)] += value;
            }
        }
    }

    /// Eliminates the own unknowns of `front`.
    fn reduced(&self, front: &Front, from: Assembled) -> Result<Remainder, FiniteElementError> {
        let Assembled {
            mut own,
            mut below,
            mut forces,
            rest: mut left,
        } = from;
        factor([own.as_view_mut()])?;
        solve([own.as_view()], [below.as_view_mut()]);
        add_gram([left.stiffness.as_view_mut()], -1.0, [below.as_view()]);
        if !front.loads.is_empty() {
            solve([own.as_view()], [forces.as_view_mut()]);
            let (below, forces) = (below.as_view(), forces.as_view());
            add_product([left.forces.as_view_mut()], -1.0, [below], [forces]);
            let split = front.split(self.loads);
            let (loads, observed) = (forces.rows_range(..split), forces.rows_range(split..));
            let held = [left.held.as_view_mut()];
            match self.functionals {
                false => add_gram(held, 1.0, [loads]),
                true => add_product(held, 1.0, [observed], [loads]),
            }
        }
        Ok(left)
    }

    /// Tells that `front` is done.
    fn told(&self, front: &Front) -> Result<(), FiniteElementError> {
        let inner: f64 = (front.separates.iter())
            .map(|part| self.fronts.fronts[*part].work)
            .sum();
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += front.work - inner;
        match (self.progress)(*done / self.work) {
            true => Ok(()),
            false => Err(FiniteElementError::Cancelled),
        }
    }
}

impl Assembled {
    /// Adds what the part of `inner`, one that `front` separates, leaves. The first `loads` columns are loads, others
    /// `functionals`, if there are any.
    fn add(
        &mut self,
        (front, inner): (&Front, &Front),
        left: &Remainder,
        (loads, functionals): (usize, bool),
    ) {
        let places = front.places(inner);
        let (p, split) = (front.own, places.partition_point(|at| *at < front.own));
        for (j, column) in places.iter().enumerate() {
            let from = left.stiffness.column(j);
            if *column < p {
                for i in j..split {
                    self.own[(places[i], *column)] += from[i];
                }
                for i in split..places.len() {
                    self.below[(places[i] - p, *column)] += from[i];
                }
            } else {
                for i in j..places.len() {
                    self.rest.stiffness[(places[i] - p, *column - p)] += from[i];
                }
            }
        }
        let columns = positions(&front.loads, &inner.loads);
        for (j, column) in columns.iter().enumerate() {
            let from = left.forces.column(j);
            for i in 0..split {
                self.forces[(*column, places[i])] += from[i];
            }
            for i in split..places.len() {
                self.rest.forces[(places[i] - p, *column)] += from[i];
            }
        }
        // Functionals come after all loads.
        let [of_loads, before] = [inner, front].map(|f| f.split(loads));
        let (columns, observed) = columns.split_at(of_loads);
        let rows: Vec<usize> = match functionals {
            true => observed.iter().map(|row| row - before).collect(),
            false => columns.to_vec(),
        };
        for (j, column) in columns.iter().enumerate() {
            for (i, row) in rows.iter().enumerate() {
                self.rest.held[(*row, *column)] += left.held[(i, j)];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finite_element::dissection::Elimination;
    use crate::finite_element::model::Model;
    use crate::finite_element::{Settings, assembly};
    use crate::samples;
    use gearmesh::gear::GearKind;
    use gearmesh::pair::Refinement;

    #[test]
    fn fronts_leave_the_schur_complement_of_the_whole_matrix() {
        let gear = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        let settings = Settings {
            plane_strain: true,
            ..Settings::new(Refinement::Coarse, 0)
        };
        let mesh = Model::new(&gear, &settings).unwrap().mesh;
        let elimination = Elimination::new(&mesh);
        let a = assembly::assemble(&mesh, &elimination.order, [1.0, 0.3]);
        let n = a.column_starts.len() - 1;
        let inside = n - 4 * mesh.sides[0].len();
        // Loads and functionals at single unknowns, at some that are far apart, and on the sides.
        let columns: Vec<LoadColumn> = vec![
            vec![(3, 1.0)],
            vec![(inside / 2, 2.0), (inside - 1, -1.0)],
            vec![(inside + 5, 1.0), (7, 0.5)],
            vec![(inside / 3, 1.0), (11, 0.3), (n - 1, -2.0)],
            vec![(inside - 2, 1.0)],
        ];

        let mut whole = DMatrix::<f64>::zeros(n, n);
        for j in 0..n {
            for at in a.column_starts[j]..a.column_starts[j + 1] {
                whole[(a.rows[at], j)] = a.values[at];
                whole[(j, a.rows[at])] = a.values[at];
            }
        }
        let mut loads = DMatrix::<f64>::zeros(n, columns.len());
        for (j, column) in columns.iter().enumerate() {
            for (row, value) in column {
                loads[(*row, j)] = *value;
            }
        }
        let factor = whole
            .view((0, 0), (inside, inside))
            .clone_owned()
            .cholesky()
            .unwrap();
        let across = whole.view((inside, 0), (n - inside, inside));
        let (loads_inside, loads_sides) = (loads.rows(0, inside), loads.rows(inside, n - inside));
        let sides = whole.view((inside, inside), (n - inside, n - inside))
            - across * factor.solve(&across.transpose());
        let side_loads = loads_sides - across * factor.solve(&loads_inside);
        let held = loads_inside.transpose() * factor.solve(&loads_inside);

        let near = |found: &DMatrix<f64>,
                    expected: &DMatrix<f64>,
                    at: (usize, usize),
                    i: usize,
                    j: usize| {
            let error = (found[(i, j)] - expected[at]).abs();
            assert!(error < 1e-10 * expected.amax(), "{i} {j}");
        };
        let all = condense(&a, &elimination.parts, &columns, &|_| true).unwrap();
        for j in 0..n - inside {
            (j..n - inside).for_each(|i| near(&all.sides, &sides, (i, j), i, j));
        }
        for j in 0..columns.len() {
            (0..n - inside).for_each(|i| near(&all.side_loads, &side_loads, (i, j), i, j));
            (j..columns.len()).for_each(|i| near(&all.held_influence, &held, (i, j), i, j));
        }
        let observed = condense_observed(&a, &elimination.parts, &columns, 2, &|_| true).unwrap();
        assert_eq!(observed.held_influence.ncols(), 2);
        for j in 0..2 {
            for i in 0..columns.len() - 2 {
                near(&observed.held_influence, &held, (2 + i, j), i, j);
            }
        }
    }
}
