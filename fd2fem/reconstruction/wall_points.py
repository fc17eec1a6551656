"""The points on and beside one wall of a large scan: taken out of it, sorted, parted by their spacing."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.reconstruction.face import Face
from fd2fem.reconstruction.thinning import chunks, coordinate_hash

__all__ = ["DUPLICATE", "measured_noise", "point_spacing", "points_beside", "sort_points"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

DUPLICATE = 1e-4
"""Points on the wall closer than this are one, m: a triangulation cannot use them apart."""
MARGIN = 0.5
"""A sample may miss so much of a wall's rim, m."""
NEIGHBOURHOOD = 0.25
"""Edge of the squares within which points are neighbours in depth, m."""
NEIGHBOUR = 8
"""The spacing follows from the distance to so many neighbours."""
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
"""Multiples of it, without their whole parts, fill an interval evenly (Weyl)."""
FEW = 10_000
"""So many squares are looked up one by one."""
SEEDS = 400
"""Points at which the spacing is measured."""


def points_beside(points: FloatArray, face: Face, *, share: float = 1.0) -> FloatArray:
    """Points of a scan that may lie on a wall's face, (m, 3) m, in its frame.

    Parameters
    ----------
    points : (n, 3) float array, m
        World frame.
    face : Face
    share : float
        Of the points to take; which ones, their coordinates decide at random.
    """
    (left, bottom), (right, top) = face.box[0] - MARGIN, face.box[1] + MARGIN
    frame, reach = face.frame, face.band + float(np.nanmax(np.abs(face.relief.values)))
    limit = np.uint64(min(share, 1.0) * float(2**64 - 2**12))
    shift = (frame.axes @ frame.origin)[:, None]
    found = []
    for part in chunks(len(points)):
        away = points[part]
        near = np.abs(away @ frame.axes[1] - shift[1]) < reach
        if not near.all():
            away = away.take(np.flatnonzero(near), axis=0)
        if share < 1.0:
            away = away[coordinate_hash(away) < limit]
        local = frame.axes @ away.T
        local -= shift
        x, _, z = local
        inside = (x > left) & (x < right) & (z > bottom) & (z < top)
        found.append(local if inside.all() else local[:, inside])
    return np.concatenate(found, axis=1).T


def sort_points(xz: FloatArray) -> IntArray:
    """Indices that sort points (n, 2) by x, and by z where x is the same, without duplicates.

    Of points that share a square of :data:`DUPLICATE` the first one stays.

    Examples
    --------
    >>> sort_points(np.array([[2.0, 0.0], [1.0, 1.0], [1.0, 0.5], [1.0, 0.50001]])).tolist()
    [2, 1, 0]
    """
    x, z = np.ascontiguousarray(xz.T)
    order, tied = _nearly_sorted(x)
    if len(tied):
        # Only those points are sorted again that share their x with another, or nearly so.
        again = np.union1d(tied, tied + 1)
        some = order[again]
        order[again] = some[np.lexsort((z[some], x[some]))]
    return _without_doubles(x, z, order)


def measured_noise(xz: FloatArray, depth: FloatArray) -> float:
    """Scatter of the depths (n,) of points (n, 2), m, about those of their neighbours, m.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> xz = rng.uniform(0.0, 4.0, (20_000, 2))
    >>> stepped = np.where(xz[:, 1] < 2.0, 0.0, 0.2) + rng.normal(0.0, 0.003, len(xz))
    >>> round(measured_noise(xz, stepped), 4)
    0.003
    """
    column, row = (np.floor((values - values.min()) / NEIGHBOURHOOD).astype(np.intp) for values in xz.T)
    cell = column * (int(row.max()) + 1) + row
    order = np.argsort(cell, kind="stable")
    together = np.diff(cell[order]) == 0
    if not together.any():
        return float(np.sqrt(np.mean(depth**2)))
    # The median difference of two normal values is 0.954 of their standard deviation.
    return float(np.median(np.abs(np.diff(depth[order])[together])) / 0.954)


def _nearly_sorted(x: FloatArray) -> tuple[IntArray, IntArray]:
    """Indices that sort values but for those that are all but equal, and the places of these but the last.

    The values are made whole numbers and their indices written behind them: sorting these is much faster
    than finding the order of the values.
    """
    behind = len(x).bit_length()
    finest = float(2 ** (62 - behind))
    low = x.min()
    key = ((x - low) * (finest / max(float(x.max() - low), 1e-9))).astype(np.int64)
    key <<= behind
    key += np.arange(len(x))
    key.sort()
    order = key & ((1 << behind) - 1)
    key >>= behind
    return order, np.flatnonzero(key[1:] == key[:-1])


def _without_doubles(x: FloatArray, z: FloatArray, order: IntArray) -> IntArray:
    """The order that sorts points by x, without those that share their square with an earlier one."""
    key = ((x - x.min()) / DUPLICATE).astype(np.int64)
    row = ((z - z.min()) / DUPLICATE).astype(np.int64)
    rows = int(row.max()) + 1
    key *= rows
    key += row
    ranked = np.sort(key)
    double = np.unique(ranked[1:][ranked[1:] == ranked[:-1]])
    if len(double) == 0:
        return order
    key = key[order]
    if len(double) > FEW:
        return order[np.sort(np.unique(key, return_index=True)[1])]
    # The points of a column are neighbours: a few squares are looked up faster than all are sorted.
    keep = np.ones(len(x), dtype=bool)
    column = key // rows
    starts, ends = (np.searchsorted(column, double // rows, side=side) for side in ("left", "right"))
    for square, start, end in zip(double, starts, ends, strict=True):
        keep[start + np.flatnonzero(key[start:end] == square)[1:]] = False
    return order[keep]


def point_spacing(xz: FloatArray) -> float:
    """Typical distance between neighbours, m: 1/√density, from the eighth neighbours of a sample.

    Parameters
    ----------
    xz : (n, 2) float array, m
        At least nine points.
    """
    x, z = np.ascontiguousarray(xz.T)
    if (x[1:] < x[:-1]).any():
        order = np.argsort(x, kind="stable")
        x, z = x[order], z[order]
    # Picked by place, so that the order of the points does not matter, nor a few points more or less.
    number = np.arange(min(SEEDS, len(x)))
    across = x[0] + (number + 0.5) / len(number) * (x[-1] - x[0])
    up = z.min() + (number * GOLDEN + 0.5) % 1.0 * np.ptp(z)
    reach = max(3.0 * float(np.sqrt(np.ptp(x) * np.ptp(z) / len(x))), DUPLICATE)
    seeds = [_point_near(x, z, place, reach) for place in zip(across, up, strict=True)]
    distance = [_neighbour_distance(x, z, seed, reach) for seed in seeds if seed >= 0]
    return float(np.median(distance) * np.sqrt(np.pi / NEIGHBOUR))


def _point_near(x: FloatArray, z: FloatArray, place: tuple[float, float], reach: float) -> int:
    """Index of a point near a place of a wall, -1 where there is none within reach.

    It is the first one along x: the nearest one would stand apart from its neighbours more than the usual.
    """
    first, end = np.searchsorted(x, [place[0] - reach, place[0] + reach])
    near = np.flatnonzero(np.abs(z[first:end] - place[1]) < reach)
    return int(first + near[0]) if len(near) else -1


def _neighbour_distance(x: FloatArray, z: FloatArray, seed: int, reach: float) -> float:
    """Distance, m, from a point to its eighth neighbour, in a square that grows until it holds it.

    The points are sorted by x.
    """
    while True:
        first, end = np.searchsorted(x, [x[seed] - reach, x[seed] + reach])
        near = first + np.flatnonzero(np.abs(z[first:end] - z[seed]) < reach)
        if len(near) > NEIGHBOUR:
            square = (x[near] - x[seed]) ** 2 + (z[near] - z[seed]) ** 2
            distance = float(np.sqrt(np.partition(square, NEIGHBOUR)[NEIGHBOUR]))
            if distance <= reach or len(near) == len(x):
                return distance
        reach *= 2.0
