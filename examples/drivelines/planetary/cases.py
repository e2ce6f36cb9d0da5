"""Phases, harmonics, load sharing and balances of the stage, each beside its closed form."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from gearmesh.energy import Ledger

from .phase import ALPHA_T
from .stage import CENTER_DISTANCE, IN_PHASE, PITCH, TEETH, Stage

TORQUE = -56.7e3  # N m on the sun: 750 kW at 22.1 rpm of the carrier
CARRIER_SPEED = 22.1 * np.pi / 30.0
STIFF = 10.0  # m, span of bearings that let no planet tilt
FLOATING = 1e6  # N/m, the support left to a floating sun: 10 N at 10 um


def measured_phase() -> float:
    """Lag of the ring mesh behind the sun mesh from the FMUs' mesh positions, at a hundredth of the torque."""
    with Stage() as stage:
        stage.equilibrium(0.0, TORQUE / 100.0)
        sun, ring = (pair["mesh.position"] for pair in stage.meshes[0])
        # Both fall while the carrier turns: the sun pushes on its coast flank, the planet turns backwards.
        return float((ring - sun + 0.5) % 1.0 - 0.5)


@dataclass(frozen=True)
class Cycle:
    """At rest at even steps of a mesh cycle, sun and carrier on fixed axes; a row each.

    `error` is the angle of the sun beyond the kinematic one, rad; `lateral` the force of the meshes on the sun, x and y, N;
    `tilting` the moment on the first pin about its radial and its tangential direction, N m; `tilt` of the first planet about the
    latter, rad; `thrust` the axial force on the sun, N.
    """

    error: np.ndarray
    lateral: np.ndarray
    tilting: np.ndarray
    tilt: np.ndarray
    thrust: np.ndarray


def at_rest(stage: Stage, positions: int, guess: np.ndarray | None = None) -> Iterator[tuple[float, np.ndarray]]:
    """Angle of the carrier and coordinates under the nominal torque, at even steps of a mesh cycle."""
    for carrier in 2.0 * np.pi / TEETH[2] * np.arange(positions) / positions:
        q = stage.equilibrium(carrier, TORQUE, guess)
        guess = q - stage.rolled(carrier)
        yield carrier, q


def cycle(places: tuple[int, ...] = IN_PHASE, positions: int = 32, **options) -> Cycle:
    """The stage under the nominal torque; `options` of `Stage`."""
    rows = np.empty((positions, 7))
    with Stage(places, **options) as stage:
        for row, (carrier, q) in zip(rows, at_rest(stage, positions)):
            load, beyond = stage.stiffness() * stage.shift(q), q - stage.rolled(carrier)
            axes = np.array([[np.cos(carrier), -np.sin(carrier)], [np.sin(carrier), np.cos(carrier)]])
            row[:] = beyond[5], *load[0, :2], *(load[1, 3:5] @ axes), beyond[9:11] @ axes[:, 1], load[0, 2]
    return Cycle(rows[:, 0], rows[:, 1:3], rows[:, 3:5], rows[:, 5], rows[:, 6])


def overturning() -> tuple[float, float]:
    """Moment, N m, on a planet by the axial forces of its meshes, opposite at its operating pitch radius, and thrust on the sun, N.

    F_t tan(helix angle there) = F_t tan(7.5 deg) r_w / r each.
    """
    radii = CENTER_DISTANCE * np.array(TEETH[:2]) / (TEETH[0] + TEETH[1])
    axial = abs(TORQUE) / 3.0 / radii[0] * np.tan(np.radians(7.5)) * radii[0] / PITCH[0]
    return 2.0 * axial * radii[1], 3.0 * axial


def steady_lateral(places: tuple[int, ...]) -> float:
    """Of equal forces of the planets along their lines of action on the sun, N."""
    force = abs(TORQUE) / 3.0 / (PITCH[0] * np.cos(ALPHA_T))
    return float(force * abs(np.exp(2j * np.pi * np.array(places) / (TEETH[0] + TEETH[2])).sum()))


def vanishing(places: tuple[int, ...], harmonic: int) -> float:
    """Share of a harmonic of one planet's excitation that the planets together leave: |sum exp(i 2 pi l gamma_n)| / N."""
    gamma = TEETH[0] * np.array(places) / (TEETH[0] + TEETH[2])
    return float(abs(np.exp(2j * np.pi * harmonic * gamma).mean()))


def load_sharing(error: float, floating: bool, positions: int = 4, span: float = STIFF) -> np.ndarray:
    """Shares of the three planets, mean over the mesh cycle, with a pin error on the first; by default no planet tilts."""
    with Stage(errors=(error, 0.0, 0.0), span=span) as stage:
        guess = None
        while floating and stage.sun_support > FLOATING:
            # Set free step by step: Newton's method needs all meshes loaded on its way.
            guess = stage.equilibrium(0.0, TORQUE, guess) - stage.rolled(0.0)
            stage.sun_support /= 10.0
        shares = [stage.shares() for _ in at_rest(stage, positions, guess)]
    return np.mean(shares, axis=0)


def path_stiffness() -> float:
    """Tangential force at a mesh of one planet over the displacement of its pin along the path, N/m.

    A planet pushed by e on its pin presses both meshes, F = k_s d_s = k_r d_r with d_s + d_r = 2 e', and its pin
    carries 2 F: F (1/k_s + 1/k_r + 4/k_pin) = 2 e. Tangents at the nominal torque.
    """
    with Stage(span=STIFF) as stage:
        stage.equilibrium(0.0, TORQUE)
        sun, ring = (pair["mesh.stiffness"] for pair in stage.meshes[0])
        return 2.0 / (1.0 / sun + 1.0 / ring + 4.0 / stage.pin)


def shares_in_closed_form(error: float, floating: bool, stiffness: float) -> np.ndarray:
    """Springs side by side between carrier and sun (fixed axis); three forces on a free sun are equal."""
    radius = CENTER_DISTANCE * TEETH[0] / (TEETH[0] + TEETH[1])
    force = abs(TORQUE) / radius
    shares = np.full(3, 1.0 / 3.0)
    return shares if floating else shares + stiffness * error / force * np.array([2.0, -1.0, -1.0]) / 3.0


def balance(damped: bool = False, duration: float = 0.03, step: float = 1e-5) -> dict[str, float]:
    """The stage turns under constant torques; the sun's drops by a tenth at the start. What strays, over the run."""
    with Stage(sun_support=2e8, damping=None if damped else 0.0, errors=(30e-6, 0.0, 0.0)) as stage:
        q = stage.equilibrium(0.0, TORQUE)
        q_t = CARRIER_SPEED * (stage.rolled(1e-4) - stage.rolled(-1e-4)) / 2e-4
        torques = (0.9 * TORQUE, -TORQUE * (1.0 + TEETH[2] / TEETH[0]))
        begin, ledger = stage.momentum(q_t), Ledger(duration)
        pairs = [pair for pairs in stage.meshes for pair in pairs]
        for _, q, q_t, (work, lost, *impulse) in stage.run(q, q_t, torques, duration, step, round(duration / step / 60)):
            ledger.enter(pairs, *stage.energy(q, q_t), lost, work, stage.momentum(q_t) - begin - impulse)
        return ledger.found()
