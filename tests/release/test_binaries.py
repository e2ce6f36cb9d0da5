"""What the binaries of a release need and what they show, by binutils."""

import re
import subprocess
import zipfile

import pytest
from conftest import DIST, ROOT

LINUX = [DIST / "linux64" / "gearmesh", DIST / "linux64" / "libgearmesh.so"]
WINDOWS = [DIST / "win64" / "gearmesh.exe", DIST / "win64" / "gearmesh.dll"]
# Present in Windows 10 itself; the last is the set of its C runtime.
SYSTEM_DLLS = {
    "kernel32.dll", "ntdll.dll", "userenv.dll", "ws2_32.dll", "bcryptprimitives.dll", "bcrypt.dll",
    "advapi32.dll", "msvcrt.dll", "ole32.dll", "oleaut32.dll", "shell32.dll",
}  # fmt: skip
OLDEST_GLIBC = (2, 17)
# All functions of FMI 2.0, as tests/c_interface/header.rs compares them with the standard's header.
FUNCTIONS = set(re.findall(r"(fmi2\w+)TYPE", (ROOT / "tests" / "c_interface" / "header.rs").read_text()))


def dump(*arguments, program="objdump"):
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout


def windows_dump(file):
    return dump("-p", file, program="x86_64-w64-mingw32-objdump")


@pytest.mark.parametrize("file", LINUX, ids=lambda file: file.name)
def test_linux_binaries_load_with_the_glibc_of_2012(file):
    versions = re.findall(r"GLIBC_(\d+)\.(\d+)", dump("-T", file))
    assert versions
    assert max((int(a), int(b)) for a, b in versions) <= OLDEST_GLIBC


@pytest.mark.parametrize("file", WINDOWS, ids=lambda file: file.name)
def test_windows_binaries_import_from_windows_alone(file):
    names = {name.lower() for name in re.findall(r"DLL Name: (\S+)", windows_dump(file))}
    assert names
    assert {n for n in names - SYSTEM_DLLS if not n.startswith("api-ms-win-")} == set()


def test_the_libraries_export_the_interface_and_nothing_else():
    lines = dump("-T", LINUX[1]).splitlines()
    defined = {line.split()[-1] for line in lines if " DF .text" in line or " DO ." in line}
    assert defined == FUNCTIONS
    table = windows_dump(WINDOWS[1]).split("[Ordinal/Name Pointer] Table")[1]
    names = set(re.findall(r"^\s*\[ *\d+\].*?(\S+)$", table.split("\n\n")[0], re.M))
    assert names == FUNCTIONS


@pytest.mark.parametrize("file", LINUX + WINDOWS, ids=lambda file: file.name)
def test_binaries_are_stripped(file):
    program = "objdump" if file in LINUX else "x86_64-w64-mingw32-objdump"
    assert ".debug_" not in dump("-h", file, program=program)
    listing = dump("-t", file, program=program)
    assert "no symbols" in listing


def test_every_unit_and_every_folder_holds_both_libraries():
    fmus = sorted((DIST / "fmus").glob("*.fmu"))
    assert len(fmus) >= 4
    for fmu in fmus:
        names = zipfile.ZipFile(fmu).namelist()
        assert {"binaries/linux64/GearMesh.so", "binaries/win64/GearMesh.dll"} <= set(names), fmu.name
    for folder in ("linux64", "win64"):
        assert {"libgearmesh.so", "gearmesh.dll"} <= {p.name for p in (DIST / folder).iterdir()}
