"""Material by which tools that import FMUs are checked, as the FMI project asks for it: signals, reference, options.

The inputs are a quarter of a revolution of gear 1 under nominal torque, with tilt and a moving centre distance.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import fmpy
import numpy as np

from examples.hosts.compare import outputs
from examples.hosts.scenario import STEP, Scenario, reference, revolution, write_table

STEPS = 256
README = """# {name}

Contact of the gear pair {name}, made by gearmesh {version} for FMI 2.0, Model Exchange and Co-Simulation.
`{name}_in.csv` turns gear 1 by a quarter of a revolution; gear 2 follows under {torque:g} N m, tilts out and back by
0.1 mrad, and the centre distance grows and shrinks by 20 um. `{name}_ref.csv` holds every Real output as gearmesh itself
computes it; {rows}. The FMU has no states of its own, and the times are multiples of 2^-14 s, exact in binary:
a tool that hands over the inputs as they stand, without interpolating between rows, finds these outputs to rounding.
"""
ROWS = {
    "cs": "the row of a time has what belongs to the inputs of the row before, held over the step",
    "me": "the row of a time has what belongs to the inputs of that time",
}


def held(rows: np.ndarray) -> np.ndarray:
    """Rows of Co-Simulation from those of the inputs: the first after initialisation, the others a step later."""
    return np.vstack([rows[:1], rows[:-1]])


def write(fmu: Path, scenario: Scenario, rows: np.ndarray, interface: str, about: dict, out: Path) -> None:
    """The files for one FMU and one interface."""
    name = fmu.stem
    out.mkdir(parents=True)
    shutil.copy(fmu, out)
    scenario.write(out / f"{name}_in.csv")
    values = held(rows) if interface == "cs" else rows
    write_table(out / f"{name}_ref.csv", ["time", *outputs(fmu)], np.column_stack([scenario.times, values]))
    (out / f"{name}_ref.opt").write_text(f"StartTime,0.0\nStopTime,{float(scenario.times[-1])!r}\nStepSize,{STEP!r}\nRelTol,1e-9\n")
    (out / "README.md").write_text(README.format(name=name, rows=ROWS[interface], **about))


def material(fmus: list[Path], out: Path) -> None:
    """For each FMU, interface and platform a folder as the FMI project names it."""
    for fmu in fmus:
        description = fmpy.read_model_description(str(fmu))
        # On gear 1, N m, as packed.
        torque = next(float(v.start) for v in description.modelVariables if v.name == "nominalTorque")
        scenario = revolution(fmu, torque, 0.25, STEPS)
        rows, about = reference(fmu, scenario, outputs(fmu)), {"version": description.version, "torque": torque}
        for interface in ("cs", "me"):
            for platform in fmpy.supported_platforms(str(fmu)):
                place = Path("2.0", interface, platform, "gearmesh", description.version, fmu.stem)
                write(fmu, scenario, rows, interface, about, out / place)
