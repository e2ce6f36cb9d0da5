"""Mesh stiffness over the angle of gear 1, as the table that the Modelica component `GearMesh.mo` reads.

    python -m examples.hosts.mesh_stiffness PAIR.json TORQUE TABLE.txt
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import gearmesh
import numpy as np


def over_a_pitch(pair: Path, torque: float) -> tuple[np.ndarray, np.ndarray]:
    """Angle, rad, and tangent stiffness on the line of action at the torque, N m: N/m, from 0 to one pitch, both ends included."""
    cycle = gearmesh.solve(pair, torque, refinement="coarse")
    pitch = 2.0 * np.pi / json.loads(pair.read_text())["gear1"]["teeth"]
    stiffness = cycle.mesh_stiffness_loa_n_per_m
    return np.append(cycle.mesh_position, 1.0) * pitch, np.append(stiffness, stiffness[0])


def write_modelica(angle: np.ndarray, stiffness: np.ndarray, file: Path) -> None:
    """As text for `Modelica.Blocks.Tables`."""
    rows = np.column_stack([angle, stiffness])
    np.savetxt(file, rows, fmt="%.17g", header=f"#1\ndouble stiffness({len(rows)},2)", comments="")


if __name__ == "__main__":
    write_modelica(*over_a_pitch(Path(sys.argv[1]), float(sys.argv[2])), Path(sys.argv[3]))
