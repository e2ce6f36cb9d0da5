"""Draws the frames of the FMU: `python -m demo.frames OUT.svg [gear1|gear2]`, with the name of the ring of an internal pair."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.fonttype"] = "none"
matplotlib.rcParams["svg.hashsalt"] = "gearmesh"

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

GEAR1, GEAR2, INK, FORCE, PLANE = "#2f6f9f", "#8a6d3b", "#222222", "#b3261e", "#4d8b4d"
# Transverse section of the paper's pair, and of its gear 1 in a ring of 36 teeth, in mm.
MODULE, PRESSURE_ANGLE = 4.1052, math.radians(20.4823)
TEETH, RING_TEETH = 20, 36
BORE = 15.0


@dataclass(frozen=True)
class Outline:
    """Closed outline of teeth (ring: spaces) about the point `center` of the x axis, one centred at the angle `first`."""

    teeth: int
    center: float
    first: float
    dedendum: float
    addendum: float

    @property
    def pitch(self) -> float:
        """Pitch radius."""
        return 0.5 * self.teeth * MODULE

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y."""

        def involute(angle: float) -> float:
            return math.tan(angle) - angle

        base, inner = self.pitch * math.cos(PRESSURE_ANGLE), self.pitch - self.dedendum
        radii = np.linspace(max(base * 1.0001, inner), self.pitch + self.addendum, 12)
        quarter = math.pi / (2 * self.teeth)
        half = [quarter + involute(PRESSURE_ANGLE) - involute(math.acos(base / r)) for r in radii]
        points = []
        for tooth in range(self.teeth):
            middle = self.first + 2 * math.pi * tooth / self.teeth
            points += [(inner, middle - half[0] * 1.06)]
            points += [(r, middle - h) for r, h in zip(radii, half)]
            points += [(r, middle + h) for r, h in zip(radii[::-1], half[::-1])]
            points += [(inner, middle + half[0] * 1.06)]
        points.append(points[0])
        r, angle = np.array(points).T
        return self.center + r * np.cos(angle), r * np.sin(angle)


def arrow(axes, start, end, color, width=1.8) -> None:
    axes.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={"arrowstyle": "-|>", "color": color, "lw": width, "shrinkA": 0, "shrinkB": 0},
    )


def turn(axes, center, radius, first_deg, last_deg, color) -> None:
    """A round arrow from one angle to another."""
    angles = np.radians(np.linspace(first_deg, last_deg, 40))
    x, y = center + radius * np.cos(angles), radius * np.sin(angles)
    axes.plot(x[:-2], y[:-2], color=color, lw=1.8)
    arrow(axes, (x[-3], y[-3]), (x[-1], y[-1]), color)


def axes_of(axes, center: float) -> None:
    """The frame of a gear at `center`, z towards the reader."""
    axes.add_patch(plt.Circle((center, 0), 1.4, fill=False, color=INK, lw=1.2))
    axes.plot(center, 0, ".", color=INK, ms=3)
    arrow(axes, (center, 0), (center + 13, 0), INK)
    arrow(axes, (center, 0), (center, 13), INK)
    axes.text(center + 11.5, -4.5, "x", color=INK, fontsize=11, style="italic")
    axes.text(center - 4.5, 11, "y", color=INK, fontsize=11, style="italic")
    axes.text(center - 5.0, -5.5, "z", color=INK, fontsize=11, style="italic")


def pitch_circle(axes, gear: Outline, color: str) -> None:
    axes.add_patch(plt.Circle((gear.center, 0), gear.pitch, fill=False, color=color, lw=0.8, ls="-."))


def solid(axes, gear: Outline, color: str) -> None:
    """An external gear with its bore."""
    axes.fill(*gear.points(), facecolor=color, alpha=0.18, edgecolor=color, lw=1.0)
    axes.add_patch(plt.Circle((gear.center, 0), BORE, facecolor="white", edgecolor=color, lw=1.0))
    pitch_circle(axes, gear, color)


def loads(axes, pitch_point: np.ndarray, direction: np.ndarray, down: float) -> None:
    """Line of action and the forces on both gears; `direction` is that of the force on gear 2."""
    low, high = pitch_point - 34 * direction, pitch_point + 52 * direction
    axes.plot([low[0], high[0]], [low[1], high[1]], color=PLANE, lw=1.1, ls="--")
    axes.text(*((low if low[1] < high[1] else high) + (2.0, -3.5)), "line of action", color=PLANE, fontsize=10)
    axes.plot(*pitch_point, "o", color=FORCE, ms=4)
    arrow(axes, pitch_point, pitch_point + 30 * direction, FORCE, 2.4)
    arrow(axes, pitch_point, pitch_point - 24 * direction, FORCE, 2.4)
    on_gear2, on_gear1 = pitch_point + 31 * direction, pitch_point - 24 * direction
    if direction[1] > 0.0:
        axes.text(*(on_gear2 + (2.0, -1)), "gear2.force", color=FORCE, fontsize=10.5)
        axes.text(*(on_gear1 + (-2.0, 0)), "gear1.force", color=FORCE, fontsize=10.5, ha="right")
    else:
        axes.text(*(on_gear2 + (-2.0, 0)), "gear2.force", color=FORCE, fontsize=10.5, ha="right")
        axes.text(*(on_gear1 + (2.0, 2.0)), "gear1.force", color=FORCE, fontsize=10.5)
    axes.annotate(
        "contact.point",
        xy=pitch_point,
        xytext=(pitch_point[0] + 9, down),
        color=FORCE,
        fontsize=10,
        arrowprops={"arrowstyle": "-", "color": FORCE, "lw": 0.7},
    )


def external(axes) -> None:
    """Seen against +z, the z axis coming out of the paper."""
    quarter = math.pi / (2 * TEETH)  # so that the flanks touch at the pitch point
    distance = TEETH * MODULE
    for center, tooth, color in ((0.0, -quarter, GEAR1), (distance, math.pi - quarter, GEAR2)):
        solid(axes, Outline(TEETH, center, tooth, 1.25 * MODULE * 0.9744, MODULE), color)
        axes_of(axes, center)
    turn(axes, 0.0, 24.0, 40, 100, GEAR1)
    axes.text(-4.5, 27, "+ spin, angles[3]", color=GEAR1, fontsize=10, ha="right")
    turn(axes, distance, 24.0, 40, 100, GEAR2)
    axes.text(distance + 19, 21, "+ spin", color=GEAR2, fontsize=10)
    axes.text(0, -30, "gear1\norigin at (0, 0, 0)", color=GEAR1, ha="center", va="center", fontsize=10)
    axes.text(distance, -30, "gear2\norigin at (C, 0, 0)", color=GEAR2, ha="center", va="center", fontsize=10)
    loads(axes, np.array([0.5 * distance, 0.0]), np.array([math.sin(PRESSURE_ANGLE), math.cos(PRESSURE_ANGLE)]), -45)
    axes.set_xlim(-50, distance + 50)
    axes.set_ylim(-52, 54)


def internal(axes, ring_is_gear1: bool) -> None:
    """The same of a pinion in a ring: the mesh lies away from the axis of the ring, beyond that of the pinion."""
    distance = 0.5 * (RING_TEETH - TEETH) * MODULE
    names = [("gear1", "origin at (0, 0, 0)", 0.0, GEAR1), ("gear2", "origin at (C, 0, 0)", distance, GEAR2)]
    (ring, ring_origin, ring_at, ring_color), (pinion, pinion_origin, pinion_at, color) = names if ring_is_gear1 else names[::-1]
    side = 1.0 if ring_is_gear1 else -1.0  # of the mesh, from either axis
    first = 0.0 if ring_is_gear1 else math.pi
    quarters = [side * math.pi / (2 * teeth) for teeth in (TEETH, RING_TEETH)]
    gear = Outline(TEETH, pinion_at, first + quarters[0], 1.25 * MODULE * 0.9744, MODULE)
    spaces = Outline(RING_TEETH, ring_at, first + quarters[1], MODULE, 1.25 * MODULE)
    rim = spaces.pitch + 16
    axes.add_patch(plt.Circle((ring_at, 0), rim, facecolor=ring_color, alpha=0.18))
    axes.add_patch(plt.Circle((ring_at, 0), rim, fill=False, edgecolor=ring_color, lw=1.0))
    axes.fill(*spaces.points(), facecolor="white", edgecolor=ring_color, lw=1.0)
    pitch_circle(axes, spaces, ring_color)
    solid(axes, gear, color)
    axes_of(axes, 0.0)
    axes_of(axes, distance)
    turn(axes, pinion_at, 24.0, 60, 120, color)
    axes.text(pinion_at, 28, "+ spin, angles[3]", color=color, fontsize=10, ha="center")
    start = 0 if side < 0 else 180
    turn(axes, ring_at, 22.0, start - 30, start + 30, ring_color)
    axes.text(ring_at - side * 23, 12, "+ spin", color=ring_color, fontsize=10, ha="left" if side < 0 else "right")
    axes.text(pinion_at + side * 3, -28, f"{pinion}\n{pinion_origin}", color=color, ha="center", va="center", fontsize=10)
    axes.text(ring_at - side * 20, -38, f"{ring}, the ring\n{ring_origin}", color=ring_color, ha="center", va="center", fontsize=10)
    pitch_point = np.array([pinion_at + side * gear.pitch, 0.0])
    loads(axes, pitch_point, np.array([-math.sin(PRESSURE_ANGLE), side * math.cos(PRESSURE_ANGLE)]), 50)
    edge, far = pinion_at + side * 70, pinion_at - side * 94
    axes.set_xlim(min(edge, far), max(edge, far))
    axes.set_ylim(-56, 62)


def side(axes) -> None:
    """The plane of action from the side: z to the right."""
    width, scale = 25.0, 2.4
    b = width * scale
    for bottom, color, name in ((-34.0, GEAR1, "gear1"), (4.0, GEAR2, "gear2")):
        axes.add_patch(plt.Rectangle((0, bottom), b, 30, facecolor=color, alpha=0.18, edgecolor=color))
        axes.text(b / 2 + 12, bottom + 24, name, color=color, ha="center", va="center", fontsize=10.5)
        arrow(axes, (0, bottom + 15), (b + 22, bottom + 15), INK)
        axes.text(b + 24, bottom + 15, "z", va="center", fontsize=11, style="italic", color=INK)
        axes.plot(0, bottom + 15, "o", color=INK, ms=4)
    axes.text(-2, 19, "origin in the\nz = 0 face", ha="right", va="center", fontsize=9.5, color=INK)
    axes.plot([0, 0], [-46, 44], color=INK, lw=0.7, ls=":")
    axes.plot([b / 2, b / 2], [-46, 44], color=PLANE, lw=1.0, ls="-.")
    axes.text(b / 2, 46, "mid-face: reference of\ntransmission error and M", color=PLANE, ha="center", va="bottom", fontsize=9.5)
    z_c = 0.68 * b
    arrow(axes, (z_c, -4), (z_c, 13), FORCE, 2.4)
    axes.text(z_c + 2, 6.5, "gear2.force", color=FORCE, fontsize=10, va="center")
    arrow(axes, (0, -42), (z_c, -42), FORCE, 1.2)
    axes.text(z_c + 2, -42, "mesh.contactZ", color=FORCE, fontsize=10, va="center")
    turn_angles = np.radians(np.linspace(-8, 8, 20))
    x, y = 82 * np.cos(turn_angles), -19 + 82 * np.sin(turn_angles)
    axes.plot(x, y, color=GEAR1, lw=1.6)
    arrow(axes, (x[-2], y[-2]), (x[-1], y[-1]), GEAR1)
    axes.text(84.5, -11, "tilt with\nM > 0", color=GEAR1, fontsize=9.5, va="center")
    axes.set_title("Plane of action from the side", fontsize=11)
    axes.set_xlim(-34, 104)
    axes.set_ylim(-52, 62)


def main(path: Path, ring: str | None = None) -> None:
    """Writes the drawing of an external pair, or of an internal one with this `ring`, to `path`."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(12.5, 5.6), width_ratios=[1.45, 1])
    if ring is None:
        external(left)
    else:
        internal(left, ring == "gear1")
    left.set_title("Transverse plane, seen against +z (drive flank loaded)", fontsize=11)
    side(right)
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.axis("off")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
