"""Predicted loads through a packed FMU: the clearance oscillator of the literature at few steps a mesh cycle."""

import math

import numpy as np
import pytest
from conftest import oscillator
from gearmesh import GearPair, Turning, cosimulate

STIFFNESS, SWING, ZETA = 4.9e8, 0.2, 0.03  # N/m on the line of action, of it, damping ratio at gear 2
TORQUE, INERTIA = 100.0, 4.213e-4  # N m and kg m^2, gear 2
STEPS = 20  # a mesh cycle
SETTLE, MEASURE = 66, 20  # cycles


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    return oscillator(tmp_path_factory.mktemp("oscillator"), SWING)


def run(unit, coupling, ratio, motion):
    """rms of y about its mean at the frequency `ratio` over the natural one, and y and its rate at the end, from there."""
    with GearPair(unit, {"coupling": coupling}) as pair:
        geometry, radius = pair.geometry, pair.geometry.base_radii[1]
        pair.set_parameter("effectiveMass", INERTIA / radius**2)
        pair.initialize()
        omega, static = math.sqrt(STIFFNESS / INERTIA) * radius, TORQUE / radius / STIFFNESS
        speed = ratio * omega / geometry.teeth[0]
        step, drag = math.tau / (ratio * omega) / STEPS, 2.0 * ZETA * omega  # of gear 2 beside its mean motion
        fade, turning = math.exp(-drag * step), Turning(pair, step)

        def advance(_, state):
            """Exact under a constant torque and the drag."""
            angle, rate = state
            final = (turning.moments()[1] + TORQUE) / INERTIA / drag
            return angle + final * step + (rate - final) * (1.0 - fade) / drag, final + (rate - final) * fade

        def place(time, state):
            turning.place(speed * time, speed, geometry.ratio * speed * time + state[0], geometry.ratio * speed + state[1])

        start = motion[0] * static / radius, motion[1] * static * omega / radius
        found = [pair["mesh.transmissionError"] for _ in cosimulate(pair, place, advance, start, step, (SETTLE + MEASURE) * STEPS + 1)]
        scale = math.cos(geometry.pressure_angle) / static  # from the pitch circle to the line of action
        end = found[-1] * scale, pair["mesh.transmissionErrorRate"] * scale / omega
        return np.std(found[SETTLE * STEPS : -1]) * scale, end


def sweep(unit, coupling, start, end):
    """rms over frequency, each run from where the last one ended."""
    motion, curve = (1.0, 0.0), {}
    for ratio in np.linspace(start, end, round(abs(end - start) / 0.005) + 1):
        curve[round(float(ratio), 3)], motion = run(unit, coupling, float(ratio), motion)
    return curve


def jump(curve):
    """The last frequency before the largest step of the curve."""
    return list(curve)[int(np.abs(np.diff(list(curve.values()))).argmax())]


@pytest.mark.parametrize("coupling", ["sequential", "parallel"])
def test_twenty_steps_a_mesh_cycle_find_both_branches_of_the_clearance_oscillator(unit, coupling):
    rising, falling = sweep(unit, coupling, 0.85, 0.92), sweep(unit, coupling, 0.92, 0.67)
    assert jump(rising) == pytest.approx(0.895, abs=0.015)
    assert jump(falling) == pytest.approx(0.70, abs=0.015)
    assert rising[0.85] == pytest.approx(0.529, rel=0.03)
    assert falling[0.85] == pytest.approx(1.539, rel=0.03)
