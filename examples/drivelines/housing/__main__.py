"""`python -m examples.drivelines.housing`: runs all cases and writes target/drivelines/housing-*.png."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import gearmesh
import numpy as np
from gearmesh import History, decibels
from gearmesh.energy import in_words
from gearmesh.plots import BLUE, RED, figure as new_figure

from examples.shared.files import save
from examples.shared.gearbox import HELICAL, SHAFTS, SPUR, sweep
from examples.shared.walls import AIR, POWER, VELOCITY, housing

from .cases import balance, balance_of_ramp, balance_of_sweep, deviation_from_statics, mesh_resonance, torque_ramp

BASE_HELIX = np.radians(20.61)  # of the helical pair
SHOWN = ("variable load", "constant load")  # with constant stiffness nothing excites
ORDERS = (SPUR.teeth[0], 2 * SPUR.teeth[0])


def ramp_figure(ramp: dict[str, np.ndarray]) -> None:
    """Bearing forces, misalignment and shuttling moment over torque."""
    figure, (left, middle, right) = new_figure(3)
    for k in range(len(SHAFTS)):
        for j, name in enumerate(("fixed", "floating")):
            force = np.linalg.norm(ramp["seats"][::50, k, j, :2], axis=1)
            left.plot(ramp["torque"][::50], force, label=f"shaft {k + 1}, {name} bearing")
    left.set(xlabel="torque, N m", ylabel="radial force on the housing, N")
    left.legend(fontsize=8)
    loaded = ramp["torque"] > 5.0
    middle.plot(ramp["torque"][loaded], 1e6 * ramp["misalignment"][loaded])
    middle.set(xlabel="torque, N m", ylabel="misalignment by shafts, bearings, housing, µrad")
    # Shuttling: the force on the line of action moves along the face.
    shuttling = ramp["normal force"] * np.cos(BASE_HELIX) * (ramp["contact z"] - 12e-3)
    right.plot(ramp["torque"][loaded], shuttling[loaded], lw=0.7)
    right.set(xlabel="torque, N m", ylabel="moment of the force about mid-face, N m")
    save(figure, "housing-torque-ramp")


def walls_level(history: History, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Speed, rpm, and level of an order's mean square normal velocity over all walls, dB re 1 nm/s."""
    waves = [name for name in history.signals if name.startswith("wave ")]
    found = [gearmesh.orders(history, name, [order], revolutions=16.0 / order) for name in waves]
    return found[0].speed_rpm, decibels(np.sqrt(0.5 * sum(f.of(order) ** 2 for f in found)), VELOCITY)


def power_level(area: float) -> float:
    """What turns a level of the walls' velocity into that of the equivalent radiated power, AIR area <v^2>, re 1 pW."""
    return float(10.0 * np.log10(AIR * area * VELOCITY**2 / POWER))


def sweep_figures(sweeps: dict[str, tuple[History, History]], resonance: float) -> None:
    figure, axes = new_figure(2, 11, sharey=True)
    for axis, (name, branches) in zip(axes, sweeps.items()):
        for history, colour, way in zip(branches, (BLUE, RED), ("up", "down")):
            speed, swing = gearmesh.swing(history, "tangential_force_n")
            axis.plot(speed, 1e-3 * swing, color=colour, label=f"run-{way}")
        axis.axvline(resonance, color="grey", lw=0.8, ls="--", label="resonance, linear")
        axis.set(title=name, xlabel="speed, rpm", xlim=(400, 6000))
    axes[0].set_ylabel("swing of the tangential force, kN")
    axes[0].legend(fontsize=8)
    save(figure, "housing-run-up")

    figure, (left, right) = new_figure(2, 13, 5.0)
    up, down = sweeps["variable load"]
    gearmesh.plot_campbell(gearmesh.campbell(up, "wall_m_per_s2"), left)
    left.set(ylim=(0.0, 10.0), title="top wall at the sensor, run-up")
    for order, style in zip(ORDERS, ("-", "--")):
        for history, colour, way in ((up, BLUE, "up"), (down, RED, "down")):
            right.plot(*walls_level(history, order), style, color=colour, label=f"run-{way}, order {order}")
    right.set(xlabel="speed, rpm", ylabel="mean square normal velocity of all walls, dB re 1 nm/s", xlim=(300, 6000), ylim=(70, None))
    shift = power_level(housing(SPUR.center_distance).area)
    power = right.secondary_yaxis("right", functions=(lambda level: level + shift, lambda level: level - shift))
    power.set_ylabel("equivalent radiated power, dB re 1 pW")
    right.legend(fontsize=8)
    save(figure, "housing-orders")


def branches(variant: str) -> tuple[History, History]:
    """Slow enough for the walls: each rings for 3 ms in a mode of 2.5 kHz."""
    return sweep(variant, duration=1.6, down=True)


def main() -> None:
    walls = housing(SPUR.center_distance)
    print(f"walls of {walls.area:.3f} m^2, first mode of bending {walls.frequencies[6] / 2.0 / np.pi:.0f} Hz")
    ramp = torque_ramp()
    ramp_figure(ramp)
    print(f"bearing forces against statics: {deviation_from_statics(ramp):.1e} of the tooth force, "
          f"largest misalignment {1e6 * np.abs(ramp['misalignment']).max():.0f} urad")
    with ProcessPoolExecutor(2) as pool:
        sweeps = dict(zip(SHOWN, pool.map(branches, SHOWN)))
    for name, histories in sweeps.items():
        for way, history in zip(("up", "down"), histories):
            late = history.cut((history.speed_rpm > 400.0) & (history.speed_rpm < 5950.0))
            force, speed = late["tangential_force_n"], late.speed_rpm
            apart = speed[force == 0.0]
            text = f"teeth part from {apart.min():.0f} to {apart.max():.0f} rpm" if len(apart) else "teeth stay in contact"
            rpm, level = walls_level(late, ORDERS[0])
            print(f"{name}, run-{way}: largest force {force.max():.0f} N at {speed[force.argmax()]:.0f} rpm, {text}; "
                  f"order {ORDERS[0]} of the walls {level.max():.1f} dB re 1 nm/s at {rpm[level.argmax()]:.0f} rpm, "
                  f"ERP {level.max() + power_level(walls.area):.1f} dB re 1 pW")
    up = sweeps["variable load"][0]
    stiffness = up["stiffness_n_per_m"][(up.speed_rpm > 200.0) & (up.speed_rpm < 600.0)].mean()
    frequency = mesh_resonance(stiffness)
    print(f"mean tangent stiffness {stiffness:.3g} N/m: eigenfrequency of the mesh {frequency:.0f} Hz, "
          f"met by order {ORDERS[0]} at {60.0 * frequency / ORDERS[0]:.0f} rpm")
    sweep_figures(sweeps, 60.0 * frequency / ORDERS[0])
    balances()


def balances() -> None:
    """Energy, momentum and loads of each case, without and with damping."""
    housing(SPUR.center_distance, False), housing(HELICAL.center_distance, False)  # before the processes part
    with ProcessPoolExecutor(2) as pool:
        found = {}
        for damped in (False, True):
            word = "damped" if damped else "undamped"
            for gears in (SPUR, HELICAL):
                found[f"{gears.name}, no mounts, {word}"] = pool.submit(balance, gears, damped)
            found[f"torque ramp, {word}"] = pool.submit(balance_of_ramp, damped)
            found[f"run-up in 0.1 s, variable load, {word}"] = pool.submit(balance_of_sweep, "variable load", damped)
        for name, future in found.items():
            print(f"{name}: {in_words(future.result())}", flush=True)


if __name__ == "__main__":
    main()
