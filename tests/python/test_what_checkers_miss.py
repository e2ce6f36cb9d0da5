"""Defects of FMUs that the public checkers let pass, looked for in the packed file itself."""

import re
import subprocess
import zipfile
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import gearmesh
import numpy as np
import pytest
from conftest import FORMULATIONS, pair_files
from fmpy import read_model_description
from fmpy.validation import validate_fmu


@pytest.fixture(scope="module")
def xml(fmus):
    with zipfile.ZipFile(fmus["external"]) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def scalars(xml):
    return list(xml.find("ModelVariables"))


def test_fmpy_finds_nothing_and_start_values_lie_within_their_range(fmus):
    for path in fmus.values():
        assert validate_fmu(str(path)) == []
        for v in read_model_description(str(path)).modelVariables:
            if v.start is not None and v.type in ("Real", "Integer"):
                assert float(v.min or "-inf") <= float(v.start) <= float(v.max or "inf"), v.name


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


@FORMULATIONS
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
