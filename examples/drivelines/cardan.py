"""From coordinates with Cardan angles x-y-z (spin last) to the unit's inputs, and back from its loads."""

from __future__ import annotations

from math import cos, sin

import numpy as np
from gearmesh import GearPair

# Where `GearPair.u` has position and angles, and velocity and angular velocity, of gear 1 and gear 2.
POSES, RATES = (slice(0, 6), slice(16, 22)), (slice(10, 16), slice(26, 32))


def place(pair: GearPair, q, q_t, reference) -> None:
    """Inputs of the unit from the coordinates of both nodes and their rates."""
    for k in (0, 1):
        x, y, z, a, b, c = q[6 * k : 6 * k + 6]
        vx, vy, vz, a_t, b_t, c_t = q_t[6 * k : 6 * k + 6]
        rx, ry, rz = reference[k]
        ca, sa, cb, sb = cos(a), sin(a), cos(b), sin(b)
        pair.u[POSES[k]] = x + rx, y + ry, z + rz, a, b, c
        # omega = a_t x + b_t Rx y + c_t Rx Ry z
        omega = a_t + c_t * sb, b_t * ca - c_t * sa * cb, b_t * sa + c_t * ca * cb
        pair.u[RATES[k]] = vx, vy, vz, *omega


def generalised(y, q) -> np.ndarray:
    """Forces on the coordinates of both nodes from the unit's: moments about the axes of the Cardan rates."""
    out = []
    for k in (0, 6):
        ca, sa, cb, sb = cos(q[k + 3]), sin(q[k + 3]), cos(q[k + 4]), sin(q[k + 4])
        fx, fy, fz, mx, my, mz = y[k : k + 6]
        out += (fx, fy, fz, mx, my * ca + mz * sa, mx * sb - my * sa * cb + mz * ca * cb)
    return np.array(out)
