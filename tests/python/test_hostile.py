"""Hosts that err: altered files, absurd values, many threads."""

import math
import shutil
from concurrent.futures import ThreadPoolExecutor

import pytest
from differences import evaluate, variables
from host import ERROR, OK, Unit

STEP = 1e-5


@pytest.fixture
def altered(table_fmus, tmp_path):
    """A copy of an FMU with tables whose resources a test may spoil."""
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


def one_digit_changed(data):
    at = next(i for i in range(len(data) // 2, len(data)) if data[i : i + 1].isdigit())
    return data[:at] + (b"1" if data[at : at + 1] != b"1" else b"2") + data[at + 1 :]


def test_tables_with_one_changed_digit_or_of_another_pair_are_refused(altered, table_units):
    unit, resources = altered
    file = resources / "tables.json"
    file.write_bytes(one_digit_changed(file.read_bytes()))
    assert "tables.json" in refusal(unit)
    shutil.copy(f"{table_units['ring2-cycle'].folder}/resources/tables.json", file)
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


@pytest.mark.parametrize("orientation, idle", [(1, "quaternion"), (2, "angles")])
def test_inputs_that_the_formulation_does_not_use_are_not_looked_at(table_mesh, orientation, idle):
    choices = {"orientationInput": orientation, "formulation": 2, "coupling": 3, "effectiveMass": 0.3}
    found = []
    for unused in ((), ("carrier.", idle)):
        instance = table_mesh("external-all")
        inputs, outputs = variables(instance)
        absurd = {n: -1e300 for n in inputs if any(part in n for part in unused)}
        instance.initialize(choices | absurd)
        instance.set({"gear1.angularVelocity[3]": 10.0})
        assert instance.step(0.0, STEP) == OK, instance.log()
        found.append(list(evaluate(instance, outputs)))
    assert found[0] == found[1]


def test_sixty_four_instances_on_eight_threads_give_what_each_gives_alone(table_units):
    unit = table_units["external-all"]

    def work(number):
        instance = unit.instance(name=f"mesh {number}")
        instance.initialize({"loadDependent": number % 2, "shuttlingEffect": number // 2 % 2})
        series = []
        for i in range(30):
            instance.set({"gear1.angles[3]": 2e-4 + 1e-5 * math.sin(i)})
            assert instance.step(i * STEP, STEP) == OK, instance.log()
            series.append(instance.vector("gear2.force") + instance.vector("gear2.moment"))
        instance.close()
        return series

    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(work, range(64)))
    alone = [work(number) for number in range(4)]
    assert together == 16 * alone and alone[0] != alone[1]
