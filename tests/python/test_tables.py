"""Units with tables: the element against the solver the tables came from, and against itself."""

import itertools
import math

import gearmesh
import numpy as np
import pytest
from conftest import FORMULATIONS, QUICK, pair_files
from differences import check_derivatives, values_of, variables
from test_mechanics import Geometry
from test_state import goes_on_elsewhere

INTERPOLATIONS = LINEAR, SPLINE, SHEPARD = 1, 2, 3
EVERY_INTERPOLATION = pytest.mark.parametrize("interpolation", INTERPOLATIONS, ids=["linear", "spline", "shepard"])
FULL = ["external-all", "ring2-all"]
CYCLE = ["external-cycle", "ring2-cycle"]
TORQUE = 100.0
# A pair without backlash jams between both flanks as soon as a tilt or a shorter centre distance takes up the relief.
ONE_FLANK = {"loadedFlank": 1}


def press(instance, tangential, sign=1):
    """Turns gear 1 until the elongation along the pitch circle is `tangential`."""
    radius = Geometry(instance.unit).rw[0]
    for _ in range(4):
        missing = sign * tangential - instance.get("mesh.transmissionError")
        instance.set({"gear1.angles[3]": instance.get("gear1.angles[3]") + missing / radius})
    return instance


def under_torque(make, pair, position, torque=TORQUE, sign=1, **parameters):
    """An instance at this mesh position with this torque on gear 1, found by secants."""
    correction = 0.0
    # Pressing the teeth moves the mesh position by the slip: again from a corrected start.
    for _ in range(3):
        instance = make(pair)
        g = Geometry(instance.unit)
        pitch = 2 * math.pi / g.z[0]
        phase = (position + correction) * pitch
        start = {"damping": 0.0, "loadedFlank": 1 if sign > 0 else 2, "meshPhase": phase}
        instance.initialize({**start, **parameters})

        def missing(angle):
            instance.set({"gear1.angles[3]": angle})
            return abs(instance.get("gear1.moment[3]")) - torque

        a, b = sign * 5e-6 / g.rw[0], sign * 3e-5 / g.rw[0]
        at_a, at_b = missing(a), missing(b)
        for _ in range(40):
            if abs(at_b) < 1e-9 * torque or at_a == at_b:
                break
            a, b, at_a = b, b - at_b * (b - a) / (at_b - at_a), at_b
            at_b = missing(b)
        assert abs(at_b) < 1e-7 * torque
        correction += (position - instance.get("mesh.position") + 0.5) % 1.0 - 0.5
    return instance


@pytest.fixture(scope="module")
def solved():
    """Mesh cycles at nominal torque by pair and flank, with the compliance of the tables."""
    return {
        (name, flank): gearmesh.solve(pair_files()[name], TORQUE, positions=8, flank=flank, **QUICK)
        for name, flank in itertools.product(("external", "ring2"), ("drive", "coast"))
    }


@FORMULATIONS
@pytest.mark.parametrize("flank", ["drive", "coast"])
@pytest.mark.parametrize("pair", CYCLE)
def test_the_unit_carries_the_nominal_torque_at_the_static_transmission_error(
    table_mesh, solved, pair, flank, formulation
):
    static = solved[pair.removesuffix("-cycle"), flank]
    sign = 1 if flank == "drive" else -1
    for i, position in enumerate(static.mesh_position):
        instance = under_torque(
            table_mesh, pair, position, sign=sign, formulation=formulation, shuttlingEffect=1
        )
        g = Geometry(instance.unit)
        away = instance.get("mesh.position") - position
        assert away - round(away) == pytest.approx(0.0, abs=1e-8)
        found = sign * instance.get("mesh.transmissionError") * math.cos(g.phi) * 1e6
        # The tables' error is 0.4 % of the force at most.
        assert found == pytest.approx(static.ste_loa_um[i], rel=4e-3)
        z = 1e3 * instance.get("mesh.contactZ")
        assert z == pytest.approx(static.contact_z_mm[i], abs=0.05)


def scan(instance, name, values, force):
    """Elongations and flags while the input `name` goes through `values` under a constant force."""
    radius = Geometry(instance.unit).rw[0]
    elongations, flags = [], []
    for value in values:
        instance.set({name: value})
        # The paper's transmission error is that of the z = 0 face: misaligned, the teeth touch elsewhere.
        for elongation in itertools.count(1e-5, 1e-5):
            press(instance, elongation)
            if instance.get("mesh.tangentialForce") > 0.0:
                break
        # Newton's iteration between an angle with too little force and one with too much: Shepard's force bends both ways.
        low, high = -math.inf, math.inf
        for _ in range(80):
            angle, excess, stiffness = instance.get("gear1.angles[3]", "mesh.tangentialForce", "mesh.stiffness")
            excess -= force
            low, high = (low, angle) if excess > 0.0 else (angle, high)
            step = -excess / stiffness / radius if stiffness > 0.0 else math.inf
            if not low < angle + step < high:
                step = 0.5 * (low + high) - angle if math.isfinite(high - low) else math.copysign(1e-5 / radius, -excess)
            instance.set({"gear1.angles[3]": angle + step})
            if abs(step * radius) < 1e-14:
                break
        assert instance.get("mesh.tangentialForce") == pytest.approx(force, rel=1e-6)
        elongations.append(instance.get("mesh.transmissionError"))
        flags.append(instance.get("mesh.outOfRange"))
    return np.array(elongations), np.array(flags)


@FORMULATIONS
@EVERY_INTERPOLATION
@pytest.mark.parametrize("pair", FULL)
def test_beyond_top_load_a_flag_is_raised_and_the_force_goes_on_smoothly(
    table_mesh, pair, interpolation, formulation
):
    choices = {"formulation": formulation, "interpolation": interpolation}
    instance = table_mesh(pair).initialize({**ONE_FLANK, "damping": 0.0, **choices})
    points = []
    for elongation in np.linspace(0.0, 6e-5, 201):
        press(instance, elongation)
        points.append(instance.get("mesh.tangentialForce", "mesh.outOfRange"))
    forces, flags = np.array(points).T
    first = np.flatnonzero(flags)[0]
    assert 10 < first < 190 and np.all(flags[first:] == 1)
    # A jump or a kink bends the curve more at the border than it bends anywhere within the range.
    bend = np.abs(np.diff(forces, 2))
    assert bend[first - 3 : first + 3].max() <= 1.5 * bend[2 : first - 3].max()


@FORMULATIONS
@EVERY_INTERPOLATION
@pytest.mark.parametrize("pair", FULL)
@pytest.mark.parametrize("end", [-1, 1], ids=["lower", "upper"])
@pytest.mark.parametrize("axis", ["centre distance", "misalignment"])
def test_beyond_the_range_of_an_axis_a_flag_is_raised_and_nothing_jumps(
    table_mesh, pair, axis, end, interpolation, formulation
):
    choices = {"formulation": formulation, "interpolation": interpolation}
    instance = table_mesh(pair).initialize({**ONE_FLANK, "damping": 0.0, **choices})
    c = instance.get("gear2.position[1]")
    name, start, far = {
        "centre distance": ("gear2.position[1]", c, c + end * 2e-4),
        "misalignment": ("gear2.angles[1]", 0.0, end * 5e-3),
    }[axis]
    values = np.linspace(start, far, 101)
    elongations, flags = scan(instance, name, values, 1500.0)
    first = np.flatnonzero(flags)[0]
    assert 5 < first < 95 and np.all(flags[first:] == 1)
    assert np.all(np.isfinite(elongations))
    # The slope within one step of the border, and as close to it as doubles allow to resolve.
    slope = np.abs(np.diff(elongations)).max() / abs(values[1] - values[0])
    low, high = values[first - 1], values[first]
    for _ in range(25):
        middle = 0.5 * (low + high)
        _, (flag,) = scan(instance, name, [middle], 1500.0)
        low, high = (low, middle) if flag else (middle, high)
    (inside, outside), _ = scan(instance, name, [low, high], 1500.0)
    assert abs(outside - inside) <= slope * abs(high - low) + 1e-13


TABLES = {"loadDependent": 1, "interpolation": SPLINE}


@FORMULATIONS
@pytest.mark.parametrize(
    "pairs, choice, step",
    [
        (FULL, TABLES, 2e-7),
        (FULL, TABLES | {"loadDependent": 0}, 2e-7),
        (FULL, TABLES | {"interpolation": LINEAR}, 2e-7),
        # Short of the nodes of sliding and stress near the pose.
        (CYCLE, {"friction": 1, "frictionTransitionSpeed": 0.1, "rootStress": 1}, 1e-7),
    ],
    ids=["spline", "constant-load", "linear", "friction and root stress"],
)
def test_directional_derivatives_of_tables_are_those_of_differences(table_mesh, pairs, choice, step, formulation):
    for pair in pairs:
        rng = np.random.default_rng(7 if pairs == FULL else 9)
        instance = table_mesh(pair)
        inputs, outputs = variables(instance)
        # Its derivative is a third derivative of the potential, piecewise constant for a cubic spline and
        # formed by differences inside the unit.
        outputs.remove("mesh.stiffness")
        instance.initialize({"damping": 1e3, "formulation": formulation, "meshPhase": 0.03, **choice})
        press(instance, 1.5e-5)
        values = values_of(instance, inputs)
        for n in inputs:
            values[n] += rng.uniform(-1, 1) * (1e-2 if "elocity" in n else 2e-6)
        values |= {"gear2.angles[1]": values["gear2.angles[1]"] + 3e-4} if pairs == FULL else {"gear1.angularVelocity[3]": 20.0}
        check_derivatives(instance, values, outputs, rng, step)


def test_interpolations_differ_by_the_error_of_the_table_alone(table_mesh):
    forces = []
    for interpolation in INTERPOLATIONS:
        instance = under_torque(table_mesh, "external-cycle", 0.21, interpolation=SPLINE)
        angle = instance.get("gear1.angles[3]")
        phase = instance.get("meshPhase")
        instance.expect("fmi2Reset")
        instance.initialize({"interpolation": interpolation, "meshPhase": phase, "damping": 0.0})
        instance.set({"gear1.angles[3]": angle})
        forces.append(instance.get("mesh.tangentialForce"))
    assert len(set(forces)) == len(INTERPOLATIONS)
    assert forces == pytest.approx([forces[1]] * len(forces), rel=0.02)


@pytest.mark.parametrize("pair", FULL)
def test_a_state_on_tables_goes_on_in_another_process(table_mesh, table_fmus, tmp_path, pair):
    instance = table_mesh(pair).initialize({"meshPhase": 0.02, "loadDependent": 0})
    goes_on_elsewhere(instance, table_fmus[pair], tmp_path)
