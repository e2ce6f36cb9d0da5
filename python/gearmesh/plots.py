"""Plots of the package's results by matplotlib, in one style; the rest of the package does without it.

Where matplotlib is not installed, all of them raise GearmeshError.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .analysis import Campbell, Orders, decibels, is_outside, swing
from .command import MeshCycle
from .errors import GearmeshError
from .speed_sweep import RunUp

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, RED, GREEN, GREY = "#2f6f9f", "#b3261e", "#4d8b4d", "#777777"
STYLE = {
    "figure.dpi": 110,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "font.size": 10,
}


def figure(columns: int = 1, width: float | None = None, height: float = 4.2, **options: Any) -> tuple[Figure, Any]:
    """A figure in the package's style.

    Parameters
    ----------
    columns
        Axes side by side.
    width, height
        Inches; the width by default as the columns need.
    **options
        Of `matplotlib.pyplot.subplots`.

    Returns
    -------
    figure, axes
        Of matplotlib; an array of axes where there are several.
    """
    try:
        from matplotlib import pyplot, rc_context
    except ImportError as error:
        raise GearmeshError("plots need matplotlib: pip install matplotlib") from error
    with rc_context(STYLE):
        return pyplot.subplots(1, columns, figsize=(width or (7.2 if columns == 1 else 4.5 * columns), height), **options)


def save(picture: Figure, file: str | Path) -> Path:
    """Writes a figure, makes its folder where there is none, and closes it."""
    from matplotlib import pyplot

    path = Path(file)
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.tight_layout()
    picture.savefig(path)
    pyplot.close(picture)
    return path


def plot_cycle(cycle: MeshCycle, axes: Axes | None = None, **line: Any) -> Axes:
    """Static transmission error over the mesh cycle.

    Parameters
    ----------
    cycle
        Of `solve`.
    axes
        Drawn into; new ones where left out.
    **line
        Options of the line.

    Returns
    -------
    Axes
    """
    axes = axes or figure()[1]
    axes.plot(cycle.mesh_position, cycle.ste_loa_um, **{"label": f"{cycle.torque_nm:g} N m"} | line)
    axes.set(xlabel="mesh position", ylabel="static transmission error (µm, line of action)")
    axes.legend()
    return axes


def plot_run_up(run: RunUp, signal: str = "transmission_error_um", axes: Axes | None = None, window_s: float = 0.01) -> Axes:
    """Half of the peak-to-peak of a signal over speed, up and down.

    Parameters
    ----------
    run
        Of `run_up`.
    signal
        Of its histories.
    axes
        Drawn into; new ones where left out.
    window_s
        As in `swing`.

    Returns
    -------
    Axes
    """
    axes = axes or figure()[1]
    for history, name, color in ((run.up, "run-up", BLUE), (run.down, "run-down", RED)):
        speed, half = swing(history, signal, window_s)
        axes.plot(speed, half, color=color, label=name)
        outside = is_outside(history, window_s)
        if outside.any():
            axes.plot(speed[outside], half[outside], "o", color=color, ms=4, fillstyle="none", label=f"{name}, outside the tables")
    axes.axvline(run.resonance_rpm, color=GREY, lw=0.8, ls="--", label="resonance, linear")
    axes.set(xlabel="speed (rpm)", ylabel=f"{_words(signal)}, half of peak to peak")
    axes.legend()
    return axes


def plot_orders(found: Orders, axes: Axes | None = None, reference: float | None = None) -> Axes:
    """Amplitude of each order over speed, a line each.

    Parameters
    ----------
    found
        Of `orders`.
    axes
        Drawn into; new ones where left out.
    reference
        Of levels in dB, in the unit of the signal; amplitudes where left out.

    Returns
    -------
    Axes
    """
    axes = axes or figure()[1]
    for order, amplitude in zip(found.order, found.amplitude.T):
        axes.plot(found.speed_rpm, amplitude if reference is None else decibels(amplitude, reference), label=f"order {order:g}")
    axes.set(xlabel="speed (rpm)", ylabel=_words(found.signal, reference))
    if reference is None:
        axes.set_yscale("log")
    axes.legend()
    return axes


def plot_campbell(found: Campbell, axes: Axes | None = None, reference: float = 1.0, range_db: float = 70.0) -> Axes:
    """Levels over speed and frequency.

    Parameters
    ----------
    found
        Of `campbell`.
    axes
        Drawn into; new ones where left out.
    reference
        Of the levels, in the unit of the signal.
    range_db
        Below the largest level that is shown.

    Returns
    -------
    Axes
    """
    axes = axes or figure()[1]
    level = found.level_db(reference).T
    order = np.argsort(found.speed_rpm)
    picture = axes.pcolormesh(
        found.speed_rpm[order], 1e-3 * found.frequency_hz, level[:, order], vmin=level.max() - range_db, vmax=level.max(), shading="auto"
    )
    axes.grid(False)
    # Up to the highest frequency that comes within the range of levels: beyond it there is nothing to see.
    seen = np.flatnonzero((level > level.max() - range_db).any(axis=1))
    axes.set(xlabel="speed (rpm)", ylabel="frequency (kHz)", ylim=(0.0, 1e-3 * found.frequency_hz[seen[-1]]))
    axes.figure.colorbar(picture, ax=axes, label=_words(found.signal, reference))
    return axes


def _words(signal: str, reference: float | None = None) -> str:
    """`tangential_force_n` as "tangential force (N)", with a reference in dB."""
    units = {"_m_per_s2": "m/s²", "_rad_per_s2": "rad/s²", "_um": "µm", "_nm": "N m", "_n": "N"}
    end = next((end for end in sorted(units, key=len, reverse=True) if signal.endswith(end)), "")
    name = signal.removesuffix(end).replace("_", " ")
    unit = f" {units[end]}" if end else ""
    return f"{name} (dB re {reference:g}{unit})" if reference is not None else f"{name} ({unit.strip() or 'own unit'})"
