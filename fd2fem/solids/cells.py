"""The wall divided into convex quadrilaterals that meet along whole edges."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import WallCells
from fd2fem.solids.division import Division
from fd2fem.solids.grid import MERGE

__all__ = ["divide_cells"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

SHRINK = 1e-6
"""Cells overlap if they still do when each is smaller by this part."""


def divide_cells(cells: WallCells) -> Division:
    """Division of the wall by its cells.

    Raises
    ------
    InputError
        If there is no cell, one is not convex or not counter-clockwise, two overlap or meet along a part of
        an edge only.
    """
    if len(cells.corners) == 0:
        msg = "There are no cells: there is no wall to make a solid of."
        raise InputError(msg)
    used, corners = np.unique(cells.corners, return_inverse=True)
    points, corners = cells.points[used], corners.reshape(-1, 4).astype(np.intp)
    _check_convex(points[corners])
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    sides, inverse = np.unique(np.sort(np.column_stack([start, end])), axis=0, return_inverse=True)
    rings = inverse.ravel().astype(np.intp)  # some releases of NumPy keep an axis more
    sense = np.where(start < end, 1, -1)
    _check_edges(points[start], rings, sense)
    _check_whole_edges(points, sides)
    _check_apart(points[corners])
    return Division(
        points=points,
        sides=sides,
        corner_of=corners,
        rings=rings,
        sense=sense,
        start=np.arange(len(corners) + 1) * 4,
        thickness=cells.thickness,
    )


def _check_convex(quads: FloatArray) -> None:
    """Raise unless each corner of quads (c, 4, 2) lies on the right of the line from its last to its next."""
    ahead, back = np.roll(quads, -1, axis=1), np.roll(quads, 1, axis=1)
    chord, arm = ahead - back, quads - back
    chord_length = np.linalg.norm(chord, axis=2)
    doubled = chord[..., 1] * arm[..., 0] - chord[..., 0] * arm[..., 1]
    bad = np.flatnonzero((doubled <= MERGE * chord_length).any(axis=1))
    if len(bad):
        msg = (
            f"{len(bad)} cells are not convex quadrilaterals, counter-clockwise seen from outside, the first "
            f"{_where(quads[bad[0]].mean(axis=0))}: correct or divide them."
        )
        raise InputError(msg)


def _check_edges(begin: FloatArray, rings: IntArray, sense: IntArray) -> None:
    """Raise if two cells use a side in the same sense; `begin` (r, 2), m, is for the message."""
    _, index, count = np.unique(2 * rings + (sense > 0), return_index=True, return_counts=True)
    if (count > 1).any():
        at = begin[index[count > 1][0]]
        msg = (
            f"Cells overlap: two lie on the same side of the edge that begins {_where(at)}; divide them anew."
        )
        raise InputError(msg)


def _check_whole_edges(points: FloatArray, sides: IntArray) -> None:
    """Raise if a corner lies on a side between its ends, or on another corner."""
    import shapely

    corners: NDArray[np.object_] = np.asarray(shapely.points(points))
    tree = shapely.STRtree(corners)
    lines = shapely.linestrings(points[sides])
    side, corner = tree.query(lines, predicate="dwithin", distance=MERGE)
    stray = np.flatnonzero((sides[side] != corner[:, None]).all(axis=1))
    if len(stray):
        msg = (
            f"Cells do not meet along whole edges: {len(stray)} corners lie on others' edges, the first "
            f"{_where(points[corner[stray[0]]])}; divide the cells there."
        )
        raise InputError(msg)


def _check_apart(quads: FloatArray) -> None:
    """Raise if two of the quads (c, 4, 2) overlap."""
    import shapely

    centre = quads.mean(axis=1, keepdims=True)
    # A little smaller, neighbours no longer touch, overlapping ones still do.
    shapes = shapely.polygons(centre + (1.0 - SHRINK) * (quads - centre))
    one, other = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    pairs = np.flatnonzero(one < other)
    if len(pairs):
        a, b = centre[one[pairs[0]], 0], centre[other[pairs[0]], 0]
        msg = f"{len(pairs)} pairs of cells overlap, the first {_where(a)} and {_where(b)}: divide them anew."
        raise InputError(msg)


def _where(point: FloatArray) -> str:
    return f"at x = {point[0]:.6f}, z = {point[1]:.6f}"
