"""Gear 1 held, gear 2 on springs in some of its six freedoms: in time through the FMU, and in closed form."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from gearmesh import GearPair, integrate
from gearmesh.energy import Ledger, mesh_loss
from gearmesh.poses import generalised, place

from examples.shared.files import opened, shipped

# The pair helical-25-47 by its drawing: transverse pressure angle and helix angle at the operating pitch cylinders.
CENTER_DISTANCE, MIDDLE, FACE_OF_GEAR2 = 98e-3, 11e-3, 1e-3  # m; MIDDLE of the common face in gear 2's frame
RADIUS = CENTER_DISTANCE * 47 / 72
REFERENCE = ((0.0, 0.0, 0.0), (CENTER_DISTANCE, 0.0, FACE_OF_GEAR2))
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


class Assembly:
    """Gear 2 on its support under the swinging torque, gear 1 held, in time through the FMU."""

    def __init__(self, support: Support, pair: GearPair, frequency: float):
        self.mass, self.stiffness, self.damping = support.matrices()
        self.inverse, self.row = np.linalg.inv(self.mass), mesh_row()[list(support.free)]
        self.pair, self.places, self.omega = pair, [6 + i for i in support.free], 2.0 * np.pi * frequency
        self.load = np.zeros(len(self.row))
        self.load[-1] = 1.0

    def torque(self, time: float) -> float:
        return TORQUE + SWING * np.sin(self.omega * time)

    def rate(self, time: float, z: np.ndarray) -> np.ndarray:
        q, q_t = np.split(z, 2)
        all_q, all_t = np.zeros(12), np.zeros(12)
        all_q[self.places], all_t[self.places] = q, q_t
        place(self.pair, all_q.tolist(), all_t.tolist(), REFERENCE)
        self.pair.evaluate(time)
        force = generalised(self.pair.y[:12], all_q)[self.places]
        force += self.torque(time) * self.load - self.stiffness @ q - self.damping @ q_t
        return np.concatenate([q_t, self.inverse @ force])

    def accounts(self, time: float, z: np.ndarray) -> list[float]:
        """Power of the torque, lost in dampers and mesh; what holds gear 1 and the support of gear 2 push, in six freedoms."""
        q, q_t = np.split(z, 2)
        lost = q_t @ self.damping @ q_t + mesh_loss(self.pair)
        support = -(self.stiffness @ q + self.damping @ q_t)[:3] if len(q) == 6 else np.zeros(3)
        return [self.torque(time) * q_t[-1], lost, *(support - self.pair.y[:3])]

    def start(self) -> np.ndarray:
        """At rest under the mean torque."""
        q = np.linalg.solve(self.stiffness + STIFFNESS * np.outer(self.row, self.row), TORQUE * self.load)
        return np.concatenate([q, np.zeros(len(q))])


@contextmanager
def assembled(support: Support, frequency: float, damping: float = DAMPING):
    choices = {"stiffnessModel": "constant", "constantStiffness": STIFFNESS, "damping": damping}
    with opened(shipped("helical-25-47"), choices) as pair:
        yield Assembly(support, pair, frequency)


def measured(support: Support, frequency: float, points: int = 48) -> float:
    """The same through the FMU: Runge-Kutta 4 until transients have died out, then a Fourier sum over whole periods."""
    with assembled(support, frequency) as line:
        # Steps of about 2.5 us, well inside the stability limit of the stiffest mode, a whole number in a period.
        count = max(points, round(1.0 / frequency / 2.5e-6))
        settle, cycles = max(4, round(0.04 * frequency)), 4
        run = integrate(line.rate, line.start(), 1.0 / frequency / count, count * (settle + cycles) - 1)
        sample = np.array([line.pair["mesh.transmissionError"] for _ in run])[count * settle :]
    phase = 2j * np.pi * np.arange(len(sample)) / count
    return 2.0 * abs(np.mean(sample * np.exp(-phase)))


def balance(support: Support, damped: bool, duration: float = 6e-3, step: float = 2.5e-6) -> dict[str, float]:
    """Under the torque swinging at 500 Hz, from its mean: what energy, momentum of gear 2 and loads stray, over the run."""
    support, ledger = support if damped else replace(support, loss=0.0), Ledger(duration)
    with assembled(support, 500.0, DAMPING if damped else 0.0) as line:
        for _, z, (work, lost, *impulse) in integrate(line.rate, line.start(), step, round(duration / step), every=100, accounts=line.accounts):
            q, q_t = np.split(z, 2)
            stray = (line.mass @ q_t)[:3] - impulse if len(q) == 6 else None
            ledger.enter([line.pair], 0.5 * q_t @ line.mass @ q_t, 0.5 * q @ line.stiffness @ q, lost, work, stray)
    return ledger.found()
