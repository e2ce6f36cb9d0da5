"""Imposed poses for one revolution of gear 1 under load, with tilt and a moving centre distance.

Gear 1 turns at a constant speed. Gear 2 follows where the contact, at rest, bears the torque: the touching pose at
the start, which sets the phase offset, the full torque after a sixteenth of a revolution. Meanwhile gear 2 tilts out
and back and the centre distance grows and shrinks, each by a full cosine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from gearmesh import GearPair, Turning
from gearmesh.poses import cardan_axes

# A power of two, so that times are exact in binary and every host sees the same: 61 us.
STEP = 2.0**-14
TILT = 1e-4  # rad, about x and half of it about y
CENTRE_DISTANCE = 20e-6  # m
SPIN, POSITION = "gear2.angles[3]", "gear2.position[1]"


@dataclass(frozen=True)
class Scenario:
    """Inputs over time: a column for each name, a row for each of the `times`, s; other inputs keep their starts."""

    times: np.ndarray
    names: list[str]
    values: np.ndarray

    def record(self) -> np.ndarray:
        """As a structured array, which fmpy takes as input."""
        return np.rec.fromarrays([self.times, *self.values.T], names=["time", *self.names])

    def write(self, file: Path) -> None:
        """As CSV with 17 digits, which any host reads to the same bits."""
        write_table(file, ["time", *self.names], np.column_stack([self.times, self.values]))


def write_table(file: Path, names: list[str], rows: np.ndarray) -> None:
    """Numbers with 17 digits below quoted names."""
    head = ",".join(f'"{name}"' for name in names)
    np.savetxt(file, rows, fmt="%.17g", delimiter=",", header=head, comments="")


def revolution(fmu: Path, torque: float, revolutions: float = 1.0, steps: int = 1024) -> Scenario:
    """The scenario for an FMU of a pair whose gear 1 bears `torque`, N m, on its drive flank.

    `steps` rows of 61 us over `revolutions` of gear 1: the parts of it that are short turn as fast.
    """
    times = STEP * np.arange(steps + 1)
    share = np.arange(steps + 1) / steps
    turn = 2.0 * math.pi * revolutions * share
    with GearPair(fmu, interface="model-exchange") as pair:
        start = {name: pair.u[index] for name, index in pair.input.items()}
        wave = 0.5 - 0.5 * np.cos(2.0 * math.pi * share)
        angles = np.column_stack([TILT * wave, 0.5 * TILT * wave, start[SPIN] + 0.0 * wave])
        position = start[POSITION] + CENTRE_DISTANCE * wave
        pair.initialize()
        ratio, turning = pair.geometry.ratio, Turning(pair)
        for i in range(1, steps + 1):
            turning.tilt(*angles[i, :2])
            pair[POSITION] = position[i]
            wanted = torque * min(1.0, 16.0 * share[i])
            angles[i, 2] = turning.resting(-wanted / ratio, turn[i], start[SPIN] + ratio * turn[i])
    rates = (cardan_axes(angles) @ np.gradient(angles, times, axis=0)[..., None])[..., 0]
    names = ["gear1.angles[3]", "gear1.angularVelocity[3]", POSITION, "gear2.velocity[1]"]
    names += [f"gear2.{quantity}[{i}]" for quantity in ("angles", "angularVelocity") for i in (1, 2, 3)]
    speed = np.gradient(turn, times)
    return Scenario(
        times, names, np.column_stack([turn, speed, position, np.gradient(position, times), angles, rates])
    )


def reference(fmu: Path, scenario: Scenario, outputs: list[str]) -> np.ndarray:
    """Outputs that belong to each row of inputs, by `GearPair` through Model Exchange: a row for each time."""
    rows = np.empty((len(scenario.times), len(outputs)))
    with GearPair(fmu, interface="model-exchange") as pair:
        at = [pair.output[name] for name in outputs]
        indices = [pair.input[name] for name in scenario.names]
        for row, time in enumerate(scenario.times):
            for index, value in zip(indices, scenario.values[row]):
                pair.u[index] = value
            if row == 0:
                pair.initialize()
            pair.evaluate(time)
            rows[row] = [pair.y[i] for i in at]
    return rows
