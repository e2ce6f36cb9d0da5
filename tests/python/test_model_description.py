"""Rules that modelDescription.xml keeps: what build.rs takes for granted, and what the public checkers of FMUs miss."""

import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
XML = ElementTree.parse(ROOT / "modelDescription.xml").getroot()
VARIABLES = list(XML.find("ModelVariables"))
UNITS = {
    unit.get("name"): [d.get("name") for d in unit.findall("DisplayUnit")] for unit in XML.find("UnitDefinitions")
}
ENUMERATIONS = {t.get("name"): list(t.find("Enumeration")) for t in XML.find("TypeDefinitions")}
# (causality, variability): `initial`, and whether there is a start value.
ROLES = {
    ("input", "continuous"): (None, True),
    ("parameter", "fixed"): ("exact", True),
    ("parameter", "tunable"): ("exact", True),
    ("output", "continuous"): ("calculated", False),
}


def test_the_version_is_that_of_the_crate():
    manifest = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))
    assert XML.get("version") == manifest["workspace"]["package"]["version"]


@pytest.mark.parametrize("variable", VARIABLES, ids=lambda v: v.get("name"))
def test_a_variable_has_all_that_belongs_to_its_role_and_type(variable):
    (typed,) = variable
    role = (variable.get("causality"), variable.get("variability"))
    assert (variable.get("initial"), typed.get("start") is not None) == ROLES[role]
    assert variable.get("description")
    assert typed.tag == "Real" or role[1] != "continuous"
    low, high = float(typed.get("min", "-inf")), float(typed.get("max", "inf"))
    if typed.tag == "Real":
        displays = UNITS[typed.get("unit")]
        assert typed.get("displayUnit") in [None, *displays]
        # Importers read no others.
        assert typed.get("unit").isascii() and typed.get("displayUnit", "").isascii()
        assert float(typed.get("nominal")) > 0
    elif typed.tag == "Enumeration":
        low, high = 1, len(ENUMERATIONS[typed.get("declaredType")])
    if typed.get("start") is not None and typed.tag != "Boolean":
        assert low <= float(typed.get("start")) <= high


def test_items_of_enumerations_count_from_1():
    for items in ENUMERATIONS.values():
        assert [int(item.get("value")) for item in items] == list(range(1, len(items) + 1))


def test_names_are_used_once_and_units_are_defined_once():
    names = [v.get("name") for v in VARIABLES]
    assert len(set(names)) == len(names)
    assert len(UNITS) == len(list(XML.find("UnitDefinitions")))


def test_value_references_ascend_without_a_gap_within_a_causality_from_the_inputs_on():
    """Hosts pass inputs and outputs as blocks."""
    assert (VARIABLES[0].get("causality"), VARIABLES[0].get("valueReference")) == ("input", "0")
    for one, other in zip(VARIABLES, VARIABLES[1:], strict=False):
        step = int(other.get("valueReference")) - int(one.get("valueReference"))
        assert step == 1 or (step > 1 and one.get("causality") != other.get("causality")), other.get("name")


@pytest.mark.parametrize("block, sources", [("Outputs", ["input"]), ("InitialUnknowns", ["input", "parameter"])])
def test_every_output_stands_once_in_the_structure_with_ascending_dependencies(block, sources):
    outputs = [i for i, v in enumerate(VARIABLES, 1) if v.get("causality") == "output"]
    unknowns = list(XML.find("ModelStructure").find(block))
    assert [int(unknown.get("index")) for unknown in unknowns] == outputs
    for unknown in unknowns:
        known = [int(k) for k in unknown.get("dependencies").split()]
        assert known == sorted(set(known))
        assert {VARIABLES[k - 1].get("causality") for k in known} <= set(sources)


@pytest.mark.parametrize("interface", ["ModelExchange", "CoSimulation"])
def test_capabilities_fit_one_another(interface):
    found = XML.find(interface)
    assert found.get("canGetAndSetFMUstate") == found.get("canSerializeFMUstate") == "true"
    assert found.get("canNotUseMemoryManagementFunctions") == "true"  # Rust allocates
    assert found.get("modelIdentifier") == XML.get("modelName")
