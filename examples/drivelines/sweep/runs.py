"""Dynamic runs of a pair over speed, from each speed on to the next; needs gearmesh and numpy alone.

Gear 1 turns as imposed, gear 2 drags a torque. Several cases advance side by side, one unit each.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from math import pi
from pathlib import Path

import numpy as np
from gearmesh import GearPair, Turning, integrate

INERTIA = 1.5e-3  # kg m^2, of gear 2
SETTLE, MEASURE, STEP = 6e-3, 4e-3, 5e-6  # s; the slowest speed, 1000 rpm, has a mesh period of 3.75 ms


@contextmanager
def instances(fmu: bytes, count: int) -> Iterator[list[GearPair]]:
    """`count` instances of an FMU, initialised."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        file = Path(folder) / "unit.fmu"
        file.write_bytes(fmu)
        pairs = [stack.enter_context(GearPair(file, interface="model-exchange")) for _ in range(count)]
        for pair in pairs:
            pair.initialize()
        yield pairs


class Run:
    """Unit, pose and torque of one case."""

    def __init__(self, pair: GearPair, case: dict[str, float]):
        geometry, self.turning = pair.geometry, Turning(pair)
        self.ratio, self.torque = geometry.ratio, -case["torque_nm"] / geometry.ratio
        self.middle = pi / geometry.teeth[1]  # half a pitch: there a space faces the tooth of gear 1 at its angle 0
        pair["gear2.position[1]"] = geometry.center_distance + 1e-6 * case["center_distance_offset_um"]
        self.turning.tilt(*geometry.tilt_of_gear2(1e-3 * case["misalignment_mrad"]))
        self.static = case["torque_nm"] / geometry.pitch_radii[0]
        self.force = pair.output["mesh.tangentialForce"]

    def acceleration(self, angle: float, speed: float, ahead: float, slip: float) -> float:
        """Of gear 2, which is `ahead` of the motion in ratio, from angle and speed of gear 1."""
        return (self.turning(angle, speed, self.ratio * angle + ahead, self.ratio * speed + slip)[1] + self.torque) / INERTIA


def simulate(fmu: bytes, cases: list[dict[str, float]]) -> list[dict[str, list[float]]]:
    """Runs the cases side by side by Runge-Kutta 4, each over so many `speeds` from `first_rpm` to `last_rpm`.

    A speed starts from the motion at the one before, so where two answers exist each direction keeps its own. The drives
    bring what changes the speed. By speed: the largest force over the mean.
    """
    speeds = np.array([np.linspace(case["first_rpm"], case["last_rpm"], int(case["speeds"])) for case in cases]).T
    with instances(fmu, len(cases)) as pairs:
        runs = [Run(pair, case) for pair, case in zip(pairs, cases)]
        static, rows = np.array([run.static for run in runs]), []
        state = np.concatenate([np.zeros(len(runs)), [run.turning.resting(run.torque, 0.0, run.middle) for run in runs], np.zeros(len(runs))])
        for before, after in zip([speeds[0], *speeds], speeds * pi / 30.0):
            before = before * pi / 30.0

            def rate(time, state):
                angle, ahead, slip = np.split(state, 3)
                speed = before + (after - before) * min(time / SETTLE, 1.0)
                motions = zip(runs, angle.tolist(), speed.tolist(), ahead.tolist(), slip.tolist())
                return np.concatenate([speed, slip, [run.acceleration(*motion) for run, *motion in motions]])

            largest = np.zeros(len(runs))
            for time, state, _ in integrate(rate, state, STEP, round((SETTLE + MEASURE) / STEP)):
                if time >= SETTLE - 0.5 * STEP:
                    largest = np.maximum(largest, [run.turning.pair.y[run.force] for run in runs])
            rows.append(largest / static)
    factors = np.array(rows).T
    return [{"speed_rpm": speed.tolist(), "dynamic_factor": factor.tolist()} for speed, factor in zip(speeds.T, factors)]
