"""Runs every scene once; page and comparison both read from here."""

from __future__ import annotations

import sys
import time
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


def static_cycles(command: Command, root: Path) -> dict[str, dict[int, Cycle]]:
    """Static transmission error of both pairs over the torque."""
    say("static solves")
    return {
        kind: {
            torque: command.solve(root / "resources" / "pairs" / f"{name}.json", torque)
            for torque in TORQUES
        }
        for kind, name in PAIRS.items()
    }


def compute(command: Command, root: Path, out: Path) -> Results:
    """Makes the FMUs in `out` and runs all scenes."""
    began = time.perf_counter()
    files = files_of(command, root, out)
    static = static_cycles(command, root)
    modified, unmodified = files["modified"], files["unmodified"]
    say("50 rpm: aligned, torque ramp, misalignment")
    slow = {kind: scenes.slow_cycles(f, f.drawing.nominal_torque) for kind, f in files.items()}
    loads = {
        "variable": {t: scenes.slow_cycles(modified, t, True) for t in (70, 100, 130)},
        "constant": {t: scenes.slow_cycles(modified, t, False) for t in (70, 100, 130)},
    }
    torque_ramp = {
        "variable": scenes.torque_ramp(modified, True),
        "constant": scenes.torque_ramp(modified, False),
    }
    misalignment = {
        "negative": scenes.misalignment_ramp(modified, -FULL_TILT),
        "positive": scenes.misalignment_ramp(modified, FULL_TILT),
    }
    say("run-up from 0 to 3000 rpm")
    sweep = scenes.speed_sweep(unmodified)
    steady = {rpm: scenes.steady_cycles(unmodified, rpm) for rpm in SPEEDS}
    say("frequency response")
    frequencies = np.unique(
        np.concatenate(
            [np.geomspace(40, 8000, 16), *map(np.array, scenes.PAPER_FREQUENCIES.values())]
        )
    )
    response = scenes.frequency_response(modified, frequencies)
    return Results(
        drawing=modified.drawing,
        static=static,
        slow=slow,
        loads=loads,
        torque_ramp=torque_ramp,
        misalignment=misalignment,
        sweep=sweep,
        steady=steady,
        response=response,
        seconds=time.perf_counter() - began,
    )
