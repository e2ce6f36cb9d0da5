"""Ecos, by ecospy: a master that reads the system from an SSP file (System Structure and Parameterization 1.0)."""

import tempfile
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

import numpy as np
from gearmesh.ssp import write as write_ssp

from examples.shared.ecos import EcosLib, EcosSimulation

VERSION = version("ecospy")

@contextmanager
def simulation(fmu, step):
    """The FMU alone, in communication steps of `step` s."""
    EcosLib.set_log_level("err")
    with tempfile.TemporaryDirectory() as folder:
        # A system with shafts and motors has more units, and connections between `mesh` and them.
        ssp = write_ssp(Path(folder, "gears.ssp"), {"mesh": fmu})
        with EcosSimulation(step, ssp_path=str(ssp)) as running:
            yield running


@contextmanager
def resting(fmu, values, step):
    """A function that makes one step with the inputs at rest, those in `values` not at their start."""
    with simulation(fmu, step) as running:
        running.init()
        for name, value in values.items():
            running.set_real(f"mesh::{name}", value)
        yield running.step


def co_simulation(fmu, scenario, outputs):
    rows = []
    with simulation(fmu, float(scenario.times[1] - scenario.times[0])) as running:
        running.init()
        for row in scenario.values[:-1]:
            for name, value in zip(scenario.names, row):
                running.set_real(f"mesh::{name}", float(value))
            running.step()
            rows.append([running.get_real(f"mesh::{name}") for name in outputs])
    return np.array(rows)
