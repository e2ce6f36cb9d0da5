//! Sums over rows of a few numbers in vector registers: four lanes with AVX, else two.
//!
//! Both do the same operations in the same order, without fused multiply-add, so results are the same to the bit on
//! every machine. Besides the C interface, this is the one file with unsafe code.

use wide::f64x2;

/// The vector registers that the code around is compiled for.
#[derive(Debug, Clone, Copy)]
pub struct Lanes {
    avx: bool,
}

impl Lanes {
    /// Two lanes, which every x86-64 has; other processors in their own way.
    pub const COMMON: Lanes = Lanes { avx: false };

    /// The widest that this processor and its system have.
    pub fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        return Lanes {
            avx: std::arch::is_x86_feature_detected!("avx"),
        };
        #[cfg(not(target_arch = "x86_64"))]
        Lanes::COMMON
    }

    /// Whether there are four.
    pub fn are_wide(self) -> bool {
        self.avx
    }

    /// `work`, compiled for these registers with all that is inlined into it; a long closure is to be marked `inline(always)`, as
    /// all that it calls: else both kinds of registers share one. The registers that it gets are a constant there.
    #[inline(always)]
    pub fn run<T>(self, work: impl FnOnce(Lanes) -> T) -> T {
        #[cfg(target_arch = "x86_64")]
        if self.avx {
            #[target_feature(enable = "avx")]
            #[allow(unsafe_code)]
            fn compiled<T>(work: impl FnOnce(Lanes) -> T) -> T {
                work(Lanes { avx: true })
            }
            // Safety: only `widest` sets `avx`, after it has looked.
            #[allow(unsafe_code)]
            return unsafe { compiled(work) };
        }
        work(Lanes::COMMON)
    }

    /// `sum` += `factor` `row`.
    #[inline(always)]
    pub fn add<const N: usize>(self, sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
        self.combine::<true>(sum, factor, row);
    }

    /// `factor` `row`.
    #[inline(always)]
    pub fn scaled<const N: usize>(self, factor: f64, row: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        self.combine::<false>(&mut out, factor, row);
        out
    }

    /// `out` = `factor` `row`, with what it was before if `ADD`, by fours, pairs and what is left.
    #[inline(always)]
    fn combine<const ADD: bool>(self, mut out: &mut [f64], factor: f64, mut row: &[f64]) {
        #[cfg(target_arch = "x86_64")]
        if self.avx {
            let (fours, rest) = out.as_chunks_mut::<4>();
            let (row_fours, row_rest) = row.as_chunks::<4>();
            for (o, r) in fours.iter_mut().zip(row_fours) {
                // Safety: `avx` is set.
                #[allow(unsafe_code)]
                unsafe {
                    combine_four::<ADD>(o, factor, r);
                }
            }
            (out, row) = (rest, row_rest);
        }
        let (pairs, single) = out.as_chunks_mut::<2>();
        let (row_pairs, row_single) = row.as_chunks::<2>();
        for (o, r) in pairs.iter_mut().zip(row_pairs) {
            let mut sum = f64x2::splat(factor) * f64x2::new(*r);
            if ADD {
                sum += f64x2::new(*o);
            }
            *o = sum.to_array();
        }
        for (o, r) in single.iter_mut().zip(row_single) {
            *o = if ADD { *o + factor * r } else { factor * r };
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
#[allow(unsafe_code)]
#[inline]
fn combine_four<const ADD: bool>(out: &mut [f64; 4], factor: f64, row: &[f64; 4]) {
    use std::arch::x86_64::*;
    // Safety: all pointers are to four numbers.
    unsafe {
        let mut sum = _mm256_mul_pd(_mm256_set1_pd(factor), _mm256_loadu_pd(row.as_ptr()));
        if ADD {
            sum = _mm256_add_pd(_mm256_loadu_pd(out.as_ptr()), sum);
        }
        _mm256_storeu_pd(out.as_mut_ptr(), sum);
    }
}

/// Sum of products, by two lanes that are summed at the end.
#[inline(always)]
pub(crate) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let (a_pairs, a_single) = a.as_chunks::<2>();
    let (b_pairs, b_single) = b.as_chunks::<2>();
    let mut products = f64x2::ZERO;
    for (a, b) in a_pairs.iter().zip(b_pairs) {
        products += f64x2::new(*a) * f64x2::new(*b);
    }
    let [x, y] = products.to_array();
    let mut sum = x + y;
    for (x, y) in a_single.iter().zip(b_single) {
        sum += x * y;
    }
    sum
}
