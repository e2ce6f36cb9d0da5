"""What is simulated: a torque ramp, a run-up in three levels of detail, and the balances of each."""

from __future__ import annotations

import math
from contextlib import contextmanager
from pathlib import Path

import exudyn as exu
import numpy as np
from gearmesh import GearPair

from ..files import local, shipped
from .balance import books
from .model import HELICAL, INERTIAS, SHAFTS, SPUR, Driveline, Gears, Motion

RPM = math.pi / 30.0
STEP = 1e-5  # s; Runge-Kutta 4 stands 1.4e-5, the shafts' axial modes limit it
DIAGNOSTICS = (
    "mesh.transmissionError", "mesh.tangentialForce", "mesh.contactZ", "mesh.misalignment", "mesh.normalForce",
    "mesh.stiffness",
)  # fmt: skip
# zeta = 0.02: test rigs with spur gears on roller bearings show 0.01 to 0.03.
SPUR_DAMPING = 500.0
VARIANTS = {
    "variable load": {},
    "constant load": {"loadDependent": False},
    "constant stiffness": {"stiffnessModel": "constant"},
}


def unit(gears: Gears, parameters: dict, fmu: Path | str | None = None, interface: str = "model-exchange") -> GearPair:
    """An initialised instance, of `fmu` or else of the tables at hand: the teeth touch at the start."""
    fmu = fmu or (shipped if gears == HELICAL else local)(gears.name)
    pair = GearPair(fmu, parameters, interface)
    pair.initialize()
    return pair


def rise(time: float, duration: float = 0.02) -> float:
    """From 0 to 1 with continuous slope."""
    share = min(time / duration, 1.0)
    return share * share * (3.0 - 2.0 * share)


@contextmanager
def ramp_line(torque: float, rpm: float, duration: float, damped: bool = True):
    """The assembly of the torque ramp, before it."""
    ratio = HELICAL.teeth[0] / HELICAL.teeth[1]
    with unit(HELICAL, {} if damped else {"damping": 0.0}) as pair:
        yield Driveline(
            HELICAL, pair, damped=damped, speed=rpm * RPM,
            motor=lambda t: torque * t / duration, load=lambda t: torque / ratio * t / duration,
        )  # fmt: skip


def torque_ramp(torque: float = 120.0, rpm: float = 600.0, duration: float = 0.4) -> tuple[Driveline, Motion]:
    """The helical pair at a steady speed; the torque rises evenly."""
    with ramp_line(torque, rpm, duration) as line:
        return line, line.run(duration, STEP, 5, DIAGNOSTICS)


@contextmanager
def run_up_line(
    variant: str, torque: float, rpm: float, duration: float, fmu: Path | str | None = None, damped: bool = True, coupling=None
):
    """The assembly of the run-up, before it."""
    choices = {"damping": SPUR_DAMPING * damped} | VARIANTS[variant] | ({"coupling": coupling} if coupling else {})
    with unit(SPUR, choices, fmu, "co-simulation" if coupling else "model-exchange") as pair:
        line = Driveline(SPUR, pair, damped=damped, coupling=coupling)
        # Each side's own inertia; the shafts without the gears add less than 1 %.
        sides = [inertia + line.bodies[k, shaft.gear].inertia[2, 2] for k, (inertia, shaft) in enumerate(zip(INERTIAS, SHAFTS))]
        ahead, behind = (inertia * rpm * RPM / duration for inertia in sides)
        line.torques = (lambda t: (torque + ahead) * rise(t), lambda t: (torque - behind) * rise(t))
        yield line


def run_up(
    variant: str, torque: float = 150.0, rpm: float = 6000.0, duration: float = 0.8, fmu: Path | str | None = None, coupling=None
) -> Motion:
    """The spur pair from rest to `rpm`, evenly; the teeth carry `torque`: the load brakes with less, the motor drives with more.
    `coupling`: by co-simulation, with communication steps of `STEP`."""
    with run_up_line(variant, torque, rpm, duration, fmu, coupling=coupling) as line:
        return line.run(duration, STEP, 2, DIAGNOSTICS)


def eigenfrequencies(stiffness: float) -> np.ndarray:
    """Of the spur pair's assembly with a constant tangential mesh stiffness, N/m, teeth in contact, undamped; Hz."""
    choices = {"stiffnessModel": "constant", "constantStiffness": stiffness, "damping": 0.0}
    with unit(SPUR, choices) as pair:
        line = Driveline(SPUR, pair, damped=False)
        data, start = line.mbs.systemData, exu.ConfigurationType.Initial
        q = np.array(data.GetODE2Coordinates(start))
        q[line.bodies[0, SHAFTS[0].gear].first + 5] = 2e-4  # pressed
        data.SetODE2Coordinates(q, start)
        values = line.mbs.ComputeODE2Eigenvalues(exu.SimulationSettings(), convert2Frequencies=True, autoAssemble=False)[0]
    return np.sort(np.real(values))


def mesh_resonance(stiffness: float) -> float:
    """The eigenfrequency, Hz, that follows the mesh stiffness most: there the teeth move most."""
    low, high = eigenfrequencies(0.99 * stiffness), eigenfrequencies(1.01 * stiffness)
    change = np.where(low > 100.0, high / np.maximum(low, 100.0) - 1.0, 0.0)
    return float(0.5 * (low + high)[np.argmax(change)])


def bearing_forces(line: Driveline, history: Motion) -> dict[tuple[int, int], np.ndarray]:
    """Forces of the shafts on the housing, N, in its axes, by shaft and station; without the dampers' share."""
    out = {}
    for name, spring in line.springs.items():
        if name[0] == "bearing":
            shift = np.array([line.deflections(spring, q)[:3] for q in history.q])
            out[name[1:]] = shift * spring.stiffness[:3]
    return out


def statics(line: Driveline, force: np.ndarray, moment: np.ndarray, k: int) -> dict[int, np.ndarray]:
    """Bearing forces of shaft `k` from the loads on its gear by the equilibrium of a rigid shaft on two bearings."""
    shaft, gears = SHAFTS[k], line.gears
    fixed, floating = (shaft.stations[i] for i in shaft.bearings)
    face = gears.faces[k][0]
    # Moments about the fixed bearing; the floating one takes no axial force.
    arm = face - fixed
    far = np.array([force[0] * arm + moment[1], force[1] * arm - moment[0]]) / (floating - fixed)
    return {
        shaft.bearings[0]: np.array([force[0] - far[0], force[1] - far[1], force[2]]),
        shaft.bearings[1]: np.array([far[0], far[1], 0.0]),
    }


def deviation_from_statics(line: Driveline, history: Motion) -> float:
    """Largest difference between the bearing forces and `statics`, mean over the last tenth, over the tooth force."""
    count = len(history.time)
    some = [slice(i, i + 1) for i in range(count - count // 10, count, 7)]
    difference, size = [], []
    with unit(line.gears, {}) as pair:
        for at in some:
            one = Motion(*(x[at] for x in (history.time, history.q, history.q_t, history.q_tt)), {})
            poses = line.gear_coordinates(one.q[0])
            pair.u[:6], pair.u[16:22] = poses[:6], poses[6:]
            pair.evaluate(0.0)
            loads = np.array(pair.y[:12]).reshape(2, 2, 3)
            found = bearing_forces(line, one)
            pieces = [(found[k, i][0], f) for k in (0, 1) for i, f in statics(line, *loads[k], k).items()]
            difference.append([a - b for a, b in pieces])
            size.append(np.linalg.norm(loads[0, 0]))
    return float(np.abs(np.mean(difference, axis=0)).max() / np.mean(size))


def balance(gears: Gears, damped: bool = False, duration: float = 0.01, step: float = 2.5e-6) -> dict[str, float]:
    """No mounts, constant torques switched on at speed: what energy, momentum and loads stray, over the run."""
    torque, ratio = 100.0, gears.teeth[0] / gears.teeth[1]
    with unit(gears, {} if damped else {"damping": 0.0}) as pair:
        line = Driveline(
            gears, pair, damped=damped, free_housing=True, speed=350.0,
            motor=lambda _: torque, load=lambda _: torque / ratio,
        )  # fmt: skip
        return books(line, line.run(duration, step, 1), momentum=True)


def balance_of_ramp(damped: bool, duration: float = 0.4) -> dict[str, float]:
    """Of the torque ramp, mounts and all."""
    with ramp_line(120.0, 600.0, duration, damped) as line:
        return books(line, line.run(duration, STEP, 1))


def balance_of_run_up(
    variant: str, damped: bool, rpm: float = 6000.0, duration: float = 0.1, step: float = 2.5e-6
) -> dict[str, float]:
    """Of a run-up, mounts and all; by default eight times as fast as the one shown, so that a quarter of the step is affordable."""
    with run_up_line(variant, 150.0, rpm, duration, damped=damped) as line:
        history = line.run(duration, step, 1, ("mesh.tangentialForce",))
        late = history.after(0.25 * duration).mesh["mesh.tangentialForce"]
        return books(line, history) | {"share of time apart": float(np.mean(late == 0.0))}
