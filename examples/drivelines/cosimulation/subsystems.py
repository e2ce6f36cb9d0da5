"""Shafts on bearings, and a housing by its modes: linear systems that step exactly under inputs linear in time.

Used as they are by the masters in this folder, and packed as FMUs by pythonfmu; so this file imports nothing of the folder.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

BEARING = (2e8, 600.0)  # N/m and N s/m, radial, at each gear's shaft
MASSES, INERTIAS = (1.2, 3.0), (4e-4, 4.5e-3)  # gears with their shafts, kg and kg m^2
SEATS = (0.15, 0.248)  # m along the housing's beam, at the two shafts
BEAM_LENGTH, BEAM_MASS, BEAM_BENDING = 0.4, 18.0, 206e9 * 1.2e-6  # m, kg, N m^2
MODES, LOSS = 4, 0.02  # modal damping ratio
SENSOR = 0.31  # m
TEETH = (25, 47)


class Linear:
    """x' = A x + B u, exact over a step on which u runs linearly; B u as force per input."""

    def __init__(self, a: np.ndarray, b: np.ndarray, state: np.ndarray):
        self.a, self.b, self.x = a, b, state
        self._size, self._parts = 0.0, None

    def parts(self, size: float):
        """State transition, and what inputs at the start and their change over the step add, for a step of `size` s."""
        if size != self._size:
            n, m = self.b.shape
            # exp of the augmented matrix: u' = slope, slope' = 0.
            augmented = np.zeros((n + 2 * m, n + 2 * m))
            augmented[:n, :n], augmented[:n, n : n + m] = self.a * size, self.b * size
            augmented[n : n + m, n + m :] = np.eye(m)
            total = expm(augmented)
            self._size, self._parts = size, (total[:n, :n], total[:n, n : n + m], total[:n, n + m :])
        return self._parts

    def step(self, start, end, size: float) -> np.ndarray:
        """The state after a step from the present one under inputs from `start` to `end`; changes nothing."""
        transition, held, ramp = self.parts(size)
        return transition @ self.x + held @ start + ramp @ (end - start)


def bearing(damped: bool = True) -> tuple[float, float]:
    """Stiffness and damping of a bearing."""
    return BEARING[0], BEARING[1] * damped


def shafts(state: np.ndarray | None = None, damped: bool = True) -> Linear:
    """Gear 1 and 2 in the plane, on bearings whose seats move along y.

    State: x, y, angle of gear 1, of gear 2, and their rates. Inputs: force x, y and moment of teeth and drive on gear 1,
    on gear 2, then displacement of both seats, then their velocities.
    """
    k, c = bearing(damped)
    mass = np.array([MASSES[0], MASSES[0], INERTIAS[0], MASSES[1], MASSES[1], INERTIAS[1]])
    on = np.array([1.0, 1.0, 0.0, 1.0, 1.0, 0.0]) / mass
    a, b = np.zeros((12, 12)), np.zeros((12, 10))
    a[:6, 6:] = np.eye(6)
    a[6:, :6], a[6:, 6:] = np.diag(-k * on), np.diag(-c * on)
    b[6:, :6] = np.diag(1.0 / mass)
    for i, row in enumerate((7, 10)):
        b[row, 6 + i], b[row, 8 + i] = k * on[row - 6], c * on[row - 6]
    return Linear(a, b, np.zeros(12) if state is None else state)


def bearing_forces(x: np.ndarray, seats: np.ndarray, damped: bool = True) -> np.ndarray:
    """Forces along y of the shafts on their seats, from the shafts' state, and displacement and velocity of the seats."""
    k, c = bearing(damped)
    return k * (x[[1, 4]] - seats[:2]) + c * (x[[7, 10]] - seats[2:])


def shape(place) -> np.ndarray:
    """Mode shapes of the simply supported beam, mass-normalised, a column for each mode."""
    waves = np.pi * np.arange(1, MODES + 1) / BEAM_LENGTH
    return np.sqrt(2.0 / BEAM_MASS) * np.sin(np.outer(np.atleast_1d(place), waves))


def housing(state: np.ndarray | None = None, damped: bool = True) -> Linear:
    """Modal housing. State: modal displacements and velocities. Inputs: forces along y at both seats."""
    waves = np.pi * np.arange(1, MODES + 1) / BEAM_LENGTH
    omega, loss = waves**2 * np.sqrt(BEAM_BENDING * BEAM_LENGTH / BEAM_MASS), LOSS * damped
    a, b = np.zeros((2 * MODES, 2 * MODES)), np.zeros((2 * MODES, 2))
    a[:MODES, MODES:] = np.eye(MODES)
    a[MODES:, :MODES], a[MODES:, MODES:] = np.diag(-(omega**2)), np.diag(-2.0 * loss * omega)
    b[MODES:] = shape(SEATS).T
    return Linear(a, b, np.zeros(2 * MODES) if state is None else state)


def seat_motion(x: np.ndarray) -> np.ndarray:
    """Displacement of both seats, then their velocities, from the housing's state."""
    return np.concatenate([shape(SEATS) @ x[:MODES], shape(SEATS) @ x[MODES:]])
