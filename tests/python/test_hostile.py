"""Hosts that err: altered files, absurd values, far places, many threads."""

import math
import shutil
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from differences import evaluate, variables
from host import DISCARD, ERROR, OK, Unit
from test_mechanics import CONSTANT, Geometry

STEP = 1e-5


@pytest.fixture
def altered(table_fmus, tmp_path):
    """A copy of a unit with tables whose resources a test may spoil."""
    unit = Unit(table_fmus["external-cycle"], tmp_path / "unit")
    yield unit, tmp_path / "unit" / "resources"
    shutil.rmtree(tmp_path / "unit", ignore_errors=True)


def refusal(unit, **options):
    """What the log says when no instance could be made."""
    instance = unit.instance(**options)
    try:
        assert not instance.component
        return instance.log()
    finally:
        instance.close()


@pytest.mark.parametrize("file", ["unit.json", "tables.json"])
@pytest.mark.parametrize("keep", [0, 1, 50, 0.5, -1])
def test_a_truncated_file_is_refused_by_name(altered, file, keep):
    unit, resources = altered
    data = (resources / file).read_bytes()
    length = int(keep * len(data)) if isinstance(keep, float) else keep
    (resources / file).write_bytes(data.rstrip()[:length])
    assert file in refusal(unit)


@pytest.mark.parametrize("file", ["unit.json", "tables.json"])
def test_spoilt_bytes_are_refused_by_name(altered, file):
    unit, resources = altered
    data = (resources / file).read_bytes()
    for bad in (b"\x00" * 1000, b"\xff" + data, data.replace(b"[", b"{"), b"[" * 100_000):
        (resources / file).write_bytes(bad)
        assert file in refusal(unit)


def test_one_changed_digit_of_the_tables_is_noticed(altered):
    unit, resources = altered
    text = (resources / "tables.json").read_text()
    at = text.index("0.0", len(text) // 2) if "0.0" in text[len(text) // 2 :] else len(text) // 2
    while not text[at].isdigit():
        at += 1
    changed = text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1 :]
    (resources / "tables.json").write_text(changed)
    assert "tables.json" in refusal(unit)


def test_missing_resources_are_refused_and_missing_tables_when_they_are_asked_for(altered):
    unit, resources = altered
    (resources / "tables.json").unlink()
    instance = unit.instance()
    if instance.component:
        instance.expect("fmi2EnterInitializationMode")
        assert instance.call("fmi2ExitInitializationMode") == ERROR
    assert "table" in instance.log()
    instance.close()
    (resources / "unit.json").unlink()
    assert "unit.json" in refusal(unit)
    shutil.rmtree(resources)
    assert "resources" in refusal(unit)


def test_tables_of_another_pair_are_refused(altered, table_units):
    unit, resources = altered
    other = f"{table_units['ring2-cycle'].folder}/resources/tables.json"
    shutil.copy(other, resources / "tables.json")
    assert "tables.json" in refusal(unit)


def test_format_characters_in_a_name_are_text(mesh):
    name = "%n%s%n%x #r1# \t"
    instance = mesh(name=name)
    assert instance.status_of_setting({"damping": -1.0}) == ERROR
    assert instance.messages[0][0] == name
    assert instance.messages[0][3] == "%s"


@pytest.mark.parametrize("formulation", [1, 2], ids=["paper", "conjugate"])
@pytest.mark.parametrize("pair", ["external", "ring2", "ring1"])
def test_a_thousand_kilometres_away_the_wrench_is_right_to_rounding(mesh, pair, formulation):
    forces = []
    # A power of two: adding it and taking it away again leaves the coordinates on a grid.
    far = 2.0**20
    grid = np.spacing(far)
    for shift in (0.0, far):
        instance = mesh(pair)
        g = Geometry(instance.unit)
        c = round(g.c / grid) * grid
        places = {f"{b}.position[{k}]": shift for b in ("gear1", "gear2", "carrier") for k in (1, 2, 3)}
        places["gear2.position[1]"] = shift + c
        places["gear2.position[3]"] = shift + round(instance_start(instance, "gear2.position[3]") / grid) * grid
        instance.initialize({**CONSTANT, **places, "formulation": formulation})
        instance.set({"gear1.angles[3]": 2e-5 / g.rw[0]})
        assert instance.step(0.0, STEP) == OK, instance.log()
        forces.append(instance.vector("gear2.force") + instance.vector("gear2.moment"))
    size = np.linalg.norm(forces[0][:3])
    assert size > 1000.0
    # The same differences of coordinates: only the world they are told in differs.
    assert forces[1] == pytest.approx(forces[0], rel=1e-12, abs=1e-12 * size)


def instance_start(instance, name):
    return float(instance.unit.variables[name].start)


@pytest.mark.parametrize("pair", ["external", "ring2"])
def test_after_ten_million_revolutions_the_wrench_is_right_to_rounding(mesh, pair):
    instance = mesh(pair)
    g = Geometry(instance.unit)
    instance.initialize(CONSTANT)
    slip = 2e-5 / g.rw[0]
    turns = 2 * math.pi * g.z[1] * 1e7 / g.z[1]
    spins = g.rolled(turns, slip)
    instance.set({"gear1.angles[3]": spins[0], "gear2.angles[3]": spins[1]})
    assert instance.step(0.0, STEP) == OK
    rounding = sum(np.spacing(abs(s)) * r for s, r in zip(spins, g.rw))
    k = instance.get("mesh.stiffness")
    assert abs(instance.get("mesh.tangentialForce") - k * 2e-5) <= 2 * k * rounding


def test_inputs_that_the_formulation_does_not_use_are_not_looked_at(table_mesh):
    instance = table_mesh("external-all")
    inputs, outputs = variables(instance)
    unused = {n: 1e300 for n in inputs if n.startswith("carrier.")}
    for orientation in (1, 2):
        instance.expect("fmi2Reset")
        choices = {"orientationInput": orientation, "formulation": 2, "coupling": 3, "effectiveMass": 0.3}
        instance.initialize(choices)
        instance.set({"gear1.angularVelocity[3]": 10.0})
        assert instance.step(0.0, STEP) == OK, instance.log()
        before = evaluate(instance, outputs)
        instance.expect("fmi2Reset")
        idle = "angles" if orientation == 2 else "quaternion"
        unused |= {n: -1e300 for n in inputs if idle in n}
        instance.initialize({**choices, **unused})
        instance.set({"gear1.angularVelocity[3]": 10.0})
        assert instance.step(0.0, STEP) == OK, instance.log()
        assert list(evaluate(instance, outputs)) == list(before)
        unused = {n: v for n, v in unused.items() if n.startswith("carrier.")}


@pytest.mark.parametrize("formulation", [1, 2], ids=["paper", "conjugate"])
@pytest.mark.parametrize("pair", ["external-all", "ring2-all"])
def test_poses_that_are_no_mesh_are_refused_or_empty(table_mesh, pair, formulation):
    c = Geometry(table_mesh(pair).unit).c
    for said, pose in (
        ("tilted", {"gear2.angles[1]": math.pi / 2}),
        ("tilted", {"gear1.angles[2]": math.pi / 2}),
        ("tilted", {"gear2.angles[1]": math.pi}),
        ("centre distance", {"gear2.position[1]": 0.0}),
    ):
        instance = table_mesh(pair).initialize({"formulation": formulation})
        instance.set(pose)
        status = instance.step(0.0, STEP)
        if status == OK:
            assert instance.vector("gear1.force") == [0.0, 0.0, 0.0], pose
        else:
            assert status == DISCARD and said in instance.log(), pose


@pytest.mark.parametrize("pair", ["external-all", "ring2-all"])
def test_gears_so_near_that_both_flanks_press_are_pushed_apart(table_mesh, pair):
    """In the conjugate formulation; the paper's looks at rotations alone."""
    instance = table_mesh(pair)
    g = Geometry(instance.unit)
    e, c = g.e, g.c
    instance.initialize({"formulation": 2, "loadedFlank": 3, "damping": 0.0})
    instance.set({"gear2.position[1]": c - e * 2.5e-4})
    assert instance.step(0.0, STEP) == OK, instance.log()
    force = instance.vector("gear2.force")
    assert np.all(np.isfinite(force)) and e * force[0] > 1000.0


def test_sixty_four_instances_on_eight_threads_give_what_each_gives_alone(table_units):
    unit = table_units["external-all"]
    results, errors = {}, []

    def work(number):
        try:
            instance = unit.instance(name=f"mesh {number}")
            instance.initialize({"loadDependent": number % 2, "shuttlingEffect": number // 2 % 2})
            series = []
            for i in range(30):
                instance.set({"gear1.angles[3]": 2e-4 + 1e-5 * math.sin(i)})
                assert instance.step(i * STEP, STEP) == OK, instance.log()
                series.append(instance.vector("gear2.force") + instance.vector("gear2.moment"))
            results[number] = series
            instance.close()
        except BaseException as error:
            errors.append(error)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(work, range(64)))
    assert not errors
    assert len(results) == 64
    together = dict(results)
    for number in range(4):
        work(number)
    for number, series in together.items():
        assert series == results[number % 4]
    assert results[0] != results[1]
