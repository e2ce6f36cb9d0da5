"""Two gears in motion: the integrator, the co-simulation master, and the run-up of two discs coupled by an FMU."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .errors import GearmeshError
from .pair import GearPair

Array = NDArray[np.float64]
State = TypeVar("State")
Rate = Callable[[float, Array], Array]
RPM = math.pi / 30.0  # rad/s
UM = 1e6


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
        """A signal by name."""
        return self.signals[name]

    def cut(self, keep: slice | Array) -> History:
        """The rows of a slice or of a mask that is true without a gap."""
        return History(
            self.time_s[keep], self.angle_rad[keep], self.speed_rpm[keep], {name: column[keep] for name, column in self.signals.items()}
        )


@dataclass(frozen=True)
class RunUp:
    """A slow run-up and the run-down from where it ended; orders refer to gear 1.

    Attributes
    ----------
    up, down : History
        With `transmission_error_um` on the operating pitch circle, > 0 with the drive flank compressed,
        `tangential_force_n`, `acceleration_gear1_rad_per_s2` and `acceleration_gear2_rad_per_s2` without the mean one.
    natural_frequency_hz, resonance_rpm
        Of both discs on the mean tangent stiffness at nominal torque, and the speed at which the mesh frequency meets it.
    damping_n_s_per_m, step_s, sweep_s
        Of the mesh, tangential; the communication step; time of each sweep.
    """

    up: History
    down: History
    natural_frequency_hz: float
    resonance_rpm: float
    damping_n_s_per_m: float
    step_s: float
    sweep_s: float


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


def run_up(
    unit: str | Path,
    inertias: tuple[float, float],
    damping: float,
    torque: float,
    speeds: tuple[float, float],
    *,
    sweep_s: float | None = None,
    step_s: float | None = None,
    parameters: Mapping[str, float | bool | str] | None = None,
) -> RunUp:
    """Sweeps the speed of two discs that an FMU couples evenly up and down again, so that both branches of a jump show.

    Both discs turn freely about fixed axes. The drive brings the torque and what speeds the discs up, so that the teeth
    carry the same mean torque at every speed. The FMU steps first and predicts its loads (`coupling` = sequential).

    Parameters
    ----------
    unit
        FMU of the pair.
    inertias
        Of both discs with all that turns with them, kg m^2; `math.inf` for one that turns as imposed.
    damping
        Damping ratio of both discs on the mean mesh stiffness, such as 0.03; sets the FMU's `damping`.
    torque
        Mean torque on gear 1, N m, > 0 on the drive flank.
    speeds
        Of gear 1, rpm, from lowest to highest.
    sweep_s
        Time of each sweep; by default twenty decay times pass while the mesh frequency crosses the resonance's width.
    step_s
        Communication step; by default 0.07 rad of the natural frequency, or a twentieth of the shortest mesh cycle: where teeth part, the end of the upper
        branch is within a percent then.
    parameters
        Of the FMU, beside those.

    Returns
    -------
    RunUp

    Raises
    ------
    GearmeshError
        An argument is out of range, or the FMU refused a pose.
    """
    low, high = speeds
    if not 0.0 <= low < high:
        raise GearmeshError(f"speeds = {speeds}: give the lowest and the highest, rpm, 0 or more")
    if not (torque > 0.0 and damping >= 0.0 and min(inertias) > 0.0 and min(inertias) < math.inf):
        raise GearmeshError(f"inertias = {inertias}, damping = {damping}, torque = {torque}: give numbers > 0 (damping 0 or more)")
    if sweep_s is None and damping == 0.0:
        raise GearmeshError("damping = 0: nothing decays, give sweep_s")
    with GearPair(unit, {"coupling": "sequential", **(parameters or {})}) as pair:
        geometry = pair.geometry
        stiffness, mass = float(pair.parameters["constantStiffness"]), geometry.reduced_mass(inertias)
        omega = math.sqrt(stiffness / mass)
        sweep_s = sweep_s or 20.0 / (2.0 * (damping * omega) ** 2) * (high - low) * RPM * geometry.teeth[0]
        step = step_s or min(0.07 / omega, 2.0 * math.pi / (20.0 * high * RPM * geometry.teeth[0]))
        pair.set_parameter("damping", 2.0 * damping * math.sqrt(stiffness * mass))
        pair.set_parameter("effectiveMass", geometry.reduced_mass(inertias, geometry.base_radii))
        rest = _Discs(pair, inertias, torque, torque / geometry.pitch_radii[0] / stiffness, step)
        settle = min(8.0 / (damping * omega), sweep_s) if damping else 0.0
        rest.sweep(low, low, settle)
        up, down = rest.sweep(low, high, sweep_s), rest.sweep(high, low, sweep_s)
        resonance = omega / geometry.teeth[0] / RPM
        return RunUp(up, down, omega / (2.0 * math.pi), resonance, float(pair.parameters["damping"]), step, sweep_s)


class _Discs:
    """Two discs on an FMU; their state is angle and rate of each beside the mean motion."""

    def __init__(self, pair: GearPair, inertias: tuple[float, float], torque: float, approach: float, step: float) -> None:
        """Starts in equilibrium: `approach`, m, on the pitch circle."""
        ratio = pair.geometry.ratio
        self._turning, self._ratio, self._step = Turning(pair, step), ratio, step
        self._inverse = 1.0 / inertias[0], 1.0 / inertias[1]
        self._torques = torque, -torque / ratio
        self._angle = 0.0  # of gear 1 in its mean motion
        share = inertias[1] < math.inf  # which disc starts turned against the other
        pitch = pair.geometry.pitch_radii
        self._state = (0.0, 0.0, -math.copysign(approach / pitch[1], ratio), 0.0) if share else (approach / pitch[0], 0.0, 0.0, 0.0)
        pair.initialize()

    def sweep(self, start: float, end: float, duration: float) -> History:
        """Evenly from `start` to `end`, rpm."""
        turning, pair, ratio, step = self._turning, self._turning.pair, self._ratio, self._step
        count = round(duration / step)
        first, change = start * RPM, (end - start) * RPM / max(count * step, step)
        (inverse1, inverse2), (torque1, torque2) = self._inverse, self._torques
        angle0 = self._angle
        rows = np.empty((count, 6))
        at = [pair.output[name] for name in ("mesh.transmissionError", "mesh.tangentialForce")]

        def place(time: float, state: tuple[float, float, float, float]) -> None:
            angle, speed = angle0 + time * (first + 0.5 * change * time), first + change * time
            turning.place(angle + state[0], speed + state[1], ratio * angle + state[2], ratio * speed + state[3])

        def advance(_: float, state: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
            moment1, moment2 = turning.moments()
            a1, a2 = (torque1 + moment1) * inverse1, (torque2 + moment2) * inverse2
            q1, v1, q2, v2 = state
            return q1 + step * (v1 + 0.5 * step * a1), v1 + step * a1, q2 + step * (v2 + 0.5 * step * a2), v2 + step * a2

        y = pair.y
        for n, (_, state) in enumerate(cosimulate(pair, place, advance, self._state, step, count)):
            moment1, moment2 = turning.moments()
            rows[n] = state[0], state[1], y[at[0]], y[at[1]], moment1, moment2
        if count:
            self._state = advance(0.0, state)
        time = step * np.arange(count)
        self._angle += count * step * (first + 0.5 * change * count * step)
        signals = {
            "transmission_error_um": UM * rows[:, 2],
            "tangential_force_n": rows[:, 3],
            "acceleration_gear1_rad_per_s2": (torque1 + rows[:, 4]) * inverse1,
            "acceleration_gear2_rad_per_s2": (torque2 + rows[:, 5]) * inverse2,
        }
        angle = angle0 + time * (first + 0.5 * change * time) + rows[:, 0]
        return History(time, angle, (first + change * time + rows[:, 1]) / RPM, signals)
