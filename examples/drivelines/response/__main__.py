"""`python -m examples.drivelines.response`: writes target/drivelines/response.png."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from itertools import repeat

import gearmesh
import numpy as np
from gearmesh.energy import in_words
from gearmesh.plots import BLUE, RED, figure as new_figure

from examples.shared.files import OUT, save
from examples.shared.tables import show

from . import linear
from .jump import balance as parting, jump, linear_swing, sweep
from .linear import ONE, SIX, closed_form, eigenfrequencies, measured

RANGE = (1500.0, 3300.0)  # rpm


def main() -> None:
    figure, (left, right) = new_figure(2, 13, 4.5)
    frequencies = np.geomspace(300.0, 6000.0, 400)
    points = np.array([300.0, 500.0, 750.0, 1900.0, 3000.0, 4200.0, 5000.0, 6000.0])
    with ProcessPoolExecutor(2) as pool:
        run = pool.submit(sweep, *RANGE)
        for support, name, colour in ((ONE, "one freedom", "C0"), (SIX, "six freedoms", "C1")):
            left.loglog(frequencies, 1e6 * closed_form(support, frequencies), color=colour, label=f"{name}, closed form")
            found = np.array(list(pool.map(measured, repeat(support), points)))
            left.loglog(points, 1e6 * found, "o", color=colour, label=f"{name}, through the FMU")
            error = np.abs(found / closed_form(support, points) - 1.0)
            print(f"{name}: resonances {np.round(eigenfrequencies(support))} Hz; largest deviation {100 * error.max():.2f} %")
        left.xaxis.set_minor_formatter(lambda value, _: f"{value:.0f}" if f"{value:.0e}"[0] in "25" else "")
        left.xaxis.set_major_formatter("{x:.0f}")
        left.set(xlabel="frequency (Hz)", ylabel="transmission error (µm)")
        left.legend(fontsize=8)
        run = run.result()
    gearmesh.plot_run_up(run, axes=right)
    speeds = np.linspace(*RANGE, 361)
    swing = linear_swing(run.natural_frequency_hz, speeds)
    right.plot(speeds, swing, "k:", label="linear, while teeth touch")
    ends = speeds[np.isnan(swing)]
    rows = [["speed (rpm)", "linear", "run-up", "run-down"], ["resonance or jump", f"{run.resonance_rpm:.0f}"]]
    rows += [["teeth part from", f"{ends.min():.0f}"], ["to", f"{ends.max():.0f}"], ["largest swing of the transmission error (um)", ""]]
    for history, colour, way in ((run.up, BLUE, "run-up"), (run.down, RED, "run-down")):
        speed, apart = jump(history)
        right.axvspan(apart.min(), apart.max(), ymax=0.03, color=colour, alpha=0.5, label=f"teeth part, {way}")
        for row, value in zip(rows[1:], (speed, apart.min(), apart.max())):
            row.append(f"{value:.0f}")
        rows[-1].append(f"{gearmesh.swing(history, 'transmission_error_um')[1].max():.1f}")
    right.legend(fontsize=8)
    show("response", rows, OUT)
    save(figure, "response")
    for damped in (False, True):
        word = "damped" if damped else "undamped"
        print(f"one freedom, {word}: {in_words(linear.balance(ONE, damped))}")
        print(f"six freedoms, {word}: {in_words(linear.balance(SIX, damped))}")
        print(f"teeth that part, {word}: {in_words(parting(damped))}")


if __name__ == "__main__":
    main()
