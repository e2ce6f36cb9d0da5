"""Slow run-up and run-down of the spur pair through its resonance: gear 1 turns as imposed, gear 2 drags a torque."""

from __future__ import annotations

import math
from functools import cache

import gearmesh
import numpy as np
from gearmesh import RunUp, Turning

from examples.shared import driven
from examples.shared.files import PAIRS, local, opened

TORQUE = 150.0  # N m on gear 1, and as much on gear 2
INERTIA = 7.6e-3  # kg m^2, a steel disc of 150 mm and 20 mm
ZETA, DAMPING = 0.0305, 1100.0  # damping ratio, and that in N s/m
PRESSURE_ANGLE = math.radians(20.0)


@cache
def static() -> gearmesh.MeshCycle:
    return gearmesh.solve(PAIRS / "spur-50-50.json", TORQUE, refinement="coarse")


def sweep(start: float, end: float, sweep_s: float = 1.6) -> RunUp:
    """Up and down between speeds in rpm."""
    stiffness = {"constantStiffness": static().mean_mesh_stiffness_loa_n_per_m * math.cos(PRESSURE_ANGLE) ** 2}
    return gearmesh.run_up(local("spur-50-50"), (math.inf, INERTIA), ZETA, TORQUE, (start, end), sweep_s=sweep_s, parameters=stiffness)


def jump(history: gearmesh.History) -> tuple[float, np.ndarray]:
    """Speed at the largest relative change of the swing from window to window, and the speeds at which teeth part, rpm."""
    speeds, swing = gearmesh.swing(history, "transmission_error_um")
    apart = history.speed_rpm[history["tangential_force_n"] == 0.0]
    return float(speeds[1:][np.argmax(np.abs(np.diff(np.log(swing))))]), apart


def linear_swing(natural_frequency_hz: float, rpm: np.ndarray) -> np.ndarray:
    """Swing of the transmission error, um, on a constant spring that the static transmission error moves; NaN where the teeth would part.

    The model of Ozguven and Houser.
    """
    cycle = static()
    order = np.arange(1, 1 + len(cycle.harmonics_loa_um))
    ratio = np.outer(rpm / 60.0 * 50 / natural_frequency_hz, order)  # 50 teeth
    amplitude = cycle.harmonics_loa_um * np.exp(1j * cycle.harmonics_phase_rad) / (1.0 - ratio**2 + 2j * ZETA * ratio)
    wave = np.exp(1j * np.outer(order, np.linspace(0.0, 2.0 * np.pi, 256)))
    error, acceleration = (amplitude @ wave).real, (-(ratio**2) * amplitude @ wave).real
    swing = 0.5 * np.ptp(error, axis=1) / math.cos(PRESSURE_ANGLE)  # on the pitch circle
    # The force is that at rest less mass times acceleration, here over the stiffness.
    return np.where(acceleration.max(axis=1) < cycle.mean_ste_loa_um, swing, np.nan)


def balance(damped: bool, rpm: float = 2200.0, duration: float = 0.03, step: float = 2.5e-6) -> dict[str, float]:
    """At a steady speed near resonance, from no load, so that teeth part: what energy and loads stray, over the run."""
    with opened(local("spur-50-50"), {"damping": DAMPING * damped}) as pair:
        return driven.balance(Turning(pair), INERTIA, TORQUE, rpm, 0.0, duration, step)
