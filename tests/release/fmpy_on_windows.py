"""A program for a Python on Windows: one scenario through fmpy, by both interfaces.

    python.exe fmpy_on_windows.py FOLDER FMU

FOLDER has `inputs.npz` (times, names and values of the inputs; names of the outputs). The rows of outputs go to
`co_simulation.npy` and `model_exchange.npy` beside it.
"""

import sys
from pathlib import Path

import fmpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from examples.hosts import with_fmpy  # noqa: E402
from examples.hosts.scenario import Scenario  # noqa: E402

if __name__ == "__main__":
    folder, fmu = map(Path, sys.argv[1:])
    given = np.load(folder / "inputs.npz")
    scenario = Scenario(given["times"], given["inputs"].tolist(), given["values"])
    for interface in ("co_simulation", "model_exchange"):
        rows = getattr(with_fmpy, interface)(fmu, scenario, given["outputs"].tolist())
        np.save(folder / f"{interface}.npy", rows)
    print(f"fmpy {fmpy.__version__}, Python {sys.version.split()[0]}, {fmpy.platform}")
