"""Gear 1 held, gear 2 on springs in some of its six freedoms: in time through the unit, and in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from gearmesh import GearPair

from ..cardan import generalised, place
from ..files import shipped
from ..integrate import runge_kutta

# The pair helical-25-47 by its drawing: transverse pressure angle and helix angle at the operating pitch cylinders.
CENTER_DISTANCE, MIDDLE, FACE_OF_GEAR2 = 98e-3, 11e-3, 1e-3  # m; MIDDLE of the common face in gear 2's frame
RADIUS = CENTER_DISTANCE * 47 / 72
PHI = np.radians(22.7804)
TAN_BETA = np.tan(np.radians(22.0)) * RADIUS / (47 * 2.5e-3 / np.cos(np.radians(22.0)) / 2.0)
STIFFNESS, DAMPING = 2.556e8, 782.0  # tangential, N/m and N s/m
TORQUE, SWING = 50.0, 4.0  # N m on gear 2: mean and amplitude


@dataclass(frozen=True)
class Support:
    """Mass, inertias, and springs at the middle of the face; SI. `free` are the freedoms x, y, z, tilts, spin."""

    free: tuple[int, ...]
    mass: float = 2.0
    inertias: tuple[float, float, float] = (2.2e-3, 2.2e-3, 4.2e-3)
    springs: tuple[float, ...] = (1.5e8, 1.5e8, 8e7, 2e5, 2e5, 0.0)
    loss: float = 1.5e-5  # s, dampers over springs

    def matrices(self):
        """Mass, stiffness and damping of gear 2 about the origin of its frame, in the z = 0 face."""
        shift = np.eye(6)
        shift[0, 4], shift[1, 3] = MIDDLE, -MIDDLE
        mass = shift.T @ np.diag([self.mass] * 3 + list(self.inertias)) @ shift
        stiffness = shift.T @ np.diag(self.springs) @ shift
        pick = np.ix_(self.free, self.free)
        return mass[pick], stiffness[pick], self.loss * stiffness[pick]


ONE, SIX = Support(free=(5,)), Support(free=(0, 1, 2, 3, 4, 5))


def mesh_row() -> np.ndarray:
    """Tangential elongation by unit displacements of gear 2 (drive flank, gear 2 at +x of gear 1), from the textbook.

    The force on gear 2, F (tan phi, 1, -tan beta_w), acts at the pitch point in the middle of the face.
    """
    force = np.array([np.tan(PHI), 1.0, -TAN_BETA])
    return -np.concatenate([force, np.cross([-RADIUS, 0.0, MIDDLE], force)])


def closed_form(support: Support, frequencies) -> np.ndarray:
    """Amplitude of the transmission error, m, over frequency, Hz, under the swinging torque."""
    mass, stiffness, damping = support.matrices()
    row = mesh_row()[list(support.free)]
    load = np.zeros(len(row))
    load[-1] = SWING
    out = []
    for omega in 2.0 * np.pi * np.asarray(frequencies):
        dynamic = stiffness + STIFFNESS * np.outer(row, row) - omega**2 * mass
        dynamic = dynamic + 1j * omega * (damping + DAMPING * np.outer(row, row))
        out.append(abs(row @ np.linalg.solve(dynamic, load)))
    return np.array(out)


def eigenfrequencies(support: Support) -> np.ndarray:
    """Undamped, Hz."""
    mass, stiffness, _ = support.matrices()
    row = mesh_row()[list(support.free)]
    values = np.linalg.eigvals(np.linalg.solve(mass, stiffness + STIFFNESS * np.outer(row, row)))
    return np.sqrt(np.sort(np.maximum(values.real, 0.0))) / (2.0 * np.pi)


def measured(support: Support, frequency: float, points: int = 48) -> float:
    """The same through the unit: Runge-Kutta 4 until transients have died out, then a Fourier sum over whole periods."""
    mass, stiffness, damping = support.matrices()
    inverse, free = np.linalg.inv(mass), list(support.free)
    row, omega = mesh_row()[free], 2.0 * np.pi * frequency
    load = np.zeros(len(row))
    load[-1] = 1.0
    reference = [(0.0, 0.0, 0.0), (CENTER_DISTANCE, 0.0, FACE_OF_GEAR2)]
    choices = {"stiffnessModel": "constant", "constantStiffness": STIFFNESS, "damping": DAMPING}
    with GearPair(shipped("helical-25-47"), choices, "model-exchange") as pair:
        pair.initialize()

        def rate(time, z):
            q, q_t = np.split(z, 2)
            all_q, all_t = np.zeros(12), np.zeros(12)
            all_q[places], all_t[places] = q, q_t
            place(pair, all_q.tolist(), all_t.tolist(), reference)
            pair.evaluate(time)
            force = generalised(pair.y[:12], all_q)[places]
            torque = TORQUE + SWING * np.sin(omega * time)
            return np.concatenate([q_t, inverse @ (force + torque * load - stiffness @ q - damping @ q_t)])

        q = np.linalg.solve(stiffness + STIFFNESS * np.outer(row, row), TORQUE * load)
        state, places = np.concatenate([q, np.zeros(len(q))]), [6 + i for i in free]
        # Steps of about 2.5 us, well inside the stability limit of the stiffest mode, a whole number in a period.
        count = max(points, round(1.0 / frequency / 2.5e-6))
        step, settle, cycles = 1.0 / frequency / count, max(4, round(0.04 * frequency)), 4
        sample = np.zeros(count * cycles)
        for n in range(count * (settle + cycles)):
            if n >= count * settle:
                rate(n * step, state)
                sample[n - count * settle] = pair["mesh.transmissionError"]
            state = runge_kutta(rate, n * step, state, step)
    phase = 2j * np.pi * np.arange(len(sample)) / count
    return 2.0 * abs(np.mean(sample * np.exp(-phase)))
