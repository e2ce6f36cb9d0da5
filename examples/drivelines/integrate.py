"""The classical Runge-Kutta method, for the examples that bring their own host."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


Rate = Callable[[float, np.ndarray], np.ndarray]


def runge_kutta(rate: Rate, time: float, state: np.ndarray, step: float, first: np.ndarray | None = None) -> np.ndarray:
    """The state after one step of `step` s of fourth order; `first` is `rate(time, state)`, where it is at hand."""
    k1 = rate(time, state) if first is None else first
    k2 = rate(time + 0.5 * step, state + 0.5 * step * k1)
    k3 = rate(time + 0.5 * step, state + 0.5 * step * k2)
    k4 = rate(time + step, state + step * k3)
    return state + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
