"""The examples of other hosts, on a short form of their scenario; `python -m examples.hosts` runs the whole."""

import gearmesh
import numpy as np
import pytest
from conftest import ROOT, TABLES
from examples.hosts import mesh_stiffness
from examples.hosts.compare import HOSTS, run
from examples.hosts.scenario import revolution


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    fmu = gearmesh.pack(TABLES / "palermo2013.json", tmp_path_factory.mktemp("hosts") / "palermo2013.fmu", set={"coupling": "held"})
    return fmu, revolution(fmu, 100.0, revolutions=1 / 16, steps=64)


@pytest.mark.parametrize("host", HOSTS)
def test_every_host_finds_the_same_outputs(unit, host):
    try:
        results = run(host, *unit)
    except ImportError as error:
        pytest.skip(f"not installed here: {error}")
    assert results
    for result in results:
        assert result.difference < 1e-12, result


@pytest.fixture(scope="module")
def table():
    return mesh_stiffness.over_a_pitch(ROOT / "examples" / "drivelines" / "pairs" / "spur-50-50.json", 150.0)


def test_the_stiffness_over_a_pitch_closes(table):
    angle, stiffness = table
    assert angle[0] == 0.0 and angle[-1] == pytest.approx(2.0 * np.pi / 50) and (np.diff(angle) > 0.0).all()
    assert stiffness[0] == stiffness[-1] and stiffness.min() < 0.9 * stiffness.max()


def test_opentorsion_has_the_mesh_mode_of_the_closed_form(table):
    example = pytest.importorskip("examples.hosts.in_opentorsion")
    for k in table[1][[0, 20]] * example.BASE_RADIUS**2:
        shaft = example.SHAFT
        stiffness = np.array([[shaft, -shaft, 0.0], [-shaft, shaft + k, k], [0.0, k, k]])
        squares = np.linalg.eigvals(stiffness / np.array([[example.FLYWHEEL], *np.transpose([example.INERTIAS])])).real
        assert example.frequencies(k)[1:] == pytest.approx(np.sqrt(np.sort(squares)[1:]) / (2.0 * np.pi))


def test_ross_reads_the_stiffness_over_the_angle(table):
    rotors = pytest.importorskip("examples.hosts.in_ross").coupled(*table)
    angle, stiffness = table
    angles = np.linspace(0.0, 3.0 * angle[-1], 50)
    expected = np.interp(angles % angle[-1], angle, stiffness)
    assert [rotors.mesh.interpolate_stiffness(a) for a in angles[:-1]] == pytest.approx(expected[:-1])
    assert rotors.mesh.stiffness == pytest.approx(stiffness[:-1].mean())


def test_the_modelica_component_reads_the_table_that_is_written(table, tmp_path):
    mesh_stiffness.write_modelica(*table, tmp_path / "mesh.txt")
    version, head, *rows = (tmp_path / "mesh.txt").read_text().splitlines()
    assert version == "#1" and head == f"double stiffness({len(rows)},2)"
    assert np.array([row.split() for row in rows], dtype=float).tolist() == np.transpose(table).tolist()
    text = (ROOT / "examples" / "hosts" / "GearMesh.mo").read_text()
    assert 'tableName="stiffness"' in text and "columns={2}" in text
    tree = pytest.importorskip("pymoca.parser").parse(text)
    assert {"gear1", "gear2", "stiffness", "backlash"} < set(tree.classes["GearMesh"].symbols)
