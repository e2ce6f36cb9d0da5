"""A wheel for one platform: the command with the libraries beside it, and the package `gearmesh`."""

from __future__ import annotations

import shutil
from pathlib import Path

from .platforms import Platform
from .tools import ROOT, run

SUMMARY = "Gear contact element for multibody and system simulation: tooth contact tables and an FMI 2.0 unit"


def pack(platform: Platform, version: str, programs: Path, licenses: list[Path], out: Path) -> None:
    """Packs the folder `programs`, which holds command and libraries, into a wheel in `out`.

    Everything of `programs` goes among the scripts, since pip puts these into one folder on every
    platform, and the command looks for libraries in its own.
    """
    stage = ROOT / "target" / "wheel" / platform.name
    shutil.rmtree(stage, ignore_errors=True)
    package, scripts, about = (
        stage / "gearmesh",
        stage / f"gearmesh-{version}.data" / "scripts",
        stage / f"gearmesh-{version}.dist-info",
    )
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "python" / "gearmesh", package, ignore=ignored)
    shutil.copytree(programs, scripts)
    (about / "licenses").mkdir(parents=True)
    for file in licenses:
        shutil.copy(file, about / "licenses")
    names = "".join(f"License-File: {file.name}\n" for file in licenses)
    (about / "METADATA").write_text(
        f"Metadata-Version: 2.4\nName: gearmesh\nVersion: {version}\nSummary: {SUMMARY}\n"
        f"License-Expression: MIT OR Apache-2.0\n{names}"
        "Requires-Python: >=3.11\nRequires-Dist: fmpy>=0.3.20\n"
        "Description-Content-Type: text/markdown\n\n"
        # Pictures and pages are beside the sources alone.
        + "\n".join(line for line in (ROOT / "README.md").read_text().split("\n") if not line.startswith("!["))
    )
    (about / "WHEEL").write_text(
        "Wheel-Version: 1.0\nGenerator: gearmesh scripts/release\nRoot-Is-Purelib: false\n"
        f"Tag: py3-none-{platform.wheel}\n"
    )
    run("python", "-m", "wheel", "pack", stage, "--dest-dir", out)
