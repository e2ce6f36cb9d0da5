"""What `make release` left in target/dist, and a Windows to run it in."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DIST = ROOT / "target" / "dist"

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
