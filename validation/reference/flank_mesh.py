"""Finite elements of one gear with a band of fine cells along the contact line of each loaded tooth, condensed onto its loads.

The gear stands in a frame of its own in which loaded flanks face +theta. Teeth that bear load, and their neighbours, are meshed;
elsewhere the body ends at the root circle. Lengths in mm, forces in N.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from pypardiso import PyPardisoSolver
from scipy.optimize import brentq
from scipy.sparse import csr_matrix

from hexahedra import LOCAL, halves, shape, stiffness
from teeth import E, NU


@dataclass
class Mesh:
    """Sizes, mm: cells of the band along the flank, how many; cells on either side of it, across the tooth, and of the body."""

    cell: float = 0.03
    band: int = 20
    side: int = 8
    across: int = 10
    body: int = 6
    edge: float = 0.008  # least size of the cells between the band and the tip edge


def growing(length, first, count):
    """Ends of `count` cells over `length`, growing geometrically from `first`; even ones where `first` is too large for that."""
    if first * count >= length:
        return np.linspace(0.0, length, count + 1)
    total = lambda q: first * (q**count - 1) / (q - 1) - length
    q = brentq(total, 1.0 + 1e-9, 60.0)
    ends = first * (q ** np.arange(count + 1) - 1) / (q - 1)
    return ends * length / ends[-1]


class Profile:
    """Half a tooth's outline from the middle of the space to the tip over its arc length."""

    def __init__(self, gear):
        land, fillet, flank = gear.half(600)
        r, t = np.array(land + fillet + flank).T
        keep = np.r_[True, np.hypot(np.diff(r), r[1:] * np.diff(t)) > 1e-9]
        self.r, self.t, self.form_radius = r[keep], t[keep], flank[0][0]
        length = np.hypot(np.diff(self.r), 0.5 * (self.r[1:] + self.r[:-1]) * np.diff(self.t))
        self.arc = np.r_[0.0, np.cumsum(length)]
        split = np.argmax(np.abs(np.diff(self.r)) > 0.707 * length)  # where the fillet has turned by 45 degrees
        self.split, self.tip = self.arc[split], self.arc[-1]
        self.kappa = gear.kappa

    def at(self, arc):
        return np.interp(arc, self.arc, self.r), np.interp(arc, self.arc, self.t)

    def of_radius(self, r):
        return np.interp(self.kappa * r, self.kappa * self.r, self.arc)


class FlankMesh:
    """`lines`: for each loaded tooth (angle of its middle at z = 0 as a number of pitches) the radius of the contact line over z."""

    def __init__(self, gear, layers, lines, mesh, plane_strain, half=False):
        """`half`: of a spur gear, from z = 0 to mid-face, where loads and displacements are even or odd."""
        self.half, self.gear, self.ends, self.zs = half, gear, np.asarray(layers, float), halves(layers)
        self.lines, self.sizes, self.plane = lines, mesh, plane_strain
        self.profile = Profile(gear)
        first, last = min(lines) - 1, max(lines) + 1
        self.depth = halves(growing(abs(gear.held - gear.root), 0.3 * gear.m, mesh.body)) / abs(gear.held - gear.root)
        self.cells, self.tooth, self.follows = [], {}, {}
        for sector in range(first, last + 1):
            self.add_tooth(sector)
        angle = 2 * pi / gear.z * (halves(np.arange(gear.z - (last - first))) + last + 0.5)
        self.add_body(np.full(angle.size, gear.root), angle, angle)
        self.join()

    def add(self, r, t):
        """Cells of a lattice: (n, m) or, where it changes along the face, (n, m, planes); returns their numbers (cells, cells, layers)."""
        steps = LOCAL + 1
        n, m = r.shape[:2]
        i, j, k = np.meshgrid(np.arange(0, n - 1, 2), np.arange(0, m - 1, 2), np.arange(0, self.zs.size - 1, 2), indexing="ij")
        a, b, c = (v.reshape(-1, 1) + steps[:, d] for d, v in enumerate((i, j, k)))
        picked = [v[a, b, c] if v.ndim == 3 else v[a, b] for v in (r, t)]
        start = sum(len(x) for x in self.cells)
        self.cells.append(np.stack([*picked, self.zs[c]], 2))
        return start + np.arange(i.size).reshape(i.shape)

    def add_body(self, surface, angle, held_angle):
        """Cells from the points of a surface down to where the gear is held."""
        weight = self.depth[None, :]
        self.add(
            surface[:, None] + weight * (self.gear.held - surface[:, None]),
            angle[:, None] + weight * (held_angle - angle)[:, None],
        )

    def rows(self, sector):
        """Arc lengths (rows, planes) of the nodes along the flank and how far each row is graded towards the flank."""
        p, s = self.profile, self.sizes
        if sector not in self.lines:
            ends = np.linspace(p.split, p.tip, 5)
            return np.repeat(halves(ends)[:, None], self.zs.size, 1), np.zeros((9, self.zs.size)), 4
        arcs, half, follows = [], 0.5 * s.band * s.cell, []
        for z in self.zs:
            line = p.of_radius(self.lines[sector](z))
            centre = np.clip(line, p.split + half + s.side * s.cell, p.tip - half - s.side * s.edge)
            follows.append(centre == line)
            below = centre - half - growing(centre - half - p.split, s.cell, s.side)[::-1]
            above = centre + half + growing(p.tip - centre - half, s.cell, s.side)
            arcs.append(halves(np.r_[below, np.linspace(centre - half, centre + half, s.band + 1)[1:-1], above]))
        arcs, self.follows[sector] = np.array(arcs).T, np.array(follows)
        start = arcs[2 * s.side]
        return arcs, np.clip((arcs - p.split) / (0.6 * (start - p.split)), 0.0, 1.0), s.across

    def add_tooth(self, sector):
        g, p = self.gear, self.profile
        pitch = 2 * pi / g.z
        arcs, graded, across = self.rows(sector)
        r, t = p.at(arcs)
        even = np.linspace(0.0, 1.0, 2 * across + 1)[:, None, None]
        width = 2 * np.mean(r * t)
        towards = halves(growing(width, min(self.sizes.cell, width / across), across))[:, None, None] / width
        u = (1 - graded) * even + graded * towards if sector in self.lines else np.broadcast_to(even, (even.size, *r.shape))
        numbers = self.add(np.broadcast_to(r, u.shape), sector * pitch + t * (1 - 2 * u))
        self.tooth[sector] = (r, numbers[0])
        # The body below the tooth, then below the land on either side of it.
        r0, t0 = p.at(p.split)
        land = halves(np.linspace(p.split, 0.0, 3))
        r_land, t_land = p.at(land)
        inside = t0 + (p.split - land) / p.split * (0.5 * pitch - t0)
        base = t0 * (1 - 2 * even[:, 0, 0])
        middle = sector * pitch
        self.add_body(np.full(base.size, r0), middle + base, middle + base)
        for side in (1, -1):
            self.add_body(r_land, middle + side * t_land, middle + side * inside)

    def join(self):
        """Nodes that cells share, and the unknowns: none where the gear is held; in plane strain one plane of nodes."""
        cells = np.concatenate(self.cells)
        angle = cells[..., 1] + self.gear.twist * cells[..., 2]
        self.x = np.stack([cells[..., 0] * np.cos(angle), cells[..., 0] * np.sin(angle), cells[..., 2]], -1)
        key = np.round(self.x.reshape(-1, 3)[:, : 2 if self.plane else 3] * 1e6 + 0.1234567).astype(np.int64)
        _, first, node = np.unique(key, axis=0, return_index=True, return_inverse=True)
        held = np.abs(cells[..., 0].ravel()[first] - self.gear.held) < 1e-7
        free = np.repeat(~held[:, None], 3, 1)
        if self.plane:
            free[:, 2] = False
        number = np.where(free, np.cumsum(free).reshape(free.shape) - 1, -1)
        self.size = int(free.sum())
        self.dofs = number[node.reshape(self.x.shape[:2])]
        # Unknowns that are zero at mid-face: uz of even displacements, ux and uy of odd ones.
        middle = (self.x[..., 2] == self.ends[-1])[..., None] & (self.dofs >= 0) & self.half
        self.fixed = [np.unique(self.dofs[middle & np.array(c)]) for c in ([False, False, True], [True, True, False])]

    def locate(self, sector, r, z):
        """Cells and local coordinates along flank and face of the points (r, z) of the loaded flank; nan where there is none."""
        radii, cells = self.tooth[sector]
        layer = np.clip(np.searchsorted(self.ends, z, side="right") - 1, 0, len(self.ends) - 2)
        zeta = 2 * (z - self.ends[layer]) / (self.ends[layer + 1] - self.ends[layer]) - 1
        n = np.stack([zeta * (zeta - 1) / 2, 1 - zeta**2, zeta * (zeta + 1) / 2])
        k = self.gear.kappa
        profile = k * sum(n[c] * radii[:, 2 * layer + c] for c in range(3))  # (rows, points)
        row = np.clip((profile[::2] <= k * r).sum(0) - 1, 0, len(cells) - 1)
        a, b, c = (profile[2 * row + q, np.arange(r.size)] for q in range(3))
        xi = np.zeros(r.size)
        for _ in range(6):
            value = a * xi * (xi - 1) / 2 + b * (1 - xi**2) + c * xi * (xi + 1) / 2 - k * r
            xi -= value / (a * (xi - 0.5) - 2 * b * xi + c * (xi + 0.5))
        xi[np.abs(xi) > 1.0 + 1e-6] = np.nan
        return cells[row, layer], xi, zeta

    def radius(self, sector, row, xi, z):
        """Radius at the local coordinate `xi` of the row of cells `row` at z."""
        radii, _ = self.tooth[sector]
        layer = np.clip(np.searchsorted(self.ends, z, side="right") - 1, 0, len(self.ends) - 2)
        zeta = 2 * (z - self.ends[layer]) / (self.ends[layer + 1] - self.ends[layer]) - 1
        n = [zeta * (zeta - 1) / 2, 1 - zeta**2, zeta * (zeta + 1) / 2]
        m = [xi * (xi - 1) / 2, 1 - xi**2, xi * (xi + 1) / 2]
        return sum(m[q] * n[c] * radii[2 * row + q, 2 * layer + c] for q in range(3) for c in range(3))

    def condensed(self, points):
        """Compliance between loads, mm/N. `points`: tooth, r, z, direction (3), share of the load, number of the load."""
        sector, r, z, direction, share, load = points
        rows, cols, values = [], [], []
        for tooth in np.unique(sector):
            at = sector == tooth
            cell, xi, zeta = self.locate(tooth, r[at], z[at])
            # On the loaded flank the first local coordinate is -1; rows of the tooth run along the second.
            n, _ = shape(np.stack([-np.ones(xi.size), xi, zeta], 1))
            dof = self.dofs[cell]
            value = (share[at, None] * n)[:, :, None] * direction[at][:, None, :]
            keep = (dof >= 0) & (value != 0.0)
            rows.append(dof[keep])
            cols.append(np.broadcast_to(load[at][:, None, None], dof.shape)[keep])
            values.append(value[keep])
        count = int(load.max()) + 1
        b = csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))), (self.size, count))
        matrix = stiffness(self.x, self.dofs, self.size, E, NU)
        if not self.half:
            return schur(matrix, b)
        keep = [np.setdiff1d(np.arange(self.size), fixed) for fixed in self.fixed]
        even, odd = (schur(matrix[k][:, k], b[k]) for k in keep)
        return 0.5 * np.block([[even + odd, even - odd], [even - odd, even + odd]])


def schur(matrix, b, chunk=100):
    """B' K^-1 B by sparse factors of K; `matrix`: its upper triangle."""
    solver = PyPardisoSolver(mtype=2)
    solver.factorize(matrix)
    # K = L L': L^-1 B is enough, the compliance is its product with itself.
    solver.set_phase(331)
    half = np.empty(b.shape, order="F")
    for i in range(0, b.shape[1], chunk):
        half[:, i : i + chunk] = solver._call_pardiso(matrix, np.asfortranarray(b[:, i : i + chunk].toarray()))
    solver.free_memory(everything=True)
    return half.T @ half
