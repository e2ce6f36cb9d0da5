"""Archives unpacked once for all their instances, which then share library and tables in memory."""

from __future__ import annotations

import json
import shutil
import threading
import weakref
from pathlib import Path
from typing import Any

import fmpy

from .geometry import Geometry

_LOCK = threading.Lock()
_UNPACKED: weakref.WeakValueDictionary[tuple[Path, int, int], Unpacked] = weakref.WeakValueDictionary()


class Unpacked:
    """Folder and model description of an archive; the folder goes with the last reference."""

    def __init__(self, file: Path) -> None:
        self.folder: str = fmpy.extract(str(file))
        weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
        self.description: Any = fmpy.read_model_description(self.folder)
        unit = json.loads(Path(self.folder, "resources", "unit.json").read_text(encoding="utf-8"))
        self.geometry = Geometry.of_unit(unit["geometry"])

    @staticmethod
    def of(fmu: str | Path) -> Unpacked:
        """The archive as it is now: one that was written anew is another one."""
        path = Path(fmu).resolve()
        status = path.stat()
        key = (path, status.st_mtime_ns, status.st_size)
        with _LOCK:
            unpacked = _UNPACKED.get(key)
            if unpacked is None:
                unpacked = _UNPACKED[key] = Unpacked(path)
            return unpacked
