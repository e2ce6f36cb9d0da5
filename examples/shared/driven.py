"""Gear 1 turns as imposed, gear 2 drags a torque, as in `response`, `sweep` and `loss`: the balance of such a run."""

from __future__ import annotations

from math import pi

import numpy as np
from gearmesh import Turning, energy


def balance(turning: Turning, inertia: float, torque: float, rpm: float, start: float, duration: float, step: float) -> dict[str, float]:
    """At a steady speed of gear 1 under a torque (N m) on gear 2, which begins at the angle `start`: what energy and loads stray, over the run."""
    ratio, speed = turning.pair.geometry.ratio, rpm * pi / 30.0

    def rate(time: float, z: np.ndarray) -> np.ndarray:
        return np.array([z[1], (turning(speed * time, speed, *z.tolist())[1] + torque) / inertia])

    def accounts(_: float, z: np.ndarray) -> list[float]:
        """Power of the drive on gear 1 and of the torque on gear 2, and what the mesh loses."""
        return [-turning.moments()[0] * speed + torque * z[1], energy.mesh_loss(turning.pair)]

    begin = np.array([start, ratio * speed])
    return energy.balance([turning.pair], rate, begin, step, duration, accounts, lambda z: 0.5 * inertia * z[1] ** 2)
