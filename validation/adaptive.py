"""Adaptive solvers on an FMU through Model Exchange: what event indicators and directional derivatives would save.

    python -m validation.adaptive CONSTANT.fmu TABLES.fmu [--data docs/data/hosts]

Gear 1 turns at a constant speed, gear 2 is free on its hinge under a torque: through the backlash and back with
constant stiffness, where both onsets of contact are known; a torque that swings about its mean with tables. The same
equations with and without what is asked about, each against a solution of a tight tolerance.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from gearmesh import GearPair, Turning
from scipy.integrate import solve_ivp

from examples.shared.tables import show

INERTIA = 8e-4  # kg m^2, gear 2
SPEED = 100.0  # rad/s, gear 1
STAGES = {"RK45": 6, "DOP853": 12}
# Of an event indicator about its zero, m: a solver that starts anew at an event must not find it again.
HYSTERESIS = 1e-13


class Hinge:
    """Gear 2 on its hinge: the state is its lead over the ideal angle, rad, and the rate; counts calls of the FMU."""

    def __init__(self, fmu: Path, torque: Callable[[float], float], backlash: float | None = None) -> None:
        parameters = {} if backlash is None else {"backlash": backlash}
        self.pair = GearPair(fmu, parameters, interface="model-exchange")
        self.pair.initialize()
        self.turning = Turning(self.pair)
        self.ratio, self.torque, self.backlash, self.calls = self.pair.geometry.ratio, torque, backlash, 0

    def rates(self, time: float, state: np.ndarray) -> list[float]:
        self.calls += 1
        moment = self.turning(SPEED * time, SPEED, self.ratio * SPEED * time + state[0], self.ratio * SPEED + state[1])[1]
        return [state[1], (self.torque(time) + moment) / INERTIA]

    def jacobian(self, time: float, state: np.ndarray) -> list[list[float]]:
        self.rates(time, state)
        ((stiffness, damping),) = self.pair.derivatives(["gear2.moment[3]"], ["gear2.angles[3]", "gear2.angularVelocity[3]"])
        return [[0.0, 1.0], [stiffness / INERTIA, damping / INERTIA]]

    def gaps(self, time: float, state: np.ndarray) -> np.ndarray:
        """Compression of the drive flank, m, and with the other sign that of the coast flank: zero where it touches."""
        self.rates(time, state)
        return self.pair["mesh.transmissionError"] + np.array([0.0, self.backlash])


@dataclass(frozen=True)
class Run:
    """Steps taken and rejected, calls of the FMU, and the lead over the grid of times, rad."""

    steps: int
    rejected: int
    calls: int
    lead: np.ndarray

    def error(self, other: Run) -> float:
        """Largest difference, in units of the other's range."""
        return float(np.abs(self.lead - other.lead).max() / np.ptp(other.lead))


def solve(hinge: Hinge, grid: np.ndarray, method: str, rtol: float, events: bool = False, jacobian: bool = False) -> Run:
    """Over `grid`; at an event the solver stops and starts anew, as an importer of FMUs does."""
    hinge.calls, time, state = 0, grid[0], np.zeros(2)
    lead, steps, attempts = [], 0, 0
    sides = np.sign(hinge.gaps(time, state) + HYSTERESIS) if events else None
    more = {"jac": hinge.jacobian} if jacobian else {}
    while len(grid):

        def indicator(index: int) -> Callable:
            def value(t, y):
                return hinge.gaps(t, y)[index] + sides[index] * HYSTERESIS

            value.terminal = True
            return value

        found = solve_ivp(
            hinge.rates,
            (time, grid[-1]),
            state,
            method=method,
            rtol=rtol,
            atol=[1e-6 * rtol, 1e-3 * rtol],
            dense_output=True,
            events=[indicator(0), indicator(1)] if events else None,
            **more,
        )
        time, state = found.t[-1], found.y[:, -1]
        inside = grid <= time
        lead += list(found.sol(grid[inside])[0])
        grid = grid[~inside]
        steps += len(found.t) - 1
        attempts += (found.nfev - 2) // STAGES[method] if method in STAGES else 0
        if found.status == 1:
            sides = np.where([len(times) > 0 for times in found.t_events], -sides, sides)
        elif not found.success:
            raise RuntimeError(found.message)
    return Run(steps, attempts - steps if attempts else 0, hinge.calls, np.array(lead))


def compared(hinge: Hinge, grid: np.ndarray, best: Run, methods: tuple, tolerances: tuple, option: str, words: tuple) -> list[list[object]]:
    """A row for each method and tolerance, without the option and with it; steps rejected where they are known."""
    rows = []
    for method, rtol, chosen in product(methods, tolerances, (False, True)):
        run = solve(hinge, grid, method, rtol, **{option: chosen})
        counts = [run.steps, run.rejected, run.calls] if method in STAGES else [run.steps, run.calls]
        rows.append([method, f"{rtol:.0e}", words[chosen], *counts, f"{run.error(best):.1e}"])
    hinge.pair.close()
    return rows


def onset(fmu: Path) -> list[list[object]]:
    """Rows of the table on event indicators: the torque reverses after 1 ms, the flanks part, the other ones meet."""
    hinge = Hinge(fmu, lambda t: 50.0 * math.cos(500.0 * math.pi * t), backlash=50e-6)
    # Few bounces: the error of each grows with the next.
    grid = np.linspace(0.0, 0.003, 2001)
    best = solve(hinge, grid, "DOP853", 1e-12, events=True)
    head = ["solver", "tolerance", "events", "steps", "rejected", "calls of the FMU", "error"]
    return [head, *compared(hinge, grid, best, ("RK45", "DOP853"), (1e-3, 1e-6, 1e-9), "events", ("without", "with"))]


def implicit(fmu: Path) -> list[list[object]]:
    """Rows of the table on directional derivatives: 20 ms under 100 N m that swing by 20."""
    hinge = Hinge(fmu, lambda t: 100.0 * min(1.0, 500.0 * t) + 20.0 * math.sin(2000.0 * t))
    grid = np.linspace(0.0, 0.02, 2001)
    best = solve(hinge, grid, "DOP853", 1e-11)
    head = ["solver", "tolerance", "Jacobian by", "steps", "calls of the FMU", "error"]
    return [head, *compared(hinge, grid, best, ("Radau", "BDF"), (1e-4, 1e-6), "jacobian", ("differences", "the FMU"))]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("constant", type=Path, metavar="CONSTANT.fmu")
    parser.add_argument("tables", type=Path, metavar="TABLES.fmu")
    parser.add_argument("--data", type=Path, help="folder for events.csv and derivatives.csv")
    arguments = parser.parse_args()
    for name, rows in (("events", onset(arguments.constant)), ("derivatives", implicit(arguments.tables))):
        show(name, rows, arguments.data)


if __name__ == "__main__":
    main()
