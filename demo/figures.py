"""One function per figure; each takes the results and a file to write."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from . import scenes  # noqa: E402
from .results import SPEEDS, Results  # noqa: E402

UM = 1e6
BLUE, RED, GREEN, GREY = "#2f6f9f", "#b3261e", "#4d8b4d", "#777777"
DTE = "mesh.transmissionError"

plt.rcParams.update(
    {
        "figure.figsize": (7.2, 4.2),
        "figure.dpi": 110,
        "axes.grid": True,
        "grid.alpha": 0.3,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "font.size": 10,
    }
)


def static_against_dynamic(results: Results, axes) -> None:
    """STE of the solver against DTE of the FMU at 50 rpm, on the pitch circle."""
    cos_phi = math.cos(results.drawing.pressure_angle)
    for kind, color in (("unmodified", GREY), ("modified", BLUE)):
        cycle, record = results.static[kind][100], results.slow[kind]
        one = scenes.cycles_of(record)[0]
        axes.plot(record["mesh.position"][one], record[DTE][one] * UM, color=color, label=f"DTE, {kind}")
        axes.plot(cycle.mesh_position, cycle.ste / cos_phi * UM, ".", color=color, ms=5, label=f"STE, {kind}")
    axes.set_xlabel("mesh position")
    axes.set_ylabel("transmission error (µm, tangential)")
    axes.legend(ncols=2)


def peak_to_peak_over_torque(results: Results, axes) -> None:
    """STE peak-to-peak of both pairs."""
    for kind, color in (("unmodified", GREY), ("modified", BLUE)):
        cycles = results.static[kind]
        axes.plot(list(cycles), [c.peak_to_peak * UM for c in cycles.values()], "o-", color=color, label=kind)
    axes.axvspan(85, 130, color=GREEN, alpha=0.12, lw=0)
    axes.set_xlabel("torque on gear 1 (N m)")
    axes.set_ylabel("STE peak-to-peak (µm, line of action)")
    axes.set_ylim(bottom=0)
    axes.legend()


def torque_ramp(results: Results, axes) -> None:
    """Fig. 19: DTE while the torque rises from 70 to 130 N m."""
    torque = np.linspace(70.0, 130.0, len(results.torque_ramp["variable"].time))
    for kind, color in (("constant", GREY), ("variable", BLUE)):
        axes.plot(torque, results.torque_ramp[kind][DTE] * UM, color=color, lw=1.0, label=f"{kind} load")
    axes.set_xlabel("torque (N m)")
    axes.set_ylabel("DTE (µm, tangential)")
    axes.legend()


def load_cycles(results: Results, axes) -> None:
    """Fig. 19, single cycles: shape changes with variable load, scales with constant load."""
    for torque, color in ((70, GREEN), (100, BLUE), (130, RED)):
        for kind, style in (("variable", "-"), ("constant", "--")):
            record = results.loads[kind][torque]
            one = scenes.cycles_of(record)[0]
            axes.plot(
                record["mesh.position"][one],
                record[DTE][one] * UM,
                style,
                color=color,
                label=f"{torque} N m, {kind} load",
            )
    axes.set_xlabel("mesh position")
    axes.set_ylabel("DTE (µm, tangential)")
    axes.legend(ncols=3, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 1.2))


def misalignment(results: Results, axes) -> None:
    """Fig. 21: DTE from 0 to -3 mrad."""
    record = results.misalignment["negative"]
    axes.plot(-record["mesh.misalignment"] * 1e3, record[DTE] * UM, color=BLUE, lw=1.0)
    axes.set_xlabel("misalignment, absolute value (mrad)")
    axes.set_ylabel("DTE (µm, tangential)")


def contact_position(results: Results, axes) -> None:
    """Fig. 22: axial position of the resultant from 0 to -3 mrad."""
    record = results.misalignment["negative"]
    axes.plot(-record["mesh.misalignment"] * 1e3, record["mesh.contactZ"] * 1e3, color=BLUE, lw=1.0)
    axes.axhline(results.drawing.face_width * 500.0, color=GREY, lw=0.8, ls="--")
    axes.set_xlabel("misalignment, absolute value (mrad)")
    axes.set_ylabel("contact position from the z = 0 face (mm)")


def both_signs(results: Results, axes) -> None:
    """Fig. 23: DTE to -3 and to +3 mrad."""
    for kind, color in (("negative", BLUE), ("positive", RED)):
        record = results.misalignment[kind]
        axes.plot(np.abs(record["mesh.misalignment"]) * 1e3, record[DTE] * UM, color=color, lw=1.0, label=kind)
    axes.axhline(0.0, color=GREY, lw=0.8)
    axes.set_xlabel("misalignment, absolute value (mrad)")
    axes.set_ylabel("DTE (µm, tangential, z = 0 plane)")
    axes.legend()


def cycle_at(results: Results, rpm: float) -> slice:
    """The whole mesh cycle of the run-up whose speed is nearest to `rpm`."""
    record = results.sweep
    speed = record.time / record.time[-1] * 3000.0
    return min(scenes.cycles_of(record), key=lambda s: abs(speed[s].mean() - rpm))


def dte_in_run_up(results: Results, axes) -> None:
    """Fig. 15: DTE over a mesh cycle at several speeds of the run-up, with the STE."""
    cycle = results.static["unmodified"][100]
    cos_phi = math.cos(results.drawing.pressure_angle)
    order = np.argsort(cycle.mesh_position)
    axes.plot(cycle.mesh_position[order], cycle.ste[order] / cos_phi * UM, "k--", lw=1.2, label="STE")
    for rpm, color in zip(SPEEDS, plt.cm.viridis(np.linspace(0.0, 0.85, len(SPEEDS)))):
        one = cycle_at(results, rpm)
        record = results.sweep
        axes.plot(record["mesh.position"][one], record[DTE][one] * UM, color=color, label=f"{rpm} rpm")
    axes.set_xlabel("mesh position")
    axes.set_ylabel("transmission error (µm, tangential)")
    axes.legend()


def force_in_run_up(results: Results, axes) -> None:
    """Fig. 17: normal force over the nominal one at several speeds of the run-up."""
    record, nominal = results.sweep, results.drawing.nominal_normal_force
    for rpm, color in zip(SPEEDS, plt.cm.viridis(np.linspace(0.0, 0.85, len(SPEEDS)))):
        one = cycle_at(results, rpm)
        axes.plot(
            record["mesh.position"][one],
            record["mesh.normalForce"][one] / nominal,
            color=color,
            label=f"{rpm} rpm",
        )
    axes.set_xlabel("mesh position")
    axes.set_ylabel("normal force / nominal")
    axes.legend()


def run_up(results: Results, axes) -> None:
    """The whole run-up: DTE over the speed."""
    record = results.sweep
    axes.plot(record.time / record.time[-1] * 3000.0, record[DTE] * UM, color=BLUE, lw=0.4)
    axes.set_xlabel("speed (rpm)")
    axes.set_ylabel("DTE (µm, tangential)")


def frequency_response(results: Results, axes) -> None:
    """Fig. 16: dynamic over static transmission error, with the gains of Table 2."""
    response = results.response
    fine = np.geomspace(30, 9000, 200)
    axes.semilogx(fine, scenes.linear_gain(fine, results.drawing), color=GREY, label="closed form")
    axes.semilogx(response.frequency, response.measured, "o", color=BLUE, ms=5, label="through the FMU")
    for rpm, color in ((200, GREEN), (3000, RED)):
        axes.semilogx(
            scenes.PAPER_FREQUENCIES[rpm],
            scenes.PAPER_GAINS[rpm],
            "x",
            color=color,
            ms=8,
            label=f"paper, Table 2, {rpm} rpm",
        )
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel("gain, dynamic / static")
    axes.legend()


@dataclass(frozen=True)
class Figure:
    """A figure of the page: file name, title, caption and how to draw it."""

    file: str
    title: str
    caption: str
    draw: Callable[[Results, plt.Axes], None]


FIGURES = (
    Figure(
        "ste-dte-50rpm.png",
        "Static and dynamic transmission error at 50 rpm",
        "Points: static solves of the tooth contact. Lines: the FMU, gear 1 turning at 50 rpm, gear 2 under "
        "100 N m on its revolute joint. At this speed they must agree.",
        static_against_dynamic,
    ),
    Figure(
        "ste-over-torque.png",
        "Peak-to-peak of the static transmission error over the torque",
        "Static solves. The modifications are made for the loads in the green band.",
        peak_to_peak_over_torque,
    ),
    Figure(
        "fig19-torque-ramp.png",
        "Torque from 70 to 130 N m (Fig. 19)",
        "Modified pair at 50 rpm. With constant load the stiffness is the secant at 100 N m, so the cycles "
        "only scale; with variable load they change their shape.",
        torque_ramp,
    ),
    Figure(
        "fig19-cycles.png",
        "Mesh cycles at 70, 100 and 130 N m (Fig. 19)",
        "The same pair under steady torques. At the nominal 100 N m both approaches must agree.",
        load_cycles,
    ),
    Figure(
        "fig21-misalignment.png",
        "Misalignment from 0 to -3 mrad (Fig. 21)",
        "Transmission error at 100 N m while gear 2 tilts in the plane of action.",
        misalignment,
    ),
    Figure(
        "fig22-contact-position.png",
        "Shift of the contact along the face (Fig. 22)",
        "Axial position of the resultant force in the same run; dashed: mid-face.",
        contact_position,
    ),
    Figure(
        "fig23-both-signs.png",
        "Misalignment of either sign (Fig. 23)",
        "With the paper's formulation the transmission error is taken in the z = 0 plane of gear 1, where "
        "a positive misalignment lets gear 2 run ahead.",
        both_signs,
    ),
    Figure(
        "fig15-run-up-dte.png",
        "Transmission error in the run-up (Fig. 15)",
        "Unmodified pair, constant load, one sweep from 0 to 3000 rpm; the cycles nearest to the speeds named.",
        dte_in_run_up,
    ),
    Figure(
        "fig17-run-up-force.png",
        "Normal force in the run-up (Fig. 17)",
        "Over the nominal normal force, in the same sweep, where speeding gear 2 up takes a thousandth of the torque; "
        "the table has the force at constant speed, without that and without what the cycles before leave behind.",
        force_in_run_up,
    ),
    Figure(
        "run-up.png",
        "The whole run-up",
        "What inertia and damping leave of the cycles from 0 to 3000 rpm.",
        run_up,
    ),
    Figure(
        "fig16-frequency-response.png",
        "Frequency response (Fig. 16, Table 2)",
        "Constant stiffness of 4.35e8 N/m, c = 1e5 N s/m; an oscillating torque on gear 2, whose inertia is "
        "integrated outside the FMU.",
        frequency_response,
    ),
)


def draw_all(results: Results, folder: Path, shown: Sequence[Figure] = FIGURES) -> None:
    """Writes figures as PNG into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for figure in shown:
        picture, axes = plt.subplots()
        figure.draw(results, axes)
        picture.tight_layout()
        picture.savefig(folder / figure.file)
        plt.close(picture)
