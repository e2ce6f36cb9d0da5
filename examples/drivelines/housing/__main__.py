"""`python -m examples.drivelines.housing`: runs all cases and writes target/drivelines/housing-*.png."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import gearmesh
import numpy as np
from gearmesh import History
from gearmesh.energy import in_words
from gearmesh.plots import figure as new_figure

from ..files import save
from .balance import without_teeth
from .cases import (
    STEP, VARIANTS, balance, balance_of_ramp, balance_of_run_up, bearing_forces, deviation_from_statics, mesh_resonance, run_up,
    torque_ramp,
)  # fmt: skip
from .model import HELICAL, SHAFTS, SPUR, Driveline, Motion
from .observe import observed

TOOTH_FORCE = (500.0, 1333.0, 0.0)  # N, about that of 100 N m
BASE_HELIX = np.radians(20.61)  # of the helical pair


def ramp_figure(line: Driveline, history: Motion) -> None:
    """Bearing forces, misalignment and shuttling moment over torque."""
    count = 250
    some = Motion(*(x[::count] for x in (history.time, history.q, history.q_t, history.q_tt)), {})
    torque = 120.0 * some.time / 0.4
    forces = bearing_forces(line, some)
    figure, (left, middle, right) = new_figure(3)
    for (k, i), force in forces.items():
        label = f"shaft {k + 1}, {'fixed' if i == SHAFTS[k].bearings[0] else 'floating'} bearing"
        left.plot(torque, np.linalg.norm(force[:, :2], axis=1), label=label)
    left.set(xlabel="torque, N m", ylabel="radial force on the housing, N")
    left.legend(fontsize=8)
    torque = 120.0 * history.time / 0.4
    normal, z = history.mesh["mesh.normalForce"], history.mesh["mesh.contactZ"]
    loaded = torque > 5.0
    middle.plot(torque[loaded], 1e6 * history.mesh["mesh.misalignment"][loaded])
    middle.set(xlabel="torque, N m", ylabel="misalignment by bending and bearings, urad")
    # Shuttling: the force on the line of action moves along the face.
    shuttling = normal * np.cos(BASE_HELIX) * (z - 12e-3)
    right.plot(torque[loaded], shuttling[loaded], lw=0.7)
    right.set(xlabel="torque, N m", ylabel="moment of the force about mid-face, N m")
    save(figure, "housing-torque-ramp")


def run_up_figures(histories: dict[str, History]) -> None:
    figure, axes = new_figure(3, sharey=True)
    for axis, (name, history) in zip(axes, histories.items()):
        axis.plot(history.speed_rpm, 1e-3 * history["mesh.tangentialForce"], lw=0.3)
        axis.set(title=name, xlabel="speed, rpm")
    axes[0].set_ylabel("tangential force, kN")
    save(figure, "housing-run-up")

    figure, (left, right) = new_figure(2, 13, 5.0)
    gearmesh.plot_campbell(gearmesh.campbell(histories["variable load"], "wall_m_per_s2"), left)
    left.set_ylim(0.0, 10.0)
    for k, (name, history) in enumerate(histories.items()):
        for order, style in ((SPUR.teeth[0], "-"), (2 * SPUR.teeth[0], "--")):
            found = gearmesh.orders(history, "wall_m_per_s2", [order], revolutions=16.0 / order)
            right.semilogy(found.speed_rpm, found.of(order), style, color=f"C{k}", label=f"{name}, order {order}")
    right.set(xlabel="speed, rpm", ylabel="acceleration, m/s²", xlim=(300, 6100), ylim=(1e-4, None))
    right.legend(fontsize=8)
    save(figure, "housing-orders")


def main() -> None:
    line, history = torque_ramp()
    ramp_figure(line, history)
    print(f"bearing forces against statics: {deviation_from_statics(line, history):.1e} of the tooth force")
    with ProcessPoolExecutor(2) as pool:
        histories = dict(zip(VARIANTS, map(observed, pool.map(run_up, VARIANTS))))
    for name, history in histories.items():
        late = history.cut(history.time_s >= 0.05)
        force, speed = late["mesh.tangentialForce"], late.speed_rpm
        apart = speed[force == 0.0]
        text = f"teeth part from {apart.min():.0f} to {apart.max():.0f} rpm" if len(apart) else "teeth stay in contact"
        print(f"{name}: largest force {force.max():.0f} N at {speed[force.argmax()]:.0f} rpm, {text}")
    history = histories["variable load"]
    slow = history["mesh.stiffness"][(history.time_s >= 0.05) & (history.speed_rpm < 600.0)]
    frequency = mesh_resonance(slow.mean())
    print(f"mean tangent stiffness {slow.mean():.3g} N/m: eigenfrequency of the mesh {frequency:.0f} Hz, "
          f"met by order {SPUR.teeth[0]} at {60.0 * frequency / SPUR.teeth[0]:.0f} rpm")
    run_up_figures(histories)
    balances()


def balances() -> None:
    """Energy, momentum and loads of each case, without and with damping."""
    for step in (1e-5, 5e-6, 2.5e-6):
        print(f"{SPUR.name}, no mounts, undamped, at {1e6 * step:g} us: {in_words(balance(SPUR, step=step))}")
        print(f"constant forces in place of the teeth, at {1e6 * step:g} us: {without_teeth(350.0, TOOTH_FORCE, 0.01, step):.1e}")
    with ProcessPoolExecutor(2) as pool:
        found = {}
        for damped in (False, True):
            word = "damped" if damped else "undamped"
            for gears in (SPUR, HELICAL):
                found[f"{gears.name}, no mounts, {word}"] = pool.submit(balance, gears, damped)
            found[f"torque ramp, {word}"] = pool.submit(balance_of_ramp, damped)
            for variant in VARIANTS:
                found[f"run-up in 0.1 s, {variant}, {word}"] = pool.submit(balance_of_run_up, variant, damped)
        found["run-up as shown, variable load, damped"] = pool.submit(balance_of_run_up, "variable load", True, duration=0.8, step=STEP)
        for name, future in found.items():
            print(f"{name}: {in_words(future.result())}", flush=True)


if __name__ == "__main__":
    main()
