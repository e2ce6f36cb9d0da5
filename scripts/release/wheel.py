"""A wheel for one platform: the command with the libraries beside it, and the package `gearmesh`."""

from __future__ import annotations

import ast
import shutil
import tomllib
from pathlib import Path

from .platforms import Platform
from .tools import ROOT, run

# Of what the wheel holds alone: it has neither the pages nor the pair files beside the sources.
DESCRIPTION = """\
From the drawing of a spur or helical gear pair, external or internal, the command `gearmesh` computes the static tooth contact in three
dimensions, tabulates it over load, mesh position, centre distance and misalignment, and packs the tables with a compiled element
into a Functional Mock-up Unit (FMI 2.0, model exchange and co-simulation) for Linux and Windows. A simulator hands the FMU the poses and
velocities of both gears; the FMU returns contact force, moment and contact point.

```sh
gearmesh new --teeth 23 81 --module-mm 1.75 --face-width-mm 30 28 --torque-nm 120 -o pair.json
gearmesh inspect pair.json                            # contact ratios, nominal force, gear data
gearmesh solve pair.json --refinement coarse          # one mesh cycle at the nominal torque
gearmesh build pair.json --refinement coarse -o pair.fmu
```

The first command writes a pair file with a comment for each field, to be changed to your drawing. Leave `--refinement coarse` out for final numbers;
`gearmesh --help` has all commands and options. `documentation/index.html` in the FMU has frames, variables with their units
and defaults, what the tables cover and how accurate they are, and a first run.

## From Python

"""


def description() -> str:
    """What an index shows beside the wheel: the command, and the docstring of the package."""
    package = ast.parse((ROOT / "python" / "gearmesh" / "__init__.py").read_text())
    return f"{DESCRIPTION}{ast.get_docstring(package)}\n"


def pack(platform: Platform, version: str, programs: Path, licenses: list[Path], out: Path) -> None:
    """Packs the folder `programs`, which holds command and libraries, into a wheel in `out`.

    Everything of `programs` goes among the scripts, since pip puts these into one folder on every
    platform, and the command looks for libraries in its own.
    """
    stage = ROOT / "target" / "wheel" / platform.name
    shutil.rmtree(stage, ignore_errors=True)
    package, scripts, about = (
        stage / "gearmesh",
        stage / f"gearmesh-{version}.data" / "scripts",
        stage / f"gearmesh-{version}.dist-info",
    )
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "python" / "gearmesh", package, ignore=ignored)
    shutil.copytree(programs, scripts)
    (about / "licenses").mkdir(parents=True)
    for file in licenses:
        shutil.copy(file, about / "licenses")
    names = "".join(f"License-File: {file.name}\n" for file in licenses)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needs = "".join(f"Requires-Dist: {needed}\n" for needed in project["dependencies"])
    for extra, packages in project["optional-dependencies"].items():
        needs += f"Provides-Extra: {extra}\n"
        needs += "".join(f"Requires-Dist: {needed}; extra == '{extra}'\n" for needed in packages)
    (about / "METADATA").write_text(
        f"Metadata-Version: 2.4\nName: {project['name']}\nVersion: {version}\nSummary: {project['description']}\n"
        f"License-Expression: {project['license']}\n{names}"
        f"Requires-Python: {project['requires-python']}\n{needs}"
        "Description-Content-Type: text/markdown\n\n"
        f"{description()}"
    )
    (about / "WHEEL").write_text(
        "Wheel-Version: 1.0\nGenerator: gearmesh scripts/release\nRoot-Is-Purelib: false\n"
        f"Tag: py3-none-{platform.wheel}\n"
    )
    run("python", "-m", "wheel", "pack", stage, "--dest-dir", out)
