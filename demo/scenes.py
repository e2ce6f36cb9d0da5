"""The paper's simulations, each through the FMU: one function, one figure or two."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from gearmesh import GearPair

from .drawing import Drawing
from .dynamics import (
    DAMPING,
    INERTIA_OF_GEAR2,
    Record,
    constant_speed,
    ramp,
    run,
    run_up,
)

SLOW_RPM = 50.0
# Between both time constants: well above c/m = 2.5 us (the linearly implicit step may be), well below
# c/k = 0.23 ms and 1/2000 of a mesh cycle at 50 rpm.
IMPLICIT_STEP = 2e-5
# Below 2 c/m = 5 us, where a force held over the step stays stable.
EXPLICIT_STEP = 2e-6
SETTLING = 0.02  # s, some 80 time constants c/k

CONSTANT_STIFFNESS = 4.35e8  # N/m, tangential: what the gains of Table 2 ask for

# The paper's formulation with every effect off; a scene switches on what it shows. One flank, as in the paper: its
# pair has no backlash, so that with both a tilted gear would jam.
PAPER = {
    "coupling": "held",  # the loop corrects the loads itself
    "formulation": "paper",
    "loadedFlank": "drive",
    "damping": DAMPING,
    "centerDistanceEffect": False,
    "misalignmentEffect": False,
    "shuttlingEffect": False,
}
PAPER_FREQUENCIES = {200: (66, 133, 200, 266, 333), 3000: (1000, 2000, 3000, 4000, 5000)}
PAPER_GAINS = {200: (0.99, 0.98, 0.96, 0.93, 0.90), 3000: (0.57, 0.33, 0.23, 0.17, 0.14)}


@dataclass(frozen=True)
class Files:
    """FMU and drawing of one pair."""

    fmu: Path
    drawing: Drawing


def simulate(files: Files, choices: dict, **scene) -> Record:
    """One run of the unit in the paper's formulation with these choices of parameters."""
    with GearPair(files.fmu, PAPER | choices) as pair:
        pair.initialize()
        return run(pair, files.drawing, **scene)


def slow_cycles(files: Files, torque: float, load_dependent: bool = True, cycles: int = 3) -> Record:
    """Whole mesh cycles at 50 rpm, aligned, under a constant torque."""
    period = 60.0 / (SLOW_RPM * files.drawing.teeth[0])
    record = simulate(
        files,
        {"stiffnessModel": "table", "loadDependent": load_dependent},
        gear1=constant_speed(SLOW_RPM),
        torque=lambda t: torque,
        duration=(cycles + 1) * period,
        step=IMPLICIT_STEP,
    )
    return record.after(period)


def torque_ramp(files: Files, load_dependent: bool, duration: float = 2.4) -> Record:
    """70 to 130 N m at 50 rpm (Fig. 19)."""
    record = simulate(
        files,
        {"stiffnessModel": "table", "loadDependent": load_dependent},
        gear1=constant_speed(SLOW_RPM),
        torque=ramp(70.0, 130.0, SETTLING, duration),
        duration=duration,
        step=IMPLICIT_STEP,
        record_every=4,
    )
    return record.after(SETTLING)


def misalignment_ramp(files: Files, end: float, duration: float = 2.4) -> Record:
    """Misalignment from 0 to `end` rad at 50 rpm and nominal torque (Fig. 21 to 23)."""
    record = simulate(
        files,
        {
            "stiffnessModel": "table",
            "loadDependent": True,
            "misalignmentEffect": True,
            "shuttlingEffect": True,
        },
        gear1=constant_speed(SLOW_RPM),
        torque=lambda t: files.drawing.nominal_torque,
        misalignment=ramp(0.0, end, SETTLING, duration),
        duration=duration,
        step=IMPLICIT_STEP,
        record_every=4,
    )
    return record.after(SETTLING)


def speed_sweep(files: Files, duration: float = 1.2) -> Record:
    """Run-up from 0 to 3000 rpm in one continuous sweep, constant load, explicit (Fig. 15, 17)."""
    record = simulate(
        files,
        {"stiffnessModel": "table", "loadDependent": False},
        gear1=run_up(3000.0, duration),
        torque=lambda t: files.drawing.nominal_torque,
        duration=duration,
        step=EXPLICIT_STEP,
        explicit=True,
        record_every=5,
    )
    return record.after(SETTLING)


def steady_cycles(files: Files, rpm: float, cycles: int = 2) -> Record:
    """The last whole mesh cycles at a constant speed, constant load, explicit."""
    period = 60.0 / (rpm * files.drawing.teeth[0])
    settling = period * math.ceil(SETTLING / period)
    record = simulate(
        files,
        {"stiffnessModel": "table", "loadDependent": False},
        gear1=constant_speed(rpm),
        torque=lambda t: files.drawing.nominal_torque,
        duration=settling + cycles * period,
        step=EXPLICIT_STEP,
        explicit=True,
    )
    return record.after(settling)


@dataclass(frozen=True)
class FrequencyResponse:
    """Dynamic over static transmission error, measured through the FMU and in closed form."""

    frequency: np.ndarray  # Hz
    measured: np.ndarray
    closed_form: np.ndarray


def linear_gain(frequency, drawing: Drawing) -> np.ndarray:
    """|H| = k / |k - m w^2 + i c w| with gear 2's inertia reduced to its pitch circle."""
    omega = 2.0 * math.pi * np.asarray(frequency, dtype=float)
    mass = INERTIA_OF_GEAR2 / drawing.pitch_radii[1] ** 2
    k = CONSTANT_STIFFNESS
    return k / np.hypot(k - mass * omega**2, DAMPING * omega)


def frequency_response(files: Files, frequencies: np.ndarray) -> FrequencyResponse:
    """Gear 1 at rest, constant stiffness, a torque that oscillates about the nominal one (Fig. 16)."""
    choices = {"stiffnessModel": "constant", "constantStiffness": CONSTANT_STIFFNESS}
    mean = files.drawing.nominal_torque
    amplitude = 0.2 * mean
    static = amplitude / files.drawing.pitch_radii[1] / CONSTANT_STIFFNESS
    measured = []
    for frequency in frequencies:
        omega = 2.0 * math.pi * frequency
        period = 1.0 / frequency
        settling = period * math.ceil(10e-3 / period)  # 40 time constants c/k
        # A whole number of steps per period, so that the Fourier sum below is over whole periods.
        step = period / math.ceil(period / EXPLICIT_STEP)
        cycles = max(1, round(4e-3 / period))
        record = simulate(
            files,
            choices,
            gear1=lambda t: (0.0, 0.0),
            torque=lambda t: mean + amplitude * math.sin(omega * t),
            duration=settling + cycles * period,
            step=step,
            explicit=True,
        )
        count = cycles * round(period / step)
        tail = record["mesh.transmissionError"][-count:]
        time = record.time[-count:]
        measured.append(2.0 / count * abs(np.sum(tail * np.exp(-1j * omega * time))) / static)
    return FrequencyResponse(
        frequency=np.asarray(frequencies, dtype=float),
        measured=np.array(measured),
        closed_form=linear_gain(frequencies, files.drawing),
    )


def cycle_harmonics(record: Record, column: str, cycles: int, count: int = 5) -> np.ndarray:
    """Amplitudes of the first harmonics of the mesh cycle over the last `cycles` of a steady run."""
    values, time = record[column], record.time
    span = time[-1] - time[0] + (time[1] - time[0])
    base = 2.0 * math.pi * cycles / span
    return np.array(
        [2.0 / len(time) * abs(np.sum(values * np.exp(-1j * n * base * time))) for n in range(1, count + 1)]
    )


def cycles_of(record: Record) -> list[slice]:
    """Slices of the whole mesh cycles in a record, cut where the mesh position wraps."""
    cuts = np.flatnonzero(np.abs(np.diff(record["mesh.position"])) > 0.5) + 1
    return [slice(int(a), int(b)) for a, b in zip(cuts[:-1], cuts[1:])]


def per_cycle(record: Record, column: str, along: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean of `along`, mean and peak-to-peak of `column`, for every whole mesh cycle."""
    spans = cycles_of(record)
    values = record[column]
    return (
        np.array([along[s].mean() for s in spans]),
        np.array([values[s].mean() for s in spans]),
        np.array([np.ptp(values[s]) for s in spans]),
    )
