"""`python -m examples.drivelines.holes`: a wheel with six holes in the elastic housing, sidebands in the velocity of its walls.

The gearbox of `housing` at a steady speed, gear 2 with a thin web of six holes; with `bodyEffect` off the same wheel has the stiffness of its mean.
Writes holes.png and holes.csv to target/drivelines.
"""

from __future__ import annotations

import json

import numpy as np
from gearmesh import decibels
from gearmesh.plots import BLUE, RED, figure as new_figure

from examples.shared.files import OUT, PAIRS, built, save
from examples.shared.gearbox import RPM, SPUR, SPUR_DAMPING, STEP, Driveline, rise, unit
from examples.shared.tables import show
from examples.shared.walls import VELOCITY

HOLES = 6
WHEEL = {
    "rim_thickness_mm": 6.0, "web_thickness_mm": 8.0, "hub_diameter_mm": 60.0,
    "web_holes": {"count": HOLES, "circle_diameter_mm": 93.0, "diameter_mm": 24.0},
}  # fmt: skip
SPEED, TORQUE = 1200.0, 150.0  # rpm, N m
TURNS = 10  # shown, after as many in which the walls come to rest
FLOOR = 30.0  # dB, of the figure
ORDERS = 2 * SPUR.teeth[1] + 2 * HOLES


def pair_file():
    """The pair of `housing` with that wheel."""
    content = json.loads((PAIRS / "spur-50-50.json").read_text())
    content |= {"name": "spur-50-50-holes", "gear2": content["gear2"] | WHEEL}
    path, text = OUT / f"{content['name']}.json", json.dumps(content, indent=2) + "\n"
    OUT.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    return path


def levels(body_effect: bool, turns: int = TURNS) -> np.ndarray:
    """Level of the mean square normal velocity over all walls by order of gear 2, from 0 on, dB re 1 nm/s."""
    choices = {"damping": SPUR_DAMPING, "bodyEffect": body_effect}
    turn = 60.0 / SPEED
    with unit(SPUR, choices, built(pair_file())) as pair:
        torque = lambda time: TORQUE * rise(time)  # noqa: E731
        line = Driveline(SPUR, pair, speed=SPEED * RPM, motor=torque, load=torque)
        samples = round(turns * turn / STEP)
        _, waves = line.run(2 * turns * turn, STEP, lambda _, q, q_t, q_tt: line.housing.waves @ q_t[line.walls])
    window = np.hanning(samples)
    amplitudes = 2.0 * np.abs(np.fft.rfft(window[:, None] * waves[-samples - 1 : -1], axis=0)) / window.sum()
    squares = 0.5 * (amplitudes[::turns] ** 2).sum(axis=1)
    return decibels(np.sqrt(squares[: ORDERS + 1]), VELOCITY)


def main() -> None:
    found = {"six holes": levels(True), "mean wheel": levels(False)}
    figure, axis = new_figure(1)
    for (name, level), colour, shift in zip(found.items(), (BLUE, RED), (-0.2, 0.2)):
        axis.vlines(np.arange(ORDERS + 1) + shift, FLOOR, np.maximum(level, FLOOR), color=colour, label=name)
    axis.set(xlabel="order of gear 2", ylabel="velocity of all walls, dB re 1 nm/s", ylim=(FLOOR, None))
    axis.legend(fontsize=8)
    save(figure, "holes")
    z = SPUR.teeth[1]
    orders = [HOLES, 2 * HOLES, z - 2 * HOLES, z - HOLES, z, z + HOLES, z + 2 * HOLES, 2 * z - HOLES, 2 * z, 2 * z + HOLES]
    rows = [[order, *(f"{level[order]:.1f}" for level in found.values())] for order in orders]
    show("holes", [["order", *(f"{name}, dB re 1 nm/s" for name in found)], *rows], OUT)


if __name__ == "__main__":
    main()
