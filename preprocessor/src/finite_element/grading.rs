//! Stations along a length, finer where it counts.

/// `from` to `to` in equal steps of about `size`.
pub fn divide(from: f64, to: f64, size: f64) -> Vec<f64> {
    let steps = (((to - from).abs() / size).round() as usize).max(1);
    // The last station exactly: rounding must not put it on the other side of a corner.
    (0..steps)
        .map(|i| from + (to - from) * i as f64 / steps as f64)
        .chain([to])
        .collect()
}

/// Fractions 0 to 1 of `length`, starting with steps of `first` that grow by `growth` up to
/// `largest`; at least two steps.
pub fn graded(length: f64, first: f64, growth: f64, largest: f64) -> Vec<f64> {
    let mut ends = vec![0.0];
    let mut step = first;
    let mut reached = 0.0;
    while reached < length - 0.4 * step || ends.len() < 3 {
        reached += step;
        ends.push(reached);
        step = (step * growth).min(largest);
    }
    ends.iter().map(|x| x / reached).collect()
}

/// Fractions 0 to 1 of `length`, with steps that start from `first` at both ends, grow by `growth` up to `largest` and
/// meet; at least two steps. Seen from the other end they are the same.
pub fn graded_from_both(length: f64, first: [f64; 2], growth: f64, largest: f64) -> Vec<f64> {
    if first[0] == first[1] {
        let half = graded(0.5 * length, first[0].min(0.5 * length), growth, largest);
        let half = if 0.5 * length <= 1.4 * first[0] {
            vec![0.0, 1.0]
        } else {
            half
        };
        let up = half.iter().map(|t| 0.5 * t);
        let down = half.iter().rev().skip(1).map(|t| 1.0 - 0.5 * t);
        return up.chain(down).collect();
    }
    let mut next = first.map(|step| step.min(largest));
    let mut steps = [Vec::new(), Vec::new()];
    let mut reached = 0.0;
    loop {
        // The finer end goes ahead, of two that are alike the one that began finer.
        let side = usize::from(next[1] < next[0] || (next[1] == next[0] && first[1] < first[0]));
        let count = steps[0].len() + steps[1].len();
        let short = reached < length - 0.4 * next[side];
        if count >= 2 && !short {
            break;
        }
        reached += next[side];
        steps[side].push(next[side]);
        next[side] = (next[side] * growth).min(largest);
    }
    let [low, high] = steps;
    let all = low.into_iter().chain(high.into_iter().rev());
    let mut ends = vec![0.0];
    let mut sum = 0.0;
    for step in all {
        sum += step / reached;
        ends.push(sum);
    }
    if let Some(end) = ends.last_mut() {
        *end = 1.0;
    }
    ends
}

/// The same stations with the middle of each step put in between.
pub fn halved(stations: &[f64]) -> Vec<f64> {
    let mut out = vec![stations[0]];
    for w in stations.windows(2) {
        out.push(0.5 * (w[0] + w[1]));
        out.push(w[1]);
    }
    out
}
