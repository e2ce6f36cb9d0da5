"""The life of instances: wrong states, bad values, logging, many loads, two pairs at once."""

import ctypes
import math
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import gearmesh
import numpy as np
import pytest
from conftest import ALIGNED, COUPLINGS, EXTERNAL_AND_INTERNAL, FORMULATIONS, PAIRS, QUICK
from differences import by_differences, columns_by_kind, jacobian, variables
from host import CO_SIMULATION, DISCARD, ERROR, MODEL_EXCHANGE, OK, EventInfo

REAL = ctypes.c_double
NULL = ctypes.c_void_p(None)


def calls(instance):
    """One legal-looking call of every function that takes an instance, by name."""
    vr = instance.references(["gear1.angles[3]"])
    out = instance.references(["gear1.moment[3]"])
    kind = instance.references(["formulation"])
    flag = instance.references(["loadDependent"])
    none, one, order = ctypes.c_size_t(0), ctypes.c_size_t(1), (ctypes.c_int * 1)(1)
    real, integer = (REAL * 1)(0.0), (ctypes.c_int * 1)(1)
    place = ctypes.byref
    modes = [f"fmi2{name}" for name in ("EnterInitializationMode", "ExitInitializationMode", "EnterEventMode", "EnterContinuousTimeMode")]
    states = ("fmi2SetContinuousStates", "fmi2GetDerivatives", "fmi2GetEventIndicators", "fmi2GetContinuousStates", "fmi2GetNominalsOfContinuousStates")
    return {
        **dict.fromkeys([*modes, "fmi2Terminate", "fmi2Reset", "fmi2CancelStep"], ()),
        **dict.fromkeys(states, (NULL, none)),
        "fmi2SetDebugLogging": (1, none, NULL),
        "fmi2SetupExperiment": (0, REAL(0), REAL(0), 0, REAL(0)),
        "fmi2GetReal": (vr, one, real),
        "fmi2GetInteger": (kind, one, integer),
        "fmi2GetBoolean": (flag, one, integer),
        "fmi2GetString": (NULL, none, NULL),
        "fmi2SetReal": (vr, one, real),
        **{f"fmi2Set{t}": (NULL, none, NULL) for t in TYPES[1:]},
        "fmi2GetFMUstate": (place(ctypes.c_void_p()),),
        "fmi2FreeFMUstate": (place(ctypes.c_void_p()),),
        "fmi2GetDirectionalDerivative": (out, one, vr, one, real, (REAL * 1)()),
        "fmi2SetRealInputDerivatives": (vr, one, order, real),
        "fmi2GetRealOutputDerivatives": (out, one, order, (REAL * 1)()),
        "fmi2DoStep": (REAL(0.0), REAL(1e-5), 1),
        "fmi2GetStatus": (0, place(ctypes.c_int())),
        "fmi2GetRealStatus": (2, place(REAL())),
        "fmi2GetBooleanStatus": (3, place(ctypes.c_int())),
        "fmi2GetIntegerStatus": (0, place(ctypes.c_int())),
        "fmi2GetStringStatus": (1, (ctypes.c_char_p * 1)()),
        "fmi2NewDiscreteStates": (place(EventInfo()),),
        "fmi2CompletedIntegratorStep": (1, place(ctypes.c_int(7)), place(ctypes.c_int(7))),
        "fmi2SetTime": (REAL(0.0),),
    }


def enter(instance, state):
    """Brings a new instance into `state`."""
    if state == "initialization":
        instance.expect("fmi2EnterInitializationMode")
    elif state != "instantiated":
        instance.initialize()
    if state == "event":
        instance.expect("fmi2EnterEventMode")
    if state == "terminated":
        instance.expect("fmi2Terminate")
    if state == "error":
        assert instance.status_of_setting({"gear1.angles[3]": math.nan}) == ERROR


# After the tables of FMI 2.0.5, sections 4.2.4 (co-simulation) and 3.2.3 (model exchange).
I, M, S, V, C, T, E = "instantiated", "initialization", "step", "event", "continuous", "terminated", "error"
STATES = {CO_SIMULATION: (I, M, S, T, E), MODEL_EXCHANGE: (I, M, V, C, T, E)}
TYPES = ("Real", "Integer", "Boolean", "String")
ALLOWED = {
    **dict.fromkeys(("fmi2SetDebugLogging", "fmi2Reset", "fmi2GetFMUstate", "fmi2FreeFMUstate"), {I, M, S, V, C, T, E}),
    "fmi2SetupExperiment": {I},
    "fmi2EnterInitializationMode": {I},
    "fmi2ExitInitializationMode": {M},
    "fmi2Terminate": {S, V, C},
    **{f"fmi2Get{t}": {M, S, V, C, T, E} for t in TYPES},
    "fmi2SetReal": {I, M, S, V, C},
    **{f"fmi2Set{t}": {I, M, S, V} for t in TYPES[1:]},
    "fmi2GetDirectionalDerivative": {M, S, V, C, T, E},
}
CO_SIMULATION_ALONE = {
    "fmi2SetRealInputDerivatives": {I, M, S},
    "fmi2GetRealOutputDerivatives": {S, T, E},
    "fmi2DoStep": {S},
    "fmi2CancelStep": set(),
    **{f"fmi2Get{t}Status": {S, T, E} for t in ("", "Real", "Boolean", "Integer", "String")},
}
MODEL_EXCHANGE_ALONE = {
    "fmi2EnterEventMode": {V, C},
    "fmi2NewDiscreteStates": {V},
    "fmi2EnterContinuousTimeMode": {V},
    "fmi2CompletedIntegratorStep": {C},
    "fmi2SetTime": {V, C},
    "fmi2SetContinuousStates": {C},
    **{f"fmi2Get{what}": {I, M, V, C, T, E} for what in ("Derivatives", "ContinuousStates", "NominalsOfContinuousStates")},
    "fmi2GetEventIndicators": {M, V, C, T, E},
}
EVERY = ALLOWED | CO_SIMULATION_ALONE | MODEL_EXCHANGE_ALONE


@pytest.mark.parametrize("kind", [CO_SIMULATION, MODEL_EXCHANGE], ids=["cs", "me"])
@pytest.mark.parametrize("function", EVERY)
def test_every_function_in_every_state(mesh, function, kind):
    foreign = MODEL_EXCHANGE_ALONE if kind == CO_SIMULATION else CO_SIMULATION_ALONE
    for state in STATES[kind]:
        instance = mesh(name=state, kind=kind)
        assert set(calls(instance)) == set(EVERY)
        enter(instance, state)
        status = instance.call(function, *calls(instance)[function])
        if function in foreign:
            assert status == ERROR and f"{function}: belongs to" in instance.log(), state
        elif state in EVERY[function]:
            discards = function in ("fmi2GetIntegerStatus", "fmi2GetStringStatus")
            assert status == (DISCARD if discards else OK), (state, instance.log())
        else:
            assert status == ERROR, state
            assert f"{function}: not allowed in the state" in instance.log()
        # The host lives, and the instance can be used again.
        instance.expect("fmi2Reset")
        instance.initialize()
        if kind == CO_SIMULATION:
            assert instance.step(0.0, 1e-5) == OK
        else:
            assert abs(instance.get("gear1.force[2]")) < 1e-6


@pytest.mark.parametrize("function", EVERY)
def test_a_null_instance_is_an_error_and_no_crash(mesh, function):
    instance = mesh()
    arguments = calls(instance)[function]
    instance.component, kept = None, instance.component
    assert instance.call(function, *arguments) == ERROR
    instance.component = kept


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_values_that_are_not_finite_are_refused_by_name(mesh, units, bad):
    for v in units["external"].description.modelVariables:
        if v.type != "Real" or v.causality == "output":
            continue
        instance = mesh()
        assert instance.status_of_setting({v.name: bad}) == ERROR
        assert f"{v.name} = " in instance.log() and "finite" in instance.log()
        instance.close()


def test_none_of_the_values_of_a_refused_call_is_taken(mesh):
    instance = mesh().initialize({"gear1.angles[3]": 0.25})
    values = {"gear1.angles[3]": 0.5, "gear2.angles[3]": math.inf}
    assert instance.status_of_setting(values) == ERROR
    assert instance.get("gear1.angles[3]") == 0.25


def test_fixed_parameters_rest_after_initialization_and_tunable_ones_do_not(mesh):
    instance = mesh().initialize()
    instance.set({"damping": 5e4})
    assert instance.get("damping") == 5e4
    assert instance.status_of_setting({"constantStiffness": 1e8}) == ERROR
    assert "constantStiffness is fixed" in instance.log()


def test_steps_must_follow_one_another(mesh):
    for time, step, said in (
        (0.0, 0.0, "communicationStepSize = 0"),
        (0.0, -1e-5, "communicationStepSize"),
        (0.0, math.nan, "communicationStepSize = NaN"),
        (0.5, 1e-5, "currentCommunicationPoint = 0.5"),
        (math.nan, 1e-5, "currentCommunicationPoint = NaN"),
        (0.0, 2.0, "after stopTime = 1"),
    ):
        instance = mesh().initialize(stop=1.0)
        assert instance.step(time, step) == ERROR
        assert said in instance.log()


def last_successful_time(instance):
    time = REAL()
    instance.expect("fmi2GetRealStatus", 2, ctypes.byref(time))
    return time.value


@COUPLINGS
def test_a_refused_step_changes_nothing(mesh, coupling):
    instance = mesh().initialize({"coupling": coupling, "gear1.angularVelocity[3]": 1.0})
    assert instance.step(0.0, 1e-5) == OK
    # Gear 2 ends the step tilted beyond what has a meaning.
    tilt = "gear2.angles[1]"
    rates = ctypes.c_size_t(1), (ctypes.c_int * 1)(1), (REAL * 1)(1e5)
    instance.expect("fmi2SetRealInputDerivatives", instance.references([tilt]), *rates)
    inputs, outputs = variables(instance)
    before = instance.get(*inputs, *outputs)
    assert instance.step(1e-5, 1e-5) == DISCARD
    assert "tilted" in instance.log()
    assert last_successful_time(instance) == 1e-5
    assert instance.get(*inputs, *outputs) == before
    # A shorter step is another one. The same again would be tried for ever by hosts that only repeat.
    assert instance.step(1e-5, 1e-8) == OK
    instance.set({tilt: 1.0})
    assert instance.step(1e-5 + 1e-8, 1e-5) == DISCARD
    instance.set({tilt: 0.0})
    assert instance.step(1e-5 + 1e-8, 1e-5) == OK
    instance.set({tilt: 1.0})
    now = last_successful_time(instance)
    assert [instance.step(now, 1e-5) for _ in range(3)] == [DISCARD, ERROR, ERROR]


@FORMULATIONS
@EXTERNAL_AND_INTERNAL
@pytest.mark.parametrize("phase", [1, 2], ids=["fromInitialPose", "absolute"])
def test_derivatives_in_initialization_are_those_of_the_values(mesh, pair, formulation, phase):
    """With the initial pose as the touching one, the phases follow the pose until it is left."""
    instance = mesh(pair)
    inputs, outputs = variables(instance)
    inputs = [n for n in inputs if "quaternion" not in n]
    choices = {"formulation": formulation, "loadedFlank": 1, "phaseReference": phase}
    instance.expect("fmi2EnterInitializationMode")
    instance.set(choices)
    values = dict(zip(inputs, instance.get(*inputs)))
    for i, name in enumerate(inputs):
        values[name] += 1e-5 * math.sin(i + 1.0)
    # At zero angles a tooth of gear 1 may face a tooth of gear 2: half a pitch.
    values["gear1.angles[3]"] += 1e-4 - {"external": math.pi / 20, "ring2": math.pi / 27, "ring1": 0.0}[pair]
    instance.set(values)
    exact = jacobian(instance, inputs, outputs)
    numeric = by_differences(instance, values, outputs, 1e-7)
    # What an output changes by where the phases are held is its scale.
    instance.expect("fmi2ExitInitializationMode")
    instance.set({"gear1.angles[3]": values["gear1.angles[3]"] + 1e-4})
    held = jacobian(instance, inputs, outputs)
    if phase == 1:
        te = outputs.index("mesh.transmissionError")
        assert np.abs(exact[te]).max() < 1e-8 * np.abs(held[te]).max()
    for row, output in enumerate(outputs):
        # At the touch itself the stiffness jumps, and differences of it say nothing.
        if output == "mesh.stiffness":
            continue
        for kind, columns in columns_by_kind(inputs).items():
            scale = np.abs(held[row, columns]).max() + 1e-3 * abs(instance.get(output)) + 1e-9
            error = np.abs(exact[row, columns] - numeric[row, columns]).max()
            assert error <= 2e-6 * scale, (output, kind, error, scale)


def test_the_log_has_refusals_always_and_events_when_it_is_on(mesh, units):
    declared = {c.name for c in units["external"].description.logCategories}
    quiet = mesh(logging=False).initialize()
    assert quiet.messages == []
    assert quiet.status_of_setting({"damping": -1.0}) == ERROR
    assert [m[2] for m in quiet.messages] == ["logStatusError"]
    odd = "%n%s%n%x #r1# \t"  # text, whatever it looks like to printf
    loud = mesh(name=odd)
    assert loud.status_of_setting({"damping": -1.0}) == ERROR
    (name, status, category, form, _text), = loud.messages
    assert (name, status, form) == (odd, ERROR, "%s")
    assert category == "logStatusError" and category in declared
    loud.expect("fmi2Reset")
    assert {m[2] for m in loud.messages} == {"logStatusError", "logEvents"} <= declared
    # Debug logging off: no events. A category is silent once it is switched off by name.
    loud.expect("fmi2SetDebugLogging", 0, ctypes.c_size_t(0), NULL)
    before = len(loud.messages)
    loud.expect("fmi2Reset")
    assert len(loud.messages) == before
    assert loud.status_of_setting({"damping": -1.0}) == ERROR
    assert len(loud.messages) == before + 1
    loud.expect("fmi2Reset")
    errors = (ctypes.c_char_p * 1)(b"logStatusError")
    loud.expect("fmi2SetDebugLogging", 0, ctypes.c_size_t(1), errors)
    assert loud.status_of_setting({"damping": -1.0}) == ERROR
    assert len(loud.messages) == before + 1
    unknown = (ctypes.c_char_p * 1)(b"logNonsense")
    assert mesh().call("fmi2SetDebugLogging", 1, ctypes.c_size_t(1), unknown) == ERROR


def test_a_host_with_its_defaults_shows_why_a_call_was_refused(fmus):
    """fmpy prints what reaches its logger, in a process of its own: loggers must not be mixed."""
    script = (
        "from fmpy import simulate_fmu\n"
        f"simulate_fmu({str(fmus['external'])!r}, stop_time=1e-4, output_interval=1e-5,"
        " start_values={'gear2.angles[1]': 1.5})\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert run.returncode != 0
    assert "tilted" in run.stdout + run.stderr


def test_what_cannot_be_instantiated_says_why(units):
    unit = units["external"]
    for options, said in (
        ({"guid": "{not-this-one}"}, "the host passed GUID {not-this-one}"),
        ({"name": ""}, "instanceName is empty"),
        ({"kind": 2}, "model exchange (0) and co-simulation (1)"),
        ({"guid": "a" * 65536}, "fmuGUID does not end within"),
    ):
        instance = unit.instance(**options)
        assert not instance.component
        assert said in instance.log()
        instance.close()
    quiet = unit.instance(guid="{x}", logger=False)
    assert not quiet.component
    quiet.close()


@pytest.mark.slow
@pytest.mark.parametrize("orientation, idle", [(1, "quaternion"), (2, "angles")])
def test_inputs_that_the_formulation_does_not_use_are_not_looked_at(mesh, orientation, idle):
    choices = {"orientationInput": orientation, "formulation": 2, "coupling": 3, "effectiveMass": 0.3}
    found = []
    for unused in ((), ("carrier.", idle)):
        instance = mesh("external-all")
        inputs, outputs = variables(instance)
        absurd = {n: -1e300 for n in inputs if any(part in n for part in unused)}
        instance.initialize(choices | absurd)
        instance.set({"gear1.angularVelocity[3]": 10.0})
        assert instance.step(0.0, 1e-5) == OK, instance.log()
        found.append(instance.get(*outputs))
    assert found[0] == found[1]


def test_sixty_four_instances_on_eight_threads_give_what_each_gives_alone(units):
    unit = units["external-all"]

    def work(number):
        instance = unit.instance(name=f"mesh {number}")
        instance.initialize({"loadDependent": number % 2, "shuttlingEffect": number // 2 % 2})
        series = []
        for i in range(30):
            instance.set({"gear1.angles[3]": 2e-4 + 1e-5 * math.sin(i)})
            assert instance.step(i * 1e-5, 1e-5) == OK, instance.log()
            series.append(instance.vector("gear2.force") + instance.vector("gear2.moment"))
        instance.close()
        return series

    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(work, range(64)))
    alone = [work(number) for number in range(4)]
    assert together == 16 * alone and alone[0] != alone[1]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="fenv.h of glibc")
def test_a_host_that_traps_floating_point_exceptions_or_rounds_otherwise_gets_the_same_numbers(tmp_path):
    levels = gearmesh.build(PAIRS / "palermo2013.json", tmp_path / "levels.fmu", **QUICK, **ALIGNED, friction=True, root_stress=True, teeth=True, contact=True)
    run = [sys.executable, Path(__file__).with_name("floats.py"), levels]
    usual, *others = (subprocess.run([*run, mode], capture_output=True, text=True) for mode in ("usual", "traps", "upward"))
    assert len(usual.stdout) == 65, usual.stderr
    for other in others:
        assert (other.returncode, other.stdout) == (0, usual.stdout), other.stderr
