"""`python -m scripts.docs.figures`: the figures of the pages on choosing and validation, from docs/data into docs/img."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

from .check import NUMBER

DOCS = Path(__file__).resolve().parents[2] / "docs"

plt.rcParams |= {"svg.hashsalt": "gearmesh", "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 11}


def rows(name: str) -> list[dict[str, str]]:
    with (DOCS / "data" / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def numbers(name: str, column: str, keep=lambda row: True) -> list[float]:
    """The first number of every cell of a column that has one, in rows that are comparisons."""
    found = (NUMBER.match(row[column] or "") for row in rows(name) if "largest" not in next(iter(row.values())) and keep(row))
    return [float(match[0]) for match in found if match]


def save(figure, name: str) -> None:
    (DOCS / "img").mkdir(exist_ok=True)
    figure.savefig(DOCS / "img" / f"{name}.svg", bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)


def levels() -> None:
    """Error of a dynamic run over the time of a step, by level of detail."""
    labels = {
        "constant stiffness": ("constant stiffness", (-6, 13)),
        "1-D table: mesh position": ("table over mesh position", (8, -12)),
        "2-D table: + load": ("+ load", (8, 0)),
        "3-D table: + misalignment, shuttling": ("+ misalignment, shuttling", (8, 0)),
        "4-D table: + centre distance": ("+ centre distance (default)", (8, -5)),
        "tooth pair by tooth pair": ("--teeth", (8, 0)),
        "contact at run time, coarse": ("--contact, coarse", (-118, 0)),
        "contact at run time, normal": ("--contact, normal", (-120, 0)),
    }
    figure, axis = plt.subplots(figsize=(8, 4.2))
    for row in rows("speed-accuracy/levels.csv"):
        if row["level"] not in labels:
            continue
        label, offset = labels[row["level"]]
        x, y = float(row["a step, µs"]), float(row["rms error of the DTE, µm"])
        colour = "C0" if "table" in row["level"] else "C1" if "contact" in row["level"] else "C2"
        axis.loglog(x, y, "o", ms=8, color=colour)
        axis.annotate(label, (x, y), xytext=offset, textcoords="offset points", va="center")
    axis.set(xlabel="processor time of a Runge-Kutta step, µs", ylabel="rms error of the transmission error, µm")
    axis.set(ylim=(2e-3, 6))
    axis.grid(alpha=0.3)
    save(figure, "levels")


def validation() -> None:
    """Differences from every reference, one line each."""
    reference = "finite-elements/reference.csv"
    plane = lambda row: "plane strain" in row["case"]  # noqa: E731
    stress = "root-stress/reference.csv"
    lines = [
        ("tooth compliance, plane strain", numbers("finite-elements/tooth-compliance.csv", "error %")),
        ("tooth pair stiffness, plane strain", numbers("finite-elements/pair-stiffness.csv", "error %")),
        ("mean STE, two finite-element codes", numbers("finite-elements/plane-ste.csv", "mean %")),
        ("peak-to-peak STE, the same", numbers("finite-elements/plane-ste.csv", "p-p %")),
        ("mean STE, direct contact, plane strain", numbers(reference, "mean %", plane)),
        ("mean STE, direct contact, solids", numbers(reference, "mean %", lambda row: not plane(row))),
        ("flank pressure, direct contact", numbers(reference, "flank pressure %")),
        ("root stress, largest", numbers(stress, "largest: difference, %")),
        ("root stress at the standard tangent", numbers(stress, "tangent: difference, %")),
    ]
    figure, axis = plt.subplots(figsize=(8, 4.2))
    for i, (_, values) in enumerate(lines):
        axis.plot(values, [i] * len(values), "|", ms=14, mew=1.5, color=f"C{i % 10}")
    axis.axvline(0.0, color="grey", lw=0.8)
    axis.set_yticks(range(len(lines)), [f"{name} ({len(values)})" for name, values in lines])
    axis.invert_yaxis()
    axis.set(xlabel="difference from the reference, %", xlim=(-3, 3))
    axis.grid(axis="x", alpha=0.3)
    save(figure, "validation")


def mesh() -> None:
    """Transverse section of the finite elements of one sector."""
    figure, axis = plt.subplots(figsize=(6, 6))
    for row in rows("finite-elements/mesh.csv"):
        values = [float(value) for value in row.values()]
        axis.plot([*values[::2], values[0]], [*values[1::2], values[1]], color="black", lw=0.7)
    axis.set(xlabel="x, mm", ylabel="y, mm", aspect="equal")
    save(figure, "mesh")


def builds() -> None:
    """Error of tables over the processor time of their build, by method."""
    figure, axis = plt.subplots(figsize=(8, 4.2))
    found = rows("tables/builds.csv")
    for i, pair in enumerate(dict.fromkeys(row["pair"] for row in found)):
        for method, line in (("cf25a0e", "--"), ("today", "-")):
            of = [row for row in found if (row["pair"], row["method"]) == (pair, method)]
            points = [(float(row["processor time, s"]), float(row["force, rms error, % of the nominal force"])) for row in of]
            # The first is the default grid.
            axis.loglog(*zip(*points[1:]), line, marker="o", ms=4, color=f"C{i}", label=f"{pair}, {method}")
            axis.loglog(*points[0], "o", ms=10, color=f"C{i}", mfc="none" if method != "today" else None)
    axis.set(xlabel="processor time of a build, s", ylabel="rms error of the force, % of the nominal one")
    axis.legend(fontsize=9)
    axis.grid(alpha=0.3, which="both")
    save(figure, "builds")


if __name__ == "__main__":
    levels()
    builds()
    mesh()
    validation()
