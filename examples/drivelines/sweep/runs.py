"""Dynamic runs of a pair at a speed, torque, misalignment and centre distance; needs gearmesh and numpy alone.

Gear 1 turns at a constant speed, gear 2 drags a torque. Several runs advance side by side, one unit each.
"""

from __future__ import annotations

import hashlib
import tempfile
from math import asin, cos, pi, sin
from pathlib import Path

import numpy as np
from gearmesh import GearPair

from ..integrate import runge_kutta

# The pair fzg-c: 16/24 teeth, 91.5 mm.
CENTER_DISTANCE, PHI = 91.5e-3, np.radians(22.4388)
RATIO, INERTIA = 16 / 24, 1.5e-3  # kg m^2, of gear 2
MIDDLE = pi / 24  # rad: half a pitch of gear 2, where a space faces the tooth of gear 1 at its angle 0
SETTLE, MEASURE, STEP = 6e-3, 4e-3, 5e-6  # s; the slowest speed, 1000 rpm, has a mesh period of 3.75 ms
COLUMNS = ("speed_rpm", "torque_nm", "misalignment_mrad", "center_distance_offset_um")
_units: dict[str, list[GearPair]] = {}


def units(fmu: bytes, count: int) -> list[GearPair]:
    """`count` instances in this process, kept for further runs: `phaseReference = absolute` leaves no trace of earlier ones."""
    key = hashlib.sha256(fmu).hexdigest()
    mine = _units.setdefault(key, [])
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
        self.pair, self.torque = pair, case["torque_nm"] / RATIO
        self.speed = case["speed_rpm"] * pi / 30.0
        tilt = 1e-3 * case["misalignment_mrad"]
        # M = n . (a1 - a2) with the line of action n = (sin phi, cos phi, 0) and a2 = (sin b, -sin a cos b, cos a cos b).
        b = asin(-tilt * sin(PHI))
        a = asin(tilt * cos(PHI) / cos(b))
        self.axis = (sin(b), -sin(a) * cos(b), cos(a) * cos(b))
        at = pair.input
        for name, value in {
            "gear2.position[1]": CENTER_DISTANCE + 1e-6 * case["center_distance_offset_um"],
            "gear2.angles[1]": a,
            "gear2.angles[2]": b,
            "gear1.angularVelocity[3]": self.speed,
        }.items():
            pair.u[at[name]] = value
        self.spin1, self.spin2 = at["gear1.angles[3]"], at["gear2.angles[3]"]
        first = at["gear2.angularVelocity[1]"]
        self.rates = slice(first, first + 3)
        out = pair.output["gear2.moment[1]"]
        self.moment = slice(out, out + 3)
        self.force, self.error = pair.output["mesh.tangentialForce"], pair.output["mesh.transmissionError"]

    def acceleration(self, time: float, angle: float, speed: float) -> float:
        u, (x, y, z) = self.pair.u, self.axis
        u[self.spin1], u[self.spin2], u[self.rates] = self.speed * time, angle, (speed * x, speed * y, speed * z)
        self.pair.evaluate(time)
        mx, my, mz = self.pair.y[self.moment]
        return (mx * x + my * y + mz * z + self.torque) / INERTIA

    def touching(self) -> float:
        """Angle of gear 2 at which the teeth balance the torque at rest, by bisection from the middle of the backlash."""
        low, high = MIDDLE, MIDDLE + 1e-3
        while self.acceleration(0.0, high, 0.0) > 0.0:
            low, high = high, high + 1e-3
        for _ in range(50):
            angle = 0.5 * (low + high)
            low, high = (angle, high) if self.acceleration(0.0, angle, 0.0) > 0.0 else (low, angle)
        return low


def simulate(fmu: bytes, cases: list[dict[str, float]]) -> list[dict[str, float]]:
    """Runs the cases side by side by Runge-Kutta 4; each with its largest and smallest force over the mean."""
    runs = [Run(pair, case) for pair, case in zip(units(fmu, len(cases)), cases)]
    state = np.array([[run.touching() for run in runs], [-run.speed * RATIO for run in runs]])
    settle, count = round(SETTLE / STEP), round((SETTLE + MEASURE) / STEP)
    forces, errors = np.empty((2, count - settle, len(runs)))

    def rate(time, state):
        angles, speeds = state.tolist()
        return np.array([speeds, [run.acceleration(time, a, s) for run, a, s in zip(runs, angles, speeds)]])

    for n in range(count):
        first = rate(n * STEP, state)
        if n >= settle:
            forces[n - settle] = [run.pair.y[run.force] for run in runs]
            errors[n - settle] = [run.pair.y[run.error] for run in runs]
        state = runge_kutta(rate, n * STEP, state, STEP, first)
    static = np.array([case["torque_nm"] for case in cases]) / (CENTER_DISTANCE * 16 / 40)
    return [
        {name: float(case[name]) for name in COLUMNS}
        | {
            "dynamic_factor": float(forces[:, i].max() / static[i]),
            "lowest_factor": float(forces[:, i].min() / static[i]),
            "transmission_error_pp_um": float(1e6 * np.ptp(errors[:, i])),
            "apart": float((forces[:, i] == 0.0).mean()),
        }
        for i, case in enumerate(cases)
    ]

