"""What `make release` left in target/dist, and wine to run the half for Windows in."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DIST = ROOT / "target" / "dist"
COARSE = ["--refinement", "coarse", "--no-center-distance", "--no-misalignment"]
# Turns gear 2 of an FMU onto the flank and prints the moment on gear 1.
SCRIPT = """
import sys
from gearmesh import GearPair
with GearPair(sys.argv[1]) as pair:
    pair.initialize()
    pair["gear2.angles[3]"] = 1e-3
    pair.step(1e-6)
    print(repr(pair["gear1.moment[3]"]))
"""

# Wine 8 has no bcryptprimitives.dll, which Rust's standard library takes its random numbers from.
STUB = """
#include <stddef.h>
#include <windows.h>
BOOLEAN NTAPI SystemFunction036(PVOID buffer, ULONG length);
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE buffer, SIZE_T length) {
    return SystemFunction036(buffer, (ULONG)length);
}
"""


@pytest.fixture(scope="session")
def wine(tmp_path_factory):
    """The environment in which `wine64` runs programs, by name for fmpy, too."""
    folder = tmp_path_factory.mktemp("wine")
    loader = shutil.which("wine64") or "/usr/lib/wine/wine64"
    assert Path(loader).exists(), "Windows' half of the release is run by wine: apt install wine64"
    (folder / "bin").mkdir()
    (folder / "bin" / "wine64").symlink_to(loader)
    environment = {
        "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "WINEPREFIX": str(folder / "prefix"),
        "WINEDEBUG": "-all",
        "WINEDLLOVERRIDES": "mscoree,mshtml=",
    }
    subprocess.run(
        ["wine64", "wineboot", "--init"], env=os.environ | environment, check=True, capture_output=True, timeout=300
    )
    source = folder / "stub.c"
    source.write_text(STUB)
    system = folder / "prefix" / "drive_c" / "windows" / "system32"
    subprocess.run(
        ["x86_64-w64-mingw32-gcc", "-shared", "-o", system / "bcryptprimitives.dll", source, "-ladvapi32"],
        check=True,
    )
    before = dict(os.environ)
    os.environ.update(environment)
    yield environment
    os.environ.clear()
    os.environ.update(before)


@dataclass(frozen=True)
class Windows:
    """A folder with a Python for Windows, fmpy and the installed wheel of the release, and wine to run its programs."""

    folder: Path
    environment: dict[str, str]

    def run(self, program, *words):
        """What the folder's `program` prints. Raises RuntimeError with its messages if it fails."""
        command = ["wine64", str(self.folder / program), *map(str, words)]
        environment = os.environ | self.environment
        # Without a console Python for Windows wants its input closed.
        done = subprocess.run(
            command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=600
        )
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout


@pytest.fixture(scope="session")
def windows(wine, tmp_path_factory):
    """A Python for Windows as windows.txt has it, and the wheel installed into it."""
    folder = tmp_path_factory.mktemp("windows")
    (wheel,) = DIST.glob("*-win_amd64.whl")
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", folder]
    platform = ["--platform", "win_amd64", "--python-version", "3.11"]
    # The one archive of the list is built by the tools of the group `release`.
    listed = ["--no-build-isolation", "--requirement", ROOT / "tests" / "release" / "windows.txt"]
    # The wheel first: both have a `bin`, and pip leaves one as it is that is there already.
    for what in ([wheel], listed):
        subprocess.run([*install, *platform, *what], check=True)
    return Windows(folder, wine)
