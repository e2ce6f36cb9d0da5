"""All hosts on one scenario, each against `GearPair`."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np

from .scenario import Scenario, reference

HOSTS = {
    "fmpy": "fmpy",
    "fmi_sim": "fmi-sim",
    "libcosim": "libcosim by libcosimpy",
    "ecos": "Ecos by ecospy, from an SSP file",
    "exudyn": "Exudyn",
    "mujoco": "MuJoCo",
    "c": "a C program, by gcc",
}


@dataclass(frozen=True)
class Result:
    """What one host found through one interface."""

    version: str
    interface: str
    rows: int
    difference: float  # largest, in units of each output's largest value


def outputs(fmu: Path) -> list[str]:
    """Every Real output."""
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    return [v.name for v in variables if v.causality == "output" and v.type == "Real"]


def run(host: str, fmu: Path, scenario: Scenario) -> list[Result]:
    """The host's interfaces on the scenario. Raises ImportError where the host is not installed."""
    module = importlib.import_module(f".with_{host}", __package__)
    names = outputs(fmu)
    expected = reference(fmu, scenario, names)
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-300)
    found = []
    for interface in ("co_simulation", "model_exchange"):
        if function := getattr(module, interface, None):
            rows = function(fmu, scenario, names)
            if len(rows) < len(expected) - 1:
                raise ValueError(f"{host} returned {len(rows)} rows of {len(expected)}")
            difference = float((np.abs(rows - expected[: len(rows)]) / scale).max())
            found.append(Result(module.VERSION, interface, len(rows), difference))
    return found
