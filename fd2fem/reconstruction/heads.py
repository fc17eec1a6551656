"""What shape an opening's head has, and where it is.

A rectangle is given up only when another shape is much more likely
(:mod:`~fd2fem.reconstruction.head_columns`) and both of its upper corners hold wall points. The most likely
shape is too large by a fraction of the point spacing, as any shape that touches points; its crown and its
haunches are then moved by :func:`~fd2fem.reconstruction.edges.edge_position`.
"""

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.model.heads import Head, HeadKind
from fd2fem.reconstruction.beside_curves import beside_head, sampled_edge
from fd2fem.reconstruction.curves import head_rise
from fd2fem.reconstruction.head_columns import Columns, Fit, Hidden, head_columns, most_likely
from fd2fem.reconstruction.sampling import Sampling

__all__ = ["fit_head"]

FloatArray = NDArray[np.float64]

EVIDENCE = 6.0
"""By so much must another shape's log-likelihood exceed the rectangle's."""
PLAINER = 6.0
"""By so much must it exceed that of an arc, to be taken instead ..."""
PLAINER_SHARE = 0.05
"""... or, where more, by such a share of what the arc is ahead of the rectangle."""
CORNER = 1.0
"""Upper corners hold wall points if some lie so many spacings below the crown."""
OUTER = 0.7
"""Columns between this place and the jamb, 1, are the corners'; a corner of which less than half shows says
nothing."""
CORNER_COLUMNS = 2.6
"""A corner is at least so many columns wide, of which the one at the jamb says little."""
RISES = 16
"""Rises tried per shape; half as many between the best one's neighbours."""
MISS = 3.0
"""A column contradicts a head from which its points are so many spacings away."""
MISSED = 0.25
"""Share of the columns that may contradict a head: a keystone does not make it irregular."""
LEAST_MISSED = 5
"""... and so many may always."""
INTRUDES = 1.0
"""Columns with several points so many spacings inside an opening, as at a keystone, say nothing of it."""
REACH = 8.0
"""Depth of wall, in spacings, that positions are read from."""
ZONES = ((0.0, 0.6), (0.6, 0.97))
"""Crown and haunches, from the middle to the jambs: each is moved by its own points."""
RANGES = {
    HeadKind.ARC: (0.06, 0.5),
    HeadKind.ELLIPTICAL: (0.12, 0.9),
    HeadKind.POINTED: (0.5, 1.5),
    HeadKind.GABLED: (0.12, 1.2),
}
"""Least and largest rise of each shape, as shares of the width. Flatter arcs are sagging lintels."""
SERIES = {kind: np.geomspace(*limits, RISES) for kind, limits in RANGES.items()}
"""The rises that are tried, as shares of the width."""


def fit_head(
    wall_xz: FloatArray,
    *,
    left: float,
    right: float,
    middle: float,
    sampling: Sampling,
    hidden: Hidden | None = None,
) -> Head:
    """Decide on the shape of an opening's head and fit it.

    Parameters
    ----------
    wall_xz : (n, 2) float array, m
        The wall's points around the opening's upper half, and as far above it as the wall is whole, best
        by eight spacings.
    left, right : float, m
        The jambs.
    middle : float, m
        A height inside the opening, below its head: points further down do not count. The sill, for an
        opening that is hardly higher than wide.
    sampling : Sampling
    hidden : function or None
        Tells for places (k, 2) on the wall whether something hid them from the scanner.

    Returns
    -------
    Head
        Flat unless the points contradict it.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> wall = rng.uniform([0, 1], [2, 3], (10_000, 2))
    >>> solid = (abs(wall[:, 0] - 1) > 0.5) | (np.hypot(wall[:, 0] - 1, np.maximum(wall[:, 1] - 2, 0)) > 0.5)
    >>> sampling = Sampling(spacing=0.02, noise=0.0, exclusion=0.0)
    >>> head = fit_head(wall[solid], left=0.5, right=1.5, middle=1.0, sampling=sampling)
    >>> head.kind.value, abs(head.crown - 2.5) < 0.01, abs(head.springing - 2.0) < 0.02
    ('arc', True, True)
    """
    columns = head_columns(wall_xz, (left, right), middle, sampling, hidden)
    if len(columns.middle) < 3:
        crown = float(np.median(columns.z)) if len(columns.z) else middle
        return Head(HeadKind.FLAT, crown, crown, max(sampling.spacing, crown - middle))
    flat = most_likely(columns, HeadKind.FLAT, np.zeros(1))
    fit = _chosen(columns, flat, sampling.spacing)
    head = Head(fit.kind, fit.springing, fit.crown, sampling.spacing)
    if _missed(columns, head, sampling.spacing) > MISSED:
        return _as_seen(columns, (left, right), sampling.spacing)
    clear = wall_xz[~_about_keystones(columns, head, wall_xz, (left, right), sampling.spacing)]
    for _ in range(1 if fit is flat else 2):
        head = _moved(head, clear, (left, right), sampling)
    return head


def _chosen(columns: Columns, flat: Fit, spacing: float) -> Fit:
    """The flat head, unless another is much more likely and both corners hold wall points."""
    coarse = {kind: most_likely(columns, kind, _rises(columns, kind)) for kind in RANGES}
    arc = _finer(columns, coarse[HeadKind.ARC])
    best = max(coarse.values(), key=lambda fit: fit.likelihood)
    best = arc if best.kind is HeadKind.ARC else _finer(columns, best)
    if best.likelihood < arc.likelihood + max(PLAINER, PLAINER_SHARE * (arc.likelihood - flat.likelihood)):
        best = arc
    if best.likelihood < flat.likelihood + EVIDENCE:
        return flat
    in_corner = columns.lowest < best.crown - CORNER * spacing
    # Of few columns, as on sparse scans, the outer two are each corner's.
    outer = min(OUTER, 1.0 - 2.0 * CORNER_COLUMNS / columns.count)
    sides = [columns.middle < -outer, columns.middle > outer]
    enough = max(2.0, 0.25 * (1.0 - outer) * columns.count)
    shown = [bool((side & in_corner).any()) for side in sides if np.count_nonzero(side) >= enough]
    return best if shown and all(shown) else flat


def _rises(columns: Columns, kind: HeadKind) -> FloatArray:
    return 2.0 * columns.half * SERIES[kind]


def _finer(columns: Columns, coarse: Fit) -> Fit:
    """The best rise between the neighbours of the best of a coarse series."""
    rises = _rises(columns, coarse.kind)
    step = rises[1] / rises[0]
    low, high = max(coarse.rise / step, rises[0]), min(coarse.rise * step, rises[-1])
    finer = most_likely(columns, coarse.kind, np.geomspace(low, high, RISES // 2))
    return max(coarse, finer, key=lambda fit: fit.likelihood)


def _missed(columns: Columns, head: Head, spacing: float) -> float:
    """Share of the columns whose points contradict a head: several lie below it, or none near above it."""
    height = head.springing + head_rise(head.kind, columns.middle, rise=head.rise, half=columns.half)
    slope = np.gradient(height, columns.middle * columns.half)
    limit = MISS * spacing * np.hypot(1.0, slope)
    off = (columns.highest < height - limit) | (columns.lowest > height + limit)
    return float(off.mean()) if np.count_nonzero(off) >= LEAST_MISSED else 0.0


def _about_keystones(
    columns: Columns, head: Head, wall_xz: FloatArray, jambs: tuple[float, float], spacing: float
) -> NDArray[np.bool_]:
    """Whether each point lies in a column that has more points inside the opening than strays explain."""
    height = head.springing + head_rise(head.kind, columns.middle, rise=head.rise, half=columns.half)
    full = columns.middle[columns.highest < height - INTRUDES * spacing]
    u = (wall_xz[:, 0] - (jambs[0] + jambs[1]) / 2.0) / columns.half
    width = 2.0 / columns.count
    about = np.zeros(len(u), dtype=bool)
    for middle in full:
        about |= np.abs(u - middle) < 0.75 * width
    return about


def _as_seen(columns: Columns, jambs: tuple[float, float], spacing: float) -> Head:
    """A head of no known shape: the lowest points, smoothed, less their mean distance from the edge."""
    low = ndimage.median_filter(columns.lowest, size=5, mode="nearest") - 0.7 * spacing
    x = (jambs[0] + jambs[1]) / 2.0 + columns.middle * columns.half
    line = shapely.LineString(np.column_stack([[jambs[0], *x, jambs[1]], [low[0], *low, low[-1]]])).simplify(
        0.7 * spacing
    )
    corners = np.array(line.coords)[::-1]
    return Head(
        HeadKind.IRREGULAR,
        springing=float(min(low[0], low[-1])),
        crown=float(corners[:, 1].max()),
        sigma=spacing,
        profile=tuple((float(x), float(z)) for x, z in corners),
    )


def _moved(head: Head, wall_xz: FloatArray, jambs: tuple[float, float], sampling: Sampling) -> Head:
    """Move a head to where the points beside it say that it is."""
    spacing = sampling.spacing
    left, right = jambs
    inward, along, foot = beside_head(head, wall_xz, left=left, right=right)
    top = float(wall_xz[:, 1].max())
    reach = max(min(max(REACH * spacing, 0.1), top - head.crown), 3.0 * spacing)
    zones = ((0.0, ZONES[1][1]),) if head.kind is HeadKind.FLAT else ZONES
    rows, found = [], []
    for low, high in zones:
        near = (np.abs(foot) >= low) & (np.abs(foot) < high) & (inward > -2.0 * spacing) & (inward < reach)
        offset, sigma = sampled_edge(inward[near], along[near], sampling, reach)
        rows.append(_sensitivity(head, (right - left) / 2.0, low, high))
        found.append((offset, sigma))
    if head.kind is HeadKind.FLAT:
        crown = head.crown + found[0][0]
        return Head(HeadKind.FLAT, crown, crown, found[0][1])
    matrix, (offsets, sigmas) = np.array(rows), np.array(found).T
    weight = 1.0 / sigmas**2
    # The most likely shape is off by less than two spacings.
    normal = matrix.T @ (weight[:, None] * matrix) + np.eye(2) / (2.0 * spacing) ** 2
    covariance = np.linalg.inv(normal)
    raised, grown = covariance @ (matrix.T @ (weight * offsets))
    crown, rise = head.crown + raised + grown, max(head.rise + grown, 0.02 * (right - left))
    if head.kind is HeadKind.ARC:
        rise = min(rise, (right - left) / 2.0)
    if head.kind is HeadKind.POINTED:
        rise = max(rise, (right - left) / 2.0)
    return replace(
        head, springing=float(crown - rise), crown=float(crown), sigma=float(np.sqrt(covariance.sum()))
    )


def _sensitivity(head: Head, half: float, low: float, high: float) -> tuple[float, float]:
    """How far a zone of a head moves into the wall, in the mean, per metre of springing and of rise."""
    u = np.linspace(low, high, 33)
    step = 1e-4 * max(head.rise, half)
    height = head_rise(head.kind, u, rise=head.rise, half=half)
    grown = head_rise(head.kind, u, rise=head.rise - step, half=half)
    length = float(np.hypot(np.diff(u) * half, np.diff(height)).sum())
    width = (high - low) * half
    return width / length, float(np.trapezoid((height - grown) / step, u)) * half / length
