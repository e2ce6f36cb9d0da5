"""Energy and momentum of the assembly in a run: where they are, what went in, what the dampers took out."""

from __future__ import annotations

import numpy as np
from gearmesh.energy import Ledger, mesh_loss
from gearmesh.poses import cardan_axes, place

from .model import COUPLING, COUPLING_DAMPING, INERTIAS, SHAFTS, SPUR, Driveline, Motion, apply, rotation

INSTANTS = 100  # at which the elastic energy of the mesh is found, by its work until the teeth are apart


def books(line: Driveline, history: Motion, momentum: bool = False) -> dict[str, float]:
    """What energy and loads stray over a run that was kept at every step; with `momentum` also linear momentum.

    That has no outside force where the housing is free. `line` still has the unit of the run.
    """
    time, q, q_t = history.time, history.q, history.q_t
    ledger = Ledger(time[-1] - time[0])
    moving, carried = motion(line, q, q_t)
    elastic = stored(line, q)
    lost = integral(time, dissipated(line, q, q_t) + mesh_losses(line, history))
    drives = np.array([[torque(t) for torque in line.torques] for t in time])
    fed = integral(time, np.sum(drives * q_t[:, line.rotors], axis=-1))
    for n in np.linspace(0, len(time) - 1, INSTANTS, dtype=int):
        touch(line, time[n], q[n], q_t[n])
        ledger.enter([line.pair], moving[n], elastic[n], lost[n], fed[n], carried[n] - carried[0] if momentum else None)
    return ledger.found()


class Pull:
    """Constant forces on both gears in place of the unit, with what `attach` asks of one."""

    def __init__(self, force):
        self.u, self.y = [0.0] * 32, [*force, 0.0, 0.0, 0.0, *np.negative(force), 0.0, 0.0, 0.0]

    def evaluate(self, _time: float) -> None:
        """The forces are those of any time."""


def without_teeth(speed: float, force, duration: float, step: float, stiffness: float = 2.33e8) -> float:
    """What energy strays of the undamped assembly on mounts under constant forces, N, over what a mesh stores under `force`.

    That is the host's own share: of Runge-Kutta 4, and of bearings and mounts, which push along axes that turn with one
    body and so have a potential to lowest order of its tilts only. `stiffness` of the mesh is tangential, N/m.
    """
    line = Driveline(SPUR, Pull(force), damped=False, speed=speed)
    history = line.run(duration, step, 1)
    first, second = (history.q[:, b.first : b.first + 3] for b in (line.bodies[k, shaft.gear] for k, shaft in enumerate(SHAFTS)))
    energy = motion(line, history.q, history.q_t)[0] + stored(line, history.q) - (first - second) @ force
    return float(np.ptp(energy) / (0.5 * force[1] ** 2 / stiffness))


def integral(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """From the start to each instant, evenly spaced: the trapezoidal rule with the correction by the slopes at both ends."""
    step = time[1] - time[0]
    sums = np.concatenate([[0.0], np.cumsum(0.5 * step * (values[1:] + values[:-1]))])
    slopes = np.gradient(values, step, edge_order=2)
    return sums - step**2 / 12.0 * (slopes - slopes[0])


def touch(line: Driveline, time: float, q: np.ndarray, q_t: np.ndarray) -> None:
    """Evaluates the unit at the poses and speeds of an instant."""
    blanks = [line.bodies[k, shaft.gear] for k, shaft in enumerate(SHAFTS)]
    gears = np.concatenate([np.arange(b.first, b.first + 6) for b in blanks])
    place(line.pair, q[gears].tolist(), q_t[gears].tolist(), [b.reference for b in blanks])
    line.pair.evaluate(time)


def mesh_losses(line: Driveline, history: Motion) -> np.ndarray:
    """Power that the mesh's damping takes, W."""
    out = np.zeros(len(history.time))
    for n, (time, q, q_t) in enumerate(zip(history.time, history.q, history.q_t)):
        touch(line, time, q, q_t)
        out[n] = mesh_loss(line.pair)
    return out


def dissipated(line: Driveline, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
    """Power that bearings, shafts, mounts and couplings take, W."""
    power = line.damped * line.couplings(q_t) ** 2 @ np.array(COUPLING_DAMPING)
    for spring in line.springs.values():
        if spring.damping.any():
            power = power + line.slip(spring, q, q_t) ** 2 @ spring.damping
    return power


def stored(line: Driveline, q: np.ndarray) -> np.ndarray:
    """Elastic energy of shafts, bearings, mounts and couplings, J."""
    energy = line.couplings(q) ** 2 @ np.array(COUPLING)
    for spring in line.springs.values():
        energy = energy + line.deflections(spring, q) ** 2 @ spring.stiffness
    return 0.5 * energy


def motion(line: Driveline, q: np.ndarray, q_t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Kinetic energy, J, and linear momentum, N s, a row for each instant."""
    energy = 0.5 * q_t[:, line.rotors] ** 2 @ np.array(INERTIAS)
    momentum = np.zeros((len(q), 3))
    for body in line.bodies.values():
        place, turn = slice(body.first, body.first + 3), slice(body.first + 3, body.first + 6)
        velocity, axes = q_t[:, place], rotation(q[:, turn])
        omega = apply(cardan_axes(q[:, turn]), q_t[:, turn])
        impulse = body.mass * (velocity + np.cross(omega, axes @ body.center))
        spin = apply(np.swapaxes(axes, -1, -2), omega)
        energy = energy + np.sum(velocity * (impulse - 0.5 * body.mass * velocity), axis=-1)
        energy = energy + 0.5 * np.sum(spin * (spin @ body.inertia), axis=-1)
        momentum += impulse
    return energy, momentum
