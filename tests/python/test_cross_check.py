"""The cross-check material of three pairs, written by its command, against fmpy's own simulation."""

import subprocess
import sys

import gearmesh
import pytest
from conftest import ROOT, TABLES
from cross_check import KINDS, differences

PAIRS = ["palermo2013", "helical-25-47", "planet-ring-27-84"]


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
