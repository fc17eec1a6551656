"""How a wall was sampled, as the estimates of its edges need it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import FacadePoints

__all__ = ["Sampling", "points_in_box"]


@dataclass(frozen=True)
class Sampling:
    """How the points lie on a wall.

    Attributes
    ----------
    spacing : float, m
        Typical distance between neighbours.
    noise : float, m
        Scatter of a point's place in the wall's plane.
    exclusion : float, m
        Smallest distance between neighbours, where a scan was re-sampled to one; 0 where not.
    """

    spacing: float
    noise: float
    exclusion: float


def points_in_box(
    points: FacadePoints, low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.intp]:
    """Indices of the wall's points strictly between two corners (2,), m; the points are sorted by x."""
    first, last = np.searchsorted(points.xz[:, 0], [low[0], high[0]], side="right")
    z = points.xz[first:last, 1]
    inside: NDArray[np.intp] = first + np.flatnonzero((z > low[1]) & (z < high[1]))
    return inside
