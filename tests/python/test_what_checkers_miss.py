"""Defects of FMUs that the public checkers let pass, looked for in the packed file itself."""

import ctypes
import re
import zipfile
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import pytest
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


def test_outputs_depend_on_inputs_alone(xml):
    variables = scalars(xml)
    structure = xml.find("ModelStructure")
    outputs = {i for i, v in enumerate(variables, 1) if v.get("causality") == "output"}
    assert {int(u.get("index")) for u in structure.find("Outputs")} == outputs
    assert {int(u.get("index")) for u in structure.find("InitialUnknowns")} == outputs
    for unknown in structure.find("Outputs"):
        known = [int(k) for k in unknown.get("dependencies").split()]
        assert known == sorted(set(known))
        assert {variables[k - 1].get("causality") for k in known} == {"input"}


def test_a_state_that_can_be_serialised_can_be_had(xml):
    flags = xml.find("CoSimulation").attrib
    assert flags["canSerializeFMUstate"] == flags["canGetAndSetFMUstate"] == "true"
    assert flags["canNotUseMemoryManagementFunctions"] == "true"


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
        GetIntegerStatus GetBooleanStatus GetStringStatus""".split()
    library = ctypes.CDLL(str(next((Path(units["external"].folder) / "binaries").glob("*/*"))))
    for name in names:
        assert hasattr(library, f"fmi2{name}")
    library.fmi2GetVersion.restype = ctypes.c_char_p
    library.fmi2GetTypesPlatform.restype = ctypes.c_char_p
    assert (library.fmi2GetVersion(), library.fmi2GetTypesPlatform()) == (b"2.0", b"default")
