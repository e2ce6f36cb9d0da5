"""`python -m examples.drivelines.tutorial`: every picture and figure of docs/tutorial.md, into target/drivelines.

With `--docs docs` also into the page and its folder of pictures.
"""

from __future__ import annotations

import argparse
import re
import shutil
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import gearmesh
import numpy as np
from gearmesh import History, MeshCycle
from gearmesh.plots import figure as new_figure

from examples.shared.files import OUT, PAIRS, built, save
from examples.shared.gearbox import SPUR, sweep

TORQUE = 150.0
ORDERS = (SPUR.teeth[0], 2 * SPUR.teeth[0])
NUMBER = r"(\d+(?:\.\d+)?)"


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


def figures(pairs: dict[str, Path], runs: list) -> dict[str, float]:
    """Figures of the page, each by the text around it: a regular expression whose group is the figure."""
    cycles = [static(pair, TORQUE)[0] for pair in pairs.values()]
    span, first = [c.peak_to_peak_ste_loa_um for c in cycles], [c.harmonics_loa_um[0] for c in cycles]
    found = {
        rf"by {NUMBER} µm peak to peak": span[0],
        rf"first harmonic, {NUMBER} µm": first[0],
        rf"peak to peak \| {NUMBER} µm": span[0],
        rf"peak to peak \| .* \| {NUMBER} µm": span[1],
        rf"first harmonic \| {NUMBER} µm": first[0],
        rf"first harmonic \| .* \| {NUMBER} µm": first[1],
        rf"harmonic fell by {NUMBER} dB": decibels(first),
    }
    for order in ORDERS:
        curves = [order_over_speed(run, order) for run in runs]
        peaks = [(amplitude.max(), rpm[amplitude.argmax()]) for rpm, amplitude in curves]
        for column, (largest, speed) in zip(("", r".* \| "), peaks):
            row = rf"order {order} of the wall, largest \| {column}"
            found[rf"{row}{NUMBER} m/s²"] = largest
            if order == ORDERS[0]:
                found[rf"{row}[\d.]+ m/s² at {NUMBER} rpm"] = speed
        if order == ORDERS[0]:
            found[rf"order {order} reaches {NUMBER} m/s²"] = peaks[0][0]
            found[rf"order {order} reaches [\d.]+ m/s² at {NUMBER} rpm"] = peaks[0][1]
            found[rf"order {order} by {NUMBER} dB at resonance"] = decibels([largest for largest, _ in peaks])
            found[rf"by {NUMBER} dB above 5000 rpm"] = decibels([amplitude[rpm > 5000.0].max() for rpm, amplitude in curves])
    # Lines of the page may end anywhere.
    return {pattern.replace(" ", r"\s+"): value for pattern, value in found.items()}


def decibels(values) -> float:
    """By how much the second is below the first."""
    return float(gearmesh.decibels(values[0], values[1]))


def digits(figure: str) -> int:
    """Decimals that the page gives."""
    return len(figure.partition(".")[2])


def rewritten(page: str, found: dict[str, float]) -> str:
    """The page with the figures found, as exact as it has them."""
    for pattern, value in found.items():
        (match,) = re.finditer(pattern, page)
        page = f"{page[: match.start(1)]}{value:.{digits(match[1])}f}{page[match.end(1) :]}"
    return page


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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", type=Path, help="folder of tutorial.md, which is given the figures and pictures found")
    docs = parser.parse_args().docs
    pairs = pair_files()
    pictures = ["tutorial-ste.png", "tutorial-orders.png"]
    for pair in pairs.values():
        folder = OUT / "tutorial" / pair.stem
        folder.parent.mkdir(parents=True, exist_ok=True)
        gearmesh.command.run("report", pair, "-o", folder.with_suffix(".html"), "--figures", folder, "--refinement", "coarse")
        pictures.append(f"tutorial-contact-{pair.stem}.svg")
        shutil.copy(folder / "contact-pattern-on-gear-1-at-200-n-m.svg", OUT / pictures[-1])
    ste_figure(pairs)
    runs = run_ups(pairs)
    order_figure(pairs, runs)
    found = figures(pairs, runs)
    for pattern, value in found.items():
        print(f"{value:9.3f}  {pattern.replace(NUMBER, '_').replace(chr(92) + 's+', ' ')}")
    if docs:
        page = docs / "tutorial.md"
        page.write_text(rewritten(page.read_text(), found))
        for name in pictures:
            shutil.copy(OUT / name, docs / "drivelines" / name)


if __name__ == "__main__":
    main()
