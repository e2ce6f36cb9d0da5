"""Windows' half of the release, run by wine: the unit in fmpy and in a program in C, the command, the wheel.

fmpy and the command run as on Windows: a Python for Windows loads the library of win64 from the FMU.
"""

import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from conftest import COARSE, DIST, ROOT, SCRIPT

sys.path.insert(0, str(ROOT))

from examples.hosts import with_c  # noqa: E402
from examples.hosts.compare import outputs  # noqa: E402
from examples.hosts.scenario import reference, revolution  # noqa: E402
from gearmesh import GearPair  # noqa: E402

PAIRS = ["palermo2013", "helical-25-47", "planet-ring-27-84"]
# Windows' sin, cos and exp are not those of glibc: the last place of an angle is 1e-16 of it, and the transmission
# error is 1e-4 of the displacements whose difference it is.
BOUND = 1e-12


@pytest.fixture(scope="module", params=PAIRS)
def case(request):
    """A shipped unit, the scenario, the names of the outputs and what linux64 finds."""
    fmu = DIST / "fmus" / f"{request.param}.fmu"
    scenario, names = revolution(fmu, 100.0, 0.25, 256), outputs(fmu)
    expected = reference(fmu, scenario, names)
    assert abs(expected[-1, names.index("gear1.moment[3]")]) > 90.0
    return fmu, scenario, names, expected


def compare(what, found, expected, names):
    """Rows of Co-Simulation are one fewer: the last inputs are not held over a step."""
    assert len(found) in (len(expected) - 1, len(expected))
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-300)
    difference = (np.abs(found - expected[: len(found)]) / scale).max(axis=0)
    worst = difference.argmax()
    print(f"{what}: {difference[worst]:.1e} of {names[worst]}")
    assert difference[worst] < BOUND, names[worst]


def test_fmpy_on_windows_gives_the_results_of_linux_by_both_interfaces(windows, case, tmp_path):
    fmu, scenario, names, expected = case
    np.savez(
        tmp_path / "inputs.npz",
        times=scenario.times, inputs=scenario.names, values=scenario.values, outputs=names,
    )  # fmt: skip
    printed = windows.run("python.exe", ROOT / "tests" / "release" / "fmpy_on_windows.py", tmp_path, fmu)
    print(printed.strip())
    assert printed.strip().endswith("win64")
    for interface in ("co_simulation", "model_exchange"):
        compare(f"{fmu.stem}, fmpy, {interface}", np.load(tmp_path / f"{interface}.npy"), expected, names)


def test_a_c_program_on_windows_gives_the_results_of_linux_by_both_interfaces(wine, case):
    fmu, scenario, names, expected = case
    for kind in ("cs", "me"):
        found = with_c.run(fmu, scenario, names, kind, "win64", "x86_64-w64-mingw32-gcc", ["wine64"])
        compare(f"{fmu.stem}, C, {kind}", found, expected, names)


def test_the_installed_command_builds_a_unit_on_windows_that_the_installed_package_runs(windows, tmp_path):
    pair = ROOT / "resources" / "pairs" / "palermo2013.json"
    unit = tmp_path / "pair.fmu"
    windows.run("bin/gearmesh.exe", "build", f"Z:{pair}", "-o", f"Z:{unit}", *COARSE)
    assert {"binaries/linux64/GearMesh.so", "binaries/win64/GearMesh.dll"} <= set(zipfile.ZipFile(unit).namelist())
    moment = float(windows.run("python.exe", "-c", SCRIPT, f"Z:{unit}"))
    with GearPair(unit) as pair:
        pair.initialize()
        pair["gear2.angles[3]"] = 1e-3
        pair.step(1e-6)
        expected = pair["gear1.moment[3]"]
    assert abs(expected) > 10.0
    assert abs(moment - expected) < BOUND * abs(expected)


def test_the_command_for_windows_packs_the_units_of_the_command_for_linux(wine, tmp_path):
    tables = ROOT / "resources" / "tables" / "palermo2013.json"
    unit = tmp_path / "palermo2013.fmu"
    run = subprocess.run(
        ["wine64", DIST / "win64" / "gearmesh.exe", "pack", "--tables", f"Z:{tables}", "-o", f"Z:{unit}"],
        env=os.environ, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert "GUID" in run.stdout
    ours, theirs = (zipfile.ZipFile(f) for f in (DIST / "fmus" / unit.name, unit))
    assert ours.namelist() == theirs.namelist()
    different = [name for name in ours.namelist() if ours.read(name) != theirs.read(name)]
    # The last digits of sines differ, and the GUID is that of the contents.
    assert set(different) <= {"documentation/example-input.csv", "modelDescription.xml", "resources/unit.json"} | {
        "documentation/index.html"
    }
