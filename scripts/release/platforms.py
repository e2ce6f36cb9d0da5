"""Command and library for one platform each, built on Linux.

`python -m scripts.release.platforms` says what that lacks.
"""

from __future__ import annotations

import os
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

from .tools import ROOT, output, run

PROGRAM = "gearmesh"
# Neither symbols nor line tables: nobody debugs what was downloaded, and they are most of the size.
STRIPPED = ["--release", "--locked", "--config", 'profile.release.strip="symbols"']
# One by one: what the command asks of crates that both use is none of the library's.
PARTS = (["--package", "gearmesh-command"], ["--package", "gearmesh"])


@dataclass(frozen=True)
class Platform:
    """Names of one platform: FMI's, wheel's and those of the files that cargo makes."""

    name: str
    wheel: str
    program: str
    library: str
    target: str

    @property
    def folder(self) -> Path:
        """Where cargo leaves program and library."""
        return ROOT / "target" / self.name / self.target.removesuffix(".2.17") / "release"


LINUX = Platform(
    "linux64",
    "manylinux2014_x86_64",
    PROGRAM,
    "libgearmesh.so",
    # The oldest C library that is served, that of RHEL 7.
    "x86_64-unknown-linux-gnu.2.17",
)
WINDOWS = Platform(
    "win64", "win_amd64", "gearmesh.exe", "gearmesh.dll", "x86_64-pc-windows-gnu"
)
PLATFORMS = (LINUX, WINDOWS)


def require() -> None:
    """Ends the program with what of the system is not there, each with its remedy; takes nothing of `.venv`."""
    if lines := missing():
        sys.exit("release: missing\n" + "\n".join(f"  {line}" for line in lines))


def missing() -> list[str]:
    if not shutil.which("rustc"):
        return ["Rust 1.89 or later: https://rustup.rs"]
    out = []
    if not shutil.which("x86_64-w64-mingw32-gcc"):
        out.append("x86_64-w64-mingw32-gcc links for Windows: apt install gcc-mingw-w64-x86-64-win32")
    if not any(map(os.path.exists, WINE)):
        out.append("wine64 runs what was built for Windows: apt install wine64")
    if not standard_library_for_windows() and not all(map(os.path.exists, DEBIAN)):
        out.append(
            "Rust's standard library for Windows: rustup target add x86_64-pc-windows-gnu, "
            "or apt install rustc-web cargo-web rust-web-src"
        )
    return out


WINE = ("/usr/bin/wine64", "/usr/lib/wine/wine64")
# Debian's own Rust, whose sources of the standard library serve any target.
DEBIAN = ("/usr/bin/rustc", "/usr/bin/cargo", "/usr/lib/rustlib/src/rust/library")


def standard_library_for_windows() -> bool:
    """Whether the toolchain of `make build` has the target."""
    folder = output("rustc", "--print", "target-libdir", "--target", WINDOWS.target)
    return Path(folder).is_dir()


def build_linux() -> None:
    """By cargo-zigbuild: zig links against the symbols of any glibc."""
    # zig names its headers relative to the folder it is called in, if it lies below; build scripts run elsewhere.
    beside = ROOT / "target"
    beside.mkdir(exist_ok=True)
    for part in PARTS:
        run("cargo", "zigbuild", *STRIPPED, *part, *_place(LINUX), folder=beside)


def build_windows() -> None:
    """By mingw, which is needed for linking alone: the library asks for Windows' own DLLs only."""
    headers = Path(output("x86_64-w64-mingw32-gcc", "-print-file-name=include"))
    environment = {
        "CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER": str(ROOT / "scripts/release/link_for_windows.sh"),
        "BINDGEN_EXTRA_CLANG_ARGS_x86_64_pc_windows_gnu": f"-I{headers}",
    }
    build = ["cargo", "build"]
    if not standard_library_for_windows():
        rustc, cargo, _ = DEBIAN
        # RUSTC_BOOTSTRAP lets a stable compiler build the standard library from its sources.
        environment |= {"RUSTC": rustc, "RUSTC_BOOTSTRAP": "1"}
        build = [cargo, "build", "-Zbuild-std=std,panic_unwind"]
    for part in PARTS:
        run(*build, *STRIPPED, *part, *_place(WINDOWS), environment=environment)


def _place(platform: Platform) -> list[str]:
    # A target folder of its own: the compilers differ, and would throw away one another's work.
    return ["--target", platform.target, "--target-dir", str(ROOT / "target" / platform.name)]


def compilers() -> dict[str, str]:
    """Versions of what built, for the manifest."""
    windows = "rustc" if standard_library_for_windows() else DEBIAN[0]
    return {
        "linux64": f"{output('rustc', '--version')}, zig {output('python', '-m', 'ziglang', 'version')}",
        "win64": f"{output(windows, '--version')}, {output('x86_64-w64-mingw32-gcc', '--version').splitlines()[0]}",
    }


if __name__ == "__main__":
    require()
