"""How wrong an edge's position is: the same strip of wall, cut where we know it, and located again."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from fd2fem.reconstruction.edge_likelihood import BLUR_BINS, EdgeProfile, locate

__all__ = ["cut_errors", "random_errors"]

FloatArray = NDArray[np.float64]

CUTS = 120
"""Cuts per edge; more cost time and say little more."""
RANDOM_EDGES = 60
LEAP = 0.5
"""A jump of the error by this share of its range ends a gap in the points."""
SMOOTH = 0.7
"""Width of the density's kernel, in standard deviations of the noise."""
DRAWS: FloatArray = np.random.default_rng(0).standard_normal(CUTS * 2 * BLUR_BINS).reshape(CUTS, -1)
"""Normal numbers that stay the same, so that a result does."""


def cut_errors(
    counts: FloatArray, profile: EdgeProfile, *, first: int, widest: float, noise: float
) -> FloatArray:
    """Errors of :func:`locate` for edges cut into the wall at many depths.

    Whatever the pattern of the points, random, rows or columns, this strip was cut out of it by the
    edge just as the cuts do. So the mean of the errors is the estimate's bias, and their scatter its
    standard error.

    Parameters
    ----------
    counts : (m,) float array
        Points per bin of width `profile.step`, from the opening into the wall.
    profile : EdgeProfile
    first : int
        Bin of the first cut.
    widest : float, m
        Widest gap between neighbouring distances.
    noise : float, m
        In-plane scatter of the points, where the profile's blur is no more than that; else 0.

    Returns
    -------
    (c,) float array, m
        Located less true position; empty where the strip is too short.
    """
    step = profile.step
    ahead = int((1.1 * widest + 4.0 / profile.rate) / step) + 2 * BLUR_BINS
    cuts = np.arange(max(first, BLUR_BINS), len(counts) - ahead)
    if len(cuts) < max(5.0, widest / step):
        return np.empty(0)
    if len(cuts) > CUTS:
        cuts = cuts[np.linspace(0, len(cuts) - 1, CUTS).astype(np.intp)]
    strips = _windows(counts, cuts - BLUR_BINS, BLUR_BINS + ahead)
    if noise > 0.0:
        near = strips[:, : 2 * BLUR_BINS]
        near[:] = _cut_blurred(near, _share_inside(counts, cuts, step=step, noise=noise))
    else:
        strips[:, :BLUR_BINS] = 0.0
    errors = locate(strips, profile)[0] - BLUR_BINS * step
    return errors[_whole_gaps(errors)]


def random_errors(profile: EdgeProfile, *, noise: float) -> FloatArray:
    """Errors of :func:`locate` (m) for edges whose points are random with the profile's density."""
    bins = 2 * BLUR_BINS + int(6.0 / (profile.rate * profile.step))
    distance = np.arange(-BLUR_BINS + 0.5, bins - BLUR_BINS) * profile.step
    sharp = replace(profile, blur=max(noise, 1e-3 * profile.step))
    expected = profile.rate * profile.step * sharp.density(distance)
    # A fixed seed: the same points give the same sigma.
    counts = np.random.default_rng(0).poisson(expected, (RANDOM_EDGES, bins)).astype(np.float64)
    errors: FloatArray = locate(counts, profile)[0] - BLUR_BINS * profile.step
    return errors


def _cut_blurred(near: FloatArray, share: FloatArray) -> FloatArray:
    """Counts near the cuts when each point stays with its `share` for a probability."""
    scatter = np.sqrt(near * share * (1.0 - share)) * DRAWS[: len(near)]
    kept: FloatArray = np.clip(np.round(near * share + scatter), 0.0, near)
    return kept


def _share_inside(counts: FloatArray, cuts: NDArray[np.intp], *, step: float, noise: float) -> FloatArray:
    """Probability that a point seen in a bin near a cut came from inside of it: (c, 2 * BLUR_BINS).

    The true distance of a point that was measured at x with normal noise has the mean
    x + noise² f'/f and the variance noise² (1 + noise² (ln f)''), f being the density of the measured ones
    (Tweedie's formula: Efron, J. Am. Stat. Assoc. 106 (2011), equations 2.8 and 2.9). So the points of one
    column stay together, as they do at a real edge, where random points part. The density is
    smoothed by a narrow kernel, which counts as more noise.
    """
    width = SMOOTH * noise
    reach = np.arange(-BLUR_BINS, BLUR_BINS + 1) * step / width
    kernel = np.exp(-0.5 * reach**2)
    density = np.convolve(counts, kernel, "same") + 1e-9
    slope = np.convolve(counts, -reach * kernel, "same") / density / width
    bend = np.convolve(counts, (reach**2 - 1.0) * kernel, "same") / density / width**2 - slope**2
    total = noise**2 + width**2
    shift = np.clip(total * slope, -3.0 * noise, 3.0 * noise)
    scatter = noise * np.sqrt(np.clip(1.0 + total * bend, 1e-4, 1.0))
    distance = (np.arange(-BLUR_BINS, BLUR_BINS) + 0.5) * step
    shifts, scatters = (_windows(values, cuts - BLUR_BINS, 2 * BLUR_BINS) for values in (shift, scatter))
    share: FloatArray = ndtr((distance + shifts) / scatters)
    return share


def _windows(values: FloatArray, starts: NDArray[np.intp], length: int) -> FloatArray:
    """So many of the values (m,) from each start on: (c, length)."""
    return values[np.add.outer(starts, np.arange(length))]


def _whole_gaps(errors: FloatArray) -> slice:
    """The cuts from the start of one wide gap to the start of another, or all.

    Between columns of points the error falls with the cut's depth and leaps at each column. Their mean is
    that of all edges only over whole gaps.
    """
    height = float(np.ptp(errors))
    starts = np.flatnonzero(np.diff(errors) > LEAP * height) + 1
    if errors[0] > errors.min() + 0.75 * height:
        starts = np.append(0, starts)
    if len(starts) > 1 and starts[-1] - starts[0] > 0.3 * len(errors):
        return slice(int(starts[0]), int(starts[-1]))
    return slice(None)
