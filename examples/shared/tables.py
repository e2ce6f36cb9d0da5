"""Tables that a command prints and keeps as CSV."""

from __future__ import annotations

import csv
from pathlib import Path


def show(name: str, rows: list[list[object]], folder: Path | None) -> None:
    """Prints `rows`, the first of which is the head, and writes NAME.csv into `folder`, if there is one."""
    for row in rows:
        print(" | ".join(map(str, row)))
    if folder:
        with (folder / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
