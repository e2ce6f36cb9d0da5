"""The coupled run as one system, and by masters that exchange at communication points."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import fmpy
import numpy as np
from gearmesh import GearPair, integrate
from gearmesh.dynamics import cosimulate as master
from scipy.optimize import root

from examples.shared.files import shipped

from . import subsystems as sub

TORQUE, SPEED = 100.0, 200.0  # N m and rad/s of gear 1
DRIVE = np.array([0.0, 0.0, TORQUE, 0.0, 0.0, TORQUE * sub.TEETH[1] / sub.TEETH[0]])
CENTER_DISTANCE = 98e-3
IN = [f"{g}.{n}" for g in ("gear1", "gear2") for n in ("position[1]", "position[2]", "angles[3]")]
RATES = [f"{g}.{n}" for g in ("gear1", "gear2") for n in ("velocity[1]", "velocity[2]", "angularVelocity[3]")]
OUT = [f"{g}.{n}" for g in ("gear1", "gear2") for n in ("force[1]", "force[2]", "moment[3]")]


class Gears:
    """The unit in the plane: loads on both gears from the state of the shafts. By co-simulation with a `coupling`, from the state `begin`."""

    def __init__(self, parameters=None, coupling: str | None = None, begin: np.ndarray | None = None):
        # Absolute phases: hosts may start at any pose. Packing brings one with the tooth in the middle of the space.
        self.parameters = parameters or {}
        choices, interface = (self.parameters, "model-exchange") if coupling is None else ({**self.parameters, "coupling": coupling}, "co-simulation")
        self.pair = GearPair(shipped("helical-25-47", phaseReference="absolute"), choices, interface)
        self.middle = self.pair.u[self.pair.input["gear2.angles[3]"]]
        self.inputs = [self.pair.input[name] for name in IN + RATES]
        self.outputs = [self.pair.output[name] for name in OUT]
        if begin is not None:
            self.place(begin)
        self.pair.initialize()

    def place(self, x: np.ndarray) -> None:
        values = x.tolist()
        values[3] += CENTER_DISTANCE
        for k, value in zip(self.inputs, values):
            self.pair.u[k] = value

    def loads(self) -> np.ndarray:
        return np.array([self.pair.y[k] for k in self.outputs])

    def __call__(self, x: np.ndarray) -> np.ndarray:
        self.place(x)
        self.pair.evaluate(0.0)
        return self.loads()

    def close(self) -> None:
        self.pair.close()

    def jacobian(self) -> np.ndarray:
        """Derivatives of the loads by the state of the shafts at the last one: the FMU's directional derivatives."""
        return np.array(self.pair.derivatives(OUT, IN + RATES))


def start(gears: Gears) -> tuple[np.ndarray, np.ndarray]:
    """States of shafts and housing in equilibrium under the torques, turning: only the teeth's changes excite."""
    shafts, housing = sub.shafts(), sub.housing()

    def at(v):
        x, h = np.zeros(12), np.zeros(2 * sub.MODES)
        x[[0, 1, 3, 4, 5]], h[: sub.MODES] = v[:5], v[5:]
        return x, h

    def residual(v):
        x, h = at(v)
        seats = sub.seat_motion(h)
        shaft = shafts.b @ np.concatenate([gears(x) + DRIVE, seats]) + shafts.a @ x
        return np.concatenate([shaft[[6, 7, 9, 10, 11]], (housing.b @ sub.bearing_forces(x, seats) + housing.a @ h)[sub.MODES :]])

    guess = np.zeros(5 + sub.MODES)
    guess[4] = gears.middle + 1e-3  # firmly in contact, so that every step finds a stiffness
    found = root(residual, guess, method="lm", tol=1e-15)
    if not found.success:
        raise RuntimeError(f"no equilibrium: {found.message}")
    x, h = at(found.x)
    x[8], x[11] = SPEED, -SPEED * sub.TEETH[0] / sub.TEETH[1]
    return x, h


def coupled(gears: Gears, damped: bool = True):
    """All equations as one system: the rate of the states of shafts and housing."""
    shafts, housing = sub.shafts(damped=damped), sub.housing(damped=damped)

    def rate(_, z):
        x, h = z[:12], z[12:]
        seats = sub.seat_motion(h)
        loads = np.concatenate([gears(x) + DRIVE, seats])
        forces = sub.bearing_forces(x, seats, damped)
        return np.concatenate([shafts.a @ x + shafts.b @ loads, housing.a @ h + housing.b @ forces])

    return rate


def monolithic(gears: Gears, begin, duration: float, step: float) -> np.ndarray:
    """All equations at once by Runge-Kutta 4: coordinates of the shafts, a row after each step."""
    run = integrate(coupled(gears), np.concatenate(begin), step, round(duration / step))
    return np.array([z[:6] for _, z, _ in run])[1:]


def exchange(gears: Gears, x: np.ndarray, h: np.ndarray, damped: bool = True) -> np.ndarray:
    """What crosses the borders: loads on the gears, forces on the seats, motion of the seats."""
    seats = sub.seat_motion(h)
    return np.concatenate([gears(x), sub.bearing_forces(x, seats, damped), seats])


def communication_points(gears: Gears, begin, size: float, coupling: str, damped: bool = True) -> Iterator[tuple]:
    """Yields at each communication point the states of shafts and housing, and the impulse handed to the seats so far, N s.

    `held`: everyone steps on the values of the last communication point; `parallel`: so, too, but the loads are those
    of the poses one point earlier, since the FMU steps beside the others; `predicted sequential`, `predicted parallel`: with the
    loads that the FMU predicts for either; `extrapolated`: on lines through the values of the last two; `iterated`: on lines to the
    values at the end of the step, found by Newton's method."""
    if coupling in ("extrapolated", "iterated"):
        yield from on_lines(gears, begin, size, coupling == "iterated", damped)
        return
    shafts, housing, impulse = sub.shafts(begin[0].copy(), damped), sub.housing(begin[1].copy(), damped), np.zeros(2)
    unit = Gears(gears.parameters, coupling.removeprefix("predicted ") if " " in coupling else "held", begin[0])

    def advance(_, impulse):
        seats = sub.seat_motion(housing.x)
        forces, loads = sub.bearing_forces(shafts.x, seats, damped), np.concatenate([unit.loads() + DRIVE, seats])
        shafts.x, housing.x = shafts.step(loads, loads, size), housing.step(forces, forces, size)
        return impulse + size * forces

    try:
        points = master(unit.pair, lambda *_: unit.place(shafts.x), advance, impulse, size, 2**40, late="parallel" in coupling)
        for _, impulse in points:
            yield shafts.x, housing.x, impulse
    finally:
        unit.close()


def on_lines(gears: Gears, begin, size: float, iterated: bool, damped: bool) -> Iterator[tuple]:
    """The couplings of second order."""
    shafts, housing = sub.shafts(begin[0].copy(), damped), sub.housing(begin[1].copy(), damped)
    now = before = exchange(gears, *begin, damped)
    drive, impulse = np.concatenate([DRIVE, np.zeros(4)]), np.zeros(2)

    def advance(there):
        return (
            shafts.step(now[SHAFT_INPUTS] + drive, there[SHAFT_INPUTS] + drive, size),
            housing.step(now[6:8], there[6:8], size),
        )

    while True:
        yield shafts.x, housing.x, impulse
        there = 2.0 * now - before
        shafts_end, housing_end = advance(there)
        for _ in range(8 if iterated else 0):
            residual = exchange(gears, shafts_end, housing_end, damped) - there
            if np.abs(residual / SCALE).max() < 1e-10:
                break
            there = there + np.linalg.solve(np.eye(12) - sensitivity(gears, shafts, housing, size, damped), residual)
            shafts_end, housing_end = advance(there)
        impulse = impulse + 0.5 * size * (now[6:8] + there[6:8])
        shafts.x, housing.x = shafts_end, housing_end
        before, now = now, exchange(gears, shafts.x, housing.x, damped)


def cosimulate(gears: Gears, begin, duration: float, size: float, coupling: str) -> np.ndarray:
    """Coordinates of the shafts, a row after each of the steps of `size` s that `duration` s hold."""
    points = communication_points(gears, begin, size, coupling)
    return np.array([x[:6] for x, _, _ in islice(points, 1, round(duration / size) + 1)])


SHAFT_INPUTS = np.r_[0:6, 8:12]
SCALE = np.array([1e3, 1e3, 1e2] * 2 + [1e3] * 2 + [1e-5] * 2 + [1e-1] * 2)


def sensitivity(gears: Gears, shafts: sub.Linear, housing: sub.Linear, size: float, damped: bool = True) -> np.ndarray:
    """Derivative of what is exchanged at the end of a step by what was assumed for it."""
    by_shafts, by_housing = np.zeros((12, 12)), np.zeros((2 * sub.MODES, 12))
    by_shafts[:, SHAFT_INPUTS] = shafts.parts(size)[2]
    by_housing[:, 6:8] = housing.parts(size)[2]
    seats = np.zeros((4, 2 * sub.MODES))
    seats[:2, : sub.MODES] = seats[2:, sub.MODES :] = sub.shape(sub.SEATS)
    motion = seats @ by_housing
    k, c = sub.bearing(damped)
    forces = k * (by_shafts[[1, 4]] - motion[:2]) + c * (by_shafts[[7, 10]] - motion[2:])
    return np.vstack([gears.jacobian() @ by_shafts, forces, motion])


def packed_step() -> float:
    """The step that the FMU of the gears recommends, s."""
    return float(fmpy.read_model_description(str(shipped("helical-25-47"))).defaultExperiment.stepSize)


def stands(gears: Gears, begin, size: float, coupling: str, duration: float = 8e-3) -> bool:
    """Whether the tooth force is still within a fifth of that of the start after `duration` s in steps of `size` s."""
    force = exchange(gears, *begin)[1]
    try:
        with np.errstate(all="ignore"):
            x, h, _ = next(islice(communication_points(gears, begin, size, coupling), round(duration / size), None))
        return bool(abs(exchange(gears, x, h)[1] - force) < 0.2 * abs(force))
    except RuntimeError:  # the poses ran away
        return False


def distance(found: np.ndarray, reference: np.ndarray, columns=slice(None)) -> float:
    """Largest error of coordinates over a run at the points of both, over the elastic displacement typical of it: 3 kN over 2e8 N/m.

    `found` has the `columns` of `reference`. The end alone would understate it: errors swing through zero.
    """
    coarse = min(len(found), len(reference))
    found, reference = (rows[len(rows) // coarse - 1 :: len(rows) // coarse] for rows in (found, reference))
    lever = np.array([1.0, 1.0, 0.034, 1.0, 1.0, 0.064])
    return float(np.abs((found - reference[:, columns]) * lever[columns]).max() / 1.5e-5)
