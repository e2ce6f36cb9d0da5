"""Energy and momentum of an assembly: what a mesh stores and loses, from its loads alone, and what went in and out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from .dynamics import Array, Rate, integrate
from .pair import GearPair
from .poses import POSES, RATES

# The law of a table is smooth between its nodes only, and the way crosses some tens of them.
PANELS = 96
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def mesh_energy(pair: GearPair, poses: Sequence[float] | None = None) -> float:
    """Elastic energy of a mesh.

    Gear 1 is turned back about its own axis until the teeth part, at rest, and its moment integrated over the way. The
    element has a potential exactly if this agrees with what its forces have done along any other path, so the
    balance of a run is a test of the element and not of this function.

    Parameters
    ----------
    pair
        Through Model Exchange. Its inputs stay; its outputs are those of the way.
    poses : (12,)
        Position and Cardan angles of gear 1, then of gear 2; those it has where left out.

    Returns
    -------
    float
        J.
    """
    kept = list(pair.u)
    poses = list(poses) if poses is not None else [*kept[POSES[0]], *kept[POSES[1]]]
    try:
        _turn(pair, poses, poses[5])
        return _work_until_apart(pair, poses) if pair.flank != 0 else 0.0
    finally:
        pair.u[:] = kept


def _work_until_apart(pair: GearPair, poses: list[float]) -> float:
    angle, work, flank = poses[5], 0.0, pair.flank
    way = 1e-5 / pair["mesh.centerDistance"] * flank

    def touches(angle: float) -> bool:
        _turn(pair, poses, angle)
        return pair.flank == flank

    while touches(angle - way):
        way *= 1.5
    # The panels end where contact does: across the kink they would be of second order only.
    inside = 0.0
    for _ in range(40):
        middle = 0.5 * (inside + way)
        inside, way = (middle, way) if touches(angle - middle) else (inside, middle)
    alpha, beta = poses[3], poses[4]
    axis = (np.sin(beta), -np.sin(alpha) * np.cos(beta), np.cos(alpha) * np.cos(beta))
    for panel in range(PANELS):
        for node, weight in zip(NODES, WEIGHTS):
            _turn(pair, poses, angle - way * (panel + 0.5 + 0.5 * node) / PANELS)
            work -= 0.5 * weight / PANELS * way * np.dot(pair.y[3:6], axis)
    return float(work)


def _turn(pair: GearPair, poses: Sequence[float], angle: float) -> None:
    """At `poses` but for the spin of gear 1, at rest."""
    pair.u[POSES[0]], pair.u[POSES[1]] = [*poses[:5], angle], poses[6:]
    pair.u[RATES[0]] = pair.u[RATES[1]] = [0.0] * 6
    pair.evaluate(pair.time)


def mesh_loss(pair: GearPair) -> float:
    """Power, W, that a mesh takes out of the motion at its last inputs: of its loads, less that of its loads at rest.

    `pair` is an instance through Model Exchange; it keeps its inputs and outputs.
    """
    inputs, outputs = list(pair.u), list(pair.y)
    rates = [*inputs[RATES[0]], *inputs[RATES[1]]]
    pair.u[RATES[0]] = pair.u[RATES[1]] = [0.0] * 6
    pair.evaluate(pair.time)
    lost = np.dot(np.subtract(pair.y[:12], outputs[:12]), rates)
    pair.u[:], pair.y[:] = inputs, outputs
    return float(lost)


def wrench_residual(pair: GearPair) -> float:
    """Sum of the loads on both gears at the last inputs, over the force: forces, and moments about the origin over the centre distance."""
    y, u = np.array(pair.y[:12]), np.array(pair.u[:32])
    size = np.linalg.norm(y[0:3])
    if size == 0.0:
        return 0.0
    moment = y[3:6] + np.cross(u[0:3], y[0:3]) + y[9:12] + np.cross(u[16:19], y[6:9])
    return float(max(np.linalg.norm(y[0:3] + y[6:9]), np.linalg.norm(moment) / pair["mesh.centerDistance"]) / size)


class Ledger:
    """Energies and loads at instants of a run, and how far they stray from what went in and out.

    Parameters
    ----------
    duration
        Of the run, s.
    """

    def __init__(self, duration: float) -> None:
        self._passed, self._wrench, self._stray, self._duration = 0.0, 0.0, 0.0, duration
        self._has_momentum = False
        self._rows: list[tuple[float, float]] = []

    def enter(
        self, pairs: Iterable[GearPair], kinetic: float, stored: float, lost: float, fed: float, stray: Sequence[float] | float | None = None
    ) -> None:
        """Enters an instant.

        Parameters
        ----------
        pairs
            The FMUs, with the loads of the instant; their outputs are not those any more afterwards.
        kinetic, stored, lost, fed
            Energies, J: of motion, of all springs but the meshes, lost and fed in so far.
        stray
            Momentum less impulse, N s.
        """
        pairs = list(pairs)
        self._wrench = max(self._wrench, *map(wrench_residual, pairs))
        self._passed = max(self._passed, *(float(np.linalg.norm(pair.y[:3])) * self._duration for pair in pairs))
        if stray is not None:
            self._has_momentum, self._stray = True, max(self._stray, float(np.linalg.norm(stray)))
        mesh = sum(map(mesh_energy, pairs))
        self._rows.append((kinetic + stored + mesh + lost - fed, mesh))

    def found(self) -> dict[str, float]:
        """What strayed.

        Returns
        -------
        dict
            `energy over mesh`: span of the energy's sum over the largest energy in the meshes (soft springs may hold many
            times that); `loads`: the largest sum of an FMU's loads over its force; `momentum`, where it was entered: the largest
            stray over the impulse of the largest mesh force over the run.
        """
        total, mesh = np.array(self._rows).T
        found = {"energy over mesh": float(np.ptp(total) / mesh.max()), "loads": self._wrench}
        return found | ({"momentum": self._stray / self._passed} if self._has_momentum else {})


def balance(
    pairs: Sequence[GearPair],
    rate: Rate,
    start: Array,
    step: float,
    duration: float,
    accounts: Callable[[float, Array], Sequence[float]],
    kinetic: Callable[[Array], float],
    *,
    every: int = 40,
) -> dict[str, float]:
    """Runs an assembly whose only springs are the meshes, and books its energy.

    Parameters
    ----------
    pairs
        The FMUs, through Model Exchange.
    rate, start, step
        As in `integrate`.
    duration
        Of the run, s.
    accounts
        Powers fed in and lost, W, from time and state.
    kinetic
        Energy of motion, J, from the state.
    every
        Steps between entries.

    Returns
    -------
    dict
        What a ledger found, and `share of time apart` of the last of `pairs`.
    """
    ledger, apart = Ledger(duration), []
    for _, state, (fed, lost) in integrate(rate, start, step, round(duration / step), every=every, accounts=accounts):
        apart.append(pairs[-1].flank == 0)
        ledger.enter(pairs, kinetic(state), 0.0, lost, fed)
    return ledger.found() | {"share of time apart": float(np.mean(apart))}


def in_words(found: dict[str, float]) -> str:
    """What a ledger found, in one line."""
    return ", ".join(f"{name} {value:.1e}" for name, value in found.items())
