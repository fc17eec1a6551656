"""Where the rays that missed the wall cross its face: the evidence that tells an opening from a shadow.

A scanner at s that measured a point p before the wall sees nothing of the wall at the place where the ray
from s through p meets it::

    p_wall = s + (p - s) s_y / (s_y - p_y)

The same formula gives, for a point behind the wall, the place where its ray passed. So no prior knowledge of
cars, trees or panels is needed: whatever they are, their points say what they hide.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.model import FacadePoints, PointCloud, RayMap
from fd2fem.reconstruction.relief import facade_depth

__all__ = ["Shadows", "cast_shadows", "is_hidden", "ray_map", "rows_in_the_light", "throw"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

RAY_CELL = 3.0
"""Edge of the cells in point spacings: rows of a scan may lie twice as far apart as its points."""
FINEST = 0.02
"""Smallest cell, m: with noise and mixed pixels, rays are not known better."""
SHALLOW = 0.6
"""Reveals, frames and glass lie at most so far behind the face, and attached things so far before it, m."""
PANE = 0.5
"""Of a pane so wide, m, only the frame may return rays."""
CHUNK = 500_000
"""Points handled at a time, so that memory grows with the wall and not with the scan."""


def throw(away: FloatArray, scanner: FloatArray) -> FloatArray:
    """Where the rays from a scanner to points cross the wall's plane.

    Parameters
    ----------
    away : (n, 3) float array, m
        Points, facade frame.
    scanner : (3,) float array, m
        Before the wall (y < 0).

    Returns
    -------
    (n, 2) float array, m
        x and z; NaN for points that lie no farther into the scene than the scanner.

    Examples
    --------
    >>> throw(np.array([[1.0, -5.0, 2.0]]), np.array([0.0, -10.0, 1.0])).tolist()
    [[2.0, 3.0]]
    """
    run = away[:, 1] - scanner[1]
    share = np.divide(-scanner[1], run, out=np.full(len(run), np.nan), where=run > 1e-6)
    crossing: FloatArray = scanner[[0, 2]] + share[:, None] * (away[:, [0, 2]] - scanner[[0, 2]])
    return crossing


def ray_map(cloud: PointCloud, points: FacadePoints) -> RayMap:
    """Count, cell by cell of the wall's face, what was seen before it, behind it and through it.

    Parameters
    ----------
    cloud : PointCloud
        The scan that `points` come from.
    points : FacadePoints

    Returns
    -------
    RayMap
    """
    low, high = points.xz.min(axis=0), points.xz.max(axis=0)
    if points.ground is not None:
        # Cars may hide the foot of the wall from end to end.
        low[1] = min(low[1], points.ground)
    cell = max(RAY_CELL * points.spacing, FINEST)
    # Counted from the middle of all points, the cells hardly move with a stray one more or less.
    middle = points.xz.mean(axis=0)
    low = middle - cell * np.ceil((middle - low) / cell + 1.0)
    raster = _Raster(low, cell, tuple(np.ceil((high - low) / cell).astype(int) + 1))
    stations = len(points.scanners)
    shadow, maybe = (np.zeros((stations, *raster.shape), dtype=np.intp) for _ in range(2))
    through, inside, before = (np.zeros(raster.shape, dtype=np.intp) for _ in range(3))
    recess = np.zeros(raster.shape)
    for local, depth, station in _off_the_wall(cloud, points):
        front, behind = depth < 0.0, depth > 0.0
        before += raster.count(local[front & (depth > -SHALLOW)])
        shallow = behind & (depth < SHALLOW)
        inside += raster.count(local[shallow])
        recess += raster.total(local[shallow], depth[shallow])
        for number, scanner in enumerate(points.scanners):
            known, unknown = station == number, station < 0
            shadow[number] += raster.count(throw(local[front & (known | unknown)], scanner))
            through += raster.count(throw(local[behind & known], scanner))
            maybe[number] += raster.count(throw(local[behind & unknown], scanner))
    # Which station saw a point is not always known. None can have seen it through what hid the place from it.
    through += np.where(shadow == 0, maybe, 0).sum(axis=0)
    return RayMap(raster.low, cell, raster.count(points.xz), shadow, through, inside, recess, before)


class _Raster:
    """A grid of square cells on the wall's face."""

    def __init__(self, low: FloatArray, cell: float, shape: tuple[int, int]) -> None:
        self.low, self.cell, self.shape = low, cell, shape

    def cells(self, places: FloatArray) -> IntArray:
        """Flat number of the cell of each place, (n, 2) or (n, 3), -1 outside of the grid or where NaN."""
        xz = places[:, [0, -1]]
        with np.errstate(invalid="ignore"):
            scaled = (xz - self.low) / self.cell
            valid = ((scaled >= 0.0) & (scaled < self.shape)).all(axis=1)
        index = np.full(len(xz), -1, dtype=np.intp)
        whole = scaled[valid].astype(np.intp)
        index[valid] = whole[:, 0] * self.shape[1] + whole[:, 1]
        return index

    def count(self, places: FloatArray) -> IntArray:
        """Points in each cell."""
        index = self.cells(places)
        number: IntArray = np.bincount(index[index >= 0], minlength=self.shape[0] * self.shape[1])
        return number.reshape(self.shape)

    def total(self, places: FloatArray, values: FloatArray) -> FloatArray:
        """Sum of the values of the points in each cell."""
        index = self.cells(places)
        held = index >= 0
        size = self.shape[0] * self.shape[1]
        added = np.bincount(index[held], values[held], minlength=size).astype(np.float64)
        return added.reshape(self.shape)


def _off_the_wall(
    cloud: PointCloud, points: FacadePoints
) -> Iterator[tuple[FloatArray, FloatArray, IntArray]]:
    """The points before and behind the wall, a part of the scan at a time.

    Their facade coordinates, depth behind the face, and station (-1: not known).
    """
    inward = points.frame.axes[1]
    offset = float(points.frame.origin @ inward)
    bulge = float(np.nanmax(np.abs(points.relief.values)))
    # A single station measured all of it.
    alone = 0 if len(points.scanners) == 1 else -1
    for start in range(0, len(cloud), CHUNK):
        part = cloud.points[start : start + CHUNK]
        # Most points lie on the wall; what is surely so is not looked at any further.
        away = np.flatnonzero(np.abs(part @ inward - offset) > points.band - bulge)
        local = points.frame.to_facade(part[away])
        depth = facade_depth(points, local)
        off = np.abs(depth) > points.band
        station = np.full(len(local), alone, dtype=np.intp)
        if len(cloud.station):
            station = cloud.station[start + away].astype(np.intp)
        yield local[off], depth[off], station[off]


@dataclass(frozen=True, eq=False)
class Shadows:
    """Which cells of the rasters are in shadow, and which were seen through.

    Attributes
    ----------
    rays : RayMap
    hidden : (nx, nz) bool array
        Hidden from every station by something before the wall, and not seen through. Without a known
        station, those before which something is attached to the wall.
    passed : (nx, nz) bool array
        Something was seen behind: a room, or the reveal and the frame of an opening.
    dark : (nx, nz) bool array
        Where neither wall nor anything behind it was seen: the hidden cells where a station is known, else
        all that no frame or reveal is near.
    """

    rays: RayMap
    hidden: BoolArray
    passed: BoolArray
    dark: BoolArray


def cast_shadows(rays: RayMap) -> Shadows:
    """Tell the cells in shadow from those that were seen through."""
    passed = (rays.through > 0) if rays.stations else (rays.inside > 0)
    hides: BoolArray = rays.before > 0
    if rays.stations:
        hides = np.logical_and.reduce(rays.shadow > 0, axis=0)
    # A ray that missed, or a point lost to re-sampling, leaves a cell open in the midst of a shadow.
    hidden = _closed(hides, 1) & ~passed
    dark = hidden
    if not rays.stations:
        dark = (rays.wall == 0) & ~_closed(passed, int(np.ceil(PANE / 2.0 / rays.cell)))
    return Shadows(rays, hidden, passed, dark)


def _closed(cells: BoolArray, reach: int) -> BoolArray:
    """Cells with the gaps between them filled that are up to twice `reach` wide."""
    padded = np.pad(cells, reach)
    closed: BoolArray = ndimage.binary_closing(padded, np.ones((2 * reach + 1, 2 * reach + 1)))
    return closed[reach:-reach, reach:-reach] | cells


def is_hidden(shadows: Shadows, places: FloatArray) -> BoolArray:
    """Whether places (n, 2), m, on the wall's face lie in shadow; outside of the rasters nothing does."""
    hidden = shadows.hidden
    cell = _Raster(shadows.rays.low, shadows.rays.cell, (hidden.shape[0], hidden.shape[1])).cells(places)
    answer: BoolArray = (cell >= 0) & hidden.ravel()[cell]
    return answer


def rows_in_the_light(shadows: Shadows, box: FloatArray, along: FloatArray, axis: int) -> BoolArray:
    """Whether no shadow falls on a strip of wall, at each of some places along it.

    Parameters
    ----------
    shadows : Shadows
    box : (2, 2) float array, m
        Lower left and upper right corner of the strip.
    along : (n,) float array, m
        Places along the strip.
    axis : int
        Along which it runs: 0 for x, 1 for z.
    """
    rays, hidden = shadows.rays, shadows.hidden
    first = np.clip(np.floor((box[0] - rays.low) / rays.cell).astype(int), 0, hidden.shape)
    last = np.clip(np.floor((box[1] - rays.low) / rays.cell).astype(int) + 1, 0, hidden.shape)
    dark = np.logical_or.reduce(hidden[first[0] : last[0], first[1] : last[1]], axis=1 - axis)
    if not dark.any():
        return np.ones(len(along), dtype=bool)
    cell = np.floor((along - rays.low[axis]) / rays.cell).astype(np.intp) - first[axis]
    light: BoolArray = ~dark[np.clip(cell, 0, len(dark) - 1)]
    return light
