"""exudyn on a system without a display: its compiled module asks for OpenGL and X11 when it is loaded, window or no window.

    .venv/bin/python scripts/without_display.py

Where the system has these libraries nothing is done. Elsewhere ones of their names are compiled beside exudyn's own, with the
functions that its modules name; each of them ends the program with the remedy. The simulations open no window and call none.
"""

import ctypes
import importlib.util
import re
import subprocess
import sys
from pathlib import Path

# Name of the library, of its functions, and the package of Debian.
LIBRARIES = [("libGL.so.1", r"glX?[A-Z]\w*", "libgl1"), ("libX11.so.6", r"X[a-zA-Z]\w*", "libx11-6")]

SOURCE = """
#include <stdio.h>
#include <stdlib.h>
static void missing(const char *name)
{{
    fprintf(stderr, "%s: this system has no {library}: install it (Debian: apt install {package}) and remove {target}\\n", name);
    abort();
}}
{functions}
"""


def is_there(library):
    """Whether the system has it."""
    try:
        ctypes.CDLL(library)
        return True
    except OSError:
        return False


def main():
    missing = [library for library in LIBRARIES if not is_there(library[0])]
    if not missing:
        return 0
    found = importlib.util.find_spec("exudyn")
    if found is None:
        print("without_display: exudyn is not installed: make .venv/.examples-complete", file=sys.stderr)
        return 1
    package = Path(found.origin).parent
    beside = package.parent / "exudyn.libs"
    modules = [*sorted(package.glob("exudynCPP*.so")), *sorted(beside.glob("libglfw*"))]
    wanted = subprocess.run(["nm", "-D", "--undefined-only", *modules], capture_output=True, text=True, check=True).stdout
    for library, functions, debian in missing:
        target = beside / library
        names = sorted(set(re.findall(rf" U ({functions})$", wanted, re.MULTILINE)))
        source = SOURCE.format(
            library=library, package=debian, target=target,
            functions="\n".join(f'void {name}(void) {{ missing("{name}"); }}' for name in names),
        )  # fmt: skip
        options = ["-shared", "-fPIC", f"-Wl,-soname,{library}", "-x", "c", "-", "-o", str(target)]
        subprocess.run(["gcc", *options], input=source, text=True, check=True)
    return 0


if __name__ == "__main__":
    if sys.argv[1:]:
        raise SystemExit(__doc__)
    raise SystemExit(main())
