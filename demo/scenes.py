"""The paper's simulations, each through the FMU: one function, one figure or two.

Gear 1 turns as imposed, gear 2 on a rigid revolute joint; its inertia is integrated outside the FMU.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import gearmesh
import numpy as np
from gearmesh import GearPair, History, RunUp, Turning, cosimulate

# Of the paper's Table 2 (0.25 kg on the pitch circle) and section 6.
INERTIA_OF_GEAR2 = 4.213e-4  # kg m^2
DAMPING = 1e5  # N s/m, tangential: 4.8 times critical
TORQUE = 100.0  # N m on gear 1, nominal; as much on gear 2, which has as many teeth
SLOW_RPM = 50.0
# Between both time constants: well above c/m = 2.5 us (the linearly implicit step may be), well below
# c/k = 0.23 ms and 1/2000 of a mesh cycle at 50 rpm.
IMPLICIT_STEP = 2e-5
# Below 2 m/c = 5 us, where a force held over the step stays stable.
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
VARIABLE_LOAD = {"stiffnessModel": "table", "loadDependent": True}
CONSTANT_LOAD = {"stiffnessModel": "table", "loadDependent": False}
PAPER_FREQUENCIES = {200: (66, 133, 200, 266, 333), 3000: (1000, 2000, 3000, 4000, 5000)}
PAPER_GAINS = {200: (0.99, 0.98, 0.96, 0.93, 0.90), 3000: (0.57, 0.33, 0.23, 0.17, 0.14)}

DTE = "mesh.transmissionError"
RECORDED = (DTE, "mesh.position", "mesh.normalForce", "mesh.contactZ", "mesh.misalignment")

# The run-up at a usual damping ratio and backlash: both gears with what turns with them, which brings the resonance below
# 10 000 rpm.
RESONANT_INERTIAS = (4e-3, 4e-3)  # kg m^2
RESONANT_DAMPING = 0.03
RESONANT_SPEEDS = (2500.0, 12000.0)  # rpm
RESONANT_BACKLASH = 80e-6  # m, circumferential; the paper's pair has none

Motion = Callable[[float], float]


def simulate(
    unit: Path,
    choices: dict,
    rpm: float,
    *,
    duration: float,
    step: float,
    torque: Motion = lambda t: TORQUE,
    misalignment: Motion | None = None,
    every: int = 1,
) -> History:
    """Runs the pair from angle zero, which is the touching pose without load, gear 1 at a constant speed; signals are in SI.

    `torque(t)` acts on gear 2 (against the drive flank when positive), `misalignment(t)` tilts gear 2 in the plane of action,
    changing so slowly that its own rate is left out.

    The pair is overdamped: the fast root is c/m = 4e5 1/s. Below 2 m/c = 5 us the force of one step is held over the next. A longer
    step is linearly implicit: the moment at the predicted pose is corrected by its derivatives, which the FMU gives as `mesh.stiffness`
    and as the damping, so that the step need only resolve the mesh cycle.
    """
    with GearPair(unit, PAPER | choices) as pair:
        pair.initialize()
        turning, y, geometry = Turning(pair, step), pair.y, pair.geometry
        stiffness, force = pair.output["mesh.stiffness"], pair.output["mesh.tangentialForce"]
        recorded = [pair.output[name] for name in RECORDED]
        squared = geometry.pitch_radii[1] ** 2
        speed_of_gear1 = rpm * math.pi / 30.0
        implicit = step > 2.0 * INERTIA_OF_GEAR2 / squared / DAMPING

        def place(time: float, state: tuple[float, float]) -> None:
            time += step
            if misalignment is not None:
                turning.tilt(*geometry.tilt_of_gear2(misalignment(time)))
            turning.place(speed_of_gear1 * time, speed_of_gear1, state[0] + step * state[1], state[1])

        def advance(time: float, state: tuple[float, float]) -> tuple[float, float]:
            inertia = INERTIA_OF_GEAR2
            if implicit and y[force] > 0.0:
                inertia += squared * step * (DAMPING + step * y[stiffness])
            speed = state[1] + step * (torque(time + step) + turning.moments()[1]) / inertia
            return state[0] + step * speed, speed

        start = (0.0, geometry.ratio * speed_of_gear1)
        rows = [
            (time + step, *(y[i] for i in recorded))
            for n, (time, _) in enumerate(cosimulate(pair, place, advance, start, step, round(duration / step)), 1)
            if n % every == 0
        ]
    time, *columns = np.array(rows).T
    return History(time, speed_of_gear1 * time, np.full(len(time), rpm), dict(zip(RECORDED, columns)))


def after(history: History, start: float) -> History:
    """The part from time `start` on."""
    return history.cut(history.time_s >= start)


def ramp(start: float, end: float, duration: float) -> Motion:
    """From `start` to `end` linearly after the settling time, until `duration`."""
    return lambda t: start + (end - start) * min(max((t - SETTLING) / (duration - SETTLING), 0.0), 1.0)


def slow_cycles(unit: Path, torque: float, load_dependent: bool = True, cycles: int = 3) -> History:
    """Whole mesh cycles at 50 rpm, aligned, under a constant torque."""
    period = 60.0 / (SLOW_RPM * 20)
    choices = VARIABLE_LOAD if load_dependent else CONSTANT_LOAD
    history = simulate(unit, choices, SLOW_RPM, torque=lambda t: torque, duration=(cycles + 1) * period, step=IMPLICIT_STEP)
    return after(history, period)


def torque_ramp(unit: Path, load_dependent: bool, duration: float = 2.4) -> History:
    """70 to 130 N m at 50 rpm (Fig. 19)."""
    choices, torque = VARIABLE_LOAD if load_dependent else CONSTANT_LOAD, ramp(70.0, 130.0, duration)
    return after(simulate(unit, choices, SLOW_RPM, torque=torque, duration=duration, step=IMPLICIT_STEP, every=4), SETTLING)


def misalignment_ramp(unit: Path, end: float, duration: float = 2.4) -> History:
    """Misalignment from 0 to `end` rad at 50 rpm and nominal torque (Fig. 22, 23)."""
    choices, tilt = VARIABLE_LOAD | {"misalignmentEffect": True, "shuttlingEffect": True}, ramp(0.0, end, duration)
    return after(simulate(unit, choices, SLOW_RPM, misalignment=tilt, duration=duration, step=IMPLICIT_STEP, every=4), SETTLING)


def steady_cycles(unit: Path, rpm: float, cycles: int = 2) -> History:
    """The last whole mesh cycles at a constant speed, constant load, explicit (Fig. 15, 17)."""
    period = 60.0 / (rpm * 20)
    settling = period * math.ceil(SETTLING / period)
    history = simulate(unit, CONSTANT_LOAD, rpm, duration=settling + cycles * period, step=EXPLICIT_STEP)
    return history.cut(slice(-round(cycles * period / EXPLICIT_STEP), None))


def resonant_run_up(unit: Path) -> RunUp:
    """Both gears free under the nominal torque, through the resonance and back: the FMU as packed, but for its backlash."""
    return gearmesh.run_up(
        unit, RESONANT_INERTIAS, RESONANT_DAMPING, TORQUE, RESONANT_SPEEDS, sweep_s=0.6, parameters={"backlash": RESONANT_BACKLASH}
    )


@dataclass(frozen=True)
class FrequencyResponse:
    """Dynamic over static transmission error, measured through the FMU and in closed form."""

    frequency: np.ndarray  # Hz
    measured: np.ndarray
    closed_form: np.ndarray


def linear_gain(frequency, radius: float) -> np.ndarray:
    """|H| = k / |k - m w^2 + i c w| with gear 2's inertia reduced to its pitch circle of `radius`, m."""
    omega = 2.0 * math.pi * np.asarray(frequency, dtype=float)
    k = CONSTANT_STIFFNESS
    return k / np.hypot(k - INERTIA_OF_GEAR2 / radius**2 * omega**2, DAMPING * omega)


def frequency_response(unit: Path, radius: float, frequencies: np.ndarray) -> FrequencyResponse:
    """Gear 1 at rest, constant stiffness, a torque that oscillates about the nominal one (Fig. 16)."""
    choices = {"stiffnessModel": "constant", "constantStiffness": CONSTANT_STIFFNESS}
    amplitude = 0.2 * TORQUE
    static = amplitude / radius / CONSTANT_STIFFNESS
    measured = []
    for frequency in frequencies:
        omega, period = 2.0 * math.pi * frequency, 1.0 / frequency
        settling = period * math.ceil(10e-3 / period)  # 40 time constants c/k
        # A whole number of steps per period, so that the Fourier sum below is over whole periods.
        step = period / math.ceil(period / EXPLICIT_STEP)
        cycles = max(1, round(4e-3 / period))
        history = simulate(
            unit, choices, 0.0, torque=lambda t: TORQUE + amplitude * math.sin(omega * t),
            duration=settling + cycles * period, step=step,
        )  # fmt: skip
        tail = history.cut(slice(-cycles * round(period / step), None))
        measured.append(2.0 * abs(np.mean(tail[DTE] * np.exp(-1j * omega * tail.time_s))) / static)
    frequency = np.asarray(frequencies, dtype=float)
    return FrequencyResponse(frequency, np.array(measured), linear_gain(frequency, radius))


def cycle_harmonics(history: History, column: str, cycles: int, count: int = 5) -> np.ndarray:
    """Amplitudes of the first harmonics of the mesh cycle over the last `cycles` of a steady run."""
    spectrum = np.fft.rfft(history[column])
    return 2.0 / len(history.time_s) * np.abs(spectrum[cycles : (count + 1) * cycles : cycles])


def cycles_of(history: History) -> list[slice]:
    """Slices of the whole mesh cycles in a history, cut where the mesh position wraps."""
    cuts = np.flatnonzero(np.abs(np.diff(history["mesh.position"])) > 0.5) + 1
    return [slice(int(a), int(b)) for a, b in zip(cuts[:-1], cuts[1:])]


def per_cycle(history: History, column: str, along: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean of `along`, mean and peak-to-peak of `column`, for every whole mesh cycle."""
    values = history[column]
    rows = [(along[s].mean(), values[s].mean(), np.ptp(values[s])) for s in cycles_of(history)]
    return tuple(np.array(rows).T)
