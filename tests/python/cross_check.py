"""Runs cross-check material through fmpy and compares with its reference."""

import numpy as np
from fmpy import simulate_fmu
from fmpy.util import read_csv

KINDS = {"cs": "CoSimulation", "me": "ModelExchange"}


def differences(folder, interface):
    """Largest difference of each output from the reference, in units of its largest value there."""
    name = folder.name
    settings = dict(line.split(",") for line in (folder / f"{name}_ref.opt").read_text().split())
    expected = read_csv(str(folder / f"{name}_ref.csv"))
    result = simulate_fmu(
        str(folder / f"{name}.fmu"),
        fmi_type=KINDS[interface],
        solver="Euler",
        step_size=float(settings["StepSize"]) if interface == "me" else None,
        output_interval=float(settings["StepSize"]),
        start_time=float(settings["StartTime"]),
        stop_time=float(expected["time"][-1]),
        input=read_csv(str(folder / f"{name}_in.csv")),
        output=list(expected.dtype.names[1:]),
    )
    assert np.array_equal(result["time"], expected["time"])
    moment = np.abs(expected["gear1.moment[3]"])
    assert moment[-1] > 10.0  # the teeth are in contact
    return {
        output: float(np.abs(result[output] - expected[output]).max() / (np.abs(expected[output]).max() or 1.0))
        for output in expected.dtype.names[1:]
    }
