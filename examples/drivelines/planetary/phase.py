"""Phase between the sun and the ring mesh of a planet in closed form, counted from several points of the mesh cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .stage import CENTER_DISTANCE, PITCH, TEETH

ALPHA_T = np.arctan(np.tan(np.radians(20.0)) / np.cos(np.radians(7.5)))
FACES = (220e-3, 227.5e-3)  # m, common to sun and planet, and to planet and ring; the middles coincide
PUBLISHED = 0.2805  # gamma_rs of the NREL GRC stage


@dataclass(frozen=True)
class Teeth:
    """What the phase depends on; SI. `shift` and `thinning` (at the operating pitch circle) are of the planets."""

    center_distance: float
    tips: tuple[float, float, float]  # radii of sun, planet, ring
    shift: float
    thinning: float = 0.0

    @property
    def pressure_angle(self) -> float:
        """Transverse, operating; of both meshes."""
        return float(np.arccos(PITCH[:2].sum() * np.cos(ALPHA_T) / self.center_distance))

    def paths(self) -> np.ndarray:
        """From the pitch point to where the tips of sun, planet and ring cut the line of action, in base pitches."""
        base = PITCH * np.cos(ALPHA_T)
        way = np.sqrt(np.square(self.tips) - base**2) - base * np.tan(self.pressure_angle)
        return np.abs(way) * TEETH / (2.0 * np.pi * base)


STANDARD = Teeth(float(PITCH[:2].sum()), tuple(PITCH + [10e-3, 10e-3, -10e-3]), 0.0)
# Tips and shift as in the pair files, backlash of 0.3 mm at each mesh.
FITTED = Teeth(CENTER_DISTANCE, (118.92e-3, 211.92e-3, 496.92e-3), 0.394235, 150e-6)


def involute(angle: float) -> float:
    return np.tan(angle) - angle


def thickness(teeth: Teeth) -> float:
    """Of a planet's tooth at the operating pitch circle, in pitches."""
    # Half of the angle times the number of teeth.
    half = np.pi / 2.0 + 2.0 * teeth.shift * np.tan(np.radians(20.0)) + TEETH[1] * (involute(ALPHA_T) - involute(teeth.pressure_angle))
    radius = teeth.center_distance * TEETH[1] / (TEETH[0] + TEETH[1])
    return float(half / np.pi - teeth.thinning * TEETH[1] / (2.0 * np.pi * radius))


def at_pitch_points(teeth: Teeth = FITTED) -> float:
    """Lag of the ring mesh behind the sun mesh, in mesh cycles, each counted from its pitch point; the ring drives.

    While one flank of the planet touches the sun at the pitch point, the opposite flanks stand so far from the
    ring's pitch point: half a turn and the tooth thickness further, in pitches. Both meshes count in the same
    transverse plane of the planet, whose place along the face does not matter.
    """
    return centred(TEETH[1] / 2.0 + thickness(teeth))


def ring_tip_for(lag: float, teeth: Teeth) -> float:
    """Tip radius of the ring, m, with which the contacts end `lag` cycles apart (ring drives), or start so (sun drives)."""
    path = lag - at_pitch_points(teeth) + teeth.paths()[1]
    base = PITCH[2] * np.cos(ALPHA_T)
    way = path * 2.0 * np.pi * base / TEETH[2]
    return float(np.hypot(base, base * np.tan(teeth.pressure_angle) - way))


def centred(phase: float) -> float:
    """The same phase from -0.5 to 0.5."""
    return (phase + 0.5) % 1.0 - 0.5


def conventions(teeth: Teeth) -> dict[str, float]:
    """The lag by the point that both meshes are counted from. Read backwards (the sun drives) a lag is a lead."""
    sun, planet, ring = teeth.paths()
    pitch = at_pitch_points(teeth)
    # Contact starts at the tip of the driven gear: driven by the ring, at the tips of sun and planet; by the sun, at
    # those of planet and ring.
    tips_of_driven, tips_of_driving = sun - planet, ring - planet
    # Both meshes start at the end of the planet that leads; the wider face starts earlier.
    corner = 0.5 * (FACES[1] - FACES[0]) * np.tan(np.radians(7.5)) * TEETH[1] / (2.0 * np.pi * PITCH[1])
    return {
        "pitch point": pitch,
        "start of contact, ring drives": centred(pitch + tips_of_driven),
        "start of contact at the corner of the faces, ring drives": centred(pitch + tips_of_driven - corner),
        "middle of the path": centred(pitch + 0.5 * (tips_of_driven + tips_of_driving)),
        "end of contact, ring drives": centred(pitch + tips_of_driving),
        "start of contact, sun drives": centred(-pitch - tips_of_driving),
        "the same, thickness of the planet's teeth left out": centred(TEETH[1] / 2.0 - tips_of_driving),
    }
