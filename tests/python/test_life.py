"""The life of instances: wrong states, bad values, logging, many loads, two pairs at once."""

import ctypes
import math
import resource

import pytest
from host import DISCARD, ERROR, OK, Unit

REAL = ctypes.c_double
NULL = ctypes.c_void_p(None)


def calls(instance):
    """One legal-looking call of every function that takes an instance, by name."""
    vr = instance.references(["gear1.angles[3]"])
    out = instance.references(["gear1.moment[3]"])
    kind = instance.references(["formulation"])
    flag = instance.references(["loadDependent"])
    one, order = ctypes.c_size_t(1), (ctypes.c_int * 1)(1)
    real, integer = (REAL * 1)(0.0), (ctypes.c_int * 1)(1)
    state, size = ctypes.c_void_p(), ctypes.c_size_t()
    text = (ctypes.c_char_p * 1)()
    place = ctypes.byref
    return {
        "fmi2SetDebugLogging": (1, ctypes.c_size_t(0), NULL),
        "fmi2SetupExperiment": (0, REAL(0), REAL(0), 0, REAL(0)),
        "fmi2EnterInitializationMode": (),
        "fmi2ExitInitializationMode": (),
        "fmi2Terminate": (),
        "fmi2Reset": (),
        "fmi2GetReal": (vr, one, real),
        "fmi2GetInteger": (kind, one, integer),
        "fmi2GetBoolean": (flag, one, integer),
        "fmi2GetString": (NULL, ctypes.c_size_t(0), NULL),
        "fmi2SetReal": (vr, one, real),
        "fmi2SetInteger": (instance.references(["formulation"]), ctypes.c_size_t(0), integer),
        "fmi2SetBoolean": (flag, ctypes.c_size_t(0), integer),
        "fmi2SetString": (NULL, ctypes.c_size_t(0), NULL),
        "fmi2GetFMUstate": (place(state),),
        "fmi2FreeFMUstate": (place(ctypes.c_void_p()),),
        "fmi2GetDirectionalDerivative": (out, one, vr, one, real, (REAL * 1)()),
        "fmi2SetRealInputDerivatives": (vr, one, order, real),
        "fmi2GetRealOutputDerivatives": (out, one, order, (REAL * 1)()),
        "fmi2DoStep": (REAL(0.0), REAL(1e-5), 1),
        "fmi2CancelStep": (),
        "fmi2GetStatus": (0, place(ctypes.c_int())),
        "fmi2GetRealStatus": (2, place(REAL())),
        "fmi2GetBooleanStatus": (3, place(ctypes.c_int())),
        "fmi2GetIntegerStatus": (0, place(ctypes.c_int())),
        "fmi2GetStringStatus": (1, text),
    }


def enter(instance, state):
    """Brings a new instance into `state`."""
    if state == "instantiated":
        return
    if state == "initialization":
        instance.expect("fmi2EnterInitializationMode")
        return
    instance.initialize()
    if state == "terminated":
        instance.expect("fmi2Terminate")
    if state == "error":
        assert instance.status_of_setting({"gear1.angles[3]": math.nan}) == ERROR


# After the table of FMI 2.0.5, section 4.2.4.
I, M, S, T, E = "instantiated", "initialization", "step", "terminated", "error"
STATES = (I, M, S, T, E)
KEPT = {I, M, S, T, E}
ALLOWED = {
    "fmi2SetDebugLogging": KEPT,
    "fmi2SetupExperiment": {I},
    "fmi2EnterInitializationMode": {I},
    "fmi2ExitInitializationMode": {M},
    "fmi2Terminate": {S},
    "fmi2Reset": KEPT,
    **{f"fmi2Get{t}": {M, S, T, E} for t in ("Real", "Integer", "Boolean", "String")},
    **{f"fmi2Set{t}": {I, M, S} for t in ("Real", "Integer", "Boolean", "String")},
    "fmi2GetFMUstate": KEPT,
    "fmi2FreeFMUstate": KEPT,
    "fmi2GetDirectionalDerivative": {M, S, T, E},
    "fmi2SetRealInputDerivatives": {I, M, S},
    "fmi2GetRealOutputDerivatives": {S, T, E},
    "fmi2DoStep": {S},
    "fmi2CancelStep": set(),
    **{f"fmi2Get{t}Status": {S, T, E} for t in ("", "Real", "Boolean", "Integer", "String")},
}


@pytest.mark.parametrize("function", ALLOWED)
def test_every_function_in_every_state(mesh, function):
    for state in STATES:
        instance = mesh(name=state)
        assert set(calls(instance)) == set(ALLOWED)
        enter(instance, state)
        status = instance.call(function, *calls(instance)[function])
        if state in ALLOWED[function]:
            discards = function in ("fmi2GetIntegerStatus", "fmi2GetStringStatus")
            assert status == (DISCARD if discards else OK), (state, instance.log())
        else:
            assert status == ERROR, state
            assert f"{function} is not allowed in the state" in instance.log()
        # The host lives, and the instance can be used again.
        instance.expect("fmi2Reset")
        instance.initialize()
        assert instance.step(0.0, 1e-5) == OK


@pytest.mark.parametrize("function", ALLOWED)
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


def test_values_out_of_range_are_refused_with_the_choices(mesh):
    for values, said in (
        ({"formulation": 3}, "choose one of 1 (paper), 2 (conjugate)"),
        ({"formulation": 0}, "formulation = 0"),
        ({"damping": -1.0}, "damping = -1; set 0 or more"),
        ({"loadDependent": 2}, "loadDependent = 2"),
        ({"gear1.force[1]": 1.0}, "gear1.force[1] is an output"),
    ):
        instance = mesh()
        assert instance.status_of_setting(values) == ERROR
        assert said in instance.log()


def test_unknown_references_and_wrong_types_are_refused(mesh):
    for function, reference in (("fmi2GetReal", 99), ("fmi2GetInteger", 0), ("fmi2GetString", 0)):
        instance = mesh().initialize()
        one = (ctypes.c_uint * 1)(reference)
        assert instance.call(function, one, ctypes.c_size_t(1), (REAL * 1)()) == ERROR
        assert f"value reference {reference}" in instance.log()


def test_no_items_with_null_arrays_is_legal_and_items_in_null_arrays_are_not(mesh):
    instance = mesh().initialize()
    for name in ("Real", "Integer", "Boolean", "String"):
        for verb in ("Get", "Set"):
            instance.expect(f"fmi2{verb}{name}", NULL, ctypes.c_size_t(0), NULL)
    assert instance.call("fmi2GetReal", NULL, ctypes.c_size_t(1), NULL) == ERROR
    assert "null" in instance.log()


def test_fixed_parameters_rest_after_initialization_and_tunable_ones_do_not(mesh):
    instance = mesh().initialize()
    instance.set({"damping": 5e4})
    assert instance.get("damping") == 5e4
    assert instance.status_of_setting({"constantStiffness": 1e8}) == ERROR
    assert "constantStiffness is fixed" in instance.log()


def test_a_unit_without_tables_says_so(mesh):
    instance = mesh()
    instance.set({"stiffnessModel": 2})
    instance.expect("fmi2EnterInitializationMode")
    assert instance.call("fmi2ExitInitializationMode") == ERROR
    assert "table" in instance.log()


@pytest.mark.parametrize("length", [0.0, 0.9, 1.1, 1e200])
def test_a_quaternion_far_from_unit_length_is_refused(mesh, length):
    instance = mesh()
    instance.expect("fmi2EnterInitializationMode")
    instance.set({"orientationInput": 2, "gear2.quaternion[1]": length})
    assert instance.call("fmi2ExitInitializationMode") == ERROR
    assert "gear2.quaternion has the length" in instance.log()


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
    # Times that are equal to rounding are equal: a host may multiply or add up.
    instance = mesh().initialize(stop=1.0)
    time = 0.0
    for i in range(1, 1001):
        assert instance.step(time, 1e-3) == OK, instance.log()
        time = i * 1e-3 if i % 2 else time + 1e-3


def test_the_log_speaks_when_it_is_on_and_in_declared_categories(mesh, units):
    declared = set(units["external"].description.logCategories and [
        c.name for c in units["external"].description.logCategories
    ] or [])
    silent = mesh(logging=False)
    assert silent.status_of_setting({"damping": -1.0}) == ERROR
    assert silent.messages == []
    loud = mesh(name="a#b")
    assert loud.status_of_setting({"damping": -1.0}) == ERROR
    (name, status, category, form, _text), = loud.messages
    assert (name, status, form) == ("a#b", ERROR, "%s")
    assert category == "logStatusError" and (not declared or category in declared)
    loud.expect("fmi2Reset")
    events = (ctypes.c_char_p * 1)(b"logStatusError")
    loud.expect("fmi2SetDebugLogging", 0, ctypes.c_size_t(1), events)
    before = len(loud.messages)
    assert loud.status_of_setting({"damping": -1.0}) == ERROR
    assert len(loud.messages) == before
    unknown = (ctypes.c_char_p * 1)(b"logNonsense")
    assert mesh().call("fmi2SetDebugLogging", 1, ctypes.c_size_t(1), unknown) == ERROR


def test_what_cannot_be_instantiated_says_why(units):
    unit = units["external"]
    for options, said in (
        ({"guid": "{not-this-one}"}, "GUID"),
        ({"resources": "file:///nowhere/resources"}, "nowhere"),
        ({"resources": "http://host/resources"}, "file URI"),
        ({"name": ""}, "instanceName is empty"),
    ):
        instance = unit.instance(**options)
        assert not instance.component
        assert said in instance.log()
        instance.close()
    quiet = unit.instance(guid="{x}", logger=False)
    assert not quiet.component
    quiet.close()


def test_two_instances_of_different_pairs_run_at_once(mesh):
    one, two = mesh("external"), mesh("ring2")
    for instance in (one, two):
        instance.initialize()
    alone = {}
    for pair in ("external", "ring2"):
        instance = mesh(pair).initialize()
        instance.set({"gear1.angles[3]": 1e-4})
        assert instance.step(0.0, 1e-5) == OK
        alone[pair] = instance.vector("gear2.moment")
    for instance in (one, two):
        instance.set({"gear1.angles[3]": 1e-4})
    assert two.step(0.0, 1e-5) == OK and one.step(0.0, 1e-5) == OK
    assert one.vector("gear2.moment") == alone["external"] != alone["ring2"]
    assert two.vector("gear2.moment") == alone["ring2"]


def resident_size():
    """Memory of this process, bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def test_a_thousand_loads_leave_no_memory_behind(fmus, tmp_path):
    unit = Unit(fmus["external"], tmp_path / "unit")

    def cycle():
        instance = unit.instance(logging=False)
        instance.initialize()
        instance.store()
        assert instance.step(0.0, 1e-5) == OK
        instance.close()

    for _ in range(100):
        cycle()
    before = resident_size()
    for _ in range(1000):
        cycle()
    # A leaked instance takes several kilobytes.
    assert resident_size() - before < 2e6
