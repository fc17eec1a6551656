"""Where an edge lies among the points beside it: the likelihood of each position, for many strips at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

__all__ = ["BLUR_BINS", "EdgeProfile", "locate"]

FloatArray = NDArray[np.float64]

BINS_PER_BLUR = 2
BLUR_BINS = 5 * BINS_PER_BLUR
"""Half width, in bins, of the zone where a blurred edge is neither wall nor opening."""
FLAT = 6.0
"""Points within one blur beyond which the likelihood is flattened, or its peak would fall between bins."""


@dataclass(frozen=True)
class EdgeProfile:
    """Expected density of points against the distance from an edge, relative to that of the wall.

    Attributes
    ----------
    rate : float, 1/m
        Points per metre of distance from the edge, further in.
    blur : float, m
        Standard deviation of the points' distances.
    stray : float
        Density in the opening, relative to the wall's.
    crowding : float
        How many times denser than further in, less one, the points are right at the edge.
    crowded_depth : float, m
        Over which depth that falls off.
    """

    rate: float
    blur: float
    stray: float
    crowding: float = 0.0
    crowded_depth: float = 1.0

    @property
    def step(self) -> float:
        """Width of a bin, m."""
        return self.blur / BINS_PER_BLUR

    @property
    def sharpness(self) -> float:
        """Share of the log-likelihood that is used, 0 to 1."""
        return min(1.0, FLAT / ((1.0 + self.crowding) * self.rate * self.blur))

    def density(self, distance: FloatArray) -> FloatArray:
        """Relative density at distances from the edge, m, without strays."""
        crowd = self.crowding * np.exp(-np.maximum(distance, 0.0) / self.crowded_depth)
        density: FloatArray = ndtr(distance / self.blur) * (1.0 + crowd)
        return density


def locate(counts: FloatArray, profile: EdgeProfile) -> tuple[FloatArray, FloatArray]:
    """Edge of each strip from its histogram.

    The points are taken for a Poisson process of the profile's density. A uniform prior makes the
    likelihood the posterior density, and its mean is the estimate: unlike the maximum it is defined
    for a few points, and unlike the outermost point it does not hang on a stray.

    Parameters
    ----------
    counts : (c, m) float array
        Points per bin of width `profile.step`, from the opening into the wall, one strip per row.
    profile : EdgeProfile

    Returns
    -------
    position, sigma : (c,) float array, m
        Mean and standard deviation of the edge's distance from the strip's outer end.

    Examples
    --------
    >>> profile = EdgeProfile(rate=2000.0, blur=0.001, stray=0.01)
    >>> counts = np.where(np.arange(60) < 20, 0.0, 1.0)[None]
    >>> position, sigma = locate(counts, profile)
    >>> abs(position.item() - 20 * profile.step) < 0.001
    True
    """
    bins = counts.shape[1]
    distance = (np.arange(1 - bins, bins) + 0.5) * profile.step
    weight = np.log(profile.density(distance) + profile.stray)
    edges = np.arange(bins) * profile.step
    likelihood = profile.sharpness * (_weighted(counts, weight) + profile.rate * edges)
    density = np.exp(likelihood - likelihood.max(axis=1, keepdims=True))
    density /= density.sum(axis=1, keepdims=True)
    mean = density @ edges
    return mean, np.sqrt(np.maximum(density @ edges**2 - mean**2, 0.0))


def _weighted(counts: FloatArray, weight: FloatArray) -> FloatArray:
    """For an edge at the outer end of each of m bins, the sum of counts (c, m) times their weights, (c, m).

    The weights (2 m - 1,) are those of the bins from m - 1 before the edge to m - 1 behind it.
    """
    if len(counts) == 1:
        return np.correlate(weight, counts[0], "valid")[None, ::-1]
    bins = counts.shape[1]
    # Column e of the table holds the weights of all bins for an edge at the outer end of bin e.
    table = weight[bins - 1 + np.subtract.outer(np.arange(bins), np.arange(bins))]
    weighted: FloatArray = counts @ table
    return weighted
