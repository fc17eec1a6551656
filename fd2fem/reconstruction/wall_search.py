"""The search for the wall: which vertical plane of a raw scan is the one to reconstruct.

The search tries vertical planes through pairs of points that stand above others, so that the pavement makes
no proposals. The points are thinned to cells first, and a cell counts with the square root of its points:
less than by points, for these crowd near the scanner, but more than by area, for glass returns few of its
rays and must not outweigh the wall around it. The planes that come out are compared by what they span, and
the best one is refined by least squares.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.errors import ReconstructionError

__all__ = [
    "MIN_POINTS",
    "MIN_WALL",
    "NEAR_PLANE",
    "PLAN_CELL",
    "THINNING",
    "face_before",
    "largest_part",
    "occupied_cells",
    "refine_plane",
    "robust_scatter",
    "search_plane",
    "thin_points",
]

FloatArray = NDArray[np.float64]

THINNING = 0.05
"""Edge of the cells that stand for the points in the search, m."""
PLAN_CELL = 0.10
"""Edge of the plan grid, m."""
UPRIGHT = 3
"""A plan cell with points at so many heights belongs to something that stands."""
HYPOTHESES = 1500
"""Pairs of points tried; with a tenth of the points on the wall, fifteen pairs lie on it."""
SAMPLE = 15_000
"""Cells that the hypotheses are scored on."""
NEAR_PLANE = 0.03
"""Distance from the plane, m, at which a point stops to speak for it."""
PLANES = 8
"""Planes that are compared by what they span."""
FACED = 3.0
"""How much more a wall counts that a scanner stands opposite to."""
IN_FRONT = 0.5
"""A parallel plane up to so far before the best one, m, with half of its points, is the wall's face."""
MAX_LEAN = np.radians(10.0)
"""A plane that leans more is not a wall."""
GAP = 0.5
"""Parts of a wall further apart than this belong to different walls, m."""
MIN_WALL = 1.0
"""Smallest length and height of a wall, m."""
MIN_POINTS = 30
"""Fewest points that show a wall, or the pavement before it."""


def robust_scatter(values: FloatArray) -> float:
    """Standard deviation of normal values, from the median absolute deviation: outliers hardly count.

    Examples
    --------
    >>> robust_scatter(np.array([-1.0, 0.0, 1.0, 2.0, 99.0]))
    1.4826
    """
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def thin_points(points: FloatArray, cell: float) -> NDArray[np.intp]:
    """Indices of one point in each occupied cell of a cubic grid.

    Parameters
    ----------
    points : (n, d) float array, m
    cell : float, m

    Examples
    --------
    >>> thin_points(np.array([[0.0, 0.0], [0.1, 0.1], [1.5, 0.0]]), 1.0).tolist()
    [0, 2]
    """
    return np.sort(occupied_cells(points, cell)[0])


def occupied_cells(points: FloatArray, cell: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Index of the first point in each occupied cell, and how many points each holds."""
    cells = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    key = np.zeros(len(cells), dtype=np.int64)
    for axis in range(cells.shape[1]):
        key = key * (int(cells[:, axis].max()) + 1) + cells[:, axis]
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    return first, count


def search_plane(
    points: FloatArray, count: NDArray[np.intp], scanners: FloatArray, seed: int
) -> tuple[FloatArray, FloatArray, float]:
    """A point and the normal of the vertical plane that is most of a wall, and how near the next one comes.

    The planes with the most weight are taken out one after the other, and the one that spans most wins,
    or one that stands before it: a room's back wall, seen through a large opening, can span as much.
    """
    rng = np.random.default_rng(seed)
    standing = _standing(points)
    first, second = points[rng.choice(standing, (2, HYPOTHESES))]
    along = (second - first)[:, :2]
    span = np.hypot(along[:, 0], along[:, 1])
    usable = span > MIN_WALL / 2
    if not usable.any():
        msg = f"No wall found: what stands upright is less than {MIN_WALL} m long; check the units."
        raise ReconstructionError(msg)
    first, along, span = first[usable], along[usable], span[usable]
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / span[:, None]
    offsets = np.einsum("ij,ij->i", normals, first[:, :2])
    sample = rng.permutation(standing)[:SAMPLE]
    where, hits = points[sample], count[sample].astype(np.float64)
    left = np.sqrt(hits)
    found = []
    for _ in range(PLANES):
        # A part of the sample tells which plane comes next.
        number = int(np.argmax(_scores(where[: SAMPLE // 5], left[: SAMPLE // 5], normals, offsets)))
        near = np.abs(where[:, :2] @ normals[number] - offsets[number]) < NEAR_PLANE
        near &= left > 0.0
        found.append(_part(where[near], hits[near], number, normals[number], scanners))
        left[near] = 0.0
    found.sort(key=lambda part: -part.value)
    best = found[0]
    for part in found[1:]:
        if _stands_before(part, best, normals, offsets, scanners):
            best = part
    others = [part.value for part in found if part is not best]
    rival = max(others, default=0.0) / max(best.value, 1e-300)
    return first[best.number], np.append(normals[best.number], 0.0), min(rival, 1.0)


@dataclass(frozen=True, eq=False)
class _Part:
    """The largest connected part of a plane's points, and how much of a wall it is.

    `low`, `high`: its extent along the plane and up, m.
    """

    number: int
    value: float
    low: FloatArray
    high: FloatArray


def _stands_before(
    part: _Part, best: _Part, normals: FloatArray, offsets: FloatArray, scanners: FloatArray
) -> bool:
    """Whether a part is parallel to the best one, nearer to the scanners, and covers about as much."""
    normal = normals[best.number]
    turn = np.sign(normals[part.number] @ normal)
    if not len(scanners) or abs(normals[part.number] @ normal) < np.cos(np.radians(5.0)):
        return False
    station = float(np.median(scanners[:, :2] @ normal)) - offsets[best.number]
    step = turn * offsets[part.number] - offsets[best.number]
    low, high = part.low, part.high
    if turn < 0:
        # The other normal runs along the plane the other way.
        low, high = np.array([-high[0], low[1]]), np.array([-low[0], high[1]])
    common = np.minimum(high, best.high) - np.maximum(low, best.low)
    covers = (common > 0.8 * (best.high - best.low)).all()
    return bool(covers and 0.0 < step * np.sign(station) < abs(station))


def _standing(points: FloatArray) -> NDArray[np.intp]:
    """Indices of the points in plan cells that hold points at several heights."""
    plan = np.floor((points[:, :2] - points[:, :2].min(axis=0)) / PLAN_CELL).astype(np.int64)
    column = np.unique(plan[:, 0] * (plan[:, 1].max() + 1) + plan[:, 1], return_inverse=True)[1].ravel()
    standing = np.flatnonzero(np.bincount(column)[column] >= UPRIGHT)
    if len(standing) < MIN_POINTS:
        msg = "No wall found: no points stand above others; check that z points up and the units are right."
        raise ReconstructionError(msg)
    return standing


def _part(
    points: FloatArray, hits: FloatArray, number: int, normal: FloatArray, scanners: FloatArray
) -> _Part:
    """How much of a wall a plane is: points of its largest connected part times the area that this spans.

    The area counts with its openings, or a strip of a blank neighbour could outweigh a wall that is mostly
    windows. A wall that a scanner stands opposite to counts more: it is what was to be scanned.
    """
    if len(points) < MIN_POINTS:
        return _Part(number, 0.0, np.zeros(2), np.zeros(2))
    direction = np.array([-normal[1], normal[0]])
    flat = np.column_stack([points[:, :2] @ direction, points[:, 2]])
    part = largest_part(flat)
    if len(part) < MIN_POINTS:
        return _Part(number, 0.0, np.zeros(2), np.zeros(2))
    hull = shapely.convex_hull(shapely.linestrings(flat[part]))
    low, high = flat[part].min(axis=0), flat[part].max(axis=0)
    foot = scanners[:, :2] @ direction
    faced = ((foot > low[0]) & (foot < high[0])).any()
    value = float(hits[part].sum() * shapely.area(hull)) * (FACED if faced else 1.0)
    return _Part(number, value, low, high)


def _scores(points: FloatArray, weight: FloatArray, normals: FloatArray, offsets: FloatArray) -> FloatArray:
    """Weight near each vertical plane, less of it the farther from the plane (MSAC)."""
    distance = normals[:, :1] * points[:, 0] + normals[:, 1:] * points[:, 1] - offsets[:, None]
    near: FloatArray = np.maximum(0.0, 1.0 - (distance / NEAR_PLANE) ** 2)
    score: FloatArray = np.einsum("ij,j->i", near, weight)
    return score


def refine_plane(
    points: FloatArray, weight: FloatArray, on_plane: FloatArray, normal: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A point and the normal of the least-squares plane through the points near a first guess."""
    for _ in range(8):
        distance = (points - on_plane) @ normal
        near = np.abs(distance) < NEAR_PLANE
        if near.sum() < 3:
            break
        scatter = robust_scatter(distance[near])
        near &= np.abs(distance - np.median(distance[near])) < max(4.0 * scatter, 0.1 * NEAR_PLANE)
        chosen, share = points[near], weight[near] / weight[near].sum()
        on_plane = share @ chosen
        away = chosen - on_plane
        candidate = np.linalg.eigh((away * share[:, None]).T @ away)[1][:, 0]
        if abs(candidate[2]) > np.sin(MAX_LEAN):
            msg = (
                f"No wall found: the best plane leans by more than {np.degrees(MAX_LEAN):.0f} degrees; "
                "check that z points up."
            )
            raise ReconstructionError(msg)
        normal = candidate * np.sign(candidate @ normal)
    return on_plane, normal


def face_before(points: FloatArray, weight: FloatArray, depth: FloatArray, normal: FloatArray) -> float:
    """Depth (negative, m) of a parallel plane before the best one that is rather the wall's face, or 0.

    Where openings take up most of a wall, blinds and frames can hold more points than the wall itself.
    """
    along = points @ np.array([-normal[1], normal[0], 0.0])
    near = np.abs(depth) < NEAR_PLANE
    low, high = np.percentile(along[near], [2, 98])
    beside = (along > low) & (along < high) & (points[:, 2] > np.percentile(points[near, 2], 10))
    edges = np.arange(-IN_FRONT - 0.01, NEAR_PLANE + 0.02, 0.02)
    count, _ = np.histogram(depth[beside], edges, weights=weight[beside])
    pair = count[:-1] + count[1:]
    front = np.flatnonzero((pair > 0.5 * pair.max()) & (edges[1:-1] < -1.5 * NEAR_PLANE))
    return float(edges[front[0] + 1]) if len(front) else 0.0


def largest_part(xz: FloatArray) -> NDArray[np.intp]:
    """Indices of the points of the largest connected part, parts being `GAP` apart."""
    cells = np.floor((xz - xz.min(axis=0)) / GAP).astype(np.int64)
    image = np.zeros(cells.max(axis=0) + 1, dtype=bool)
    image[cells[:, 0], cells[:, 1]] = True
    label, count = ndimage.label(image, structure=np.ones((3, 3)))
    size = ndimage.sum_labels(image, label, np.arange(1, count + 1))
    return np.flatnonzero(label[cells[:, 0], cells[:, 1]] == 1 + int(np.argmax(size)))
