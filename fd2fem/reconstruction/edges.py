"""Where an edge really is: the outermost sample lies inside it by a fraction of the point spacing."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fd2fem.reconstruction.edge_columns import column_share, outermost_column, unseen_columns
from fd2fem.reconstruction.edge_crowding import crowding, exclusion_distance
from fd2fem.reconstruction.edge_cuts import cut_errors, random_errors
from fd2fem.reconstruction.edge_likelihood import EdgeProfile, locate

__all__ = ["edge_position", "exclusion_distance"]

FloatArray = NDArray[np.float64]

MARGIN = 2.5
"""The edge is sought so many spacings outside of the first dense place."""
SEARCH = 3.0
"""... and so many inside of it."""
FEWEST = 8
"""Points that an edge's position needs."""
DENSE = 0.25
"""Share of the wall's density from which on a place is wall and no stray."""
CROWDED_DEPTH = 0.2
"""How deep re-sampled points crowd at an edge, in smallest distances."""
CROWDING_DOUBT = 0.02
"""Error, in spacings, that is left of the crowding, as no two scans' crowding is the same;"""
CROWDING_SPREAD = 1.15
"""... and by how much it widens the scatter."""
RIM = 0.3
"""How deep points are looked at that crowd at an edge for another reason, in spacings."""
DIFFUSE = 1.5
"""Clumping up to which points are taken to lie anywhere."""
COLUMNS = 2.5
"""Clumping from which on points lie in columns along the edge."""


@dataclass(frozen=True, eq=False)
class _Strip:
    """The wall beside an edge.

    Attributes
    ----------
    distance : (n,) float array, m
        From the first guess, sorted.
    first : int
        Number of the first that is wall.
    rate : float, 1/m
        Points per metre of distance.
    stray : float
        Density in the opening, relative to the wall's.
    """

    distance: FloatArray
    first: int
    rate: float
    stray: float

    @property
    def edge(self) -> float:
        """Where the first dense place begins, m."""
        return float(self.distance[self.first])

    @cached_property
    def gaps(self) -> FloatArray:
        """Between neighbouring distances on the wall, m."""
        gaps: FloatArray = np.diff(self.distance[self.first :])
        return gaps

    @cached_property
    def clumping(self) -> float:
        """Mean distance from a cut to the next point, by that of random points: 1, or more for columns."""
        gaps = self.gaps
        return float(self.rate * np.sum(gaps**2) / (2.0 * np.sum(gaps)))


def edge_position(
    inward: FloatArray,
    along: FloatArray,
    *,
    spacing: float,
    reach: float,
    noise: float = 0.0,
    exclusion: float = 0.0,
) -> tuple[float, float]:
    """Position of an edge from the wall's points beside it, and its standard error.

    The likelihood of every position is that of random points of the wall's density. How far that is off
    for the pattern at hand, rows, columns, several stations, is read from the wall itself: the strip is
    cut at many known depths and each cut is located in the same way. The mean of these errors is taken
    away, their scatter is the standard error.

    Parameters
    ----------
    inward : (n,) float array, m
        Distance of each point from a first guess of the edge, positive into the wall; from about three
        spacings outside of it.
    along : (n,) float array, m
        Coordinate of each point along the edge.
    spacing : float, m
        Typical distance between neighbours.
    reach : float, m
        How far into the wall the points are even.
    noise : float, m
        Standard deviation of a point's position in the plane.
    exclusion : float, m
        Smallest distance between neighbours where the cloud was re-sampled to one, else 0.

    Returns
    -------
    offset : float, m
        Of the edge from the first guess, positive into the wall; 0 where too few points tell.
    sigma : float, m

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> x, z = rng.uniform(0.0, 1.0, (2, 4000))
    >>> offset, sigma = edge_position(x + 0.013, z, spacing=0.016, reach=0.2)
    >>> abs(offset - 0.013) < 3 * sigma < 0.01
    True
    """
    shown = (inward < reach) & np.isfinite(inward + along)
    inward, along = inward[shown], along[shown]
    shown = _rows_that_show_the_edge(inward, along, spacing)
    inward, along = inward[shown], along[shown]
    strip = _strip(np.sort(inward), spacing, reach)
    if strip is None:
        return 0.0, spacing
    profile = _profile(strip, spacing, noise=noise, exclusion=exclusion)
    if reach - strip.edge < profile.step:
        # All of the points lie as deep as the strip reaches: they say nothing of the edge.
        return 0.0, spacing
    position, bias, variance = _located(strip, profile, spacing, reach=reach, noise=noise)
    crowded = _crowding_seen(strip, profile, position - bias, RIM * spacing)
    if crowded > 0.0:
        profile = replace(profile, crowding=crowded, crowded_depth=RIM * spacing)
        position, bias, variance = _located(strip, profile, spacing, reach=reach, noise=noise)
    if strip.clumping > COLUMNS:
        outside = strip.distance[strip.distance >= position - 2.0 * profile.blur]
        column = outermost_column(outside, float(strip.gaps.max()), profile.blur)
        if column is not None:
            return column
    wall = inward > position + spacing
    variance = max(variance, unseen_columns(inward[wall], along[wall], spacing=spacing, noise=noise))
    return position - bias, float(np.sqrt(variance))


def _rows_that_show_the_edge(inward: FloatArray, along: FloatArray, spacing: float) -> NDArray[np.bool_]:
    """Whether each point lies at a height where the wall was seen right up to the edge.

    Where something hid the wall beside the edge, its points end further in and say nothing of the edge.
    """
    if len(inward) == 0:
        return np.zeros(0, dtype=bool)
    length = float(np.ptp(along))
    rows = max(1, int(length / max(8.0 * spacing, 0.1)))
    row = np.minimum((along - along.min()) * (rows / max(length, 1e-9)), rows - 1).astype(np.intp)
    # One row behind another, so that they are sorted at once.
    lengths = np.arange(rows + 1) * (1.0 + float(np.ptp(inward))) - inward.min()
    ranked = np.sort(lengths[row] + inward)
    start = np.searchsorted(ranked, lengths + inward.min())
    filled = np.flatnonzero(np.diff(start) > 0)
    # Of the eight points per spacing that a row has: strays do not count, nor does a sliver that was seen.
    sixth = np.full(rows, np.inf)
    sixth[filled] = ranked[np.minimum(start[filled] + 5, start[filled + 1] - 1)] - lengths[filled]
    seen = np.sort(sixth[filled])
    level = float(seen[min(1, len(seen) // 4)])
    shown = sixth < level + 1.5 * spacing
    point_shown: NDArray[np.bool_] = shown[row]
    if shown.all():
        return point_shown
    # The last row before a hidden one may be hidden in part: a run of rows ends with its points at the edge.
    run = np.cumsum(~shown)[row]
    rim = point_shown & (inward < level + 0.75 * spacing)
    low, high = np.full(rows + 1, np.inf), np.full(rows + 1, -np.inf)
    np.minimum.at(low, run[rim], along[rim])
    np.maximum.at(high, run[rim], along[rim])
    point_shown &= (along >= low[run]) & (along <= high[run])
    return point_shown


def _strip(distance: FloatArray, spacing: float, reach: float) -> _Strip | None:
    """The sorted distances with the wall's density; None where too few points tell."""
    if len(distance) < FEWEST:
        return None
    rate = np.count_nonzero(distance > reach / 2.0) / (reach / 2.0)
    within = np.searchsorted(distance, distance + spacing) - np.arange(len(distance))
    first = int(np.argmax(within > max(DENSE * rate * spacing, 1.5)))
    edge = float(distance[first])
    inner = min(edge + 1.5 * spacing, (edge + reach) / 2.0)
    rate = np.count_nonzero(distance > inner) / (reach - inner)
    if rate * spacing < 1.0 or first > len(distance) - 3:
        return None
    strays = np.count_nonzero(distance < edge - spacing / 2.0)
    stray = float(np.clip((strays + 0.1) / (2.0 * rate * spacing), 0.01, 0.1))
    return _Strip(distance, first, rate, stray)


def _profile(strip: _Strip, spacing: float, *, noise: float, exclusion: float) -> EdgeProfile:
    """What to expect at the edge; the blur is no finer than the points can tell."""
    dense = crowding((exclusion / spacing) ** 2) if exclusion > 0.0 else 0.0
    tells = 0.7 / ((1.0 + dense) * strip.rate)
    blur = max(noise, tells, spacing / 25.0, float(strip.gaps.max()) / 40.0)
    return EdgeProfile(strip.rate, blur, strip.stray, dense, max(CROWDED_DEPTH * exclusion, blur / 10.0))


def _histogram(distance: FloatArray, depth: float, step: float) -> FloatArray:
    """Points per bin of width `step` from 0 to `depth`."""
    bins = int(depth / step)
    number = np.floor(distance / step)
    inside = number[(number >= 0) & (number < bins)].astype(np.intp)
    return np.bincount(inside, minlength=bins).astype(np.float64)


def _located(
    strip: _Strip, profile: EdgeProfile, spacing: float, *, reach: float, noise: float
) -> tuple[float, float, float]:
    """Position of the edge, its bias (m) and its variance (m²)."""
    step = profile.step
    # The edge's own point lies in the middle of a bin: on the border of two, rounding would decide.
    start = strip.edge - (np.round(MARGIN * spacing / step) + 0.5) * step
    counts = _histogram(strip.distance - start, reach - start, step)
    found, scatter = locate(counts[None, : int((MARGIN + SEARCH) * spacing / step)], profile)
    crowded = strip.edge + 3.5 * profile.crowded_depth if profile.crowding else -np.inf
    first = int(np.ceil((max(start + found[0], crowded) - start) / step)) + 1
    seen = noise if noise >= profile.blur else 0.0
    errors = cut_errors(counts, profile, first=first, widest=float(strip.gaps.max()), noise=seen)
    if len(errors):
        bias, variance = float(errors.mean()), float(errors.var())
    else:
        bias, variance = _from_gaps(strip, float(scatter[0]))
    if profile.crowding:
        # Columns part re-sampled points as they do others; without columns crowding sharpens the edge.
        low, middle, high = np.quantile(random_errors(profile, noise=noise), [0.16, 0.5, 0.84])
        columns = column_share(strip.clumping, len(strip.gaps), profile.crowding)
        bias = columns * bias + (1.0 - columns) * float(middle)
        doubt = (CROWDING_SPREAD * float(high - low) / 2.0) ** 2 + (CROWDING_DOUBT * spacing) ** 2
        variance = columns * variance + (1.0 - columns) * doubt
    return start + float(found[0]), bias, max(variance, (0.3 * step) ** 2)


def _crowding_seen(strip: _Strip, profile: EdgeProfile, edge: float, depth: float) -> float:
    """How many times denser, less one, the points beside the edge are, where that is no chance.

    So they are where each cell of a grid was thinned to one of its points, and on a reveal.
    """
    if profile.crowding > 0.0 or strip.clumping > DIFFUSE:
        return 0.0
    ends = np.searchsorted(strip.distance, [edge - profile.blur, edge + depth])
    count, expected = int(ends[1] - ends[0]), strip.rate * depth
    return count / expected - 1.0 if count > expected + 4.0 * np.sqrt(expected) else 0.0


def _from_gaps(strip: _Strip, scatter: float) -> tuple[float, float]:
    """Bias and variance where the strip is too short for cuts, from how far a cut is from the next point."""
    gaps = strip.gaps
    mean = float(np.sum(gaps**2) / (2.0 * np.sum(gaps)))
    square = float(np.sum(gaps**3) / (3.0 * np.sum(gaps)))
    return max(0.0, mean - 1.0 / strip.rate), square - mean**2 + scatter**2
