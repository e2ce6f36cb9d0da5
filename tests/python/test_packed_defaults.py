"""What packing derives from a pair: damping and step that co-simulation masters survive, both flanks, a first run."""

import json
import math
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import gearmesh
import numpy as np
import pytest
from conftest import ROOT, SHIPPED, TABLES
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.util import read_csv
from gearmesh import GearPair, Turning, cosimulate
from gearmesh.poses import POSES, RATES
from scipy.linalg import expm

STEEL = 7850.0
COUPLINGS = pytest.mark.parametrize("coupling", ["sequential", "parallel"])
EVERY_PAIR = pytest.mark.parametrize("name", SHIPPED)


class Mesh:
    """A running FMU, by default with packed parameters, and its gears as solid steel discs."""

    def __init__(self, fmu, coupling="sequential"):
        self.pair = GearPair(fmu, {} if coupling == "kept" else {"coupling": coupling})  # kept: as packed
        with zipfile.ZipFile(fmu) as archive:
            self.gears = json.loads(archive.read("resources/unit.json"))["geometry"]["gears"]
        self.geometry, self.torque = self.pair.geometry, self.pair.parameters["nominalTorque"]
        self.pitch_angle = math.tau / self.geometry.teeth[0]
        self.force = self.torque / self.geometry.pitch_radii[0]
        self.step = float(read_model_description(str(fmu)).defaultExperiment.stepSize)
        self.pair.initialize()

    def blank(self, gear):
        """Mass, moments of inertia about the axis and across it at mid-face."""
        g = self.gears[gear]
        reference = 0.5 * g["teeth"] * g["normal_module_m"] / math.cos(g["helix_angle_rad"])
        squares = reference**2 + g["held_radius_m"] ** 2
        mass = STEEL * math.pi * abs(reference**2 - g["held_radius_m"] ** 2) * g["face_width_m"]
        return mass, 0.5 * mass * squares, 0.25 * mass * squares + mass * g["face_width_m"] ** 2 / 12

    def spin(self, free, step, torque=None, speed=0.0, duration=0.03, late=None):
        """Tangential force and transmission error over time while the gears in `free` spin under the mesh and the torque on gear 1
        `torque(t)` (its reaction on gear 2; by default the nominal one), from rest against one another at `speed` of gear 1. The bodies
        move exactly under loads that are held over a step."""
        turning, ratio = Turning(self.pair, step), self.geometry.ratio
        inverse = np.array([1.0 / self.blank(i)[1] if i in free else 0.0 for i in (0, 1)])

        def advance(time, state):
            angle, rate = state
            load = torque(time + 0.5 * step) if torque else self.torque
            acceleration = inverse * (np.array(turning.moments()) + [load, -load / ratio])
            return angle + step * rate + 0.5 * step**2 * acceleration, rate + step * acceleration

        def place(_, state):
            (angle1, angle2), (rate1, rate2) = state
            turning.place(angle1, rate1, angle2, rate2)

        rows, start = [], (np.zeros(2), speed * np.array([1.0, ratio]))
        for _ in cosimulate(self.pair, place, advance, start, step, round(duration / step), late=late):
            rows.append((self.pair["mesh.tangentialForce"], self.pair["mesh.transmissionError"]))
            assert rows[-1][0] < 1e9
        return np.array(rows).T


def assert_settles(force, mean, least, share):
    """The force departs from its mean by more than the part `least` of it in the first quarter of the time, and by less than `share` of
    that in the last one."""
    first, *_, last = (part.max() for part in np.array_split(np.abs(force / mean - 1.0), 4))
    assert first > least
    assert last < share * first


@COUPLINGS
@pytest.mark.parametrize("free", [(0,), (1,), (0, 1)], ids=["gear1", "gear2", "both"])
@EVERY_PAIR
def test_masters_survive_twice_the_packed_step(fmus, name, free, coupling):
    mesh = Mesh(fmus[name], coupling)
    # Nominal torque at once, so that the force starts by swinging to twice its mean; half a cycle a millisecond.
    force, _ = mesh.spin(free, 2 * mesh.step, speed=500 * mesh.pitch_angle)
    assert_settles(force, mesh.force, 0.6, 0.7)


@COUPLINGS
@EVERY_PAIR
def test_the_packed_step_costs_less_than_a_percent(fmus, name, coupling):
    """A load over 2 ms, gear 1 at constant speed: the transmission error against a twentieth of the step."""

    def run(divisor):
        mesh = Mesh(fmus[name], "sequential" if divisor > 1 else coupling)
        load = lambda t: mesh.torque * min(t / 2e-3, 1.0)  # noqa: E731
        return mesh.spin((1,), mesh.step / divisor, load, 750 * mesh.pitch_angle, 0.012)[1][::divisor]

    reference, found = run(20), run(1)
    count = min(len(found), len(reference))
    error = np.sqrt(np.mean((found[:count] - reference[:count]) ** 2)) / reference.std()
    assert error < 0.007, error


@pytest.mark.parametrize("late", [False, True], ids=["sequential", "parallel"])
@EVERY_PAIR
def test_a_master_that_keeps_the_default_is_found_stable_and_within_a_percent(fmus, name, late):
    """A load over 2 ms, both gears free: against a twentieth of the step."""

    def run(divisor, late):
        mesh = Mesh(fmus[name], "sequential" if divisor > 1 else "kept")
        load = lambda t: mesh.torque * min(t / 2e-3, 1.0)  # noqa: E731
        error = mesh.spin((0, 1), mesh.step / divisor, load, 750 * mesh.pitch_angle, 0.012, late)[1][::divisor]
        return error, mesh.pair["coupling.mode"]

    (reference, _), (found, mode) = run(20, False), run(1, late)
    count = min(len(found), len(reference))
    steady = slice(count // 2, count)
    assert mode == (2.0 if late else 1.0)
    assert np.sqrt(np.mean((found[steady] - reference[steady]) ** 2)) < 0.01 * reference.std()
    assert np.sqrt(np.mean((found[:count] - reference[:count]) ** 2)) < 0.02 * reference.std()


@COUPLINGS
@EVERY_PAIR
def test_a_gear_on_bearings_with_all_its_freedoms_survives_twice_the_packed_step(fmus, name, coupling):
    """Gear 2 spins freely and is held radially, axially and against tilting by bearings of damping ratio 0.02, which
    the master integrates exactly with the body."""
    mesh = Mesh(fmus[name], coupling)
    pair, step = mesh.pair, 2 * mesh.step
    mass, axial, transverse = mesh.blank(1)
    inertia = np.array([mass] * 3 + [transverse] * 2 + [axial])
    bearing = np.array([3e8, 3e8, 1e8, 2e5, 2e5, 0.0])
    damping = 2 * 0.02 * np.sqrt(bearing * inertia)
    # Of (place, speed, held load): the exact step.
    system = np.zeros((18, 18))
    for i in range(6):
        system[i, 6 + i] = 1.0
        system[6 + i, [i, 6 + i, 12 + i]] = [-bearing[i] / inertia[i], -damping[i] / inertia[i], 1 / inertia[i]]
    exact = expm(system * step)[:12]
    half = np.array([0.0, 0.0, 0.5 * mesh.gears[1]["face_width_m"]])
    start = np.array(pair.u[POSES[1]][:3])
    outside = -mesh.torque / mesh.geometry.ratio

    def place(_, state):
        # Small tilts: the origin lies half a face below the centre.
        for at, (shift, turn), origin in ((POSES[1], state[:6].reshape(2, 3), start), (RATES[1], state[6:].reshape(2, 3), 0.0)):
            pair.u[at] = [*(origin + shift - np.cross(turn * [1, 1, 0], half)), *turn]

    def advance(_, state):
        force, moment = np.array(pair.y[6:12]).reshape(2, 3)
        return exact @ np.concatenate([state, force, moment - np.cross(half, force) + [0.0, 0.0, outside]])

    force = []
    for _ in cosimulate(pair, place, advance, np.zeros(12), step, round(0.03 / step)):
        force.append(pair["mesh.tangentialForce"])
        assert force[-1] < 1e9
    assert_settles(np.array(force), mesh.force, 0.7, 0.5)


@COUPLINGS
@EVERY_PAIR
def test_a_reversed_torque_ends_on_the_coast_flank_without_a_jump(fmus, name, coupling):
    mesh = Mesh(fmus[name], coupling)

    def torque(t):
        return mesh.torque * math.cos(math.pi * min(max(t - 2e-3, 0.0) / 6e-3, 1.0))

    force, _ = mesh.spin((1,), mesh.step / 16, torque)
    assert (mesh.pair.flank, mesh.pair.out_of_range) == (-1, False)
    assert force[-len(force) // 5 :].mean() == pytest.approx(mesh.force, rel=0.02)
    # Teeth that meet do so within some steps: an impact is no wall.
    assert np.abs(np.diff(force)).max() < 0.08 * mesh.force
    assert force.max() < 4 * mesh.force


@EVERY_PAIR
def test_without_load_forces_stay_small(fmus, name):
    """The damper fades at light load, so that held loads rattle there; no more than that."""
    mesh = Mesh(fmus[name], "parallel")
    force, _ = mesh.spin((1,), mesh.step, lambda t: 0.01 * mesh.torque)
    assert force.max() < 0.1 * mesh.force


@EVERY_PAIR
def test_the_description_and_the_page_name_pair_damping_and_step(fmus, name):
    description = read_model_description(str(fmus[name]))
    assert description.modelName == name
    assert description.coSimulation.modelIdentifier == "GearMesh"
    with zipfile.ZipFile(fmus[name]) as archive:
        text = archive.read("documentation/index.html").decode()
    start = {v.name: v.start for v in description.modelVariables}

    def row(label):
        found = re.search(rf"<td>{re.escape(label)}</td><td>([0-9.e+-]+)", text)
        return float(found.group(1))

    step = description.defaultExperiment.stepSize
    cost = re.search(r"<code>stepSize</code>: ([0-9.]+) % rms", text)
    steady = re.search(r"and ([0-9.]+) % in steady state", text)
    # The search for the master costs some of it where the load rises.
    assert 0 < float(cost.group(1)) < 2.0
    assert 0 < float(steady.group(1)) < 1.0
    assert f"costs {float(cost.group(1)):.2f} % rms" in gearmesh.inspect(fmus[name]).text
    assert row("<code>stepSize</code>") == pytest.approx(float(step), rel=1e-3)
    assert row("<code>damping</code> c") == pytest.approx(float(start["damping"]), rel=1e-3)
    k, m = row("mean tangent stiffness k at nominal torque"), row("reduced mass m on the pitch circle, both spinning")
    assert float(start["constantStiffness"]) == pytest.approx(k, rel=1e-3)
    assert float(start["damping"]) == pytest.approx(0.1 * math.sqrt(k * m), rel=5e-3)
    assert row("<code>effectiveMass</code> on the line of action") == pytest.approx(float(start["effectiveMass"]), rel=1e-3)
    assert "torque on gear 1" in text and "% rms" in text


@EVERY_PAIR
def test_constant_stiffness_starts_as_the_mean_tangent_at_nominal_torque(fmus, name):
    stiffness = []
    with GearPair(fmus[name], interface="model-exchange") as pair:
        pair.initialize()
        turning, ratio, pitch = Turning(pair), pair.geometry.ratio, math.tau / pair.geometry.teeth[0]
        for spin in pitch * np.arange(64) / 64:
            turning.resting(-pair.parameters["nominalTorque"] / ratio, spin, ratio * spin)
            stiffness.append(pair["mesh.stiffness"])
        assert pair.parameters["constantStiffness"] == pytest.approx(np.mean(stiffness), rel=5e-3)


@pytest.mark.parametrize("name", [*SHIPPED, "external"])
def test_the_example_input_turns_the_gears_under_nominal_torque(fmus, tmp_path, capsys, name):
    folder = extract(str(fmus[name]), str(tmp_path / "unit"))
    signals = read_csv(f"{folder}/documentation/example-input.csv")
    output = ["gear1.moment[3]", "mesh.transmissionError", "mesh.position"]
    result = simulate_fmu(str(folder), input=signals, output=output)
    assert "missing input" not in capsys.readouterr().out
    assert abs(result["gear1.moment[3]"][0]) < 1e-6
    steady = result[result["time"] > 2.6e-3]
    start = {v.name: v.start for v in read_model_description(str(folder)).modelVariables}
    assert -steady["gear1.moment[3]"] == pytest.approx(float(start["nominalTorque"]), rel=0.02)
    assert steady["mesh.transmissionError"].min() > 0.0
    assert (np.diff(steady["mesh.position"]) % 1.0).sum() == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize("pair, torque", [("fzg-c", 302.0), ("palermo2013", 100.0)])
def test_the_script_of_the_page_on_the_fmu_runs(tmp_path, pair, torque):
    """As a user would: own pair, own FMU, the lines of the page."""
    page = (ROOT / "docs" / "fmu.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.S)
    assert len(blocks) == 1
    assert 10 <= len(blocks[0].splitlines()) <= 20
    (tmp_path / "first.py").write_text(blocks[0])
    gearmesh.pack(TABLES / f"{pair}.json", tmp_path / "pair.fmu")
    run = subprocess.run([sys.executable, "first.py"], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "Warning" not in run.stdout + run.stderr
    mean, swing = map(float, re.findall(r"(-?\d+\.\d+) N m", run.stdout))
    assert mean == pytest.approx(torque, rel=0.02)
    assert 0.0 < swing < 0.02 * torque


def test_the_commands_of_the_units_page_run_with_what_the_package_brings(tmp_path):
    """The package brings fmpy, without the packages that plot for it."""
    fmu = gearmesh.pack(TABLES / "fzg-c.json", tmp_path / "UNIT.fmu")
    page = zipfile.ZipFile(fmu).read("documentation/index.html").decode()
    (commands,) = re.findall(r"<pre>(.*?)</pre>", page, re.S)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    subprocess.run(["sh", "-e", "-c", commands], cwd=tmp_path, env=os.environ | {"PATH": path}, check=True)
    outputs = (tmp_path / "outputs.csv").read_text().splitlines()
    column = outputs[0].replace('"', "").split(",").index("gear1.moment[3]")
    assert -float(outputs[-1].split(",")[column]) == pytest.approx(302.0, rel=0.02)


def test_start_values_set_when_packing_are_those_of_the_unit(tmp_path):
    settings = {"interpolation": "shepard", "phaseReference": "absolute", "damping": 500.0, "coupling": "sequential", "loadDependent": False}
    fmu = gearmesh.pack(TABLES / "helical-25-47.json", tmp_path / "unit.fmu", set=settings)
    assert re.search(r"start: damping +500 N\.s/m\n", gearmesh.inspect(fmu).text)
    with GearPair(fmu, interface="model-exchange") as pair:
        assert {name: pair.parameters[name] for name in settings} == settings
        # In the middle of the gaps: half the backlash to either flank, on the pitch circle of gear 2.
        pair.initialize()
        backlash, radius = pair.parameters["backlash"], pair.geometry.pitch_radii[1]
        angle = pair.u[pair.input["gear2.angles[3]"]]
        assert angle != 0.0 and backlash > 0.0
        for side, flank in ((0.45, 0), (-0.45, 0), (0.6, 1), (-0.6, -1)):
            pair["gear2.angles[3]"] = angle + side * backlash / radius
            pair.evaluate(0.0)
            assert pair.flank == flank, side
