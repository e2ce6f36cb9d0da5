"""Whole simulations through fmpy, both orientation inputs, and folders with awkward names."""

import numpy as np
import pytest
from fmpy import extract, simulate_fmu
from host import OK, Unit

OUTPUTS = ["gear1.force[2]", "gear1.moment[3]", "gear2.moment[3]", "mesh.transmissionError", "mesh.position"]


def signals(times, angle, orientation):
    """Gear 1 turns by `angle` over time, gear 2 half a permille less."""
    columns = {}
    for gear, turn in (("gear1", angle), ("gear2", -angle * (1 - 5e-4))):
        if orientation == "angles":
            columns[f"{gear}.angles[3]"] = turn
        else:
            columns[f"{gear}.quaternion[1]"] = np.cos(turn / 2)
            columns[f"{gear}.quaternion[4]"] = np.sin(turn / 2)
        columns[f"{gear}.angularVelocity[3]"] = np.gradient(turn, times)
    out = np.zeros(len(times), dtype=[("time", float)] + [(n, float) for n in columns])
    out["time"] = times
    for name, values in columns.items():
        out[name] = values
    return out


def simulate(fmu, orientation, **options):
    times = np.linspace(0.0, 1e-2, 1001)
    angle = 20.0 * times + 5e-3 * np.sin(300.0 * times)
    return simulate_fmu(
        fmu,
        stop_time=1e-2,
        output_interval=1e-5,
        input=signals(times, angle, orientation),
        output=OUTPUTS,
        start_values={"orientationInput": 1 if orientation == "angles" else 2, "damping": 1e3},
        **options,
    )


def test_both_orientation_inputs_give_the_same_simulation(fmus):
    fmu = str(fmus["external"])
    one, two = simulate(fmu, "angles"), simulate(fmu, "quaternion")
    assert len(one) == 1001
    for name in OUTPUTS[:4]:
        scale = np.abs(one[name]).max()
        assert scale > 0
        # Interpolated quaternions are not quite those of interpolated angles: 1 um of 40 mm.
        assert np.abs(one[name] - two[name]).max() < 1e-6 * scale, name
    # The driven gear turns slower, so the drive flank is pressed more and more.
    assert one["mesh.transmissionError"][-1] > 1e-6
    assert one["gear2.moment[3]"][-1] == pytest.approx(one["gear1.moment[3]"][-1], rel=1e-12)


def test_a_unit_runs_from_folders_with_awkward_names(fmus, tmp_path):
    for name in ("with space", "Zähne und Räder", "100% #1 a+b", "歯車"):
        unit = Unit(fmus["external"], tmp_path / name / "unit")
        instance = unit.instance()
        assert instance.component, instance.log()
        instance.initialize()
        assert instance.step(0.0, 1e-5) == OK
        instance.close()


@pytest.mark.parametrize(
    "form", ["file://{}", "file:{}", "file://localhost{}", "FILE://{}", "{}"]
)
def test_every_form_of_the_resource_location_is_found(units, form):
    from urllib.parse import quote

    unit = units["external"]
    instance = unit.instance(resources=form.format(quote(unit.folder) + "/resources"))
    assert instance.component, instance.log()
    instance.close()


def test_fmpy_can_unpack_and_run_the_folder(fmus, tmp_path):
    folder = extract(str(fmus["ring2"]), str(tmp_path / "unit"))
    result = simulate_fmu(folder, stop_time=1e-3, output_interval=1e-5, output=OUTPUTS)
    assert np.abs(result["gear1.moment[3]"]).max() < 1e-6


def test_input_derivatives_and_poses_advance_inside_the_step(mesh):
    """Held, extrapolated by derivatives, and by velocities: the latter two see the end of the step."""
    import ctypes

    step, rate = 1e-4, 2.0

    def force(extrapolate, derivative):
        instance = mesh().initialize({"damping": 0.0, "extrapolatePoses": int(extrapolate)})
        instance.set({"gear1.angularVelocity[3]": rate if extrapolate else 0.0})
        if derivative:
            instance.expect(
                "fmi2SetRealInputDerivatives",
                instance.references(["gear1.angles[3]"]),
                ctypes.c_size_t(1),
                (ctypes.c_int * 1)(1),
                (ctypes.c_double * 1)(rate),
            )
        assert instance.step(0.0, step) == OK
        return instance.get("gear2.force[2]")

    reference = mesh().initialize({"damping": 0.0})
    reference.set({"gear1.angles[3]": rate * step})
    end = reference.get("gear2.force[2]")
    assert end > 1000.0
    assert abs(force(False, False)) < 1e-6
    assert force(False, True) == pytest.approx(end, rel=1e-12)
    assert force(True, False) == pytest.approx(end, rel=1e-12)


def test_output_derivatives_are_the_rates_of_the_outputs(mesh):
    import ctypes

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
    data = (ctypes.c_double * len(names))()
    middle.expect(
        "fmi2GetRealOutputDerivatives",
        middle.references(names),
        ctypes.c_size_t(len(names)),
        (ctypes.c_int * len(names))(*[1] * len(names)),
        data,
    )
    before, after = (instance_at(t).get(*names) for t in (-step, step))
    numeric = (np.array(after) - before) / (2 * step)
    assert np.array(list(data)) == pytest.approx(numeric, rel=1e-6)
