"""Archives unpacked once for all their instances, which then share library and tables in memory."""

from __future__ import annotations

import shutil
import threading
from pathlib import Path
from typing import Any

import fmpy

_LOCK = threading.Lock()
_UNPACKED: dict[tuple[Path, int, int], Unpacked] = {}


class Unpacked:
    """Folder and model description of an archive while instances of it live."""

    def __init__(self, key: tuple[Path, int, int]) -> None:
        self._key = key
        self._users = 0
        self.folder: str = fmpy.extract(str(key[0]))
        try:
            self.description: Any = fmpy.read_model_description(self.folder)
        except BaseException:
            shutil.rmtree(self.folder, ignore_errors=True)
            raise

    @staticmethod
    def of(fmu: str | Path) -> Unpacked:
        """The archive as it is now: one that was written anew is another one."""
        path = Path(fmu).resolve()
        status = path.stat()
        key = (path, status.st_mtime_ns, status.st_size)
        with _LOCK:
            if key not in _UNPACKED:
                _UNPACKED[key] = Unpacked(key)
            _UNPACKED[key]._users += 1
            return _UNPACKED[key]

    def release(self) -> None:
        """Removes the folder after its last user."""
        with _LOCK:
            self._users -= 1
            if self._users == 0:
                del _UNPACKED[self._key]
                shutil.rmtree(self.folder, ignore_errors=True)
