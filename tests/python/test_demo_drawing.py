"""The demo's own geometry against the paper and against the definition of the misalignment."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from demo.drawing import Drawing  # noqa: E402


@pytest.fixture(scope="module")
def drawing():
    return Drawing.read(ROOT / "resources" / "pairs" / "palermo2013.json")


def rotation(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    if axis == "x":
        return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def test_nominal_normal_force_follows_from_the_geometry(drawing):
    assert drawing.nominal_normal_force == pytest.approx(2660.4, abs=0.1)


@pytest.mark.parametrize("misalignment", [-3e-3, -1e-6, 0.0, 2e-3])
def test_tilt_of_gear2_gives_the_misalignment_asked_for_and_none_across_the_plane(drawing, misalignment):
    alpha, beta = drawing.tilt_of_gear2(misalignment)
    axis2 = rotation("x", alpha) @ rotation("y", beta) @ np.array([0.0, 0.0, 1.0])
    phi = drawing.pressure_angle
    in_plane = np.array([math.sin(phi), math.cos(phi), 0.0])
    across = np.array([math.cos(phi), -math.sin(phi), 0.0])
    difference = np.array([0.0, 0.0, 1.0]) - axis2
    assert in_plane @ difference == pytest.approx(misalignment, abs=1e-15)
    assert across @ difference == pytest.approx(0.0, abs=1e-15)
