"""ecospy, whose library needs oneTBB and the command unzip: that of the Python package `tbb`, loaded ahead, and one that calls
Python's zipfile where the system has none."""

import ctypes
import os
from importlib.metadata import files
from pathlib import Path

os.environ["PATH"] += f"{os.pathsep}{Path(__file__).resolve().parent / 'without_unzip'}"

for _file in files("tbb") or ():
    if _file.name == "libtbb.so.12":
        ctypes.CDLL(str(_file.locate().resolve()), ctypes.RTLD_GLOBAL)

from ecospy import EcosLib, EcosSimulation  # noqa: E402

__all__ = ["EcosLib", "EcosSimulation"]
