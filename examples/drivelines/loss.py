"""`python -m examples.drivelines.loss`: loss of four published pairs over speed by each law of friction.

Pairs of the FZG test rig with centre distance 91.5 mm; the tip reliefs are ours. Writes loss.png and loss.csv to target/drivelines.
"""

from __future__ import annotations

import json
import math
from contextlib import AbstractContextManager

import gearmesh
import numpy as np
from gearmesh import GearPair, Turning
from gearmesh.energy import in_words
from gearmesh.plots import BLUE, GREEN, RED, figure as new_figure

from examples.shared import driven
from examples.shared.files import OUT, PAIRS, opened, save
from examples.shared.tables import show

TORQUE = 200.0  # N m on the pinion
INERTIA = 1.5e-3  # kg m^2, of the gear in a balance
SPEEDS = (250.0, 500.0, 1000.0, 1500.0, 2000.0, 3000.0, 4000.0, 6000.0)  # rpm
OIL = {"dynamic_viscosity_mpa_s": 13.28, "roughness_ra_um": [0.4, 0.31], "lubricant_factor": 0.846}
WORDS = {"constant": "constant, 0.05", "schlenk": "Schlenk", "xu_kahraman": "Xu and Kahraman"}
PUBLISHED = 274.0  # W, C14 at 1500 rpm by the law of Schlenk, from a program with rigid teeth
LAWS = {"constant": ({"coefficient": 0.05}, GREEN), "schlenk": (OIL, BLUE), "xu_kahraman": (OIL, RED)}
NAMES = ("C14", "H501", "H701", "H951")


def pair(name: str, law: str, relief: bool) -> dict:
    """The pair file with the law; the tip relief is that of the shipped fzg-c in proportion to the module."""
    content = json.loads((PAIRS / f"fzg-{name.lower()}.json").read_text())
    module = content["normal_module_mm"]
    tip = {"tip_relief": {"amount_um": 5.5 * module, "start": {"from_tip_mm": 0.8 * module}, "shape": "parabolic"}} if relief else {}
    gears = {gear: content[gear] | tip for gear in ("gear1", "gear2")}
    return content | gears | {"name": f"{name}-{law}", "friction": {"law": law} | LAWS[law][0]}


def solved(name: str, law: str, relief: bool) -> gearmesh.MeshCycle:
    return gearmesh.solve(pair(name, law, relief), TORQUE, speed_rpm=SPEEDS, refinement="coarse")


def unit(name: str, law: str, **start: float) -> AbstractContextManager[GearPair]:
    """The FMU with friction, without relief, and the start values."""
    coarse = {"refinement": "coarse", "no_center_distance": True, "no_misalignment": True, "friction": True}
    fmu = gearmesh.build(pair(name, law, False), OUT / f"{name}-{law}.fmu", set={"friction": True}, **coarse)
    return opened(fmu, start)


def balance(damped: bool, duration: float = 0.02, step: float = 2.5e-6) -> dict[str, float]:
    """Of a run with friction under the torque, from a gap of 0.1 mrad: what energy and loads stray, over the run."""
    with unit("C14", "schlenk", **({} if damped else {"damping": 0.0})) as made:
        start = made.u[made.input["gear2.angles[3]"]] - 1e-4
        return driven.balance(Turning(made), INERTIA, -TORQUE / made.geometry.ratio, 1500.0, start, duration, step)


def through_the_fmu(name: str, law: str, rpm: float, positions: int = 32) -> float:
    """Mean loss, W, of the FMU over a mesh cycle at the torque, without relief."""
    with unit(name, law, damping=0.0) as made:
        turning, geometry, speed, lost = Turning(made), made.geometry, rpm * math.pi / 30.0, []
        start = made.u[made.input["gear2.angles[3]"]]
        for angle in np.arange(positions) / positions * 2.0 * math.pi / geometry.teeth[0]:
            at = turning.resting(-TORQUE / geometry.ratio, angle, start + geometry.ratio * angle)
            turning(angle, speed, at, geometry.ratio * speed)
            lost.append(-made["mesh.frictionPower"])
    return float(np.mean(lost))


def main() -> None:
    figure, axes = new_figure(len(NAMES), 15, 4.0, sharey=True)
    power = TORQUE * np.array(SPEEDS) * math.pi / 30.0
    rows = [["pair", "law", "tip relief", *(f"loss at {rpm:g} rpm (W)" for rpm in SPEEDS), "loss factor", "mean coefficient at 1500 rpm"]]
    for axis, name in zip(axes, NAMES):
        for law, (_, colour) in LAWS.items():
            for relief, style in ((False, "-"), (True, "--")):
                cycle = solved(name, law, relief)
                axis.semilogx(SPEEDS, 100.0 * cycle.loss_w / power, style, color=colour, label=WORDS[law] + ", relieved" * relief)
                coefficient = cycle.friction_coefficient[SPEEDS.index(1500.0)]
                rows.append([name, law, "yes" if relief else "no", *(f"{w:.1f}" for w in cycle.loss_w), f"{cycle.loss_factor:.4f}", f"{coefficient:.4f}"])
        axis.set(title=name, xlabel="speed (rpm)", xticks=SPEEDS[::2], ylim=(0.0, None))
        axis.xaxis.set_major_formatter("{x:g}")
        axis.xaxis.set_minor_formatter("")
    axes[0].set(ylabel="loss (% of the power)")
    axes[0].plot(1500.0, 100.0 * PUBLISHED / power[SPEEDS.index(1500.0)], "kx", label="another program, Schlenk")
    axes[0].legend(fontsize=8, loc="lower left")
    save(figure, "loss")
    show("loss", rows, OUT)
    for law in LAWS:
        by_fmu, by_solve = through_the_fmu("C14", law, 1500.0), float(next(row[6] for row in rows if row[:3] == ["C14", law, "no"]))
        print(f"C14, {law}, 1500 rpm: {by_fmu:.1f} W by the FMU, {by_solve:.1f} W by solve")
    for damped in (False, True):
        print(f"C14, {'damped' if damped else 'undamped'}: {in_words(balance(damped))}")


if __name__ == "__main__":
    main()
