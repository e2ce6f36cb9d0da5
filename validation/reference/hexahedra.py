"""20-node hexahedra, and the stiffness of any elements, which the reference programs here have in common."""

import numpy as np
from scipy.sparse import coo_matrix

# Corners, then the middles of the edges.
_CORNERS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
_EDGES = [np.array(c) for c in np.ndindex(3, 3, 3) if sum(v == 1 for v in c) == 1]
LOCAL = np.vstack([_CORNERS, np.array(_EDGES) - 1])


def halves(ends):
    """The ends of cells and the middles between them."""
    ends = np.asarray(ends, float)
    return np.sort(np.r_[ends, 0.5 * (ends[1:] + ends[:-1])])


def shape(xi):
    """Values (points, 20) and gradients (points, 20, 3) of the functions at the points `xi`."""
    c, p = LOCAL, np.atleast_2d(xi)[:, None, :]
    f, d = np.where(c == 0, 1 - p**2, 1 + p * c), np.where(c == 0, -2 * p + 0 * c, c)
    corner = (c != 0).all(1)
    extra = np.where(corner, (p * c).sum(2) - 2, 1.0)
    scale = np.where(corner, 0.125, 0.25)
    product = f.prod(2)
    grad = np.stack([d[..., k] * f[..., (k + 1) % 3] * f[..., (k + 2) % 3] for k in range(3)], 2)
    grad = scale[:, None] * (grad * extra[..., None] + np.where(corner[:, None], product[..., None] * c, 0.0))
    return scale * product * extra, grad


def tensor(points, n):
    """Points of a product of `n` rules (their weights likewise): (points, n)."""
    return np.stack([grid.ravel() for grid in np.meshgrid(*[points] * n, indexing="ij")], 1)


def spatial(x, grad):
    """Gradients in space (elements, points, nodes, dimensions) and volumes (elements, points) of elements with nodes at x."""
    jac = np.einsum("gad,eai->egdi", grad, x, optimize=True)
    return np.einsum("egid,gad->egai", np.linalg.inv(jac), grad, optimize=True), np.abs(np.linalg.det(jac))


def stiffness(x, dofs, size, modulus, ratio, functions=shape, chunk=1000):
    """Upper triangle (CSR) of the stiffness of elements with nodes at x (elements, nodes, dimensions); dofs alike, -1: held."""
    lam, mu = modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))
    (a, w), (_, nodes, n) = np.polynomial.legendre.leggauss(3), x.shape
    _, grad = functions(tensor(a, n))
    weight = tensor(w, n).prod(1)
    parts = []
    for i in range(0, len(x), chunk):
        b, volume = spatial(x[i : i + chunk], grad)
        b = (b * np.sqrt(volume * weight)[..., None, None]).reshape(len(b), len(weight), nodes * n)
        bb = np.matmul(b.transpose(0, 2, 1), b).reshape(-1, nodes, n, nodes, n)
        k = lam * bb + mu * bb.transpose(0, 1, 4, 3, 2)
        dot = mu * np.einsum("eaibi->eab", bb)
        for axis in range(n):
            k[:, :, axis, :, axis] += dot
        dof = dofs[i : i + chunk].reshape(-1, nodes * n).astype(np.int32)
        rows, cols = np.repeat(dof[:, :, None], nodes * n, 2).ravel(), np.repeat(dof[:, None, :], nodes * n, 1).ravel()
        keep = (rows >= 0) & (cols >= rows)
        parts.append((k.ravel()[keep], rows[keep], cols[keep]))
    value, rows, cols = (np.concatenate(p) for p in zip(*parts))
    return coo_matrix((value, (rows, cols)), (size, size)).tocsr()
