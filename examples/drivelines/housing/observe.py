"""What is looked at in a run: rotation of gear 1 and acceleration of the housing wall."""

from __future__ import annotations

import numpy as np

from .model import HOUSING_CENTER, SENSOR, SHAFTS, History


def spin(history: History):
    """Angle (rad) and speed (rad/s) of gear 1."""
    first = 6 * (1 + SHAFTS[0].gear) + 5
    return history.q[:, first], history.q_t[:, first]


def wall(history: History) -> np.ndarray:
    """Acceleration of the sensor along y, m/s^2; the housing turns by microradians only."""
    arm = np.subtract(SENSOR, HOUSING_CENTER)
    angular = history.q_tt[:, 3:6]
    return history.q_tt[:, 1] + angular[:, 2] * arm[0] - angular[:, 0] * arm[2]
