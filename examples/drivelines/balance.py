"""Energy stored in a mesh, from its forces alone."""

from __future__ import annotations

import numpy as np
from gearmesh import GearPair

from .cardan import POSES

PANELS = 48
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def mesh_energy(pair: GearPair, poses) -> float:
    """Elastic energy (J) at `poses` (position and Cardan angles of gear 1, then of gear 2).

    Gear 1 is turned back about its own axis until the teeth part, and its moment integrated over the way. The
    element has a potential exactly if this agrees with what its forces have done along any other path, so the
    balance of a run is a test of the element and not of this function. The unit must be undamped.
    """
    _place(pair, poses)
    if pair.flank == 0:
        return 0.0
    angle, work = poses[5], 0.0
    way, flank = 1e-5 / _radius(pair) * pair.flank, pair.flank
    while pair.flank == flank:
        way *= 1.2
        _place(pair, [*poses[:5], angle - way, *poses[6:]])
    for panel in range(PANELS):
        for node, weight in zip(NODES, WEIGHTS):
            share = (panel + 0.5 + 0.5 * node) / PANELS
            _place(pair, [*poses[:5], angle - way * share, *poses[6:]])
            alpha, beta = poses[3], poses[4]
            axis = (np.sin(beta), -np.sin(alpha) * np.cos(beta), np.cos(alpha) * np.cos(beta))
            work -= 0.5 * weight / PANELS * way * np.dot(pair.y[3:6], axis)
    return float(work)


def wrench_residual(pair: GearPair) -> float:
    """Sum of the loads on both gears at the last inputs, forces and moments about the origin, over the normal force."""
    y, u = np.array(pair.y[:12]), np.array(pair.u[:32])
    force = y[0:3] + y[6:9]
    moment = y[3:6] + np.cross(u[0:3], y[0:3]) + y[9:12] + np.cross(u[16:19], y[6:9])
    size = np.linalg.norm(y[0:3])
    return float(max(np.linalg.norm(force), np.linalg.norm(moment) / _radius(pair)) / size) if size > 0.0 else 0.0


def _radius(pair: GearPair) -> float:
    """Lever of the tangential force on gear 1, m."""
    return abs(pair["gear1.moment[3]"] / pair["mesh.tangentialForce"])


def _place(pair: GearPair, poses) -> None:
    pair.u[POSES[0]], pair.u[POSES[1]] = poses[:6], poses[6:]
    pair.evaluate(pair.time)
