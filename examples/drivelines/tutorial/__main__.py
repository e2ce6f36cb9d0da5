"""`python -m examples.drivelines.tutorial`: every picture of docs/tutorial.md, and its figures as tutorial.csv, into target/drivelines."""

from __future__ import annotations

import shutil
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import gearmesh
import numpy as np
from gearmesh import History, MeshCycle
from gearmesh.plots import figure as new_figure

from examples.shared.files import OUT, PAIRS, built, save
from examples.shared.gearbox import SPUR, sweep
from examples.shared.tables import show

TORQUE = 150.0
ORDERS = (SPUR.teeth[0], 2 * SPUR.teeth[0])


def relieved() -> Path:
    """The pair file with the tip relief that a study finds best."""
    folder, out = OUT / "tutorial" / "relief", OUT / "spur-50-50-relieved.json"
    folder.parent.mkdir(parents=True, exist_ok=True)
    gears = [f"{gear}.tip_relief.{{0}}" for gear in ("gear1", "gear2")]
    amount, start = [",".join(gears).format(field) for field in ("amount_um", "start.diameter_mm")]
    grid = ["--vary", f"{amount}=8..20/7", "--vary", f"{start}=151..153.5/6"]
    best = ["--best", "peak_to_peak_ste_loa_um", "--restart"]
    gearmesh.command.run("study", PAIRS / "spur-50-50.json", "--torques-nm", TORQUE, *grid, *best, "-o", folder)
    text = (folder / "best.json").read_text()
    # An FMU is built again where its pair file is newer.
    if not out.exists() or out.read_text() != text:
        out.write_text(text)
    return out


def pair_files() -> dict[str, Path]:
    return {"unmodified": PAIRS / "spur-50-50.json", "with tip relief": relieved()}


def static(pair: Path, *torques: float) -> list[MeshCycle]:
    return gearmesh.solve_all(pair, torques, refinement="coarse")


def one_run(pair: Path) -> History:
    """A run-up."""
    return sweep("variable load", TORQUE, fmu=built(pair))[0]


def run_ups(pairs: dict[str, Path]) -> list[History]:
    with ProcessPoolExecutor(2) as pool:
        return list(pool.map(one_run, pairs.values()))


def order_over_speed(run: History, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Speed, rpm, from 500 on, and amplitude of an order of the wall's acceleration, m/s^2."""
    found = gearmesh.orders(run, "wall_m_per_s2", [order], revolutions=16.0 / order)
    fast = found.speed_rpm > 500.0
    return found.speed_rpm[fast], found.of(order)[fast]


def table(pairs: dict[str, Path], runs: list[History]) -> list[list[str]]:
    """Figures of the page, with as many digits."""
    cycles = [static(pair, TORQUE)[0] for pair in pairs.values()]
    lines = [
        ("STE, peak to peak (um)", 2, [cycle.peak_to_peak_ste_loa_um for cycle in cycles]),
        ("first harmonic (um)", 3, [cycle.harmonics_loa_um[0] for cycle in cycles]),
    ]
    rows = [["quantity", *pairs, "lower by (dB)"]]
    for order in ORDERS:
        curves = [order_over_speed(run, order) for run in runs]
        lines.append((f"order {order} of the wall (m/s2)", 1, [amplitude.max() for _, amplitude in curves]))
        lines.append((f"order {order} above 5000 rpm (m/s2)", 1, [amplitude[rpm > 5000.0].max() for rpm, amplitude in curves]))
        speeds = [f"{rpm[amplitude.argmax()]:.0f}" for rpm, amplitude in curves]
        rows.append([f"speed of the largest order {order} (rpm)", *speeds, ""])
    return rows + [[name, *(f"{v:.{digits}f}" for v in values), f"{decibels(values):.0f}"] for name, digits, values in lines]


def decibels(values) -> float:
    """By how much the second is below the first."""
    return float(gearmesh.decibels(values[0], values[1]))


def ste_figure(pairs: dict[str, Path]) -> None:
    figure, (left, right) = new_figure(2, 11, 4.0)
    torques = (25.0, 50.0, 100.0, TORQUE, 200.0, 250.0, 300.0)
    for name, pair in pairs.items():
        cycles = static(pair, *torques)
        error = cycles[3].ste_loa_um
        left.plot(cycles[3].mesh_position, error - error.mean(), label=name)
        right.plot(torques, [cycle.harmonics_loa_um[0] for cycle in cycles], "o-", label=name)
    left.set(xlabel="mesh cycle", ylabel=f"STE at {TORQUE:g} N m less its mean, µm")
    right.set(xlabel="torque, N m", ylabel="first harmonic, µm")
    left.legend()
    save(figure, "tutorial-ste")


def order_figure(pairs: dict[str, Path], runs: list[History]) -> None:
    figure, axis = new_figure()
    for colour, (name, run) in enumerate(zip(pairs, runs)):
        for order, style in zip(ORDERS, ("-", "--")):
            axis.semilogy(*order_over_speed(run, order), style, color=f"C{colour}", label=f"{name}, order {order}")
    axis.axhline(10.0, color="grey", lw=0.8)
    axis.set(xlabel="speed, rpm", ylabel="acceleration of the housing wall, m/s²", xlim=(500, 6000), ylim=(1e-2, 3000))
    axis.legend(loc="upper right", ncol=2, fontsize=8)
    save(figure, "tutorial-orders")


def main() -> None:
    pairs = pair_files()
    for pair in pairs.values():
        folder = OUT / "tutorial" / pair.stem
        folder.parent.mkdir(parents=True, exist_ok=True)
        gearmesh.command.run("report", pair, "-o", folder.with_suffix(".html"), "--figures", folder, "--refinement", "coarse")
        shutil.copy(folder / "contact-pattern-on-gear-1-at-200-n-m.svg", OUT / f"tutorial-contact-{pair.stem}.svg")
    ste_figure(pairs)
    runs = run_ups(pairs)
    order_figure(pairs, runs)
    show("tutorial", table(pairs, runs), OUT)


if __name__ == "__main__":
    main()
