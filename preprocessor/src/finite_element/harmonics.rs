//! Which harmonics of a ring are solved: not all.
//!
//! The response M(phi) of one is the sum of e^{-i k phi} times the influence k teeth away,
//! which decays with k: it is analytic in phi but for the lowest harmonics, in which the body moves as a whole. So the
//! lowest are solved one by one and the others at some places only, close to Chebyshev's in u = ln tan(phi / 4), which
//! is odd about phi = pi, where M mirrors into its conjugate; polynomials in u give those between. The places are the
//! fewest that do so for every influence e^{-a |k|}, M = sinh a / (cosh a - cos phi), to [`TOLERANCE`].

use std::f64::consts::PI;

/// Largest error of a harmonic that is not solved over its value, for influences that decay exponentially.
pub(super) const TOLERANCE: f64 = 1e-7;
/// Decays a over which that is tried, per tooth: from a body that moves as a whole to teeth that do not feel each other.
const DECAYS: [f64; 2] = [0.01, 4.0];
const TRIALS: usize = 24;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solved {
    pub harmonic: usize,
    /// Weights of the even and of the odd part of its response in the influence k teeth away, k from 0:
    /// C_k = sum over the solved ones of even M' - odd M'', M = M' + i M''.
    pub weights: Vec<[f64; 2]>,
}

/// The harmonics to be solved for a ring of `teeth` and influences up to `reach` teeth away.
pub(super) fn solved(teeth: usize, reach: usize) -> Vec<Solved> {
    let mut best = Places::all(teeth);
    for low in 3..=16 {
        for points in (10..=80).step_by(2) {
            let trial = Places::new(teeth, low, points);
            if trial.solved.len() < best.solved.len() && trial.error() < TOLERANCE {
                best = trial;
            }
        }
    }
    best.weighed(reach)
}

/// Every harmonic.
#[cfg(test)]
pub(super) fn all(teeth: usize, reach: usize) -> Vec<Solved> {
    Places::all(teeth).weighed(reach)
}

/// Harmonics that are solved, ascending: 0 to `low` - 1 and some of those above.
#[derive(Debug, Clone)]
struct Places {
    teeth: usize,
    low: usize,
    solved: Vec<usize>,
}

impl Places {
    /// Every harmonic.
    fn all(teeth: usize) -> Places {
        let low = teeth / 2 + 1;
        Places {
            teeth,
            low,
            solved: (0..low).collect(),
        }
    }

    /// The harmonics with their weights in the influences up to `reach` teeth away.
    fn weighed(&self, reach: usize) -> Vec<Solved> {
        let top = self.teeth / 2;
        let unweighed = self.solved.iter().map(|&harmonic| Solved {
            harmonic,
            weights: vec![[0.0; 2]; reach + 1],
        });
        let mut found: Vec<Solved> = unweighed.collect();
        for n in 0..=top {
            // Harmonics n and z - n are conjugate.
            let alone = n == 0 || 2 * n == self.teeth;
            let weight = if alone { 1.0 } else { 2.0 } / self.teeth as f64;
            for (at, [even, odd]) in self.shares(n) {
                for (k, sum) in found[at].weights.iter_mut().enumerate() {
                    let (sin, cos) = (k as f64 * 2.0 * PI * n as f64 / self.teeth as f64).sin_cos();
                    sum[0] += weight * cos * even;
                    sum[1] += weight * sin * odd;
                }
            }
        }
        found
    }

    /// The harmonics next to `points` of Chebyshev's between `low` and its mirror image.
    fn new(teeth: usize, low: usize, points: usize) -> Places {
        let low = low.min(teeth / 2 + 1);
        let mut solved: Vec<usize> = (0..low).collect();
        let end = place(low, teeth);
        for i in 0..points {
            let u = end * (PI * i as f64 / (points - 1) as f64).cos();
            let n = (u.exp().atan() * 2.0 * teeth as f64 / PI).round() as usize;
            if n >= low && 2 * n <= teeth {
                solved.push(n);
            }
        }
        solved.sort_unstable();
        solved.dedup();
        Places { teeth, low, solved }
    }

    /// What each solved harmonic (counted as in [`solved`]) has in the harmonic `n`: shares of even and odd part.
    fn shares(&self, n: usize) -> Vec<(usize, [f64; 2])> {
        if let Ok(at) = self.solved.binary_search(&n) {
            return vec![(at, [1.0; 2])];
        }
        let between = &self.solved[self.low..];
        let u = place(n, self.teeth);
        let own = |n: &usize| place(*n, self.teeth);
        let middle = |n: &usize| 2 * n == self.teeth;
        // Lagrange's polynomial that is one at `at` and zero at all other places and mirror images.
        let lagrange = |at: f64| -> f64 {
            let mut value = 1.0;
            for other in between {
                let q = own(other);
                for q in [q, -q].into_iter().take(if middle(other) { 1 } else { 2 }) {
                    if (q - at).abs() > 1e-9 {
                        value *= (u - q) / (at - q);
                    }
                }
            }
            value
        };
        let both = between.iter().enumerate().map(|(i, n)| {
            let here = lagrange(own(n));
            let image = if middle(n) { 0.0 } else { lagrange(-own(n)) };
            (self.low + i, [here + image, here - image])
        });
        both.collect()
    }

    /// Largest error of a harmonic that is not solved over its value, even and odd part.
    fn error(&self) -> f64 {
        let top = self.teeth / 2;
        // Many teeth: some of the harmonics tell of all.
        let step = (top / 64).max(1);
        let mut worst = 0.0f64;
        for n in (self.low..=top).step_by(step) {
            if self.solved.binary_search(&n).is_ok() {
                continue;
            }
            let shares = self.shares(n);
            for trial in 0..TRIALS {
                let share = trial as f64 / (TRIALS - 1) as f64;
                let a = DECAYS[0] * (DECAYS[1] / DECAYS[0]).powf(share);
                let parts = |n: usize| {
                    let phi = 2.0 * PI * n as f64 / self.teeth as f64;
                    let below = a.cosh() - phi.cos();
                    [a.sinh() / below, phi.sin() / below]
                };
                let mut error = parts(n).map(|part| -part);
                for (at, share) in &shares {
                    let solved = parts(self.solved[*at]);
                    for part in 0..2 {
                        error[part] += share[part] * solved[part];
                    }
                }
                let scale = parts(n)[0];
                let errors = error.map(|error| error.abs() / scale);
                worst = errors.into_iter().fold(worst, f64::max);
            }
            if worst.is_nan() || worst > TOLERANCE {
                return f64::INFINITY;
            }
        }
        worst
    }
}

/// u of the harmonic `n`.
fn place(n: usize, teeth: usize) -> f64 {
    (0.5 * PI * n as f64 / teeth as f64).tan().ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_teeth_need_few_harmonics_and_few_teeth_all() {
        for (teeth, most) in [
            (4, 3),
            (17, 9),
            (23, 12),
            (40, 17),
            (81, 22),
            (300, 32),
            (5000, 50),
        ] {
            let found = solved(teeth, 2);
            assert!(found.len() <= most, "{teeth}: {}", found.len());
            assert!(found.iter().all(|s| 2 * s.harmonic <= teeth));
        }
        assert_eq!(solved(17, 2).len(), 9);
    }
}
