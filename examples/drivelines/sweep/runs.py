"""Dynamic runs of a pair at a speed, torque, misalignment and centre distance; needs gearmesh and numpy alone.

Gear 1 turns at a constant speed, gear 2 drags a torque. Several runs advance side by side, one unit each.
"""

from __future__ import annotations

import hashlib
import tempfile
from math import pi
from pathlib import Path

import numpy as np
from gearmesh import GearPair, Turning, integrate

INERTIA = 1.5e-3  # kg m^2, of gear 2
SETTLE, MEASURE, STEP = 6e-3, 4e-3, 5e-6  # s; the slowest speed, 1000 rpm, has a mesh period of 3.75 ms
_units: dict[str, list[GearPair]] = {}


def units(fmu: bytes, count: int) -> list[GearPair]:
    """`count` instances in this process, kept for further runs: `phaseReference = absolute` leaves no trace of earlier ones."""
    mine = _units.setdefault(hashlib.sha256(fmu).hexdigest(), [])
    if len(mine) < count:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "unit.fmu"
            file.write_bytes(fmu)
            while len(mine) < count:
                mine.append(GearPair(file, interface="model-exchange"))
                mine[-1].initialize()
    return mine[:count]


class Run:
    """Unit, pose and torque of one run."""

    def __init__(self, pair: GearPair, case: dict[str, float]):
        geometry, self.turning = pair.geometry, Turning(pair)
        self.ratio, self.torque = geometry.ratio, -case["torque_nm"] / geometry.ratio
        self.speed = case["speed_rpm"] * pi / 30.0
        self.middle = pi / geometry.teeth[1]  # half a pitch: there a space faces the tooth of gear 1 at its angle 0
        pair["gear2.position[1]"] = geometry.center_distance + 1e-6 * case["center_distance_offset_um"]
        self.turning.tilt(*geometry.tilt_of_gear2(1e-3 * case["misalignment_mrad"]))
        self.static = case["torque_nm"] / geometry.pitch_radii[0]
        self.force, self.error = pair.output["mesh.tangentialForce"], pair.output["mesh.transmissionError"]

    def acceleration(self, time: float, angle: float, speed: float) -> float:
        return (self.turning(self.speed * time, self.speed, angle, speed)[1] + self.torque) / INERTIA

    def touching(self) -> float:
        """Angle of gear 2 at which the teeth balance the torque at rest, by bisection from the middle of the backlash."""
        low, high = self.middle, self.middle + 1e-3
        while self.acceleration(0.0, high, 0.0) > 0.0:
            low, high = high, high + 1e-3
        for _ in range(50):
            angle = 0.5 * (low + high)
            low, high = (angle, high) if self.acceleration(0.0, angle, 0.0) > 0.0 else (low, angle)
        return low


def simulate(fmu: bytes, cases: list[dict[str, float]]) -> list[dict[str, float]]:
    """Runs the cases side by side by Runge-Kutta 4; each with its largest and smallest force over the mean."""
    runs = [Run(pair, case) for pair, case in zip(units(fmu, len(cases)), cases)]
    state = np.array([run.touching() for run in runs] + [run.speed * run.ratio for run in runs])

    def rate(time, state):
        angles, speeds = np.split(state, 2)
        return np.array([*speeds, *(run.acceleration(time, a, s) for run, a, s in zip(runs, angles.tolist(), speeds.tolist()))])

    rows = [
        [(y[run.force], y[run.error]) for run in runs for y in (run.turning.pair.y,)]
        for time, _, _ in integrate(rate, state, STEP, round((SETTLE + MEASURE) / STEP) - 1)
        if time >= SETTLE - 0.5 * STEP
    ]
    forces, errors = np.moveaxis(np.array(rows), -1, 0)
    return [
        {
            "dynamic_factor": float(forces[:, i].max() / run.static),
            "lowest_factor": float(forces[:, i].min() / run.static),
            "transmission_error_pp_um": float(1e6 * np.ptp(errors[:, i])),
            "apart": float((forces[:, i] == 0.0).mean()),
        }
        for i, run in enumerate(runs)
    ]
