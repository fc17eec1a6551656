"""Step 2: the quadtree over the wall's bounding box (equations 2 and 3, figure 7 of the paper).

The root is the bounding box itself, so voxels are not square. Every voxel is divided in height and
length, never in depth, until it is smaller than half of the smallest opening.
"""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Boundary, CellState, FacadePoints, QuadTree

__all__ = ["addresses", "build_quadtree", "divide", "leaf_of_points"]

FloatArray = NDArray[np.float64]

DEEPEST = 11
"""Levels of the quadtree at the most: four million voxels."""


def divide(lower: FloatArray, upper: FloatArray, *, max_size: float) -> tuple[FloatArray, FloatArray, int]:
    """Divide a rectangle into four again and again until both sides are at most `max_size`.

    Returns
    -------
    lower, upper : (c, 2) float arrays, m
        Corners of the leaves, column by column from the lower left.
    depth : int
        How often it was divided.

    Raises
    ------
    InputError
        If that takes more than `DEEPEST` levels.

    Examples
    --------
    >>> low, high, depth = divide(np.zeros(2), np.array([1.0, 2.0]), max_size=0.6)
    >>> depth, len(low), high[0].tolist()
    (2, 16, [0.25, 0.5])
    """
    size = np.asarray(upper, dtype=np.float64) - lower
    depth = max(0, int(np.ceil(np.log2(size.max() / max_size))))
    if depth > DEEPEST:
        msg = f"Voxels of {max_size:g} m on {size.max():.2f} m are too many: take a larger max_voxel."
        raise InputError(msg)
    count = 2**depth
    # Both corners from the same table, so that neighbours share their sides to the last bit.
    x, z = (lower[axis] + size[axis] * np.arange(count + 1) / count for axis in range(2))
    column, row = (grid.ravel() for grid in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    return (
        np.column_stack([x[column], z[row]]),
        np.column_stack([x[column + 1], z[row + 1]]),
        depth,
    )


def build_quadtree(points: FacadePoints, boundary: Boundary, *, max_size: float) -> QuadTree:
    """Divide the wall's bounding box and classify the voxels by their points.

    A voxel is empty without points, full with interior points only, partial otherwise.

    Parameters
    ----------
    points : FacadePoints
    boundary : Boundary
    max_size : float, m
    """
    lower, upper, depth = divide(points.xz.min(axis=0), points.xz.max(axis=0), max_size=max_size)
    count = 2**depth
    index = np.column_stack(np.divmod(np.arange(count * count), count))
    leaf = leaf_of_points(points.xz, lower[0], upper[-1], depth)
    state = np.full(count * count, int(CellState.EMPTY))
    state[leaf] = CellState.FULL
    state[leaf[boundary.points]] = CellState.PARTIAL
    return QuadTree(lower=lower, upper=upper, state=state, depth=depth, index=index)


def leaf_of_points(xz: FloatArray, lower: FloatArray, upper: FloatArray, depth: int) -> NDArray[np.intp]:
    """Number of the leaf that holds each point of (n, 2) `xz`, m."""
    count = 2**depth
    column, row = (
        np.clip(((values - low) / (high - low) * count).astype(np.intp), 0, count - 1)
        for values, low, high in zip(xz.T, lower, upper, strict=True)
    )
    leaf: NDArray[np.intp] = column * count + row
    return leaf


def addresses(tree: QuadTree) -> list[str]:
    """Address of each leaf: one digit a level, 0 to 3 for lower left, lower right, upper left, upper right.

    Examples
    --------
    >>> from fd2fem.model import QuadTree
    >>> low, high, depth = divide(np.zeros(2), np.ones(2), max_size=0.5)
    >>> index = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    >>> addresses(QuadTree(low, high, np.zeros(4, int), depth, index))
    ['0', '2', '1', '3']
    """
    digits = [
        (tree.index[:, 0] >> level & 1) + 2 * (tree.index[:, 1] >> level & 1)
        for level in reversed(range(tree.depth))
    ]
    return ["".join(map(str, row)) for row in np.column_stack(digits).tolist()]
