"""Runs every host on the whole scenario.

    python -m examples.hosts PAIR.fmu [--data docs/data/hosts]

PAIR.fmu is the packed FMU of the paper's pair, with tables.
"""

from __future__ import annotations

import argparse
import platform
from pathlib import Path

from examples.shared.tables import show

from .compare import HOSTS, Result, run
from .scenario import revolution

HEAD = ["host", "version", "platform", "CS", "ME", "what was run", "largest difference"]


def line(host: str, results: list[Result]) -> list[str]:
    kinds = {result.interface for result in results}
    yes = [("yes" if kind in kinds else "") for kind in ("co_simulation", "model_exchange")]
    worst = max(result.difference for result in results)
    difference = "none, bit-equal" if worst == 0.0 else f"{worst:.0e}"
    rows = max(result.rows for result in results)
    system = f"{platform.system()} {platform.machine()}"
    return [HOSTS[host], results[0].version, system, *yes, f"the revolution, {rows} rows, {host}", difference]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu", type=Path, metavar="PAIR.fmu")
    parser.add_argument("--data", type=Path, help="folder for hosts.csv")
    arguments = parser.parse_args()
    scenario = revolution(arguments.fmu, 100.0)
    rows = [HEAD]
    for host in HOSTS:
        try:
            rows.append(line(host, run(host, arguments.fmu, scenario)))
        except ImportError as error:
            rows.append([HOSTS[host], "", "", "", "", f"not installed: {error}", ""])
    show("hosts", rows, arguments.data)


if __name__ == "__main__":
    main()
