"""Where an edge really is: the outermost sample lies inside it by a fraction of the point spacing."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

__all__ = ["edge_position"]

FloatArray = NDArray[np.float64]

STRAY_RUN = 6
"""A point counts as wall when so many points follow it about as densely as on the wall."""
STRAY_GAP = 4.0
"""... that is, within so many times the distance that they would take there."""
RIM = 0.15
"""Random points are used so many spacings deep."""
CROWDED = 0.01
"""Points are crowded when random ones would lie so close together with this probability."""


def edge_position(
    inward: FloatArray, along: FloatArray, *, spacing: float, reach: float
) -> tuple[float, float]:
    """Position of a straight edge from the wall's points beside it, and its standard error.

    Beside an edge at ``e`` that is sampled with a constant density, the i-th point from the outside
    lies at ``e + (i - 1/2)/r`` in the mean, ``r`` being the number of points per metre of distance from the
    edge. So each of the outermost points gives an estimate of ``e``; their mean is free of the bias that
    both the outermost point and a line through the boundary points have, for random points as for
    rows of a scan parallel to the edge. It varies by the scatter of a Poisson count, or by a twelfth of the
    square of the rows' distance, whichever is larger.

    Where a scan was re-sampled to a smallest distance, points crowd along its edges, and points on a reveal
    pile up there: closer together than random points ever lie, they mark the edge themselves.

    Parameters
    ----------
    inward : (n,) float array, m
        Distance of each point from a first guess of the edge, positive into the wall.
    along : (n,) float array, m
        Coordinate of each point along the edge.
    spacing : float, m
        Typical distance between neighbours.
    reach : float, m
        How far into the wall the points are even.

    Returns
    -------
    offset : float, m
        Of the edge from the first guess, positive into the wall.
    sigma : float, m

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> x, z = rng.uniform(0.0, 1.0, (2, 4000))
    >>> offset, sigma = edge_position(x + 0.013, z, spacing=0.016, reach=0.2)
    >>> abs(offset - 0.013) < 3 * sigma < 0.01
    True
    """
    seen = _rows_that_show_the_edge(inward, along, spacing)
    distance = np.sort(inward[seen & (inward < reach)])
    rate = _rate(distance, spacing, reach)
    if not np.isfinite(rate):
        return 0.0, spacing
    distance = distance[_first_of_wall(distance, rate) :]
    count, row = _outermost(distance, rate, spacing)
    outermost = distance[:count]
    run = float(outermost[-1] - outermost[0])
    if not row and count > 2 and run * rate < gammaincinv(count - 1, CROWDED):
        step = run / (count - 1)
        return float(outermost[0]) - step, max(step, 0.5 / rate)
    estimate = float(np.mean(outermost - (np.arange(count) + 0.5) / rate))
    # The third point lies 3/rate from the edge in the mean, and hardly ever more than 8/rate.
    limit = float(outermost[min(2, count - 1)]) - max(row, 8.0 / rate)
    variance = row**2 / 12.0 if row else count / 3.0 / rate**2
    return max(estimate, limit), float(np.sqrt(variance))


def _rows_that_show_the_edge(inward: FloatArray, along: FloatArray, spacing: float) -> NDArray[np.bool_]:
    """Whether each point lies at a height where the wall was seen right up to the edge.

    Where something hid the wall beside the edge, its points end further in and say nothing of the edge.
    """
    height = max(8.0 * spacing, 0.1)
    row = np.floor((along - along.min(initial=0.0)) / height).astype(np.intp)
    outermost = np.full(row.max(initial=0) + 1, np.inf)
    np.minimum.at(outermost, row, inward)
    level = np.median(outermost[np.isfinite(outermost)]) if len(inward) else 0.0
    shown: NDArray[np.bool_] = (outermost < level + 3.0 * spacing)[row]
    return shown


def _rate(distance: FloatArray, spacing: float, reach: float) -> float:
    """Points per metre of distance from the edge, NaN where too few to say."""
    start = min(2.0 * spacing, reach / 2.0)
    count = np.count_nonzero((distance > start) & (distance < reach))
    return count / (reach - start) if count >= STRAY_RUN else np.nan


def _outermost(distance: FloatArray, rate: float, spacing: float) -> tuple[int, float]:
    """How many of the outermost points to use, and the distance of the rows that they lie in (0: none).

    Rows parallel to the edge show as gaps that are too wide for random points; then whole rows are
    used, two of them, for part of a row would bias the estimate.
    """
    window = distance[: max(2 * STRAY_RUN, int(np.ceil(6.0 * spacing * rate)))]
    gaps = np.diff(window)
    widest = float(gaps.max(initial=0.0))
    # The widest of n gaps of random points is ln(n)/rate in the mean; e³ times rarer is no chance.
    if widest > (np.log(len(window)) + 3.0) / rate:
        ends = np.flatnonzero(gaps > widest / 2.0)
        if len(ends) >= 2:
            return int(ends[1]) + 1, widest
    return min(len(distance), max(STRAY_RUN, int(np.ceil(RIM * spacing * rate)))), 0.0


def _first_of_wall(distance: FloatArray, rate: float) -> int:
    """Number of the first point that is wall and no stray."""
    run = min(STRAY_RUN, len(distance) - 1)
    near = distance[run:] - distance[:-run] < STRAY_GAP * run / rate
    return int(np.argmax(near)) if near.any() else 0
