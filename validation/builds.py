"""Error of tables over the processor time of their build: `python -m validation.builds [--gearmesh PATH] [--method NAME] [--data docs/data/tables]`.

Builds with several bounds of the error, on coarse elastic models that are ready before. Rows of `--method` in builds.csv are replaced, all
others kept: so an earlier method is measured by `gearmesh` of a `git worktree` at its commit, in the same hour as today's.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import resource
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAIRS = ("palermo2013", "fzg-c", "helical-25-47")
BOUNDS = (None, 0.016, 0.008, 0.004, 0.002, 0.001)
HEAD = ("pair", "method", "grid", "processor time, s", "force, rms error, % of the nominal force", "moment, rms error, % of F b/2", "nodes")
MODELS = ("--refinement", "coarse", "--threads", "1", "--quiet")


def built(program: str, pair: str, options: list[str], folder: str) -> tuple[float, dict]:
    """Processor seconds and the tables of a build."""
    file, before = Path(folder) / "tables.json", resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "tables", str(ROOT / f"resources/pairs/{pair}.json"), "-o", str(file), *MODELS, *options]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | {"GEARMESH_CACHE_DIR": folder})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime, json.loads(file.read_text(encoding="utf-8"))


def row(program: str, method: str, pair: str, bound: float | None, folder: str) -> list[str]:
    options = [] if bound is None else ["--max-error", str(bound)]
    seconds, tables = built(program, pair, options, folder)
    error = tables["interpolation_error"]
    nodes = "x".join(str(len(axis)) for axis in tables["axes"].values())
    grid = "default" if bound is None else f"--max-error {bound}"
    rms = [f"{100 * error[name]:.3f}" for name in ("force_rms", "moment_rms")]
    return [pair, method, grid, f"{seconds:.2f}", *rms, nodes]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gearmesh", default=str(ROOT / "target/release/gearmesh"), help="program to measure")
    parser.add_argument("--method", default="today", help="what to call it: today, or the commit of another program")
    parser.add_argument("--data", type=Path, default=ROOT / "docs/data/tables", help="folder of builds.csv")
    arguments = parser.parse_args()
    file = arguments.data / "builds.csv"
    known = []
    if file.exists():
        with file.open(encoding="utf-8", newline="") as text:
            known = [row for row in list(csv.reader(text))[1:] if row[1] != arguments.method]
    for pair in PAIRS:
        with tempfile.TemporaryDirectory() as folder:
            built(arguments.gearmesh, pair, ["--no-center-distance", "--no-misalignment"], folder)
            known += [row(arguments.gearmesh, arguments.method, pair, bound, folder) for bound in BOUNDS]
    with file.open("w", encoding="utf-8", newline="") as text:
        csv.writer(text, lineterminator="\n").writerows([HEAD, *known])


if __name__ == "__main__":
    main()
