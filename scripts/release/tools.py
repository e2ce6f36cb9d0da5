"""Running other programs, with .venv in front."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def _environment(more: dict[str, str] | None) -> dict[str, str]:
    path = f"{ROOT / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"
    return os.environ | {"PATH": path} | (more or {})


def run(*command: object, environment: dict[str, str] | None = None, folder: Path = ROOT) -> None:
    """Runs the command in the project's folder or in `folder`; a failure ends the release."""
    line = [str(word) for word in command]
    print("release:", " ".join(line), flush=True)
    subprocess.run(line, cwd=folder, check=True, env=_environment(environment))


def output(*command: object) -> str:
    """What the command prints."""
    line = [str(word) for word in command]
    done = subprocess.run(line, cwd=ROOT, check=True, env=_environment(None), capture_output=True, text=True)
    return done.stdout.strip()
