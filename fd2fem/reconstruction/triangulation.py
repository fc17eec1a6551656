"""The long-edged triangles of a Delaunay triangulation, without triangulating everything.

The circumcircle of a triangle with a side longer than L holds no point, and its radius is over L/2. So the
disc of radius L/2 that touches it from within at one of the triangle's corners is empty too, and a grid shows
where such discs can lie:

1. A cell is *clear* when the cells that lie within L/2 of every place in it hold no point. The centre of
   an empty disc of radius L/2 always lies in a clear cell.
2. So every corner of a long triangle lies within L/2 of a clear cell. The points that do are the candidates,
   and only they are triangulated.
3. A long triangle of the candidates is one of all points exactly if the centre of the disc that touches its
   circumcircle at a corner lies in a clear cell. If it does not, a point that was left out lies in
   the disc, and so in the circumcircle. If it does, the disc is empty, since every point near it is a
   candidate; and if it is blown up until it fills the circumcircle, the first point it met
   would be a candidate as well, of which a circumcircle holds none.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from fd2fem.errors import ReconstructionError

__all__ = ["LongTriangles", "bounds", "long_triangles", "side_lengths", "triangle_areas"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class _Raster:
    """How a disc of radius L/2 is made up of cells.

    Attributes
    ----------
    radius : float
        L/2 in cells.
    within : tuple of (int, int)
        Blocks of cells about a cell, so many columns and rows to each side, that lie within L/2 of every
        place in it.
    about : tuple of (int, int)
        Blocks that together hold all cells within L/2 of any place in it.
    """

    radius: float
    within: tuple[tuple[int, int], ...]
    about: tuple[tuple[int, int], ...]


COARSE = _Raster(float(np.sqrt(13.0)), within=((1, 2), (2, 1)), about=((3, 4), (4, 3)))
FINE = _Raster(
    float(np.sqrt(52.0)),
    within=((0, 6), (3, 5), (4, 4), (5, 3), (6, 0)),
    about=((2, 8), (5, 7), (6, 6), (7, 5), (8, 2)),
)
DENSE = 1.0
"""With more points in a coarse cell, fine ones pay: fewer points lie near the clear ones."""
MARGIN = 0.999
"""Cells are so much smaller than they could be, which keeps rounding errors and points on circles out."""
PAD = 16
"""Cells around the wall; discs about its hull reach so far."""
CHUNK = 1 << 17
"""Points put into cells at a time."""
FLAT = 1e-10
"""Triangles lower than this share of their longest side are lines that rounding errors left on the hull."""


@dataclass(frozen=True, eq=False)
class LongTriangles:
    """Triangles with a side longer than a length, out of the triangulation of a wall's points.

    Attributes
    ----------
    corners : (t, 3) int array
        Indices into the wall's points, counter-clockwise.
    neighbours : (t, 3) int array
        The one of these triangles across the side opposite to each corner; -1 where that is a short one,
        or none.
    on_hull : (t, 3) bool array
        Whether that side lies on the convex hull.
    hull : (h,) int array
        Sorted indices of the points on the convex hull.
    """

    corners: IntArray
    neighbours: IntArray
    on_hull: BoolArray
    hull: IntArray

    def subset(self, chosen: BoolArray) -> "LongTriangles":
        """Some of the triangles; those left out are no longer anyone's neighbours."""
        number = np.append(np.where(chosen, np.cumsum(chosen) - 1, -1), -1)
        return LongTriangles(
            corners=self.corners[chosen],
            neighbours=number[self.neighbours[chosen]].astype(np.intp),
            on_hull=self.on_hull[chosen],
            hull=self.hull,
        )


def long_triangles(xz: FloatArray, length: float) -> LongTriangles:
    """Triangles of the Delaunay triangulation with a side longer than a length, and the convex hull.

    Parameters
    ----------
    xz : (n, 2) float array, m
        Points without duplicates.
    length : float, m

    Returns
    -------
    LongTriangles
        The same as out of a triangulation of all points, but for the choice among points on one circle.

    Raises
    ------
    ReconstructionError
        If the points lie on one line, or so far from the origin that rounding errors merge them.

    Examples
    --------
    >>> grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0), indexing="ij"), axis=-1).reshape(-1, 2)
    >>> holed = grid[~((grid > 5.0) & (grid < 10.0)).all(axis=1)]
    >>> long = long_triangles(holed, 1.5)  # the short diagonals cut off the corners of the 5 x 5 gap
    >>> float(triangle_areas(holed[long.corners]).sum()), len(long.hull)
    (23.0, 76)
    """
    grid = _clear_cells(xz, length)
    used = np.arange(len(xz)) if grid is None else grid.candidates
    local = xz[used] - xz[0]  # digits: Qhull loses points that lie far from the origin
    triangulation = _triangulate(local)
    triangles = triangulation.simplices
    # Side k lies opposite to corner k, as the neighbours do.
    longest = side_lengths(local, triangles).max(axis=1)
    chosen = longest > length
    flat = chosen.copy()
    flat[chosen] = 2.0 * triangle_areas(local[triangles[chosen]]) < FLAT * longest[chosen] ** 2
    chosen &= ~flat
    if grid is not None:
        chosen[chosen] = grid.is_clear(xz[0] + _touching_discs(local[triangles[chosen]], length / 2.0))
    everything = LongTriangles(
        corners=used[triangles],
        neighbours=triangulation.neighbors.astype(np.intp),
        on_hull=np.append(flat, True)[triangulation.neighbors],
        hull=np.unique(used[triangulation.convex_hull]),
    )
    return everything.subset(chosen)


def bounds(xz: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest coordinates (2,), m, of points (n, 2), m."""
    # Column by column: numpy takes five times as long along the short axis.
    columns = xz[:, 0], xz[:, 1]
    return np.array([c.min() for c in columns]), np.array([c.max() for c in columns])


def side_lengths(xz: FloatArray, triangles: IntArray) -> FloatArray:
    """Lengths (t, 3), m, of the sides of triangles; side k lies opposite to corner k."""
    corners = xz[triangles]
    sides = corners[:, [1, 2, 0]] - corners[:, [2, 0, 1]]
    return np.hypot(sides[..., 0], sides[..., 1])


def triangle_areas(corners: FloatArray) -> FloatArray:
    """Areas, m², of (t, 3, 2) triangles."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area: FloatArray = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    return area


@dataclass(frozen=True, eq=False)
class _Cells:
    """Square cells over a wall, column after column in one array.

    The columns are padded, so that a step past the end of one lands in the padding of the next.
    """

    low: FloatArray
    size: float
    rows: int

    def number(self, places: FloatArray) -> IntArray:
        """Number of the cell that each of (m, 2) places lies in."""
        index = ((places - self.low) * (1.0 / self.size) + PAD).astype(np.intp)
        number: IntArray = index[:, 0] * self.rows + index[:, 1]
        return number


@dataclass(frozen=True, eq=False)
class _Clear:
    """The clear cells, and the points near them."""

    cells: _Cells
    clear: BoolArray
    candidates: IntArray

    def is_clear(self, places: FloatArray) -> BoolArray:
        """Whether each of (m, 2) places lies in a clear cell."""
        return self.clear[self.cells.number(places)]


def _clear_cells(xz: FloatArray, length: float) -> _Clear | None:
    """The clear cells and the points near them; ``None`` where the points are too sparse for it to pay."""
    low, high = bounds(xz)
    coarse = MARGIN * length / 2.0 / COARSE.radius
    raster = FINE if len(xz) * coarse**2 > DENSE * (high - low).prod() else COARSE
    size = MARGIN * length / 2.0 / raster.radius
    columns, rows = np.floor((high - low) / size) + 1 + 2 * PAD
    if columns * rows > 4_000_000 + 32 * len(xz):
        return None
    cells = _Cells(low, size, int(rows))
    number = np.empty(len(xz), dtype=np.int32)
    # Piece by piece, so that the coordinates are not copied as a whole.
    for start in range(0, len(xz), CHUNK):
        number[start : start + CHUNK] = cells.number(xz[start : start + CHUNK])
    occupied = np.zeros(int(columns) * int(rows), dtype=np.bool_)
    occupied[number] = True
    clear = ~_spread_blocks(occupied, int(rows), raster.within)
    near = _spread_blocks(clear, int(rows), raster.about)
    return _Clear(cells, clear, np.flatnonzero(near[number]))


def _spread_blocks(cells: BoolArray, rows: int, blocks: tuple[tuple[int, int], ...]) -> BoolArray:
    """Spread marked cells to blocks about them, each so many columns and rows to each side."""
    spread = np.zeros_like(cells)
    wide, done = cells, 0
    # The blocks come with more and more columns.
    for columns, high in blocks:
        wide, done = _spread(wide, columns - done, rows), columns
        spread |= _spread(wide, high, 1)
    return spread


def _spread(cells: BoolArray, reach: int, step: int) -> BoolArray:
    """Mark the `reach` cells before and after each marked one, `step` apart."""
    spread, done = cells.copy(), 0
    while done < reach:
        # What is marked so far, moved to where it goes on without a gap.
        more = min(2 * done + 1, reach - done)
        shift, marked = more * step, spread.copy()
        spread[shift:] |= marked[:-shift]
        spread[:-shift] |= marked[shift:]
        done += more
    return spread


def _touching_discs(corners: FloatArray, radius: float) -> FloatArray:
    """Centres (t, 2) of the discs that touch the circumcircles of triangles from within at corner 0."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double = 2.0 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    squares = (first**2).sum(axis=1), (second**2).sum(axis=1)
    centre = np.column_stack(
        [
            second[:, 1] * squares[0] - first[:, 1] * squares[1],
            first[:, 0] * squares[1] - second[:, 0] * squares[0],
        ]
    )
    # The sign is all that is needed of the area: circles through nearly collinear points stay finite.
    away: FloatArray = centre * (np.sign(double) / np.hypot(centre[:, 0], centre[:, 1]))[:, None]
    return corners[:, 0] + radius * away


def _triangulate(local: FloatArray) -> Delaunay:
    """Delaunay triangulation of points near the origin, all of them used."""
    try:
        triangulation = Delaunay(local - local.mean(axis=0))
    except (QhullError, ValueError) as error:
        reason = str(error).split("\n", 1)[0]
        msg = f"The wall's points cannot be triangulated ({reason}): they may lie on one line."
        raise ReconstructionError(msg) from error
    if len(triangulation.coplanar) > 0.001 * len(local):
        msg = (
            f"The triangulation left out {len(triangulation.coplanar)} of {len(local)} points: "
            "the coordinates lack precision."
        )
        raise ReconstructionError(msg)
    return triangulation
