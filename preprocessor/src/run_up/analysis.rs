//! Swings, orders and spectra over the speed.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

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

    /// Amplitude, 0 to peak, of what repeats `order` times a turn of gear 1 in `signal`, in Hann windows of `turns` of gear 1
    /// that overlap by half. An order 2 / `turns` away from it does not enter.
    pub fn order(&self, signal: &[f64], order: f64, turns: f64) -> OverSpeed {
        let angles = self.angle.iter().map(|a| (a - self.angle[0]).abs());
        let angles: Vec<f64> = angles.collect();
        let Some(last) = angles.last() else {
            return Vec::new();
        };
        let half = PI * turns;
        let count = (last / half) as usize;
        (1..count)
            .map(|k| {
                // Angles rise, but for the swing of the teeth.
                let [start, end] = [-1.0, 1.0]
                    .map(|side| (k as f64 + side) * half)
                    .map(|edge| angles.partition_point(|angle| *angle < edge));
                start..end
            })
            .filter(|rows| rows.len() >= 16)
            .map(|rows| {
                let (speed, rows) = self.window(rows);
                (speed, amplitude(signal, &rows, |i| order * angles[i]))
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
        let starts = (0..self.time.len()).step_by((count / 2).max(1));
        starts
            .take_while(|start| start + count <= self.time.len())
            .map(|start| {
                let (speed, rows) = self.window(start..start + count);
                (
                    speed,
                    frequencies
                        .iter()
                        .map(|f| amplitude(signal, &rows, |i| TAU * f * self.time[i]))
                        .collect(),
                )
            })
            .collect()
    }
}

/// Amplitude of cos(phase) in `signal` over `rows` under a Hann window, without the mean.
fn amplitude(signal: &[f64], rows: &Range<usize>, phase: impl Fn(usize) -> f64) -> f64 {
    let n = rows.len() as f64;
    let window = (0..rows.len()).map(|k| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n).cos());
    let window: Vec<f64> = window.collect();
    let weights: f64 = window.iter().sum();
    let mean = rows
        .clone()
        .zip(&window)
        .map(|(i, weight)| weight * signal[i])
        .sum::<f64>()
        / weights;
    let (mut real, mut imaginary) = (0.0, 0.0);
    for (i, weight) in rows.clone().zip(&window) {
        let (sin, cos) = phase(i).sin_cos();
        let value = weight * (signal[i] - mean);
        real += value * cos;
        imaginary += value * sin;
    }
    2.0 * f64::hypot(real, imaginary) / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gear 1 speeding up from 100 to 200 rad/s within a second; order 20 with the amplitude 3 and order 22 with 1.
    fn history() -> (History, Vec<f64>) {
        let time: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 5e-5).collect();
        let angle: Vec<f64> = time.iter().map(|t| 100.0 * t + 50.0 * t * t).collect();
        let signal = angle
            .iter()
            .map(|a| 7.0 + 3.0 * (20.0 * a + 1.0).cos() + (22.0 * a).sin());
        let signal = signal.collect();
        let speed = time.iter().map(|t| 100.0 + 100.0 * t).collect();
        let history = History {
            time,
            angle,
            speed,
            ..History::default()
        };
        (history, signal)
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
                    (amplitude - expected).abs() < 0.03,
                    "{order}: {amplitude} at {speed}"
                );
            }
        }
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
