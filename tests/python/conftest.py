"""The FMUs that the tests drive, packed once."""

import copy
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
COUPLINGS = pytest.mark.parametrize("coupling", [1, 2, 3, 4], ids=["held", "sequential", "parallel", "automatic"])
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
    """The pairs by name: external, gear 2 a ring, gear 1 a ring; with profile shifts, unequal faces and a face offset, too; each in both hands
    but for shifted rings."""
    external, shifted = (json.loads((PAIRS / f"{name}.json").read_text()) for name in ("palermo2013", "helical-25-47"))
    ring = json.loads((PAIRS / "planet-ring-27-84.json").read_text())
    # A helix with the transverse module kept leaves all diameters as they are.
    helix = 12.0
    module = ring["normal_module_mm"] * math.cos(math.radians(helix))
    ring = dict(ring, helix_angle_deg=helix, normal_module_mm=module)
    shifted_ring = copy.deepcopy(ring) | {"name": "ring-shifted", "face_offset_mm": -2.5}
    shifted_ring["gear2"] |= {"face_width_mm": 26.0, "profile_shift": 0.3}
    # The centre distance of these shifts, and teeth of standard height there.
    del shifted_ring["center_distance_mm"]
    for gear in ("gear1", "gear2"):
        del shifted_ring[gear]["tip_diameter_mm"], shifted_ring[gear]["tip_relief"]
    base = {"external": external, "ring2": ring, "ring1": swapped(ring), "external-shifted": shifted}
    rings = {"ring2-shifted": shifted_ring, "ring1-shifted": dict(swapped(shifted_ring), face_offset_mm=2.5)}
    return base | {f"{name}-left": other_hand(pair) for name, pair in base.items()} | rings


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


class Lazy(dict):
    """Values that are made when they are first asked for."""

    def __init__(self, make):
        super().__init__()
        self.make = make

    def __missing__(self, name):
        self[name] = self.make(name)
        return self[name]


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """FMU files by name: pairs with constant stiffness, shipped tables as packing makes them, tables by pair and grid, as `external-cycle`."""
    folder, pairs = tmp_path_factory.mktemp("fmus"), pair_files()

    def make(name):
        file = folder / f"{name}.fmu"
        if name in SHIPPED:
            return gearmesh.pack(TABLES / f"{name}.json", file)
        if name in pairs:
            return gearmesh.pack(pairs[name], file)
        pair, grid = name.split("-")
        return gearmesh.build(tabulated_pairs()[pair], file, **QUICK, **GRIDS[grid], contact=name == "external-cycle")

    return Lazy(make)


@pytest.fixture(scope="session")
def units(fmus):
    """The FMUs, unpacked."""
    units = Lazy(lambda name: Unit(fmus[name]))
    yield units
    for unit in units.values():
        unit.close()


@pytest.fixture
def mesh(units):
    """Makes instances of an FMU and frees them after the test."""
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
