"""What a release brings: its needs, what the wheel says of itself, the cross-check material against fmpy's own simulation."""

import os
import re
import subprocess
import sys
from textwrap import dedent

import gearmesh
import numpy as np
import pytest
from conftest import GEARMESH, ROOT, TABLES
from fmpy import simulate_fmu
from fmpy.util import read_csv
from scripts.release import cross_check
from scripts.release.wheel import description

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
    cross_check.material(fmus, folder / "out")
    return folder / "out"


@pytest.mark.parametrize("interface", KINDS)
@pytest.mark.parametrize("pair", PAIRS)
def test_fmpy_finds_the_outputs_of_the_reference(material, pair, interface):
    (folder,) = material.glob(f"2.0/{interface}/linux64/gearmesh/*/{pair}")
    assert {p.name for p in folder.iterdir()} == {
        "README.md", *(f"{pair}{end}" for end in (".fmu", "_in.csv", "_ref.csv", "_ref.opt"))
    }  # fmt: skip
    assert max(differences(folder, interface).values()) == 0.0


def test_the_description_names_nothing_that_the_wheel_does_not_hold():
    text = description()
    assert not re.findall(r"\]\((?!https://)", text)
    for place in ("docs/", "resources/", "demo/", "examples/", ".venv", "make ", ".md"):
        assert place not in text, place


@pytest.mark.slow
def test_the_commands_and_the_script_of_the_description_run(tmp_path):
    text = description()
    (commands,) = re.findall(r"```sh\n(.*?)```", text, re.S)
    path = f"{GEARMESH.parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "XDG_CACHE_HOME": str(tmp_path)}
    subprocess.run(["sh", "-e", "-c", commands], cwd=tmp_path, env=environment, check=True, stdout=subprocess.DEVNULL)
    (script,) = re.findall(r"^    from gearmesh.*?(?=^\S)", text, re.S | re.M)
    subprocess.run([sys.executable, "-c", dedent(script)], cwd=tmp_path, check=True)


def test_what_is_missing_is_named_with_nothing_but_python():
    run = subprocess.run(
        [sys.executable, "-S", "-m", "scripts.release.platforms"],
        cwd=ROOT, env={"PATH": "/nowhere"}, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode != 0
    assert run.stderr.startswith("release: missing\n") and "Rust" in run.stderr, run.stderr


def test_it_is_the_first_that_make_runs():
    lines = subprocess.run(
        ["make", "--no-print-directory", "-n", "release"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.splitlines()
    assert lines[0].endswith("-m scripts.release.platforms"), lines[0]
