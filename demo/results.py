"""Runs every scene once; page and comparison both read from here."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import scenes
from .drawing import Drawing
from .dynamics import Record
from .scenes import Files, FrequencyResponse
from .solver import Command, Cycle

TORQUES = (20, 40, 55, 70, 85, 100, 115, 130, 150, 175, 200)
SPEEDS = (200, 1000, 2000, 3000)
FULL_TILT = 3e-3
# The paper never changes the centre distance, and runs up the unmodified pair on parallel axes.
GRID = {"modified": ("--no-center-distance",), "unmodified": ("--no-center-distance", "--no-misalignment")}
PAIRS = {"modified": "palermo2013", "unmodified": "palermo2013-unmodified"}


@dataclass(frozen=True)
class Results:
    """Everything that is shown. The key `modified` is the paper's pair with its modifications."""

    drawing: Drawing
    static: dict[str, dict[int, Cycle]]  # "modified" or "unmodified", torque in N m
    slow: dict[str, Record]
    loads: dict[str, dict[int, Record]]  # "variable" or "constant" load, torque in N m
    torque_ramp: dict[str, Record]  # "variable" or "constant" load
    misalignment: dict[str, Record]  # "negative" or "positive"
    sweep: Record
    steady: dict[int, Record]  # rpm
    response: FrequencyResponse
    seconds: float


def say(text: str) -> None:
    """One line of progress."""
    print(f"demo: {text}", file=sys.stderr, flush=True)


def files_of(command: Command, root: Path, out: Path) -> dict[str, Files]:
    """Makes tables and FMU of both pairs in `out`."""
    files = {}
    for kind, name in PAIRS.items():
        pair = root / "resources" / "pairs" / f"{name}.json"
        tables, fmu = out / f"{name}.tables.json", out / f"{name}.fmu"
        say(f"tables and FMU of {name}")
        command.tables(pair, tables, *GRID[kind])
        command.pack(tables, fmu)
        files[kind] = Files(fmu, Drawing.read(pair))
    return files


def found(of: dict) -> dict:
    """The dictionary `of` with the results of its futures."""
    return {key: value.result() if isinstance(value, Future) else found(value) for key, value in of.items()}


def compute(command: Command, root: Path, out: Path) -> Results:
    """Makes the FMUs in `out` and runs all scenes, as many at a time as there are cores."""
    began = time.perf_counter()
    files = files_of(command, root, out)
    with ProcessPoolExecutor() as pool:
        try:
            return scenes_of(pool.submit, command, root, files, began)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def scenes_of(
    later: Callable[..., Future], command: Command, root: Path, files: dict[str, Files], began: float
) -> Results:
    """All scenes, each given to `later`, longest first within what is said."""
    modified, unmodified = files["modified"], files["unmodified"]
    pairs = {kind: root / "resources" / "pairs" / f"{name}.json" for kind, name in PAIRS.items()}
    static = {
        kind: {torque: later(command.solve, pair, torque) for torque in TORQUES} for kind, pair in pairs.items()
    }
    torque_ramp = {
        "variable": later(scenes.torque_ramp, modified, True),
        "constant": later(scenes.torque_ramp, modified, False),
    }
    misalignment = {
        "negative": later(scenes.misalignment_ramp, modified, -FULL_TILT),
        "positive": later(scenes.misalignment_ramp, modified, FULL_TILT),
    }
    slow = {kind: later(scenes.slow_cycles, f, f.drawing.nominal_torque) for kind, f in files.items()}
    loads = {
        kind: {t: later(scenes.slow_cycles, modified, t, kind == "variable") for t in (70, 100, 130)}
        for kind in ("variable", "constant")
    }
    sweep = later(scenes.speed_sweep, unmodified)
    frequencies = np.unique(
        np.concatenate([np.geomspace(40, 8000, 16), *map(np.array, scenes.PAPER_FREQUENCIES.values())])
    )
    response = later(scenes.frequency_response, modified, frequencies)
    steady = {rpm: later(scenes.steady_cycles, unmodified, rpm) for rpm in SPEEDS}

    say("static solves")
    static = found(static)
    say("50 rpm: aligned, torque ramp, misalignment")
    torque_ramp, misalignment, slow, loads = map(found, (torque_ramp, misalignment, slow, loads))
    say("run-up from 0 to 3000 rpm, frequency response")
    return Results(
        drawing=modified.drawing,
        static=static,
        slow=slow,
        loads=loads,
        torque_ramp=torque_ramp,
        misalignment=misalignment,
        sweep=sweep.result(),
        steady=found(steady),
        response=response.result(),
        seconds=time.perf_counter() - began,
    )
