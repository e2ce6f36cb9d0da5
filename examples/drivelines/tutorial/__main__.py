"""`python -m examples.drivelines.tutorial`: every picture of docs/tutorial.md, into target/drivelines and docs/drivelines."""

from __future__ import annotations

import json
import shutil
import subprocess
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..files import GEARMESH, OUT, PAIRS, ROOT, built
from ..housing.cases import run_up
from ..housing.model import SPUR
from ..housing.observe import spin, wall
from ..orders import order_amplitude

TORQUE = 150.0
RELIEF = {"amount_um": 14.0, "start": {"diameter_mm": 152.5}, "shape": "linear"}
RPM = 30.0 / np.pi


def relieved() -> Path:
    """The pair file with tip relief on both gears."""
    pair = json.loads((PAIRS / "spur-50-50.json").read_text())
    for gear in ("gear1", "gear2"):
        pair[gear]["tip_relief"] = RELIEF
    pair["name"] = "spur-50-50-relieved"
    out = OUT / "spur-50-50-relieved.json"
    OUT.mkdir(parents=True, exist_ok=True)
    text = json.dumps(pair, indent=2)
    if not out.exists() or out.read_text() != text:
        out.write_text(text)
    return out


def command(*arguments: object) -> str:
    run = [str(a) for a in (GEARMESH, *arguments, "--refinement", "coarse")]
    return subprocess.run(run, check=True, stdout=subprocess.PIPE, text=True).stdout


def static(pair: Path, torque: float) -> dict:
    return json.loads(command("solve", pair, "--torque-nm", torque, "--json"))


def transmission_errors(pairs: dict[str, Path]) -> None:
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4))
    torques = np.array([25.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0])
    for name, pair in pairs.items():
        cycle = static(pair, TORQUE)
        error = np.array(cycle["ste_loa_um"])
        left.plot(cycle["mesh_position"], error - error.mean(), label=name)
        right.plot(torques, [static(pair, t)["harmonics_loa_um"][0] for t in torques], "o-", label=name)
        print(f"{name}: {cycle['peak_to_peak_ste_loa_um']:.2f} um peak to peak at {TORQUE:g} N m, "
              f"first harmonic {cycle['harmonics_loa_um'][0]:.3f} um")
    left.set(xlabel="mesh cycle", ylabel=f"STE at {TORQUE:g} N m less its mean, µm")
    right.set(xlabel="torque, N m", ylabel="first harmonic, µm")
    left.legend()
    figure.tight_layout()
    figure.savefig(OUT / "tutorial-ste.png", dpi=80)


def whine(pairs: dict[str, Path]) -> None:
    figure, axis = plt.subplots(figsize=(8, 4.5))
    with ProcessPoolExecutor(2) as pool:
        histories = list(pool.map(one_run, [built(pair) for pair in pairs.values()]))
    for colour, (name, (angle, speed, signal)) in enumerate(zip(pairs, histories)):
        for order, style in ((SPUR.teeth[0], "-"), (2 * SPUR.teeth[0], "--")):
            at, amplitude = order_amplitude(angle, signal, order)
            rpm = RPM * speed[at]
            axis.semilogy(rpm, amplitude, style, color=f"C{colour}", label=f"{name}, order {order}")
            band = rpm > 500.0
            worst = np.argmax(np.where(band, amplitude, 0.0))
            print(f"{name}, order {order}: at most {amplitude[worst]:.1f} m/s^2, at {rpm[worst]:.0f} rpm")
    axis.axhline(10.0, color="grey", lw=0.8)
    axis.set(xlabel="speed, rpm", ylabel="acceleration of the housing wall, m/s²", xlim=(500, 6000), ylim=(1e-2, 300))
    axis.legend(loc="upper right", ncol=2, fontsize=8)
    figure.tight_layout()
    figure.savefig(OUT / "tutorial-orders.png", dpi=80)


def one_run(fmu: Path):
    """Angle and speed of gear 1 and the wall's acceleration in a run-up."""
    history = run_up("variable load", TORQUE, fmu=fmu)
    return *spin(history), wall(history)


def main() -> None:
    docs = ROOT / "docs" / "drivelines"
    (OUT / "tutorial").mkdir(parents=True, exist_ok=True)
    pairs = {"unmodified": PAIRS / "spur-50-50.json", "with tip relief": relieved()}
    for name, pair in pairs.items():
        folder = OUT / "tutorial" / pair.stem
        command("report", pair, "-o", folder.with_suffix(".html"), "--figures", folder)
        shutil.copy(folder / "contact-pattern-on-gear-1-2.svg", docs / f"tutorial-contact-{pair.stem}.svg")
    transmission_errors(pairs)
    whine(pairs)
    for name in ("tutorial-ste.png", "tutorial-orders.png"):
        shutil.copy(OUT / name, docs / name)


if __name__ == "__main__":
    main()
