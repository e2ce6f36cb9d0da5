"""Mesh stiffness over the angle of gear 1, as tools with a gear mesh of their own take it.

    python -m examples.hosts.mesh_stiffness PAIR.json TORQUE TABLE.txt

writes the table of `GearMesh.mo`. `in_ross` and `in_opentorsion` use the same function.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from gearmesh import command

PAIR = Path(__file__).parents[1] / "drivelines" / "pairs" / "spur-50-50.json"


def over_a_pitch(pair: Path, torque: float, refinement: str = "coarse") -> dict[str, np.ndarray]:
    """Tangent stiffness at the torque, N m, from 0 to one pitch, both ends included.

    `angle`, rad; `normal`, N/m, along the normal of the flank; `line_of_action`, N/m, in the transverse plane; `torsional`,
    N m/rad, about the axis of gear 1 with gear 2 held.
    """
    with tempfile.TemporaryDirectory() as folder:
        command.run("solve", pair, "--torque-nm", torque, "--refinement", refinement, "--output", folder, "-q")
        table = np.genfromtxt(Path(folder, "stiffness.csv"), delimiter=",", names=True)
    angle = np.radians(table["gear1_angle_deg"])
    columns = {"normal": "normal_n_per_m", "line_of_action": "loa_n_per_m", "torsional": "torsional_stiffness_gear1_nm_per_rad"}
    closed = {name: table[c if name == "torsional" else f"stiffness_{c}"] for name, c in columns.items()}
    closed = {name: np.append(column, column[0]) for name, column in closed.items()}
    return {"angle": np.append(angle, len(angle) * angle[1])} | closed


def write_modelica(table: dict[str, np.ndarray], file: Path) -> None:
    """As text for `Modelica.Blocks.Tables`: angle, and stiffness on the line of action."""
    rows = np.column_stack([table["angle"], table["line_of_action"]])
    np.savetxt(file, rows, fmt="%.17g", header=f"#1\ndouble stiffness({len(rows)},2)", comments="")


if __name__ == "__main__":
    write_modelica(over_a_pitch(Path(sys.argv[1]), float(sys.argv[2])), Path(sys.argv[3]))
