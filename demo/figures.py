"""The figures of the page in their order: what each is, and how it is drawn from the results into axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import gearmesh
import matplotlib
import numpy as np
from gearmesh.plots import BLUE, GREEN, GREY, RED, figure, save
from matplotlib.axes import Axes

from . import scenes
from .results import Results
from .scenes import DTE, TORQUE

matplotlib.use("Agg")
UM = 1e6
TANGENTIAL = "DTE (µm, tangential)"
Draw = Callable[[Results, Axes], None]


@dataclass(frozen=True)
class Figure:
    """A figure of the page."""

    file: str
    title: str
    caption: str
    draw: Draw


FIGURES: list[Figure] = []


def on_page(file: str, title: str, caption: str) -> Callable[[Draw], Draw]:
    """Adds a figure that the function draws."""

    def add(draw: Draw) -> Draw:
        FIGURES.append(Figure(file, title, caption, draw))
        return draw

    return add


def draw_all(results: Results, folder: Path, shown: Sequence[Figure] = FIGURES) -> None:
    """Writes figures as PNG into `folder`."""
    for one in shown:
        picture, axes = figure()
        one.draw(results, axes)
        save(picture, folder / one.file)


def label(axes, x: str, y: str, **legend) -> None:
    axes.set(xlabel=x, ylabel=y)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(**legend)


@on_page(
    "ste-dte-50rpm.png", "Static and dynamic transmission error at 50 rpm",
    "Points: static solves of the tooth contact. Lines: the FMU, gear 1 turning at 50 rpm, gear 2 under "
    "100 N m on its revolute joint. At this speed they must agree.",
)  # fmt: skip
def static_against_dynamic(results: Results, axes) -> None:
    cos_phi = math.cos(results.geometry.pressure_angle)
    for kind, color in (("unmodified", GREY), ("modified", BLUE)):
        cycle, record = results.static[kind][100], results.slow[kind]
        one = scenes.cycles_of(record)[0]
        axes.plot(record["mesh.position"][one], record[DTE][one] * UM, color=color, label=f"DTE, {kind}")
        axes.plot(cycle.mesh_position, cycle.ste_loa_um / cos_phi, ".", color=color, ms=5, label=f"STE, {kind}")
    label(axes, "mesh position", "transmission error (µm, tangential)", ncols=2)


@on_page(
    "ste-over-torque.png", "Peak-to-peak of the static transmission error over the torque",
    "Static solves. The modifications are made for the loads in the green band.",
)  # fmt: skip
def peak_to_peak_over_torque(results: Results, axes) -> None:
    for kind, color in (("unmodified", GREY), ("modified", BLUE)):
        cycles = results.static[kind]
        axes.plot(list(cycles), [c.peak_to_peak_ste_loa_um for c in cycles.values()], "o-", color=color, label=kind)
    axes.axvspan(85, 130, color=GREEN, alpha=0.12, lw=0)
    axes.set_ylim(bottom=0)
    label(axes, "torque on gear 1 (N m)", "STE peak-to-peak (µm, line of action)")


@on_page(
    "resonance.png", "Run-up through the resonance and back",
    "Half of the peak-to-peak transmission error over windows of 5 ms. Unmodified pair with 80 µm of backlash, both gears free "
    "with 4e-3 kg m² each, 100 N m, damping ratio 0.03. Where the mesh frequency meets the natural frequency the teeth part, "
    "which softens the mesh: up and down differ. The peaks at lower speeds are the harmonics of the mesh frequency. One call: "
    'gearmesh.run_up(fmu, (4e-3, 4e-3), 0.03, 100.0, (2500.0, 12000.0), sweep_s=0.6, parameters={"backlash": 80e-6}).',
)  # fmt: skip
def resonance(results: Results, axes) -> None:
    gearmesh.plot_run_up(results.resonance, axes=axes, window_s=5e-3)


@on_page(
    "resonance-orders.png", "Mesh orders in the run-up",
    "Angular acceleration of gear 2 at once, twice and three times the mesh frequency (gearmesh.orders).",
)  # fmt: skip
def resonance_orders(results: Results, axes) -> None:
    signal = "acceleration_gear2_rad_per_s2"
    found = gearmesh.orders(results.resonance.up, signal, [20, 40, 60], revolutions=1.0)
    gearmesh.plot_orders(found, axes, reference=1.0)


@on_page(
    "resonance-campbell.png", "Spectra in the run-up",
    "The same signal over frequency and speed (gearmesh.campbell): orders are lines through the origin.",
)  # fmt: skip
def resonance_campbell(results: Results, axes) -> None:
    found = gearmesh.campbell(results.resonance.up, "acceleration_gear2_rad_per_s2", window_s=0.02)
    gearmesh.plot_campbell(found, axes, reference=1.0)
    axes.set_ylim(0.0, 15.0)


@on_page(
    "fig19-torque-ramp.png", "Torque from 70 to 130 N m (Fig. 19)",
    "Modified pair at 50 rpm. With constant load the stiffness is the secant at 100 N m, so the cycles "
    "only scale; with variable load they change their shape.",
)  # fmt: skip
def torque_ramp(results: Results, axes) -> None:
    torque = np.linspace(70.0, 130.0, len(results.torque_ramp["variable"].time_s))
    for kind, color in (("constant", GREY), ("variable", BLUE)):
        axes.plot(torque, results.torque_ramp[kind][DTE] * UM, color=color, lw=1.0, label=f"{kind} load")
    label(axes, "torque (N m)", TANGENTIAL)


@on_page(
    "fig19-cycles.png", "Mesh cycles at 70, 100 and 130 N m (Fig. 19)",
    "The same pair under steady torques. At the nominal 100 N m both approaches must agree.",
)  # fmt: skip
def load_cycles(results: Results, axes) -> None:
    for torque, color in ((70, GREEN), (100, BLUE), (130, RED)):
        for kind, style in (("variable", "-"), ("constant", "--")):
            record = results.loads[kind][torque]
            one = scenes.cycles_of(record)[0]
            name = f"{torque} N m, {kind} load"
            axes.plot(record["mesh.position"][one], record[DTE][one] * UM, style, color=color, label=name)
    label(axes, "mesh position", TANGENTIAL, ncols=3, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 1.2))


@on_page(
    "fig22-contact-position.png", "Shift of the contact along the face (Fig. 22)",
    "Axial position of the resultant force at 100 N m while gear 2 tilts in the plane of action; dashed: mid-face.",
)  # fmt: skip
def contact_position(results: Results, axes) -> None:
    record = results.misalignment["negative"]
    axes.plot(-record["mesh.misalignment"] * 1e3, record["mesh.contactZ"] * 1e3, color=BLUE, lw=1.0)
    axes.axhline(1e3 * np.mean(results.geometry.faces[0]), color=GREY, lw=0.8, ls="--")
    label(axes, "misalignment, absolute value (mrad)", "contact position from the z = 0 face (mm)")


@on_page(
    "fig23-both-signs.png", "Misalignment of either sign (Fig. 23)",
    "Transmission error at 100 N m. With the paper's formulation the transmission error is taken in the z = 0 plane of gear 1, where "
    "a positive misalignment lets gear 2 run ahead.",
)  # fmt: skip
def both_signs(results: Results, axes) -> None:
    for kind, color in (("negative", BLUE), ("positive", RED)):
        record = results.misalignment[kind]
        axes.plot(np.abs(record["mesh.misalignment"]) * 1e3, record[DTE] * UM, color=color, lw=1.0, label=kind)
    axes.axhline(0.0, color=GREY, lw=0.8)
    label(axes, "misalignment, absolute value (mrad)", "DTE (µm, tangential, z = 0 plane)")


def over_cycles(results: Results, axes, column: str, scale: float) -> None:
    """A column over the last mesh cycle at each speed."""
    for (rpm, record), color in zip(results.steady.items(), matplotlib.colormaps["viridis"](np.linspace(0.0, 0.85, len(results.steady)))):
        last = record.cut(slice(len(record.time_s) // 2, None))
        order = np.argsort(last["mesh.position"])
        axes.plot(last["mesh.position"][order], last[column][order] * scale, color=color, label=f"{rpm} rpm")


@on_page(
    "fig15-dte.png", "Transmission error at the speeds of the paper's run-up (Fig. 15)",
    "Unmodified pair, constant load, 4.8 times critical damping as in the paper, a mesh cycle at each speed, held.",
)  # fmt: skip
def dte_over_speed(results: Results, axes) -> None:
    cycle = results.static["unmodified"][100]
    order = np.argsort(cycle.mesh_position)
    static = cycle.ste_loa_um / math.cos(results.geometry.pressure_angle)
    axes.plot(cycle.mesh_position[order], static[order], "k--", lw=1.2, label="STE")
    over_cycles(results, axes, DTE, UM)
    label(axes, "mesh position", "transmission error (µm, tangential)")


@on_page(
    "fig17-force.png", "Normal force at the speeds of the paper's run-up (Fig. 17)", "Over the nominal normal force, in the same cycles."
)
def force_over_speed(results: Results, axes) -> None:
    over_cycles(results, axes, "mesh.normalForce", 1.0 / results.geometry.normal_force(TORQUE))
    label(axes, "mesh position", "normal force / nominal")


@on_page(
    "fig16-frequency-response.png", "Frequency response (Fig. 16, Table 2)",
    "Constant stiffness of 4.35e8 N/m, c = 1e5 N s/m; an oscillating torque on gear 2, whose inertia is "
    "integrated outside the FMU.",
)  # fmt: skip
def frequency_response(results: Results, axes) -> None:
    response, fine = results.response, np.geomspace(30, 9000, 200)
    axes.semilogx(fine, scenes.linear_gain(fine, results.geometry.pitch_radii[1]), color=GREY, label="closed form")
    axes.semilogx(response.frequency, response.measured, "o", color=BLUE, ms=5, label="through the FMU")
    for rpm, color in ((200, GREEN), (3000, RED)):
        name = f"paper, Table 2, {rpm} rpm"
        axes.semilogx(scenes.PAPER_FREQUENCIES[rpm], scenes.PAPER_GAINS[rpm], "x", color=color, ms=8, label=name)
    label(axes, "frequency (Hz)", "gain, dynamic / static")
