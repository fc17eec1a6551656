"""What a wall is to the search: the largest connected part of an upright plane's points, and its rank."""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.reconstruction.thinning import Sample, occupied_cells, pick

__all__ = [
    "MIN_POINTS",
    "MIN_WALL",
    "NEAR_PLANE",
    "Cells",
    "Wall",
    "face_before",
    "is_dense",
    "largest_part",
    "measure_wall",
    "robust_scatter",
    "same_wall",
    "stands_before",
    "thin_cells",
    "wall_density",
]

FloatArray = NDArray[np.float64]

THINNING = 0.05
"""Edge of the cells that stand for the points in the search, m."""
NEAR_PLANE = 0.03
"""Distance from the plane, m, at which a point stops to speak for it."""
FACED = 3.0
"""How much more a wall counts that a scanner stands opposite to."""
IN_FRONT = 0.5
"""A parallel plane up to so far before the best one, m, with half of its points, is the wall's face."""
COVERING = 0.3
"""A wall before a room holds at least this share of the points that the room's back wall shows."""
PATCH = 0.25
"""Edge of the squares on which points are counted, m."""
THIN = 0.12
"""A square of the wall with a smaller share of the usual points is not of the wall."""
GAP = 0.5
"""Parts of a wall further apart than this belong to different walls, m."""
MIN_WALL = 1.0
"""Smallest length and height of a wall, m."""
MIN_POINTS = 30
"""Fewest points that show a wall, or the pavement before it."""


@dataclass(frozen=True, eq=False)
class Cells:
    """A sample thinned to one point per cell.

    Attributes
    ----------
    points : (c, 3) float array, m
    count : (c,) int array
        Points of the sample in each cell.
    """

    points: FloatArray
    count: NDArray[np.intp]

    @property
    def weight(self) -> FloatArray:
        """What a cell counts."""
        return np.sqrt(self.count)


@dataclass(frozen=True, eq=False)
class Wall:
    """The largest connected part of a plane's points, and how much of a wall it is.

    Attributes
    ----------
    on_plane, normal : (3,) float arrays
    low, high : (2,) float arrays, m
        Extent along the plane, as `right` measures it, and up.
    points : float
        Of the sample.
    span : float, m²
        Area of the convex hull.
    value : float
        By which walls are ranked.
    """

    on_plane: FloatArray
    normal: FloatArray
    low: FloatArray
    high: FloatArray
    points: float
    span: float
    value: float

    @property
    def right(self) -> FloatArray:
        """Level unit vector (3,) along the plane."""
        right: FloatArray = np.array([-self.normal[1], self.normal[0], 0.0]) / np.hypot(*self.normal[:2])
        return right

    @property
    def centre(self) -> FloatArray:
        """Middle of its extent, on the plane (3,), m."""
        along, up = 0.5 * (self.low + self.high)
        place = along * self.right + np.array([0.0, 0.0, up])
        level = np.append(self.normal[:2], 0.0) / np.hypot(*self.normal[:2])
        # Along the level normal to the plane, which leaves the place along it and the height.
        centre: FloatArray = place + level * ((self.on_plane - place) @ self.normal) / (level @ self.normal)
        return centre


def robust_scatter(values: FloatArray) -> float:
    """Standard deviation of normal values, from the median absolute deviation: outliers hardly count.

    Examples
    --------
    >>> robust_scatter(np.array([-1.0, 0.0, 1.0, 2.0, 99.0]))
    1.4826
    """
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def thin_cells(sample: Sample) -> Cells:
    """One point in each cell of :data:`THINNING`."""
    first, count = occupied_cells(sample.points, THINNING)
    return Cells(pick(sample.points, first), count)


def largest_part(xz: FloatArray, *, around: FloatArray | None = None, least: float = 0.0) -> NDArray[np.intp]:
    """Indices of the points of the largest connected part, parts being `GAP` apart.

    Parameters
    ----------
    xz : (n, 2) float array, m
    around : (k, 2) float array, m, optional
        If given, the part that holds most of these places is taken instead.
    least : float
        Squares with a smaller share of the points of the typical one do not count.
    """
    start = np.array([values.min() for values in xz.T])
    column, row = (((values - low) / GAP).astype(np.intp) for values, low in zip(xz.T, start, strict=True))
    shape = (int(column.max()) + 1, int(row.max()) + 1)
    column *= shape[1]
    number = np.add(column, row, out=column)
    points = np.bincount(number, minlength=shape[0] * shape[1])
    held = points > (least * np.median(points[number]) if least > 0.0 else 0)
    label, count = ndimage.label(held.reshape(shape), structure=np.ones((3, 3)))
    if count == 1 and least == 0.0:
        return np.arange(len(xz))
    size = np.bincount(label.ravel())
    if around is not None:
        places = ((around - start) / GAP).astype(np.intp)
        inside = ((around >= start) & (places < shape)).all(axis=1)
        size = np.bincount(label[tuple(places[inside].T)], minlength=count + 1)
    return np.flatnonzero(label.ravel()[number] == 1 + int(np.argmax(size[1:])))


def wall_density(xz: FloatArray) -> float:
    """Points per m² around the typical one of the points (n, 2), m, of a wall.

    Examples
    --------
    >>> round(wall_density(np.random.default_rng(0).uniform(0.0, 5.0, (20_000, 2))), -2)
    800.0
    """
    column, row = (np.floor(values / PATCH).astype(np.intp) for values in xz.T)
    number = (column - column.min()) * (int(np.ptp(row)) + 1) + row - row.min()
    return float(np.median(np.bincount(number)[number])) / PATCH**2


def measure_wall(
    points: FloatArray, hits: FloatArray, plane: tuple[FloatArray, FloatArray], scanners: FloatArray
) -> tuple[Wall, NDArray[np.intp]]:
    """How much of a wall a plane is: points of its largest connected part times the area that this spans.

    The area counts with its openings, or a strip of a blank neighbour could outweigh a wall that is mostly
    windows. A wall that a scanner stands opposite to counts more: it is what was to be scanned.

    Parameters
    ----------
    points : (k, 3) float array, m
        Near the plane; more than none.
    hits : (k,) float array
        Points of the sample that each stands for.
    plane : two (3,) float arrays
        A point on it and its normal.
    scanners : (s, 3) float array, m

    Returns
    -------
    wall : Wall
    part : (w,) int array
        Which of the points are on it.
    """
    wall = Wall(*plane, np.zeros(2), np.zeros(2), 0.0, 0.0, 0.0)
    flat = np.column_stack([points @ wall.right, points[:, 2]])
    # The pavement's rim goes on in the plane, but thinly.
    part = largest_part(flat, least=THIN)
    if len(part) < MIN_POINTS:
        return wall, part
    span = float(shapely.area(shapely.convex_hull(shapely.linestrings(flat[part]))))
    low, high = flat[part].min(axis=0), flat[part].max(axis=0)
    foot = scanners @ wall.right
    faced = ((foot > low[0]) & (foot < high[0])).any()
    on_wall = float(hits[part].sum())
    value = on_wall * span * (FACED if faced else 1.0)
    return Wall(*plane, low, high, on_wall, span, value), part


def stands_before(wall: Wall, best: Wall, scanners: FloatArray) -> bool:
    """Whether a wall is parallel to the best one, nearer to the scanners, and really covers it."""
    if not len(scanners) or not _are_parallel(wall, best):
        return False
    station = float(np.median((scanners - best.on_plane) @ best.normal))
    step = float((wall.centre - best.on_plane) @ best.normal)
    low, high = _extent_on(wall, best)
    common = np.minimum(high, best.high) - np.maximum(low, best.low)
    covers = (common > 0.8 * (best.high - best.low)).all() and wall.points > COVERING * best.points
    return bool(covers and 0.0 < step * np.sign(station) < abs(station))


def same_wall(wall: Wall, other: Wall) -> bool:
    """Whether a plane is parallel to another, within its depth, and half of it before or behind that one."""
    if wall is other:
        return True
    step = float((wall.centre - other.on_plane) @ other.normal)
    if not _are_parallel(wall, other) or abs(step) > IN_FRONT:
        return False
    low, high = _extent_on(wall, other)
    common = np.minimum(high, other.high) - np.maximum(low, other.low)
    return bool((common > 0.5 * (high - low)).all())


def is_dense(wall: Wall, cells: Cells) -> bool:
    """Whether a plane holds more than the space beside it: a cut through a tree or a room does not."""
    along = cells.points @ wall.right
    within = (along > wall.low[0]) & (along < wall.high[0])
    within &= (cells.points[:, 2] > wall.low[1]) & (cells.points[:, 2] < wall.high[1])
    away = np.abs((cells.points[within] - wall.on_plane) @ wall.normal)
    near = away < NEAR_PLANE
    beside = ~near & (away < 3.0 * NEAR_PLANE)
    return bool(beside.sum() < near.sum())


def _extent_on(wall: Wall, other: Wall) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corner of a wall as the other one measures along."""
    if wall.right @ other.right > 0.0:
        return wall.low, wall.high
    return np.array([-wall.high[0], wall.low[1]]), np.array([-wall.low[0], wall.high[1]])


def _are_parallel(wall: Wall, other: Wall) -> bool:
    """Whether two walls run within five degrees of the same direction."""
    return bool(abs(wall.right @ other.right) > np.cos(np.radians(5.0)))


def face_before(cells: Cells, depth: FloatArray, wall: Wall) -> float:
    """Depth (negative, m) of a parallel plane before the best one that is rather the wall's face, or 0.

    Where openings take up most of a wall, blinds and frames can hold more points than the wall itself.

    Parameters
    ----------
    cells : Cells
    depth : (c,) float array, m
        Of the cells behind the wall's plane.
    wall : Wall
    """
    along, up = cells.points @ wall.right, cells.points[:, 2]
    rim = 0.02 * (wall.high - wall.low)
    beside = (along > wall.low[0] + rim[0]) & (along < wall.high[0] - rim[0])
    # The pavement and what stands on it are left out.
    beside &= (up > wall.low[1] + 5.0 * rim[1]) & (up < wall.high[1] - rim[1])
    edges = np.arange(-IN_FRONT - 0.01, NEAR_PLANE + 0.02, 0.02)
    count, _ = np.histogram(depth[beside], edges, weights=cells.weight[beside])
    pair = count[:-1] + count[1:]
    front = np.flatnonzero((pair > 0.5 * pair.max()) & (edges[1:-1] < -1.5 * NEAR_PLANE))
    return float(edges[front[0] + 1]) if len(front) else 0.0
