"""The two opposite edges of a hole by the histogram of its boundary's coordinates (figure 5 of the paper)."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["histogram_peaks"]

FloatArray = NDArray[np.float64]

PEAK = 0.5
"""Share of the highest bin from which on a bin is a peak."""


def histogram_peaks(
    values: FloatArray, weights: FloatArray, *, centre: float, width: float, least: float = 0.0
) -> tuple[float, float]:
    """Positions of the two opposite edges of a hole: the peaks of a coordinate histogram (figure 5).

    On either side of the centre it is the outermost peak that counts, a peak being at least half as high as
    the highest. So a long edge across, whose points are spread over many bins, does not pass for one.

    Parameters
    ----------
    values : (b,) float array, m
        One coordinate of the hole's boundary.
    weights : (b,) float array
        How much of an edge lies there: points, or length along the edge.
    centre : float, m
        Inside the hole; one peak lies on either side of it.
    width : float, m
        Of a bin.
    least : float
        Weight below which nothing is a peak.

    Returns
    -------
    low, high : float, m
        Weighted medians in the peak bins; the extreme values where a side has no peak.

    Examples
    --------
    >>> jambs = np.array([1.0, 1.0, 1.01, 1.4, 1.7, 2.0, 2.0, 1.99])
    >>> histogram_peaks(jambs, np.ones(8), centre=1.5, width=0.05)
    (1.0, 2.0)
    """
    found = []
    for sign in (-1.0, 1.0):
        outward = sign * (values - centre)
        side = outward > 0
        if not side.any():
            found.append(float(values.min() if sign < 0 else values.max()))
            continue
        edges = np.arange(0.0, outward.max() + 3 * width, width)
        count, _ = np.histogram(outward[side], edges, weights=weights[side])
        # Pairs of bins, so that a peak that falls on a bin's edge is not halved.
        pair = count[:-1] + count[1:]
        if pair.max() < least:
            found.append(float(values.min() if sign < 0 else values.max()))
            continue
        peak = int(np.flatnonzero(pair >= PEAK * pair.max())[-1])
        if peak > 0 and pair[peak - 1] > pair[peak]:
            peak -= 1
        inside = np.flatnonzero(side & (outward >= edges[peak]) & (outward <= edges[peak + 2]))
        order = inside[np.argsort(values[inside], kind="stable")]
        half = np.searchsorted(np.cumsum(weights[order]), weights[order].sum() / 2.0)
        found.append(float(values[order[min(half, len(order) - 1)]]))
    return found[0], found[1]
