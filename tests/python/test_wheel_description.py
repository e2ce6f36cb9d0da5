"""What the wheel says about itself holds where there is nothing but the wheel."""

import os
import re
import subprocess
import sys
from textwrap import dedent

from conftest import GEARMESH
from scripts.release.wheel import description


def test_the_description_names_nothing_that_the_wheel_does_not_hold():
    text = description()
    assert not re.findall(r"\]\((?!https://)", text)
    for place in ("docs/", "resources/", "demo/", "examples/", ".venv", "make ", ".md"):
        assert place not in text, place


def test_the_commands_and_the_script_of_the_description_run(tmp_path):
    text = description()
    (commands,) = re.findall(r"```sh\n(.*?)```", text, re.S)
    path = f"{GEARMESH.parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "XDG_CACHE_HOME": str(tmp_path)}
    subprocess.run(["sh", "-e", "-c", commands], cwd=tmp_path, env=environment, check=True, stdout=subprocess.DEVNULL)
    (script,) = re.findall(r"^    from gearmesh.*?(?=^\S)", text, re.S | re.M)
    subprocess.run([sys.executable, "-c", dedent(script)], cwd=tmp_path, check=True)
