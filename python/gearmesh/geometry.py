"""Transverse geometry of a pair in closed form, from what its FMU says of it; SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Geometry:
    """A gear pair at its nominal centre distance, both axes along z.

    Attributes
    ----------
    teeth : (gear 1, gear 2)
    internal
        Whether one gear is a ring.
    center_distance : m
    base_radii, pitch_radii : m
        Of both gears; pitch radii are the operating ones.
    pressure_angle, base_helix_angle, helix_angle : rad
        Operating transverse pressure angle; helix angles at the base and at the operating pitch cylinder, > 0 where gear 1 is
        right-handed.
    faces : m
        z of both faces of each gear.
    ratio
        Turn of gear 2 per turn of gear 1: negative for external pairs.
    """

    teeth: tuple[int, int]
    internal: bool
    center_distance: float
    base_radii: tuple[float, float]
    pitch_radii: tuple[float, float]
    pressure_angle: float
    base_helix_angle: float
    helix_angle: float
    faces: tuple[tuple[float, float], tuple[float, float]]

    @classmethod
    def of_unit(cls, geometry: Mapping[str, Any]) -> Geometry:
        """From the object `geometry` of the FMU's resources/unit.json."""
        distance = geometry["center_distance"]
        # FMUs of earlier versions have the names without units.
        gears = [{name.removesuffix("_m").removesuffix("_rad"): value for name, value in gear.items()} for gear in geometry["gears"]]
        internal = any(gear["kind"] == "ring" for gear in gears)
        helix, module = gears[0]["helix_angle"], gears[0]["normal_module"]
        transverse = math.atan(math.tan(gears[0]["normal_pressure_angle"]) / math.cos(helix))
        teeth = tuple(gear["teeth"] for gear in gears)
        base = tuple(0.5 * z * module / math.cos(helix) * math.cos(transverse) for z in teeth)
        together = abs(teeth[0] - teeth[1]) if internal else sum(teeth)
        pitch = tuple(z * distance / together for z in teeth)
        pressure = math.acos(base[0] / pitch[0])
        base_helix = gears[0]["hand"] * math.atan(math.tan(helix) * math.cos(transverse))
        operating_helix = math.atan(math.tan(base_helix) * pitch[0] / base[0])
        faces = tuple((gear["face_offset"], gear["face_offset"] + gear["face_width"]) for gear in gears)
        return cls(teeth, internal, distance, base, pitch, pressure, base_helix, operating_helix, faces)

    @property
    def ratio(self) -> float:
        """Turn of gear 2 per turn of gear 1."""
        return (1.0 if self.internal else -1.0) * self.teeth[0] / self.teeth[1]

    def normal_force(self, torque: float) -> float:
        """Force normal to the flank, N, under `torque`, N m, on gear 1."""
        return torque / self.base_radii[0] / math.cos(self.base_helix_angle)

    def reduced_mass(self, inertias: tuple[float, float], radii: tuple[float, float] | None = None) -> float:
        """Mass, kg, of both gears turning against one another, at `radii` (the operating pitch radii), from inertias in kg m^2.

        An infinite inertia is a gear that turns as imposed.
        """
        inverse = sum(radius**2 / inertia for radius, inertia in zip(radii or self.pitch_radii, inertias))
        return 1.0 / inverse

    def tilt_of_gear2(self, misalignment: float) -> tuple[float, float]:
        """First two Cardan angles of gear 2, rad, that put `misalignment`, rad, in the plane of action of the drive flank.

        For an external pair with gear 2 at (C, 0, 0) the line of action is n = (sin phi, cos phi, 0), and M = n . (a1 - a2)
        with the axis a2 = Rx(alpha) Ry(beta) z = (sin beta, -sin alpha cos beta, ...). Tilting along n alone leaves the
        axes parallel in the plane normal to it.
        """
        beta = math.asin(-misalignment * math.sin(self.pressure_angle))
        alpha = math.asin(misalignment * math.cos(self.pressure_angle) / math.cos(beta))
        return alpha, beta
