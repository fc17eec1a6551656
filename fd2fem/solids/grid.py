"""The full voxels on the irregular grid of their coordinates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import CellState, VoxelModel

__all__ = ["MERGE", "VoxelGrid", "full_voxels", "merged"]

MERGE = 1e-7
"""Coordinates that follow each other within this distance, m, are one: OpenCASCADE's own tolerance."""

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class VoxelGrid:
    """Full voxels by the columns and rows of their corners, so that equal coordinates are equal integers.

    Attributes
    ----------
    x, z : (·,) float arrays, m
        The distinct coordinates, ascending.
    lower, upper : (v, 2) int arrays
        Column and row, in `x` and `z`, of each full voxel's corners.
    thickness : (v,) float array, m
        Of each full voxel.
    """

    x: FloatArray
    z: FloatArray
    lower: IntArray
    upper: IntArray
    thickness: FloatArray


def full_voxels(voxels: VoxelModel) -> VoxelGrid:
    """Take the full voxels, with nearly equal coordinates merged (`MERGE`).

    Voxels narrower than that, which rounding leaves beside a boundary line, vanish.

    Raises
    ------
    InputError
        If no voxel is full, one is inverted, two overlap, or the thickness is not positive.

    Examples
    --------
    >>> grid = full_voxels(VoxelModel([[0, 0], [1 + 1e-9, 0]], [[1, 1], [2, 1]], [1, 1], 0.3))
    >>> grid.x.tolist(), grid.lower.tolist(), grid.upper.tolist()
    ([0.0, 1.0, 2.0], [[0, 0], [1, 0]], [[1, 1], [2, 1]])
    """
    full = voxels.state == CellState.FULL
    lower, upper = voxels.lower[full], voxels.upper[full]
    x, columns = merged(np.concatenate([lower[:, 0], upper[:, 0]]))
    z, rows = merged(np.concatenate([lower[:, 1], upper[:, 1]]))
    low, high = np.split(np.column_stack([columns, rows]), 2)
    inverted = np.flatnonzero((high < low).any(axis=1))
    if len(inverted):
        at = lower[inverted[0]]
        msg = (
            f"{len(inverted)} full voxels end before they begin, the first at x = {at[0]:.6f}, "
            f"z = {at[1]:.6f}: correct their corners."
        )
        raise InputError(msg)
    thick = (high > low).all(axis=1)
    if not thick.any():
        msg = f"None of the {len(voxels.state)} voxels is full: there is no wall to make a solid of."
        raise InputError(msg)
    low, high, lower = low[thick], high[thick], lower[thick]
    _check_apart(low, high, lower)
    return VoxelGrid(x, z, low, high, _thicknesses(voxels.thickness[full][thick], lower))


def _thicknesses(thickness: FloatArray, corner: FloatArray) -> FloatArray:
    """Raise unless all are positive; `corner` (v, 2), m, is for the message."""
    flat = np.flatnonzero(thickness <= MERGE)
    if len(flat):
        x, z = corner[flat[0]]
        msg = (
            f"{len(flat)} full voxels have no thickness, the first, at x = {x:.6f}, z = {z:.6f}, is "
            f"{thickness[flat[0]]:g} m thick: give the wall a positive thickness."
        )
        raise InputError(msg)
    return thickness


def merged(values: FloatArray) -> tuple[FloatArray, IntArray]:
    """Distinct values, ascending, and the index of each given value among them; nearly equal ones are one.

    Examples
    --------
    >>> [part.tolist() for part in merged(np.array([2.0, 1.0, 2.0 + 1e-9]))]
    [[1.0, 2.0], [1, 0, 1]]
    """
    distinct, inverse = np.unique(values, return_inverse=True)
    # A gap starts a new value; rounding to a grid would part neighbours on either side of a half.
    new = np.diff(distinct, prepend=-np.inf) > MERGE
    return distinct[new], (np.cumsum(new) - 1)[inverse].astype(np.intp)


def _check_apart(low: IntArray, high: IntArray, corner: FloatArray) -> None:
    """Raise if two voxels share more than an edge; `corner` (v, 2), m, is for the message."""
    import shapely

    # A quarter of a column less on each side: neighbours no longer touch, overlapping ones still do.
    boxes = shapely.box(*(low + 0.25).T, *(high - 0.25).T)
    one, other = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    pairs = one < other
    if pairs.any():
        a, b = corner[one[pairs][0]], corner[other[pairs][0]]
        msg = (
            f"{int(pairs.sum())} pairs of full voxels overlap, the first at x, z = {a[0]:.6f}, {a[1]:.6f} "
            f"and {b[0]:.6f}, {b[1]:.6f}: divide them anew."
        )
        raise InputError(msg)
