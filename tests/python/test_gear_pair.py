"""The Python package: both interfaces against one another and against fmpy, and its refusals."""

import shutil
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import PAIRS, gearmesh
from gearmesh import GearPair, GearPairError

OUTPUTS = ["gear1.moment[3]", "gear2.force[1]", "contact.point[3]", "mesh.transmissionError"]
MISALIGNED = {"gear2.angles[2]": 1e-4, "gear2.position[1]": 0.08206, "gear2.angles[3]": 1e-3}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """The paper's pair with constant stiffness, whose name no folder likes."""
    file = tmp_path_factory.mktemp("pair") / "pair with spaces ä.fmu"
    gearmesh("pack", "--pair", PAIRS / "palermo2013.json", "-o", file)
    return file


def turned(pair):
    """The pair after initialisation, gear 2 moved onto the flank."""
    pair.initialize()
    for name, value in MISALIGNED.items():
        pair[name] = value
    return pair


def test_steps_and_evaluations_give_the_same_outputs(fmu):
    with GearPair(fmu) as stepped, GearPair(fmu, interface="model-exchange") as evaluated:
        turned(stepped).step(1e-6)
        turned(evaluated).evaluate(1e-6)
        assert abs(stepped["gear2.moment[3]"]) > 10.0
        assert list(stepped.y) == list(evaluated.y)
        assert (stepped.flank, stepped.out_of_range) == (evaluated.flank, evaluated.out_of_range)
        # In any order: a solver comes back to earlier times with other inputs.
        there = list(evaluated.y)
        evaluated["gear2.angles[3]"] = 0.0
        evaluated.evaluate(5e-7)
        assert list(evaluated.y) != there
        evaluated["gear2.angles[3]"] = MISALIGNED["gear2.angles[3]"]
        evaluated.evaluate(1e-6)
        assert list(evaluated.y) == there


def test_outputs_are_those_that_fmpy_finds(fmu):
    step, count = 2.0**-20, 50  # exact in binary, so that both are at the same times
    columns = ["gear1.angles[3]", "gear2.angles[3]", "gear2.angles[1]"]
    signals = np.zeros(count + 1, dtype=[("time", float)] + [(name, float) for name in columns])
    signals["time"] = step * np.arange(count + 1)
    signals["gear1.angles[3]"] = 20.0 * signals["time"]
    signals["gear2.angles[3]"] = -10.0 * signals["time"]
    signals["gear2.angles[1]"] = signals["time"]
    expected = fmpy.simulate_fmu(
        str(fmu), stop_time=step * count, output_interval=step, input=signals, output=OUTPUTS
    )
    assert np.ptp(expected["gear1.moment[3]"]) > 10.0
    with GearPair(fmu) as pair:
        pair.initialize()
        for row in range(count):
            for name in columns:
                pair[name] = signals[name][row]
            pair.step(step)
            assert [pair[name] for name in OUTPUTS] == list(expected[row + 1])[1:], row


def test_derivatives_are_those_of_the_outputs(fmu):
    outputs, inputs = ["gear1.moment[3]", "gear2.force[2]"], ["gear1.angles[3]", "gear2.position[1]"]
    with GearPair(fmu, interface="model-exchange") as pair:
        turned(pair).evaluate(0.0)
        exact = np.array(pair.derivatives(outputs, inputs))
        found = np.empty_like(exact)
        for column, name in enumerate(inputs):
            at = pair.u[pair.input[name]]
            ends = []
            for side in (1e-9, -1e-9):
                pair[name] = at + side
                pair.evaluate(0.0)
                ends.append([pair[o] for o in outputs])
            pair[name] = at
            found[:, column] = (np.array(ends[0]) - ends[1]) / 2e-9
    assert found == pytest.approx(exact, rel=1e-4, abs=1e-6 * abs(exact).max())


def test_an_enumeration_that_does_not_exist_is_refused_with_those_that_do(fmu):
    with pytest.raises(GearPairError, match="paper, conjugate"):
        GearPair(fmu, {"formulation": "exact"})


def test_what_the_unit_logs_is_in_the_exception(fmu):
    with GearPair(fmu, {"stiffnessModel": "table"}) as pair:
        with pytest.raises(GearPairError, match="stiffnessModel"):
            pair.initialize()
    with GearPair(fmu) as pair:
        pair.initialize()
        pair["gear1.position[1]"] = float("nan")
        with pytest.raises(GearPairError, match=r"gear1\.position\[1\]"):
            pair.step(1e-6)


def test_a_variable_that_does_not_exist_is_refused_by_name(fmu):
    with pytest.raises(GearPairError, match="'dampnig'"):
        GearPair(fmu, {"dampnig": 1.0})


def test_instances_of_one_archive_share_its_files_until_the_last_one_closes(fmu):
    first, second = GearPair(fmu), GearPair(fmu, interface="model-exchange")
    folder = Path(first._unpacked.folder)
    assert Path(second._unpacked.folder) == folder
    first.close()
    assert folder.is_dir()
    turned(second).evaluate(0.0)
    second.close()
    assert not folder.exists()


def test_an_archive_written_anew_is_another_one(fmu, tmp_path):
    file = shutil.copy2(fmu, tmp_path / "pair.fmu")
    with GearPair(file) as old:
        gearmesh("pack", "--pair", PAIRS / "fzg-c.json", "-o", file)
        with GearPair(file) as new:
            assert new._description.guid != old._description.guid
