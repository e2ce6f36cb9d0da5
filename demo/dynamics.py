"""Gear 2 on its revolute joint, integrated outside the unit while gear 1 turns as imposed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from gearmesh import GearPair

from .drawing import Drawing

# Of the paper's Table 2 (0.25 kg on the pitch circle) and section 6.
INERTIA_OF_GEAR2 = 4.213e-4  # kg m^2
DAMPING = 1e5  # N s/m, tangential

RPM = math.pi / 30.0


@dataclass(frozen=True)
class Record:
    """Time histories, one row per recorded step: `time` in s, `columns[name]` in SI units."""

    time: np.ndarray
    columns: dict[str, np.ndarray]
    steps: int
    out_of_range: bool

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def after(self, start: float) -> Record:
        """The part from time `start` on."""
        keep = self.time >= start
        columns = {name: column[keep] for name, column in self.columns.items()}
        return Record(self.time[keep], columns, self.steps, self.out_of_range)


RECORDED = (
    "mesh.transmissionError",
    "mesh.position",
    "mesh.normalForce",
    "mesh.contactZ",
    "mesh.misalignment",
    "mesh.tangentialForce",
)


def run(
    pair: GearPair,
    drawing: Drawing,
    *,
    gear1: Callable[[float], tuple[float, float]],
    torque: Callable[[float], float],
    misalignment: Callable[[float], float] | None = None,
    duration: float,
    step: float,
    explicit: bool = False,
    record_every: int = 1,
) -> Record:
    """Runs the pair from rest at angle zero, which is the touching pose without load.

    `gear1(t)` gives angle and speed of gear 1, `torque(t)` the torque on gear 2 (against the drive
    flank when positive), `misalignment(t)` a tilt of gear 2 in the plane of action, changing so slowly
    that its own rate is left out.

    The pair is overdamped (zeta = 4.8): the fast root is c/m = 4e5 1/s. With `explicit` the force of
    one step is held over the next, which is stable only below 2 m/c = 5 us. Otherwise the step is
    linearly implicit: the moment at the predicted pose is corrected by its derivatives, which the unit
    gives as `mesh.stiffness` and as the damping, so that the step need only resolve the mesh cycle.
    """
    u, y = pair.u, pair.y
    theta1, omega1 = pair.input["gear1.angles[3]"], pair.input["gear1.angularVelocity[3]"]
    tilt_x, tilt_y = pair.input["gear2.angles[1]"], pair.input["gear2.angles[2]"]
    theta2 = pair.input["gear2.angles[3]"]
    spin = [pair.input[f"gear2.angularVelocity[{i}]"] for i in (1, 2, 3)]
    moment = [pair.output[f"gear2.moment[{i}]"] for i in (1, 2, 3)]
    stiffness = pair.output["mesh.stiffness"]
    recorded = [pair.output[name] for name in RECORDED]

    steps = round(duration / step)
    rows = np.empty((steps // record_every, len(RECORDED) + 1))
    out_of_range = False
    radius_squared = drawing.pitch_radii[1] ** 2
    axis = (0.0, 0.0, 1.0)
    angle, speed = 0.0, -gear1(0.0)[1] * drawing.teeth[0] / drawing.teeth[1]

    for n in range(1, steps + 1):
        t = n * step
        u[theta1], u[omega1] = gear1(t)
        if misalignment is not None:
            u[tilt_x], u[tilt_y] = alpha, beta = drawing.tilt_of_gear2(misalignment(t))
            axis = (
                math.sin(beta),
                -math.sin(alpha) * math.cos(beta),
                math.cos(alpha) * math.cos(beta),
            )
        u[theta2] = angle + step * speed
        for i in range(3):
            u[spin[i]] = speed * axis[i]
        pair.step(step)

        total = torque(t) + sum(y[moment[i]] * axis[i] for i in range(3))
        inertia = INERTIA_OF_GEAR2
        if not explicit and y[recorded[5]] > 0.0:
            inertia += radius_squared * step * (DAMPING + step * y[stiffness])
        speed += step * total / inertia
        angle += step * speed

        if n % record_every == 0:
            row = rows[n // record_every - 1]
            row[0] = t
            row[1:] = [y[i] for i in recorded]
            if n % (64 * record_every) == 0:
                out_of_range = out_of_range or pair.out_of_range
    columns = {name: rows[:, i + 1] for i, name in enumerate(RECORDED)}
    return Record(rows[:, 0], columns, steps, out_of_range)


def constant_speed(rpm: float) -> Callable[[float], tuple[float, float]]:
    """Gear 1 at a constant speed."""
    omega = rpm * RPM
    return lambda t: (omega * t, omega)


def run_up(rpm: float, duration: float) -> Callable[[float], tuple[float, float]]:
    """Gear 1 from rest to `rpm` in `duration` seconds, evenly accelerated."""
    acceleration = rpm * RPM / duration
    return lambda t: (0.5 * acceleration * t * t, acceleration * t)


def ramp(start: float, end: float, begin: float, finish: float) -> Callable[[float], float]:
    """From `start` to `end` linearly between the times `begin` and `finish`, constant outside."""

    def value(t: float) -> float:
        share = min(max((t - begin) / (finish - begin), 0.0), 1.0)
        return start + share * (end - start)

    return value
