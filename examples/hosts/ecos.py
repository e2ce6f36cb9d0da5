"""ecospy, whose library needs oneTBB: that of the Python package `tbb`, loaded ahead, so that the system need have none."""

import ctypes
from importlib.metadata import files

for _file in files("tbb") or ():
    if _file.name == "libtbb.so.12":
        ctypes.CDLL(str(_file.locate().resolve()), ctypes.RTLD_GLOBAL)

from ecospy import EcosLib, EcosSimulation  # noqa: E402

__all__ = ["EcosLib", "EcosSimulation"]
