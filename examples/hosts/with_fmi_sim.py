"""fmi-sim, the command line of the Rust importer `fmi` (cargo install fmi-sim): both interfaces, CSV in and out."""

import csv
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

# `make` puts it beside this Python.
PROGRAM = shutil.which("fmi-sim", path=Path(sys.executable).parent) or shutil.which("fmi-sim")
if PROGRAM is None:
    raise ImportError("fmi-sim is not on the path: cargo install fmi-sim@0.7.0")
# The program ends with status 1 after it has told its version, on the other channel.
VERSION = re.search(r"fmi-sim (\S+)", subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stderr)[1]


def _run(fmu, scenario, outputs, interface):
    with tempfile.TemporaryDirectory() as folder:
        signals, result = Path(folder, "in.csv"), Path(folder, "out.csv")
        scenario.write(signals)
        signals.write_text(signals.read_text().replace('"', ""))
        step = repr(float(scenario.times[1] - scenario.times[0]))
        subprocess.run(
            [
                PROGRAM,
                *("--model", fmu, "--input-file", signals, "--output-file", result),
                interface,
                *("-f", repr(float(scenario.times[-1])), "--output-interval", step),
            ],
            check=True,
            capture_output=True,
        )
        rows = list(csv.DictReader(result.open()))
    return np.array([[float(row[name]) for name in outputs] for row in rows])


def co_simulation(fmu, scenario, outputs):
    """The row of a time belongs to the inputs of the row before."""
    return _run(fmu, scenario, outputs, "co-simulation")[1:]


def model_exchange(fmu, scenario, outputs):
    """The row of a time belongs to the inputs of that time."""
    return _run(fmu, scenario, outputs, "model-exchange")
