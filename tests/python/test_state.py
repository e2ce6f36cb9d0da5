"""Reset, kept states, and states carried into another process."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from conftest import COUPLINGS
from host import ERROR, OK, Unit

STEP = 1e-5


def run(instance, steps, first=0):
    """Gear 1 turns on with a torque ripple; all continuous outputs after each step."""
    out = []
    for i in range(first, first + steps):
        phase = 0.3 * i
        instance.set({"gear1.angles[3]": 1e-4 + 3e-5 * np.sin(phase), "gear1.velocity[1]": 1e-3 * i})
        instance.set({"gear1.angularVelocity[3]": 0.3 * 3e-5 / STEP * np.cos(phase)})
        assert instance.step(i * STEP, STEP) == OK, instance.log()
        out.append(instance.vector("gear2.force") + instance.vector("gear1.moment"))
    return out


def test_a_second_run_after_reset_is_the_first_one_to_the_last_bit(mesh):
    instance = mesh().initialize({"gear1.angles[3]": 0.01, "damping": 5e3}, start=0.0)
    first = run(instance, 50)
    instance.expect("fmi2Reset")
    # Nothing of the first run is left: parameters and inputs are at their start values.
    instance.initialize()
    assert instance.get("damping") == float(instance.unit.variables["damping"].start)
    assert instance.get("gear1.angles[3]") == 0.0
    assert instance.get("mesh.transmissionError") == pytest.approx(0.0, abs=1e-15)
    instance.expect("fmi2Reset")
    instance.initialize({"gear1.angles[3]": 0.01, "damping": 5e3})
    assert run(instance, 50) == first


def test_the_first_sample_belongs_to_the_initial_inputs(mesh):
    # Absolute phases, so that the initial pose is loaded: the first sample is not zero.
    instance = mesh().initialize({"gear1.angles[3]": 0.0})
    held = instance.get("mesh.transmissionError")
    assert held == pytest.approx(0.0, abs=1e-15)
    instance.set({"gear1.angles[3]": 1e-4})
    force = instance.vector("gear2.force")
    assert instance.step(0.0, STEP) == OK
    assert instance.vector("gear2.force") == force
    assert force[1] > 1000.0


@COUPLINGS
def test_a_restored_state_repeats_what_followed_it(mesh, coupling):
    instance = mesh().initialize({"gear1.angles[3]": 0.01, "coupling": coupling})
    run(instance, 10)
    state = instance.store()
    given = instance.vector("gear2.force")
    held = mesh().initialize({"gear1.angles[3]": 0.01, "coupling": 1})
    if coupling in (1, 3):  # automatic takes so fast a ripple for one that follows the loads, sequential holds the loads under it
        assert (run(held, 10)[-1][:3] == given) == (coupling == 1)
    after = run(instance, 20, first=10)
    assert instance.restore(state) == OK
    assert instance.vector("gear2.force") == given
    assert run(instance, 20, first=10) == after
    # The same memory again, now at the end; then back in time is forward again.
    assert instance.store(state) == state
    end = instance.vector("gear2.force")
    run(instance, 5, first=30)
    assert instance.restore(state) == OK
    assert instance.vector("gear2.force") == end


@pytest.mark.slow
def test_what_follows_a_state_at_contact_is_the_same_each_time_it_is_restored(mesh):
    instance = mesh("external-cycle").initialize({"stiffnessModel": 3})
    run(instance, 3)
    state = instance.store()
    first = run(instance, 3, first=3)
    again = []
    for further in (0, 2):
        run(instance, further, first=6)
        assert instance.restore(state) == OK
        again.append(run(instance, 3, first=3))
    # A restored solve starts from nothing, which the tolerance of the solver shows.
    assert again[0] == again[1]
    assert np.array(again[0]) == pytest.approx(np.array(first), rel=1e-6, abs=1e-6)


def test_a_state_leads_out_of_an_error(mesh):
    instance = mesh().initialize()
    state = instance.store()
    assert instance.step(5.0, STEP) == ERROR
    assert instance.step(0.0, STEP) == ERROR
    assert instance.restore(state) == OK
    assert instance.step(0.0, STEP) == OK


def continued(fmu, data):
    """What follows the state `data` of an instance of `fmu` here."""
    unit = Unit(fmu)
    instance = unit.instance()
    status, state = instance.deserialize(data)
    assert (status, instance.restore(state)) == (OK, OK), instance.log()
    after = run(instance, 20, first=10)
    instance.close()
    unit.close()
    return after


@pytest.mark.slow
@pytest.mark.parametrize("pair", ["external-all", "ring2-all"])
def test_a_state_on_tables_goes_on_in_another_process(mesh, fmus, pair):
    instance = mesh(pair).initialize({"meshPhase": 0.02, "loadDependent": 0})
    run(instance, 10)
    data = instance.serialize(instance.store())
    with ProcessPoolExecutor(1, get_context("spawn")) as elsewhere:
        assert elsewhere.submit(continued, fmus[pair], data).result() == run(instance, 20, first=10)
