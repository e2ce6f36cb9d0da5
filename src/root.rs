//! The one search for a root: halving an interval that holds it.

/// Where `is_below` turns from true to false between `low` and `high`: the middle of what is left of them after `halvings`.
/// It needs no more than that `is_below` turns once; where it never does, this is the end that it points to.
pub fn bisection(ends: [f64; 2], halvings: usize, is_below: impl FnMut(f64) -> bool) -> f64 {
    let [low, high] = bracket(ends, halvings, is_below);
    0.5 * (low + high)
}

/// What is left of the interval after `halvings`: the end at which `is_below` holds, and the one at which it does not.
pub fn bracket(
    [mut low, mut high]: [f64; 2],
    halvings: usize,
    mut is_below: impl FnMut(f64) -> bool,
) -> [f64; 2] {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::bisection;

    #[test]
    fn the_root_is_found_to_rounding_and_an_interval_without_one_ends_at_its_end() {
        assert!((bisection([0.0, 2.0], 60, |x| x * x < 2.0) - 2.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(bisection([0.0, 1.0], 60, |_| true), 1.0);
    }
}
