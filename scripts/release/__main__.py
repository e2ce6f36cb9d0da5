"""Builds both platforms, packs the shipped pairs, the wheels and the archives, and writes the manifest.

    python -m scripts.release

leaves in target/dist: linux64/ and win64/ (command and libraries of both platforms), fmus/, cross-check/,
one archive and one wheel for each platform, and manifest.json with versions, sizes and SHA-256.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import time
import tomllib
from pathlib import Path

from . import cross_check, platforms, wheel
from .platforms import PLATFORMS, WINDOWS, Platform
from .tools import ROOT, output, run

DIST = ROOT / "target" / "dist"
# The paper's pair, one with another law of modifications, an internal one.
CROSS_CHECKED = ("palermo2013", "helical-25-47", "planet-ring-27-84")


def programs(platform: Platform) -> Path:
    """The folder with this platform's command and the libraries of both, so that it packs FMUs for both."""
    folder = DIST / platform.name
    folder.mkdir()
    shutil.copy(platform.folder / platform.program, folder)
    for other in PLATFORMS:
        shutil.copy(other.folder / other.library, folder)
    return folder


def packed(pair: str, fmu: Path, *options: str) -> Path:
    """The FMU of a shipped pair with the libraries of both platforms."""
    fmu.parent.mkdir(exist_ok=True)
    tables = ROOT / "resources" / "tables" / f"{pair}.json"
    run(DIST / "linux64" / "gearmesh", "pack", "--tables", tables, *options, "-o", fmu)
    return fmu


def archive(platform: Platform, folder: Path, version: str, licenses: list[Path]) -> None:
    """One file to download: command, libraries, pair files, licences."""
    name = f"gearmesh-{version}-{platform.name}"
    stage = ROOT / "target" / "archive" / name
    shutil.rmtree(stage, ignore_errors=True)
    shutil.copytree(folder, stage)
    shutil.copytree(ROOT / "resources" / "pairs", stage / "pairs")
    for page in ("pair-file.md", "flanks.md"):
        shutil.copy(ROOT / "docs" / page, stage)
    for file in licenses:
        shutil.copy(file, stage)
    kind = "zip" if platform is WINDOWS else "gztar"
    shutil.make_archive(str(DIST / name), kind, stage.parent, name)


def manifest(version: str) -> None:
    """Sizes and checksums of every file, and what built them."""
    files = [
        {
            "file": file.relative_to(DIST).as_posix(),
            "bytes": file.stat().st_size,
            "sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
        }
        for file in sorted(DIST.rglob("*"))
        if file.is_file()
    ]
    about = {
        "version": version,
        "commit": output("git", "rev-parse", "HEAD"),
        "commit_date": output("git", "show", "--no-patch", "--format=%cs"),
        "compilers": platforms.compilers(),
        "files": files,
    }
    (DIST / "manifest.json").write_text(json.dumps(about, indent=2) + "\n")


def main() -> None:
    platforms.require()
    began = time.monotonic()
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    platforms.build_linux()
    platforms.build_windows()
    shutil.rmtree(DIST, ignore_errors=True)
    DIST.mkdir(parents=True)
    third_party = ROOT / "target" / "third-party.txt"
    run("python", "scripts/licenses.py", "--command", third_party)
    licenses = [ROOT / "LICENSE-MIT", ROOT / "LICENSE-APACHE", third_party]
    for platform in PLATFORMS:
        folder = programs(platform)
        archive(platform, folder, version, licenses)
        wheel.pack(platform, version, folder, licenses, DIST)
    for tables in sorted((ROOT / "resources" / "tables").glob("*.json")):
        packed(tables.stem, DIST / "fmus" / f"{tables.stem}.fmu")
    # For inputs that are given: the outputs of a step are those of its inputs.
    held = [packed(pair, ROOT / "target" / "held" / f"{pair}.fmu", "--set", "coupling=held") for pair in CROSS_CHECKED]
    cross_check.material(held, DIST / "cross-check")
    manifest(version)
    for file in sorted(DIST.rglob("*")):
        if file.is_file():
            print(f"{file.stat().st_size / 1e6:8.2f} MB  {file.relative_to(DIST)}")
    print(f"release: {(time.monotonic() - began) / 60:.1f} min")


if __name__ == "__main__":
    main()
