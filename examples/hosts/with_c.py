"""A program in C of about a hundred lines, compiled here: c_program/host.c and unit.h."""

import shutil
import subprocess
import tempfile
from pathlib import Path

import fmpy
import numpy as np

SOURCE = Path(__file__).parent / "c_program" / "host.c"
VERSION = subprocess.run(["cc", "-dumpfullversion"], capture_output=True, text=True, check=True).stdout.strip()


def run(fmu, scenario, outputs, kind, platform="linux64", compiler="cc", before=()):
    """Outputs for each row of inputs; `before` stands before the program, such as wine64."""
    folder = fmpy.extract(str(fmu))
    try:
        description = fmpy.read_model_description(folder)
        reference = {v.name: str(v.valueReference) for v in description.modelVariables}
        with tempfile.TemporaryDirectory() as build:
            program = Path(build, "host.exe")
            flags = ["-O2", "-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-cast-function-type"]
            libraries = ["-ldl"] if platform == "linux64" else []
            subprocess.run([compiler, *flags, SOURCE, "-o", program, *libraries], check=True)
            lists = [[str(len(names)), *(reference[name] for name in names)] for names in (scenario.names, outputs)]
            step = repr(float(scenario.times[1] - scenario.times[0]))
            (library,) = Path(folder, "binaries", platform).iterdir()
            unit = [library, description.guid, Path(folder, "resources").as_uri()]
            lines = "\n".join(" ".join(repr(float(v)) for v in row) for row in scenario.values)
            command = [*before, program, kind, *unit, step, *sum(lists, [])]
            answer = subprocess.run(command, input=lines, capture_output=True, text=True)
        if answer.returncode != 0:
            raise RuntimeError(answer.stderr)
        return np.array([line.split() for line in answer.stdout.splitlines()], dtype=float)
    finally:
        shutil.rmtree(folder)


def co_simulation(fmu, scenario, outputs):
    return run(fmu, scenario, outputs, "cs")


def model_exchange(fmu, scenario, outputs):
    return run(fmu, scenario, outputs, "me")
