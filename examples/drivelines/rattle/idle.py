"""An idle gear that rattles: its restitution, its motion over a shaking gear, and the same inside a two-stage gearbox."""

from __future__ import annotations

from contextlib import contextmanager
from functools import cache

import numpy as np
from gearmesh import Turning, cosimulate, energy, integrate

from examples.shared.files import opened, shipped

# The idle pair: fzg-c, 16 teeth on the countershaft, 24 on the idle gear.
INERTIA, BASE_RADIUS = 1.5e-3, 101.4868e-3 / 2  # kg m^2 and m of the idle gear
RATIO = 16 / 24
DRAG = 0.1  # N m
SHAKE = 2.0 * np.pi * 100.0  # rad/s
SPEED = 5.0  # rad/s, mean, of the countershaft: slow, so that the mesh itself excites next to nothing
# Oil and idle clearance take more energy than teeth under load: damping chosen for a restitution near 0.6, and from
# small forces on, since impacts of an idle gear are light.
IDLE = {"damping": 2400.0, "dampingOnset": 0.0005}
STEP = 1e-5


@contextmanager
def turning(name: str, parameters: dict, coupling: str | None = None):
    """A pair whose gears turn on fixed axes; with a `coupling` by co-simulation, in steps of `STEP`."""
    choices, interface = (parameters | {"coupling": coupling}, "co-simulation") if coupling else (parameters, "model-exchange")
    with opened(shipped(name), choices, interface) as pair:
        yield Turning(pair, STEP if coupling else None)


@cache
def restitution(speed: float = 0.03) -> float:
    """Speed after over speed before an impact at `speed`, m/s on the line of action, gear 1 held."""
    with turning("fzg-c", IDLE) as mesh:

        def rate(_, s):
            return np.array([s[1], mesh(0.0, 0.0, *s)[1] / INERTIA])

        # Gear 2 backwards onto the flank of gear 1 that turns it forwards.
        for _, s, _ in integrate(rate, np.array([-2e-6, speed]) / BASE_RADIUS, 2e-6, 4000):
            if s[1] < 0.0 and mesh.moments()[1] == 0.0:
                return float(-s[1] * BASE_RADIUS / speed)
    raise RuntimeError("gear 2 did not come back")


def period_one(r: float) -> tuple[float, float]:
    """Gamma between which one impact in every period is stable, for impacts without duration."""
    low = np.pi * (1.0 - r) / (1.0 + r)
    return low, float(np.sqrt(low**2 + 4.0 * (1.0 + r * r) ** 2 / (1.0 + r) ** 4))


def shaken(gamma: float, periods: int = 60, kept: int = 12, coupling: str | None = None) -> np.ndarray:
    """Gap between the flanks, m, once a period in mid-flight, over the last `kept` periods.

    Gear 1 turns with a swing of acceleration gamma DRAG / INERTIA at the idle gear, which starts, where there is one, on
    the orbit with one impact a period (impacts without duration), else at rest on its flank. With a `coupling` the loads
    cross a border once a step, those of a `parallel` master one step late.
    """
    fall = DRAG / INERTIA
    amplitude, period = gamma * fall / SHAKE**2, 2.0 * np.pi / SHAKE
    cosine = period_one(restitution())[0] / gamma
    phase = np.arccos(min(cosine, 1.0))
    bounce = 0.5 * fall * period if cosine < 1.0 else amplitude * SHAKE
    start, count = np.array([0.0, -RATIO * SPEED - bounce]), round(period / STEP)

    def drive(time):
        return (
            SPEED * time + amplitude / RATIO * (np.sin(SHAKE * time + phase) - np.sin(phase)),
            SPEED + amplitude / RATIO * SHAKE * np.cos(SHAKE * time + phase),
        )

    with turning("fzg-c", IDLE, coupling) as mesh:

        def acceleration():
            return (mesh.moments()[1] + DRAG) / INERTIA

        def rate(time, s):
            mesh(*drive(time), *s)
            return np.array([s[1], acceleration()])

        def advance(_, s):
            return s + STEP * np.array([s[1] + 0.5 * STEP * acceleration(), acceleration()])

        if coupling:
            run = cosimulate(mesh.pair, lambda time, s: mesh.place(*drive(time), *s), advance, start, STEP, periods * count)
        else:
            run = integrate(rate, start, STEP, periods * count - 1)
        gaps = [-mesh.pair["mesh.transmissionError"] for n, _ in enumerate(run) if n % count == count // 2]
        return np.array(gaps[-kept:])


COUNTERSHAFT = 6e-3  # kg m^2
LOADED_TORQUE = 40.0  # N m on the countershaft


@contextmanager
def gearbox_of(gamma: float, damped: bool = True):
    """Two stages: the input turns as imposed, the countershaft carries gear 2 of the loaded pair (helical-25-47) and gear 1
    of the idle pair. The input swings as much as the rigid ratio would make `gamma` at the idle gear.

    Both pairs; rate and accounts (power of input, torque and drag, and what both meshes lose) for `integrate`; and the start. The state
    has angle and speed of the countershaft, then of the idle gear.
    """
    undamped, first = {} if damped else {"damping": 0.0}, 25 / 47
    amplitude = gamma * DRAG / INERTIA / SHAKE**2 / RATIO / first
    with turning("helical-25-47", undamped) as loaded, turning("fzg-c", IDLE | undamped) as idle:

        def drive(time):
            """Angle and speed of the input."""
            return SPEED / first * time + amplitude * np.sin(SHAKE * time), SPEED / first + amplitude * SHAKE * np.cos(SHAKE * time)

        def rate(time, s):
            on_counter, (back, on_idle) = loaded(*drive(time), s[0], s[1])[1], idle(*s)
            # The countershaft turns backwards, the idle gear forwards: the drag pulls it back.
            return np.array([s[1], (on_counter + back + LOADED_TORQUE) / COUNTERSHAFT, s[3], (on_idle - DRAG) / INERTIA])

        def accounts(time, s):
            fed = -loaded.moments()[0] * drive(time)[1] + LOADED_TORQUE * s[1] - DRAG * s[3]
            return [fed, energy.mesh_loss(loaded.pair) + energy.mesh_loss(idle.pair)]

        yield (loaded.pair, idle.pair), rate, accounts, np.array([0.0, -SPEED, 0.0, RATIO * SPEED])


def gearbox(gamma: float, periods: int = 30) -> tuple[float, float]:
    """Shares of time that the loaded and the idle pair of the gearbox are apart, over the last ten periods."""
    count = round(2.0 * np.pi / SHAKE / STEP)
    with gearbox_of(gamma) as (pairs, rate, _, start):
        apart = [[pair.flank == 0 for pair in pairs] for _ in integrate(rate, start, STEP, periods * count)]
    return tuple(np.mean(apart[-10 * count :], axis=0))


def balance(damped: bool, gamma: float = 1.2, duration: float = 0.03, step: float = 2.5e-6) -> dict[str, float]:
    """The gearbox from rest on no load, rattling: what energy and loads stray, over the run."""
    with gearbox_of(gamma, damped) as (pairs, rate, accounts, start):
        return energy.balance(pairs, rate, start, step, duration, accounts, lambda s: 0.5 * (COUNTERSHAFT * s[1] ** 2 + INERTIA * s[3] ** 2))
