"""What is looked at in a run: rotation of gear 1 with the acceleration of the housing wall and what the unit says."""

from __future__ import annotations

import numpy as np
from gearmesh import History

from .model import HOUSING_CENTER, SENSOR, SHAFTS, Motion


def observed(motion: Motion) -> History:
    """Angle and speed of gear 1; `wall_m_per_s2` is the acceleration of the sensor along y, the housing turning by microradians
    only. The outputs of the unit keep their names and are in SI."""
    first = 6 * (1 + SHAFTS[0].gear) + 5
    arm = np.subtract(SENSOR, HOUSING_CENTER)
    angular = motion.q_tt[:, 3:6]
    wall = motion.q_tt[:, 1] + angular[:, 2] * arm[0] - angular[:, 0] * arm[2]
    return History(motion.time, motion.q[:, first], motion.q_t[:, first] * 30.0 / np.pi, {"wall_m_per_s2": wall, **motion.mesh})
