"""The wall seen from outside: a division of the plane into cells that share corners and sides.

Voxels and quadrilaterals both become a `Division`; what is done with it does not ask where it came from.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VoxelModel
from fd2fem.solids.grid import full_voxels

__all__ = ["Division", "divide_voxels"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Division:
    """A division of the plane into cells.

    Attributes
    ----------
    points : (n, 2) float array, m
        x, z of the corners.
    sides : (s, 2) int array
        Start and end of each side: a piece of a cell's edge with a corner at its ends and none between.
    corner_of : (c, 4) int array
        Corners of each cell, counter-clockwise.
    rings : (r,) int array
        Sides of all cells one after the other, counter-clockwise from the first corner of each.
    sense : (r,) int array
        -1 where a ring runs against the side, else 1.
    start : (c + 1,) int array
        Cell i owns `rings[start[i]:start[i + 1]]`.
    thickness : (c,) float array, m
    """

    points: FloatArray
    sides: IntArray
    corner_of: IntArray
    rings: IntArray
    sense: IntArray
    start: IntArray
    thickness: FloatArray

    @property
    def cell_of(self) -> IntArray:
        """The cell that each entry of `rings` belongs to."""
        return np.repeat(np.arange(len(self.corner_of)), np.diff(self.start))


def divide_voxels(voxels: VoxelModel) -> Division:
    """Division of the wall by its full voxels; their edges are cut at every corner on them.

    Raises
    ------
    InputError
        See :func:`~fd2fem.solids.grid.full_voxels`.
    """
    grid = full_voxels(voxels)
    (i0, j0), (i1, j1) = grid.lower.T, grid.upper.T
    columns, rows = len(grid.x), len(grid.z)
    # Corners sorted by row, so that those on a horizontal edge follow each other; likewise by column.
    by_row = np.unique(
        np.concatenate([j0 * columns + i0, j0 * columns + i1, j1 * columns + i0, j1 * columns + i1])
    )
    corners = np.column_stack([by_row % columns, by_row // columns])
    keys = corners[:, 0] * rows + corners[:, 1]
    order = np.argsort(keys)
    by_column = keys[order]

    def at_row(i: IntArray, j: IntArray) -> IntArray:
        return np.searchsorted(by_row, j * columns + i)

    def at_column(i: IntArray, j: IntArray) -> IntArray:
        return np.searchsorted(by_column, i * rows + j)

    # Each edge as the range of places in one of the two orders, counter-clockwise around the voxel.
    n = len(corners)
    begin = np.column_stack(
        [at_row(i0, j0), n + at_column(i1, j0), at_row(i1, j1) - 1, n + at_column(i0, j1) - 1]
    )
    end = np.column_stack(
        [at_row(i1, j0), n + at_column(i1, j1), at_row(i0, j1) - 1, n + at_column(i0, j0) - 1]
    )
    places, sense, start = _ranges(begin, end)
    used, rings = np.unique(places, return_inverse=True)
    flat = used[used < n]
    upright = used[used >= n] - n
    sides = np.concatenate(
        [np.column_stack([flat, flat + 1]), np.column_stack([order[upright], order[upright + 1]])]
    )
    corner_of = np.column_stack([at_row(i0, j0), at_row(i1, j0), at_row(i1, j1), at_row(i0, j1)])
    return Division(
        points=np.column_stack([grid.x[corners[:, 0]], grid.z[corners[:, 1]]]),
        sides=sides,
        corner_of=corner_of,
        rings=rings.astype(np.intp),
        sense=sense,
        start=start,
        thickness=grid.thickness,
    )


def _ranges(begin: IntArray, end: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Write out ranges (v, 4), the last two of each voxel falling: values, +1 or -1, voxel's start."""
    lengths = np.abs(end - begin).ravel()
    sense = np.repeat(np.tile([1, 1, -1, -1], len(begin)), lengths)
    first = np.repeat(np.cumsum(lengths) - lengths, lengths)
    values = np.repeat(begin.ravel(), lengths) + sense * (np.arange(len(sense)) - first)
    start = np.concatenate([[0], np.cumsum(lengths.reshape(-1, 4).sum(axis=1))])
    return values, sense, start
