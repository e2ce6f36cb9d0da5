"""Loads predicted over steps, rates and derivatives of the outputs, both orientation inputs, both interfaces."""

import ctypes
import math

import numpy as np
import pytest
from conftest import EXTERNAL_AND_INTERNAL, FORMULATIONS
from differences import by_differences, columns_by_kind, directional, jacobian, variables
from host import DISCARD, MODEL_EXCHANGE, OK, EventInfo


@EXTERNAL_AND_INTERNAL
@pytest.mark.parametrize("orientation", [1, 2], ids=["angles", "quaternion"])
def test_without_a_mass_loads_are_the_mean_along_the_velocities(mesh, pair, orientation):
    """Linear stiffness: the mean over a step is the load in its middle, in the step after it for `parallel`."""
    step, speed = 1e-6, 30.0

    def start(coupling):
        instance = mesh(pair)
        choices = {"coupling": coupling, "effectiveMass": 0.0, "orientationInput": orientation, "damping": 0.0}
        instance.initialize(choices)
        # Pressed by some microns, and on its way about every axis and along.
        turn(instance, 2e-4)
        spins = {"gear1.angularVelocity[3]": speed, "gear2.velocity[1]": 1e-2, "gear2.angularVelocity[2]": 1.0}
        instance.set(spins)
        return instance

    def turn(instance, angle, time=0.0):
        tilt = time * 1.0
        instance.set({"gear1.angles[3]": angle, "gear2.angles[2]": tilt})
        instance.set({"gear1.quaternion[1]": math.cos(angle / 2), "gear1.quaternion[4]": math.sin(angle / 2)})
        instance.set({"gear2.quaternion[1]": math.cos(tilt / 2), "gear2.quaternion[3]": math.sin(tilt / 2)})
        place = "gear2.position[1]"
        instance.set({place: float(instance.unit.variables[place].start) + 1e-2 * time})

    for coupling, middle in ((2, 0.5), (3, 1.5)):
        found = start(coupling)
        assert found.step(0.0, step) == OK, found.log()
        expected = start(1)
        turn(expected, 2e-4 + speed * middle * step, middle * step)
        names = [f"gear{g}.{q}[{i}]" for g in (1, 2) for q in ("force", "moment") for i in (1, 2, 3)]
        names += ["mesh.tangentialForce", "mesh.normalForce"]
        size = abs(expected.get("mesh.normalForce"))
        assert size > 500.0
        assert found.get(*names) == pytest.approx(expected.get(*names), abs=1e-5 * size)
        # All else belongs to the communication point.
        here = start(1)
        for name in ("mesh.transmissionError", "mesh.stiffness", "mesh.contactZ", "mesh.position"):
            assert found.get(name) == here.get(name)


def test_output_derivatives_are_the_rates_of_the_outputs(mesh):
    names = ["gear2.force[2]", "gear1.moment[3]", "mesh.transmissionError", "mesh.position"]
    rates = {"gear1.angularVelocity[3]": 0.3, "gear2.angularVelocity[3]": -0.2}
    step = 1e-6

    def instance_at(time):
        instance = mesh().initialize({"damping": 1e3})
        angles = {"gear1.angles[3]": 2e-4 + 0.3 * time, "gear2.angles[3]": -0.2 * time}
        instance.set({**rates, **angles})
        return instance

    middle = instance_at(0.0)
    assert middle.step(0.0, step) == OK
    count, data = len(names), (ctypes.c_double * len(names))()
    first_order = (ctypes.c_int * count)(*[1] * count)
    middle.expect("fmi2GetRealOutputDerivatives", middle.references(names), ctypes.c_size_t(count), first_order, data)
    before, after = (instance_at(t).get(*names) for t in (-step, step))
    numeric = (np.array(after) - before) / (2 * step)
    assert np.array(list(data)) == pytest.approx(numeric, rel=1e-6)


def test_model_exchange_answers_at_every_stage_and_goes_on_after_a_point_that_is_none(mesh):
    one, other = mesh(kind=MODEL_EXCHANGE).initialize(), mesh().initialize()
    inputs, outputs = variables(one)
    rng = np.random.default_rng(3)
    for stage in range(20):
        values = {"gear1.angles[3]": 2e-4 * rng.random(), "gear1.angularVelocity[3]": rng.normal()}
        one.expect("fmi2SetTime", ctypes.c_double(0.1 * rng.random()))
        for instance in (one, other):
            instance.set(values)
        assert one.get(*outputs) == other.get(*outputs)
        seeds = rng.normal(size=2)
        along = [directional(i, outputs, list(values), seeds) for i in (one, other)]
        assert list(along[0]) == list(along[1])
        assert one.get("mesh.flank") == other.get("mesh.flank")
        if stage == 10:
            # A solver tries a pose without meaning and comes back.
            one.set({"gear2.angles[1]": 1.5})
            data = (ctypes.c_double * 1)()
            references = one.references(["gear1.force[1]"])
            assert one.call("fmi2GetReal", references, ctypes.c_size_t(1), data) == DISCARD
            assert "tilted" in one.log()
            one.set({"gear2.angles[1]": 0.0})
    # Tunable parameters change at events.
    one.expect("fmi2EnterEventMode")
    one.set({"damping": 5e4})
    info = EventInfo(*[7] * 6)
    one.expect("fmi2NewDiscreteStates", ctypes.byref(info))
    assert [getattr(info, name) for name, _ in EventInfo._fields_] == [0] * 6
    one.expect("fmi2EnterContinuousTimeMode")
    assert one.get("damping") == 5e4
    event, end = ctypes.c_int(7), ctypes.c_int(7)
    one.expect("fmi2CompletedIntegratorStep", 1, ctypes.byref(event), ctypes.byref(end))
    assert (event.value, end.value) == (0, 0)


@pytest.mark.parametrize("orientation", [1, 2], ids=["angles", "quaternion"])
@FORMULATIONS
@EXTERNAL_AND_INTERNAL
def test_directional_derivatives_are_those_of_differences(mesh, pair, formulation, orientation):
    rng = np.random.default_rng(20130411)
    instance = mesh(pair)
    inputs, outputs = variables(instance)
    # One flank: the pairs have no backlash, so that the other one would carry, too, as soon as gears approach.
    choices = {"stiffnessModel": 1, "damping": 1e3, "loadedFlank": 1}
    instance.initialize({**choices, "orientationInput": orientation, "formulation": formulation})
    values = dict(zip(inputs, instance.get(*inputs)))
    for n in inputs:
        if "quaternion" not in n:
            values[n] += rng.uniform(-1, 1) * (1e-2 if "elocity" in n else 1e-5)
    slip = 4e-5 / instance.unit.geometry.pitch_radii[0]
    values["gear1.angles[3]"] += slip
    values["gear1.quaternion[4]"] += slip / 2
    instance.set(values)
    assert instance.get("mesh.flank") == 1
    exact, step = jacobian(instance, inputs, outputs), 2e-7
    numeric = by_differences(instance, values, outputs, step)
    for i, output in enumerate(outputs):
        for kind, columns in columns_by_kind(inputs).items():
            # The largest of one kind of input, and what rounding of the output leaves of a difference.
            scale, h = np.abs(exact[i, columns]).max(), 1e-3 if "elocity" in kind else step
            floor = 8 * np.spacing(abs(instance.get(output))) / h + 1e-9
            error = np.abs(numeric[i, columns] - exact[i, columns]).max()
            assert error <= 1e-6 * scale + floor, (output, kind, error, scale)
    # A direction is the sum of its parts.
    seed = rng.normal(size=len(inputs))
    along = directional(instance, outputs, inputs, seed)
    rounding = 1e-12 * np.abs(exact) @ np.abs(seed) + 1e-13 * np.abs(instance.get(*outputs))
    assert np.all(np.abs(along - exact @ seed) <= rounding)
