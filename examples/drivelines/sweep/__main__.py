"""`python -m examples.drivelines.sweep`: dynamic factor over speed, torque, misalignment and centre distance.

Runs on a local Dask cluster, or on the one at `--scheduler ADDRESS`; what is done stays done after a kill. Writes
target/drivelines/sweep.csv and sweep.png.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import cloudpickle
import numpy as np
from dask.distributed import Client, LocalCluster
from gearmesh.energy import in_words
from gearmesh.plots import figure as new_figure
from gearmesh.sweep import grid, sweep

from examples.shared import driven
from examples.shared.files import OUT, opened, save, shipped
from examples.shared.tables import show

from . import runs

SPEEDS, TORQUES = (1000.0, 14000.0), (50.0, 100.0, 200.0, 300.0)  # rpm, N m
TILTS, OFFSETS = (0.0, 1.0), (0.0, 40.0)  # mrad, um
COUNT = 40  # of speeds
BATCH = 4  # cases a task, side by side
TWO = 1.2  # ratio of the factors from which on there are two answers


def cases(count: int = COUNT, torques=TORQUES) -> list[dict[str, float]]:
    """Each from the lowest speed up, then from the highest down."""
    axes = {"torque_nm": torques, "misalignment_mrad": TILTS, "center_distance_offset_um": OFFSETS, "speeds": [count]}
    ways = [{"first_rpm": first, "last_rpm": last} for first, last in (SPEEDS, SPEEDS[::-1])]
    return [case | way for case in grid(**axes) for way in ways]


def study(fmu: bytes, some: list[dict[str, float]], folder: Path, client: Client, **options) -> dict[str, np.ndarray]:
    """Computes the cases that have no result in `folder`. Workers need gearmesh and numpy, not this repository."""
    cloudpickle.register_pickle_by_value(runs)
    identity = hashlib.sha256(fmu + Path(runs.__file__).read_bytes()).hexdigest()
    return sweep(partial(runs.simulate, fmu), some, folder, client.get_executor(), identity=identity, **{"batch": BATCH, **options})


@contextmanager
def connect(scheduler: str | None, workers: int):
    """A client of the scheduler at the address, or of a local cluster."""
    if scheduler:
        with Client(scheduler) as client:
            yield client
        return
    # Processes of one thread: an instance of the FMU belongs to one thread at a time.
    with LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            yield client


def progress(done: int, total: int) -> None:
    print(f"\r{done} of {total}", end="\n" if done == total else "", file=sys.stderr, flush=True)


def balance(damped: bool, duration: float = 0.02, step: float = 2.5e-6) -> dict[str, float]:
    """Of a run with tilted gears too far apart, from the middle of the backlash: what energy and loads stray, over the run."""
    fmu = shipped("fzg-c", phaseReference="absolute")
    with opened(fmu, {} if damped else {"damping": 0.0}) as pair:
        run = runs.Run(pair, {"torque_nm": 100.0, "misalignment_mrad": TILTS[1], "center_distance_offset_um": OFFSETS[1]})
        return driven.balance(run.turning, runs.INERTIA, run.torque, 8000.0, run.middle, duration, step)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scheduler", help="address of a Dask scheduler, such as tcp://host:8786")
    parser.add_argument("--workers", type=int, default=2, help="local worker processes")
    arguments = parser.parse_args()
    fmu = shipped("fzg-c", phaseReference="absolute").read_bytes()
    with connect(arguments.scheduler, arguments.workers) as client:
        table = study(fmu, cases(), OUT / "sweep", client, progress=progress)
    rows = [np.broadcast_to(column.reshape(len(cases()), -1), (len(cases()), COUNT)).ravel() for column in table.values()]
    np.savetxt(OUT / "sweep.csv", np.column_stack(rows), delimiter=",", header=",".join(table), comments="")
    draw(table)
    for damped in (False, True):
        print(f"{'damped' if damped else 'undamped'}: {in_words(balance(damped))}")


def branches(table: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Dynamic factor by torque, misalignment, offset and rising speed: from below, and from above."""
    factor = table["dynamic_factor"].reshape(len(TORQUES), len(TILTS), len(OFFSETS), 2, -1)
    return factor[..., 0, :], factor[..., 1, ::-1]


def draw(table: dict[str, np.ndarray]) -> None:
    (below, above), speeds = branches(table), np.linspace(*SPEEDS, COUNT)
    figure, axes = new_figure(3)
    two = np.maximum(above / below, below / above) > TWO
    for k, tilt in enumerate(TILTS):
        picture = axes[k].contourf(speeds, TORQUES, below[:, k, 0], np.linspace(1.0, 3.0, 21), extend="max")
        axes[k].contourf(speeds, TORQUES, two[:, k, 0], [0.5, 1.0], colors="none", hatches=["//"])
        axes[k].set(xlabel="speed (rpm)", ylabel="torque (N m)", title=f"run-up, {tilt:g} mrad; //: two answers")
    figure.colorbar(picture, ax=axes[1], label="dynamic factor")
    rows = [["torque (N m)", "speeds with two answers", "from (rpm)", "to (rpm)", "largest factor from below", "from above"]]
    for i, torque in enumerate(TORQUES):
        axes[2].plot(speeds, below[i, 0, 0], color=f"C{i}", label=f"{torque:g} N m")
        axes[2].plot(speeds, above[i, 0, 0], "--", color=f"C{i}")
        found = speeds[two[i, 0, 0]]
        largest = [f"{branch[i, 0, 0].max():.2f}" for branch in (below, above)]
        rows.append([f"{torque:g}", len(found), f"{found.min():.0f}", f"{found.max():.0f}", *largest])
    show("sweep-branches", rows, OUT)
    for axis in axes:
        axis.set_xticks(range(2000, 14001, 4000))
    axes[2].set(xlabel="speed (rpm)", ylabel="dynamic factor", title="run-up, dashed: run-down")
    axes[2].legend()
    save(figure, "sweep")


if __name__ == "__main__":
    main()
