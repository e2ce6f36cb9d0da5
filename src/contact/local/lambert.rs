//! The root v > 1 of v - ln v = t for t > 1, which inverts the law of Hertz: v = -W(-e^-t), W the lower branch of Lambert's
//! function.
//!
//! With sigma = sqrt(t - 1), v is smooth down to the branch point, v = 1 + sqrt(2) sigma + ...: fifth-degree polynomials
//! that take value and two derivatives at both ends of each piece are within 1e-13 of it.

use std::sync::LazyLock;

use crate::f64x4::F64x4;

/// Range of sigma in pieces.
const FIRST: f64 = 0.3125;
const STEP: f64 = 1.0 / 32.0;
const PIECES: usize = 200;

/// Up to here, in t, the pieces reach.
const LAST_T: f64 = 1.0 + (FIRST + STEP * PIECES as f64) * (FIRST + STEP * PIECES as f64);
/// From here on.
const FIRST_T: f64 = 1.0 + FIRST * FIRST;

/// Coefficients over the fraction of a piece.
static TABLE: LazyLock<Vec<[f64; 6]>> = LazyLock::new(|| {
    let node = |k: usize| {
        let sigma = FIRST + STEP * k as f64;
        let v = root(1.0 + sigma * sigma);
        let (by_t, twice) = (v / (v - 1.0), -v / (v - 1.0).powi(3));
        let by_sigma = 2.0 * sigma * by_t;
        let bend = 2.0 * by_t + 4.0 * sigma * sigma * twice;
        [v, STEP * by_sigma, STEP * STEP * bend]
    };
    (0..PIECES)
        .map(|k| {
            let ([a, a1, a2], [b, b1, b2]) = (node(k), node(k + 1));
            // What the parabola at the lower end leaves over at the upper one.
            let rest = [b - a - a1 - 0.5 * a2, b1 - a1 - a2, b2 - a2];
            [
                a,
                a1,
                0.5 * a2,
                10.0 * rest[0] - 4.0 * rest[1] + 0.5 * rest[2],
                -15.0 * rest[0] + 7.0 * rest[1] - rest[2],
                6.0 * rest[0] - 3.0 * rest[1] + 0.5 * rest[2],
            ]
        })
        .collect()
});

/// The root by Newton's method.
fn root(t: f64) -> f64 {
    let mut v = start(t);
    for _ in 0..20 {
        let step = (v - v.ln() - t) / (1.0 - v.recip());
        v -= step;
        // Quadratic: what is left is the square of it.
        if step.abs() <= 1e-9 * v {
            break;
        }
    }
    v
}

/// The root within 3e-4: Barry, Culligan-Hensley, Barry (1995), Real values of the W-function, ACM Transactions on
/// Mathematical Software 21, 161-171.
fn start(t: f64) -> f64 {
    let sigma = t - 1.0;
    let root = sigma.sqrt();
    let falling = 1.0 - 0.0042 * sigma * (-0.0201 * root).exp();
    let inner = 1.0 + 0.3361 * std::f64::consts::FRAC_1_SQRT_2 * root / falling;
    1.0 + sigma + 2.0 / 0.3361 * (1.0 - inner.recip())
}

/// The root v at `t` > 1.
pub fn root_at(t: f64) -> f64 {
    if (FIRST_T..LAST_T).contains(&t) {
        roots_at(F64x4::splat(t)).0[0]
    } else {
        root(t)
    }
}

/// Whether [`roots_at`] holds `t`.
#[inline(always)]
pub fn is_held(t: F64x4) -> bool {
    (t - FIRST_T).min(-t + LAST_T).are_positive()
}

/// The roots at `t`, which [`is_held`].
#[inline(always)]
pub fn roots_at(t: F64x4) -> F64x4 {
    // Added to a number of this size, another one is rounded to a whole number, which the last digits hold.
    const LARGE: f64 = 6_755_399_441_055_744.0;
    let place = ((t - 1.0).sqrt() - FIRST) * (1.0 / STEP);
    let rounded = (place - 0.5) + LARGE;
    let x = place - (rounded - LARGE);
    let table: &[[f64; 6]] = &TABLE;
    let pieces = rounded.0.map(|r| {
        let piece = (r.to_bits() & 0xffff) as usize;
        &table[piece.min(PIECES - 1)]
    });
    let c = |power: usize| F64x4(pieces.map(|piece| piece[power]));
    c(0) + x * (c(1) + x * (c(2) + x * (c(3) + x * (c(4) + x * c(5)))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_satisfies_its_equation_all_over_the_range() {
        for i in 0..20_000 {
            let t = FIRST_T + (60.0 - FIRST_T) * f64::from(i) / 20_000.0;
            let v = root_at(t);
            let error = (v - v.ln() - t) / (1.0 - v.recip());
            assert!(error.abs() < 1e-13 * v, "{t}: {v} {error}");
        }
        // Next to the branch point.
        let v = root_at(1.0 + 1e-4);
        assert!((v - v.ln() - 1.0001).abs() < 1e-14);
    }
}
