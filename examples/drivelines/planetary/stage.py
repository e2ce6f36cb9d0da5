"""A planetary stage in its plane: sun, planets on pins of a turning carrier, ring held; one unit for each mesh.

Coordinates q: x, y and angle of the sun, then of each planet, then the angle of the carrier; SI, fixed axes. All units
run with `phaseReference = absolute`: the phases between the meshes follow from teeth and places alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from gearmesh import GearPair, integrate
from gearmesh.energy import mesh_loss

from ..files import local

TEETH = (21, 39, 99)  # sun, planet, ring
CENTER_DISTANCE = 0.3079208  # m
IN = [f"gear{gear}.{name}" for gear in (1, 2) for name in ("position[1]", "position[2]", "angles[3]")]
OUT = [f"gear{gear}.{name}" for gear in (1, 2) for name in ("force[1]", "force[2]", "moment[3]")]
# Places of those and of the rates in `GearPair.u` and `GearPair.y`.
U, RATES, Y = np.array([[0, 1, 5, 16, 17, 21], [10, 11, 15, 26, 27, 31], [0, 1, 5, 6, 7, 11]])

# Body x axes pass through teeth at each gear's own z = 0 face; these turns put the teeth of sun (face 3.75 mm above the
# planets') and ring (1.25 mm below) on +x in the plane of the planets' z = 0 face: z tan(helix angle) / reference radius.
PITCH = np.array(TEETH) * 10e-3 / np.cos(np.radians(7.5)) / 2.0  # reference radii, m
SUN_TURN, RING_TURN = 3.75e-3 * np.tan(np.radians(7.5)) / PITCH[0], 1.25e-3 * np.tan(np.radians(7.5)) / PITCH[2]

SUN, RING = np.array([0.0, 0.0, SUN_TURN]), np.array([0.0, 0.0, RING_TURN])

IN_PHASE, SEQUENTIAL = (0, 40, 80), (0, 42, 84)  # places of the planets, in steps of 360 / (21 + 99) deg


@dataclass
class Stage:
    """The stage; `errors` are tangential errors of the pins, m, positive in the carrier's positive sense."""

    places: tuple[int, ...] = IN_PHASE
    errors: tuple[float, ...] = (0.0, 0.0, 0.0)
    sun_support: float = 1e11  # N/m; 0: floating
    pin: float = 3e9  # N/m, planet bearings and pins
    damping: float | None = None  # N s/m at each mesh; None: as packed
    masses: tuple[float, float, float] = (60.0, 150.0, 2.2)  # sun and planet, kg; carrier's inertia with rotor, 1e3 kg m^2
    inertias: tuple[float, float] = (0.35, 4.1)  # sun and planet, kg m^2
    angles: np.ndarray = field(init=False)

    def __post_init__(self):
        choices = {"phaseReference": "absolute"} | ({} if self.damping is None else {"damping": self.damping})
        kinds = [local(name) for name in ("grc-sun-planet", "grc-planet-ring")]
        self.meshes = [[GearPair(fmu, choices, "model-exchange") for fmu in kinds] for _ in self.places]
        self.angles = 2.0 * np.pi * np.array(self.places) / (TEETH[0] + TEETH[2])
        start = self.rolled(0.0)
        for n, pairs in enumerate(self.meshes):
            for pair, bodies in zip(pairs, self._bodies(start, n)):
                for k, value in zip(U, bodies):
                    pair.u[k] = value
                pair.initialize()

    def close(self) -> None:
        for pair in (pair for pairs in self.meshes for pair in pairs):
            pair.close()

    def __enter__(self) -> Stage:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def pins(self, carrier: float) -> np.ndarray:
        """Where the pins are, m, one row each."""
        angle = self.angles + carrier
        radial = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return CENTER_DISTANCE * radial + np.array(self.errors)[:, None] * radial[:, ::-1] * [-1.0, 1.0]

    def rolled(self, carrier: float) -> np.ndarray:
        """Coordinates after rolling without load: at angle zero a tooth of sun and planet lies on +x, and a space of the ring."""
        sun, planet, ring = TEETH
        planets = np.column_stack([self.pins(carrier), (self.angles + carrier) * (1.0 - ring / planet)])
        return np.concatenate([[0.0, 0.0, carrier * (1.0 + ring / sun)], planets.ravel(), [carrier]])

    def _bodies(self, q, n, sun=SUN, ring=RING):
        """Coordinates of gear 1 and gear 2 of planet n's meshes with sun and ring."""
        planet = q[3 + 3 * n : 6 + 3 * n]
        return np.concatenate([q[:3] + sun, planet]), np.concatenate([planet, ring])

    def _rows(self, n):
        """Where the loads of planet n's two meshes go in q; the ring's go to the ground."""
        planet = np.arange(3 + 3 * n, 6 + 3 * n)
        return np.concatenate([np.arange(3), planet]), planet

    def forces(self, q: np.ndarray, q_t: np.ndarray, jacobian: bool = False):
        """Forces of meshes, pins and sun support on the coordinates; with `jacobian` their derivatives by q, too."""
        force, slope = np.zeros(len(q)), np.zeros((len(q), len(q)))
        for n, pairs in enumerate(self.meshes):
            speeds = self._bodies(q_t, n, 0.0, np.zeros(3))
            for pair, bodies, rates, rows in zip(pairs, self._bodies(q, n), speeds, self._rows(n)):
                values, motion = bodies.tolist(), rates.tolist()
                for k in range(6):
                    pair.u[U[k]], pair.u[RATES[k]] = values[k], motion[k]
                pair.evaluate(0.0)
                y = np.array(pair.y[:12])[Y]
                force[rows] += y[: len(rows)]
                if jacobian:
                    part = np.array(pair.derivatives(OUT, IN))
                    slope[np.ix_(rows, rows)] += part[: len(rows), : len(rows)]
        pins = self.pins(q[-1])
        arm = np.stack([-pins[:, 1], pins[:, 0]], axis=1)
        for n in range(len(self.places)):
            at = 3 + 3 * n
            pull = self.pin * (pins[n] - q[at : at + 2])
            force[at : at + 2] += pull
            force[-1] -= pull @ arm[n]
            slope[at, at] -= self.pin
            slope[at + 1, at + 1] -= self.pin
        force[:2] -= self.sun_support * q[:2]
        slope[[0, 1], [0, 1]] -= self.sun_support
        return (force, slope) if jacobian else force

    def equilibrium(self, carrier: float, torque: float, guess: np.ndarray | None = None) -> np.ndarray:
        """Coordinates at rest with the carrier held and `torque`, N m, on the sun, by Newton's method."""
        sense = -np.sign(torque)
        q = self.rolled(carrier)
        if guess is not None:
            q = q + guess
        else:
            # Through half of the backlash of both meshes and a little further, so that teeth touch.
            q[5:-1:3] += -sense * 5e-4
            q[2] -= sense * 3.2e-3
        rest, free = np.zeros(len(q)), slice(0, len(q) - 1)
        for _ in range(60):
            force, slope = self.forces(q, rest, jacobian=True)
            force[2] += torque
            residual = force[free]
            # Forces over a tenth of a metre, so that they compare with moments.
            if np.linalg.norm(residual * np.tile([0.1, 0.1, 1.0], 1 + len(self.places))) < 1e-9 * abs(torque):
                return q
            step = np.linalg.solve(slope[free, free], -residual)
            q[free] += step * min(1.0, 2e-4 / np.abs(step).max())
        raise RuntimeError(f"no equilibrium at a carrier angle of {carrier} rad: residual {np.abs(residual).max()}")

    def shares(self) -> np.ndarray:
        """Shares of the planets in the tangential force at the sun, at the last evaluation."""
        forces = np.array([pairs[0]["mesh.tangentialForce"] for pairs in self.meshes])
        return forces / forces.sum()

    def mass(self) -> np.ndarray:
        """Diagonal of the mass matrix."""
        sun = [self.masses[0], self.masses[0], self.inertias[0]]
        planet = [self.masses[1], self.masses[1], self.inertias[1]]
        return np.array(sun + planet * len(self.places) + [1e3 * self.masses[2]])

    def energy(self, q: np.ndarray, q_t: np.ndarray) -> tuple[float, float]:
        """Kinetic energy, and elastic energy of pins and sun support, J."""
        shift = self.pins(q[-1]) - self._planets(q)
        elastic = 0.5 * (self.sun_support * q[:2] @ q[:2] + self.pin * np.sum(shift**2))
        return 0.5 * float(self.mass() @ q_t**2), float(elastic)

    def run(self, q, q_t, torques: tuple[float, float], duration: float, step: float, every: int):
        """Runge-Kutta 4 under constant torques on sun and carrier, every `every`-th step: time, coordinates, rates, and integrals.

        Those are the work of the torques, what the meshes lose, and the impulse (x, y) that sun and planets get from
        ring, pins and sun support.
        """
        inverse, load, half = 1.0 / self.mass(), np.zeros(len(q)), len(q)
        load[2], load[-1] = torques

        def rate(_, z):
            q, q_t = z[:half], z[half:]
            return np.concatenate([q_t, (self.forces(q, q_t) + load) * inverse])

        def accounts(_, z):
            q, q_t = z[:half], z[half:]
            # The ring's own loads, not those on the planets, so that the sum is a check.
            push = -sum(np.array(pairs[1].y[6:8]) for pairs in self.meshes)
            push = push + self.pin * (self.pins(q[-1]) - self._planets(q)).sum(axis=0) - self.sun_support * q[:2]
            return [load @ q_t, sum(mesh_loss(pair) for pairs in self.meshes for pair in pairs), *push]

        run = integrate(rate, np.concatenate([q, q_t]), step, round(duration / step), every=every, accounts=accounts)
        for time, z, integrals in run:
            yield time, z[:half], z[half:], integrals

    def momentum(self, q_t: np.ndarray) -> np.ndarray:
        """Linear momentum of sun and planets, x and y, N s."""
        return self.masses[0] * q_t[:2] + self.masses[1] * self._planets(q_t).sum(axis=0)

    @staticmethod
    def _planets(q: np.ndarray) -> np.ndarray:
        """x and y of the planets, one row each."""
        return q[3:-1].reshape(-1, 3)[:, :2]
