"""`python -m examples.drivelines.cosimulation`: writes target/drivelines/cosimulation.png and ssp/gearbox.ssp."""

from __future__ import annotations

import time
from contextlib import closing

import fmpy
import matplotlib.pyplot as plt
import numpy as np

from ..files import OUT, shipped
from . import ssp
from .masters import Gears, cosimulate, distance, exchange, monolithic, start

DURATION = 1.024e-3  # s, two mesh cycles less a little; a whole number of each step
SIZES = 1.28e-4 * 0.5 ** np.arange(11)
ENOUGH = slice(0, 9)  # for couplings of second order
COUPLINGS = ("parallel", "held", "extrapolated", "iterated")


def orders(gears, begin, reference, coupling, sizes):
    """Errors at the sizes where the coupling is stable, and the order that the two smallest show."""
    errors = []
    for size in sizes:
        with np.errstate(all="ignore"):
            try:
                errors.append(distance(cosimulate(gears, begin, DURATION, size, coupling), reference))
            except (np.linalg.LinAlgError, RuntimeError):  # the poses ran away
                errors.append(np.inf)
    return np.array(errors), float(np.log2(errors[-2] / errors[-1]))


def longest_stable(gears, begin, coupling, packed: float) -> float:
    """Longest of 1, 1.5, 2, ... times the packed step after which the tooth force still stands after 8 ms, s."""
    factor = 1.0
    while factor < 20.0:
        force = exchange(gears, *begin)[1]
        try:
            with np.errstate(all="ignore"):
                end = cosimulate(gears, begin, 8e-3, factor * packed, coupling)
            if not abs(exchange(gears, *end)[1] - force) < 0.2 * abs(force):
                break
        except RuntimeError:
            break
        factor += 0.5
    return (factor - 0.5) * packed


def main() -> None:
    with closing(Gears()) as gears:
        compare(gears)


def compare(gears: Gears) -> None:
    begin = start(gears)
    reference = monolithic(gears, begin, DURATION, 2.5e-7)
    figure, axis = plt.subplots(figsize=(7, 5))
    for coupling in COUPLINGS:
        sizes = SIZES if coupling in ("parallel", "held") else SIZES[ENOUGH]
        errors, order = orders(gears, begin, reference, coupling, sizes)
        axis.loglog(1e6 * sizes, np.where(errors < 3.0, errors, np.nan), "o-", label=f"{coupling}, order {order:.2f}")
        print(f"{coupling}: order {order:.2f}, error {errors[-1]:.1e} at {1e6 * sizes[-1]:.2f} us")
    file = ssp.build(gears, begin)
    sizes, errors = SIZES[5:], []
    for size in sizes:
        clock = time.process_time()
        found = ssp.run(file, DURATION, size)
        clock = (time.process_time() - clock) / round(DURATION / size)
        errors.append(np.abs((found - reference[0][[1, 4, 5]]) * [1.0, 1.0, 0.064]).max() / 1.5e-5)
    print(f"Ecos, SSP of three FMUs: order {np.log2(errors[-2] / errors[-1]):.2f}, {1e6 * clock:.0f} us of processor time a step")
    axis.loglog(1e6 * sizes, errors, "k+", ms=10, label="Ecos, SSP of three FMUs")
    packed = float(fmpy.read_model_description(str(shipped("helical-25-47"))).defaultExperiment.stepSize)
    axis.axvline(1e6 * packed, color="grey", lw=0.8)
    axis.text(1e6 * packed, 0.3, " packed step", color="grey")
    for coupling in ("parallel", "held"):
        print(f"{coupling}: stands {longest_stable(gears, begin, coupling, packed) / packed:.1f} times the packed step of {1e6 * packed:.2f} us")
    axis.set(xlabel="communication step, µs", ylabel="error over the elastic displacement", ylim=(1e-8, 1.0))
    axis.legend()
    figure.tight_layout()
    figure.savefig(OUT / "cosimulation.png", dpi=80)


if __name__ == "__main__":
    main()
