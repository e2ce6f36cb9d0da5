//! Swings, orders and spectra over the speed.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::Complex;

use super::History;

/// Values over the mean speed of a window, rad/s.
pub type OverSpeed = Vec<(f64, f64)>;

impl History {
    /// Rows of windows of `duration` s, one after the other, each with its mean speed, rad/s.
    pub fn windows(&self, duration: f64) -> Vec<(f64, Range<usize>)> {
        let count = self.samples(duration);
        let whole = self.time.len() / count;
        (0..whole)
            .map(|k| self.window(k * count..(k + 1) * count))
            .collect()
    }

    fn window(&self, rows: Range<usize>) -> (f64, Range<usize>) {
        let speeds = &self.speed[rows.clone()];
        (speeds.iter().sum::<f64>() / speeds.len() as f64, rows)
    }

    /// Samples in `duration` s, at least one.
    fn samples(&self, duration: f64) -> usize {
        let step = self
            .time
            .get(1)
            .map_or(duration, |time| time - self.time[0]);
        ((duration / step).round() as usize).max(1)
    }

    /// Half of the peak-to-peak of `signal` in windows of `duration` s.
    pub fn swing(&self, signal: &[f64], duration: f64) -> OverSpeed {
        let windows = self.windows(duration).into_iter();
        windows
            .map(|(speed, rows)| {
                let low = signal[rows.clone()]
                    .iter()
                    .copied()
                    .fold(f64::INFINITY, f64::min);
                let high = signal[rows]
                    .iter()
                    .copied()
                    .fold(f64::NEG_INFINITY, f64::max);
                (speed, 0.5 * (high - low))
            })
            .collect()
    }

    /// Amplitude, 0 to peak, of what repeats `order` times a turn of gear 1 in `signal`, in windows of `turns` of gear 1 that overlap
    /// by half. With the angle theta of gear 1, each window from theta0 on,
    ///
    /// amplitude = 2 |sum w(theta_i) (x_i - mean) e^(-j order theta_i) dtheta_i| / sum w(theta_i) dtheta_i,
    ///
    /// w(theta) = sin^2((theta - theta0) / (2 turns)), dtheta_i = (theta_i+1 - theta_i-1) / 2,
    ///
    /// and the mean by the same weights. As Hann's window w lies over the angle, no order that is a multiple of 1 / `turns`, and
    /// 2 / `turns` or more, away enters, however the speed changes. The speed of a window is the mean by these weights.
    pub fn order(&self, signal: &[f64], order: f64, turns: f64) -> OverSpeed {
        let found = self.phasors(signal, order, turns).into_iter();
        found
            .map(|(speed, phasor)| (speed, phasor.norm()))
            .collect()
    }

    /// What `order` takes the amplitude of: a cos(`order` theta + b) has a e^(j b), with theta from the first sample on.
    fn phasors(&self, signal: &[f64], order: f64, turns: f64) -> Vec<(f64, Complex<f64>)> {
        let angles = self.angle.iter().map(|a| (a - self.angle[0]).abs());
        let angles: Vec<f64> = angles.collect();
        let Some(last) = angles.last() else {
            return Vec::new();
        };
        let half = PI * turns;
        let count = (last / half) as usize;
        (1..count)
            .map(|k| {
                let [start, end] = [-1.0, 1.0].map(|side| (k as f64 + side) * half);
                // Angles rise, but for the swing of the teeth.
                let [first, after] =
                    [start, end].map(|edge| angles.partition_point(|angle| *angle < edge));
                let weight = |i: usize| {
                    let neighbours = [i.saturating_sub(1), (i + 1).min(angles.len() - 1)];
                    let [before, next] = neighbours.map(|i| angles[i]);
                    hann((angles[i] - start) / (end - start)) * 0.5 * (next - before)
                };
                Window {
                    rows: first..after,
                    weights: (first..after).map(weight).collect(),
                }
            })
            .filter(|window| window.rows.len() >= 16)
            .map(|window| {
                let phasor = window.phasor(signal, |i| order * angles[i]);
                (window.mean(&self.speed), phasor)
            })
            .collect()
    }

    /// Amplitude, 0 to peak, of each of `frequencies` (Hz) in `signal`, in Hann windows of `duration` s that overlap by half, a row
    /// for each window.
    pub fn spectra(
        &self,
        signal: &[f64],
        frequencies: &[f64],
        duration: f64,
    ) -> Vec<(f64, Vec<f64>)> {
        let count = self.samples(duration);
        let share = |k: usize| (k as f64 + 0.5) / count as f64;
        let weights: Vec<f64> = (0..count).map(|k| hann(share(k))).collect();
        let starts = (0..self.time.len()).step_by((count / 2).max(1));
        starts
            .take_while(|start| start + count <= self.time.len())
            .map(|start| {
                let (speed, rows) = self.window(start..start + count);
                let weights = weights.clone();
                let window = Window { rows, weights };
                let amplitude = |f| window.phasor(signal, |i| TAU * f * self.time[i]).norm();
                (speed, frequencies.iter().map(amplitude).collect())
            })
            .collect()
    }
}

/// Hann's window at a share, 0 to 1, of its length.
fn hann(share: f64) -> f64 {
    0.5 - 0.5 * (TAU * share).cos()
}

/// Rows with the weight of each.
struct Window {
    rows: Range<usize>,
    weights: Vec<f64>,
}

impl Window {
    fn weighted(&self) -> impl Iterator<Item = (usize, f64)> {
        self.rows.clone().zip(self.weights.iter().copied())
    }

    fn mean(&self, signal: &[f64]) -> f64 {
        let sum: f64 = self.weighted().map(|(i, weight)| weight * signal[i]).sum();
        sum / self.weights.iter().sum::<f64>()
    }

    /// a e^(j b) of a cos(phase + b) in `signal`, without the mean.
    fn phasor(&self, signal: &[f64], phase: impl Fn(usize) -> f64) -> Complex<f64> {
        let mean = self.mean(signal);
        let terms = self
            .weighted()
            .map(|(i, weight)| Complex::from_polar(weight * (signal[i] - mean), -phase(i)));
        terms.sum::<Complex<f64>>() * 2.0 / self.weights.iter().sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gear 1 from 100 rad/s on, `rise` rad/s faster each second, for `duration` s; order 20 with the amplitude 3 and order 22 with 1.
    fn rising_by(rise: f64, duration: f64) -> (History, Vec<f64>) {
        let count = (duration / 5e-5) as usize;
        let time: Vec<f64> = (0..count).map(|i| i as f64 * 5e-5).collect();
        let angle = time.iter().map(|t| 100.0 * t + 0.5 * rise * t * t);
        let angle: Vec<f64> = angle.collect();
        let signal = angle
            .iter()
            .map(|a| 7.0 + 3.0 * (20.0 * a + 1.0).cos() + (22.0 * a).sin());
        let signal = signal.collect();
        let speed = time.iter().map(|t| 100.0 + rise * t).collect();
        let history = History {
            time,
            angle,
            speed,
            ..History::default()
        };
        (history, signal)
    }

    fn history() -> (History, Vec<f64>) {
        rising_by(100.0, 1.0)
    }

    #[test]
    fn orders_are_found_with_their_amplitudes_at_every_speed() {
        let (history, signal) = history();
        for (order, expected) in [(20.0, 3.0), (22.0, 1.0), (30.0, 0.0)] {
            let found = history.order(&signal, order, 1.0);
            assert!(found.len() > 20, "{}", found.len());
            for (speed, amplitude) in found {
                assert!((100.0..200.0).contains(&speed));
                assert!(
                    (amplitude - expected).abs() < 1e-6,
                    "{order}: {amplitude} at {speed}"
                );
            }
        }
    }

    #[test]
    fn an_order_keeps_amplitude_and_phase_beside_its_neighbour_while_the_speed_rises_by_a_quarter()
    {
        // From 100 to 128 rad/s within a turn.
        let (history, signal) =
            rising_by((128.0f64.powi(2) - 100.0f64.powi(2)) / (2.0 * TAU), 0.056);
        for (order, expected) in [
            (18.0, Complex::ZERO),
            (20.0, Complex::from_polar(3.0, 1.0)),
            (22.0, Complex::from_polar(1.0, -0.5 * PI)),
            (24.0, Complex::ZERO),
        ] {
            let found = history.phasors(&signal, order, 1.0);
            assert_eq!(found.len(), 1);
            let error = (found[0].1 - expected).norm();
            assert!(error < 1e-6, "{order}: {error:e}");
        }
        // Near the speed at which half of the turn is over; 114 rad/s is that at which half of the time is.
        let middle = (0.5 * (100.0f64.powi(2) + 128.0f64.powi(2))).sqrt();
        let speed = history.order(&signal, 20.0, 1.0)[0].0;
        assert!((speed - middle).abs() < 0.2, "{speed} {middle}");
    }

    #[test]
    fn a_spectrum_peaks_where_the_order_is_and_the_swing_is_half_of_the_range() {
        let (history, signal) = history();
        let frequencies: Vec<f64> = (1..100).map(|k| 10.0 * f64::from(k)).collect();
        for (speed, row) in history.spectra(&signal, &frequencies, 0.02) {
            let largest = (0..row.len())
                .max_by(|a, b| row[*a].total_cmp(&row[*b]))
                .unwrap();
            let expected = 20.0 * speed / TAU;
            assert!((frequencies[largest] - expected).abs() < 30.0, "{speed}");
        }
        for (_, swing) in history.swing(&signal, 0.1) {
            assert!((swing - 4.0).abs() < 0.02, "{swing}");
        }
    }
}
