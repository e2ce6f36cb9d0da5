"""Energy and momentum of an assembly: what a mesh stores and loses, from its loads alone, and what went in and out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from gearmesh import GearPair

from .cardan import POSES, RATES
from .integrate import runge_kutta

PANELS = 48
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def mesh_energy(pair: GearPair, poses=None) -> float:
    """Elastic energy (J) at `poses` (position and Cardan angles of gear 1, then of gear 2), or else at those it has.

    Gear 1 is turned back about its own axis until the teeth part, at rest, and its moment integrated over the way. The
    element has a potential exactly if this agrees with what its forces have done along any other path, so the
    balance of a run is a test of the element and not of this function. Inputs stay; outputs are those of the way.
    """
    kept = list(pair.u)
    poses = list(poses) if poses is not None else [*kept[POSES[0]], *kept[POSES[1]]]
    try:
        _place(pair, poses)
        return _work_until_apart(pair, poses) if pair.flank != 0 else 0.0
    finally:
        pair.u[:] = kept


def _work_until_apart(pair: GearPair, poses: list[float]) -> float:
    angle, work = poses[5], 0.0
    way, flank = 1e-5 / pair["mesh.centerDistance"] * pair.flank, pair.flank
    while _touches(pair, poses, angle - way, flank):
        way *= 1.5
    # The panels end where contact does: across the kink they would be of second order only.
    inside = 0.0
    for _ in range(40):
        middle = 0.5 * (inside + way)
        inside, way = (middle, way) if _touches(pair, poses, angle - middle, flank) else (inside, middle)
    for panel in range(PANELS):
        for node, weight in zip(NODES, WEIGHTS):
            share = (panel + 0.5 + 0.5 * node) / PANELS
            _turn(pair, poses, angle - way * share)
            alpha, beta = poses[3], poses[4]
            axis = (np.sin(beta), -np.sin(alpha) * np.cos(beta), np.cos(alpha) * np.cos(beta))
            work -= 0.5 * weight / PANELS * way * np.dot(pair.y[3:6], axis)
    return float(work)


def mesh_loss(pair: GearPair) -> float:
    """Power (W) that the mesh takes out of the motion at the last inputs: of its loads, less that of its loads at rest."""
    inputs, outputs = list(pair.u), list(pair.y)
    rates = [*inputs[RATES[0]], *inputs[RATES[1]]]
    pair.u[RATES[0]] = pair.u[RATES[1]] = [0.0] * 6
    pair.evaluate(pair.time)
    lost = np.dot(np.subtract(pair.y[:12], outputs[:12]), rates)
    pair.u[:], pair.y[:] = inputs, outputs
    return float(lost)


def wrench_residual(pair: GearPair) -> float:
    """Sum of the loads on both gears at the last inputs, forces and moments about the origin (over the centre distance), over the force."""
    y, u = np.array(pair.y[:12]), np.array(pair.u[:32])
    force = y[0:3] + y[6:9]
    moment = y[3:6] + np.cross(u[0:3], y[0:3]) + y[9:12] + np.cross(u[16:19], y[6:9])
    size = np.linalg.norm(y[0:3])
    if size == 0.0:
        return 0.0
    return float(max(np.linalg.norm(force), np.linalg.norm(moment) / pair["mesh.centerDistance"]) / size)


def followed(
    rate: Callable[[float, np.ndarray], np.ndarray],
    accounts: Callable[[float, np.ndarray], list[float]],
    state: np.ndarray,
    step: float,
    count: int,
    every: int,
):
    """A run by Runge-Kutta 4 that integrates `accounts` with the state: yields time, state and integrals, every `every`-th step.

    `accounts(time, state)` has powers, W, and forces, N; it is asked right after `rate` at the same stage, so that the
    units hold its loads. At each yield they hold those of the state.
    """
    size = len(state)

    def both(time, z):
        return np.concatenate([rate(time, z[:size]), accounts(time, z[:size])])

    rate(0.0, state)
    z = np.concatenate([state, np.zeros(len(accounts(0.0, state)))])
    for n in range(count + 1):
        if n % every == 0:
            rate(n * step, z[:size])
            yield n * step, z[:size], z[size:]
        z = runge_kutta(both, n * step, z, step)


class Ledger:
    """Energies and loads at instants of a run, and how far they stray from what went in and out."""

    def __init__(self, duration: float):
        self._passed, self._wrench, self._stray, self._duration = 0.0, 0.0, None, duration
        self._rows: list[tuple[float, ...]] = []

    def enter(self, pairs, kinetic: float, stored: float, lost: float, fed: float, stray=None) -> None:
        """Energies, J: of motion, of all springs but the meshes, lost and fed in so far; `stray`, N s, is momentum less impulse.

        The units `pairs` hold the loads of the instant. Their outputs are not those any more afterwards.
        """
        self._wrench = max(self._wrench, *map(wrench_residual, pairs))
        self._passed = max(self._passed, *(np.linalg.norm(pair.y[:3]) * self._duration for pair in pairs))
        if stray is not None:
            self._stray = max(self._stray or 0.0, float(np.linalg.norm(stray)))
        mesh = sum(map(mesh_energy, pairs))
        self._rows.append((kinetic + stored + mesh + lost - fed, mesh))

    def found(self) -> dict[str, float]:
        """Span of the energy's sum over the largest energy in the meshes (springs, such as soft couplings, may hold many times
        that); the largest sum of a unit's loads over its force; the largest stray momentum over the impulse of the largest
        mesh force over the run."""
        total, mesh = np.array(self._rows).T
        found = {
            "energy over mesh": float(np.ptp(total) / mesh.max()),
            "loads": self._wrench,
        }
        return found | ({} if self._stray is None else {"momentum": self._stray / self._passed})


def in_words(found: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.1e}" for name, value in found.items())


def _touches(pair: GearPair, poses, angle: float, flank: int) -> bool:
    _turn(pair, poses, angle)
    return pair.flank == flank


def _turn(pair: GearPair, poses, angle: float) -> None:
    _place(pair, [*poses[:5], angle, *poses[6:]])


def _place(pair: GearPair, poses) -> None:
    pair.u[POSES[0]], pair.u[POSES[1]] = poses[:6], poses[6:]
    pair.u[RATES[0]] = pair.u[RATES[1]] = [0.0] * 6
    pair.evaluate(pair.time)
