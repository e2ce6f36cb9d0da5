"""An idle gear that rattles: its restitution, its motion over a shaking gear, and the same inside a two-stage gearbox."""

from __future__ import annotations

from contextlib import closing

import numpy as np
from gearmesh import GearPair

from ..balance import Ledger, followed, mesh_loss
from ..files import shipped
from ..integrate import runge_kutta

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


class Turning:
    """One pair of which both gears turn on fixed axes; with a `coupling` by co-simulation, in steps of `STEP`."""

    def __init__(self, name: str, parameters: dict, coupling: str | None = None):
        choices = parameters | ({"coupling": coupling} if coupling else {})
        self.pair = GearPair(shipped(name), choices, "co-simulation" if coupling else "model-exchange")
        self.pair.initialize()
        self.ask = (lambda: self.pair.step(STEP)) if coupling else (lambda: self.pair.evaluate(0.0))
        at_input, at_output = self.pair.input, self.pair.output
        self.places = [at_input[f"gear{g}.{q}[3]"] for g in (1, 2) for q in ("angles", "angularVelocity")]
        self.moments = [at_output[f"gear{g}.moment[3]"] for g in (1, 2)]

    def __call__(self, *motion: float) -> tuple[float, float]:
        """Moments on gear 1 and 2 at angle and speed of gear 1, then of gear 2."""
        u, y = self.pair.u, self.pair.y
        for place, value in zip(self.places, motion):
            u[place] = value
        self.ask()
        return y[self.moments[0]], y[self.moments[1]]

    def close(self) -> None:
        self.pair.close()


def restitution(speed: float = 0.03) -> float:
    """Speed after over speed before an impact at `speed`, m/s on the line of action, gear 1 held."""
    mesh = Turning("fzg-c", IDLE)
    try:
        # Gear 2 backwards onto the flank of gear 1 that turns it forwards.
        state = np.array([-2e-6 / BASE_RADIUS, speed / BASE_RADIUS])

        def rate(_, s):
            return np.array([s[1], mesh(0.0, 0.0, s[0], s[1])[1] / INERTIA])

        for _ in range(4000):
            state = runge_kutta(rate, 0.0, state, 2e-6)
            if state[1] < 0.0 and mesh(0.0, 0.0, *state)[1] == 0.0:
                return float(-state[1] * BASE_RADIUS / speed)
        raise RuntimeError("gear 2 did not come back")
    finally:
        mesh.close()


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
    mesh = Turning("fzg-c", IDLE, coupling)
    fall = DRAG / INERTIA
    amplitude, period = gamma * fall / SHAKE**2, 2.0 * np.pi / SHAKE
    cosine = period_one(restitution())[0] / gamma
    phase = np.arccos(min(cosine, 1.0))
    bounce = 0.5 * fall * period if cosine < 1.0 else amplitude * SHAKE
    try:

        def drive(time):
            return (
                SPEED * time + amplitude / RATIO * (np.sin(SHAKE * time + phase) - np.sin(phase)),
                SPEED + amplitude / RATIO * SHAKE * np.cos(SHAKE * time + phase),
            )

        def rate(time, s):
            return np.array([s[1], (mesh(*drive(time), *s)[1] + DRAG) / INERTIA])

        state = np.array([0.0, -RATIO * SPEED - bounce])
        count = round(period / STEP)
        out, late = [], 0.0
        for n in range(periods * count):
            now = mesh(*drive(n * STEP), *state)[1]
            if n % count == count // 2:
                out.append(-mesh.pair["mesh.transmissionError"])
            if coupling:
                acceleration = ((late if coupling == "parallel" else now) + DRAG) / INERTIA
                late = now
                state = state + STEP * np.array([state[1] + 0.5 * STEP * acceleration, acceleration])
            else:
                state = runge_kutta(rate, n * STEP, state, STEP)
        return np.array(out[-kept:])
    finally:
        mesh.close()


COUNTERSHAFT = 6e-3  # kg m^2
LOADED_TORQUE = 40.0  # N m on the countershaft


class Gearbox:
    """Two stages: the input turns as imposed, the countershaft carries gear 2 of the loaded pair (helical-25-47) and gear 1
    of the idle pair. The state has angle and speed of the countershaft, then of the idle gear.

    The input swings as much as the rigid ratio would make `gamma` at the idle gear.
    """

    def __init__(self, gamma: float, damped: bool = True):
        undamped = {} if damped else {"damping": 0.0}
        self.loaded, self.idle = Turning("helical-25-47", undamped), Turning("fzg-c", IDLE | undamped)
        self.first = 25 / 47
        self.amplitude = gamma * DRAG / INERTIA / SHAKE**2 / RATIO / self.first
        self.start = np.array([0.0, -SPEED, 0.0, RATIO * SPEED])

    def drive(self, time: float) -> tuple[float, float]:
        """Angle and speed of the input."""
        return (
            SPEED / self.first * time + self.amplitude * np.sin(SHAKE * time),
            SPEED / self.first + self.amplitude * SHAKE * np.cos(SHAKE * time),
        )

    def rate(self, time: float, s: np.ndarray) -> np.ndarray:
        self.on_input, on_counter = self.loaded(*self.drive(time), s[0], s[1])
        back, on_idle = self.idle(*s)
        # The countershaft turns backwards, the idle gear forwards: the drag pulls it back.
        return np.array([s[1], (on_counter + back + LOADED_TORQUE) / COUNTERSHAFT, s[3], (on_idle - DRAG) / INERTIA])

    def accounts(self, time: float, s: np.ndarray) -> list[float]:
        """Power of input, torque and drag, and what both meshes lose."""
        fed = -self.on_input * self.drive(time)[1] + LOADED_TORQUE * s[1] - DRAG * s[3]
        return [fed, mesh_loss(self.loaded.pair) + mesh_loss(self.idle.pair)]

    def close(self) -> None:
        self.loaded.close()
        self.idle.close()


def gearbox(gamma: float, periods: int = 30) -> tuple[float, float]:
    """Shares of time that the loaded and the idle pair of the gearbox are apart."""
    with closing(Gearbox(gamma)) as box:
        state = box.start
        count = round(2.0 * np.pi / SHAKE / STEP)
        apart = np.zeros(2)
        for n in range(periods * count):
            state = runge_kutta(box.rate, n * STEP, state, STEP)
            if n >= (periods - 10) * count:
                apart += box.loaded.pair.flank == 0, box.idle.pair.flank == 0
        return tuple(apart / (10 * count))


def balance(damped: bool, gamma: float = 1.2, duration: float = 0.03, step: float = 2.5e-6) -> dict[str, float]:
    """The gearbox from rest on no load, rattling: what energy and loads stray, over the run."""
    ledger, apart = Ledger(duration), []
    with closing(Gearbox(gamma, damped)) as box:
        pairs = (box.loaded.pair, box.idle.pair)
        for _, s, (work, lost) in followed(box.rate, box.accounts, box.start, step, round(duration / step), 40):
            apart.append(box.idle.pair.flank == 0)
            ledger.enter(pairs, 0.5 * (COUNTERSHAFT * s[1] ** 2 + INERTIA * s[3] ** 2), 0.0, lost, work)
    return ledger.found() | {"share of time apart": float(np.mean(apart))}
