"""Steps an FMU at every level of detail in another floating-point mode than the usual one: `floats.py FMU traps|upward|usual`.

Prints a digest of all outputs. Divisions by zero, overflows and operations without a value end the process where traps are on.
"""

import ctypes
import hashlib
import itertools
import random
import sys

from gearmesh import GearPair, GearPairError

INVALID, DIVIDED_BY_ZERO, OVERFLOW, UPWARD = 1, 4, 8, 0x800  # fenv.h of x86-64
LEVELS = [
    *({"stiffnessModel": "table", "interpolation": kind} for kind in ("linear", "spline", "shepard")),
    {"stiffnessModel": "constant"},
    {"stiffnessModel": "teeth"},
    {"stiffnessModel": "contact"},
    {"stiffnessModel": "contact", "friction": True, "rootStress": True},
]


def main(fmu: str, mode: str) -> None:
    libm, digest = ctypes.CDLL("libm.so.6"), hashlib.sha256()
    if mode == "traps":
        libm.feenableexcept(INVALID | DIVIDED_BY_ZERO | OVERFLOW)
    for level, formulation in itertools.product(LEVELS, ("conjugate", "paper")):
        source = random.Random(1)
        with GearPair(fmu, level | {"formulation": formulation}) as pair:
            pair.initialize()
            start, at = list(pair.u), pair.input
            for n in range(40):
                pair.u[:] = start
                pair.u[at["gear1.angles[3]"]] = 0.02 * n + source.choice([0.0, 1e-4, -1e-4, 3e-4, -2e-3, 0.05])
                pair.u[at["gear2.angles[3]"]] = -0.02 * n
                pair.u[at["gear2.angles[1]"]] = source.choice([0.0, 1e-3, -1e-3])
                pair.u[at["gear2.position[1]"]] += source.choice([0.0, 5e-5, 5e-3])
                pair.u[at["gear1.angularVelocity[3]"]] = source.choice([0.0, 100.0])
                libm.fesetround(UPWARD if mode == "upward" else 0)
                try:
                    pair.step(1e-6)
                except GearPairError as error:
                    digest.update(str(error).encode())
                finally:
                    libm.fesetround(0)
                digest.update(bytes(pair.y))
    libm.fedisableexcept(INVALID | DIVIDED_BY_ZERO | OVERFLOW)
    print(digest.hexdigest())


if __name__ == "__main__":
    main(*sys.argv[1:])
