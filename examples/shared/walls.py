"""The gearbox housing: a box of finite elements, reduced to its bearing seats and modes by Craig and Bampton's method.

Every bearing sits in a rigid square patch of an end wall, whose six freedoms stay as they are. The rest of the box follows
them statically, and in modes with the seats fixed. The motion is small: mounts are part of the box's stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import skfem as fem
from scipy.linalg import eigh
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

YOUNG, POISSON, DENSITY = 169e9, 0.275, 7100.0  # ductile iron
WALL, END_WALL = 8e-3, 16e-3  # m
ENDS = (-0.040, 0.100)  # m, middles of the end walls along z, in which the bearings sit
SEAT = 30e-3  # m, half the width of a seat
ELEMENT = 40e-3  # m, the largest edge; two for each bending wave of a wall at 10 kHz
MODES = 60  # with fixed seats, up to 10 kHz
MOUNT = 3e6  # N/m, each corner of the bottom, each direction
LOSS = (0.06, 0.02)  # of critical: the six modes on the mounts, the others
VELOCITY, POWER, AIR = 1e-9, 1e-12, 412.0  # references, m/s and W; impedance of air, N s/m^3


def elasticity(mesh: fem.MeshHex, young: float = YOUNG, poisson: float = POISSON, density: float = DENSITY):
    """Basis, stiffness and mass of a solid of 20-node bricks, which bend with two points of integration each way only."""
    basis, reduced = (fem.Basis(mesh, fem.ElementVector(fem.ElementHexS2()), intorder=order) for order in (4, 3))
    stiffness = linear_elasticity(*lame_parameters(young, poisson)).assemble(reduced)
    mass = fem.BilinearForm(lambda u, v, w: density * dot(u, v)).assemble(basis)
    return basis, stiffness.tocsc(), mass.tocsc()


def frequencies(stiffness: csc_matrix, mass: csc_matrix, count: int) -> np.ndarray:
    """The lowest, Hz; those of rigid motion as next to nothing."""
    squares = eigsh(stiffness, count, mass, sigma=-1e6, return_eigenvectors=False)
    return np.sqrt(np.maximum(np.sort(squares), 0.0)) / (2.0 * np.pi)


class Box:
    """The elements. `freedom` is the direction of each freedom, `place` where it acts."""

    def __init__(self, center_distance: float, element: float = ELEMENT) -> None:
        low, high = np.array([-0.11, -0.12, ENDS[0] - END_WALL / 2]), np.array([center_distance + 0.11, 0.10, ENDS[1] + END_WALL / 2])
        skin = np.array([WALL, WALL, END_WALL])
        self.low, self.high = low, high
        seats = [-SEAT, SEAT, center_distance - SEAT, center_distance + SEAT], [-SEAT, SEAT], []
        edges = [np.sort([a, a + s, *more, b - s, b]) for a, b, s, more in zip(low, high, skin, seats)]
        mesh = fem.MeshHex.init_tensor(*(graded(e, element) for e in edges))
        middle = mesh.p[:, mesh.t].mean(axis=1).T
        mesh = mesh.remove_elements(np.flatnonzero(np.all((middle > low + skin) & (middle < high - skin), axis=1)))
        self.basis, self.stiffness, self.mass = elasticity(mesh)
        self.place = self.basis.doflocs.T
        self.freedom = np.empty(len(self.place), dtype=int)
        for block in (self.basis.nodal_dofs, self.basis.edge_dofs):
            self.freedom[block] = np.arange(3)[:, None]
        self.seats = np.array([(x, 0.0, z) for x in (0.0, center_distance) for z in ENDS])

    def rigid(self, point: np.ndarray) -> np.ndarray:
        """Displacement of each freedom in the six rigid motions about a point."""
        turns = np.cross(np.eye(3)[:, None], self.place - point)
        rows = np.arange(len(self.place))
        return np.column_stack([*(self.freedom == i for i in range(3)), *(turn[rows, self.freedom] for turn in turns)]).astype(float)

    def patch(self, seat: np.ndarray) -> np.ndarray:
        return np.all(np.abs(self.place - seat) < [SEAT + 1e-6, SEAT + 1e-6, END_WALL / 2 + 1e-6], axis=1)

    def mounted(self) -> csc_matrix:
        """Stiffness with that of the mounts, under the four corners of the bottom."""
        x, y, z = self.place.T
        feet = (y < self.low[1] + 1e-6) & (np.minimum(x - self.low[0], self.high[0] - x) < WALL + 1e-6)
        feet &= np.minimum(z - self.low[2], self.high[2] - z) < END_WALL + 1e-6
        return (self.stiffness + diags(4.0 * MOUNT / (feet.sum() / 3.0) * feet)).tocsc()

    def walls(self) -> tuple[csc_matrix, float]:
        """Integral of the squared normal displacement over the outer surface, and its area, m^2."""
        outside = lambda x: np.any([np.isclose(x[i], end[i]) for i in range(3) for end in (self.low, self.high)], axis=0)  # noqa: E731
        facets = fem.FacetBasis(self.basis.mesh, self.basis.elem, facets=self.basis.mesh.facets_satisfying(outside, True), intorder=4)
        return fem.BilinearForm(lambda u, v, w: dot(u, w.n) * dot(v, w.n)).assemble(facets).tocsc(), float(facets.dx.sum())


def graded(edges: np.ndarray, largest: float) -> np.ndarray:
    """`edges` with even steps between them."""
    return np.unique([x for a, b in zip(edges, edges[1:]) for x in np.linspace(a, b, max(1, round((b - a) / largest)) + 1)])


@dataclass(frozen=True)
class Housing:
    """By modes of unit mass, with free seats; each array has a column for each mode.

    `waves` times the rates has as its sum of squares the mean of the squared normal velocity over the outer surface.
    """

    frequencies: np.ndarray  # rad/s
    damping: np.ndarray  # 1/s, over the rates
    shapes: np.ndarray  # of the box's freedoms
    seats: np.ndarray  # displacement of the four seats, x, y, z of each
    impulse: np.ndarray  # linear momentum, from the rates
    waves: np.ndarray
    sensor: np.ndarray  # normal displacement of the top wall, off the middle
    area: float  # m^2


@cache
def housing(center_distance: float, mounts: bool = True) -> Housing:
    box = Box(center_distance)
    stiffness = box.mounted() if mounts else box.stiffness
    reduced = np.zeros((len(box.place), 6 * len(box.seats) + MODES))
    patches = [box.patch(seat) for seat in box.seats]
    for i, (patch, seat) in enumerate(zip(patches, box.seats)):
        reduced[patch, 6 * i : 6 * i + 6] = box.rigid(seat)[patch]
    free = np.flatnonzero(~np.any(patches, axis=0))
    inner = stiffness[free][:, free].tocsc()
    solve = splu(inner).solve
    reduced[free, :-MODES] = -solve(stiffness[free] @ reduced[:, :-MODES])
    inverse = LinearOperator(inner.shape, solve)
    reduced[free, -MODES:] = eigsh(inner, MODES, box.mass[free][:, free], sigma=0.0, OPinv=inverse)[1]
    # All modes of the reduced box, the static ones of up to 23 kHz as well: its statics stay exact.
    squares, modes = eigh(*(reduced.T @ (matrix @ reduced) for matrix in (stiffness, box.mass)))
    rigid, shapes = np.arange(len(squares)) < 6, reduced @ modes
    frequencies = np.sqrt(squares * (mounts | ~rigid))
    surface, area = box.walls()
    values, vectors = np.linalg.eigh(shapes.T @ (surface @ shapes) / area)
    away = np.linalg.norm(box.place - [0.6 * center_distance, box.high[1], 0.06], axis=1) + (box.freedom != 1)
    return Housing(
        frequencies,
        2.0 * np.where(rigid, *LOSS) * frequencies,
        shapes,
        modes[np.add.outer(6 * np.arange(len(box.seats)), np.arange(3)).ravel()],
        box.rigid(np.zeros(3))[:, :3].T @ (box.mass @ shapes),
        np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T,
        shapes[np.argmin(away)],
        area,
    )
