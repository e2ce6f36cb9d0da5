"""The units that the tests drive, packed once by the command `gearmesh`."""

import json
import math
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
GEARMESH = ROOT / "target" / "release" / "gearmesh"
PAIRS = ROOT / "resources" / "pairs"
SHIPPED = ("fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84")

sys.path.insert(0, str(Path(__file__).parent))

from host import Unit  # noqa: E402


def gearmesh(*arguments):
    """Runs the command and returns what it printed."""
    run = subprocess.run([GEARMESH, *map(str, arguments)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout


def swapped(pair):
    """The pair with its gears exchanged: the ring becomes gear 1."""
    out = dict(pair, gear1=pair["gear2"], gear2=pair["gear1"], name=pair["name"] + "-swapped")
    if pair["meshing"] == "external":
        out["helix_angle_deg"] = -pair.get("helix_angle_deg", 0.0)
    return out


def other_hand(pair):
    return dict(pair, helix_angle_deg=-pair["helix_angle_deg"], name=pair["name"] + "-other-hand")


def pair_files():
    """The pairs by name: external, gear 2 a ring, gear 1 a ring, each in both hands."""
    external = json.loads((PAIRS / "palermo2013.json").read_text())
    ring = json.loads((PAIRS / "planet-ring-27-84.json").read_text())
    # A helix with the transverse module kept leaves all diameters as they are.
    helix = 12.0
    module = ring["normal_module_mm"] * math.cos(math.radians(helix))
    ring = dict(ring, helix_angle_deg=helix, normal_module_mm=module)
    base = {"external": external, "ring2": ring, "ring1": swapped(ring)}
    return base | {f"{name}-left": other_hand(pair) for name, pair in base.items()}


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """Constant-stiffness FMU files by pair name."""
    folder = tmp_path_factory.mktemp("fmus")
    out = {}
    for name, pair in pair_files().items():
        file = folder / f"{name}.json"
        file.write_text(json.dumps(pair))
        out[name] = folder / f"{name}.fmu"
        gearmesh("pack", "--pair", file, "-o", out[name])
    return out


@pytest.fixture(scope="session")
def units(fmus):
    """The same, unpacked."""
    units = {name: Unit(path) for name, path in fmus.items()}
    yield units
    for unit in units.values():
        unit.close()


# Quick tables: coarse finite elements, kept for all tests, on few stations. `cycle` has mesh position and load
# alone, on the default grid, sliding and root stress; `all` has the centre distance and the misalignment, too, on a
# coarse one.
COARSE = ["--refinement", "coarse", "--cache-dir", ROOT / "target" / "tmp" / "elastic-models"]
QUICK = [*COARSE, "--stations", "12", "-q"]
GRIDS = {
    "cycle": ["--no-center-distance", "--no-misalignment", "--friction", "--root-stress"],
    "all": ["--max-error", "0.02"],
}


@pytest.fixture(scope="session")
def table_fmus(tmp_path_factory):
    """FMU files with tables by pair and grid, as `external-cycle`."""
    folder = tmp_path_factory.mktemp("tables")
    out = {}
    for name in ("external", "ring2"):
        file = folder / f"{name}.json"
        file.write_text(json.dumps(pair_files()[name]))
        for grid, options in GRIDS.items():
            fmu = out[f"{name}-{grid}"] = folder / f"{name}-{grid}.fmu"
            gearmesh("build", file, "-o", fmu, *QUICK, *options)
    return out


@pytest.fixture(scope="session")
def table_units(table_fmus):
    """The same, unpacked."""
    units = {name: Unit(path) for name, path in table_fmus.items()}
    yield units
    for unit in units.values():
        unit.close()


@pytest.fixture(scope="session")
def shipped_fmus(tmp_path_factory):
    """FMU files of the shipped tables as packing makes them, by name."""
    folder = tmp_path_factory.mktemp("shipped")
    out = {name: folder / f"{name}.fmu" for name in SHIPPED}
    for name, fmu in out.items():
        gearmesh("pack", "--tables", ROOT / "resources" / "tables" / f"{name}.json", "-o", fmu)
    return out


@pytest.fixture(scope="session")
def shipped_units(shipped_fmus):
    """The same, unpacked."""
    units = {name: Unit(path) for name, path in shipped_fmus.items()}
    yield units
    for unit in units.values():
        unit.close()


@pytest.fixture
def shipped(shipped_units):
    """As `mesh`, of the shipped tables with packed defaults."""
    yield from instances(shipped_units)


@pytest.fixture
def table_mesh(table_units):
    """As `mesh`, of the units with tables."""
    yield from instances(table_units)


@pytest.fixture
def mesh(units):
    """Makes instances of a unit and frees them after the test."""
    yield from instances(units)


def instances(units):
    made = []

    def make(pair="external", **options):
        made.append(units[pair].instance(**options))
        return made[-1]

    yield make
    for instance in made:
        instance.close()
