"""Sweeps over many cases on any executor, which go on where they were stopped."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from pathlib import Path

import numpy as np

from .dynamics import Array

Case = Mapping[str, float]
Rows = Sequence[Mapping[str, float | Sequence[float]]]


def grid(**axes: Sequence[float]) -> list[dict[str, float]]:
    """All combinations of values.

    Parameters
    ----------
    **axes
        Values by name, with the unit in it.

    Returns
    -------
    list of dict
        Cases; the last axis changes first.
    """
    return [dict(zip(axes, map(float, values))) for values in itertools.product(*axes.values())]


def sweep(
    simulate: Callable[[list[dict[str, float]]], Rows],
    cases: Sequence[Case],
    folder: str | Path,
    executor: Executor,
    *,
    batch: int = 8,
    identity: str = "",
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, Array]:
    """Computes all cases that have no result yet.

    Each finished batch lies in a file named by what it holds; it is written under another name and moved into place, so that
    a kill at any time leaves whole files only.

    Parameters
    ----------
    simulate
        Takes a batch of cases and returns a row of results for each. It is pickled, by cloudpickle where that is installed.
    cases
        Inputs of each, by name with the unit.
    folder
        Of the results.
    executor
        Of `concurrent.futures`, or the `get_executor()` of a Dask client.
    batch
        Number of cases in a task.
    identity
        Of whatever the results depend on beside the cases, such as FMU and code; another one begins anew.
    progress
        Called with how many cases are done, of how many.

    Returns
    -------
    dict of (number of cases, ...)
        Inputs and results by name, in the order of the cases; a result may be a list, equally long for all cases.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    keys = [hashlib.sha256(f"{identity} {json.dumps(dict(case), sort_keys=True)}".encode()).hexdigest()[:32] for case in cases]
    done = dict(finished(folder))
    names = dict(zip(keys, cases))
    missing = [key for key in names if key not in done]
    task = _pickled(simulate)
    tasks: dict[Future[Rows], list[str]] = {}
    for i in range(0, len(missing), batch):
        some = missing[i : i + batch]
        tasks[executor.submit(_simulate, task, [dict(names[key]) for key in some])] = some
    count = len(names) - len(missing)
    progress(count, len(names))
    for future in as_completed(tasks):
        some = tasks[future]
        rows = {key: dict(row) for key, row in zip(some, future.result())}
        part = folder / f"{some[0]}.json"
        beside = part.with_suffix(f".{os.getpid()}")
        beside.write_text(json.dumps(rows), encoding="utf-8")
        beside.replace(part)
        done |= rows
        count += len(some)
        progress(count, len(names))
    rows = [{**case, **done[key]} for key, case in zip(keys, cases)]
    return {name: np.array([row[name] for row in rows], dtype=float) for name in rows[0]}


def finished(folder: str | Path) -> Iterator[tuple[str, dict[str, float | list[float]]]]:
    """Key and results of each case that a sweep left in `folder`."""
    for part in sorted(Path(folder).glob("*.json")):
        yield from json.loads(part.read_text(encoding="utf-8")).items()


def _pickled(function: Callable[..., Rows]) -> bytes:
    try:
        from cloudpickle import dumps
    except ImportError:
        from pickle import dumps
    return dumps(function)


def _simulate(task: bytes, cases: list[dict[str, float]]) -> Rows:
    return pickle.loads(task)(cases)
