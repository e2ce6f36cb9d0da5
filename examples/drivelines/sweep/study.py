"""A study through Dask: cases, what is already done, and the one file of results.

Finished cases lie in small Parquet files named by what they hold. Each is written under another name and moved into
place, so that a kill at any time leaves whole files only, and a restart computes what has none.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import operator
import os
from collections.abc import Callable
from pathlib import Path

import cloudpickle
import pyarrow as pa
import pyarrow.parquet as pq
from dask.distributed import Client, Future, as_completed

from .. import integrate
from . import runs

BATCH = 8  # cases a task, side by side: about a third of a second
CODE = (runs, integrate)  # what a case runs through


def grid(**axes) -> list[dict[str, float]]:
    """All combinations of the axes' values."""
    return [dict(zip(axes, map(float, values))) for values in itertools.product(*axes.values())]


def key(fmu: bytes, case: dict[str, float]) -> str:
    """Name of a case: of the unit, the inputs, and the code that computes it."""
    text = hashlib.sha256(fmu + b"".join(Path(module.__file__).read_bytes() for module in CODE))
    text.update(json.dumps(case, sort_keys=True).encode())
    return text.hexdigest()[:32]


def finished(folder: Path) -> dict[str, Path]:
    """Part file by key of the cases in it."""
    return {k: part for part in sorted(folder.glob("*.parquet")) for k in pq.read_table(part, columns=["key"])["key"].to_pylist()}


def submit(client: Client, fmu: bytes, batches: list[list[dict[str, float]]]) -> list[Future]:
    """A task for each batch of cases. Workers need gearmesh and numpy, not this repository.

    Dask would name the function of a task by its module: as data it travels by value.
    """
    for module in CODE:
        cloudpickle.register_pickle_by_value(module)
    simulate, unit = client.scatter([runs.simulate, fmu], broadcast=True)
    return [client.submit(operator.call, simulate, unit, batch, pure=False) for batch in batches]


def run(client: Client, fmu: bytes, cases: list[dict[str, float]], folder: Path, progress: Callable[[int, int], None]) -> int:
    """Computes the cases that have no result in `folder`; returns how many."""
    folder.mkdir(parents=True, exist_ok=True)
    done = finished(folder)
    names = {key(fmu, case): case for case in cases}
    todo = [name for name in names if name not in done]
    batches = [todo[i : i + BATCH] for i in range(0, len(todo), BATCH)]
    tasks = dict(zip(submit(client, fmu, [[names[n] for n in batch] for batch in batches]), batches))
    count = len(names) - len(todo)
    progress(count, len(names))
    for task, rows in as_completed(tasks, with_results=True):
        batch = tasks[task]
        part = folder / f"{batch[0]}.parquet"
        beside = part.with_suffix(f".{os.getpid()}")
        pq.write_table(pa.Table.from_pylist([{"key": n} | row for n, row in zip(batch, rows)]), beside)
        beside.replace(part)
        count += len(batch)
        progress(count, len(names))
    return len(todo)


def collect(fmu: bytes, cases: list[dict[str, float]], folder: Path, out: Path) -> pa.Table:
    """Puts the results of the cases, in their order, into one file."""
    parts = [pq.read_table(part) for part in sorted(folder.glob("*.parquet"))]
    rows = {row["key"]: row for part in parts for row in part.to_pylist()}
    table = pa.Table.from_pylist([rows[key(fmu, case)] for case in cases])
    pq.write_table(table, out)
    return table
