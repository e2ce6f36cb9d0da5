"""Shafts with their gears as solids of revolution, by finite elements that share nothing with the beams of preprocessor/src/shaft.

    python validation/reference/shafts.py > tests/data/shafts.json

Displacements are harmonics about the axis (Zienkiewicz, Taylor, The Finite Element Method, axisymmetric solids under any load):
harmonic 0 for torsion, harmonic 1 for bending in one plane, on quadratic quadrilaterals of scikit-fem in the r-z plane. The
gear is a ring up to its root circle, at whose surface the force of the mesh enters evenly over the face, and where displacements
are taken. A bearing is a spring on the mean displacement of the shaft over a short width, without what a ring of force would dent. A
hole of a twentieth of the radius takes the axis out.
"""

import json

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, FacetBasis, Functional, LinearForm, MeshQuad

YOUNG, POISSON = 206e9, 0.3
SHEAR = YOUNG / 2 / (1 + POISSON)
LAME = 2 * SHEAR * POISSON / (1 - 2 * POISSON)

# mm: cylinders (from z, to z, diameter) with the gear last, its bearings (z, N/um), and the end where the torque enters.
CASES = [
    {"name": "pinion shaft", "sections": [[-90, 0, 40], [0, 40, 40], [40, 110, 35]], "face": 40, "root": 70,
     "bearings": [[-75, 400], [95, 300]], "torque_end": "lower"},
    {"name": "slender pinion", "sections": [[-60, 0, 30], [0, 60, 36], [60, 120, 30]], "face": 60, "root": 44,
     "bearings": [[-50, 400], [110, 400]], "torque_end": "upper"},
    {"name": "overhung", "sections": [[-130, 0, 45], [0, 30, 45]], "face": 30, "root": 80,
     "bearings": [[-115, 300], [-25, 600]], "torque_end": "lower"},
    {"name": "wheel", "sections": [[-70, 0, 50], [0, 30, 60], [30, 80, 50]], "face": 30, "root": 160,
     "bearings": [[-60, 300], [70, 300]], "torque_end": "upper"},
]

# inch: the intermediate shaft of Shigley's Mechanical Engineering Design, 9th ed., Example 7-2, Figure 7-10: shoulders, diameters between
# them, bearings, and each of its gears alone, an inch wide, without stiffening the shaft.
SHOULDERS = [0, 1.25, 1.75, 3.5, 7.5, 9.75, 10.25, 11.5]
DIAMETERS = [1, 1.4, 1.625, 2, 1.625, 1.4, 1]
for name, middle in (("textbook, left gear", 2.75), ("textbook, right gear", 8.5)):
    low = middle - 0.5
    ends = [round(25.4 * (z - low), 3) for z in SHOULDERS]
    bearings = [[round(25.4 * (z - low), 3), 1000000] for z in (0.75, 10.75)]
    diameters = [round(25.4 * diameter, 3) for diameter in DIAMETERS]
    CASES.append({"name": name, "sections": [list(s) for s in zip(ends, ends[1:], diameters)], "face": 25.4, "root": 41.275,
                  "bearings": bearings, "torque_end": "lower"})


def stiffness(basis, n):
    """Of displacements (u_r cos n theta, u_theta sin n theta, u_z cos n theta), over the angle of pi (harmonic 0: 2 pi, torsion alone)."""

    def strains(u, r):
        (radial, around, _), slopes = u, u.grad
        return (
            slopes[0][0],
            (radial + n * around) / r,
            slopes[2][1],
            slopes[0][1] + slopes[2][0],
            slopes[1][0] - (around + n * radial) / r,
            slopes[1][1] - n * u[2] / r,
        )

    @BilinearForm
    def form(u, v, w):
        r = w.x[0]
        e, f = strains(u, r), strains(v, r)
        normal = 2 * SHEAR * sum(a * b for a, b in zip(e[:3], f[:3])) + LAME * sum(e[:3]) * sum(f[:3])
        return (normal + SHEAR * sum(a * b for a, b in zip(e[3:], f[3:]))) * r

    return (np.pi if n else 2 * np.pi) * form.assemble(basis)


def mesh_of(cylinders, size):
    """Quadrilaterals about `size` large of cylinders (from z, to z, radius), any of which may lie over others."""
    hole = 0.05 * min(radius for *_, radius in cylinders)
    radii = sorted({hole} | {radius for *_, radius in cylinders})
    places = sorted({z for low, high, _ in cylinders for z in (low, high)})

    def divided(ends):
        parts = [np.linspace(a, b, max(1, round((b - a) / size)) + 1)[:-1] for a, b in zip(ends, ends[1:])]
        return np.concatenate([*parts, ends[-1:]])

    grid = MeshQuad.init_tensor(divided(radii), divided(places))
    r, z = grid.p[:, grid.t].mean(axis=1)
    inside = [(low < z) & (z < high) & (r < radius) for low, high, radius in cylinders]
    return grid.restrict(np.flatnonzero(np.any(inside, axis=0)))


def flexibility(case, size, ends):
    """z along the face (mm), displacement of the axis across it (um per kN), rotation about it (mrad per kN m) and tilt of its sections
    (mrad per kN, that of a rising displacement positive), a column for each load: even between two of `ends` (mm)."""
    face, root = 1e-3 * case["face"], 0.5e-3 * case["root"]
    width = 4e-3
    cylinders = [(1e-3 * low, 1e-3 * high, 0.5e-3 * diameter) for low, high, diameter in case["sections"]]
    bearings = [(1e-3 * z, 1e6 * stiff) for z, stiff in case["bearings"]]
    bands = [(1e-3 * low, 1e-3 * high) for low, high in zip(ends, ends[1:])]
    # Ends of the springs and of the loads are nodes.
    places = [z + s for z, _ in bearings for s in (-width / 2, width / 2)] + [1e-3 * z for z in ends]
    split = []
    for low, high, radius in cylinders:
        between = [low, *sorted(z for z in places if low + 1e-9 < z < high - 1e-9), high]
        split += [(a, b, radius) for a, b in zip(between, between[1:])]
    mesh = mesh_of([*split, (0.0, face, root)], size)
    basis = Basis(mesh, ElementVector(ElementQuad2(), 3), intorder=5)

    def surface(low, high):
        def there(x):
            return (np.abs(x[0] - root) < 1e-9) & (low < x[1]) & (x[1] < high)

        return FacetBasis(mesh, basis.elem, facets=mesh.facets_satisfying(there), intorder=5)

    def mean(basis):
        """Mean displacement across the axis, (u_r - u_theta) / 2, over a surface or a volume."""
        weight = LinearForm(lambda v, w: 0.5 * (v[0] - v[1]) * w.x[0]).assemble(basis)
        return weight / Functional(lambda w: w.x[0]).assemble(basis)

    def slab(z):
        middle = mesh.p[1, mesh.t].mean(axis=0)
        return Basis(mesh, basis.elem, elements=np.flatnonzero(np.abs(middle - z) < width / 2), intorder=5)

    springs = csc_matrix(np.array([mean(slab(z)) for z, _ in bearings]).T)
    matrix = stiffness(basis, 1) + springs @ csc_matrix(np.diag([stiff for _, stiff in bearings])) @ springs.T
    bent = splu(matrix.tocsc()).solve(1e3 * np.array([mean(surface(*band)) for band in bands]).T)

    def turning(low, high):
        return 1e3 * LinearForm(lambda v, w: v[1] / (root * (high - low))).assemble(surface(low, high))

    torque = np.array([turning(*band) for band in bands]).T
    end = min(c[0] for c in cylinders) if case["torque_end"] == "lower" else max(c[1] for c in cylinders)
    around = basis.get_dofs(elements=True).all(["u^2"])
    held = basis.get_dofs(lambda x: np.abs(x[1] - end) < 1e-9).all(["u^2"])
    free = np.setdiff1d(around, held)
    twist = np.zeros((basis.N, len(bands)))
    twist[free] = splu(stiffness(basis, 0)[free][:, free].tocsc()).solve(torque[free])
    line = np.flatnonzero((np.abs(mesh.p[0] - root) < 1e-9) & (mesh.p[1] > -1e-9) & (mesh.p[1] < face + 1e-9))
    line = line[np.argsort(mesh.p[1][line])]
    u, v, w = (basis.nodal_dofs[i][line] for i in range(3))
    return 1e3 * mesh.p[1][line], 1e6 * 0.5 * (bent[u] - bent[v]), 1e3 * twist[v] / root, -1e3 * bent[w] / root


def solved(case, size):
    """The same under a load even over the whole face."""
    z, across, twist, _ = flexibility(case, size, [0.0, case["face"]])
    return z, across[:, 0], twist[:, 0]


def main():
    cases = []
    for case in CASES:
        results = [solved(case, size) for size in (2.5e-3, 1.25e-3)]
        at = np.linspace(0, case["face"], 5)
        coarse, fine = ([np.interp(at, z, values) for values in (across, turned)] for z, across, turned in results)
        changes = [float(np.max(np.abs(a - b)) / np.max(np.abs(b))) for a, b in zip(coarse, fine)]
        across, turned = ([round(float(v), 5) for v in values] for values in fine)
        cases.append({**case, "z_mm": at.tolist(), "across_um_per_kn": across, "twist_mrad_per_knm": turned,
                      "change_by_halved_elements": [float(f"{c:.1e}") for c in changes]})
    print("[")
    print(",\n".join(json.dumps(case) for case in cases))
    print("]")


if __name__ == "__main__":
    main()
