"""Time of one step of a unit from C, from ctypes with arrays made beforehand, and through fmpy.

    python benches/fmu_step.py UNIT.fmu

prints one JSON object: nanoseconds per step (set all inputs, do the step, get all main outputs), medians
over batches, and the moment on gear 1 in N m that tells whether the teeth were in contact.
"""

import ctypes
import json
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

BATCHES = 21
STEP = 1e-6


def blocks(description):
    """Value references of all Real inputs and of the main Real outputs, each contiguous."""
    inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
    outputs = [
        v.valueReference
        for v in description.modelVariables
        if v.causality == "output" and v.type == "Real"
    ]
    for name, block in (("inputs", inputs), ("outputs", outputs)):
        if block != list(range(block[0], block[0] + len(block))):
            raise SystemExit(f"value references of the {name} are not contiguous")
    return inputs, outputs


def from_c(folder, description, inputs, outputs):
    source = Path(__file__).with_name("fmu_step.c")
    library = next(Path(folder, "binaries", "linux64").glob("*.so"))
    with tempfile.TemporaryDirectory() as build:
        program = Path(build, "fmu_step")
        subprocess.run(
            ["cc", "-O2", "-std=c99", "-Wall", "-Wextra", str(source), "-o", str(program), "-ldl"],
            check=True,
        )
        answer = subprocess.run(
            [
                str(program),
                str(library),
                description.guid,
                Path(folder, "resources").as_uri(),
                "20000",
                *(str(n) for n in (inputs[0], len(inputs), outputs[0], len(outputs))),
            ],
            check=True,
            capture_output=True,
            text=True,
        )
    return [float(x) for x in answer.stdout.split()]


def median_step(step, steps):
    """Median over batches of the time of one call of `step`, ns."""
    times = []
    for _ in range(BATCHES):
        begin = time.perf_counter_ns()
        for _ in range(steps):
            step()
        times.append((time.perf_counter_ns() - begin) / steps)
    return statistics.median(times)


def instance(folder, description):
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="mesh",
    )
    slave.instantiate()
    slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    return slave


def main(fmu):
    folder = extract(fmu)
    try:
        description = read_model_description(folder)
        inputs, outputs = blocks(description)
        c, moment = from_c(folder, description, inputs, outputs)
        slave = instance(folder, description)
        values = slave.getReal(inputs)
        # Turns gear 1 into contact, as the C program does.
        values[5] = 1.3e-4
        clock = 0.0

        def through_fmpy():
            nonlocal clock
            slave.setReal(inputs, values)
            slave.doStep(clock, STEP)
            slave.getReal(outputs)
            clock += STEP

        def value_by_value():
            nonlocal clock
            for reference, value in zip(inputs, values):
                slave.setReal([reference], [value])
            slave.doStep(clock, STEP)
            for reference in outputs:
                slave.getReal([reference])
            clock += STEP

        vr_in = (ctypes.c_uint * len(inputs))(*inputs)
        vr_out = (ctypes.c_uint * len(outputs))(*outputs)
        u = (ctypes.c_double * len(inputs))(*values)
        y = (ctypes.c_double * len(outputs))()
        dll = ctypes.CDLL(slave.dll._name)
        size, real = ctypes.c_size_t, ctypes.c_double
        pointer = ctypes.c_void_p
        dll.fmi2SetReal.argtypes = [pointer, pointer, size, pointer]
        dll.fmi2GetReal.argtypes = [pointer, pointer, size, pointer]
        dll.fmi2DoStep.argtypes = [pointer, real, real, ctypes.c_int]
        set_real, get_real, do_step = dll.fmi2SetReal, dll.fmi2GetReal, dll.fmi2DoStep
        component, n, m = slave.component, len(inputs), len(outputs)

        def through_ctypes():
            nonlocal clock
            set_real(component, vr_in, n, u)
            do_step(component, clock, STEP, 1)
            get_real(component, vr_out, m, y)
            clock += STEP

        result = {
            "inputs": len(inputs),
            "outputs": len(outputs),
            "moment": moment,
            "c": c,
            "ctypes": median_step(through_ctypes, 2000),
            "fmpy": median_step(through_fmpy, 300),
            "value_by_value": median_step(value_by_value, 60),
        }
        slave.terminate()
        slave.freeInstance()
        print(json.dumps(result))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    main(sys.argv[1])
