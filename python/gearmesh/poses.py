"""From coordinates with Cardan angles x-y-z (spin last) to the FMU's inputs, and back from its loads."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin

import numpy as np

from .dynamics import Array
from .pair import GearPair

#: Where `GearPair.u` has position and angles, and velocity and angular velocity, of gear 1 and gear 2.
POSES, RATES = (slice(0, 6), slice(16, 22)), (slice(10, 16), slice(26, 32))


def cardan_axes(angles: Array) -> Array:
    """Axes about which the rates of the Cardan angles x-y-z turn: R = Rx(a) Ry(b) Rz(c), angular velocity = axes @ rates.

    Parameters
    ----------
    angles : (..., 3)
        rad.

    Returns
    -------
    ndarray (..., 3, 3)
        A column for each rate, world axes.
    """
    (ca, cb, _), (sa, sb, _) = (np.moveaxis(f(angles), -1, 0) for f in (np.cos, np.sin))
    one, zero = np.ones_like(ca), np.zeros_like(ca)
    return np.stack([np.stack(row, axis=-1) for row in ([one, zero, sb], [zero, ca, -sa * cb], [zero, sa, ca * cb])], axis=-2)


def place(pair: GearPair, q: Sequence[float], q_t: Sequence[float], reference: Sequence[Sequence[float]]) -> None:
    """Writes the inputs of an FMU from the coordinates of a node on the axis of each gear in its z = 0 face.

    Parameters
    ----------
    pair
        The FMU.
    q, q_t : (12,)
        Displacement, m, and Cardan angles, rad, of the node of gear 1, then of gear 2, and their rates; plain floats are quickest.
    reference : (2, 3)
        Positions of the nodes at zero displacement, m.
    """
    for k in (0, 1):
        x, y, z, a, b, c = q[6 * k : 6 * k + 6]
        vx, vy, vz, a_t, b_t, c_t = q_t[6 * k : 6 * k + 6]
        rx, ry, rz = reference[k]
        ca, sa, cb, sb = cos(a), sin(a), cos(b), sin(b)
        pair.u[POSES[k]] = x + rx, y + ry, z + rz, a, b, c
        # omega = a_t x + b_t Rx y + c_t Rx Ry z
        omega = a_t + c_t * sb, b_t * ca - c_t * sa * cb, b_t * sa + c_t * ca * cb
        pair.u[RATES[k]] = vx, vy, vz, *omega


def generalised(y: Sequence[float], q: Sequence[float]) -> Array:
    """Forces on these coordinates from the FMU's loads: moments about the axes of the Cardan rates.

    Parameters
    ----------
    y : (12,)
        Force and moment on gear 1, then on gear 2, world axes, N and N m: the first outputs of an FMU.
    q : (12,)
        As in `place`.

    Returns
    -------
    ndarray (12,)
    """
    out = []
    for k in (0, 6):
        ca, sa, cb, sb = cos(q[k + 3]), sin(q[k + 3]), cos(q[k + 4]), sin(q[k + 4])
        fx, fy, fz, mx, my, mz = y[k : k + 6]
        out += (fx, fy, fz, mx, my * ca + mz * sa, mx * sb - my * sa * cb + mz * ca * cb)
    return np.array(out)
