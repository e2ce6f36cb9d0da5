"""Slow run-up and run-down of the spur pair through its resonance: gear 1 turns as imposed, gear 2 drags a torque."""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
from gearmesh import GearPair

from ..balance import Ledger, followed, mesh_loss
from ..files import local
from ..integrate import runge_kutta

TEETH = 50
INERTIA = 7.6e-3  # kg m^2, a steel disc of 150 mm and 20 mm
PITCH_RADIUS = 75e-3
DAMPING = 1100.0  # N s/m
RPM = np.pi / 30.0


class Imposed:
    """Gear 1 at `start` rpm and evenly on to `start` + `change` rpm in a second, gear 2 dragging `torque`, N m.

    The state is the angle and speed of gear 2.
    """

    def __init__(self, pair: GearPair, start: float, change: float = 0.0, torque: float = 150.0):
        self.pair, self.start, self.change, self.torque = pair, start * RPM, change * RPM, torque
        into, out = pair.input, pair.output
        self.gears = [(into[f"gear{g}.angles[3]"], into[f"gear{g}.angularVelocity[3]"]) for g in (1, 2)]
        self.moments = [out[f"gear{g}.moment[3]"] for g in (1, 2)]

    def speed(self, time: float) -> float:
        return self.start + self.change * time

    def rate(self, time: float, z: np.ndarray) -> np.ndarray:
        u = self.pair.u
        (spin1, rate1), (spin2, rate2) = self.gears
        u[spin1], u[rate1] = time * (self.start + 0.5 * self.change * time), self.speed(time)
        u[spin2], u[rate2] = z
        self.pair.evaluate(time)
        # The mean acceleration is taken off the torque, so that the teeth carry the same load up and down.
        return np.array([z[1], (self.pair.y[self.moments[1]] + self.torque) / INERTIA - self.change])

    def accounts(self, time: float, z: np.ndarray) -> list[float]:
        """Power of the drive on gear 1 and of the torques on gear 2, and what the mesh loses."""
        fed = -self.pair.y[self.moments[0]] * self.speed(time) + (self.torque - self.change * INERTIA) * z[1]
        return [fed, mesh_loss(self.pair)]


@contextmanager
def imposed(damping: float, *motion: float):
    with GearPair(local("spur-50-50"), {"damping": damping}, "model-exchange") as pair:
        pair.initialize()
        yield Imposed(pair, *motion)


def sweep(start: float, end: float, torque: float = 150.0, duration: float = 1.6, step: float = 1e-5):
    """Speed, rpm, and swing (half of peak to peak) of the transmission error, m, in windows of 10 ms; share of time apart."""
    count = round(duration / step)
    window = round(0.01 / step)
    with imposed(DAMPING, start, (end - start) / duration, torque) as line:
        y, error = line.pair.y, line.pair.output["mesh.transmissionError"]
        state = np.array([0.0, -start * RPM])
        values, apart = np.empty(count), np.empty(count, dtype=bool)
        for n in range(count):
            first = line.rate(n * step, state)
            values[n], apart[n] = y[error], y[line.moments[1]] == 0.0
            state = runge_kutta(line.rate, n * step, state, step, first)
    parts = values[: count // window * window].reshape(-1, window)
    speeds = start + (end - start) * (np.arange(len(parts)) + 0.5) * window / count
    return speeds, 0.5 * np.ptp(parts, axis=1), apart[: parts.size].reshape(parts.shape).mean(axis=1)


def balance(damped: bool, rpm: float = 2200.0, duration: float = 0.03, step: float = 2.5e-6) -> dict[str, float]:
    """At a steady speed near resonance, from no load, so that teeth part: what energy and loads stray, over the run."""
    ledger, apart = Ledger(duration), []
    with imposed(DAMPING if damped else 0.0, rpm) as line:
        start = np.array([0.0, -rpm * RPM])
        for _, z, (work, lost) in followed(line.rate, line.accounts, start, step, round(duration / step), 40):
            apart.append(line.pair.flank == 0)
            ledger.enter([line.pair], 0.5 * INERTIA * z[1] ** 2, 0.0, lost, work)
    return ledger.found() | {"share of time apart": float(np.mean(apart))}


def jump(speeds: np.ndarray, swing: np.ndarray) -> float:
    """Speed at the largest relative change from window to window, rpm."""
    return float(speeds[1:][np.argmax(np.abs(np.diff(np.log(swing))))])
