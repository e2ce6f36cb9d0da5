"""The command line as the demo uses it: static solves, tables and packing."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Cycle:
    """One quasi-static mesh cycle on the line of action, as `gearmesh solve --json` prints it."""

    mesh_position: np.ndarray
    ste: np.ndarray  # m
    contact_z: np.ndarray  # m
    mean: float  # m
    peak_to_peak: float  # m


class Command:
    """The command `gearmesh`. What it says on standard error goes to the user's terminal."""

    def __init__(self, executable: Path, model: Sequence[object] = ()):
        """`model` are options for every subcommand that solves contact, such as `--refinement coarse`."""
        self._executable = str(executable)
        self._model = list(model)

    def _run(self, *arguments: object) -> str:
        command = [self._executable, *map(str, arguments)]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout

    def tables(self, pair: Path, out: Path, *options: object) -> None:
        """Tables of a pair file."""
        self._run("tables", pair, "-o", out, *options, *self._model)

    def pack(self, tables: Path, out: Path) -> None:
        """An FMU from tables."""
        self._run("pack", "--tables", tables, "-o", out)

    def solve(self, pair: Path, torque: float, *options: object) -> Cycle:
        """One mesh cycle under `torque` N m on gear 1."""
        text = self._run("solve", pair, "--torque-nm", torque, "--json", *options, *self._model)
        result = json.loads(text)
        return Cycle(
            mesh_position=np.array(result["mesh_position"]),
            ste=np.array(result["ste_loa_um"]) * 1e-6,
            contact_z=np.array(result["contact_z_mm"]) * 1e-3,
            mean=result["mean_ste_loa_um"] * 1e-6,
            peak_to_peak=result["peak_to_peak_ste_loa_um"] * 1e-6,
        )
