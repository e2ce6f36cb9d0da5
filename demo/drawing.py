"""What the demo needs to know of a pair file: transverse geometry in closed form, SI."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Drawing:
    """An external pair. Angles in rad, lengths in m, torque on gear 1 in N m."""

    teeth: tuple[int, int]
    base_radii: tuple[float, float]
    base_helix_angle: float
    center_distance: float
    face_width: float
    nominal_torque: float

    @classmethod
    def read(cls, path: str | Path) -> Drawing:
        """Reads a pair file whose gears are both external and whose centre distance is given."""
        pair = json.loads(Path(path).read_text(encoding="utf-8"))
        if pair.get("meshing", "external") != "external":
            raise ValueError(f"{path}: the demo draws external pairs only")
        module = pair["normal_module_mm"] * 1e-3
        helix = math.radians(pair["helix_angle_deg"])
        pressure = math.atan(math.tan(math.radians(pair["normal_pressure_angle_deg"])) / math.cos(helix))
        teeth = tuple(pair[gear]["teeth"] for gear in ("gear1", "gear2"))
        return cls(
            teeth=teeth,
            base_radii=tuple(0.5 * z * module / math.cos(helix) * math.cos(pressure) for z in teeth),
            base_helix_angle=math.atan(math.tan(helix) * math.cos(pressure)),
            center_distance=pair["center_distance_mm"] * 1e-3,
            face_width=min(pair[gear]["face_width_mm"] for gear in ("gear1", "gear2")) * 1e-3,
            nominal_torque=pair["operating"]["nominal_torque_nm"],
        )

    @property
    def pressure_angle(self) -> float:
        """Operating transverse pressure angle."""
        return math.acos(sum(self.base_radii) / self.center_distance)

    @property
    def pitch_radii(self) -> tuple[float, float]:
        """Operating pitch radii."""
        return tuple(self.center_distance * z / sum(self.teeth) for z in self.teeth)

    @property
    def nominal_normal_force(self) -> float:
        """Force normal to the flank at the nominal torque, N."""
        return self.nominal_torque / self.base_radii[0] / math.cos(self.base_helix_angle)

    def tilt_of_gear2(self, misalignment: float) -> tuple[float, float]:
        """First two Cardan angles of gear 2 that put `misalignment` (rad) in the plane of action.

        The unit line of action of the force on gear 2, drive flank, gear 2 at (C, 0, 0), is
        n = (sin phi, cos phi, 0), and M = n . (a1 - a2) with the axis
        a2 = Rx(alpha) Ry(beta) z = (sin beta, -sin alpha cos beta, ...). Tilting along n alone leaves
        the axis parallel in the plane normal to it.
        """
        phi = self.pressure_angle
        beta = math.asin(-misalignment * math.sin(phi))
        alpha = math.asin(misalignment * math.cos(phi) / math.cos(beta))
        return alpha, beta
