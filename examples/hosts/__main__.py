"""Runs every host on the whole scenario and writes the table in docs/hosts.md.

    python -m examples.hosts UNIT.fmu [--docs docs/hosts.md]

UNIT.fmu is the packed unit of the paper's pair, with tables.
"""

from __future__ import annotations

import argparse
import platform
from pathlib import Path

from .compare import HOSTS, Result, run
from .document import replace_table
from .scenario import revolution

NAMES = {
    "fmpy": "[fmpy](https://fmpy.readthedocs.io)",
    "fmi_sim": "[fmi-sim](https://github.com/jondo2010/rust-fmi)",
    "libcosim": "[libcosim](https://open-simulation-platform.github.io) by libcosimpy",
    "ecos": "[Ecos](https://github.com/Ecos-platform/ecos) by ecospy, from an SSP file",
    "exudyn": "[Exudyn](https://github.com/jgerstmayr/EXUDYN)",
    "mujoco": "[MuJoCo](https://mujoco.org)",
    "c": "a C program, by gcc",
}
HEAD = "| host | version | platform | CS | ME | what was run | largest difference |\n|---|---|---|---|---|---|---|\n"


def line(host: str, results: list[Result]) -> str:
    kinds = {result.interface for result in results}
    yes = [("yes" if kind in kinds else "") for kind in ("co_simulation", "model_exchange")]
    worst = max(result.difference for result in results)
    difference = "none, bit-equal" if worst == 0.0 else f"{worst:.0e}"
    rows = max(result.rows for result in results)
    source = f"[{host}](../examples/hosts/with_{host}.py)"
    system = f"{platform.system()} {platform.machine()}"
    what = f"the revolution, {rows} rows, {source}"
    return f"| {NAMES[host]} | {results[0].version} | {system} | {yes[0]} | {yes[1]} | {what} | {difference} |\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu", type=Path, metavar="UNIT.fmu")
    parser.add_argument("--docs", type=Path, help="page whose table is replaced")
    arguments = parser.parse_args()
    scenario = revolution(arguments.fmu, 100.0)
    table = HEAD
    for host in HOSTS:
        try:
            table += line(host, run(host, arguments.fmu, scenario))
        except ImportError as error:
            table += f"| {NAMES[host]} | | | | | not installed: {error} | |\n"
    print(table)
    if arguments.docs:
        replace_table(arguments.docs, "hosts", table)


if __name__ == "__main__":
    main()
