"""Energy and momentum of the run as one system, and what each coupling adds to them."""

from __future__ import annotations

from contextlib import closing
from itertools import islice

import numpy as np
from gearmesh import integrate
from gearmesh.energy import Ledger, mesh_loss

from . import subsystems as sub
from .masters import DRIVE, Gears, communication_points, coupled, start

MASS = np.array([sub.MASSES[0], sub.MASSES[0], sub.INERTIAS[0], sub.MASSES[1], sub.MASSES[1], sub.INERTIAS[1]])


def energies(x: np.ndarray, h: np.ndarray) -> tuple[float, float]:
    """Kinetic and elastic, J, of shafts, bearings and housing."""
    omega2 = -np.diag(sub.housing().a[sub.MODES :, : sub.MODES])
    modes, rates = np.split(h, 2)
    shift = np.concatenate([x[[0, 3]], x[[1, 4]] - sub.seat_motion(h)[:2]])
    return 0.5 * (MASS @ x[6:] ** 2 + rates @ rates), 0.5 * (sub.BEARING[0] * shift @ shift + omega2 @ modes**2)


def balance(damped: bool, duration: float = 2e-3, step: float = 5e-7) -> dict[str, float]:
    """What energy, linear momentum of the shafts and loads stray, over the run; undamped: teeth, bearings and housing."""
    k, c = sub.bearing(damped)
    losses = -np.diag(sub.housing(damped=damped).a[sub.MODES :, sub.MODES :])

    def accounts(_, z):
        """Power of the drive, lost in mesh, bearings and housing; impulse of the bearings on the shafts."""
        x, h = z[:12], z[12:]
        seats = sub.seat_motion(h)
        slip = np.concatenate([x[[6, 9]], x[[7, 10]] - seats[2:]])
        lost = mesh_loss(gears.pair) + c * slip @ slip + losses @ h[sub.MODES :] ** 2
        across = -(k * x[[0, 3]] + c * x[[6, 9]]).sum()
        return [DRIVE @ x[6:], lost, across, -sub.bearing_forces(x, seats, damped).sum()]

    ledger = Ledger(duration)
    with closing(Gears(None if damped else {"damping": 0.0})) as gears:
        rate, begin = coupled(gears, damped), np.concatenate(start(gears))
        for _, z, (work, lost, *impulse) in integrate(rate, begin, step, round(duration / step), every=80, accounts=accounts):
            x, h = z[:12], z[12:]
            momentum = [(MASS * x[6:])[[i, 3 + i]].sum() for i in (0, 1)]
            ledger.enter([gears.pair], *energies(x, h), lost, work, np.subtract(momentum, impulse))
    return ledger.found()


def coupling_balance(size: float, coupling: str, duration: float = 1.024e-3, instants: int = 32) -> dict[str, float]:
    """What a coupling creates or destroys in steps of `size` s, over the run: nothing is damped, so nothing else does.

    Subsystems step exactly and the drive is constant, so the energy strays by the coupling alone. Momentum along y is
    that of the shafts, less what the bearings handed to the seats: the two sides of a border see different forces.
    """
    ledger, every = Ledger(duration), round(duration / size / instants)
    with closing(Gears({"damping": 0.0})) as gears:
        points = communication_points(gears, start(gears), size, coupling, damped=False)
        for x, h, impulse in islice(points, 0, round(duration / size) + 1, every):
            gears(x)
            momentum = (MASS * x[6:])[[1, 4]].sum() + impulse.sum()
            ledger.enter([gears.pair], *energies(x, h), 0.0, DRIVE @ x[:6], momentum)
    return ledger.found()
