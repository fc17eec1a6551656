"""Samples of a scan that do not depend on the order of its points.

A point's place alone decides whether it is taken: its coordinates are hashed to an even random number. So
the sample is the same however a file was sorted, and it is random, so that no pattern of it beats with the
pattern of the scan.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Sample", "chunks", "coordinate_hash", "occupied_cells", "pick", "take_sample", "thin_points"]

FloatArray = NDArray[np.float64]

CHUNK = 1 << 15
"""Points handled at a time: memory grows with the wall and not with the scan, and a cache holds them."""
SAMPLE = 300_000
"""Points that show a scene well enough to find the wall in it."""
ENOUGH = 10_000
"""So many points show where the middle of a scene is."""
ODD = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], dtype=np.uint64)
"""Multipliers that mix bits well (D. Stafford's mix 13, as used in SplitMix64)."""


@dataclass(frozen=True, eq=False)
class Sample:
    """Some points of a scan, in random order.

    Attributes
    ----------
    points : (k, 3) float array, m
        Relative to `centre`.
    centre : (3,) float array, m
        The median of some of them, world frame.
    share : float
        Of the points of the scan.
    """

    points: FloatArray
    centre: FloatArray
    share: float


def chunks(count: int) -> Iterator[slice]:
    """Slices that cover `count` points, :data:`CHUNK` of them at a time.

    Examples
    --------
    >>> list(chunks(32_769))
    [slice(0, 32768, None), slice(32768, 32769, None)]
    """
    for start in range(0, count, CHUNK):
        yield slice(start, min(start + CHUNK, count))


def coordinate_hash(points: FloatArray) -> NDArray[np.uint64]:
    """An even random 64-bit number (n,) for each point (n, 3), wherever the point stands in the array.

    Examples
    --------
    >>> a = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 4.0]])
    >>> bool((coordinate_hash(a[::-1]) == coordinate_hash(a)[::-1]).all())
    True
    """
    bits = np.ascontiguousarray(points).view(np.uint64)
    mixed = np.zeros(len(bits), dtype=np.uint64)
    # Once more than there are coordinates: the last one has to reach all bits, too.
    for axis in (0, 1, 2, None):
        if axis is not None:
            mixed += bits[:, axis]
        mixed *= ODD[axis or 0]
        mixed ^= mixed >> np.uint64(31)
    return mixed


def pick(points: FloatArray, which: NDArray[np.intp] | NDArray[np.bool_]) -> FloatArray:
    """Some of the points (n, d), laid out column by column: what is done to millions is done by columns."""
    chosen = np.flatnonzero(which) if which.dtype == np.bool_ else which
    return np.array([column.take(chosen) for column in points.T]).T


def take_sample(points: FloatArray, size: int = SAMPLE) -> Sample:
    """About `size` points of a scan, all of a smaller one, sorted by their hash.

    Parameters
    ----------
    points : (n, 3) float array, m
        At least one.
    size : int
    """
    limit = np.uint64(min(size / len(points), 1.0) * float(2**64 - 2**12))
    taken, order = [], []
    for part in chunks(len(points)):
        key = coordinate_hash(points[part])
        chosen = np.arange(len(key)) if size >= len(points) else np.flatnonzero(key < limit)
        taken.append(points[part].take(chosen, axis=0))
        order.append(key[chosen])
    # Points with the same hash are the same points.
    found = pick(np.concatenate(taken), np.argsort(np.concatenate(order)))
    if len(found) == 0:
        found = points[:1]
    centre = np.array([np.median(column) for column in found[:ENOUGH].T])
    return Sample((found.T - centre[:, None]).T, centre, len(found) / len(points))


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
    key = np.zeros(len(points), dtype=np.int64)
    for column in points.T:
        number = np.floor((column - column.min()) / cell).astype(np.int64)
        key = key * (int(number.max()) + 1) + number
    order = np.argsort(key)
    key = key[order]
    starts = np.flatnonzero(np.diff(key, prepend=key[0] - 1))
    # The first of a cell's points in the given order, though the faster sort does not keep it.
    first = np.minimum.reduceat(order, starts)
    return first, np.diff(starts, append=len(key))
