"""Where the examples find their units, and the place for results."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import gearmesh
import matplotlib
from gearmesh import GearPair, command, plots

matplotlib.use("Agg")

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "target" / "drivelines"
PAIRS = ROOT / "examples" / "drivelines" / "pairs"


def save(figure, name: str) -> None:
    """Writes a figure of matplotlib to target/drivelines/NAME.png."""
    plots.save(figure, OUT / f"{name}.png")


def shipped(name: str, **set: command.Value) -> Path:
    """The FMU of the tables in resources/tables, packed once, with start values."""
    tables = ROOT / "resources" / "tables" / f"{name}.json"
    return _made("-".join([name, *(f"{k}={v}" for k, v in set.items())]), tables, lambda out: gearmesh.pack(tables, out, set=set))


def local(name: str) -> Path:
    """The FMU of a pair of the examples' own, from the tables beside its pair file (examples/drivelines/pairs)."""
    tables = PAIRS / f"{name}.tables.json"
    return _made(name, tables, lambda out: gearmesh.pack(tables, out))


def built(pair: Path) -> Path:
    """The FMU of a pair file, with tables over load and mesh position on coarse finite elements."""
    options = {"refinement": "coarse", "no_center_distance": True, "no_misalignment": True}
    return _made(f"{pair.stem}-built", pair, lambda out: gearmesh.build(pair, out, **options))


@contextmanager
def opened(fmu: Path | str, parameters: Mapping[str, command.Value] | None = None, interface: str = "model-exchange") -> Iterator[GearPair]:
    """An instance of the FMU with the parameters, initialised."""
    with GearPair(fmu, parameters, interface) as pair:
        pair.initialize()
        yield pair


def _made(name: str, source: Path, make: Callable[[Path], object]) -> Path:
    """Makes an FMU unless there is one newer than what it is made of."""
    out = OUT / f"{name}.fmu"
    if not out.exists() or out.stat().st_mtime < max(s.stat().st_mtime for s in (source, command.executable())):
        OUT.mkdir(parents=True, exist_ok=True)
        # Moved into place when whole: several processes may want the same unit at once.
        beside = out.with_name(f"{out.stem}.{os.getpid()}.fmu")
        make(beside)
        beside.replace(out)
    return out
