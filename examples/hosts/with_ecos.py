"""Ecos, by ecospy: a master that reads the system from an SSP file (System Structure and Parameterization 1.0)."""

import tempfile
import zipfile
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

import numpy as np

from .ecos import EcosLib, EcosSimulation

VERSION = version("ecospy")

# One unit; a system with shafts and motors adds components and <Connections> between `mesh` and them.
STRUCTURE = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="gears"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription">
  <ssd:System name="gears">
    <ssd:Elements>
      <ssd:Component name="mesh" type="application/x-fmu-sharedlibrary" source="resources/mesh.fmu"/>
    </ssd:Elements>
  </ssd:System>
  <ssd:DefaultExperiment startTime="0"/>
</ssd:SystemStructureDescription>
"""


@contextmanager
def simulation(fmu, step):
    """The unit alone, in communication steps of `step` s."""
    EcosLib.set_log_level("err")
    with tempfile.TemporaryDirectory() as folder:
        ssp = Path(folder, "gears.ssp")
        with zipfile.ZipFile(ssp, "w") as archive:
            archive.writestr("SystemStructure.ssd", STRUCTURE)
            archive.write(fmu, "resources/mesh.fmu")
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
