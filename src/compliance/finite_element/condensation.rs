//! Sparse Cholesky factor of one sector and what is left of the sector when its inside is eliminated.
//!
//! With the nodes of both sides last in the elimination order, the factor L of the sector holds the
//! Schur complement S = L_ss L_ss^T of the sides in its last block, and the forward solution Y = L^-1 P
//! of the load columns P gives the rest: P^T A^-1 P of the inside (sides held) is Y_i^T Y_i, the loads
//! that the sides feel are G = L_ss Y_s. No backward solution is needed.

use super::FiniteElementError;
use super::assembly::LowerTriangle;
use super::dense::{add_gram, product};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::{simplicial, supernodal};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// A sector seen from its sides and its loaded flank.
pub(super) struct CondensedSector {
    /// Stiffness of both sides, side 0 first, N/m; lower triangle valid.
    pub sides: Mat<f64>,
    /// Forces on the held sides from each unit load column; as many rows as `sides`.
    pub side_loads: Mat<f64>,
    /// Displacements along the load columns with the sides held, m/N; lower triangle valid.
    pub held_influence: Mat<f64>,
    /// Entries of the factor.
    pub factor_entries: usize,
}

/// A sparse load vector: (unknown, value).
pub(super) type LoadColumn = Vec<(usize, f64)>;

/// Symbolic factor of the lower triangle `a`.
fn symbolic(
    a: &LowerTriangle,
) -> Result<supernodal::SymbolicSupernodalCholesky<usize>, FiniteElementError> {
    let n = a.column_starts.len() - 1;
    // The lower triangle by columns is the upper triangle by rows; faer wants the upper by columns.
    let mut column_starts = vec![0; n + 1];
    for row in &a.rows {
        column_starts[row + 1] += 1;
    }
    for i in 0..n {
        column_starts[i + 1] += column_starts[i];
    }
    let mut next = column_starts.clone();
    let mut rows = vec![0; a.rows.len()];
    for column in 0..n {
        for row in &a.rows[a.column_starts[column]..a.column_starts[column + 1]] {
            rows[next[*row]] = column;
            next[*row] += 1;
        }
    }
    let upper = SymbolicSparseColMatRef::new_checked(n, n, &column_starts, None, &rows);
    let scratch = simplicial::prefactorize_symbolic_cholesky_scratch::<usize>(n, rows.len())
        .or(supernodal::factorize_supernodal_symbolic_cholesky_scratch::<usize>(n));
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| FiniteElementError::Memory)?;
    let mut parents = vec![0; n];
    let mut counts = vec![0; n];
    let tree = simplicial::prefactorize_symbolic_cholesky(
        &mut parents,
        &mut counts,
        upper,
        MemStack::new(&mut memory),
    );
    supernodal::factorize_supernodal_symbolic_cholesky(
        upper,
        tree,
        &counts,
        MemStack::new(&mut memory),
        SymbolicSupernodalParams::default(),
    )
    .map_err(|_| FiniteElementError::Memory)
}

/// Factors the sector's stiffness `a`, whose last `side_unknowns` rows are the sides, and eliminates the
/// inside under the load `columns`. `progress` is told the share done and may stop the work.
pub(super) fn condense(
    a: &LowerTriangle,
    side_unknowns: usize,
    columns: &[LoadColumn],
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<CondensedSector, FiniteElementError> {
    condense_with(a, side_unknowns, columns, progress, gram)
}

/// As [`condense`] with the first `loads` of `columns` as loads and the others as functionals of the displacement
/// that are observed under them: `held_influence` has a row for each functional and a column for each load.
pub(super) fn condense_observed(
    a: &LowerTriangle,
    side_unknowns: usize,
    columns: &[LoadColumn],
    loads: usize,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<CondensedSector, FiniteElementError> {
    condense_with(a, side_unknowns, columns, progress, |y| {
        let (y_loads, y_observed) = y.split_at_col(loads);
        product(y_observed.transpose(), y_loads)
    })
}

/// `held` makes the held influence of the inside of the forward solution, a column for each of `columns`.
fn condense_with(
    a: &LowerTriangle,
    side_unknowns: usize,
    columns: &[LoadColumn],
    progress: &(dyn Fn(f64) -> bool + Sync),
    held: impl Fn(MatRef<'_, f64>) -> Mat<f64>,
) -> Result<CondensedSector, FiniteElementError> {
    let n = a.column_starts.len() - 1;
    let symbolic = symbolic(a)?;
    let mut values = vec![0.0; symbolic.len_val()];
    let par = Par::rayon(0);
    let scratch = supernodal::factorize_supernodal_numeric_llt_scratch::<usize, f64>(
        &symbolic,
        par,
        Default::default(),
    );
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| FiniteElementError::Memory)?;
    supernodal::factorize_supernodal_numeric_llt(
        &mut values,
        SparseColMatRef::new(
            SymbolicSparseColMatRef::new_checked(n, n, &a.column_starts, None, &a.rows),
            &a.values,
        ),
        LltRegularization::default(),
        &symbolic,
        par,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|_| FiniteElementError::NotPositiveDefinite)?;
    drop(memory);
    if !progress(0.5) {
        return Err(FiniteElementError::Cancelled);
    }
    let factor = supernodal::SupernodalLltRef::new(&symbolic, &values);
    let mut y = Mat::<f64>::zeros(n, columns.len());
    for (j, column) in columns.iter().enumerate() {
        for (row, value) in column {
            y[(*row, j)] += value;
        }
    }
    const BLOCK: usize = 48;
    y.as_mut()
        .par_col_chunks_mut(BLOCK)
        .for_each(|block| forward_solve(&factor, block));
    if !progress(0.9) {
        return Err(FiniteElementError::Cancelled);
    }

    let inside = n - side_unknowns;
    let (y_inside, y_sides) = y.as_ref().split_at_row(inside);
    let held_influence = held(y_inside);
    let last = last_block(&factor, inside, side_unknowns);
    let side_loads = product(last.as_ref(), y_sides);
    let mut sides = Mat::zeros(side_unknowns, side_unknowns);
    triangular::matmul(
        sides.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        &last,
        BlockStructure::TriangularLower,
        last.transpose(),
        BlockStructure::TriangularUpper,
        1.0,
        par,
    );
    Ok(CondensedSector {
        sides,
        side_loads,
        held_influence,
        factor_entries: symbolic.len_val(),
    })
}

/// y^T y, lower triangle, for a matrix of whose columns few reach most of the rows: those that reach a stretch of
/// rows mostly follow each other.
fn gram(y: MatRef<'_, f64>) -> Mat<f64> {
    const ROWS: usize = 192;
    let mut out = Mat::zeros(y.ncols(), y.ncols());
    for start in (0..y.nrows()).step_by(ROWS) {
        let part = y.subrows(start, ROWS.min(y.nrows() - start));
        let reaches = |j: &usize| part.col(*j).iter().any(|v| *v != 0.0);
        let Some(first) = (0..part.ncols()).find(reaches) else {
            continue;
        };
        let last = (first..part.ncols()).rfind(reaches).unwrap_or(first);
        let count = last + 1 - first;
        let part = part.subcols(first, count);
        add_gram(out.as_mut().submatrix_mut(first, first, count, count), part);
    }
    out
}

/// x := L^-1 x, skipping the supernodes that the loads do not reach.
fn forward_solve(factor: &supernodal::SupernodalLltRef<'_, usize, f64>, mut x: MatMut<'_, f64>) {
    let symbolic = factor.symbolic();
    let columns = x.ncols();
    let mut update = Vec::new();
    for s in 0..symbolic.n_supernodes() {
        let node = factor.supernode(s);
        let size = node.val().ncols();
        let start = node.start();
        let reached = (0..columns).any(|j| (start..start + size).any(|i| x[(i, j)] != 0.0));
        if !reached {
            continue;
        }
        let (top, bottom) = node.val().split_at_row(size);
        solve_lower_triangular_in_place(top, x.as_mut().subrows_mut(start, size), Par::Seq);
        let below = node.pattern().len();
        update.resize(below * columns, 0.0);
        let mut product = MatMut::from_column_major_slice_mut(&mut update, below, columns);
        faer::linalg::matmul::matmul(
            product.as_mut(),
            Accum::Replace,
            bottom,
            x.as_ref().subrows(start, size),
            1.0,
            Par::Seq,
        );
        for j in 0..columns {
            for (k, row) in node.pattern().iter().enumerate() {
                x[(*row, j)] -= product[(k, j)];
            }
        }
    }
}

/// The lower-triangular last block of the factor as a dense matrix.
fn last_block(
    factor: &supernodal::SupernodalLltRef<'_, usize, f64>,
    inside: usize,
    size: usize,
) -> Mat<f64> {
    let mut block = Mat::zeros(size, size);
    for s in 0..factor.symbolic().n_supernodes() {
        let node = factor.supernode(s);
        let columns = node.val().ncols();
        for j in 0..columns {
            let Some(column) = (node.start() + j).checked_sub(inside) else {
                continue;
            };
            for i in j..columns {
                block[(column + i - j, column)] = node.val()[(i, j)];
            }
            for (k, row) in node.pattern().iter().enumerate() {
                block[(row - inside, column)] = node.val()[(columns + k, j)];
            }
        }
    }
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_columns_that_reach_few_rows_are_those_of_the_whole() {
        // 500 rows, 40 columns that begin ever further down, some with holes, one empty.
        let y = Mat::from_fn(500, 40, |i, j| {
            let inside = i >= 11 * j && j != 7 && (i / 100) % 3 != j % 3;
            if inside {
                (i * 7 + j * 13) as f64 % 5.0 - 2.0
            } else {
                0.0
            }
        });
        let found = gram(y.as_ref());
        for j in 0..40 {
            for i in j..40 {
                let expected: f64 = (0..500).map(|row| y[(row, i)] * y[(row, j)]).sum();
                assert!((found[(i, j)] - expected).abs() < 1e-9, "{i} {j}");
            }
        }
    }
}
