"""Time of one step of a unit from C, from ctypes with arrays made beforehand, through fmpy, and by the masters libcosim and Ecos.

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
    """Value references of all Real inputs and of the main Real outputs, the block that the first of them begins."""
    inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
    outputs = [
        v.valueReference
        for v in description.modelVariables
        if v.causality == "output" and v.type == "Real"
    ]
    outputs = [r for r in outputs if set(range(outputs[0], r)) <= set(outputs)]
    if inputs != list(range(inputs[0], inputs[0] + len(inputs))):
        raise SystemExit("value references of the inputs are not contiguous")
    return inputs, outputs


def from_c(folder, description, inputs, outputs):
    """Nanoseconds of a step, and the moment on gear 1."""
    with tempfile.TemporaryDirectory() as build:
        program = Path(build, "fmu_step")
        source = Path(__file__).with_name("fmu_step.c")
        command = ["cc", "-O2", "-std=c99", "-Wall", "-Wextra", str(source), "-o", str(program), "-ldl"]
        subprocess.run(command, check=True)
        library = next(Path(folder, "binaries", "linux64").glob("*.so"))
        uri = Path(folder, "resources").as_uri()
        blocks = (inputs[0], len(inputs), outputs[0], len(outputs))
        command = [program, library, description.guid, uri, 20000, *blocks]
        run = subprocess.run([str(x) for x in command], check=True, capture_output=True, text=True)
        time, moment = (float(x) for x in run.stdout.split())
        return {"c": time, "moment": moment}


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


def masters(fmu, values):
    """Median time, ns, of a step of the masters libcosim and Ecos with this unit alone, its inputs resting at `values` (by name)."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    from examples.hosts import with_ecos, with_libcosim

    times = {}
    for name, host in (("libcosim", with_libcosim), ("ecos", with_ecos)):
        with host.resting(fmu, values, STEP) as step:
            times[name] = median_step(step, 1000)
    return times


def main(fmu):
    folder = extract(fmu)
    try:
        description = read_model_description(folder)
        inputs, outputs = blocks(description)
        times = from_c(folder, description, inputs, outputs)
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
            **times,
            "ctypes": median_step(through_ctypes, 2000),
            "fmpy": median_step(through_fmpy, 300),
        }
        slave.terminate()
        slave.freeInstance()
        result |= masters(fmu, {"gear1.angles[3]": values[5]})
        print(json.dumps(result))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    main(sys.argv[1])
