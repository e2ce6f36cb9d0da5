"""Runs every scene once; page and comparison both read from here."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import gearmesh
import numpy as np
from gearmesh import GearPair, Geometry, History, MeshCycle, RunUp

from . import scenes
from .scenes import FrequencyResponse

TORQUES = (20, 40, 55, 70, 85, 100, 115, 130, 150, 175, 200)
SPEEDS = (200, 1000, 2000, 3000)
FULL_TILT = 3e-3 * (1.0 - 1e-9)  # within the tables, whatever the last digit
# The paper never changes the centre distance, and runs up the unmodified pair on parallel axes.
GRID = {"modified": {"no_center_distance": True}, "unmodified": {"no_center_distance": True, "no_misalignment": True}}
PAIRS = {"modified": "palermo2013", "unmodified": "palermo2013-unmodified"}


@dataclass(frozen=True)
class Results:
    """Everything that is shown. The key `modified` is the paper's pair with its modifications."""

    geometry: Geometry
    static: dict[str, dict[int, MeshCycle]]  # "modified" or "unmodified", torque in N m
    resonance: RunUp
    slow: dict[str, History]
    loads: dict[str, dict[int, History]]  # "variable" or "constant" load, torque in N m
    torque_ramp: dict[str, History]  # "variable" or "constant" load
    misalignment: dict[str, History]  # "negative" or "positive"
    steady: dict[int, History]  # rpm
    response: FrequencyResponse
    seconds: float


def say(text: str) -> None:
    """One line of progress."""
    print(f"demo: {text}", file=sys.stderr, flush=True)


def found(of: dict) -> dict:
    """The dictionary `of` with the results of its futures."""
    return {key: value.result() if isinstance(value, Future) else found(value) for key, value in of.items()}


def compute(root: Path, out: Path, model: dict) -> Results:
    """Makes the FMUs in `out` with the options `model` and runs all scenes, as many at a time as there are cores."""
    began = time.perf_counter()
    pairs = {kind: root / "resources" / "pairs" / f"{name}.json" for kind, name in PAIRS.items()}
    units = {}
    for kind, pair in pairs.items():
        say(f"tables and unit of {pair.stem}")
        units[kind] = gearmesh.build(pair, out / f"{pair.stem}.fmu", **GRID[kind], **model)
    say("report and static solves")
    report = out / "report.html"
    options = [f"--{name.replace('_', '-')}={value}" for name, value in model.items() if value is not None]
    gearmesh.command.run("report", pairs["modified"], "--output", report, "--figures", out / "report", *options)
    static = {kind: dict(zip(TORQUES, gearmesh.solve_all(pair, TORQUES, **model))) for kind, pair in pairs.items()}
    with ProcessPoolExecutor() as pool:
        try:
            return scenes_of(pool.submit, units, static, began)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def scenes_of(later: Callable[..., Future], units: dict[str, Path], static: dict[str, dict[int, MeshCycle]], began: float) -> Results:
    """All scenes, each given to `later`, longest first."""
    modified, unmodified = units["modified"], units["unmodified"]
    with GearPair(modified) as pair:
        geometry = pair.geometry
    frequencies = np.unique(np.concatenate([np.geomspace(40, 8000, 16), *map(np.array, scenes.PAPER_FREQUENCIES.values())]))
    resonance = later(scenes.resonant_run_up, unmodified)
    torque_ramp = {kind: later(scenes.torque_ramp, modified, kind == "variable") for kind in ("variable", "constant")}
    misalignment = {
        kind: later(scenes.misalignment_ramp, modified, end) for kind, end in (("negative", -FULL_TILT), ("positive", FULL_TILT))
    }
    response = later(scenes.frequency_response, modified, geometry.pitch_radii[1], frequencies)
    slow = {kind: later(scenes.slow_cycles, unit, scenes.TORQUE) for kind, unit in units.items()}
    loads = {
        kind: {t: later(scenes.slow_cycles, modified, t, kind == "variable") for t in (70, 100, 130)} for kind in ("variable", "constant")
    }
    steady = {rpm: later(scenes.steady_cycles, unmodified, rpm) for rpm in SPEEDS}
    say("run-ups, 50 rpm under torque and misalignment, frequency response")
    return Results(
        geometry, static, resonance.result(), *map(found, (slow, loads, torque_ramp, misalignment)),
        found(steady), response.result(), time.perf_counter() - began,
    )  # fmt: skip
