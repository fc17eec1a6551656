"""Stiffness and body force of a mesh, element by element.

scikit-fem's stock forms take 40 s for 200,000 unknowns; one dense product per element, in batches that
bound the memory, gives the same matrix to round-off in a fraction of it.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array
from solvers.elements import STIFFNESS_ORDER, ElementTable, Space, tabulate

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["batches", "body_force", "element_gradients", "stiffness", "strain_matrix"]

BATCH = 256
"""Elements per batch: about 40 MB of strain matrices."""

POINTS_PER_PRODUCT = 9
"""Quadrature points per matrix product. OpenBLAS hands larger products to several threads, whose waiting
for one another costs ten times the product on a busy machine."""

FloatArray = NDArray[np.float64]


def batches(count: int) -> Iterator[slice]:
    """Slices that cover `count` elements."""
    return (slice(start, min(start + BATCH, count)) for start in range(0, count, BATCH))


def element_gradients(space: Space, table: ElementTable, batch: slice) -> tuple[FloatArray, FloatArray]:
    """Gradients of the displacement functions at the quadrature points of some elements.

    Returns
    -------
    gradients : (c, q, 3, b) float array, 1/m
    volumes : (c, q) float array, m³
        Volume that each point stands for.

    Raises
    ------
    InputError
        If an element is folded or has no volume.
    """
    mapped = table.geometry_gradients.shape[2]
    nodes = space.points[space.connectivity[batch, :mapped]]
    jacobian = table.geometry_gradients @ nodes[:, None]
    determinant: FloatArray = np.linalg.det(jacobian)
    if determinant.min() <= 0.0:
        element = int(determinant.min(axis=1).argmin())
        centre = ", ".join(f"{value:.4g}" for value in nodes[element].mean(axis=0))
        msg = (
            f"Element {batch.start + element} at ({centre}) m is folded or has no volume: "
            "its nodes must follow VTK's order and its corners be convex."
        )
        raise InputError(msg)
    gradients = np.linalg.solve(jacobian, table.gradients[None])
    return np.asarray(gradients, dtype=np.float64), determinant * table.weights


def strain_matrix(gradients: FloatArray) -> FloatArray:
    """Strain from displacements: ε = B u.

    Parameters
    ----------
    gradients : (..., 3, b) float array, 1/m

    Returns
    -------
    B : (..., 6, 3b) float array, 1/m
        Rows xx, yy, zz, xy, yz, xz (engineering shear); columns x, y, z of each function in turn.
    """
    x, y, z = (gradients[..., i, :] for i in range(3))
    B = np.zeros((*gradients.shape[:-2], 6, 3 * gradients.shape[-1]))
    B[..., 0, 0::3] = B[..., 3, 1::3] = B[..., 5, 2::3] = x
    B[..., 1, 1::3] = B[..., 3, 0::3] = B[..., 4, 2::3] = y
    B[..., 2, 2::3] = B[..., 4, 1::3] = B[..., 5, 0::3] = z
    return B


def stiffness(space: Space, elasticity: FloatArray) -> "csr_array":
    """Stiffness matrix K of a homogeneous body.

    Parameters
    ----------
    space : Space
    elasticity : (6, 6) float array, Pa

    Returns
    -------
    K : (3m, 3m) sparse array, N/m
        Components x, y, z of each point in turn.

    Raises
    ------
    InputError
        If an element is folded or has no volume.
    """
    from scipy.sparse import bsr_array

    table = tabulate(space.kind, STIFFNESS_ORDER[space.kind])
    count, functions = space.connectivity.shape
    slots, columns, row_starts = _pattern(space)
    blocks = np.zeros(9 * len(columns))
    within = np.arange(9)
    for batch in batches(count):
        gradients, volumes = element_gradients(space, table, batch)
        B = strain_matrix(gradients)
        stress = (elasticity @ B) * volumes[..., None, None]
        K = _sum_over_points(B, stress)
        pairs = K.reshape(-1, functions, 3, functions, 3).transpose(0, 1, 3, 2, 4).reshape(-1, 9)
        np.add.at(blocks, (9 * slots[batch].reshape(-1, 1) + within).ravel(), pairs.ravel())
    matrix = bsr_array((blocks.reshape(-1, 3, 3), columns, row_starts), shape=(space.unknowns,) * 2)
    return matrix.tocsr()


def _sum_over_points(B: FloatArray, stress: FloatArray) -> FloatArray:
    """Element matrices (c, 3b, 3b): Bᵀ (D B dV) summed over the points of (c, q, 6, 3b) arrays."""
    count, points, _, columns = B.shape
    K = np.zeros((count, columns, columns))
    for start in range(0, points, POINTS_PER_PRODUCT):
        some = slice(start, start + POINTS_PER_PRODUCT)
        left = B[:, some].reshape(count, -1, columns)
        K += left.transpose(0, 2, 1) @ stress[:, some].reshape(count, -1, columns)
    return K


def _pattern(space: Space) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Where each pair of an element's points goes among the matrix's 3 x 3 blocks.

    Returns the block of each pair (e, b * b), the column of each block and the start of each row.
    """
    count, functions = space.connectivity.shape
    n = len(space.points)
    rows = np.repeat(space.connectivity, functions, axis=1)
    columns = np.tile(space.connectivity, (1, functions))
    keys, slots = np.unique(rows * n + columns, return_inverse=True)
    row_starts = np.searchsorted(keys, n * np.arange(n + 1))
    return slots.reshape(count, -1), keys % n, row_starts


def body_force(space: Space, force: ArrayLike) -> FloatArray:
    """Nodal forces of a constant force per volume.

    Parameters
    ----------
    space : Space
    force : (3,) array-like, N/m³

    Returns
    -------
    f : (3m,) float array, N
    """
    density = as_array("force", force, (3,))
    table = tabulate(space.kind, STIFFNESS_ORDER[space.kind])
    share = np.zeros(len(space.points))
    for batch in batches(len(space.connectivity)):
        _, volumes = element_gradients(space, table, batch)
        np.add.at(share, space.connectivity[batch].ravel(), (volumes @ table.values).ravel())
    return np.outer(share, density).ravel()
