"""Tooth root stress by finite elements that share nothing with the program: writes tests/data/root_stress.json.

    python validation/reference/root_stress.py > tests/data/root_stress.json

Outline by own formulas, mesh by gmsh (unstructured 9-node quadrilaterals, swept along the helix to 27-node hexahedra), some real
teeth on a disc or ring that is otherwise plain, bore or rim held. A line load acts on the flank of tooth 0. Stress is that of the
2 x 2 (x 2) Gauss points, carried to the nodes and averaged; the largest principal one over the nodes of the fillet counts.
"""

import json
import sys
from math import acos, cos, hypot, pi, sin, sqrt

import gmsh
import numpy as np
from pypardiso import PyPardisoSolver
from scipy.optimize import brentq

from hexahedra import spatial, stiffness, tensor
from teeth import E, NU, Gear


def mesh(gear, teeth, fine, coarse):
    """Nodes, 9-node quadrilaterals, and the nodes of fillet and flank of tooth 0's +theta side."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    geo = gmsh.model.geo
    point = lambda r, t: geo.addPoint(r * cos(t), r * sin(t), 0, coarse)
    centre = geo.addPoint(0, 0, 0)
    land, fillet, flank = gear.half()
    loop, fine_curves, load_curve = [], [], None
    pitch, count = 2 * pi / gear.z, teeth // 2
    first = last = point(gear.root, -count * pitch - pi / gear.z)

    def arc_to(r, angle):
        """Goes on along a circle about the axis."""
        nonlocal last
        start, last = last, point(r, angle)
        loop.append(geo.addCircleArc(start, centre, last))

    for k in range(-count, count + 1):
        for side in (-1, 1):
            rows = [fillet, flank] if side < 0 else [flank[::-1], fillet[::-1]]
            r, t = rows[0][0]
            arc_to(r, k * pitch + side * t)
            for row in rows:
                points = [last] + [point(r, k * pitch + side * t) for r, t in row[1:]]
                loop.append(geo.addSpline(points))
                last = points[-1]
                if k == 0 and side > 0:
                    if row[0] == flank[-1]:
                        load_curve = loop[-1]
                    else:
                        fine_curves.append(loop[-1])
        arc_to(gear.root, k * pitch + pi / gear.z)
        if k == 0:
            fine_curves.append(loop[-1])
    for angle in np.linspace(count * pitch + pi / gear.z, 2 * pi - count * pitch - pi / gear.z, 5)[1:-1]:
        arc_to(gear.root, angle)
    loop.append(geo.addCircleArc(last, centre, first))
    held = [geo.addPoint(gear.held * cos(a), gear.held * sin(a), 0, coarse) for a in (0, pi / 2, pi, 1.5 * pi)]
    circle = [geo.addCircleArc(held[i], centre, held[(i + 1) % 4]) for i in range(4)]
    surfaces = [geo.addCurveLoop(loop), geo.addCurveLoop(circle)]
    geo.addPlaneSurface(surfaces[::-1] if gear.ring else surfaces)
    geo.synchronize()
    field = gmsh.model.mesh.field
    limits = []
    for curves, size, reach in [(fine_curves, fine, 1.5), ([load_curve], 3 * fine, 1.0)]:
        d = field.add("Distance")
        field.setNumbers(d, "CurvesList", curves)
        field.setNumber(d, "Sampling", 400)
        t = field.add("Threshold")
        for name, value in [("InField", d), ("SizeMin", size), ("SizeMax", coarse), ("DistMin", 0.15 * reach * gear.m), ("DistMax", 3 * gear.m)]:
            field.setNumber(t, name, value)
        limits.append(t)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", limits)
    field.setAsBackgroundMesh(least)
    for name, value in [("MeshSizeExtendFromBoundary", 0), ("MeshSizeFromPoints", 0), ("Algorithm", 8), ("RecombineAll", 1),
                        ("RecombinationAlgorithm", 1), ("SubdivisionAlgorithm", 1), ("ElementOrder", 2), ("HighOrderOptimize", 1)]:
        gmsh.option.setNumber("Mesh." + name, value)
    gmsh.model.mesh.generate(2)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    number = {t: i for i, t in enumerate(tags)}
    xy = xyz.reshape(-1, 3)[:, :2]
    types, _, nodes = gmsh.model.mesh.getElements(2)
    assert list(types) == [10], types
    quads = np.array([number[t] for t in nodes[0]]).reshape(-1, 9)

    def lines(curves):
        edges = []
        for c in curves:
            kind, _, nodes = gmsh.model.mesh.getElements(1, c)
            edges += [[number[t] for t in nodes[i].reshape(-1, 3).ravel()] for i in range(len(kind))]
        return np.array(edges[0] if len(edges) == 1 else sum(edges, [])).reshape(-1, 3)

    out = lines(fine_curves[:1]), lines([load_curve])
    gmsh.finalize()
    used = np.unique(quads)
    new = np.full(len(xy), -1)
    new[used] = np.arange(len(used))
    return xy[used], new[quads], new[out[0]], new[out[1]]


# Lagrange elements: line3 nodes at -1, 1, 0 as gmsh numbers them; the quadrilateral's nine in its order, the solid's plane by plane.
def line3(x):
    return np.array([x * (x - 1) / 2, x * (x + 1) / 2, 1 - x * x]), np.array([x - 0.5, x + 0.5, -2 * x])


QUAD = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (1, 2), (2, 1), (0, 2), (2, 2)]


def nodes(n):
    """Numbers in line3 of each node of an element with `n` dimensions."""
    return np.array([(*ij, k)[:n] for k in range(3 if n == 3 else 1) for ij in QUAD])


def shape(points):
    """Values (points, nodes) and gradients (points, nodes, dimensions) of the 9 or 27 functions."""
    dimensions = range(points.shape[1])
    value, slope = line3(points)
    along = [[(slope if d == g else value)[nodes(len(dimensions))[:, d], :, d].T for d in dimensions] for g in [None, *dimensions]]
    values, *grads = (np.prod(each, 0) for each in along)
    return values, np.stack(grads, 2)


class Model:
    def __init__(self, gear, layers, fine=0.16, coarse=1.0, teeth=3):
        """`layers`: ends along z, mm; None for plane strain."""
        self.gear, self.solid = gear, layers is not None
        xy, quads, self.fillet, self.flank = mesh(gear, teeth, fine * gear.m, coarse * gear.m)
        self.plane = len(xy)
        if self.solid:
            ends = np.asarray(layers)
            self.z = np.sort(np.concatenate([ends, 0.5 * (ends[1:] + ends[:-1])]))
            turn = np.exp(1j * gear.twist * self.z)
            w = (xy[:, 0] + 1j * xy[:, 1])[None, :] * turn[:, None]
            self.x = np.stack([w.real, w.imag, np.repeat(self.z[:, None], len(xy), 1)], 2).reshape(-1, 3)
            stack = [[quads + p * self.plane for p in (2 * k, 2 * k + 2, 2 * k + 1)] for k in range(len(ends) - 1)]
            self.elements = np.concatenate([np.concatenate(s, 1) for s in stack])
        else:
            self.z, self.x, self.elements = np.zeros(1), xy, quads
        held = np.abs(np.hypot(self.x[:, 0], self.x[:, 1]) - gear.held) < 1e-6
        self.free = np.repeat(~held, self.x.shape[1])
        self.size = int(self.free.sum())
        dofs = np.where(self.free, np.cumsum(self.free) - 1, -1).reshape(self.x.shape)
        self.k = stiffness(self.x[self.elements], dofs[self.elements], self.size, E, NU, shape)
        self.solver = PyPardisoSolver(mtype=2)
        self.solver.factorize(self.k)

    def line_load(self, radius, load):
        """Nodal forces of `load(z)` N/mm of face at the radius `radius(z)` along the inward normal (plane strain: N/mm)."""
        g, f = self.gear, np.zeros_like(self.x)
        edges = self.flank
        r = np.hypot(*self.x[edges.ravel(), :2].T).reshape(-1, 3)
        spans = [(0.0, 0.0)] if not self.solid else list(zip(self.z[:-2:2], self.z[2::2]))
        gauss, weight = np.polynomial.legendre.leggauss(8)
        for layer, (low, high) in enumerate(spans):
            for t, w in zip(gauss, weight) if self.solid else [(0.0, 2.0)]:
                z = 0.5 * (low + high) + 0.5 * (high - low) * t
                part = load(z) * (0.5 * (high - low) * w if self.solid else 1.0)
                if part == 0.0:
                    continue
                rz = radius(z)
                inside = np.flatnonzero((r.min(1) <= rz + 1e-9) & (rz <= r.max(1) + 1e-9))[0]
                value = lambda s: line3(s)[0] @ r[inside] - rz
                s = brentq(value, -1.0 - 1e-6, 1.0 + 1e-6)
                theta, alpha = g.flank(rz) + g.twist * z, acos(g.rb / rz)
                # Out of the material: circumferential and, for a ring inwards, radial.
                normal = [g.kappa * sin(alpha), cos(alpha)]
                direction = [normal[0] * cos(theta) - normal[1] * sin(theta), normal[0] * sin(theta) + normal[1] * cos(theta)]
                if self.solid:
                    axial = -cos(alpha) * rz * g.twist  # the surface contains (0, r twist, 1)
                    direction = np.array([*direction, axial]) / hypot(1.0, axial)
                along = line3(t)[0] if self.solid else [1.0]
                planes = [2 * layer, 2 * layer + 2, 2 * layer + 1] if self.solid else [0]
                for a, p in zip(along, planes):
                    for c, node in zip(line3(s)[0], edges[inside]):
                        f[node + p * self.plane] -= part * a * c * np.asarray(direction)
        return f

    def stress(self, forces):
        """Largest principal stress at the nodes of the fillet (planes, nodes), and these nodes."""
        u, n = np.zeros(self.x.size), self.x.shape[1]
        u[self.free] = self.solver.solve(self.k, forces.ravel()[self.free])
        fillet = np.unique(self.fillet)
        wanted = np.concatenate([fillet + p * self.plane for p in range(len(self.z))])
        near = self.elements[np.isin(self.elements, wanted).any(1)]
        points = tensor(np.array([-1, 1]) / sqrt(3), n)
        grad, _ = spatial(self.x[near], shape(points)[1])
        slope = np.einsum("egai,eaj->egij", grad, u.reshape(-1, n)[near], optimize=True)
        strain = 0.5 * (slope + slope.swapaxes(2, 3))
        stress = E / (1 + NU) * (strain + NU / (1 - 2 * NU) * np.trace(strain, axis1=2, axis2=3)[..., None, None] * np.eye(n))
        # Linear through the Gauss points, to the nodes of the element.
        at = np.array([-1, 1, 0])[nodes(n)]
        share = np.prod(0.5 * (1 + 3 * points * at[:, None]), 2)
        total, count = np.zeros((len(self.x), n, n)), np.zeros(len(self.x))
        np.add.at(total, near, np.einsum("ag,egij->eaij", share, stress))
        np.add.at(count, near, 1)
        return np.linalg.eigvalsh(total[wanted] / count[wanted][:, None, None])[:, -1].reshape(len(self.z), -1), fillet

    def root(self, radius, load, at=()):
        """Largest principal stress, MPa: anywhere on the fillet, at the 30 (60) degree tangent, and at the places `at` along z."""
        s, fillet = self.stress(self.line_load(radius, load))
        r = np.hypot(*self.x[fillet, :2].T)
        order = np.argsort(self.gear.kappa * r)
        s, r = s[:, order], r[order]
        fr, ft = self.gear.fillet(800)
        angle = np.interp(self.gear.kappa * r, self.gear.kappa * fr, self.gear.tangent_angle(fr, ft))
        top = np.unravel_index(s.argmax(), s.shape)
        tangent = 60 if self.gear.ring else 30
        at_tangent = max(np.interp(-tangent, -angle, row) for row in s)
        out = {"largest_mpa": s.max(), "place_radius_mm": r[top[1]], "place_tangent_deg": angle[top[1]], "at_tangent_mpa": at_tangent}
        if self.solid:
            out["place_z_mm"] = self.z[top[0]]
            out["along_face_mpa"] = [[z, np.interp(z, self.z, s.max(1))] for z in at]
        return json.loads(json.dumps(out), parse_float=lambda v: round(float(v), 3))


def thinner_at_ends(b, count):
    """Ends of `count` layers, the outermost a third as thick."""
    w = np.ones(count)
    w[[0, -1]], w[[1, -2]] = 0.35, 0.65
    return np.concatenate([[0], np.cumsum(w)]) / w.sum() * b


SPUR = dict(z=20, m=4.0, alpha=20.0, tip=44.0, held=15.0, b=25.0)
SHIFTED = dict(z=16, m=4.5, alpha=20.0, x=0.4, tip=41.4, held=15.0)
RING = dict(z=60, m=3.0, alpha=20.0, x=0.0, tip=87.6, held=105.0, rho=0.3, ring=True)


def case(name, gear, layers, loads, **sizes):
    """`loads`: (radius at z = 0 and at z = b, N/mm there); the contact line and the load are straight between."""
    g = Gear(**gear)
    model = Model(g, layers, **sizes)
    print(name, model.x.size, "unknowns", file=sys.stderr, flush=True)
    out = []
    for (r0, r1), (q0, q1) in loads:
        # A straight contact line of constant slope in the roll length.
        roll = [sqrt(r * r - g.rb**2) for r in (r0, r1)]
        b = g.b or 1.0
        radius = lambda z: hypot(g.rb, roll[0] + (roll[1] - roll[0]) * z / b)
        found = model.root(radius, lambda z: q0 + (q1 - q0) * z / b, at=(0.5 * b, 0.25 * b, 0.75 * b) if layers is not None else ())
        out.append({"radius_mm": [r0, r1], "load_n_per_mm": [q0, q1], **found})
        print(out[-1], file=sys.stderr, flush=True)
    model.solver.free_memory(everything=True)
    return {"name": name, "gear": gear, "plane_strain": layers is None, "loads": out}


def flat(*radii):
    return [((r, r), (100.0, 100.0)) for r in radii]


CASES = {
    "spur20": lambda: case("spur 20, plane strain", SPUR, None, flat(38.5, 40.0, 42.0, 43.6), fine=0.1, coarse=0.6, teeth=5),
    "spur16": lambda: case("spur 16 with profile shift, plane strain", SHIFTED, None, flat(36.5, 38.0, 40.0), fine=0.1, coarse=0.6, teeth=5),
    "ring60": lambda: case("ring 60, plane strain", RING, None, flat(88.5, 90.0, 91.5), fine=0.08, coarse=0.6, teeth=7),
    "solid20": lambda: case("spur 20, face 25 mm", SPUR, thinner_at_ends(25.0, 10), [((42.0, 42.0), (100.0, 100.0)), ((42.0, 42.0), (200.0, 0.0)), ((40.0, 40.0), (0.0, 200.0))]),
    "helical20": lambda: case("helical 20, beta 25 degrees, face 24 mm", dict(z=20, m=3.0, alpha=20.0, beta=25.0, tip=36.104, held=14.0, b=24.0), thinner_at_ends(24.0, 10), [((34.0, 34.0), (100.0, 100.0)), ((32.6, 35.6), (100.0, 100.0)), ((35.6, 32.6), (0.0, 200.0))], fine=0.2, coarse=1.3),
}

if __name__ == "__main__":
    names = sys.argv[1:] or list(CASES)
    data = {"description": " ".join(__doc__.split()), "cases": [CASES[name]() for name in names]}
    print(json.dumps(data, indent=1))
