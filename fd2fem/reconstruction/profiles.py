"""How far a wall reaches, looked at from one side: its skyline from above, its ends from left and right.

The wall is laid out in cells about three spacings wide. A cell is wall if it holds a fair share of the points
that it would on the wall; so strays and single ragged points say nothing. Looked at from one side, the
outermost cell of each column gives its reach, to be refined by the points in it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.model import Side, SpacingGrid

__all__ = ["Profile", "WallCells", "outermost", "piecewise_lines", "profile", "rim", "wall_cells"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]
Hidden = Callable[[FloatArray], BoolArray]

CELL = 3.0
"""Width of a cell in point spacings."""
SPARSEST = 0.9
"""Cells are large enough for so much of the wall."""
MOST_CELLS = 600
"""Along the wall's longer side; larger walls have larger cells."""
SHARE = 0.3
"""A cell is wall from such a share of the points that a cell of wall holds."""
DEEP = 3
"""A column's reach is that of its third point from outside: up to two may be strays."""
PROBES = (1.0, 2.0, 3.0, 4.0, 6.0)
"""A reach is unknown when something hides a place so many spacings further out."""


@dataclass(frozen=True, eq=False)
class WallCells:
    """The wall as cells.

    Attributes
    ----------
    origin : (2,) float array, m
        Lower left corner of the first cell.
    size : float, m
    wall : (columns, rows) bool array
        Cells with points enough, or inside a gap that is known to be no end of the wall.
    cell : (n,) int array
        Number of each point's cell, column by column.
    """

    origin: FloatArray
    size: float
    wall: BoolArray
    cell: IntArray


@dataclass(frozen=True, eq=False)
class Profile:
    """How far the wall reaches outwards, column by column.

    Attributes
    ----------
    along : (c,) float array, m
        Middle of each column: x, looked at from above or below; z, from left or right.
    reach : (c,) float array, m
        Coordinate of the end, with its sign turned for the left and the bottom so that it grows outwards.
        Lies inside the edge by about a spacing.
    known : (c,) bool array
        False where the column has no wall or something hides its end.
    least : (c,) float array, m
        The same where something hides the end: the wall reaches at least so far. Minus infinity where the
        column has no wall.
    """

    along: FloatArray
    reach: FloatArray
    known: BoolArray
    least: FloatArray


def wall_cells(
    xz: FloatArray, spacing: float, gaps: list[FloatArray], *, grid: SpacingGrid | None = None
) -> WallCells:
    """Lay cells over a wall and tell which are wall.

    Parameters
    ----------
    xz : (n, 2) float array, m
    spacing : float, m
        Typical of the wall.
    gaps : list of (k, 2) float arrays, m
        Outlines of openings and of filled occlusions.
    grid : SpacingGrid or None
        The local spacing, where it was measured.
    """
    if grid is not None:
        spacing = max(spacing, float(np.quantile(grid.spacing, SPARSEST)))
    # Column by column: numpy is slow along the first axis of a narrow array.
    low, high = (np.array([end(xz[:, 0]), end(xz[:, 1])]) for end in (np.min, np.max))
    size = max(CELL * spacing, float((high - low).max()) / MOST_CELLS)
    origin = low - 2.0 * size
    shape = np.ceil((high - low) / size).astype(np.intp) + 4
    column, row = (((xz[:, axis] - origin[axis]) / size).astype(np.intp) for axis in (0, 1))
    cell = column * shape[1] + row
    counts = np.bincount(cell, minlength=int(shape.prod()))
    typical = _typical(counts, origin, size, shape, grid)
    wall = (counts >= np.maximum(2.0, SHARE * typical)).reshape(shape)
    for ring in gaps:
        first = np.maximum(np.floor((ring.min(axis=0) - origin) / size).astype(np.intp), 0)
        last = np.minimum(np.ceil((ring.max(axis=0) - origin) / size).astype(np.intp), shape)
        if (last <= first).any():
            continue
        x, z = (origin[axis] + (np.arange(first[axis], last[axis]) + 0.5) * size for axis in (0, 1))
        block = wall[first[0] : last[0], first[1] : last[1]]
        block |= shapely.contains_xy(shapely.Polygon(ring), *np.meshgrid(x, z, indexing="ij"))
    label, _ = ndimage.label(ndimage.binary_dilation(wall, np.ones((3, 3), dtype=bool)), np.ones((3, 3)))
    sizes = np.bincount(label.ravel())
    sizes[0] = 0
    wall &= label == int(np.argmax(sizes))
    return WallCells(origin, size, wall, cell)


def _typical(
    counts: IntArray, origin: FloatArray, size: float, shape: IntArray, grid: SpacingGrid | None
) -> FloatArray:
    """How many points a cell of wall holds, cell by cell."""
    if grid is None:
        return np.full(len(counts), float(np.quantile(counts[counts > 0], 0.6)))
    x, z = (origin[axis] + (np.arange(shape[axis]) + 0.5) * size for axis in (0, 1))
    middles = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    typical: FloatArray = (size / grid.spacing_at(middles)) ** 2
    return typical


def rim(cells: WallCells, depth: float) -> BoolArray:
    """Whether each point (n,) lies less than a depth, m, inside the wall's outer edge, or outside of it."""
    label, _ = ndimage.label(~cells.wall)
    # The first cell lies outside; what is not connected to it is a gap in the wall.
    inner = ndimage.binary_erosion(
        label != label[0, 0], np.ones((3, 3)), iterations=int(np.ceil(depth / cells.size))
    )
    near: BoolArray = ~inner.ravel()[cells.cell]
    return near


def profile(xz: FloatArray, cells: WallCells, side: Side, spacing: float, hidden: Hidden | None) -> Profile:
    """How far the wall reaches towards one side."""
    axis = 0 if side.vertical else 1
    sign = 1.0 if side in {Side.RIGHT, Side.TOP} else -1.0
    shape = cells.wall.shape
    # Turned so that the second axis runs outwards.
    wall = cells.wall.T if axis == 0 else cells.wall
    wall = wall if sign > 0 else wall[:, ::-1]
    any_wall = wall.any(axis=1)
    end = wall.shape[1] - 1 - np.argmax(wall[:, ::-1], axis=1)
    border = np.zeros_like(wall)
    for beside in (-1, 0, 1):
        border[np.arange(len(end)), np.clip(end + beside, 0, wall.shape[1] - 1)] = any_wall
    back = border if sign > 0 else border[:, ::-1]
    back = back.T if axis == 0 else back
    near = np.flatnonzero(back.ravel()[cells.cell])
    column = np.stack(np.divmod(cells.cell[near], shape[1]))[1 - axis]
    _, first, third = outermost(column, sign * xz[near, axis], len(end), DEEP)
    along = cells.origin[1 - axis] + (np.arange(len(end)) + 0.5) * cells.size
    reach = np.where(np.isfinite(third), third, first)
    known = any_wall & np.isfinite(reach)
    # Where a gap reaches the outermost cell, no points show the end.
    known &= ~np.isfinite(reach) | (np.abs(reach - _cell_reach(cells, end, axis, sign)) < 2.0 * cells.size)
    least = np.where(known, reach, -np.inf)
    if hidden is not None:
        for step in PROBES:
            out = sign * (np.where(known, first, 0.0) + step * spacing)
            known &= ~hidden(np.column_stack([out, along] if axis == 0 else [along, out]))
    return Profile(along, np.where(known, reach, 0.0), known, least)


def _cell_reach(cells: WallCells, end: IntArray, axis: int, sign: float) -> FloatArray:
    """Outer side of the outermost cell, m, growing outwards."""
    count = cells.wall.shape[axis]
    index = end + 1 if sign > 0 else count - end - 1
    reach: FloatArray = sign * (cells.origin[axis] + index * cells.size)
    return reach


def outermost(
    column: IntArray, value: FloatArray, count: int, deep: int
) -> tuple[IntArray, FloatArray, FloatArray]:
    """The highest few points of each column.

    Parameters
    ----------
    column : (n,) int array
    value : (n,) float array, m
    count : int
        Number of columns.
    deep : int
        How many points of each.

    Returns
    -------
    kept : (m,) int array
        Indices of these points.
    first, last : (count,) float arrays, m
        The highest and the lowest of each column's; minus infinity for a column without points.

    Examples
    --------
    >>> column, value = np.array([0, 0, 0, 1]), np.array([1.0, 3.0, 2.0, 5.0])
    >>> outermost(column, value, 3, 2)
    (array([1, 3, 2]), array([  3.,   5., -inf]), array([  2.,   5., -inf]))
    """
    kept, left = [], np.arange(len(value))
    first = last = np.full(count, -np.inf)
    for number in range(deep):
        top = np.full(count, -np.inf)
        np.maximum.at(top, column[left], value[left])
        first = top if number == 0 else first
        last = np.where(np.isfinite(top), top, last)
        taken = value[left] == top[column[left]]
        kept.append(left[taken])
        left = left[~taken]
    return np.concatenate(kept), first, last


def piecewise_lines(
    along: FloatArray, reach: FloatArray, weight: FloatArray, *, sigma: float, least: int, price: float
) -> list[tuple[int, int]]:
    """Divide a profile into pieces that straight lines fit, by dynamic programming.

    The sum of squared residuals over sigma² plus a price for each piece is least among all divisions.

    Parameters
    ----------
    along, reach : (c,) float arrays, m
    weight : (c,) float array
        0 for columns that say nothing.
    sigma : float, m
        Deviation from a line that is no feature.
    least : int
        Fewest columns of a piece.
    price : float
        Of a piece.

    Returns
    -------
    list of (start, stop)
        Columns of each piece, from the left.

    Examples
    --------
    >>> x = np.arange(20.0)
    >>> piecewise_lines(x, np.where(x < 10, 5.0, 7.0), np.ones(20), sigma=0.1, least=3, price=30)
    [(0, 10), (10, 20)]
    """
    count = len(along)
    x = along - along.mean()
    z = reach - np.average(reach, weights=np.maximum(weight, 1e-12))
    sums = [
        np.concatenate([[0.0], np.cumsum(weight * term)])
        for term in (np.ones(count), x, z, x * x, x * z, z * z)
    ]
    cost, back = np.full(count + 1, np.inf), np.zeros(count + 1, dtype=np.intp)
    cost[0] = 0.0
    for stop in range(min(least, count), count + 1):
        start = np.arange(0, stop - min(least, count) + 1)
        total, sx, sz, sxx, sxz, szz = (term[stop] - term[start] for term in sums)
        total = np.maximum(total, 1e-12)
        spread = np.maximum(sxx - sx * sx / total, 1e-12)
        residual = np.maximum(szz - sz * sz / total - (sxz - sx * sz / total) ** 2 / spread, 0.0)
        whole = cost[start] + residual / sigma**2 + price
        best = int(np.argmin(whole))
        cost[stop], back[stop] = whole[best], start[best]
    pieces, stop = [], count
    while stop > 0:
        pieces.append((int(back[stop]), stop))
        stop = int(back[stop])
    return pieces[::-1]
