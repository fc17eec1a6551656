"""Full voxels to a conformal boundary representation (Appendix A of the paper).

Seen from outside, the wall is a division of the plane into rectangles: their corners, the pieces of
their edges between corners (here "sides"), and the rectangles themselves. Each corner becomes two
keypoints and a line through the wall, each side a line on the front, one on the back and the area
between them, each rectangle an area on the front, one on the back and the volume between them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import SolidModel, VoxelModel
from fd2fem.solids.grid import VoxelGrid, full_voxels

__all__ = ["solid_from_voxels"]

IntArray = NDArray[np.intp]
Ids = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class _Plan:
    """The division of the plane.

    `corners` (c, 2): column and row. `sides` (s, 2): the corners of each side, rightward or upward.
    `corner_of` (v, 4): corners of each voxel, counter-clockwise from the lower left one.
    `rings`: sides of all voxels one after the other, from 0, counter-clockwise; `sense` is -1 where
    a ring runs against the side; voxel i owns `rings[start[i]:start[i + 1]]`.
    """

    corners: IntArray
    sides: IntArray
    corner_of: IntArray
    rings: IntArray
    sense: IntArray
    start: IntArray


def solid_from_voxels(voxels: VoxelModel) -> SolidModel:
    """Boundary representation with one volume for each full voxel.

    Neighbours share their keypoints, lines and areas. Where they differ in size, the larger one's
    edges are cut at every keypoint on them, so that its front and back are loops of more than four
    lines. Coordinates within 1e-7 m of each other are one, and voxels narrower than that vanish.

    Parameters
    ----------
    voxels : VoxelModel
        Only the full ones count.

    Returns
    -------
    solid : SolidModel
        Keypoints: first those of the front, then those of the back. Areas: fronts, backs, sides.

    Raises
    ------
    InputError
        If no voxel is full, one is inverted, or two overlap.

    References
    ----------
    Appendix A of the paper: eight keypoints, twelve lines, six areas and a volume for a voxel; loops
    after the right-hand rule about the outward normal, negative numbers for reversed lines.

    Examples
    --------
    >>> two = VoxelModel([[0, 0], [2, 0]], [[2, 3], [4, 3]], [1, 1], 0.5)
    >>> solid = solid_from_voxels(two)
    >>> len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes)
    (12, 20, 11, 2)
    """
    grid = full_voxels(voxels)
    plan = _divide(grid)
    x, z = grid.x[plan.corners[:, 0]], grid.z[plan.corners[:, 1]]
    front = np.column_stack([x, np.zeros_like(x), z])
    n, s = len(front), len(plan.sides)
    through = np.column_stack([np.arange(n), np.arange(n) + n])
    areas, patches, first = _areas(plan, n, s)
    return SolidModel(
        keypoints=np.concatenate([front, front + np.array([0.0, grid.thickness, 0.0])]),
        lines=np.concatenate([plan.sides, plan.sides + n, through]),
        areas=areas,
        patches=patches,
        volumes=_volumes(plan, first),
    )


def _divide(grid: VoxelGrid) -> _Plan:
    """Cut the edges of the voxels at every corner on them."""
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
    return _Plan(corners, sides, corner_of, rings.astype(np.intp), sense, start)


def _ranges(begin: IntArray, end: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Write out ranges (v, 4), the last two of each voxel falling: values, +1 or -1, voxel's start."""
    lengths = np.abs(end - begin).ravel()
    sense = np.repeat(np.tile([1, 1, -1, -1], len(begin)), lengths)
    first = np.repeat(np.cumsum(lengths) - lengths, lengths)
    values = np.repeat(begin.ravel(), lengths) + sense * (np.arange(len(sense)) - first)
    start = np.concatenate([[0], np.cumsum(lengths.reshape(-1, 4).sum(axis=1))])
    return values, sense, start


def _first_users(plan: _Plan) -> IntArray:
    """Place in `plan.rings` where each side is used first; its area's loop suits that voxel."""
    return np.unique(plan.rings, return_index=True)[1].astype(np.intp)


def _areas(plan: _Plan, n: int, s: int) -> tuple[tuple[Ids, ...], IntArray, IntArray]:
    """Loops and patches of all areas; and for each side's area, where in the rings it is used first.

    Lines count from 1: side k is k + 1 on the front and s + k + 1 on the back, corner c is
    2 s + c + 1 through the wall.
    """
    first = _first_users(plan)
    front = plan.sense * (plan.rings + 1)
    back = -plan.sense * (plan.rings + s + 1)
    bounds = list(zip(plan.start[:-1].tolist(), plan.start[1:].tolist(), strict=True))
    flat, reverse = front.tolist(), back.tolist()
    fronts = [tuple(flat[a:b]) for a, b in bounds]
    backs = [tuple(reverse[a:b][::-1]) for a, b in bounds]

    sense = plan.sense[first]
    # The front area runs p -> q along the side, so the side's own area runs q -> p there.
    p = np.where(sense > 0, plan.sides[:, 0], plan.sides[:, 1])
    q = np.where(sense > 0, plan.sides[:, 1], plan.sides[:, 0])
    side = np.arange(s) + 1
    loops = np.column_stack([-sense * side, 2 * s + p + 1, sense * (s + side), -(2 * s + q + 1)])
    patches = np.concatenate(
        [plan.corner_of, plan.corner_of[:, [0, 3, 2, 1]] + n, np.column_stack([q, p, p + n, q + n])]
    )
    return (*fronts, *backs, *map(tuple, loops.tolist())), patches, first


def _volumes(plan: _Plan, first: IntArray) -> tuple[Ids, ...]:
    """Signed areas of each voxel: front, back, then its sides, negative where it is the second user."""
    v = len(plan.start) - 1
    owned = first[plan.rings] == np.arange(len(plan.rings))
    sides = (np.where(owned, 1, -1) * (2 * v + plan.rings + 1)).tolist()
    bounds = zip(plan.start[:-1].tolist(), plan.start[1:].tolist(), strict=True)
    return tuple((k + 1, v + k + 1, *sides[a:b]) for k, (a, b) in enumerate(bounds))
