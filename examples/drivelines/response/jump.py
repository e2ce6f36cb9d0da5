"""Slow run-up and run-down of the spur pair through its resonance: gear 1 turns as imposed, gear 2 drags a torque."""

from __future__ import annotations

import numpy as np
from gearmesh import GearPair

from ..files import local
from ..integrate import runge_kutta

TEETH = 50
INERTIA = 7.6e-3  # kg m^2, a steel disc of 150 mm and 20 mm
PITCH_RADIUS = 75e-3
DAMPING = 1100.0  # N s/m
RPM = np.pi / 30.0


def sweep(start: float, end: float, torque: float = 150.0, duration: float = 1.6, step: float = 1e-5):
    """Speed, rpm, and swing (half of peak to peak) of the transmission error, m, in windows of 10 ms; share of time apart."""
    count = round(duration / step)
    window = round(0.01 / step)
    rate = (end - start) * RPM / duration
    with GearPair(local("spur-50-50"), {"damping": DAMPING}, "model-exchange") as pair:
        pair.initialize()
        spin1, rate1 = pair.input["gear1.angles[3]"], pair.input["gear1.angularVelocity[3]"]
        spin2, rate2 = pair.input["gear2.angles[3]"], pair.input["gear2.angularVelocity[3]"]
        moment, error = pair.output["gear2.moment[3]"], pair.output["mesh.transmissionError"]
        u, y = pair.u, pair.y

        def motion(time, z):
            u[spin1], u[rate1] = time * (start * RPM + 0.5 * rate * time), start * RPM + rate * time
            u[spin2], u[rate2] = z
            pair.evaluate(time)
            # The mean acceleration is taken off the torque, so that the teeth carry the same load up and down.
            return np.array([z[1], (y[moment] + torque) / INERTIA - rate])

        state = np.array([0.0, -start * RPM])
        values, apart = np.empty(count), np.empty(count, dtype=bool)
        for n in range(count):
            motion(n * step, state)
            values[n], apart[n] = y[error], y[moment] == 0.0
            state = runge_kutta(motion, n * step, state, step)
    parts = values[: count // window * window].reshape(-1, window)
    speeds = start + (end - start) * (np.arange(len(parts)) + 0.5) * window / count
    return speeds, 0.5 * np.ptp(parts, axis=1), apart[: parts.size].reshape(parts.shape).mean(axis=1)


def jump(speeds: np.ndarray, swing: np.ndarray) -> float:
    """Speed at the largest relative change from window to window, rpm."""
    return float(speeds[1:][np.argmax(np.abs(np.diff(np.log(swing))))])
