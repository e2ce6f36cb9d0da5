//! Samples of one quantity over the axes of a grid.

/// A dense array over (centre distance, misalignment, displacement, mesh position), the last index fastest.
#[derive(Debug, Clone)]
pub struct Block {
    pub lengths: [usize; 4],
    pub values: Vec<f64>,
}

impl Block {
    pub fn stride(&self, axis: usize) -> usize {
        self.lengths[axis + 1..].iter().product()
    }

    pub fn lines(&self, axis: usize) -> impl Iterator<Item = usize> + use<> {
        let (n, stride) = (self.lengths[axis], self.stride(axis));
        (0..self.values.len() / (n * stride))
            .flat_map(move |outer| (0..stride).map(move |inner| outer * n * stride + inner))
    }

    /// The block with every line along `axis` taken by `map` to one of the length `length`.
    pub fn mapped(
        &self,
        axis: usize,
        length: usize,
        mut map: impl FnMut(Vec<f64>) -> Vec<f64>,
    ) -> Block {
        let mut lengths = self.lengths;
        lengths[axis] = length;
        let mut out = Block {
            lengths,
            values: vec![0.0; lengths.iter().product()],
        };
        let stride = self.stride(axis);
        for (from, to) in self.lines(axis).zip(out.lines(axis)) {
            let line = self.values[from..].iter().step_by(stride);
            let line = map(line.take(self.lengths[axis]).copied().collect());
            for (k, value) in line.into_iter().enumerate() {
                out.values[to + k * stride] = value;
            }
        }
        out
    }
}

/// `values` to whole decimals that are at most `share` of the largest of them.
pub(super) fn rounded(values: &[f64], share: f64) -> Vec<f64> {
    let largest = values.iter().fold(0.0, |l: f64, v| l.max(v.abs()));
    let step = share * largest;
    if !(step.is_finite() && step > 0.0) {
        return values.to_vec();
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 300.0) as usize;
    // Formatting and parsing gives the double nearest to the decimals; `+ 0.0` makes -0 plain 0.
    let round = |x: &f64| format!("{x:.decimals$}").parse().unwrap_or(*x) + 0.0;
    values.iter().map(round).collect()
}

/// `values` to so many `digits`, but not beyond a tenth of the last digit of the largest of them.
pub(super) fn rounded_to(digits: usize, values: &[f64]) -> Vec<f64> {
    let after_first = digits - 1;
    let round = |x: f64| format!("{x:.after_first$e}").parse().unwrap_or(x);
    let share = 0.1 * 0.1f64.powi(digits as i32);
    rounded(values, share).into_iter().map(round).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_digits_down_to_a_share_of_the_largest() {
        let values = [4321.987654, -321.987654, 0.987654, 0.0004, -0.0004];
        let expected = [4322.0, -321.99, 0.988, 0.0, 0.0];
        assert_eq!(rounded_to(5, &values), expected);
        assert!(rounded_to(5, &values)[4].is_sign_positive());
        assert_eq!(rounded(&values, 1e-6)[0], 4321.988);
    }
}
