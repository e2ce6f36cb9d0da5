//! Products and factors of dense matrices.

use super::FiniteElementError;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{self, LltRegularization};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::traits::ComplexField;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// a b.
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>, par: Par) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    matmul(out.as_mut(), Accum::Replace, a, b, 1.0, par);
    out
}

/// Puts the Cholesky factor L of the Hermitian matrix whose lower triangle `a` holds in its place.
///
/// # Errors
/// A matrix that is not positive definite; memory.
pub fn factor<T: ComplexField>(a: MatMut<'_, T>, par: Par) -> Result<(), FiniteElementError> {
    let scratch = factor::cholesky_in_place_scratch::<T>(a.nrows(), par, Default::default());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| FiniteElementError::Memory)?;
    let stack = MemStack::new(&mut memory);
    factor::cholesky_in_place(
        a,
        LltRegularization::default(),
        par,
        stack,
        Default::default(),
    )
    .map_err(|_| FiniteElementError::NotPositiveDefinite)?;
    Ok(())
}

/// Adds `factor` a^T a to the lower triangle of `out`.
pub fn add_gram(out: MatMut<'_, f64>, a: MatRef<'_, f64>, factor: f64, par: Par) {
    triangular::matmul(
        out,
        BlockStructure::TriangularLower,
        Accum::Add,
        a.transpose(),
        BlockStructure::Rectangular,
        a,
        BlockStructure::Rectangular,
        factor,
        par,
    );
}
