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
