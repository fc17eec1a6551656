"""Points re-sampled to a smallest distance: finding that distance, and how they crowd at an edge."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

__all__ = ["crowding", "exclusion_distance"]

FloatArray = NDArray[np.float64]

PATCHES = 30
PATCH = 9.0
"""Width of a patch, in spacings."""
RIM = 2.0
"""Points so many spacings from the rim of a patch may have their neighbour outside of it."""
PACKED = 0.28
"""Smallest packing of re-sampled points, less where patches have holes; scan lines five times as far apart
as their points have 0.2."""
ENOUGH = 100
"""Neighbour distances that the verdict needs."""
ONSET = 1.05
"""Largest ratio of the distances to the nearest neighbour that 10 % and 1 % of the points do not exceed."""
APART = 1.09, 1.36
"""Bounds of the upper quartile of the distance to the second neighbour by that to the first."""
ABRUPT = 0.45
"""Largest excess of the first ratio over 1, relative to that of the second; noise on a grid has 0.55."""


def crowding(packing: float) -> float:
    """How many times denser than further in, less one, re-sampled points are right at an edge.

    Beside an edge that was cut before the re-sampling no point outside keeps others away. Fitted to the
    mean distance D of the outermost point in 4,400 simulated edges, 1/(rate D) = 1 + crowding, of scans
    whose own spacing was 1/1.1 to 1/12 of the re-sampling's; within 10 % for random ones, from a packing of
    0.43 (scan hardly denser than the re-sampling) to 0.66 (all but jammed).

    Parameters
    ----------
    packing : float
        Points per unit of area times the square of the smallest distance.

    Examples
    --------
    >>> round(crowding(0.6), 2)
    1.8
    """
    return 5.0 * min(packing, 0.7) ** 2


def exclusion_distance(xz: FloatArray) -> float:
    """Smallest distance between neighbours if the cloud was re-sampled to one, else 0.

    After random re-sampling the distances to the nearest neighbour start abruptly at the smallest one, and
    the second neighbour is somewhat farther away than the first. In a grid both are equally far but for the
    noise, and where points are random or stations overlap the distances start at 0.

    Parameters
    ----------
    xz : (n, 2) float array, m
        Points on the wall, sorted by x.

    Returns
    -------
    float, m

    Examples
    --------
    >>> random = np.random.default_rng(1).uniform(0.0, 1.0, (5000, 2))
    >>> exclusion_distance(random[np.argsort(random[:, 0])])
    0.0
    """
    nearest, density = _neighbour_distances(xz)
    if len(nearest) < ENOUGH:
        return 0.0
    first, tenth = np.quantile(nearest[:, 0], [0.01, 0.1])
    if tenth > ONSET * first:
        return 0.0
    apart = float(np.quantile(nearest[:, 1] / nearest[:, 0], 0.75))
    abrupt = tenth / first - 1.0 < ABRUPT * (apart - 1.0)
    packed = first**2 * density > PACKED
    if not (abrupt and packed and APART[0] < apart < APART[1]):
        return 0.0
    return float(np.quantile(nearest[:, 0], 0.02))


def _neighbour_distances(xz: FloatArray) -> tuple[FloatArray, float]:
    """Distances (m, 2) from points in patches to their two nearest neighbours, m, and points per m²."""
    if len(xz) < ENOUGH:
        return np.empty((0, 2)), 0.0
    x, z = (np.ascontiguousarray(column) for column in xz.T)
    spacing = float(np.sqrt(max(np.ptp(x) * np.ptp(z), 1e-12) / len(xz)))
    half = PATCH / 2.0 * spacing
    points, inner = [], []
    # The middle of each of so many parts of the points, so that every point is as likely.
    centres = xz[((np.arange(PATCHES) + 0.5) / PATCHES * len(xz)).astype(np.intp)]
    slabs = np.searchsorted(x, np.add.outer(centres[:, 0], [-half, half]))
    for patch, (centre, slab) in enumerate(zip(centres, slabs, strict=True)):
        near = xz[slice(*slab)] - centre
        near = near[np.abs(near[:, 1]) < half]
        inner.append((np.abs(near) < half - RIM * spacing).all(axis=1))
        # Side by side, far apart: one search tree serves them all.
        points.append(near + np.array([4.0 * half * patch, 0.0]))
    together, chosen = np.concatenate(points), np.concatenate(inner)
    distance: FloatArray = cKDTree(together).query(together[chosen], k=3)[0][:, 1:]
    area = PATCHES * (2.0 * (half - RIM * spacing)) ** 2
    apart = np.isfinite(distance).all(axis=1) & (distance[:, 0] > 0.0)
    return distance[apart], len(distance) / area
