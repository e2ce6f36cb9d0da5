"""Where the examples find the command, their units and the place for results."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "target" / "drivelines"
PAIRS = Path(__file__).parent / "pairs"
GEARMESH = ROOT / "target" / "release" / "gearmesh"


def save(figure, name: str) -> None:
    """Writes a figure of matplotlib to target/drivelines/NAME.png."""
    OUT.mkdir(parents=True, exist_ok=True)
    figure.tight_layout()
    figure.savefig(OUT / f"{name}.png", dpi=80)


def shipped(name: str, *settings: str) -> Path:
    """The unit of the tables in resources/tables, packed once, with settings `NAME=VALUE`."""
    options = [f"--set={setting}" for setting in settings]
    return _made("-".join([name, *settings]), "pack", "--tables", ROOT / "resources" / "tables" / f"{name}.json", *options)


def local(name: str) -> Path:
    """The unit of a pair of the examples' own, from the tables beside its pair file (examples/drivelines/pairs)."""
    return _made(name, "pack", "--tables", PAIRS / f"{name}.tables.json")


def built(pair: Path) -> Path:
    """The unit of a pair file, with tables over load and mesh position on coarse finite elements."""
    return _made(f"{pair.stem}-built", "build", pair, "--refinement", "coarse", "--no-center-distance", "--no-misalignment", "-q")


def _made(name: str, command: str, *arguments: object) -> Path:
    """Runs the command unless its result is newer than what it is made of."""
    out = OUT / f"{name}.fmu"
    sources = [GEARMESH, *(a for a in arguments if isinstance(a, Path))]
    if not out.exists() or out.stat().st_mtime < max(s.stat().st_mtime for s in sources):
        OUT.mkdir(parents=True, exist_ok=True)
        # Moved into place when whole: several processes may want the same unit at once.
        beside = out.with_name(f"{out.stem}.{os.getpid()}.fmu")
        run = [str(a) for a in (GEARMESH, command, *arguments, "-o", beside)]
        subprocess.run(run, check=True, stdout=subprocess.PIPE)
        beside.replace(out)
    return out
