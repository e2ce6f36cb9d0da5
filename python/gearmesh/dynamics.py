"""Two gears in motion: the integrator and the co-simulation master."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .errors import GearmeshError
from .pair import GearPair

Array = NDArray[np.float64]
State = TypeVar("State")
Rate = Callable[[float, Array], Array]


@dataclass(frozen=True)
class History:
    """Signals over time beside the motion of a shaft.

    Attributes
    ----------
    time_s, angle_rad, speed_rpm : (n,)
        Evenly spaced times; angle and speed of the shaft that orders refer to.
    signals : dict of (n,)
        By name, with the unit in it.
    """

    time_s: Array
    angle_rad: Array
    speed_rpm: Array
    signals: dict[str, Array]

    def __getitem__(self, name: str) -> Array:
        """A signal by name.

        Raises
        ------
        GearmeshError
            There is none of this name.
        """
        if name not in self.signals:
            raise GearmeshError(f"no signal {name!r}: choose one of {', '.join(self.signals)}")
        return self.signals[name]

    def cut(self, keep: slice | Array) -> History:
        """The rows of a slice or of a mask that is true without a gap."""
        return History(
            self.time_s[keep], self.angle_rad[keep], self.speed_rpm[keep], {name: column[keep] for name, column in self.signals.items()}
        )


class Turning:
    """Two gears that turn about fixed axes: angles and speeds in, moments about the axes out.

    Parameters
    ----------
    pair
        An instance, initialised at the latest when this is called.
    step
        Communication step, s, of co-simulation; left out for Model Exchange.
    """

    def __init__(self, pair: GearPair, step: float | None = None) -> None:
        self.pair, self.step = pair, step
        first = [[pair.input[f"gear{gear}.{name}[1]"] for name in ("angles", "angularVelocity")] for gear in (1, 2)]
        (self._spin1, self._rate1), (self._spin2, self._rate2) = [(angle + 2, slice(rate, rate + 3)) for angle, rate in first]
        self._tilt2 = slice(self._spin2 - 2, self._spin2)
        self._moment1, moment2 = pair.output["gear1.moment[3]"], pair.output["gear2.moment[1]"]
        self._moment2 = slice(moment2, moment2 + 3)
        self._axis = (0.0, 0.0, 1.0)

    def tilt(self, alpha: float, beta: float) -> None:
        """Tilts the axis of gear 2 by its first two Cardan angles, rad."""
        self.pair.u[self._tilt2] = alpha, beta
        self._axis = math.sin(beta), -math.sin(alpha) * math.cos(beta), math.cos(alpha) * math.cos(beta)

    def place(self, angle1: float, speed1: float, angle2: float, speed2: float) -> None:
        """Writes the motion into the inputs, rad and rad/s."""
        u, (x, y, z) = self.pair.u, self._axis
        u[self._spin1], u[self._rate1] = angle1, (0.0, 0.0, speed1)
        u[self._spin2], u[self._rate2] = angle2, (speed2 * x, speed2 * y, speed2 * z)

    def moments(self) -> tuple[float, float]:
        """On gear 1 and on gear 2 about their axes, N m, as last fetched."""
        (a, b, c), (x, y, z) = self.pair.y[self._moment2], self._axis
        return self.pair.y[self._moment1], a * x + b * y + c * z

    def resting(self, torque: float, angle1: float = 0.0, start: float = 0.0) -> float:
        """Angle of gear 2 at which the teeth hold a torque on it at rest, by bisection.

        Parameters
        ----------
        torque
            On gear 2, N m, not 0; its sign says which flank.
        angle1, start
            Angle of gear 1, and one of gear 2 at which the teeth hold less or are apart, rad.

        Returns
        -------
        float
            rad.

        Raises
        ------
        GearmeshError
            The teeth do not hold it within 0.1 rad.
        """
        low, high = 0.0, math.copysign(1e-6, torque)

        def holds(way: float) -> bool:
            return (self(angle1, 0.0, start + way, 0.0)[1] + torque) * torque <= 0.0

        while not holds(high):
            low, high = high, 2.0 * high
            if abs(high) > 0.1:
                raise GearmeshError(f"torque = {torque}: the teeth do not hold it within 0.1 rad from {start}")
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if holds(middle) else (middle, high)
        return start + low

    def __call__(self, *motion: float) -> tuple[float, float]:
        """Places the gears and evaluates the FMU, or steps it: moments on gear 1 and 2."""
        self.place(*motion)
        if self.step:
            self.pair.step(self.step)
        else:
            self.pair.evaluate(self.pair.time)
        return self.moments()


def runge_kutta(rate: Rate, time: float, state: Array, step: float, first: Array | None = None) -> Array:
    """One step of the classical Runge-Kutta method.

    Parameters
    ----------
    rate
        Derivative of the state from time, s, and state.
    time, state, step
        Where the step starts, and its length, s.
    first
        `rate(time, state)`, where it is at hand.

    Returns
    -------
    ndarray
        The state after the step.
    """
    k1 = rate(time, state) if first is None else first
    k2 = rate(time + 0.5 * step, state + 0.5 * step * k1)
    k3 = rate(time + 0.5 * step, state + 0.5 * step * k2)
    k4 = rate(time + step, state + step * k3)
    return state + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)


def integrate(
    rate: Rate, state: Array, step: float, count: int, *, every: int = 1, accounts: Callable[[float, Array], Sequence[float]] | None = None
) -> Iterator[tuple[float, Array, Array]]:
    """Runs an assembly by Runge-Kutta 4, for FMUs through Model Exchange.

    Parameters
    ----------
    rate
        Derivative of the state from time, s, and state; evaluates the FMUs.
    state, step, count
        State at time 0, step in s, number of steps.
    every
        Yields every so many steps, the start and the end included.
    accounts
        Further integrands of time and state, such as powers; called right after `rate` at the same stage, so that the
        FMUs hold its loads.

    Yields
    ------
    time, state, integrals
        Of `accounts`, from 0 on. At each yield the FMUs hold the loads of the state.
    """
    size = len(state)
    more = accounts or (lambda _time, _state: ())

    def both(time: float, z: Array) -> Array:
        derivative = rate(time, z[:size])
        return np.concatenate([derivative, more(time, z[:size])]) if accounts else derivative

    first = both(0.0, state)
    z = np.concatenate([state, np.zeros(len(first) - size)])
    for n in range(count + 1):
        first = both(n * step, z)
        if n % every == 0:
            yield n * step, z[:size], z[size:]
        if n < count:
            z = runge_kutta(both, n * step, z, step, first)


def cosimulate(
    pair: GearPair,
    place: Callable[[float, State], None],
    advance: Callable[[float, State], State],
    state: State,
    step: float,
    count: int,
    *,
    late: bool | None = None,
) -> Iterator[tuple[float, State]]:
    """Steps an FMU and the bodies on it, which exchange at communication points.

    Parameters
    ----------
    pair
        An initialised co-simulation instance; its time goes on.
    place
        Writes the inputs of the FMU from time, s, and state of the bodies.
    advance
        State of the bodies one step later, under the loads that `pair.y` has during the call, constant over the step.
    state, step, count
        State at the start, step in s, number of steps.
    late
        Whether the loads act one step late, as where a master steps all at once; by default with `coupling` = parallel.

    Yields
    ------
    time, state
        At the start of each step, from 0 on, after the FMU has stepped.
    """
    late = pair.parameters["coupling"] == "parallel" if late is None else late
    start, before = pair.time, None
    for n in range(count):
        place(n * step, state)
        pair.time = start + n * step
        pair.step(step)
        yield n * step, state
        if late:
            given = list(pair.y)
            pair.y[:], before = before or given, given  # the first ones act at once
        state = advance(n * step, state)
        if late:
            pair.y[:] = given
