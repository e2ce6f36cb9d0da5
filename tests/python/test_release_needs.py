"""`make release` says what the system lacks before it sets anything up."""

import subprocess
import sys

from conftest import ROOT


def test_what_is_missing_is_named_with_nothing_but_python():
    run = subprocess.run(
        [sys.executable, "-S", "-m", "scripts.release.platforms"],
        cwd=ROOT, env={"PATH": "/nowhere"}, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode != 0
    assert run.stderr.startswith("release: missing\n") and "Rust" in run.stderr, run.stderr


def test_it_is_the_first_that_make_runs():
    lines = subprocess.run(
        ["make", "--no-print-directory", "-n", "release"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.splitlines()
    assert lines[0].endswith("-m scripts.release.platforms"), lines[0]
