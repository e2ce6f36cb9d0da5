"""Defects of FMUs that the public checkers let pass, looked for in the packed file itself."""

import ctypes
import re
import subprocess
import zipfile
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import gearmesh
from fmpy import read_model_description
from fmpy.validation import validate_fmu


@pytest.fixture(scope="module")
def xml(fmus):
    with zipfile.ZipFile(fmus["external"]) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def scalars(xml):
    return list(xml.find("ModelVariables"))


def test_fmpy_finds_nothing(fmus):
    for path in fmus.values():
        assert validate_fmu(str(path)) == []


def test_value_references_are_unique_over_all_types(xml):
    references = [v.get("valueReference") for v in scalars(xml)]
    assert len(set(references)) == len(references)


def test_inputs_and_main_outputs_are_contiguous_blocks(xml):
    by_name = {v.get("name"): int(v.get("valueReference")) for v in scalars(xml)}
    inputs = [int(v.get("valueReference")) for v in scalars(xml) if v.get("causality") == "input"]
    assert inputs == list(range(len(inputs))) and len(inputs) == 48
    main = [
        by_name[f"{owner}[{i}]"]
        for owner in ("gear1.force", "gear1.moment", "gear2.force", "gear2.moment", "contact.point")
        for i in (1, 2, 3)
    ]
    assert main == list(range(main[0], main[0] + 15))


def listed(xml, block):
    """Names of what each unknown of a block of ModelStructure depends on, by its name."""
    variables = scalars(xml)
    out = {}
    for unknown in xml.find("ModelStructure").find(block):
        known = [int(k) for k in unknown.get("dependencies").split()]
        assert known == sorted(set(known))
        out[variables[int(unknown.get("index")) - 1].get("name")] = [
            variables[k - 1].get("name") for k in known
        ]
    return out


def named(xml, causality):
    return {v.get("name") for v in scalars(xml) if v.get("causality") == causality}


def test_outputs_depend_on_inputs_and_at_first_on_parameters(xml):
    running, initial = listed(xml, "Outputs"), listed(xml, "InitialUnknowns")
    assert set(running) == set(initial) == named(xml, "output")
    for name, known in running.items():
        assert set(known) <= named(xml, "input"), name
        # In initialization parameters count as well; these act in steps alone.
        assert set(initial[name]) - set(known) == named(xml, "parameter") - {"coupling", "effectiveMass"}


@pytest.mark.parametrize("formulation", [1, 2], ids=["paper", "conjugate"])
@pytest.mark.parametrize("pair", ["external-all", "ring2-all"])
def test_no_output_changes_with_an_input_it_is_not_listed_with(table_mesh, xml, pair, formulation):
    dependencies = listed(xml, "Outputs")
    inputs, outputs = sorted(named(xml, "input")), list(dependencies)
    rng = np.random.default_rng(7)
    seen = set()
    instance = table_mesh(pair)
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


def test_units_are_spelled_in_ascii(xml):
    for unit in xml.find("UnitDefinitions"):
        assert all(u.get("name").isascii() for u in [unit, *unit.findall("DisplayUnit")])


def test_the_unit_names_its_author_and_its_date_and_is_packed_alike_every_time(fmus, tmp_path):
    with zipfile.ZipFile(fmus["external"]) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert root.get("author") and root.get("copyright") and root.get("license")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", root.get("generationDateAndTime"))
    again = tmp_path / "again.fmu"
    gearmesh("pack", "--pair", fmus["external"].with_suffix(".json"), "-o", again)
    assert again.read_bytes() == fmus["external"].read_bytes()


def test_the_library_exports_the_interface_and_nothing_else(units):
    library = next((Path(units["external"].folder) / "binaries").glob("*/*"))
    table = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True)
    assert table.returncode == 0, table.stderr
    names = [line.split()[-1] for line in table.stdout.splitlines()]
    assert names and all(name.startswith("fmi2") for name in names), names


def test_a_state_that_can_be_serialised_can_be_had(xml):
    for interface in ("ModelExchange", "CoSimulation"):
        flags = xml.find(interface).attrib
        assert flags["canSerializeFMUstate"] == flags["canGetAndSetFMUstate"] == "true"
        assert flags["canNotUseMemoryManagementFunctions"] == "true"
        # The library is named after it, whatever the pair is called.
        assert flags["modelIdentifier"] == "GearMesh"


def test_start_values_lie_within_their_range(fmus):
    for path in fmus.values():
        for v in read_model_description(str(path)).modelVariables:
            if v.start is None or v.type not in ("Real", "Integer"):
                continue
            assert v.min is None or float(v.start) >= float(v.min), v.name
            assert v.max is None or float(v.start) <= float(v.max), v.name


def test_inputs_have_a_start_and_no_initial_and_outputs_no_start(xml):
    for v in scalars(xml):
        has_start = v[0].get("start") is not None
        if v.get("causality") == "input":
            assert has_start and v.get("initial") is None, v.get("name")
        if v.get("causality") == "output":
            assert not has_start, v.get("name")


def test_every_unit_and_display_unit_is_defined(xml):
    units = {
        u.get("name"): {d.get("name") for d in u.findall("DisplayUnit")}
        for u in xml.find("UnitDefinitions")
    }
    for v in scalars(xml):
        if v[0].tag == "Real":
            assert v[0].get("unit") in units, v.get("name")
            display = v[0].get("displayUnit")
            assert display is None or display in units[v[0].get("unit")], v.get("name")


def test_the_library_bears_the_model_identifier(fmus, xml):
    identifier = xml.find("CoSimulation").get("modelIdentifier")
    with zipfile.ZipFile(fmus["external"]) as archive:
        libraries = [PurePosixPath(n) for n in archive.namelist() if n.startswith("binaries/")]
    assert libraries and all(p.stem == identifier for p in libraries)


def test_the_archive_is_plain(fmus):
    with zipfile.ZipFile(fmus["external"]) as archive:
        for info in archive.infolist():
            assert "\\" not in info.filename and not info.filename.startswith("/")
            assert info.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            assert (info.external_attr >> 28) != 0o12, "a symbolic link"
        assert {"modelDescription.xml", "model.png", "documentation/index.html"} <= set(
            archive.namelist()
        )


def test_the_documentation_lists_every_variable_and_draws_the_frames(fmus, xml):
    with zipfile.ZipFile(fmus["external"]) as archive:
        page = archive.read("documentation/index.html").decode()
    for v in scalars(xml):
        assert f"<code>{v.get('name')}</code>" in page
    assert "<svg" in page and not re.search(r"@[A-Z]+@", page)
    ElementTree.fromstring(page[page.index("<svg") : page.index("</svg>") + 6])


def test_units_of_different_pairs_have_different_guids(fmus):
    guids = [read_model_description(str(p)).guid for p in fmus.values()]
    assert len(set(guids)) == len(guids)


def test_no_function_of_the_interface_is_missing(units):
    names = """GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment
        EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean
        GetString SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate
        SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative
        SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus
        GetIntegerStatus GetBooleanStatus GetStringStatus EnterEventMode NewDiscreteStates
        EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates GetDerivatives
        GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates""".split()
    library = ctypes.CDLL(str(next((Path(units["external"].folder) / "binaries").glob("*/*"))))
    for name in names:
        assert hasattr(library, f"fmi2{name}")
    library.fmi2GetVersion.restype = ctypes.c_char_p
    library.fmi2GetTypesPlatform.restype = ctypes.c_char_p
    assert (library.fmi2GetVersion(), library.fmi2GetTypesPlatform()) == (b"2.0", b"default")
