"""The strip of wall beside an edge of an opening, and where it says that the edge is."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Boundary, FacadePoints, Hole, Side
from fd2fem.reconstruction.edges import edge_position
from fd2fem.reconstruction.rays import Shadows, rows_in_the_light
from fd2fem.reconstruction.sampling import Sampling, points_in_box

__all__ = ["Place", "View", "edge_beside", "sampling_at", "seen_place"]

FloatArray = NDArray[np.float64]

REACH = 8.0
"""Depth of wall, in point spacings, that an edge's position is read from."""
MARGIN = 3.0
"""Points so many spacings outside of an edge's first guess are looked at, too."""
SYSTEMATIC = 0.5
"""Share of the in-plane noise by which an edge may be off without its scatter showing it."""
ENDS = 1.2
"""So many spacings at either end of an edge are left out: the other edges cut off points there."""
LEAST_NOISE, NOISE_SHARE = 0.0003, 1.0
"""In-plane noise at the least, m, and as a share of the depth's where no scanner's position is known."""
LIT = 12
"""Where so many points of the wall beside an edge are out of any shadow, only they speak of the edge."""


@dataclass(frozen=True, eq=False)
class View:
    """All that the edges of openings are read from."""

    points: FacadePoints
    boundary: Boundary
    holes: tuple[Hole, ...]
    shadows: Shadows
    sampling: Sampling


@dataclass(frozen=True, eq=False)
class Place:
    """Which opening an edge belongs to (its number in the holes), and its rectangle, m."""

    number: int
    low: FloatArray
    high: FloatArray


def seen_place(number: int, hole: Hole) -> Place:
    """The part of a hole's rectangle that no shadow hides: beside the rest, the wall may go on."""
    low, high = hole.low, hole.high
    for side, (least, most) in hole.unseen.items():
        axis = 0 if side.vertical else 1
        if side in {Side.LEFT, Side.BOTTOM}:
            low[axis] = max(low[axis], most)
        else:
            high[axis] = min(high[axis], least)
    return Place(number, low, high)


def edge_beside(view: View, place: Place, side: Side, level: float) -> tuple[float, float]:
    """Position of an edge from all of the wall's points beside it, and its standard error, m.

    Parameters
    ----------
    view : View
    place : Place
        The opening; the edge is read between its ends, less a margin.
    side : Side
    level : float, m
        First guess of the edge.
    """
    axis = 0 if side.vertical else 1
    sign = 1.0 if side in {Side.RIGHT, Side.TOP} else -1.0
    middle = (place.low + place.high) / 2.0
    middle[axis] = level
    points, sampling = view.points, sampling_at(view, middle)
    noise = _noise(points, middle, axis)
    reach = min(max(REACH * sampling.spacing, 0.1), _free_depth(view.holes, place, side, level))
    margin = MARGIN * sampling.spacing
    low, high = place.low + ENDS * sampling.spacing, place.high - ENDS * sampling.spacing
    low[axis], high[axis] = sorted((level - sign * margin, level + sign * reach))
    near = points_in_box(points, low, high)
    # On the reveal, points lie deeper than on the wall's face; they would crowd the edge.
    near = near[np.abs(points.depth[near]) < max(2.0 * points.rms, 1e-4)]
    lit = rows_in_the_light(view.shadows, np.array([low, high]), points.xz[near, 1 - axis], 1 - axis)
    if lit.sum() > LIT:
        near = near[lit]
    offset, sigma = edge_position(
        sign * (points.xz[near, axis] - level),
        points.xz[near, 1 - axis],
        spacing=sampling.spacing,
        reach=reach,
        noise=noise,
        exclusion=sampling.exclusion,
    )
    # Points of the reveal and mixed ones lie beside the edge by a part of the noise, all the same way.
    return float(level + sign * offset), float(np.hypot(sigma, SYSTEMATIC * noise))


def sampling_at(view: View, place: FloatArray) -> Sampling:
    """How the wall was sampled at a place (2,), m: the spacing changes over a wall."""
    grid = view.boundary.spacing
    if grid is None:
        return view.sampling
    return replace(view.sampling, spacing=float(grid.spacing_at(place[None])[0]))


def _noise(points: FacadePoints, place: FloatArray, axis: int) -> float:
    """Scatter of a point's coordinate along an axis of the wall's plane, m.

    The scatter lies along the ray, and so in the plane by as much more or less than in depth as the ray runs
    along the wall more or less than into it.
    """
    if not len(points.scanners):
        return max(NOISE_SHARE * points.rms, LEAST_NOISE)
    aside = np.abs(place[axis] - points.scanners[:, 2 * axis])
    return max(float(np.max(aside / np.abs(points.scanners[:, 1]))) * points.rms, LEAST_NOISE)


def _free_depth(holes: tuple[Hole, ...], place: Place, side: Side, level: float) -> float:
    """Distance from an edge into the wall up to the next hole beside it, m."""
    axis = 0 if side.vertical else 1
    outward = side in {Side.RIGHT, Side.TOP}
    depth = np.inf
    for number, hole in enumerate(holes):
        low, high = hole.low, hole.high
        overlap = min(high[1 - axis], place.high[1 - axis]) - max(low[1 - axis], place.low[1 - axis])
        gap = (low[axis] - level) if outward else (level - high[axis])
        if number != place.number and overlap > 0.0 and gap > 0.0:
            depth = min(depth, gap)
    return float(depth)
