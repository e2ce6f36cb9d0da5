"""Drives a packed gearmesh unit (FMI 2.0) from Python with preallocated arrays.

    from gearmesh import GearPair

    with GearPair("pair.fmu", {"interpolation": "shepard", "damping": 500.0}) as pair:
        pair.initialize()
        pair["gear2.angles[3]"] = 1e-4
        pair.step(5e-7)
        moment = pair["gear2.moment[3]"]

The command `gearmesh` makes the unit from a drawing: `gearmesh build PAIR.json -o pair.fmu`.
"""

from .pair import GearPair, GearPairError

__version__ = "0.1.0"
__all__ = ["GearPair", "GearPairError"]
