"""openTorsion (pip install opentorsion): `python -m examples.hosts.in_opentorsion`, eigenfrequency over the mesh cycle."""

from __future__ import annotations

import gearmesh
import numpy as np
from opentorsion import Assembly, Disk, Shaft
from opentorsion.elements.elastic_gear_element import ElasticGear

from examples.shared.files import PAIRS

BASE_RADIUS = 75e-3 * np.cos(np.radians(20.0))  # m
INERTIAS, RATIO = (7.6e-3, 7.6e-3), 1.0  # kg m^2 of both gears; teeth of gear 2 over those of gear 1
FLYWHEEL, SHAFT = 0.5, 2e4  # kg m^2 and N m/rad, beside gear 1


def assembly(stiffness: float) -> Assembly:
    """A flywheel on a shaft with gear 1, and gear 2; `stiffness` of the mesh about the axis of gear 1, N m/rad."""
    gear1 = ElasticGear(1, INERTIAS[0], 1.0)
    gear2 = ElasticGear(2, INERTIAS[1], RATIO, k=stiffness, c=0.0, parent=gear1)
    # Nodes are counted by shafts and discs: gear 2 has a disc of nothing.
    discs = [Disk(0, FLYWHEEL), Disk(2, 0.0)]
    return Assembly([Shaft(0, 1, None, None, k=SHAFT, I=0.0)], discs, elastic_gear_elements=[gear1, gear2])


def frequencies(stiffness: float) -> np.ndarray:
    """Hz, undamped, from the lowest on."""
    line = assembly(stiffness)
    squares = np.linalg.eigvals(np.linalg.solve(line.M, line.K)).real
    return np.sqrt(np.maximum(np.sort(squares), 0.0)) / (2.0 * np.pi)


if __name__ == "__main__":
    stiffness = gearmesh.solve(PAIRS / "spur-50-50.json", 150.0, refinement="coarse").mesh_stiffness_loa_n_per_m * BASE_RADIUS**2
    found = np.array([frequencies(k) for k in stiffness])
    print(f"mesh mode {found[:, -1].min():.0f} to {found[:, -1].max():.0f} Hz over the mesh cycle")
