"""The command `run-up` from Python: two discs that an FMU couples, through the resonances of the mesh and back."""

from __future__ import annotations

import json
import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .command import run, settings
from .dynamics import History


@dataclass(frozen=True)
class RunUp:
    """A slow run-up and the run-down from where it ended; orders refer to gear 1.

    Attributes
    ----------
    up, down : History
        With `transmission_error_um` on the operating pitch circle, > 0 with the drive flank compressed,
        `tangential_force_n`, `acceleration_gear1_rad_per_s2` and `acceleration_gear2_rad_per_s2` without the mean one, and
        `out_of_range`, 1 where poses or loads lie outside the range of the tables. With `shafts` also
        `gear1_bearing1_radial_force_n` and so on.
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


def run_up(
    unit: str | Path,
    inertias: tuple[float, float],
    damping: float,
    torque: float,
    speeds: tuple[float, float],
    *,
    sweep_s: float | None = None,
    step_s: float | None = None,
    shafts: str | Path | None = None,
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
        Mean torque on gear 1, N m, > 0 on the drive flank, < 0 on the coast flank.
    speeds
        Of gear 1, rpm, from lowest to highest.
    sweep_s
        Time of each sweep; by default twenty decay times pass while the mesh frequency crosses the resonance's width.
    step_s
        Communication step; by default 0.07 rad of the natural frequency, or a twentieth of the shortest mesh cycle: where teeth part, the end of the upper
        branch is within a percent then.
    shafts
        Pair file of these gears with their shafts on bearings, whose radial forces are then among the signals: without clearances,
        weight, and inertia across the axes.
    parameters
        Of the FMU, beside those.

    Returns
    -------
    RunUp

    Raises
    ------
    CommandError
        An argument is out of range, or the FMU refused a pose.

    Warns
    -----
    UserWarning
        Poses or loads lie outside the range of the tables.
    """
    low, high = speeds
    with tempfile.TemporaryDirectory() as folder:
        page, signals = Path(folder, "run-up.html"), Path(folder)
        options = {
            "inertia-kg-m2": inertias, "damping-ratio": [damping], "torque-nm": [torque], "speed-rpm": [low, high],
            "sweep-s": [sweep_s], "step-s": [step_s],
        }  # fmt: skip
        words = [word for name, values in options.items() if values[0] is not None for word in (f"--{name}", *map(float, values))]
        of_shafts = [] if shafts is None else ["--shafts", shafts]
        found = json.loads(run("run-up", unit, "--output", page, "--signals", signals, "--json", *words, *of_shafts, *settings(parameters)))
        up, down = (_history(np.load(signals / f"{name}.npy")) for name in ("up", "down"))
    share = {name: found[name]["out_of_range_share"] for name in ("up", "down")}
    if any(share.values()):
        between = ", ".join(
            f"{name}: {100.0 * share[name]:.1f} % of the time, between {way[0]:.0f} and {way[1]:.0f} rpm"
            for name, way in ((name, found[name]["out_of_range_rpm"]) for name in share if share[name])
        )
        warnings.warn(f"poses or loads outside the range of the tables ({between}): loads there are extrapolated", stacklevel=2)
    numbers = (found[name] for name in ("natural_frequency_hz", "resonance_rpm", "damping_n_s_per_m", "step_s", "sweep_s"))
    return RunUp(up, down, *numbers)


def _history(array: NDArray[np.void]) -> History:
    """Of the signals that the command wrote."""
    columns = {name: np.ascontiguousarray(array[name]) for name in array.dtype.names or ()}
    return History(columns.pop("time_s"), columns.pop("angle_rad"), columns.pop("speed_rpm"), columns)
