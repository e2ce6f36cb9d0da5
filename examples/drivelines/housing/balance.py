"""Energy and momentum of the assembly in a run: where they are, what went in, what the dampers took out."""

from __future__ import annotations

import numpy as np
from gearmesh.energy import Ledger, mesh_loss
from gearmesh.poses import place

from examples.shared.gearbox import INERTIAS, Driveline, Output

INSTANTS = 100  # at which the elastic energy of the mesh is found, by its work until the teeth are apart


class Books:
    """Observes every step of a run of `line`, and so what energy and loads stray; with `momentum` also linear momentum.

    That has no outside force where the housing is free. Work and losses are integrated by Simpson's rule.
    """

    def __init__(self, line: Driveline, duration: float, step: float, momentum: bool = False) -> None:
        self.line, self.step, self.momentum, self.ledger = line, step, momentum, Ledger(duration)
        self.every = 2 * max(round(duration / step / INSTANTS / 2), 1)
        self.powers, self.integrals, self.begin = [], np.zeros(2), np.zeros(3)

    def __call__(self, time: float, q: np.ndarray, q_t: np.ndarray, _q_tt: np.ndarray) -> float:
        """The tangential force."""
        line, gears, n = self.line, self.line.gear_coordinates, len(self.powers)
        place(line.pair, q[gears].tolist(), q_t[gears].tolist(), [b.reference for b in line.blanks])
        line.pair.evaluate(time)
        rates = q_t[line.elastic]
        lost = mesh_loss(line.pair) + rates @ line.damping @ rates
        lost += sum(spring.damping @ line.deflections(spring, rates=True) ** 2 for spring in line.springs.values())
        self.powers.append(np.array([lost, sum(torque(time) * q_t[i] for torque, i in zip(line.torques, line.rotors))]))
        if n and n % 2 == 0:
            first, middle, last = self.powers[-3:]
            self.integrals += self.step / 3.0 * (first + 4.0 * middle + last)
        force = line.pair["mesh.tangentialForce"]
        if n % self.every == 0:
            self._enter(q, q_t)
        return force

    def _enter(self, q: np.ndarray, q_t: np.ndarray) -> None:
        line, at = self.line, self.line.mbs.GetObjectOutputBody
        elastic, walls = q[line.elastic], q_t[line.walls]
        kinetic = 0.5 * np.array(INERTIAS) @ q_t[line.rotors] ** 2 + 0.5 * walls @ walls
        kinetic += sum(at(body.item, Output.KineticEnergy, [0.0, 0.0, 0.0]) for body in line.bodies.values())
        stored = elastic @ line.stiffness @ elastic + sum(s.stiffness @ line.deflections(s) ** 2 for s in line.springs.values())
        impulse = line.housing.impulse @ walls
        impulse = impulse + sum(body.mass * at(body.item, Output.Velocity, body.center) for body in line.bodies.values())
        if not self.begin.any():
            self.begin = impulse
        self.ledger.enter([line.pair], kinetic, 0.5 * stored, *self.integrals, impulse - self.begin if self.momentum else None)


def books(line: Driveline, duration: float, step: float, momentum: bool = False) -> dict[str, float]:
    """Runs `line`: what strays, and how long the teeth are apart."""
    observer = Books(line, duration, step, momentum)
    _, force = line.run(duration, step, observer)
    return observer.ledger.found() | {"share of time apart": float(np.mean(force[len(force) // 4 :] == 0.0))}
