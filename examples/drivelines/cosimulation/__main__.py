"""`python -m examples.drivelines.cosimulation`: writes target/drivelines/cosimulation.png and ssp/gearbox.ssp."""

from __future__ import annotations

from contextlib import closing
from itertools import product

import numpy as np
from gearmesh.energy import in_words
from gearmesh.plots import figure as new_figure
from matplotlib.ticker import NullLocator

from examples.shared.files import save

from . import ssp
from .balance import balance, coupling_balance
from .masters import Gears, cosimulate, distance, monolithic, packed_step, stands, start

DURATION = 1.024e-3  # s, two mesh cycles less a little; a whole number of each step
SIZES = 1.28e-4 * 0.5 ** np.arange(11)
ENOUGH = slice(0, 9)  # for couplings of second order
BOOKED = slice(5, 10)  # small enough for every coupling to stand without damping, for the run
COUPLINGS = ("parallel", "held", "predicted parallel", "predicted sequential", "extrapolated", "iterated")


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


def by_size(sizes, errors) -> str:
    """Errors by communication step, us, where the coupling stood."""
    return "errors " + ", ".join(f"{error:.1e} at {1e6 * size:.3g}" for size, error in zip(sizes, errors) if error < 3.0)


def longest_stable(gears, begin, coupling) -> float:
    """Longest of the steps 1, 1.25, 1.25^2, ... us that the coupling stands, s."""
    size = 1e-6
    while size < 1e-4 and stands(gears, begin, size, coupling):
        size *= 1.25
    return size / 1.25


def main() -> None:
    figure, (left, right) = new_figure(2, 13, 5.0)
    with closing(Gears()) as gears:
        compare(gears, left)
    books(right)
    save(figure, "cosimulation")
    for damped in (False, True):
        print(f"as one system, {'damped' if damped else 'undamped'}: {in_words(balance(damped))}")


def books(axis) -> None:
    """Energy and momentum that each coupling creates or destroys, over the communication step, nothing damped."""
    sizes = SIZES[BOOKED]
    for n, coupling in enumerate(COUPLINGS):
        rows = [coupling_balance(size, coupling) for size in sizes]
        for name, style in (("energy over mesh", "o-"), ("momentum", "s--")):
            strays = np.array([row[name] for row in rows])
            order = np.log2(strays[-2] / strays[-1])
            kind = name.split()[0]
            axis.loglog(1e6 * sizes, strays, style, color=f"C{n}", ms=4, label=f"{kind}, {coupling}, order {order:.2f}")
            print(f"{coupling}, undamped: {kind} order {order:.2f}, strays {strays[-1]:.1e} at {1e6 * sizes[-1]:.2f} us, "
                  f"{strays[2]:.1e} at {1e6 * sizes[2]:.2f} us")
    axis.set(xlabel="communication step (µs)", ylabel="energy (of the mesh's), momentum (of the impulse)", ylim=(1e-10, 10.0))
    axis.set_xticks(1e6 * sizes, [f"{1e6 * size:g}" for size in sizes])
    axis.xaxis.set_minor_locator(NullLocator())
    axis.legend(fontsize=8)


def compare(gears: Gears, axis) -> None:
    """Error over the communication step, of our own master and of the hosts."""
    begin = start(gears)
    reference = monolithic(gears, begin, DURATION, 2.5e-7)
    for coupling in COUPLINGS:
        sizes = SIZES[ENOUGH] if coupling in ("extrapolated", "iterated") else SIZES
        errors, order = orders(gears, begin, reference, coupling, sizes)
        axis.loglog(1e6 * sizes, np.where(errors < 3.0, errors, np.nan), "o-", label=f"{coupling}, order {order:.2f}")
        print(f"{coupling}: order {order:.2f}, {by_size(sizes, errors)}")
    for (name, host), coupling in product(ssp.HOSTS.items(), ("held", "parallel", "automatic")):
        sizes = SIZES[5:] if coupling == "held" else SIZES[2:]
        file = ssp.build(gears, begin, coupling)
        errors = []
        for size in sizes:
            errors.append(distance(host(file, DURATION, size), reference, ssp.COLUMNS))
        print(f"{name}, SSP of three FMUs, {coupling}: order {np.log2(errors[-2] / errors[-1]):.2f}, {by_size(sizes, errors)}")
        marker = {"Ecos": "+", "libcosim": "x"}[name]
        color = {"held": "r", "parallel": "k", "automatic": "b"}[coupling]
        axis.loglog(1e6 * sizes, errors, color + marker, ms=10, label=f"{name}, SSP, coupling = {coupling}")
    packed = packed_step()
    axis.axvline(1e6 * packed, color="grey", lw=0.8)
    axis.text(1e6 * packed, 0.3, " packed step", color="grey")
    print(f"packed step {1e6 * packed:.1f} us; largest error at it: " + ", ".join(
        f"{coupling} {distance(cosimulate(gears, begin, DURATION, packed, coupling), reference):.1e}" for coupling in COUPLINGS[2:4]))
    for coupling in COUPLINGS[:4]:
        print(f"{coupling}: stands {1e6 * longest_stable(gears, begin, coupling):.1f} us")
    axis.set(xlabel="communication step (µs)", ylabel="largest error of the run over the elastic displacement", ylim=(1e-8, 1.0))
    axis.legend()


if __name__ == "__main__":
    main()
