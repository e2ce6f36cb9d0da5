"""Draws the frames of the FMU: `python -m demo.frames OUT.svg`."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.fonttype"] = "none"
matplotlib.rcParams["svg.hashsalt"] = "gearmesh"

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

GEAR1, GEAR2, INK, FORCE, PLANE = "#2f6f9f", "#8a6d3b", "#222222", "#b3261e", "#4d8b4d"
# The paper's pair, transverse section, in mm.
TEETH, MODULE, PRESSURE_ANGLE = 20, 4.1052, math.radians(20.4823)
PITCH, BASE = 41.052, 41.052 * math.cos(PRESSURE_ANGLE)
TIP, ROOT, DISTANCE = 45.1575, 36.0521, 82.104


def outline(center: float, first_tooth: float) -> tuple[np.ndarray, np.ndarray]:
    """Closed outline of a gear on the x axis at `center`, a tooth centre at the angle `first_tooth`."""

    def involute(angle: float) -> float:
        return math.tan(angle) - angle

    half_pitch_tooth = math.pi / (2 * TEETH)
    radii = np.linspace(max(BASE, ROOT) * 1.0001, TIP, 12)
    half = [half_pitch_tooth + involute(PRESSURE_ANGLE) - involute(math.acos(BASE / r)) for r in radii]
    points = []
    for tooth in range(TEETH):
        middle = first_tooth + 2 * math.pi * tooth / TEETH
        points += [(ROOT, middle - half[0] * 1.06)]
        points += [(r, middle - h) for r, h in zip(radii, half)]
        points += [(r, middle + h) for r, h in zip(radii[::-1], half[::-1])]
        points += [(ROOT, middle + half[0] * 1.06)]
    points.append(points[0])
    r, angle = np.array(points).T
    return center + r * np.cos(angle), r * np.sin(angle)


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


def transverse(axes) -> None:
    """Seen against +z, the z axis coming out of the paper."""
    quarter = math.pi / (2 * TEETH)  # so that the flanks touch at the pitch point
    for center, tooth, color in ((0.0, -quarter, GEAR1), (DISTANCE, math.pi - quarter, GEAR2)):
        axes.fill(*outline(center, tooth), facecolor=color, alpha=0.18, edgecolor=color, lw=1.0)
        axes.add_patch(plt.Circle((center, 0), PITCH, fill=False, color=color, lw=0.8, ls="-."))
        axes.add_patch(plt.Circle((center, 0), 15.0, facecolor="white", edgecolor=color, lw=1.0))
        axes.add_patch(plt.Circle((center, 0), 1.4, fill=False, color=INK, lw=1.2))
        axes.plot(center, 0, ".", color=INK, ms=3)
        arrow(axes, (center, 0), (center + 13, 0), INK)
        arrow(axes, (center, 0), (center, 13), INK)
        axes.text(center + 11.5, -4.5, "x", color=INK, fontsize=11, style="italic")
        axes.text(center - 4.5, 11, "y", color=INK, fontsize=11, style="italic")
        axes.text(center - 5.0, -5.5, "z", color=INK, fontsize=11, style="italic")
    turn(axes, 0.0, 24.0, 40, 100, GEAR1)
    axes.text(-4.5, 27, "+ spin, angles[3]", color=GEAR1, fontsize=10, ha="right")
    turn(axes, DISTANCE, 24.0, 40, 100, GEAR2)
    axes.text(DISTANCE + 19, 21, "+ spin", color=GEAR2, fontsize=10)
    axes.text(0, -30, "gear1\norigin at (0, 0, 0)", color=GEAR1, ha="center", va="center", fontsize=10)
    axes.text(DISTANCE, -30, "gear2\norigin at (C, 0, 0)", color=GEAR2, ha="center", va="center", fontsize=10)

    direction = np.array([math.sin(PRESSURE_ANGLE), math.cos(PRESSURE_ANGLE)])
    pitch_point = np.array([PITCH, 0.0])
    low, high = pitch_point - 34 * direction, pitch_point + 52 * direction
    axes.plot([low[0], high[0]], [low[1], high[1]], color=PLANE, lw=1.1, ls="--")
    axes.text(*(low + (2.0, -3.5)), "line of action", color=PLANE, fontsize=10)
    axes.plot(*pitch_point, "o", color=FORCE, ms=4)
    arrow(axes, pitch_point, pitch_point + 30 * direction, FORCE, 2.4)
    arrow(axes, pitch_point, pitch_point - 24 * direction, FORCE, 2.4)
    axes.text(*(pitch_point + 31 * direction + (2.0, -1)), "gear2.force", color=FORCE, fontsize=10.5)
    axes.text(*(pitch_point - 24 * direction + (-2.0, 0)), "gear1.force", color=FORCE, fontsize=10.5, ha="right")
    axes.annotate(
        "contact.point",
        xy=pitch_point,
        xytext=(PITCH + 9, -45),
        color=FORCE,
        fontsize=10,
        arrowprops={"arrowstyle": "-", "color": FORCE, "lw": 0.7},
    )
    axes.set_title("Transverse plane, seen against +z (drive flank loaded)", fontsize=11)
    axes.set_xlim(-50, DISTANCE + 50)
    axes.set_ylim(-52, 54)


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


def main(path: Path) -> None:
    """Writes the drawing to `path`."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(12.5, 5.6), width_ratios=[1.45, 1])
    transverse(left)
    side(right)
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.axis("off")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
