"""Orders, spectra over speed and levels, from time histories with the angle of a shaft."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .dynamics import Array, History
from .errors import GearmeshError

#: How far a shaft that turns in one sense may swing back with its teeth, rad.
TURNED_BACK = np.pi / 50


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

    With the angle theta of the shaft, in each window from theta0 on,

        amplitude = 2 |sum w(theta_i) (x_i - mean) exp(-j order theta_i) dtheta_i| / sum w(theta_i) dtheta_i,

        w(theta) = sin^2((theta - theta0) / (2 revolutions)), dtheta_i = (theta_i+1 - theta_i-1) / 2,

    and the mean by the same weights. As Hann's window w lies over the angle, no order that is a multiple of
    1 / `revolutions`, and 2 / `revolutions` or more, away from those asked for enters, however the speed changes; nearer
    ones enter in part. Windows overlap by half.

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
        The history is shorter than a window, has less than 16 samples in each, or its shaft turns back.
    """
    wanted = np.asarray(orders, dtype=float)
    middle, phasors = _phasors(history, signal, wanted, revolutions)
    return Orders(history.speed_rpm[middle], history.time_s[middle], wanted, np.abs(phasors), signal)


def _phasors(history: History, signal: str, wanted: Array, revolutions: float) -> tuple[list[int], NDArray[np.complex128]]:
    """Row in the middle of each window, and what `orders` takes the amplitude of, (n, m): a cos(order theta + b) has
    a exp(j b), with theta from the first row on."""
    turned = history.angle_rad - history.angle_rad[0]
    angle = turned * np.sign(turned[-1])
    back = (np.maximum.accumulate(angle) - angle).max()
    if back > TURNED_BACK:
        raise GearmeshError(f"angle_rad turns back by {back:.3g} rad: give a history in which the shaft turns in one sense")
    if revolutions <= 0.0:
        raise GearmeshError(f"revolutions = {revolutions}: give a number above 0")
    steps = np.gradient(angle)
    half = np.pi * revolutions
    edges = half * np.arange(int(angle[-1] / half) + 1)
    cuts = np.searchsorted(angle, edges)
    windows = [window for window in zip(edges, cuts, cuts[1:], cuts[2:]) if window[3] - window[1] >= 16]
    if not windows:
        raise GearmeshError(f"revolutions = {revolutions}: the history has no window of that length with 16 samples or more")
    rows = []
    for start, a, _, b in windows:
        part, turn = history[signal][a:b], angle[a:b]
        weights = np.sin((turn - start) / (2.0 * revolutions)) ** 2 * steps[a:b]
        part = part - np.average(part, weights=weights)
        rows.append(2.0 * np.exp(-1j * np.outer(wanted, turn)) @ (part * weights) / weights.sum())
    return [middle for _, _, middle, _ in windows], np.array(rows)


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
