"""`python -m examples.drivelines.sweep`: dynamic factor over speed, torque, misalignment and centre distance.

Runs on a local Dask cluster, or on the one at `--scheduler ADDRESS`; what is done stays done after a kill. Writes
target/drivelines/sweep.csv and sweep.png. `--throughput` measures instead.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import cloudpickle
import numpy as np
from dask.distributed import Client, LocalCluster
from gearmesh.plots import figure as new_figure
from gearmesh.sweep import grid, sweep

from ..files import OUT, save, shipped
from . import runs

SPEEDS, TORQUES = np.linspace(1000.0, 14000.0, 40), (50.0, 100.0, 200.0, 300.0)
TILTS, OFFSETS = (0.0, 1.0), (0.0, 40.0)
BATCH = 8  # cases a task, side by side: about a third of a second


def cases(speeds=SPEEDS) -> list[dict[str, float]]:
    return grid(speed_rpm=speeds, torque_nm=TORQUES, misalignment_mrad=TILTS, center_distance_offset_um=OFFSETS)


def study(fmu: bytes, some: list[dict[str, float]], folder: Path, client: Client, progress=lambda done, total: None) -> dict[str, np.ndarray]:
    """Computes the cases that have no result in `folder`. Workers need gearmesh and numpy, not this repository."""
    cloudpickle.register_pickle_by_value(runs)
    identity = hashlib.sha256(fmu + Path(runs.__file__).read_bytes()).hexdigest()
    return sweep(partial(runs.simulate, fmu), some, folder, client.get_executor(), batch=BATCH, identity=identity, progress=progress)


@contextmanager
def connect(scheduler: str | None, workers: int):
    """A client of the scheduler at the address, or of a local cluster."""
    if scheduler:
        with Client(scheduler) as client:
            yield client
        return
    # Processes of one thread: an instance of the unit belongs to one thread at a time.
    with LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            yield client


def show(done: int, total: int) -> None:
    print(f"\r{done} of {total}", end="\n" if done == total else "", file=sys.stderr, flush=True)


def processor_time(client: Client) -> float:
    """Of all workers and of this process, which also schedules for a local cluster, s."""
    return time.process_time() + sum(client.run(time.process_time).values())


def throughput(fmu: bytes) -> None:
    """Cases per second: Dask with one and with two workers, and one process that runs 64 side by side or one by one."""
    some = cases(np.linspace(2000.0, 12000.0, 8))
    for workers in (1, 2):
        with connect(None, workers) as client:
            parts = OUT / "throughput" / f"{time.time_ns()}"
            study(fmu, some[:1], parts, client)
            clock, spent = time.perf_counter(), processor_time(client)
            study(fmu, some, parts, client)
            clock, spent = time.perf_counter() - clock, processor_time(client) - spent
            print(f"Dask, {workers} worker{'s' * (workers > 1)}: {len(some) / clock:.1f} cases/s, {len(some) / spent:.1f} per second of processor time")
    for count in (1, BATCH, 64):
        runs.simulate(fmu, some[:count])
        clock = time.process_time()
        for i in range(0, 64, count):
            runs.simulate(fmu, some[i : i + count])
        print(f"one process, {count} instance{'s' * (count > 1)}: {64 / (time.process_time() - clock):.1f} cases per second of processor time")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scheduler", help="address of a Dask scheduler, such as tcp://host:8786")
    parser.add_argument("--workers", type=int, default=2, help="local worker processes")
    parser.add_argument("--throughput", action="store_true")
    arguments = parser.parse_args()
    fmu = shipped("fzg-c", phaseReference="absolute").read_bytes()
    if arguments.throughput:
        throughput(fmu)
        return
    with connect(arguments.scheduler, arguments.workers) as client:
        table = study(fmu, cases(), OUT / "sweep", client, show)
    np.savetxt(OUT / "sweep.csv", np.column_stack(list(table.values())), delimiter=",", header=",".join(table), comments="")
    draw(table)


def draw(table: dict[str, np.ndarray]) -> None:
    factor = table["dynamic_factor"].reshape(len(SPEEDS), len(TORQUES), len(TILTS), len(OFFSETS))
    figure, axes = new_figure(len(TILTS) + 1)
    for k, tilt in enumerate(TILTS):
        picture = axes[k].contourf(SPEEDS, TORQUES, factor[:, :, k, 0].T, np.linspace(1.0, 3.0, 21), extend="max")
        axes[k].set(xlabel="speed, rpm", ylabel="torque, N m", title=f"dynamic factor, misalignment {tilt:g} mrad")
    figure.colorbar(picture, ax=axes[len(TILTS) - 1])
    for i, torque in enumerate(TORQUES):
        for k, style in enumerate(("-", "--")):
            axes[-1].plot(SPEEDS, factor[:, i, 0, k], style, color=f"C{i}", label=None if k else f"{torque:g} N m")
    for axis in axes:
        axis.set_xticks(range(2000, 14001, 4000))
    axes[-1].set(xlabel="speed, rpm", ylabel="dynamic factor", title="centre distance: nominal, dashed + 40 µm")
    axes[-1].legend()
    save(figure, "sweep")


if __name__ == "__main__":
    main()
