//! Small systems of linear equations without allocation.

/// Most unknowns.
pub const SIZE: usize = 8;

/// Solves the first `n` rows and columns of `matrix`, for each of `R` right-hand sides in place.
///
/// Without exchange of rows, which matrices 1 + A with a norm of A below 1 do not need: all their leading blocks can be inverted.
pub fn solve<const R: usize>(
    matrix: &mut [[f64; SIZE]; SIZE],
    right: &mut [[f64; R]; SIZE],
    n: usize,
) {
    let n = n.min(SIZE);
    for i in 0..n {
        let (above, below) = matrix.split_at_mut(i + 1);
        let pivot = &above[i];
        let inverse = 1.0 / pivot[i];
        let (right_above, right_below) = right.split_at_mut(i + 1);
        for (row, right) in below.iter_mut().zip(right_below).take(n - i - 1) {
            let factor = row[i] * inverse;
            if factor == 0.0 {
                continue;
            }
            for j in i + 1..n {
                row[j] -= factor * pivot[j];
            }
            for (r, p) in right.iter_mut().zip(&right_above[i]) {
                *r -= factor * p;
            }
        }
    }
    for i in (0..n).rev() {
        let inverse = 1.0 / matrix[i][i];
        let (head, tail) = right.split_at_mut(i + 1);
        for (j, known) in (i + 1..n).zip(tail.iter()) {
            let factor = matrix[i][j];
            for (r, k) in head[i].iter_mut().zip(known) {
                *r -= factor * k;
            }
        }
        head[i].iter_mut().for_each(|r| *r *= inverse);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_solution_fulfils_the_equations() {
        let mut random = Random::new(1);
        for n in 1..=SIZE {
            let mut matrix = [[0.0; SIZE]; SIZE];
            let mut right = [[0.0; 3]; SIZE];
            for i in 0..n {
                for j in 0..n {
                    matrix[i][j] = random.within([-0.9, 0.9]) / n as f64 + f64::from(i == j);
                }
                right[i] = [0; 3].map(|_| random.within([-1.0, 1.0]));
            }
            let (before, wanted) = (matrix, right);
            solve(&mut matrix, &mut right, n);
            for i in 0..n {
                for r in 0..3 {
                    let sum: f64 = (0..n).map(|j| before[i][j] * right[j][r]).sum();
                    assert!((sum - wanted[i][r]).abs() < 1e-13);
                }
            }
        }
    }
}
