"""The paper's numbers beside ours, as rows of a table."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import figures, scenes
from .results import Results
from .scenes import DTE, TORQUE

UM = 1e6
# Tangential, Table 2, N/m.
PAPER_STIFFNESS = (4.3e8, 4.47e8)


class Row(NamedTuple):
    """One compared quantity."""

    quantity: str
    paper: str
    ours: str
    reason: str


SAME = "No difference in kind."


def verdict(claims: dict[str, bool]) -> str:
    """What the numbers of this run say of the paper's claims."""
    missing = [claim for claim, holds in claims.items() if not holds]
    return SAME if not missing else "Not so here: " + "; ".join(missing) + "."


def static_rows(results: Results) -> Iterator[Row]:
    """Geometry and static solves."""
    modified, unmodified = results.static["modified"], results.static["unmodified"]
    force = results.slow["modified"]["mesh.normalForce"]
    yield Row(
        "normal force at 100 N m (section 6)", "2726 N",
        f"{results.geometry.normal_force(TORQUE):.1f} N; FMU at 50 rpm, mean over the cycles {force.mean():.1f} N",
        "T / (r_b cos beta_b) from Table 1 gives 2660.4 N; no combination of the printed data gives 2726 N.",
    )  # fmt: skip
    for kind, cycles, paper, reason in (
        ("unmodified", unmodified, "2 µm", "Read off a figure by the paper; hub and basic rack behind its tables are not published."),
        ("modified", modified, "0.2 µm", "As above; small differences of large numbers, so it depends most on the compliance model."),
    ):
        yield Row(f"STE peak-to-peak, {kind}, 100 N m", paper, f"{cycles[100].peak_to_peak_ste_loa_um:.2f} µm (line of action)", reason)
    best = min(modified, key=lambda torque: modified[torque].peak_to_peak_ste_loa_um)
    share = modified[best].peak_to_peak_ste_loa_um / unmodified[best].peak_to_peak_ste_loa_um
    yield Row(
        "torque of the smallest peak-to-peak, modified", "100 N m (design load)",
        f"{best} N m, there {100 * share:.0f} % of the unmodified pair's", "Of the torques solved; see the figure over the torque.",
    )  # fmt: skip
    yield Row(
        "mean STE, unmodified, 100 N m", "5.1 to 5.4 µm, from k = 4.3 to 4.47e8 N/m of Table 2",
        f"{unmodified[100].mean_ste_loa_um:.2f} µm (line of action); modified {modified[100].mean_ste_loa_um:.2f} µm, which "
        "contains the microgeometry",
        "Depends on the radius at which the gear bodies are held (bore 30 mm here); the paper names none.",
    )  # fmt: skip
    means = ", ".join(f"{modified[t].mean_ste_loa_um:.2f}" for t in (70, 100, 130))
    spans = ", ".join(f"{modified[t].peak_to_peak_ste_loa_um:.2f}" for t in (70, 100, 130))
    ours = f"mean {means} µm; p-p {spans} µm"
    yield Row("STE at 70, 100, 130 N m (Fig. 19)", "p-p grows on both sides of 100 N m", ours, "Each from its own solve, not scaled.")


def load_row(results: Results) -> Row:
    """Constant load scales the cycles, variable load changes them."""

    def share(kind: str, torque: int) -> float:
        record = results.loads[kind][torque]
        one = scenes.cycles_of(record)[0]
        return np.ptp(record[DTE][one]) / record[DTE][one].mean()

    constant, variable = ([share(kind, t) for t in (70, 100, 130)] for kind in ("constant", "variable"))
    words = [", ".join(f"{100 * s:.1f}" for s in shares) for shares in (constant, variable)]
    claims = {
        "constant load scales the cycles (to 1 %)": max(constant) < 1.01 * min(constant),
        "variable load changes their shape (by a fifth and more)": max(variable) > 1.2 * min(variable),
        "both agree at 100 N m (to 2 %)": abs(variable[1] / constant[1] - 1) < 0.02,
    }
    return Row(
        "p-p over mean of the DTE cycles at 70, 100, 130 N m (Fig. 19)", "constant load: scaled by load; variable load: another shape",
        f"constant: {words[0]} %; variable: {words[1]} %", verdict(claims),
    )  # fmt: skip


def misalignment_rows(results: Results) -> Iterator[Row]:
    """Sign of the mean DTE and position of the contact."""
    middle = 1e3 * np.mean(results.geometry.faces[0])
    for kind, end, sign in (("negative", "-3", "rises"), ("positive", "+3", "becomes negative")):
        record = results.misalignment[kind]
        angle, mean, span = scenes.per_cycle(record, DTE, record["mesh.misalignment"])
        moved = mean[-1] > mean[0] if kind == "negative" else mean[-1] < 0.0
        reason = verdict({f"the mean {sign}": moved, "the p-p grows": span[-1] > span[0]})
        if kind == "positive":
            offset = 1e-3 * middle * abs(angle[-1]) / math.cos(results.geometry.pressure_angle)
            reason += f" Between z = 0 and mid-face lie M b / (2 cos phi) = {offset * UM:.1f} µm."
        ours = f"{mean[0] * UM:.2f} µm to {mean[-1] * UM:.2f} µm at {1e3 * angle[-1]:.2f} mrad; p-p {span[0] * UM:.2f} to {span[-1] * UM:.2f} µm"
        yield Row(f"mean DTE over 0 to {end} mrad (Fig. 21, 23)", f"{sign}; p-p grows", ours, reason)
    record = results.misalignment["negative"]
    angle, position, _ = scenes.per_cycle(record, "mesh.contactZ", record["mesh.misalignment"])
    order = np.argsort(position)
    at_ten = 1e3 * np.interp(10e-3, position[order], -angle[order])
    yield Row(
        "mean contact position at -3 mrad (Fig. 22)", "about 10 mm",
        f"{1e3 * position[0]:.2f} mm at {1e3 * angle[0]:.2f} mrad (mid-face {middle:.1f} mm), "
        f"{1e3 * position[-1]:.2f} mm at {1e3 * angle[-1]:.2f} mrad; 10 mm is reached at {at_ten:.2f} mrad",
        "With 4.5 µm of crowning, 10 mm and the negative DTE of Fig. 23 cannot both hold at 3 mrad: "
        f"{abs(middle - 10.0):.1f} mm off the middle is what {at_ten:.2f} mrad do.",
    )  # fmt: skip


def stiffness_beside_table_2(results: Results) -> str:
    """Mean tangential secant stiffness at 100 N m against that of the paper's Table 2, and what it does to the gains."""
    force, cos_phi = TORQUE / results.geometry.pitch_radii[0], math.cos(results.geometry.pressure_angle)
    ours = UM * force * cos_phi / results.static["unmodified"][100].mean_ste_loa_um
    place, changes = ("below", "lowers") if ours < np.mean(PAPER_STIFFNESS) else ("above", "raises")
    return (
        f"The mean stiffness of our unmodified pair is {ours:.2e} N/m, {place} the mean of Table 2 (see mean STE), which {changes} the gains; "
        "and it varies over the cycle, which the linear gains leave out."
    )


def force_verdict(ranges: dict[int, tuple[float, float]]) -> str:
    """Whether the force over nominal swings more at each higher speed, and to which side further."""
    swings = [ranges[rpm][1] - ranges[rpm][0] for rpm in sorted(ranges)]
    grows = verdict({"the oscillation grows with speed": swings == sorted(swings)})
    least, most = ranges[max(ranges)]
    side = "below" if 1 - least > most - 1 else "above"
    return f"{grows} At {max(ranges)} rpm it goes further {side} the nominal force. The paper prints no numbers."


def dynamic_rows(results: Results) -> Iterator[Row]:
    """Run-up and frequency response."""
    cycle = results.static["unmodified"][100]
    order = np.argsort(cycle.mesh_position)
    static = cycle.ste_loa_um[order] / math.cos(results.geometry.pressure_angle) / UM
    static_harmonics = 2 / len(static) * np.abs(np.fft.rfft(static)[1:6])
    response = results.response
    for rpm in (200, 3000):
        gains = scenes.PAPER_GAINS[rpm]
        paper = ", ".join(f"{g:.2f}" for g in gains)
        measured = [response.measured[np.argmin(np.abs(response.frequency - f))] for f in scenes.PAPER_FREQUENCIES[rpm]]
        worst = max(abs(a - b) for a, b in zip(gains, measured))
        yield Row(
            f"gains at {rpm} rpm, harmonics 1 to 5 (Table 2)", paper,
            ", ".join(f"{g:.3f}" for g in measured) + f" (largest difference {worst:.3f})",
            "Constant stiffness 4.35e8 N/m, c = 1e5 N s/m, 4.213e-4 kg m² integrated outside the FMU.",
        )  # fmt: skip
        dynamic = scenes.cycle_harmonics(results.steady[rpm], DTE, cycles=2)
        ours = ", ".join(f"{g:.2f}" for g in dynamic / static_harmonics)
        yield Row(f"DTE over STE harmonics at {rpm} rpm, varying stiffness (Fig. 15)", paper, ours, stiffness_beside_table_2(results))
    nominal = results.geometry.normal_force(TORQUE)
    forces = {rpm: record["mesh.normalForce"] / nominal for rpm, record in results.steady.items()}
    ranges = {rpm: (force.min(), force.max()) for rpm, force in forces.items()}
    yield Row(
        "normal force over nominal at constant speed (Fig. 17)", "oscillation grows with speed, unloading first",
        "; ".join(f"{rpm} rpm {low:.3f} to {high:.3f}" for rpm, (low, high) in ranges.items()), force_verdict(ranges),
    )  # fmt: skip


def rows(results: Results) -> list[Row]:
    """All rows in the order of the paper."""
    return [*static_rows(results), load_row(results), *misalignment_rows(results), *dynamic_rows(results)]


def write_docs(results: Results, docs: Path) -> None:
    """Writes data/paper.csv into the folder of the pages, and the pictures that paper-comparison.md shows."""
    with (docs / "data" / "paper.csv").open("w", encoding="utf-8", newline="") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(["quantity", "paper", "gearmesh", "reason for the difference"])
        lines.writerows(rows(results))
    shown = [figure for figure in figures.FIGURES if (docs / "paper-comparison" / figure.file).exists()]
    figures.draw_all(results, docs / "paper-comparison", shown)
