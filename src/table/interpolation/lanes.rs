//! Sums over the few lanes of vector registers: two with what every x86-64 has, four with AVX.
//!
//! Both do the same operations in the same order, without fused multiply-add, so results are the same to the
//! bit whatever the machine. Besides the C interface, this is the one file with unsafe code.

use wide::f64x2;

/// The vector registers that code is compiled for. A value of a type says that the processor has them.
pub trait Registers: Copy {
    /// `sum` += `factor` `row`.
    fn add<const N: usize>(self, sum: &mut [f64; N], factor: f64, row: &[f64; N]);

    /// `factor` `row`.
    fn scaled<const N: usize>(self, factor: f64, row: &[f64; N]) -> [f64; N];

    /// `work()`, compiled for these registers with all that is inlined into it, apart from the code around: what an
    /// evaluation has many of is compiled once.
    fn run<T>(self, work: impl FnOnce() -> T) -> T;
}

/// Two lanes, as every x86-64 has them; other processors in their own way.
#[derive(Debug, Clone, Copy)]
pub struct Two;

impl Registers for Two {
    #[inline(always)]
    fn add<const N: usize>(self, sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
        add_pairs(sum, factor, row);
    }

    #[inline(always)]
    fn scaled<const N: usize>(self, factor: f64, row: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        scale_pairs(&mut out, factor, row);
        out
    }

    #[inline(always)]
    fn run<T>(self, work: impl FnOnce() -> T) -> T {
        #[inline(never)]
        fn compiled<T>(work: impl FnOnce() -> T) -> T {
            work()
        }
        compiled(work)
    }
}

/// `out` = `factor` `row` by pairs and what is left.
#[inline(always)]
fn scale_pairs(out: &mut [f64], factor: f64, row: &[f64]) {
    let (pairs, single) = out.as_chunks_mut::<2>();
    let (row_pairs, row_single) = row.as_chunks::<2>();
    for (o, r) in pairs.iter_mut().zip(row_pairs) {
        *o = (f64x2::splat(factor) * f64x2::new(*r)).to_array();
    }
    for (o, r) in single.iter_mut().zip(row_single) {
        *o = factor * r;
    }
}

/// `sum` += `factor` `row` by pairs and what is left.
#[inline(always)]
fn add_pairs(sum: &mut [f64], factor: f64, row: &[f64]) {
    let (pairs, single) = sum.as_chunks_mut::<2>();
    let (row_pairs, row_single) = row.as_chunks::<2>();
    for (s, r) in pairs.iter_mut().zip(row_pairs) {
        *s = (f64x2::new(*s) + f64x2::splat(factor) * f64x2::new(*r)).to_array();
    }
    for (s, r) in single.iter_mut().zip(row_single) {
        *s += factor * r;
    }
}

/// Registers that the code around is compiled for already: nothing is apart from it.
#[derive(Debug, Clone, Copy)]
pub struct Within<R>(pub R);

impl<R: Registers> Registers for Within<R> {
    #[inline(always)]
    fn add<const N: usize>(self, sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
        self.0.add(sum, factor, row);
    }

    #[inline(always)]
    fn scaled<const N: usize>(self, factor: f64, row: &[f64; N]) -> [f64; N] {
        self.0.scaled(factor, row)
    }

    #[inline(always)]
    fn run<T>(self, work: impl FnOnce() -> T) -> T {
        work()
    }
}

/// Four lanes, AVX.
#[derive(Debug, Clone, Copy)]
pub struct Four {
    _detected: (),
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod avx {
    use super::{Four, Registers, add_pairs, scale_pairs};
    use std::arch::x86_64::{
        _mm256_add_pd, _mm256_loadu_pd, _mm256_mul_pd, _mm256_set1_pd, _mm256_storeu_pd,
    };

    impl Four {
        /// If the processor and its system have them.
        pub fn detect() -> Option<Self> {
            std::arch::is_x86_feature_detected!("avx").then_some(Four { _detected: () })
        }
    }

    impl Registers for Four {
        #[inline(always)]
        fn add<const N: usize>(self, sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
            let (fours, rest) = sum.as_chunks_mut::<4>();
            let (row_fours, row_rest) = row.as_chunks::<4>();
            for (s, r) in fours.iter_mut().zip(row_fours) {
                // Safety: `self` comes from `detect`.
                unsafe { add_four(s, factor, r) };
            }
            add_pairs(rest, factor, row_rest);
        }

        #[inline(always)]
        fn scaled<const N: usize>(self, factor: f64, row: &[f64; N]) -> [f64; N] {
            let mut out = [0.0; N];
            let (fours, rest) = out.as_chunks_mut::<4>();
            let (row_fours, row_rest) = row.as_chunks::<4>();
            for (o, r) in fours.iter_mut().zip(row_fours) {
                // Safety: `self` comes from `detect`.
                unsafe { scale_four(o, factor, r) };
            }
            scale_pairs(rest, factor, row_rest);
            out
        }

        #[inline(always)]
        fn run<T>(self, work: impl FnOnce() -> T) -> T {
            #[target_feature(enable = "avx")]
            fn compiled<T>(work: impl FnOnce() -> T) -> T {
                work()
            }
            // Safety: `self` comes from `detect`.
            unsafe { compiled(work) }
        }
    }

    #[target_feature(enable = "avx")]
    #[inline]
    fn scale_four(out: &mut [f64; 4], factor: f64, row: &[f64; 4]) {
        // Safety: both point to four numbers.
        let r = unsafe { _mm256_loadu_pd(row.as_ptr()) };
        let product = _mm256_mul_pd(_mm256_set1_pd(factor), r);
        // Safety: as above.
        unsafe { _mm256_storeu_pd(out.as_mut_ptr(), product) };
    }

    #[target_feature(enable = "avx")]
    #[inline]
    fn add_four(sum: &mut [f64; 4], factor: f64, row: &[f64; 4]) {
        // Safety: both point to four numbers.
        let (s, r) = unsafe { (_mm256_loadu_pd(sum.as_ptr()), _mm256_loadu_pd(row.as_ptr())) };
        let new = _mm256_add_pd(s, _mm256_mul_pd(_mm256_set1_pd(factor), r));
        // Safety: as above.
        unsafe { _mm256_storeu_pd(sum.as_mut_ptr(), new) };
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod avx {
    use super::{Four, Registers, Two};

    impl Four {
        /// None: this is no x86-64.
        pub fn detect() -> Option<Self> {
            None
        }
    }

    impl Registers for Four {
        fn add<const N: usize>(self, sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
            Two.add(sum, factor, row);
        }

        fn scaled<const N: usize>(self, factor: f64, row: &[f64; N]) -> [f64; N] {
            Two.scaled(factor, row)
        }

        fn run<T>(self, work: impl FnOnce() -> T) -> T {
            Two.run(work)
        }
    }
}

/// Sum of products. Lanes are summed at the end, in the same order everywhere.
#[inline(always)]
pub fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let (a_pairs, a_single) = a.as_chunks::<2>();
    let (b_pairs, b_single) = b.as_chunks::<2>();
    let mut sum = 0.0;
    if let ([a, a_rest @ ..], [b, b_rest @ ..]) = (a_pairs, b_pairs) {
        let mut products = f64x2::new(*a) * f64x2::new(*b);
        for (a, b) in a_rest.iter().zip(b_rest) {
            products += f64x2::new(*a) * f64x2::new(*b);
        }
        let [x, y] = products.to_array();
        sum = x + y;
    }
    for (x, y) in a_single.iter().zip(b_single) {
        sum += x * y;
    }
    sum
}
