"""Columns of points along an edge: how they part an edge's position, and what the outermost one tells."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["column_share", "outermost_column", "unseen_columns"]

FloatArray = NDArray[np.float64]

CHANCE = 0.7
"""Clumping so many times 1/√n above that of random points is no chance."""
EVEN = 0.15
"""Largest range of the distances between even columns, relative to their median; and of their width."""
SHORT = 0.88
"""The outermost column is off the grid when it lies nearer to the next than this share of the distance."""
FULL = 0.7
"""Share of a column's points from which on the outermost one is a whole column."""
UNSEEN = 5.0
"""Columns less than so many times the noise apart do not show."""
REGULAR = 0.65
"""Scatter of the counts in squares, relative to random points', below which a pattern is a grid."""
SQUARE = 2.5
"""Side of the squares, in spacings."""


def column_share(clumping: float, count: int, crowding: float) -> float:
    """Share of an edge's variance that columns of points cause, where points crowd at the edge.

    Let columns of n points in the mean (Poisson) be p apart, with u = n/2. Then the outermost point of a
    strip cut at random lies u coth(u) = `clumping` times 1/rate inside of the cut in the mean. Its
    variance is u²/3 + u²/sinh²(u) times 1/rate², of which the first part is p²/12; (1 + crowding) times as
    many points in the outermost column reduce the second to that of (1 + crowding) u.

    Parameters
    ----------
    clumping : float
        Mean distance of a cut from the next point, times the rate: 1 for random points.
    count : int
        Gaps that it was found from.
    crowding : float

    Examples
    --------
    >>> column_share(1.0, 100, 2.0), round(column_share(5.0, 100, 2.0), 3)
    (0.0, 1.0)
    """
    excess = clumping - 1.0 - CHANCE / np.sqrt(max(count, 1))
    if excess <= 0.0:
        return 0.0
    # Within 6 % of the root of u coth(u) = 1 + excess.
    u = np.sqrt(excess * (excess + 3.0))
    columns = u**2 / 3.0
    return float(columns / (columns + (u / np.sinh(min((1.0 + crowding) * u, 50.0))) ** 2))


def outermost_column(distance: FloatArray, widest: float, blur: float) -> tuple[float, float] | None:
    """Edge and sigma (m) where the outermost column of points is off the grid that the others keep.

    A scan's outermost column keeps the distance. Where each cell of a grid was thinned to the
    mean of its points, the outermost column is the middle of what the edge left of its cells. And a short
    column of points beside the edge is no part of the grid: points of the reveal mark the edge itself.

    Parameters
    ----------
    distance : (n,) float array, m
        Sorted, from the outermost point on.
    widest : float, m
        Widest gap between them.
    blur : float, m

    Returns
    -------
    position, sigma : float, m
        None where there are no even columns, or the outermost is one of them.
    """
    starts = np.flatnonzero(np.diff(distance, prepend=-np.inf) > widest / 4.0)
    size = np.diff(starts, append=len(distance))
    if len(size) < 5 or size[0] < 3:
        return None
    column = np.add.reduceat(distance, starts) / size
    apart = np.diff(column)
    typical, usual = float(np.median(apart[1:])), float(np.median(size[1:-1]))
    alike = np.abs(size[1:-1] - usual).max() < 0.4 * usual
    if not alike or np.ptp(apart[1:]) > EVEN * typical or apart[0] > SHORT * typical:
        return None
    variance = np.add.reduceat((distance - np.repeat(column, size)) ** 2, starts) / size
    if 1.5 * np.sqrt(np.median(variance)) > EVEN * typical:
        return None
    whole = size[0] > FULL * usual and apart[0] > 0.45 * typical
    rest = max(0.0, float(apart[0]) - typical / 2.0) if whole else 0.0
    return float(column[0]) - rest, 0.08 * typical + blur


def unseen_columns(inward: FloatArray, along: FloatArray, *, spacing: float, noise: float) -> float:
    """Variance (m²) that an edge has from columns which the noise hides; 0 where there are none.

    A grid shows in the counts of points in squares, which scatter less than those of random points.
    """
    apart = min(UNSEEN * noise, 1.5 * spacing)
    if UNSEEN * noise < 0.7 * spacing or len(inward) < 2:
        return 0.0
    side = SQUARE * spacing
    depth, length = inward.max() - inward.min(), along.max() - along.min()
    shape = int(depth / side), int(length / side)
    if shape[0] * shape[1] < 12:
        return apart**2 / 12.0
    row, column = (np.floor((values - values.min()) / side).astype(np.intp) for values in (inward, along))
    inside = (row < shape[0]) & (column < shape[1])
    counts = np.bincount(row[inside] * shape[1] + column[inside], minlength=shape[0] * shape[1])
    counts = counts[counts > 0]
    return apart**2 / 12.0 if counts.var() < REGULAR * counts.mean() else 0.0
