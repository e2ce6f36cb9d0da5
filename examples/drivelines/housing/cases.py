"""What is simulated beside run-up and run-down: a torque ramp, the resonance of the mesh, and the balances of each."""

from __future__ import annotations

from contextlib import contextmanager

import exudyn as exu
import numpy as np

from examples.shared.gearbox import HELICAL, RPM, SHAFTS, SPUR, STEP, Driveline, Gears, sweep_line, unit

from .balance import books


@contextmanager
def ramp_line(torque: float, rpm: float, duration: float, damped: bool = True):
    """The assembly of the torque ramp, before it."""
    ratio = HELICAL.teeth[0] / HELICAL.teeth[1]
    with unit(HELICAL, {} if damped else {"damping": 0.0}) as pair:
        yield Driveline(
            HELICAL, pair, damped=damped, speed=rpm * RPM,
            motor=lambda t: torque * t / duration, load=lambda t: torque / ratio * t / duration,
        )  # fmt: skip


def torque_ramp(torque: float = 120.0, rpm: float = 600.0, duration: float = 0.4) -> dict[str, np.ndarray]:
    """The helical pair at a steady speed; the torque rises evenly.

    `torque`, N m; forces on each seat by shaft and bearing, `seats` (n, 2, 2, 3), N, without the dampers' share; force and moment
    on each gear, `loads` (n, 2, 2, 3); `misalignment`, rad, `normal force`, N, and `contact z`, m.
    """
    with ramp_line(torque, rpm, duration) as line:

        def observe(_time, q, *_):
            seats = line.bearings * (line.slip @ q[line.elastic])
            mesh = [line.pair[f"mesh.{name}"] for name in ("misalignment", "normalForce", "contactZ")]
            return np.concatenate([seats, line.pair.y[:12], mesh])

        time, rows = line.run(duration, STEP, observe, 5)
    seats, loads = (block.reshape(-1, 2, 2, 3) for block in (rows[:, :12], rows[:, 12:24]))
    return {"torque": torque * time / duration, "seats": seats, "loads": loads} | dict(
        zip(("misalignment", "normal force", "contact z"), rows[:, 24:].T)
    )


def deviation_from_statics(ramp: dict[str, np.ndarray]) -> float:
    """Largest difference of the forces on the seats from those on a rigid shaft on two bearings, mean over the last tenth, over
    the tooth force."""
    late = slice(-len(ramp["torque"]) // 10, None)
    (seats, loads), difference = (ramp[name][late].mean(axis=0) for name in ("seats", "loads")), []
    for k, shaft in enumerate(SHAFTS):
        (force, moment), (fixed, floating) = loads[k], (shaft.stations[i] for i in shaft.bearings)
        arm = HELICAL.faces[k][0] - fixed
        # Moments about the fixed bearing; the floating one takes no axial force.
        far = np.array([force[0] * arm + moment[1], force[1] * arm - moment[0], 0.0]) / (floating - fixed)
        difference += [seats[k, 0] - (force - far), seats[k, 1] - far]
    return float(np.abs(difference).max() / np.linalg.norm(loads[0, 0]))


def eigenfrequencies(stiffness: float) -> np.ndarray:
    """Of the spur pair's assembly with a constant tangential mesh stiffness, N/m, teeth in contact, undamped; Hz."""
    choices = {"stiffnessModel": "constant", "constantStiffness": stiffness, "damping": 0.0}
    with unit(SPUR, choices) as pair:
        line = Driveline(SPUR, pair, damped=False)
        data, start = line.mbs.systemData, exu.ConfigurationType.Initial
        q = np.array(data.GetODE2Coordinates(start))
        q[line.gear_coordinates[5]] = 2e-4  # pressed
        data.SetODE2Coordinates(q, start)
        values = line.mbs.ComputeODE2Eigenvalues(exu.SimulationSettings(), convert2Frequencies=True, autoAssemble=False)[0]
    return np.sort(np.real(values))


def mesh_resonance(stiffness: float) -> float:
    """The eigenfrequency, Hz, that follows the mesh stiffness most: there the teeth move most."""
    low, high = eigenfrequencies(0.99 * stiffness), eigenfrequencies(1.01 * stiffness)
    change = np.where(low > 100.0, high / np.maximum(low, 100.0) - 1.0, 0.0)
    return float(0.5 * (low + high)[np.argmax(change)])


def balance(gears: Gears, damped: bool = False, duration: float = 0.01, step: float = 2.5e-6) -> dict[str, float]:
    """No mounts, constant torques switched on at speed: what energy, momentum and loads stray, over the run."""
    torque, ratio = 100.0, gears.teeth[0] / gears.teeth[1]
    with unit(gears, {} if damped else {"damping": 0.0}) as pair:
        line = Driveline(
            gears, pair, damped=damped, mounts=False, speed=350.0,
            motor=lambda _: torque, load=lambda _: torque / ratio,
        )  # fmt: skip
        return books(line, duration, step, momentum=True)


def balance_of_ramp(damped: bool, duration: float = 0.4) -> dict[str, float]:
    """Of the torque ramp, mounts and all."""
    with ramp_line(120.0, 600.0, duration, damped) as line:
        return books(line, duration, STEP)


def balance_of_sweep(
    variant: str, damped: bool, rpm: float = 6000.0, duration: float = 0.1, step: float = 2.5e-6
) -> dict[str, float]:
    """Of a run-up, mounts and all; by default eight times as fast as the one shown, so that a quarter of the step is affordable."""
    with sweep_line(variant, 150.0, rpm, duration, damped=damped) as line:
        return books(line, duration, step)
