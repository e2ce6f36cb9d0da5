"""The body of a gear from another finite-element program: a ring on four pins, meshed by gmsh, condensed by scikit-fem.

    pip install gmsh scikit-fem
    python examples/body_matrix.py FOLDER
    gearmesh solve FOLDER/ring-of-matrix.json --revolution

Teeth and rim are gearmesh's up to a cylinder; what lies beyond it is a matrix here: the stiffness of the wall by the displacements of the
nodes on that cylinder, with the holes of the pins held. Any program that makes substructures can take the place of this one. FOLDER also gets
ring-on-pins.json, the same ring by `rim_pins`, for comparison.
"""

import json
import sys
from pathlib import Path

import gmsh
import numpy as np
import scipy.io
from scipy.sparse.linalg import splu
from skfem import Basis, ElementHex2, ElementVector, MeshHex, MeshHex2, asm
from skfem.models.elasticity import lame_parameters, linear_elasticity

PAIR = Path(__file__).parents[1] / "resources" / "pairs" / "planet-ring-27-84.json"

# mm and N: the cylinder, 1.25 modules outside of the roots; the outside; the pins.
CYLINDER, OUTSIDE, FACE = 89.4, 103.0, 20.0
PINS, PIN_CIRCLE, PIN = 4, 97.0, 4.0
E, NU = 206e3, 0.3
# Elements around the cylinder, around a pin and along the face; the matrix has the square of three times their nodes as numbers.
AROUND, AROUND_PIN, LAYERS = 72, 12, 2


def section():
    """Quadrilaterals of the wall's cross-section: nodes (n, 2), mm, and elements (m, 4)."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    wall, _ = occ.cut([(2, occ.addDisk(0, 0, 0, OUTSIDE, OUTSIDE))], [(2, occ.addDisk(0, 0, 0, CYLINDER, CYLINDER))])
    angles = 2 * np.pi * np.arange(PINS) / PINS
    holes = [(2, occ.addDisk(PIN_CIRCLE * np.cos(a), PIN_CIRCLE * np.sin(a), 0, PIN, PIN)) for a in angles]
    occ.cut(wall, holes)
    occ.synchronize()
    for dimension, curve in gmsh.model.getEntities(1):
        length = occ.getMass(dimension, curve)
        around = next(n for radius, n in ((CYLINDER, AROUND), (OUTSIDE, AROUND), (PIN, AROUND_PIN)) if np.isclose(length, 2 * np.pi * radius, rtol=1e-3))
        gmsh.model.mesh.setTransfiniteCurve(curve, around + 1)
    gmsh.option.setNumber("Mesh.RecombineAll", 1)
    gmsh.option.setNumber("Mesh.Algorithm", 8)
    gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 3)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 3.5)
    gmsh.model.mesh.generate(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    _, quads = gmsh.model.mesh.getElementsByType(gmsh.model.mesh.getElementType("quadrangle", 1))
    gmsh.finalize()
    used, quads = np.unique(quads, return_inverse=True)
    place = {tag: i for i, tag in enumerate(tags)}
    return places.reshape(-1, 3)[[place[tag] for tag in used], :2], quads.reshape(-1, 4)


def swept(points, quads):
    """Bricks with curved edges: the section along the face."""
    n, levels = len(points), np.linspace(0.0, FACE, LAYERS + 1)
    places = np.vstack([np.column_stack([points, np.full(n, z)]) for z in levels])
    bricks = np.vstack([np.hstack([quads + i * n, quads + (i + 1) * n]) for i in range(LAYERS)])
    # scikit-fem's order of the corners.
    mesh = MeshHex2.from_mesh(MeshHex(places.T, bricks[:, [0, 4, 3, 1, 7, 5, 2, 6]].T))
    curved = mesh.doflocs.copy()
    # The middles of edges lie on the chords of their circles.
    angles = 2 * np.pi * np.arange(PINS) / PINS
    circles = [((0.0, 0.0), radius, AROUND) for radius in (CYLINDER, OUTSIDE)]
    circles += [((PIN_CIRCLE * np.cos(a), PIN_CIRCLE * np.sin(a)), PIN, AROUND_PIN) for a in angles]
    for middle, radius, around in circles:
        arm = curved[:2] - np.array(middle)[:, None]
        distance = np.hypot(*arm)
        near = np.abs(distance - radius) < 1.01 * radius * (1 - np.cos(np.pi / around))
        curved[:2, near] += (arm * (radius / distance - 1))[:, near]
    return MeshHex2(curved, mesh.t)


def on_circle(places, middle, radius):
    return np.abs(np.hypot(places[0] - middle[0], places[1] - middle[1]) - radius) < 1e-6


def condensed(mesh):
    """Nodes of the cylinder (n, 3), mm, and the stiffness by their displacements x, y, z, node by node (3n, 3n), N/mm."""
    basis = Basis(mesh, ElementVector(ElementHex2()))
    whole = asm(linear_elasticity(*lame_parameters(E, NU)), basis).tocsc()
    # Unknowns of a node side by side.
    nodes = np.hstack([basis.nodal_dofs, basis.edge_dofs, basis.facet_dofs, basis.interior_dofs])
    places = basis.doflocs[:, nodes[0]]
    kept = on_circle(places, (0.0, 0.0), CYLINDER)
    angles = 2 * np.pi * np.arange(PINS) / PINS
    held = np.any([on_circle(places, (PIN_CIRCLE * np.cos(a), PIN_CIRCLE * np.sin(a)), PIN) for a in angles], axis=0)
    outer, inner = (nodes[:, which].T.ravel() for which in (kept, ~kept & ~held))
    within = splu(whole[inner][:, inner])
    across = whole[inner][:, outer].toarray()
    stiffness = whole[outer][:, outer].toarray() - across.T @ within.solve(across)
    return places[:, kept].T, 0.5 * (stiffness + stiffness.T)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    places, stiffness = condensed(swept(*section()))
    np.savetxt(folder / "ring-nodes.csv", places, delimiter=",", header="x_mm,y_mm,z_mm", comments="", fmt="%.9g")
    scipy.io.mmwrite(folder / "ring.mtx", stiffness, symmetry="symmetric", precision=12)
    matrix = {"nodes_file": "ring-nodes.csv", "stiffness_n_per_mm_file": "ring.mtx"}
    pins = {"count": PINS, "circle_diameter_mm": 2 * PIN_CIRCLE, "diameter_mm": 2 * PIN}
    for name, body in (("ring-of-matrix", {"body_matrix": matrix}), ("ring-on-pins", {"rim_pins": pins})):
        pair = json.loads(PAIR.read_text()) | {"name": name}
        pair["gear2"] |= {"rim_diameter_mm": 2 * OUTSIDE} | body
        (folder / f"{name}.json").write_text(json.dumps(pair, indent=2) + "\n")
    print(f"Wrote {folder}: {len(places)} nodes, a matrix of {len(stiffness)} rows, ring-of-matrix.json, ring-on-pins.json")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
