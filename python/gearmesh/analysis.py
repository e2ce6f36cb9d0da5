"""Orders, spectra over speed and levels, from time histories with the angle of a shaft."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .dynamics import Array, History
from .errors import GearmeshError


@dataclass(frozen=True)
class Orders:
    """Amplitudes over order and speed.

    Attributes
    ----------
    speed_rpm, time_s : (n,)
        Of the middle of each window.
    order : (m,)
        Events per turn of the shaft.
    amplitude : (n, m)
        In the unit of the signal, 0 to peak.
    signal
        Name of the signal, with its unit.
    """

    speed_rpm: Array
    time_s: Array
    order: Array
    amplitude: Array
    signal: str

    def of(self, order: float) -> Array:
        """Amplitude of one order over the windows, (n,)."""
        found = np.flatnonzero(np.isclose(self.order, order))
        if not len(found):
            raise GearmeshError(f"order {order} was not analysed: choose one of {', '.join(f'{o:g}' for o in self.order)}")
        return self.amplitude[:, found[0]]

    def level_db(self, reference: float) -> Array:
        """Amplitudes in dB re `reference`, in the unit of the signal, (n, m)."""
        return decibels(self.amplitude, reference)


@dataclass(frozen=True)
class Campbell:
    """Amplitudes over frequency and speed.

    Attributes
    ----------
    speed_rpm, time_s : (n,)
        Mean speed and middle of each window.
    frequency_hz : (m,)
    amplitude : (n, m)
        In the unit of the signal, 0 to peak.
    signal
        Name of the signal, with its unit.
    """

    speed_rpm: Array
    time_s: Array
    frequency_hz: Array
    amplitude: Array
    signal: str

    def level_db(self, reference: float) -> Array:
        """Amplitudes in dB re `reference`, in the unit of the signal, (n, m)."""
        return decibels(self.amplitude, reference)


def decibels(amplitude: Array | float, reference: float) -> Array:
    """20 log10 of amplitudes over a reference.

    Parameters
    ----------
    amplitude
        0 or more; 0 becomes -inf.
    reference
        In the same unit, > 0.

    Returns
    -------
    ndarray
        dB re `reference`, of the shape of `amplitude`.
    """
    if not reference > 0.0:
        raise GearmeshError(f"reference = {reference}: give a positive amplitude in the unit of the signal")
    with np.errstate(divide="ignore"):
        return 20.0 * np.log10(np.asarray(amplitude, dtype=float) / reference)


def orders(history: History, signal: str, orders: Sequence[float], revolutions: float) -> Orders:
    """Amplitudes of orders over windows of the shaft's angle.

    A Hann window over the angle passes an order that is 2 / `revolutions` away from those asked for not at all, and
    nearer ones in part. Windows overlap by half. The mean over each window is left out.

    Parameters
    ----------
    history
        Whose angle moves in one sense.
    signal
        Its signal to analyse.
    orders
        Events per turn, not necessarily whole.
    revolutions
        Length of a window, turns of the shaft; a whole number of periods of the orders leaves none of one in another.

    Returns
    -------
    Orders

    Raises
    ------
    GearmeshError
        The history is shorter than a window, or has less than 16 samples in each.
    """
    angle = np.abs(history.angle_rad - history.angle_rad[0])
    edges = np.arange(0.0, angle[-1], np.pi * revolutions)
    cuts = np.searchsorted(angle, edges)
    wanted = np.asarray(orders, dtype=float)
    windows = [(a, b) for a, b in zip(cuts[:-2], cuts[2:]) if b - a >= 16]
    if not windows:
        raise GearmeshError(f"revolutions = {revolutions}: the history has no window of that length with 16 samples or more")
    rows = []
    for a, b in windows:
        part, turn = history[signal][a:b], angle[a:b]
        weights = np.hanning(b - a) * np.gradient(turn)
        part = part - np.average(part, weights=weights)
        rows.append(2.0 * np.abs(np.exp(-1j * np.outer(wanted, turn)) @ (part * weights)) / weights.sum())
    middle = [(a + b) // 2 for a, b in windows]
    return Orders(history.speed_rpm[middle], history.time_s[middle], wanted, np.array(rows), signal)


def campbell(history: History, signal: str, window_s: float = 0.04) -> Campbell:
    """Spectra over speed: short Fourier transforms with a Hann window that overlap by three quarters.

    Parameters
    ----------
    history
        With evenly spaced times.
    signal
        Its signal to analyse.
    window_s
        Length of a window; frequencies are 1 / `window_s` apart.

    Returns
    -------
    Campbell

    Raises
    ------
    GearmeshError
        The history is shorter than a window.
    """
    step = history.time_s[1] - history.time_s[0]
    count = round(window_s / step)
    starts = np.arange(0, len(history.time_s) - count + 1, max(count // 4, 1))
    if not len(starts):
        raise GearmeshError(f"window_s = {window_s}: the history lasts {step * len(history.time_s):.4g} s only")
    window = np.hanning(count)
    parts = np.array([history[signal][a : a + count] for a in starts])
    rows = 2.0 * np.abs(np.fft.rfft(window * (parts - parts.mean(axis=1, keepdims=True)))) / window.sum()
    speed = np.array([history.speed_rpm[a : a + count].mean() for a in starts])
    return Campbell(speed, history.time_s[starts + count // 2], np.fft.rfftfreq(count, step), rows, signal)


def swing(history: History, signal: str, window_s: float = 0.01) -> tuple[Array, Array]:
    """Half of the peak-to-peak of a signal over speed.

    Parameters
    ----------
    history, signal
        As in `campbell`.
    window_s
        Length of the windows, one after the other; at least one mesh cycle.

    Returns
    -------
    speed_rpm, swing : (n,)
        Mean speed of each window, and the swing in the unit of the signal.
    """
    speed, values = (_windows(history, x, window_s) for x in (history.speed_rpm, history[signal]))
    return speed.mean(axis=1), 0.5 * np.ptp(values, axis=1)


def is_outside(history: History, window_s: float = 0.01) -> NDArray[np.bool_]:
    """Windows of `swing` in which poses or loads lie outside the range of the tables, (n,)."""
    return _windows(history, history["out_of_range"], window_s).any(axis=1)


def _windows(history: History, values: Array, window_s: float) -> Array:
    """Rows of `values` in windows one after the other; a shorter rest is left out."""
    count = round(window_s / (history.time_s[1] - history.time_s[0]))
    return values[: len(values) // count * count].reshape(-1, count)
