"""The Python packages of groups of pyproject.toml, each with its version of constraints.txt, as pip reads them.

    python scripts/packages.py [GROUP ...]      # of all groups where none is named
"""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def packages(chosen: list[str]) -> list[str]:
    """Lines such as numpy==2.4.6. Ends the program where a package has no version, or a version no package."""
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text())["dependency-groups"]
    if unknown := set(chosen) - set(groups):
        sys.exit(f"packages: no group {', '.join(sorted(unknown))} in pyproject.toml: there are {', '.join(groups)}")
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    versions = {name.lower(): line for line in lines if (name := re.split("==|#", line)[0])}
    needed = {name.lower() for group in groups.values() for name in group}
    if apart := sorted(needed ^ set(versions)):
        sys.exit(f"packages: in a group of pyproject.toml and not in constraints.txt, or the other way round: {', '.join(apart)}")
    return sorted({versions[name.lower()] for group in chosen or groups for name in groups[group]})


if __name__ == "__main__":
    print("\n".join(packages(sys.argv[1:])))
