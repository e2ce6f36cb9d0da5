"""`python -m examples.drivelines.response`: writes target/drivelines/response.png."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from itertools import repeat

import matplotlib.pyplot as plt
import numpy as np

from ..balance import in_words
from ..files import save
from . import linear
from .jump import balance as parting, jump, sweep
from .linear import ONE, SIX, closed_form, eigenfrequencies, measured

RANGE = (1500.0, 3300.0)  # rpm


def main() -> None:
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.5))
    frequencies = np.geomspace(300.0, 6000.0, 400)
    points = np.array([300.0, 500.0, 750.0, 1900.0, 3000.0, 4200.0, 5000.0, 6000.0])
    with ProcessPoolExecutor(2) as pool:
        sweeps = [pool.submit(sweep, *RANGE), pool.submit(sweep, *RANGE[::-1])]
        for support, name, colour in ((ONE, "one freedom", "C0"), (SIX, "six freedoms", "C1")):
            left.loglog(frequencies, 1e6 * closed_form(support, frequencies), color=colour, label=f"{name}, closed form")
            found = np.array(list(pool.map(measured, repeat(support), points)))
            left.loglog(points, 1e6 * found, "o", color=colour, label=f"{name}, through the unit")
            error = np.abs(found / closed_form(support, points) - 1.0)
            print(f"{name}: resonances {np.round(eigenfrequencies(support))} Hz; largest deviation {100 * error.max():.2f} %")
        left.xaxis.set_minor_formatter(lambda value, _: f"{value:.0f}" if f"{value:.0e}"[0] in "25" else "")
        left.xaxis.set_major_formatter("{x:.0f}")
        left.set(xlabel="frequency, Hz", ylabel="transmission error, µm")
        left.legend(fontsize=8)
        for future, name in zip(sweeps, ("run-up", "run-down")):
            speeds, swing, apart = (x[8:] for x in future.result())  # the start has died out
            right.plot(speeds, 1e6 * swing, label=name)
            lost = speeds[apart > 0.0]
            print(f"{name}: jump at {jump(speeds, swing):.0f} rpm, teeth part from {lost.min():.0f} to {lost.max():.0f} rpm")
    right.set(xlabel="speed, rpm", ylabel="swing of the transmission error, µm")
    right.legend()
    save(figure, "response")
    for damped in (False, True):
        word = "damped" if damped else "undamped"
        print(f"one freedom, {word}: {in_words(linear.balance(ONE, damped))}")
        print(f"six freedoms, {word}: {in_words(linear.balance(SIX, damped))}")
        print(f"teeth that part, {word}: {in_words(parting(damped))}")


if __name__ == "__main__":
    main()
