//! What an evaluation is compiled for: vector registers, derivatives and, for what a simulation asks at every step,
//! the axes that a table has.

use super::basis::{Basis, Weights};
use super::lanes::{Four, Registers, Two, Within};
use super::{Checks, Evaluate};
use crate::table::{Potential, Query};

/// Axes that code finds out as it runs. A smaller number says that code is compiled for the axes of centre distance,
/// misalignment and mesh position whose bits 0 to 2 are set in it.
pub const ANY: usize = 8;

/// Whether `basis` of the `axis`th of centre distance, misalignment and mesh position has an extent.
#[inline(always)]
pub fn present<const AXES: usize, const N: usize>(axis: usize, basis: &Basis<N>) -> bool {
    if AXES == ANY {
        basis.present()
    } else {
        AXES >> axis & 1 == 1
    }
}

/// How many functions of that axis there are at one point.
#[inline(always)]
pub fn count<const AXES: usize, const N: usize>(axis: usize, weights: &Weights<N>) -> usize {
    if AXES == ANY {
        weights.count
    } else if AXES >> axis & 1 == 1 {
        N
    } else {
        1
    }
}

/// [`Basis::weights`] of that axis.
#[inline(always)]
pub fn weights<const AXES: usize, const N: usize>(
    (axis, basis): (usize, &Basis<N>),
    registers: impl Registers,
    x: f64,
    order: usize,
) -> (Weights<N>, bool) {
    if present::<AXES, N>(axis, basis) {
        basis.weights(registers, x, order)
    } else {
        (Weights::constant(), false)
    }
}

/// An [`Evaluate`] behind a pointer: the choices that are made at run time.
pub trait Interpolant: std::fmt::Debug + Send + Sync {
    fn evaluate(&self, four: Option<Four>, query: &Query, want_hessian: bool) -> Potential;
    fn checks(&self) -> Checks;
    fn bytes(&self) -> usize;
}

/// `T` with the axes `AXES`. Without second derivatives and with the registers that nearly every processor has, its
/// evaluation is compiled for these axes; else all share one (but a table without any). Each more would cost seconds of
/// every build.
#[derive(Debug)]
struct For<const AXES: usize, T>(T);

impl<const AXES: usize, T: Evaluate> Interpolant for For<AXES, T> {
    fn evaluate(&self, four: Option<Four>, query: &Query, want_hessian: bool) -> Potential {
        if const { AXES == ANY } {
            return shared(&self.0, four, query, want_hessian);
        }
        if want_hessian {
            // Without any axis there is little to compile, and little to gain by sharing.
            if const { AXES != 0 } {
                return shared(&self.0, four, query, true);
            }
            return self.0.at::<true, 0>(Within(Two), query);
        }
        if const { !T::WIDE } {
            return self.0.at::<false, AXES>(Within(Two), query);
        }
        match four {
            Some(four) => four.run(
                #[inline(always)]
                || self.0.at::<false, AXES>(Within(four), query),
            ),
            None => shared(&self.0, None, query, false),
        }
    }

    fn checks(&self) -> Checks {
        self.0.checks()
    }

    fn bytes(&self) -> usize {
        self.0.bytes()
    }
}

/// An evaluation for any axes.
#[inline(never)]
fn shared<T: Evaluate>(
    table: &T,
    four: Option<Four>,
    query: &Query,
    want_hessian: bool,
) -> Potential {
    if const { T::WIDE }
        && let Some(four) = four
    {
        return if want_hessian {
            table.at::<true, ANY>(four, query)
        } else {
            table.at::<false, ANY>(four, query)
        };
    }
    if want_hessian {
        table.at::<true, ANY>(Two, query)
    } else {
        table.at::<false, ANY>(Two, query)
    }
}

/// `table`, which finds out its axes as it runs.
pub fn boxed(table: impl Evaluate + 'static) -> Box<dyn Interpolant> {
    Box::new(For::<ANY, _>(table))
}

/// `table` compiled for the axes of centre distance, misalignment and mesh position that are `present`.
pub fn boxed_for(present: [bool; 3], table: impl Evaluate + 'static) -> Box<dyn Interpolant> {
    match present {
        [false, false, false] => Box::new(For::<0, _>(table)),
        [true, false, false] => Box::new(For::<1, _>(table)),
        [false, true, false] => Box::new(For::<2, _>(table)),
        [true, true, false] => Box::new(For::<3, _>(table)),
        [false, false, true] => Box::new(For::<4, _>(table)),
        [true, false, true] => Box::new(For::<5, _>(table)),
        [false, true, true] => Box::new(For::<6, _>(table)),
        [true, true, true] => Box::new(For::<7, _>(table)),
    }
}
