#!/usr/bin/env bash
# setup.sh [GROUP...] makes .venv with the Python packages of the group `demo` of pyproject.toml and of further GROUPs, in the
# versions of constraints.txt, and the package in python/.
# setup.sh --bindgen makes what `cargo test` needs for bindgen: two links that .cargo/config.toml names, .venv/libclang
# (the shared library that comes with the Python package `libclang`) and .venv/c-include (the C compiler's own headers).
# Safe to call again.
set -euo pipefail
cd "$(dirname "$0")/.."

python=${PYTHON:-python3}
venv=.venv

fail() {
    printf 'setup: %s\n' "$*" >&2
    exit 1
}

have() { command -v "$1" >/dev/null 2>&1; }

have cargo || fail "cargo is missing: install Rust 1.89 or later (https://rustup.rs)"
have "$python" || fail "$python is missing: install Python 3.11 or later, or name one: make PYTHON=/path/to/python3"
have gcc || fail "gcc is missing: install a C compiler (Debian: apt install gcc)"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    fail "$("$python" --version) is too old: Python 3.11 or later is needed, name one: make PYTHON=/path/to/python3"

# Debian and Ubuntu split ensurepip off into python3-venv. Without it, a pip of the system can still
# fill an environment that has none of its own; failing that, virtualenv brings its own pip.
if [ ! -x "$venv/bin/python" ]; then
    if "$python" -c 'import ensurepip' 2>/dev/null; then
        "$python" -m venv "$venv"
    elif "$python" -m pip --version >/dev/null 2>&1; then
        "$python" -m venv --without-pip "$venv"
    elif "$python" -m virtualenv --version >/dev/null 2>&1; then
        "$python" -m virtualenv --quiet "$venv"
    else
        fail "this Python can make no environment with pip in it: install python3-venv (Debian: apt install python3-venv)"
    fi
fi

if "$venv/bin/python" -m pip --version >/dev/null 2>&1; then
    pip=("$venv/bin/python" -m pip)
else
    pip=("$python" -m pip --python "$venv/bin/python")
fi
# Groups are complete, so that pip need not follow what a package says it may want. Python compiles what it imports.
install() {
    "$venv/bin/python" scripts/packages.py "$@" >"$venv/packages.txt"
    "${pip[@]}" install --quiet --disable-pip-version-check --no-deps --no-compile --requirement "$venv/packages.txt" ||
        fail "the packages of $* could not be installed: see pip's message above"
}

if [ "${1:-}" = --bindgen ]; then
    echo "setup: libclang into $venv, a few seconds"
    install bindgen
    native=$("$venv/bin/python" -c 'import pathlib, clang; print(pathlib.Path(clang.__file__).resolve().parent / "native")')
    headers=$(gcc -print-file-name=include)
    [ -d "$native" ] || fail "the Python package libclang brings no library for this platform: install libclang-dev and set LIBCLANG_PATH"
    [ -f "$headers/stddef.h" ] || fail "gcc names no folder with its own headers (gcc -print-file-name=include gives $headers)"
    ln -sfn "$native" "$venv/libclang"
    ln -sfn "$headers" "$venv/c-include"
    touch "$venv/.bindgen"
    exit 0
fi

echo "setup: Python packages into $venv, a quarter of a minute at the first time"
install demo "$@"
# `import gearmesh` finds the sources; the path is relative, so that the folder may be moved.
"$venv/bin/python" - python <<'END'
import os, pathlib, sys, sysconfig

site = sysconfig.get_path("purelib")
pathlib.Path(site, "gearmesh.pth").write_text(os.path.relpath(os.path.abspath(sys.argv[1]), site) + "\n")
END

touch "$venv/.complete"
