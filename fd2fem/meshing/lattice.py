"""A lattice of macro points on which every edge of a rectilinear wall is a grid line.

Jambs that line up on the drawing differ by millimetres in a scan. A plain partition along all of
them would be full of slivers; here edges closer than a tolerance share a grid line, which passes
through each edge exactly and runs straight from one to the next.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.options import divisions
from fd2fem.meshing.walls import WallRings

__all__ = ["Lattice", "build_lattice", "count_divisions", "fill_runs"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

ON_LEVEL = 1e-9
"""An edge this close to a storey's level, m, lies on it."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """Macro points (column, row) and the macro cells between them.

    Attributes
    ----------
    points : (c, r, 2) float array, m
        x, z of each macro point; those on an edge of the wall lie on it exactly.
    columns, rows : (c,) and (r,) float arrays, m
        Mean position of each grid line, rising.
    wall : (c - 1, r - 1) bool array
        Which macro cells are wall.
    """

    points: FloatArray
    columns: FloatArray
    rows: FloatArray
    wall: BoolArray

    def min_scaled_jacobian(self) -> float:
        """Worst corner of the wall's macro cells.

        A transfinite grid on a cell with straight edges has no worse corner: its tangents lie between
        those of the cell's edges, and the sine is concave up to π.
        """
        p = self.points
        ring = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], axis=2)[self.wall]
        after, before = np.roll(ring, -1, axis=1) - ring, np.roll(ring, 1, axis=1) - ring
        area = after[..., 0] * before[..., 1] - after[..., 1] * before[..., 0]
        return float((area / np.linalg.norm(after, axis=2) / np.linalg.norm(before, axis=2)).min())


@dataclass(frozen=True, eq=False)
class _Edges:
    """Edges of one direction: their `position`, and the two edges of the other direction at their `ends`."""

    position: FloatArray
    ends: IntArray

    @property
    def differ(self) -> BoolArray:
        unequal: BoolArray = self.position[:, None] != self.position[None, :]
        return unequal


def build_lattice(rings: WallRings, *, tolerance: float, levels: Sequence[float] = ()) -> Lattice:
    """Lattice of a rectilinear wall.

    Edges up to `tolerance` apart (m) share a grid line, closest first, unless they would meet on it at
    different places: then a point would have to be in two places at once. Grid lines are intervals of
    position, so their order is that of the edges. 0 gives the plain partition along every edge.

    Parameters
    ----------
    rings : WallRings
        With horizontal and vertical edges only.
    tolerance : float, m
    levels : sequence of float, m
        Heights of grid lines that are level all along the wall: none but edges just there share them.
    """
    vertical, horizontal = _edges(rings)
    heights = np.r_[horizontal.position, _on_edges(levels, horizontal.position)]
    edges = len(horizontal.position)
    # Rows first. Edges of one row that do not overlap stay that way: the jambs at their ends meet on
    # that row, which keeps these on different columns. A level overlaps all edges.
    overlap = heights[:, None] != heights[None, :]
    overlap[:edges, :edges] &= _touching(vertical.position[horizontal.ends])
    every_row = _cluster(heights, conflict=overlap, tolerance=tolerance)
    row = every_row[:edges]
    meet = vertical.differ & _touching(row[vertical.ends])
    column = _cluster(vertical.position, conflict=meet, tolerance=tolerance)
    columns, rows = _means(vertical.position, column), _means(heights, every_row)
    x = _pass_through(vertical.position, column, row[vertical.ends], across=rows, lines=len(columns))
    throughout = np.broadcast_to([0, len(columns) - 1], (len(levels), 2))
    spans = np.vstack([column[horizontal.ends], throughout])
    z = _pass_through(heights, every_row, spans, across=columns, lines=len(rows))
    wall = _wall_cells(rings, column, row)
    return Lattice(points=np.stack([x, z.T], axis=2), columns=columns, rows=rows, wall=wall)


def _on_edges(levels: Sequence[float], heights: FloatArray) -> FloatArray:
    """The levels, those within rounding of an edge just on it."""
    snapped = np.array(levels, dtype=np.float64)
    for k, level in enumerate(levels):
        nearest = heights[np.abs(heights - level).argmin()]
        if abs(nearest - level) < ON_LEVEL:
            snapped[k] = nearest
    return snapped


def _edges(rings: WallRings) -> tuple[_Edges, _Edges]:
    """Vertical and horizontal edges; in a ring the k-th horizontal one comes before the k-th vertical one."""
    x, z, vertical_ends, horizontal_ends = [], [], [], []
    start = 0
    for ring in map(_horizontal_first, rings.all):
        k = np.arange(len(ring) // 2)
        following, preceding = np.roll(k, -1), np.roll(k, 1)
        z.append(ring[0::2, 1])
        x.append(ring[1::2, 0])
        vertical_ends.append(start + np.column_stack([k, following]))
        horizontal_ends.append(start + np.column_stack([preceding, k]))
        start += len(k)
    return (
        _Edges(np.concatenate(x), np.concatenate(vertical_ends)),
        _Edges(np.concatenate(z), np.concatenate(horizontal_ends)),
    )


def _horizontal_first(ring: FloatArray) -> FloatArray:
    """Let the ring start with a horizontal edge."""
    return ring if ring[0, 1] == ring[1, 1] else np.roll(ring, -1, axis=0)


def _touching(ends: NDArray[np.float64] | IntArray) -> BoolArray:
    """Which pairs of intervals, (e, 2) ends in any order, share at least a point."""
    low, high = ends.min(axis=1), ends.max(axis=1)
    shared: BoolArray = (low[:, None] <= high[None, :]) & (low[None, :] <= high[:, None])
    return shared


def _cluster(position: FloatArray, *, conflict: BoolArray, tolerance: float) -> IntArray:
    """Number of the grid line, in rising order, of each edge: complete linkage, closest neighbours first."""
    values = np.unique(position)
    groups = [np.flatnonzero(position == value) for value in values]

    def spread(left: IntArray, right: IntArray) -> float:
        """Width of two neighbours made one; infinite where they must stay apart."""
        width = float(position[right].max() - position[left].min())
        return np.inf if width > tolerance or conflict[np.ix_(left, right)].any() else width

    spreads = [spread(left, right) for left, right in pairwise(groups)]
    while spreads and min(spreads) < np.inf:
        k = int(np.argmin(spreads))
        groups[k : k + 2] = [np.concatenate(groups[k : k + 2])]
        del spreads[k]
        for j in {k - 1, k} & set(range(len(spreads))):
            spreads[j] = spread(groups[j], groups[j + 1])
    label = np.empty(len(position), dtype=np.intp)
    for number, group in enumerate(groups):
        label[group] = number
    return label


def _means(position: FloatArray, label: IntArray) -> FloatArray:
    """Mean position of each grid line."""
    return np.bincount(label, weights=position) / np.bincount(label)


def _pass_through(
    position: FloatArray, line: IntArray, span: IntArray, *, across: FloatArray, lines: int
) -> FloatArray:
    """Coordinates (lines, across) of grid lines that follow their edges and run straight between them."""
    fixed = np.full((lines, len(across)), np.nan)
    for value, index, (start, end) in zip(position, line, np.sort(span, axis=1), strict=True):
        fixed[index, start : end + 1] = value
    for row in fixed:
        known = ~np.isnan(row)
        row[~known] = np.interp(across[~known], across[known], row[known])
    return fixed


def _wall_cells(rings: WallRings, column: IntArray, row: IntArray) -> BoolArray:
    """Which macro cells lie inside the outer ring and outside the holes."""
    import shapely

    loops, start = [], 0
    for ring in rings.all:
        k = start + np.arange(len(ring) // 2)
        following = np.roll(k, -1)
        corners = np.stack([column[k], row[k], column[k], row[following]], axis=1)
        loops.append(corners.reshape(-1, 2))
        start += len(k)
    wall = shapely.Polygon(loops[0], loops[1:])
    centre_x, centre_z = np.meshgrid(np.arange(column.max()) + 0.5, np.arange(row.max()) + 0.5, indexing="ij")
    inside: BoolArray = shapely.contains_xy(wall, centre_x, centre_z)
    return inside


def count_divisions(lattice: Lattice, *, size: float, pier_elements: int) -> tuple[IntArray, IntArray]:
    """Elements along each macro column and row.

    About `size` (m) long each; then, wherever a run of wall from void to void is still fewer than
    `pier_elements` across, the widest of its columns (rows) get one more.
    """
    columns = _count(np.diff(lattice.columns), lattice.wall.T, size=size, least=pier_elements)
    rows = _count(np.diff(lattice.rows), lattice.wall, size=size, least=pier_elements)
    return columns, rows


def _count(widths: FloatArray, lines: BoolArray, *, size: float, least: int) -> IntArray:
    """Elements along each of `widths`; `lines` are rows of cells along them."""
    count = np.array([divisions(width, size) for width in widths], dtype=np.intp)
    fill_runs(count, widths, lines, least=least)
    return count


def fill_runs(count: IntArray, widths: FloatArray, lines: BoolArray, *, least: int) -> None:
    """Raise `count`, elements along each of `widths`, until each run of wall in `lines` has `least`."""
    runs = {run for line in lines for run in _runs(line)}
    for start, end in sorted(runs, key=lambda run: (run[1] - run[0], run)):
        while count[start:end].sum() < least:
            count[start + int(np.argmax(widths[start:end] / count[start:end]))] += 1


def _runs(line: BoolArray) -> list[tuple[int, int]]:
    """Start and end of each run of wall."""
    change = np.flatnonzero(np.diff(np.r_[False, line, False].astype(np.int8)))
    return [(int(start), int(end)) for start, end in change.reshape(-1, 2)]
