"""The same system as an SSP of three FMUs, run by Ecos and by libcosim."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import gearmesh
import numpy as np
from gearmesh.ssp import write as write_ssp
from pythonfmu import FmuBuilder

from examples.shared.files import OUT, ROOT

from .masters import DRIVE, IN, OUT as LOADS, RATES, CENTER_DISTANCE, exchange

SEATS = [f"seat{i}.{name}" for name in ("position", "velocity") for i in (1, 2)]
CONNECTIONS = (
    [("shafts", name, "gears", name) for name in IN + RATES]
    + [("gears", name, "shafts", name) for name in LOADS]
    + [("shafts", f"seat{i}.force", "housing", f"seat{i}.force") for i in (1, 2)]
    + [("housing", name, "shafts", name) for name in SEATS]
)
OBSERVED = (("shafts", "gear1.position[2]"), ("shafts", "gear2.position[2]"), ("shafts", "gear2.angles[3]"))
COLUMNS = [1, 4, 5]  # of those in the coordinates of the shafts


def build(gears, begin, coupling: str = "parallel") -> Path:
    """The SSP of the three FMUs with `begin`, the states of shafts and housing, as start, the gears with `coupling`."""
    values = exchange(gears, *begin)
    start = {
        "shafts": begin[0].tolist(), "housing": begin[1].tolist(), "drive": DRIVE.tolist(),
        "exchange": values[np.r_[0:6, 8:12]].tolist(), "forces": values[6:8].tolist(),
    }  # fmt: skip
    return assemble(("shafts", "housing"), start, begin[0], {"coupling": coupling, "phaseReference": "absolute"})


def assemble(bodies: tuple[str, ...], start: dict, shafts: np.ndarray, choices: dict) -> Path:
    """Packs the FMUs of `bodies` with the values of `start`, and that of the gears at the state of the `shafts` with `choices`; writes the SSP."""
    folder, here = OUT / "ssp", Path(__file__).parent
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "start.json").write_text(json.dumps(start))
    sys.path.insert(0, str(here))
    try:
        for name in bodies:
            files = [here / "subsystems.py", here / "linear_fmu.py", folder / "start.json"]
            FmuBuilder.build_FMU(here / f"{name}_fmu.py", dest=folder, project_files=files)
    finally:
        sys.path.remove(str(here))
    pose = shafts.copy()
    pose[3] += CENTER_DISTANCE
    starts = dict(zip(IN + RATES, pose.tolist())) | choices
    gearmesh.pack(ROOT / "resources" / "tables" / "helical-25-47.json", folder / "Gears.fmu", set=starts)
    units = {name: folder / f"{name.capitalize()}.fmu" for name in (*bodies, "gears")}
    within = [c for c in CONNECTIONS if c[0] in units and c[2] in units]
    return write_ssp(folder / "gearbox.ssp", units, within)


def with_ecos(ssp: Path, duration: float, size: float) -> np.ndarray:
    """y of both gears and the angle of gear 2, a row after each step of `size` s, by Ecos."""
    from examples.shared.ecos import EcosSimulation

    simulation = EcosSimulation(size, ssp_path=str(ssp))
    try:
        simulation.init()
        rows = []
        for _ in range(round(duration / size)):
            simulation.step(1)
            rows.append([simulation.get_real(f"{unit}::{name}") for unit, name in OBSERVED])
        return np.array(rows)
    finally:
        simulation.terminate()
        simulation.free()


def with_libcosim(ssp: Path, duration: float, size: float) -> np.ndarray:
    """The same by libcosim, whose times are whole nanoseconds."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(str(ssp), round(1e9 * size))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    places = []
    for unit, name in OBSERVED:
        slave = execution.slave_index_from_instance_name(unit)
        places.append((slave, [{v.name.decode(): v.reference for v in execution.slave_variables(slave)}[name]]))
    rows = []
    for _ in range(round(duration / size)):
        execution.step(1)
        rows.append([observer.last_real_values(*place)[0] for place in places])
    return np.array(rows)


HOSTS = {"Ecos": with_ecos, "libcosim": with_libcosim}
