"""The demo's driver and scenes through packed FMUs, against the paper and closed forms."""

import math

import gearmesh
import numpy as np
import pytest
from conftest import COARSE, PAIRS
from demo import comparison, scenes

PAIR = PAIRS / "palermo2013.json"


@pytest.fixture(scope="module")
def tabulated(tmp_path_factory):
    """The paper's pair on tables over load and mesh position, coarse finite elements for speed."""
    fmu = tmp_path_factory.mktemp("tables") / "pair with spaces ä.fmu"
    return gearmesh.build(PAIR, fmu, no_center_distance=True, no_misalignment=True, **COARSE)


@pytest.mark.parametrize("rpm", [200, 3000])
def test_frequency_response_is_that_of_the_papers_table_2(fmus, rpm):
    response = scenes.frequency_response(fmus["external"], 41.052e-3, np.array(scenes.PAPER_FREQUENCIES[rpm]))
    assert response.measured == pytest.approx(np.array(scenes.PAPER_GAINS[rpm]), abs=0.02)
    assert response.measured == pytest.approx(response.closed_form, abs=0.01)


def test_explicit_and_implicit_steps_agree_on_the_slow_cycle(tabulated):
    implicit = scenes.slow_cycles(tabulated, 100.0, load_dependent=False, cycles=1)
    explicit = scenes.steady_cycles(tabulated, scenes.SLOW_RPM, cycles=1)

    def by_position(record):
        one = scenes.cycles_of(record)[0] if len(scenes.cycles_of(record)) else slice(None)
        position, dte = record["mesh.position"][one], record["mesh.transmissionError"][one]
        order = np.argsort(position)
        return np.interp(np.linspace(0.05, 0.95, 50), position[order], dte[order])

    # 1 nm of some 10 um.
    assert by_position(implicit) == pytest.approx(by_position(explicit), abs=1e-9)


def test_slow_rotation_reproduces_the_static_solution(tabulated):
    cycle = gearmesh.solve(PAIR, 100.0, **COARSE)
    record = scenes.slow_cycles(tabulated, 100.0, cycles=2)
    assert record["mesh.normalForce"].mean() == pytest.approx(2660.4, abs=0.1)
    one = scenes.cycles_of(record)[0]
    delta = 1e6 * record["mesh.transmissionError"][one] * math.cos(0.3574830)
    found = np.interp(cycle.mesh_position[1:], record["mesh.position"][one], delta)
    # Half a percent of the mean, the default grid's error and the mesh damping together.
    assert found == pytest.approx(cycle.ste_loa_um[1:], abs=0.005 * cycle.mean_ste_loa_um)


def test_constant_load_scales_the_cycle_and_variable_load_changes_its_shape(tabulated):
    def relative_span(torque, load_dependent):
        record = scenes.slow_cycles(tabulated, torque, load_dependent, cycles=2)
        dte = record["mesh.transmissionError"][scenes.cycles_of(record)[0]]
        return np.ptp(dte) / dte.mean()

    constant = [relative_span(t, False) for t in (70.0, 130.0)]
    variable = [relative_span(t, True) for t in (70.0, 130.0)]
    assert constant[0] == pytest.approx(constant[1], rel=1e-2)
    assert abs(variable[0] / variable[1] - 1.0) > 0.2
    # At the nominal torque both are one.
    assert relative_span(100.0, False) == pytest.approx(relative_span(100.0, True), rel=0.02)


def test_verdicts_on_the_comparison_page_follow_from_the_numbers():
    assert comparison.verdict({"it holds": True, "this, too": True}) == comparison.SAME
    assert comparison.verdict({"it holds": True, "this fails": False}) == "Not so here: this fails."
    assert comparison.force_verdict({200: (1.0, 1.0), 3000: (0.998, 1.003)}).startswith(comparison.SAME)
    falling = comparison.force_verdict({200: (0.9, 1.0), 3000: (0.99, 1.001)})
    assert "Not so here" in falling and "further below" in falling
