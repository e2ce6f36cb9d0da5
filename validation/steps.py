"""How long steps may be with held and with predicted loads, by host: `python -m validation.steps [--data docs/data/hosts]`.

Both shafts on bearings in seats that stand, so that loads of the teeth are all that is exchanged. They turn, and take up their torque
within a millisecond. With a housing hosts hold the forces on the seats as well, whose error is of first order whatever the teeth do.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import closing
from itertools import islice
from pathlib import Path

import numpy as np
from gearmesh import integrate
from gearmesh.dynamics import cosimulate as master

from examples.drivelines.cosimulation import ssp, subsystems as sub
from examples.drivelines.cosimulation.masters import DRIVE, SPEED, Gears, distance
from examples.shared.tables import show


RISE, DURATION = 1.024e-3, 4.096e-3  # s, powers of two times nanoseconds
SIZES = {"held": 1e-6 * 0.5 ** np.arange(3), "automatic": 16e-6 * 0.5 ** np.arange(3), "known": 16e-6 * 0.5 ** np.arange(3)}
ERROR = 1e-3  # of the elastic displacement, largest of the run
TOUCHING = {"phaseReference": "fromInitialPose"}
Host = Callable[[str, float], tuple[np.ndarray, slice | list[int]]]


def begin(gears: Gears) -> np.ndarray:
    """The teeth just touch, and turn."""
    x = np.zeros(12)
    x[5], x[8], x[11] = gears.middle, SPEED, -SPEED * sub.TEETH[0] / sub.TEETH[1]
    return x


def loads(forces: np.ndarray, time: float) -> np.ndarray:
    return np.concatenate([forces + DRIVE * min(1.0, time / RISE), np.zeros(4)])


def exact(gears: Gears, step: float) -> np.ndarray:
    """Coordinates of the shafts after each step of Runge-Kutta 4, by Model Exchange."""
    shafts = sub.shafts()
    run = integrate(lambda t, z: shafts.a @ z + shafts.b @ loads(gears(z), t), begin(gears), step, round(DURATION / step))
    return np.array([z[:6] for _, z, _ in run])[1:]


def loop(late: bool) -> Host:
    """A loop in Python: the FMU first, or all at once."""

    def run(coupling: str, size: float):
        shafts = sub.shafts()
        unit = Gears(TOUCHING, coupling)
        shafts.x = begin(unit)

        def advance(time, state):
            u = loads(unit.loads(), time + 0.5 * size)
            shafts.x = shafts.step(u, u, size)
            return state

        with closing(unit):
            points = master(unit.pair, lambda *_: unit.place(shafts.x), advance, None, size, 2**40, late=late)
            rows = [shafts.x[:6].copy() for _ in islice(points, 1, round(DURATION / size) + 1)]
        return np.array(rows), slice(None)

    return run


def by_host(host: Callable[[Path, float, float], np.ndarray], x: np.ndarray) -> Host:
    def run(coupling: str, size: float):
        start = {"shafts": x.tolist(), "drive": DRIVE.tolist(), "rise": RISE}
        file = ssp.assemble(("shafts",), start, x, TOUCHING | {"coupling": coupling})
        return host(file, DURATION, size), ssp.COLUMNS

    return run


def longest(sizes: np.ndarray, errors: list[float]) -> float:
    """Step, s, at which the error is `ERROR`, by the line through the two errors nearest to it, or one beyond them."""
    logs, steps = np.log(np.array(errors) / ERROR), np.log(sizes)
    i, k = sorted(np.argsort(np.abs(logs))[:2])
    return float(np.exp(steps[i] - logs[i] * (steps[k] - steps[i]) / (logs[k] - logs[i])))


def hosts(gears: Gears) -> dict[str, tuple[Host, str]]:
    """By name: the host, and the coupling that says what it does."""
    x = begin(gears)
    loops = {"loop, the FMU first": (loop(late=False), "sequential"), "loop, all at once": (loop(late=True), "parallel")}
    return loops | {name: (by_host(host, x), "parallel") for name, host in ssp.HOSTS.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="folder for steps.csv")
    arguments = parser.parse_args()
    with closing(Gears(TOUCHING)) as gears:
        reference, all_hosts = exact(gears, 2.5e-7), hosts(gears)
    rows = [["host", "coupling", *[f"error, step {n}" for n in (1, 2, 3)], "step at an error of 1e-3, us", "over that of held"]]
    for name, (host, known) in all_hosts.items():
        of_held = None
        for kind, sizes in SIZES.items():
            coupling = known if kind == "known" else kind
            errors = []
            for size in sizes:
                found, columns = host(coupling, size)
                errors.append(distance(found, reference, columns))
            step = longest(sizes, errors)
            of_held = of_held or step
            cells = [f"{error:.1e} at {1e6 * size:g} us" for error, size in zip(errors, sizes)]
            rows.append([name, coupling, *cells, f"{1e6 * step:.2f}", f"{step / of_held:.0f}"])
    show("steps", rows, arguments.data)


if __name__ == "__main__":
    main()
