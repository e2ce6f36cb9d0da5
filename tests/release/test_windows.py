"""Windows' half of the release, run by wine: the unit in a program for Windows, and the command.

fmpy's own server for Windows ends by itself after a second in wine, so the host is that of examples/hosts.
"""

import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from conftest import DIST, ROOT

sys.path.insert(0, str(ROOT))

from examples.hosts.compare import outputs  # noqa: E402
from examples.hosts.scenario import reference, revolution  # noqa: E402
from examples.hosts.with_c import run  # noqa: E402

# Windows' sin, cos and exp are not those of glibc: the last place of an angle is 1e-16 of it, and the transmission
# error is 1e-4 of the displacements whose difference it is.
BOUND = 1e-12


@pytest.mark.parametrize("pair", ["palermo2013", "helical-25-47", "planet-ring-27-84"])
def test_windows_gives_the_results_of_linux_by_both_interfaces(wine, pair):
    fmu = DIST / "fmus" / f"{pair}.fmu"
    scenario, names = revolution(fmu, 100.0, 0.25, 256), outputs(fmu)
    expected = reference(fmu, scenario, names)
    assert abs(expected[-1, names.index("gear1.moment[3]")]) > 90.0
    for kind in ("cs", "me"):
        found = run(fmu, scenario, names, kind, "win64", "x86_64-w64-mingw32-gcc", ["wine64"])
        difference = np.abs(found - expected).max(axis=0) / np.maximum(np.abs(expected).max(axis=0), 1e-300)
        worst = difference.argmax()
        print(f"{pair} {kind}: {difference[worst]:.1e} of {names[worst]}")
        assert difference[worst] < BOUND, names[worst]


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
