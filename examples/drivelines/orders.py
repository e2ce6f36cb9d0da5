"""Spectra of a run-up over speed, and amplitudes of orders."""

from __future__ import annotations

import numpy as np


def waterfall(time: np.ndarray, signal: np.ndarray, speed: np.ndarray, length: float = 0.04):
    """Amplitudes by short Fourier transforms with a Hann window of `length` s: mean speed, frequency (Hz), amplitudes.

    `speed` in rad/s; amplitudes have the signal's unit, a row for each window; windows overlap by three quarters.
    """
    step = time[1] - time[0]
    count = round(length / step)
    window = np.hanning(count)
    starts = range(0, len(signal) - count + 1, count // 4)
    rows = [2.0 * np.abs(np.fft.rfft(window * (s - s.mean()))) / window.sum() for s in (signal[a : a + count] for a in starts)]
    speeds = np.array([speed[a : a + count].mean() for a in starts])
    return speeds, np.fft.rfftfreq(count, step), np.array(rows)


def order_amplitude(angle: np.ndarray, signal: np.ndarray, order: float, cycles: float = 8.0):
    """Amplitude of an order of `angle` (rad) over windows of `cycles` periods: centre index and amplitude."""
    edges = np.arange(angle[0], angle[-1], 2.0 * np.pi * cycles / order)
    cuts = np.searchsorted(angle, edges)
    at, out = [], []
    for a, b in zip(cuts[:-2], cuts[2:]):
        if b - a < 16:
            continue
        window = np.hanning(b - a) * np.gradient(angle[a:b])
        part = signal[a:b] - np.average(signal[a:b], weights=window)
        out.append(2.0 * abs(np.sum(part * window * np.exp(-1j * order * angle[a:b]))) / window.sum())
        at.append((a + b) // 2)
    return np.array(at, dtype=int), np.array(out)
