"""The FMUs that the tests drive, packed once."""

import json
import math
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
GEARMESH = ROOT / "target" / "release" / "gearmesh"
PAIRS, TABLES = ROOT / "resources" / "pairs", ROOT / "resources" / "tables"
SHIPPED = ("fzg-c", "helical-25-47", "palermo2013", "planet-ring-27-84")

sys.path[:0] = [str(Path(__file__).parent), str(ROOT)]

import gearmesh  # noqa: E402
from host import Unit  # noqa: E402


FORMULATIONS = pytest.mark.parametrize("formulation", [1, 2], ids=["paper", "conjugate"])
COUPLINGS = pytest.mark.parametrize("coupling", [1, 2, 3], ids=["held", "sequential", "parallel"])
EXTERNAL_AND_INTERNAL = pytest.mark.parametrize("pair", ["external", "ring2", "ring1"])


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
    return {name: gearmesh.pack(pair, folder / f"{name}.fmu") for name, pair in pair_files().items()}


# Quick tables: coarse finite elements, kept for all tests, on few stations. `cycle` has mesh position and load
# alone, on the default grid, sliding and root stress, of the external pair contact at run time, too; `all` has the centre distance and the misalignment, too, on a
# coarse one.
COARSE = {"refinement": "coarse", "cache_dir": ROOT / "target" / "tmp" / "elastic-models"}
QUICK = {**COARSE, "stations": 12}
ALIGNED = {"no_center_distance": True, "no_misalignment": True}
GRIDS = {"cycle": {**ALIGNED, "friction": True, "root_stress": True}, "all": {"max_error": 0.02}}


def tabulated_pairs():
    """Those of the FMUs with tables: the flanks of the external one differ by a lead slope."""
    pairs = {name: pair_files()[name] for name in ("external", "ring2")}
    for gear in ("gear1", "gear2"):
        pairs["external"][gear]["lead_slope_um"] = 8.0
    return pairs


@pytest.fixture(scope="session")
def table_fmus(tmp_path_factory):
    """FMU files with tables by pair and grid, as `external-cycle`."""
    folder = tmp_path_factory.mktemp("tables")
    return {
        f"{name}-{grid}": gearmesh.build(pair, folder / f"{name}-{grid}.fmu", **QUICK, **options, contact=f"{name}-{grid}" == "external-cycle")
        for name, pair in tabulated_pairs().items()
        for grid, options in GRIDS.items()
    }


@pytest.fixture(scope="session")
def shipped_fmus(tmp_path_factory):
    """FMU files of the shipped tables as packing makes them, by name."""
    folder = tmp_path_factory.mktemp("shipped")
    return {name: gearmesh.pack(TABLES / f"{name}.json", folder / f"{name}.fmu") for name in SHIPPED}


def unpacked(files):
    """A fixture of the FMU files, unpacked, and one of a function that makes instances and frees them after the test."""

    @pytest.fixture(scope="session")
    def units(request):
        units = {name: Unit(path) for name, path in request.getfixturevalue(files).items()}
        yield units
        for unit in units.values():
            unit.close()

    return units


units, table_units = map(unpacked, ("fmus", "table_fmus"))


@pytest.fixture
def mesh(units):
    """Makes instances of an FMU and frees them after the test."""
    yield from instances(units)


@pytest.fixture
def table_mesh(table_units):
    """As `mesh`, of the FMUs with tables."""
    yield from instances(table_units)


def instances(units):
    made = []

    def make(pair="external", **options):
        made.append(units[pair].instance(**options))
        return made[-1]

    yield make
    for instance in made:
        instance.close()


def oscillator(folder, swing):
    """An FMU of y'' + k(t) max(y, 0) = 1 with k = 4.9e8 N/m (1 + `swing` cos(mesh position)) on the line of action, without damping."""
    pair = PAIRS / "palermo2013-unmodified.json"
    radius = 38.4567147e-3  # of the base circles
    rows = ["torque_nm,mesh_position,center_distance_offset_um,misalignment_mrad,ste_loa_um,contact_z_mm"]
    for torque in (0.0, 0.1, 1.0, 10.0, 100.0, 1000.0):
        for n in range(32):
            stiffness = 4.9e8 * (1.0 + swing * math.cos(math.tau * n / 32))
            rows.append(f"{torque},{n / 32},0,0,{1e6 * torque / radius / stiffness!r},12.5")
    samples, tables = folder / "samples.csv", folder / "tables.json"
    samples.write_text("\n".join(rows) + "\n")
    gearmesh.command.run("import", samples, "--pair", pair, "-o", tables)
    return gearmesh.pack(tables, folder / "oscillator.fmu", set={"damping": 0.0, "loadedFlank": "drive"})
