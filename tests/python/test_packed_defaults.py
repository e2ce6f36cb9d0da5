"""What packing derives from a pair: damping and step that co-simulation masters survive, both flanks, a first run."""

import ctypes
import json
import math
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import GEARMESH, ROOT, SHIPPED, gearmesh
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.util import read_csv
from host import OK, Unit
from scipy.linalg import expm

STEEL = 7850.0


class Mesh:
    """A running unit with packed defaults, and its gears as solid steel discs."""

    def __init__(self, make, name, values=None):
        table = json.loads((ROOT / "resources" / "tables" / f"{name}.json").read_text())
        self.gears = [table["geometry"][g] for g in ("gear1", "gear2")]
        self.torque = table["nominal_torque_nm"]
        self.e = -1.0 if "ring" in (g["kind"] for g in self.gears) else 1.0
        self.ratio = self.gears[0]["teeth"] / self.gears[1]["teeth"]
        self.pitch_angle = 2 * math.pi / self.gears[0]["teeth"]
        distance = table["geometry"]["center_distance_m"]
        z1, z2 = (g["teeth"] for g in self.gears)
        self.radius = [z * distance / abs(z1 + self.e * z2) for z in (z1, z2)]
        self.instance = make(name)
        self.instance.initialize(values)
        self.error = []  # mesh.transmissionError at each step
        self.step = float(self.instance.unit.description.defaultExperiment.stepSize)
        self.names = [v.name for v in self.instance.unit.description.modelVariables if v.causality == "input"]
        self.u = (ctypes.c_double * len(self.names))()
        for i, name in enumerate(self.names):
            self.u[i] = self.instance.get(name)
        self.at = {name: i for i, name in enumerate(self.names)}
        outputs = ["gear1.moment[3]", "gear2.moment[3]", "mesh.tangentialForce"]
        outputs += [f"gear2.{q}[{i}]" for q in ("force", "moment") for i in (1, 2, 3)]
        outputs.append("mesh.transmissionError")
        self.y = (ctypes.c_double * len(outputs))()
        self.references = [self.instance.references(n) for n in (self.names, outputs)]
        self.time = 0.0

    def blank(self, gear):
        """Mass, moments of inertia about the axis and across it at mid-face."""
        g = self.gears[gear]
        reference = 0.5 * g["teeth"] * g["normal_module_m"] / math.cos(g["helix_angle_rad"])
        squares = reference**2 + g["held_radius_m"] ** 2
        mass = STEEL * math.pi * abs(reference**2 - g["held_radius_m"] ** 2) * g["face_width_m"]
        return mass, 0.5 * mass * squares, 0.25 * mass * squares + mass * g["face_width_m"] ** 2 / 12

    def advance(self, step):
        """One communication step with the inputs in `u`; the outputs are then in `y`."""
        inputs, outputs = self.references
        i = self.instance
        assert i.call("fmi2SetReal", inputs, ctypes.c_size_t(len(self.u)), self.u) == OK, i.log()
        assert i.step(self.time, step) == OK, i.log()
        self.time += step
        assert i.call("fmi2GetReal", outputs, ctypes.c_size_t(len(self.y)), self.y) == OK, i.log()
        self.error.append(self.y[9])


def coupling(parallel):
    return {"coupling": 3 if parallel else 2}


def spins(mesh, free, parallel, step, duration, torque, speed=0.0):
    """Tangential force over time while the gears in `free` spin under the mesh and the torque on gear 1 `torque(t)`
    (its reaction on gear 2), from rest against one another at `speed` of gear 1. A master that holds the loads and
    moves the bodies exactly; it hands them on one step late if it is `parallel`.
    """
    inertia = [mesh.blank(i)[1] for i in (0, 1)]
    angle, rate = [0.0, 0.0], [speed, -mesh.e * mesh.ratio * speed]
    share = [1.0, mesh.e / mesh.ratio]
    held = [0.0, 0.0]
    force = np.empty(round(duration / step))
    for n in range(len(force)):
        for i, gear in enumerate(("gear1", "gear2")):
            mesh.u[mesh.at[f"{gear}.angles[3]"]] = angle[i]
            mesh.u[mesh.at[f"{gear}.angularVelocity[3]"]] = rate[i]
        load = torque((n + 0.5) * step)
        if not parallel:
            mesh.advance(step)
            held = [mesh.y[0], mesh.y[1]]
        acting = [(held[i] + share[i] * load) / inertia[i] if i in free else 0.0 for i in (0, 1)]
        if parallel:
            mesh.advance(step)
            held = [mesh.y[0], mesh.y[1]]
        force[n] = mesh.y[2]
        if not force[n] < 1e9:
            return force[: n + 1]
        for i in (0, 1):
            angle[i] += step * rate[i] + 0.5 * step**2 * acting[i]
            rate[i] += step * acting[i]
    return force


def swing(force, mean):
    """Largest departure from `mean`, over it, in the first and in the last quarter of the time."""
    quarter = len(force) // 4
    deviation = np.abs(force / mean - 1.0)
    return deviation[:quarter].max(), deviation[-quarter:].max()


@pytest.mark.parametrize("parallel", [False, True], ids=["sequential", "parallel"])
@pytest.mark.parametrize("free", [(0,), (1,), (0, 1)], ids=["gear1", "gear2", "both"])
@pytest.mark.parametrize("name", SHIPPED)
def test_masters_survive_twice_the_packed_step(shipped, name, free, parallel):
    mesh = Mesh(shipped, name, coupling(parallel))
    # Nominal torque at once, so that the force starts by swinging to twice its mean; half a cycle a millisecond.
    force = spins(mesh, free, parallel, 2 * mesh.step, 0.03, lambda t: mesh.torque, 500 * mesh.pitch_angle)
    first, last = swing(force, mesh.torque / mesh.radius[0])
    assert first > 0.6
    assert last < 0.7 * first
    assert "set coupling" not in mesh.instance.log()


@pytest.mark.parametrize("parallel", [False, True], ids=["sequential", "parallel"])
@pytest.mark.parametrize("name", SHIPPED)
def test_the_packed_step_costs_less_than_a_percent(shipped, name, parallel):
    """A load over 2 ms, gear 1 at constant speed: the transmission error against a twentieth of the step."""

    def run(divisor):
        mesh = Mesh(shipped, name, coupling(False if divisor > 1 else parallel))
        load = lambda t: mesh.torque * min(t / 2e-3, 1.0)  # noqa: E731
        spins(mesh, (1,), divisor == 1 and parallel, mesh.step / divisor, 0.012, load, 750 * mesh.pitch_angle)
        return np.array(mesh.error[::divisor])

    reference, found = run(20), run(1)
    count = min(len(found), len(reference))
    error = np.sqrt(np.mean((found[:count] - reference[:count]) ** 2)) / reference.std()
    assert error < 0.007, error


@pytest.mark.parametrize("name", SHIPPED)
def test_a_sequential_master_that_keeps_the_default_is_damped_and_stable(shipped, name):
    mesh = Mesh(shipped, name)
    force = spins(mesh, (1,), False, mesh.step, 0.03, lambda t: mesh.torque, 500 * mesh.pitch_angle)
    first, last = swing(force, mesh.torque / mesh.radius[0])
    assert last < 0.3 * first
    assert "set coupling = sequential" in mesh.instance.log()


def test_held_loads_bear_twice_the_step_packed_for_them_and_not_four_times(tmp_path):
    fmu = tmp_path / "held.fmu"
    gearmesh("pack", "--tables", ROOT / "resources/tables/palermo2013.json", "--set", "coupling=held", "-o", fmu)
    unit = Unit(fmu)
    try:
        for parallel, factor in ((False, 2), (True, 2), (True, 4)):
            mesh = Mesh(lambda _: unit.instance(), "palermo2013")
            load = lambda t: mesh.torque  # noqa: E731
            force = spins(mesh, (1,), parallel, factor * mesh.step, 0.03, load, 500 * mesh.pitch_angle)
            if factor == 2:
                first, last = swing(force, mesh.torque / mesh.radius[0])
                assert last < 0.7 * first
            else:
                assert force.max() > 10 * mesh.torque / mesh.radius[0]
    finally:
        unit.close()


@pytest.mark.parametrize("parallel", [False, True], ids=["sequential", "parallel"])
@pytest.mark.parametrize("name", SHIPPED)
def test_a_gear_on_bearings_with_all_its_freedoms_survives_twice_the_packed_step(shipped, name, parallel):
    """Gear 2 spins freely and is held radially, axially and against tilting by bearings of damping ratio 0.02, which
    the master integrates exactly with the body."""
    mesh = Mesh(shipped, name, coupling(parallel))
    step = 2 * mesh.step
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
    state = np.zeros(12)
    half = np.array([0.0, 0.0, 0.5 * mesh.gears[1]["face_width_m"]])
    start = np.array([mesh.u[mesh.at[f"gear2.position[{i}]"]] for i in (1, 2, 3)])
    names = ("position", "angles", "velocity", "angularVelocity")
    place, angles, velocity, spin = (mesh.at[f"gear2.{n}[1]"] for n in names)
    outside = np.zeros(6)
    outside[5] = mesh.e / mesh.ratio * mesh.torque
    load = np.zeros(6)
    force = np.empty(round(0.03 / step))
    for n in range(len(force)):
        # Small tilts: the origin lies half a face below the centre.
        mesh.u[place : place + 3] = start + state[:3] - np.cross(state[3:6] * [1, 1, 0], half)
        mesh.u[angles : angles + 3] = state[3:6]
        mesh.u[velocity : velocity + 3] = state[6:9] - np.cross(state[9:12] * [1, 1, 0], half)
        mesh.u[spin : spin + 3] = state[9:12]
        acting = load
        mesh.advance(step)
        f, m = np.array(mesh.y[3:6]), np.array(mesh.y[6:9])
        load = np.concatenate([f, m - np.cross(half, f)])
        state = exact @ np.concatenate([state, (acting if parallel else load) + outside])
        force[n] = mesh.y[2]
        assert force[n] < 1e9
    first, last = swing(force, mesh.torque / mesh.radius[0])
    assert first > 0.7
    assert last < 0.5 * first


@pytest.mark.parametrize("parallel", [False, True], ids=["sequential", "parallel"])
@pytest.mark.parametrize("name", SHIPPED)
def test_a_reversed_torque_ends_on_the_coast_flank_without_a_jump(shipped, name, parallel):
    mesh = Mesh(shipped, name, coupling(parallel))
    begin, turn = 2e-3, 6e-3

    def torque(t):
        return mesh.torque * math.cos(math.pi * min(max(t - begin, 0.0) / turn, 1.0))

    force = spins(mesh, (1,), parallel, mesh.step / 16, 0.03, torque)
    nominal = mesh.torque / mesh.radius[0]
    assert mesh.instance.get("mesh.flank") == -1
    assert mesh.instance.get("mesh.outOfRange") == 0
    last = force[-len(force) // 5 :]
    assert last.mean() == pytest.approx(nominal, rel=0.02)
    # Teeth that meet do so within some steps: an impact is no wall.
    assert np.abs(np.diff(force)).max() < 0.08 * nominal
    assert force.max() < 4 * nominal


@pytest.mark.parametrize("name", SHIPPED)
def test_without_load_forces_stay_small(shipped, name):
    """The damper fades at light load, so that held loads rattle there; no more than that."""
    mesh = Mesh(shipped, name)
    force = spins(mesh, (1,), True, mesh.step, 0.03, lambda t: 0.01 * mesh.torque)
    assert force.max() < 0.1 * mesh.torque / mesh.radius[0]


@pytest.mark.parametrize("name", SHIPPED)
def test_the_description_and_the_page_name_pair_damping_and_step(shipped_fmus, name):
    description = read_model_description(str(shipped_fmus[name]))
    assert description.modelName == name
    assert description.coSimulation.modelIdentifier == "GearMesh"
    with zipfile.ZipFile(shipped_fmus[name]) as archive:
        text = archive.read("documentation/index.html").decode()
    start = {v.name: v.start for v in description.modelVariables}

    def row(label):
        found = re.search(rf"<td>{re.escape(label)}</td><td>([0-9.e+-]+)", text)
        return float(found.group(1))

    step = description.defaultExperiment.stepSize
    cost = re.search(r"<code>stepSize</code>: ([0-9.]+) % rms", text)
    assert 0 < float(cost.group(1)) < 0.7
    assert f"costs {float(cost.group(1)):.2f} % rms" in gearmesh("inspect", shipped_fmus[name])
    assert row("<code>stepSize</code>") == pytest.approx(float(step), rel=1e-3)
    assert row("<code>damping</code> c") == pytest.approx(float(start["damping"]), rel=1e-3)
    k, m = row("mean tangent stiffness k at nominal torque"), row("reduced mass m on the pitch circle, both spinning")
    assert float(start["constantStiffness"]) == pytest.approx(k, rel=1e-3)
    assert float(start["damping"]) == pytest.approx(0.1 * math.sqrt(k * m), rel=5e-3)
    assert row("<code>effectiveMass</code> on the line of action") == pytest.approx(float(start["effectiveMass"]), rel=1e-3)
    assert "torque on gear 1" in text and "% rms" in text


@pytest.mark.parametrize("name", SHIPPED)
def test_constant_stiffness_starts_as_the_mean_tangent_at_nominal_torque(shipped, name):
    mesh = Mesh(shipped, name)
    stiffness = []
    for i in range(64):
        spin = mesh.pitch_angle * i / 64
        low, high = 0.0, 0.2 * mesh.pitch_angle * mesh.ratio
        for _ in range(40):
            middle = 0.5 * (low + high)
            turn = mesh.e * (middle - mesh.ratio * spin)
            mesh.instance.set({"gear1.angles[3]": spin, "gear2.angles[3]": turn})
            if -mesh.instance.get("gear1.moment[3]") < mesh.torque:
                low = middle
            else:
                high = middle
        stiffness.append(mesh.instance.get("mesh.stiffness"))
    assert mesh.instance.get("constantStiffness") == pytest.approx(np.mean(stiffness), rel=5e-3)


@pytest.mark.parametrize("name", [*SHIPPED, "palermo2013 of constant stiffness"])
def test_the_example_input_turns_the_gears_under_nominal_torque(shipped_fmus, tmp_path, capsys, name):
    if name in SHIPPED:
        fmu = shipped_fmus[name]
    else:
        fmu = tmp_path / "constant.fmu"
        gearmesh("pack", "--pair", ROOT / "resources/pairs/palermo2013.json", "-o", fmu)
    folder = extract(str(fmu), str(tmp_path / "unit"))
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


@pytest.mark.parametrize("pair, torque, cosine", [("fzg-c", 302.0, 0.92428), ("palermo2013", 100.0, 0.93678)])
def test_the_script_of_the_page_on_the_fmu_runs(tmp_path, pair, torque, cosine):
    """As a user would: own pair, own FMU, the lines of the page."""
    page = (ROOT / "docs" / "fmu.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.S)
    assert len(blocks) == 1
    assert 10 <= len(blocks[0].splitlines()) <= 25
    (tmp_path / "first.py").write_text(blocks[0])
    gearmesh("pack", "--tables", ROOT / f"resources/tables/{pair}.json", "-o", tmp_path / "pair.fmu")
    run = subprocess.run([sys.executable, "first.py"], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "Warning" not in run.stdout + run.stderr
    found, *errors = map(float, re.findall(r"(-?\d+\.\d+) (?:N m|um)", run.stdout))
    assert found == pytest.approx(torque, rel=0.02)
    (mean, swing), (mean_loa, swing_loa) = errors[:2], errors[2:]
    assert mean > swing > 0.0
    # On the line of action, as `gearmesh solve` has it, smaller by the cosine of the operating pressure angle.
    assert (mean_loa, swing_loa) == pytest.approx((cosine * mean, cosine * swing), abs=0.01)


def test_the_commands_of_the_units_page_run_with_what_the_package_brings(tmp_path):
    """The package brings fmpy, without the packages that plot for it."""
    fmu = tmp_path / "UNIT.fmu"
    gearmesh("pack", "--tables", ROOT / "resources/tables/fzg-c.json", "-o", fmu)
    page = zipfile.ZipFile(fmu).read("documentation/index.html").decode()
    (commands,) = re.findall(r"<pre>(.*?)</pre>", page, re.S)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    subprocess.run(["sh", "-e", "-c", commands], cwd=tmp_path, env=os.environ | {"PATH": path}, check=True)
    outputs = (tmp_path / "outputs.csv").read_text().splitlines()
    column = outputs[0].replace('"', "").split(",").index("gear1.moment[3]")
    assert -float(outputs[-1].split(",")[column]) == pytest.approx(302.0, rel=0.02)


def test_start_values_set_when_packing_are_those_of_the_unit(tmp_path):
    fmu = tmp_path / "unit.fmu"
    settings = ["interpolation=shepard", "phaseReference=absolute", "damping=500", "coupling=sequential"]
    options = [x for s in settings for x in ("--set", s)]
    gearmesh("pack", "--tables", ROOT / "resources/tables/helical-25-47.json", "-o", fmu, *options)
    shown = gearmesh("inspect", fmu)
    for line in ("interpolation +shepard", "phaseReference +absolute", r"damping +500 N\.s/m", "loadedFlank +both"):
        assert re.search(rf"start: {line}\n", shown), line
    unit = Unit(fmu)
    try:
        values = {v.name: v.start for v in unit.description.modelVariables}
        assert (values["interpolation"], values["phaseReference"]) == ("3", "2")
        assert (values["damping"], values["coupling"]) == ("500.0", "2")
        instance = unit.instance()
        # In the middle of the gaps: half the backlash to either flank, on the pitch circle of gear 2.
        instance.initialize()
        backlash = instance.get("backlash")
        angle, radius = instance.get("gear2.angles[3]"), 0.098 * 47 / 72
        assert angle != 0.0 and backlash > 0.0
        for side, flank in ((0.45, 0), (-0.45, 0), (0.6, 1), (-0.6, -1)):
            instance.set({"gear2.angles[3]": angle + side * backlash / radius})
            assert instance.get("mesh.flank") == flank, side
        instance.close()
    finally:
        unit.close()


@pytest.mark.parametrize(
    "setting, reason",
    [
        ("damping", "name=value"),
        ("loadedFlank=left", "one of drive, coast, both"),
        ("stifness=3", "no parameter or input stifness"),
        ("damping=-1", "0 or above"),
        ("gear2.position[1]=0.05", "centre distance"),
    ],
)
def test_start_values_that_cannot_be_are_refused(tmp_path, setting, reason):
    fmu = tmp_path / "unit.fmu"
    pair = ROOT / "resources/pairs/palermo2013.json"
    command = [GEARMESH, "pack", "--pair", pair, "-o", fmu, "--set", setting]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert run.returncode != 0
    assert reason in run.stderr, run.stderr
    assert not fmu.exists()
