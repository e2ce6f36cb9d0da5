"""Phases, harmonics, load sharing and balances of the stage, each beside its closed form."""

from __future__ import annotations

import numpy as np
from gearmesh.energy import Ledger

from .stage import CENTER_DISTANCE, TEETH, Stage

TORQUE = -56.7e3  # N m on the sun: 750 kW at 22.1 rpm of the carrier
CARRIER_SPEED = 22.1 * np.pi / 30.0
FLOATING = 1e6  # N/m, the support left to a floating sun: 10 N at 10 um


def measured_phase() -> float:
    """Lag of the ring mesh behind the sun mesh from the units' mesh positions, at a hundredth of the torque."""
    with Stage() as stage:
        stage.equilibrium(0.0, TORQUE / 100.0)
        sun, ring = (pair["mesh.position"] for pair in stage.meshes[0])
        # Both fall while the carrier turns: the sun pushes on its coast flank, the planet turns backwards.
        return float((ring - sun + 0.5) % 1.0 - 0.5)


def transmission_error(places: tuple[int, ...], positions: int = 32) -> np.ndarray:
    """Angle of the sun beyond the kinematic one, rad, over a mesh cycle at rest, sun and carrier on fixed axes."""
    out = np.empty(positions)
    with Stage(places) as stage:
        guess = None
        for i in range(positions):
            carrier = 2.0 * np.pi / TEETH[2] * i / positions
            q = stage.equilibrium(carrier, TORQUE, guess)
            guess = q - stage.rolled(carrier)
            out[i] = guess[2]
    return out


def vanishing(places: tuple[int, ...], harmonic: int) -> float:
    """Share of a harmonic of one planet's excitation that the planets together leave: |sum exp(i 2 pi l gamma_n)| / N."""
    gamma = TEETH[0] * np.array(places) / (TEETH[0] + TEETH[2])
    return float(abs(np.exp(2j * np.pi * harmonic * gamma).mean()))


def load_sharing(error: float, floating: bool, positions: int = 4) -> np.ndarray:
    """Shares of the three planets, mean over the mesh cycle, with a pin error on the first."""
    shares = []
    with Stage(errors=(error, 0.0, 0.0)) as stage:
        guess = None
        for i in range(positions):
            carrier = 2.0 * np.pi / TEETH[2] * i / positions
            while floating and stage.sun_support > FLOATING:
                # Set free step by step: Newton's method needs all meshes loaded on its way.
                guess = stage.equilibrium(carrier, TORQUE, guess) - stage.rolled(carrier)
                stage.sun_support /= 10.0
            q = stage.equilibrium(carrier, TORQUE, guess)
            guess = q - stage.rolled(carrier)
            shares.append(stage.shares())
    return np.mean(shares, axis=0)


def path_stiffness() -> float:
    """Tangential force at a mesh of one planet over the displacement of its pin along the path, N/m.

    A planet pushed by e on its pin presses both meshes, F = k_s d_s = k_r d_r with d_s + d_r = 2 e', and its pin
    carries 2 F: F (1/k_s + 1/k_r + 4/k_pin) = 2 e. Tangents at the nominal torque.
    """
    with Stage() as stage:
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
