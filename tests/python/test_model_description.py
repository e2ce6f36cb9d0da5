"""Rules that modelDescription.xml and packed FMUs keep: what build.rs takes for granted, and what the public checkers miss."""

import re
import subprocess
import tomllib
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import gearmesh
import numpy as np
import pytest
from conftest import FORMULATIONS, ROOT, pair_files
from fmpy.validation import validate_fmu

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


def test_the_versions_of_units_and_package_are_that_of_the_project():
    manifest = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))
    assert XML.get("version") == gearmesh.__version__ == manifest["workspace"]["package"]["version"]


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


def named(causality):
    return [v.get("name") for v in VARIABLES if v.get("causality") == causality]


def listed(block):
    """Names of what each unknown of a block of ModelStructure depends on, by its name; both in ascending order."""
    indices, found = [], {}
    for unknown in XML.find("ModelStructure").find(block):
        indices.append(int(unknown.get("index")))
        known = [int(k) for k in unknown.get("dependencies").split()]
        assert known == sorted(set(known))
        found[VARIABLES[indices[-1] - 1].get("name")] = {VARIABLES[k - 1].get("name") for k in known}
    assert indices == sorted(set(indices))
    return found


def test_outputs_depend_on_inputs_and_at_first_on_parameters():
    running, initial = listed("Outputs"), listed("InitialUnknowns")
    assert list(running) == list(initial) == named("output")
    for name, known in running.items():
        assert known <= set(named("input")), name
        # In initialization parameters count as well; these act in steps alone.
        steps = {"coupling", "effectiveMass"}
        if name.startswith("coupling."):
            assert not known and initial[name] <= steps
        else:
            assert initial[name] - known == set(named("parameter")) - steps
        assert known <= initial[name]


@pytest.mark.parametrize("interface", ["ModelExchange", "CoSimulation"])
def test_capabilities_fit_one_another(interface):
    found = XML.find(interface)
    assert found.get("canGetAndSetFMUstate") == found.get("canSerializeFMUstate") == "true"
    assert found.get("canNotUseMemoryManagementFunctions") == "true"  # Rust allocates
    assert found.get("modelIdentifier") == XML.get("modelName")


@pytest.mark.slow
def test_fmpy_finds_nothing(fmus):
    for name in pair_files():
        assert validate_fmu(str(fmus[name])) == [], name


@FORMULATIONS
@pytest.mark.parametrize("pair", ["external-all", "ring2-all"])
def test_no_output_changes_with_an_input_it_is_not_listed_with(mesh, pair, formulation):
    dependencies = listed("Outputs")
    inputs, outputs = named("input"), list(dependencies)
    rng = np.random.default_rng(7)
    seen = set()
    instance = mesh(pair)
    instance.initialize({"formulation": formulation, "loadedFlank": 3, "damping": 3e3})
    start = {n: instance.get(n) for n in inputs}
    for _ in range(20):
        # Poses about the nominal one, within a slack of some micrometres, moving either way.
        values = {n: start[n] + rng.normal() * (2e-5 if "on[" in n or "angles" in n else 0.02) for n in inputs}
        values["gear1.angles[3]"] = rng.choice([-1, 1]) * rng.uniform(0, 4e-4)
        values |= {n: start[n] for n in inputs if "quaternion" in n}
        instance.set(values)
        before = dict(zip(outputs, instance.get(*outputs)))
        for name in inputs:
            far = "elocity" in name or name.startswith("carrier.position")
            instance.set({name: values[name] + (0.5 if far else 1e-6)})
            for output, value in zip(outputs, instance.get(*outputs)):
                if value != before[output]:
                    assert name in dependencies[output], (name, output, value, before[output])
                    seen.add((name, output))
            instance.set({name: values[name]})
    # Poses move all forces.
    assert {("gear1.position[1]", f"gear2.force[{k}]") for k in (1, 2, 3)} <= seen


def test_the_unit_names_its_author_and_its_date_and_is_packed_alike_every_time(fmus, tmp_path):
    with zipfile.ZipFile(fmus["external"]) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert root.get("author") and root.get("copyright") and root.get("license")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", root.get("generationDateAndTime"))
    again = gearmesh.pack(pair_files()["external"], tmp_path / "again.fmu")
    assert again.read_bytes() == fmus["external"].read_bytes()


def test_the_library_exports_the_interface_and_nothing_else(units):
    library = next((Path(units["external"].folder) / "binaries").glob("*/*"))
    table = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True)
    assert table.returncode == 0, table.stderr
    names = [line.split()[-1] for line in table.stdout.splitlines()]
    assert names and all(name.startswith("fmi2") for name in names), names


def test_the_archive_is_plain(fmus):
    with zipfile.ZipFile(fmus["external"]) as archive:
        for info in archive.infolist():
            assert "\\" not in info.filename and not info.filename.startswith("/")
            assert info.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            assert (info.external_attr >> 28) != 0o12, "a symbolic link"
        assert {"modelDescription.xml", "model.png", "documentation/index.html"} <= set(
            archive.namelist()
        )


def test_the_documentation_lists_every_variable_and_draws_the_frames(fmus):
    with zipfile.ZipFile(fmus["external"]) as archive:
        page = archive.read("documentation/index.html").decode()
    for v in VARIABLES:
        assert f"<code>{v.get('name')}</code>" in page
    assert "<svg" in page and "{{" not in page and "{%" not in page
    ElementTree.fromstring(page[page.index("<svg") : page.index("</svg>") + 6])
