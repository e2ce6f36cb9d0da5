"""The wheels, as a user installs them: into an empty environment, without compiler and without Rust."""

import os
import subprocess
import sys
import zipfile

import pytest
from conftest import COARSE, DIST, ROOT, SCRIPT


def wheel(tag):
    (found,) = DIST.glob(f"*-{tag}.whl")
    return found


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """An environment with the wheel in it; only its own programs are on the path."""
    folder = tmp_path_factory.mktemp("environment")
    # Unlike venv, virtualenv needs no ensurepip; without either, the pip that runs the tests fills it.
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    install = [sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install", "--quiet"]
    subprocess.run([*install, wheel("manylinux2014_x86_64")], check=True)
    return folder


def test_the_installed_command_builds_a_unit_that_the_installed_package_runs(installed, tmp_path):
    bare = {"PATH": str(installed / "bin"), "HOME": str(tmp_path), "LANG": os.environ.get("LANG", "C.UTF-8")}

    def run(*command):
        return subprocess.run(
            [str(word) for word in command], cwd=tmp_path, env=bare, check=True, capture_output=True, text=True
        ).stdout

    pair = ROOT / "resources" / "pairs" / "palermo2013.json"
    run(installed / "bin" / "gearmesh", "build", pair, "-o", "pair.fmu", *COARSE)
    names = zipfile.ZipFile(tmp_path / "pair.fmu").namelist()
    assert {"binaries/linux64/GearMesh.so", "binaries/win64/GearMesh.dll"} <= set(names)
    assert abs(float(run(installed / "bin" / "python", "-c", SCRIPT, "pair.fmu"))) > 10.0


@pytest.mark.parametrize("tag", ["manylinux2014_x86_64", "win_amd64"])
def test_wheels_hold_command_libraries_package_and_licences(tag):
    names = {name.split("/", 1)[1] for name in zipfile.ZipFile(wheel(tag)).namelist()}
    program = "gearmesh.exe" if tag == "win_amd64" else "gearmesh"
    scripts = {f"scripts/{name}" for name in (program, "libgearmesh.so", "gearmesh.dll")}
    licences = {f"licenses/{name}" for name in ("LICENSE-MIT", "LICENSE-APACHE", "third-party.txt")}
    assert scripts | licences | {"__init__.py", "pair.py", "py.typed", "METADATA", "RECORD"} <= names
