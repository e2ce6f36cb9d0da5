"""Contact of deformed teeth in plane strain, with finite rotations: places, normals and gaps are those of the loaded flanks.

Quadrilaterals of 8 nodes in total Lagrangian form, St. Venant-Kirchhoff's law; a gear that is stiff beside its mate is condensed onto
its flanks once, linear. Flanks are meshed finely all over, so that contact may go anywhere. A constant pressure on each face of the flank whose tip is
nearer acts along the normal of the deformed mate, at the point that is closest to it. Newton's method, each step with the tangent
stiffness and a linear complementarity problem. Both gears turn by half of the approach, which is the conjugate of the mean of the
torques over the base radii. Lengths in mm, forces in N.
"""

from dataclasses import replace
from math import pi

import numpy as np
from pypardiso import PyPardisoSolver
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_matrix, csr_matrix

from flank_mesh import FlankMesh
from hexahedra import LOCAL, shape, spatial, tensor
from pair import Pair

GAUSS = 4  # points along a face
WINDOW = 0.15  # gaps up to it may close in a step, mm
LONGEST = 0.08  # way of a node in a step, mm
TOLERANCE = 2e-5  # change of the approach in the last step, mm; what it leaves is a hundredth of that
# Nodes of a hexahedron at its lower end: a quadrilateral.
FLAT = np.flatnonzero(LOCAL[:, 2] == -1)
CORNERS = LOCAL[FLAT, :2].astype(float)
AXES = np.array([1.0, 1j])


class Body:
    """A gear with fine cells all over the flanks of `teeth`; `modulus` MPa. `large`: with finite rotations."""

    def __init__(self, gear, teeth, mesh, modulus, ratio, large):
        self.gear, self.large = gear, large
        ends = np.array([0.0, 1.0])
        # The active flank between its form circle and the tip.
        outline = FlankMesh(gear, ends, {0: lambda z: np.full(np.shape(z), gear.tip)}, mesh, True).profile
        form = outline.of_radius(outline.form_radius)
        middle = outline.at(0.5 * (form + outline.tip))[0]
        band = int((outline.tip - form - mesh.side * mesh.edge) / mesh.cell)
        found = FlankMesh(gear, ends, {k: lambda z: np.full(np.shape(z), middle) for k in teeth}, replace(mesh, band=band), True)
        x, self.dofs, self.size = found.x[:, FLAT, :2], found.dofs[:, FLAT, :2], found.size
        lam, mu = modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))
        unit = np.eye(2)
        twice = np.einsum("ik,jl->ijkl", unit, unit) + np.einsum("il,jk->ijkl", unit, unit)
        self.elastic = lam * np.einsum("ij,kl->ijkl", unit, unit) + mu * twice
        a, w = np.polynomial.legendre.leggauss(3)
        grad = shape([(p, q, -1) for p in a for q in a])[1][:, FLAT, :2]
        self.grad, volume = spatial(x, grad)
        self.weight = volume * tensor(w, 2).prod(1) * gear.b
        # On the loaded flank the first local coordinate is -1; rows of the tooth run along the second.
        low, centre, high = (int(np.flatnonzero((CORNERS == [-1, s]).all(1))[0]) for s in (-1, 0, 1))
        self.flank = {}
        for k in teeth:
            cells = found.tooth[k][1][:, 0]
            nodes = np.array([(c, n) for c in cells for n in (low, centre)] + [(cells[-1], high)])
            at, dof = (v[nodes[:, 0], nodes[:, 1]] for v in (x, self.dofs))
            first = np.flatnonzero(np.abs(at @ AXES) > outline.form_radius - 1e-9)[0] // 2
            # From the first cell on the involute on.
            self.flank[k] = at[2 * first :] @ AXES, dof[2 * first :]
        if not large:
            self.surface = np.unique(np.concatenate([dof[dof >= 0] for _, dof in self.flank.values()]))
            unit = csr_matrix((np.ones(self.surface.size), (self.surface, np.arange(self.surface.size))), (self.size, self.surface.size))
            stiffness, _ = self.assembled(np.zeros(self.size))
            self.compliance = solved(stiffness, unit.toarray())[self.surface]

    def assembled(self, u):
        """Tangent stiffness (upper triangle) and nodal forces of the stresses under the displacements `u`."""
        here = np.where(self.dofs >= 0, u[self.dofs], 0.0)
        unit, forces, parts = np.eye(2), np.zeros(self.size), []
        for i in range(0, len(here), 4000):
            grad, weight, dof = self.grad[i : i + 4000], self.weight[i : i + 4000], self.dofs[i : i + 4000].reshape(-1, 16)
            f = unit + np.einsum("eai,egaj->egij", here[i : i + 4000], grad)
            strain = 0.5 * (np.einsum("egki,egkj->egij", f, f) - unit)
            stress = np.einsum("ijkl,egkl->egij", self.elastic, strain)
            force = np.einsum("eg,egij,egjk,egak->eai", weight, f, stress, grad, optimize=True)
            tangent = np.einsum("egij,jkml,egnm->egiknl", f, self.elastic, f, optimize=True) + np.einsum("in,egkl->egiknl", unit, stress)
            left = np.einsum("eg,egak,egiknl->eaingl", weight, grad, tangent, optimize=True).reshape(len(f), 32, -1)
            right = grad.transpose(0, 1, 3, 2).reshape(len(f), -1, 8)
            value = (left @ right).reshape(-1, 8, 2, 2, 8).transpose(0, 1, 2, 4, 3).reshape(-1, 16, 16)
            np.add.at(forces, dof[dof >= 0], force.reshape(-1, 16)[dof >= 0])
            rows, cols = np.repeat(dof[:, :, None], 16, 2), np.repeat(dof[:, None, :], 16, 1)
            keep = (rows >= 0) & (cols >= rows)
            parts.append((value[keep], rows[keep], cols[keep]))
        value, rows, cols = (np.concatenate(p) for p in zip(*parts))
        return coo_matrix((value, (rows, cols)), (self.size, self.size)).tocsr(), forces

    def response(self, u, loads):
        """Displacements at `u` without contact, and by unit loads (size, faces)."""
        if self.large:
            tangent, forces = self.assembled(u)
            found = solved(tangent, np.c_[-forces, loads.toarray()])
            return u + found[:, 0], found[:, 1:]
        by = np.zeros(loads.shape)
        by[self.surface] = self.compliance @ loads[self.surface].toarray()
        return np.zeros(self.size), by


def solved(matrix, right):
    solver = PyPardisoSolver(mtype=2)
    solver.factorize(matrix)
    found = solver.solve(matrix, np.asfortranarray(right))
    solver.free_memory(everything=True)
    return found


class Deformed:
    """A spur pair of which the tooth pairs `teeth` may touch; `meshes` of gear 1 and gear 2, `large`: which have finite rotations."""

    def __init__(self, file, teeth, meshes, large):
        self.pair, self.teeth = Pair(file), sorted(teeth)
        sectors = self.teeth, [-k for k in reversed(self.teeth)]
        of = [file["gear1"], file["gear2"]]
        elastic = [(1e3 * g.get("youngs_modulus_gpa", 206.0), g.get("poisson_ratio", 0.3)) for g in of]
        self.bodies = [Body(*each[:3], *each[3], each[4]) for each in zip(self.pair.gears, sectors, meshes, elastic, large)]
        self.forget()

    def forget(self):
        """Back to no load."""
        self.u, self.approach = [np.zeros(body.size) for body in self.bodies], 0.0

    def faces(self, position):
        """Gaps (mm), arms, loads on both gears (size, faces) and descriptions of the faces that may bear."""
        pair, gears = self.pair, self.pair.gears
        xi, weight = np.polynomial.legendre.leggauss(GAUSS)
        weight, along = 0.5 * weight, np.stack([0.5 * xi * (xi - 1), 1 - xi**2, 0.5 * xi * (xi + 1)])
        angle = [pair.middle[g] + (1 - 2 * g) * position * 2 * pi / gears[g].z + 0.5 * self.approach / gears[g].rb for g in (0, 1)]
        # World: centre[g] + turn[g] times points in the frame of the gear.
        turn, centre = [np.exp(1j * angle[0]), -np.exp(1j * angle[1])], [0.0, pair.a]
        gaps, arms, parts, each, count = [], [], ([], []), [], 0
        for k in self.teeth:
            slave = 0 if pair.path(position, k, 0.5 * pair.b) > 0 else 1
            master = 1 - slave
            at, dofs = [None, None], [None, None]
            for g, sector in enumerate((k, -k)):
                still, dofs[g] = self.bodies[g].flank[sector]
                at[g] = still + np.where(dofs[g] >= 0, self.u[g][dofs[g]], 0.0) @ AXES
            # The flank of the master in its own frame.
            arc = np.r_[0.0, np.cumsum(np.abs(np.diff(at[master])))]
            curve = CubicSpline(arc, np.stack([at[master].real, at[master].imag], 1))
            nodes = 2 * np.arange(len(at[slave]) // 2)[:, None] + np.arange(3)
            own = at[slave][nodes] @ along
            seen = (centre[slave] + turn[slave] * own - centre[master]) / turn[master]
            t = arc[np.abs(seen[..., None] - at[master]).argmin(-1)]
            for _ in range(8):
                away, tangent, bend = (seen - curve(t) @ AXES, *(curve(t, n) @ AXES for n in (1, 2)))
                slope = (np.conj(away) * bend).real - np.abs(tangent) ** 2
                t = np.clip(t - (np.conj(away) * tangent).real / np.minimum(slope, -1e-3), 0.0, arc[-1])
            foot, tangent = curve(t) @ AXES, curve(t, 1) @ AXES
            # Loaded flanks face +theta, arcs run from the root of the mesh to its tip, outwards on an external gear.
            normal = gears[master].kappa * 1j * tangent / np.abs(tangent)
            gap = (np.conj(seen - foot) * normal).real @ weight
            good = np.flatnonzero(((t > 0) & (t < arc[-1])).all(1) & (gap < WINDOW))
            number = count + np.arange(good.size)
            count += good.size
            t, normal, own, foot, nodes = t[good], normal[good] * turn[master], own[good], foot[good], nodes[good]
            gaps.append(gap[good])
            closing = [(np.conj(normal) * turn[g] * 1j * point).real / (2 * gears[g].rb) for g, point in ((master, foot), (slave, own))]
            arms.append((closing[0] - closing[1]) @ weight)
            # Of the master the cells in which the points lie.
            cell = 2 * np.clip(np.searchsorted(arc[::2], t, side="right") - 1, 0, len(arc) // 2 - 1)
            a, b, c = (arc[cell + n] for n in range(3))
            share = [(t - b) * (t - c) / ((a - b) * (a - c)), (t - a) * (t - c) / ((b - a) * (b - c)), (t - a) * (t - b) / ((c - a) * (c - b))]
            own_force, mate_force = normal / turn[slave] * weight, -normal / turn[master] * weight
            for n in range(3):
                parts[slave].append((dofs[slave][nodes[:, n]], number, (own_force * along[n]).sum(1)))
                dof, value = dofs[master][cell + n], mate_force * share[n]
                parts[master].append((dof.reshape(-1, 2), np.repeat(number, GAUSS), value.ravel()))
            radii = np.abs(self.bodies[slave].flank[(k, -k)[slave]][0][nodes])
            ends = (radii**2 - gears[slave].rb**2) / (2 * gears[slave].rb)
            last = len(at[slave]) - 1
            each += [dict(tooth=k, arc=e[1], length=abs(e[2] - e[0]), edge=last - n <= 8) for e, n in zip(ends, nodes[:, 2])]
        loads = []
        for g, body in enumerate(self.bodies):
            dof, number, value = (np.concatenate(v) for v in zip(*parts[g]))
            value, number = np.stack([value.real, value.imag], 1), np.repeat(number[:, None], 2, 1)
            keep = dof >= 0
            loads.append(csr_matrix((value[keep], (dof[keep], number[keep])), (body.size, count)))
        return np.concatenate(gaps), np.concatenate(arms), loads, each

    def solve(self, position, load, complementarity):
        """From the last solution on: approach (mm) under `load` (N on the line of action), forces on the faces and the faces."""
        for iteration in range(40):
            gap, arm, loads, each = self.faces(position)
            compliance = 0.0
            found = [body.response(u, b) for body, u, b in zip(self.bodies, self.u, loads)]
            for b, u, (free, by) in zip(loads, self.u, found):
                compliance = compliance + b.T @ by
                gap = gap + b.T @ (free - u)
            force, more = complementarity(compliance, gap, arm, load)
            steps = [free + by @ force - u for u, (free, by) in zip(self.u, found)]
            longest = LONGEST / max(np.abs(step).max() for step in steps)
            # Where faces at a tip edge bear by turns, half the way.
            share = min(1.0 if iteration < 5 else 0.5, longest)
            self.u, self.approach = [u + share * step for u, step in zip(self.u, steps)], self.approach + share * more
            if share < longest and abs(more) < TOLERANCE:
                return self.approach, force, each
        raise RuntimeError(f"no equilibrium at {position} under {load} N")
