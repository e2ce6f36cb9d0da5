"""Predicted loads through a packed unit: the clearance oscillator of the literature at few steps a mesh cycle."""

import json
import math

import numpy as np
import pytest
from conftest import PAIRS, gearmesh
from gearmesh import GearPair

STIFFNESS, SWING, ZETA = 4.9e8, 0.2, 0.03  # N/m on the line of action, of it, damping ratio at gear 2
TORQUE = 100.0  # on gear 2, N m
INERTIA = 4.213e-4
STEPS = 20  # a mesh cycle
SETTLE, MEASURE = 66, 20  # cycles


@pytest.fixture(scope="module")
def oscillator(tmp_path_factory):
    """A unit of y'' + k(t) max(y, 0) = 1, k = 1 + 0.2 cos(mesh position), and the base radii of its gears."""
    folder = tmp_path_factory.mktemp("oscillator")
    pair = PAIRS / "palermo2013-unmodified.json"
    geometry = json.loads(pair.read_text())
    helix = math.radians(geometry.get("helix_angle_deg", 0.0))
    pressure = math.atan(math.tan(math.radians(geometry["normal_pressure_angle_deg"])) / math.cos(helix))
    module = geometry["normal_module_mm"] * 1e-3 / math.cos(helix)
    radius = [0.5 * geometry[gear]["teeth"] * module * math.cos(pressure) for gear in ("gear1", "gear2")]
    rows = ["torque_nm,mesh_position,center_distance_offset_um,misalignment_mrad,ste_loa_um,contact_z_mm"]
    for torque in (0.0, 0.1, 1.0, 10.0, 100.0, 1000.0):
        for n in range(32):
            stiffness = STIFFNESS * (1.0 + SWING * math.cos(math.tau * n / 32))
            face = 0.5e3 * geometry["gear1"].get("face_width_mm", 20.0) * 1e-3
            rows.append(f"{torque},{n / 32},0,0,{1e6 * torque / radius[0] / stiffness!r},{face}")
    samples, tables, fmu = folder / "samples.csv", folder / "tables.json", folder / "oscillator.fmu"
    samples.write_text("\n".join(rows) + "\n")
    gearmesh("import", samples, "--pair", pair, "-o", tables)
    mass = INERTIA / radius[1] ** 2
    settings = ["damping=0", "loadedFlank=drive", f"effectiveMass={mass!r}"]
    gearmesh("pack", "--tables", tables, "-o", fmu, *(x for s in settings for x in ("--set", s)))
    teeth = [geometry[gear]["teeth"] for gear in ("gear1", "gear2")]
    return fmu, radius, teeth


def run(oscillator, coupling, ratio, motion):
    """rms of y about its mean at the frequency `ratio` over the natural one, and y and its rate at the end, from there."""
    fmu, radius, teeth = oscillator
    omega = math.sqrt(STIFFNESS / INERTIA) * radius[1]
    static = TORQUE / radius[1] / STIFFNESS
    speed = ratio * omega / teeth[0]
    back = -speed * teeth[0] / teeth[1]
    step = math.tau / (ratio * omega) / STEPS
    angle, rate, drag = 0.0, 0.0, 2.0 * ZETA * omega  # of gear 2 beside its mean motion
    out = np.empty(MEASURE * STEPS)
    with GearPair(fmu, {"coupling": coupling}) as pair:
        pair.initialize()
        acting = 0.0
        angle, rate = motion[0] * static / radius[1], motion[1] * static * omega / radius[1]
        error, error_rate = "mesh.transmissionError", "mesh.transmissionErrorRate"
        for n in range((SETTLE + MEASURE) * STEPS + 1):
            t = n * step
            pair["gear1.angles[3]"], pair["gear1.angularVelocity[3]"] = speed * t, speed
            pair["gear2.angles[3]"], pair["gear2.angularVelocity[3]"] = back * t + angle, back + rate
            before = acting
            pair.step(step)
            acting = pair["gear2.moment[3]"]
            if n >= SETTLE * STEPS and n < (SETTLE + MEASURE) * STEPS:
                out[n - SETTLE * STEPS] = pair[error]
            torque = (before if coupling == "parallel" and n else acting) + TORQUE
            # Exact under a constant torque and the drag.
            final = torque / INERTIA / drag
            fade = math.exp(-drag * step)
            angle += final * step + (rate - final) * (1.0 - fade) / drag
            rate = final + (rate - final) * fade
        scale = sum(radius) / pair["mesh.centerDistance"] / static  # from the pitch circle to the line of action
        return out.std() * scale, (pair[error] * scale, pair[error_rate] * scale / omega)


def sweep(oscillator, coupling, start, end):
    """rms over frequency, each run from where the last one ended."""
    motion, curve = (1.0, 0.0), {}
    for ratio in np.linspace(start, end, round(abs(end - start) / 0.005) + 1):
        curve[round(float(ratio), 3)], motion = run(oscillator, coupling, float(ratio), motion)
    return curve


def jump(curve):
    """The last frequency before the largest step of the curve."""
    values = np.array(list(curve.values()))
    return list(curve)[int(np.abs(np.diff(values)).argmax())]


@pytest.mark.parametrize("coupling", ["sequential", "parallel"])
def test_twenty_steps_a_mesh_cycle_find_both_branches_of_the_clearance_oscillator(oscillator, coupling):
    rising, falling = sweep(oscillator, coupling, 0.85, 0.92), sweep(oscillator, coupling, 0.92, 0.67)
    assert jump(rising) == pytest.approx(0.895, abs=0.015)
    assert jump(falling) == pytest.approx(0.70, abs=0.015)
    assert rising[0.85] == pytest.approx(0.529, rel=0.03)
    assert falling[0.85] == pytest.approx(1.539, rel=0.03)
