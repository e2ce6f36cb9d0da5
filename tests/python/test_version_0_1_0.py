"""A unit that version 0.1.0 packed runs with today's library and gives what it gave then, once its tables say that they hold today's
law of misalignment: of helical gears that was another, and such tables are refused by name.

`tests/data/version-0.1.0/pair.fmu` holds that version's modelDescription.xml and resources; the library is
put in here. `outputs.json` has the outputs that the library of 0.1.0 gave, without damping.
"""

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from host import Unit

DATA = ROOT / "tests" / "data" / "version-0.1.0"
GEAR_1_SPIN = "gear1.angles[3]"

# Outputs of one kind have the size of the largest among them.
KINDS = ["force", "moment", "contact.point"]


@pytest.fixture(scope="module")
def old(units, tmp_path_factory):
    """The unit of 0.1.0 with the library that today's units carry."""
    unit = Unit(DATA / "pair.fmu", tmp_path_factory.mktemp("version-0.1.0") / "unit")
    shutil.copytree(Path(units["external"].folder) / "binaries", Path(unit.folder) / "binaries")
    renumbered(Path(unit.folder) / "resources/tables.json")
    # An Integer and a Boolean in that version; today's library has all outputs as Real, by the same references.
    for name in ("mesh.flank", "mesh.outOfRange"):
        unit.variables[name].type = "Real"
    yield unit
    unit.close()


def renumbered(tables):
    """Gives tables of version 1 today's number, and the checksum that goes with it."""
    text = tables.read_text().rstrip("\n").replace('"version":1', '"version":2', 1)
    old = json.loads(text)["checksum_sha256"]
    unsealed = text.replace(old, "", 1)
    tables.write_text(text.replace(old, hashlib.sha256(unsealed.encode()).hexdigest(), 1) + "\n")


def started_as_then(unit, parameters, spin):
    """An instance whose phases are those that 0.1.0 took at this spin of gear 1.

    That version let the unmodified involutes touch in the initial pose, today's library lets the flanks as they are, with
    relief and misalignment. The pose in which today's touch is gear 1 turned by the transmission error there.
    """
    from_initial_pose = parameters["phaseReference"] == 1
    sign = -1 if parameters["loadedFlank"] == 2 else 1
    z1, z2 = 25, 47

    def start(turn):
        instance = unit.instance()
        phase = parameters["meshPhase"] + sign * turn
        instance.initialize({**parameters, GEAR_1_SPIN: spin + turn, "meshPhase": phase})
        return instance

    turn = 0.0
    for _ in range(8 if from_initial_pose else 0):
        instance = start(turn)
        turn = instance.get("mesh.transmissionError") * (z1 + z2) / (z1 * instance.get("mesh.centerDistance"))
        instance.close()
    return start(turn)


def test_a_unit_packed_by_version_0_1_0_gives_the_outputs_it_gave_then(old):
    record = json.loads((DATA / "outputs.json").read_text())
    names = record["outputs"]
    # What an importer may take from modelDescription.xml: the fixed parameters that this unit started with.
    starts = {
        v.name: v.start
        for v in old.description.modelVariables
        if v.causality == "parameter" and v.type in ("Real", "Enumeration")
    }
    starts = {n: float(x) if old.variables[n].type == "Real" else int(x) for n, x in starts.items()}
    assert len(record["rows"]) == 40
    for row, (parameters, spin, inputs, outputs) in enumerate(record["rows"]):
        chosen = dict(zip(record["parameters"], parameters))
        instance = started_as_then(old, {**starts, **chosen}, spin)
        instance.set({GEAR_1_SPIN: spin, **dict(zip(record["inputs"], inputs))})
        found, expected = np.array([float(instance.get(n)) for n in names]), np.array(outputs)
        scale = np.abs(expected)
        for kind in KINDS:
            same = [i for i, n in enumerate(names) if kind in n]
            scale[same] = scale[same].max()
        # A rounding of the poses times the stiffness; without load, of the length of a tooth.
        wrong = np.abs(found - expected) > 1e-10 * scale + 1e-15
        if chosen["formulation"] == 1:
            # (6) of the paper leaves out what a changing centre distance adds; 0.1.0 did, too.
            wrong[names.index("mesh.transmissionErrorRate")] = False
        assert not wrong.any(), (row, [(names[i], found[i], expected[i]) for i in np.flatnonzero(wrong)])
        instance.close()


