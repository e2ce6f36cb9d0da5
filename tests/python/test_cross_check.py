"""The cross-check material of three pairs, written by its command, against fmpy's own simulation."""

import subprocess
import sys

import gearmesh
import numpy as np
import pytest
from conftest import ROOT, TABLES
from fmpy import simulate_fmu
from fmpy.util import read_csv

PAIRS = ["palermo2013", "helical-25-47", "planet-ring-27-84"]
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


@pytest.fixture(scope="module")
def material(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cross-check")
    fmus = [gearmesh.pack(TABLES / f"{pair}.json", folder / f"{pair}.fmu", set={"coupling": "held"}) for pair in PAIRS]
    command = [sys.executable, "-m", "scripts.release.cross_check", *fmus, "--out", folder / "out"]
    subprocess.run(command, cwd=ROOT, check=True)
    return folder / "out"


@pytest.mark.parametrize("interface", KINDS)
@pytest.mark.parametrize("pair", PAIRS)
def test_fmpy_finds_the_outputs_of_the_reference(material, pair, interface):
    (folder,) = material.glob(f"2.0/{interface}/linux64/gearmesh/*/{pair}")
    assert {p.name for p in folder.iterdir()} == {
        "README.md", *(f"{pair}{end}" for end in (".fmu", "_in.csv", "_ref.csv", "_ref.opt"))
    }  # fmt: skip
    assert max(differences(folder, interface).values()) == 0.0
