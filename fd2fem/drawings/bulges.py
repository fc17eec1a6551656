"""Outlines whose edges bulge: arcs of circles between corners, as CAD polylines have them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model.outlines import Outline, Oval, curved_outline, oval_outline

__all__ = ["FLAT", "bulge_oval", "bulged_outline", "joined_outline"]

FloatArray = NDArray[np.float64]

FLAT = 1e-6
"""An edge that bulges by less is straight, m."""
SAME = 2e-7
"""Pieces of ellipses whose centres and half axes differ by less are of one, m."""


def bulge_oval(start: ArrayLike, end: ArrayLike, bulge: float, *, flat: float = FLAT) -> Oval | None:
    """The arc of a circle between two corners.

    Parameters
    ----------
    start, end : (2,) array-like, m
    bulge : float
        Tangent of a quarter of the arc's angle: 1 is half a turn; positive where it turns to the left.
    flat : float, m
        An edge that bulges by no more is straight.

    Returns
    -------
    Oval or None
        None for a straight edge.

    Examples
    --------
    >>> half_turn = bulge_oval([1.0, 0.0], [-1.0, 0.0], 1.0)
    >>> half_turn.x, half_turn.z, half_turn.a, round(half_turn.end - half_turn.start, 12)
    (0.0, 0.0, 1.0, 3.14159265359)
    """
    (x0, z0), (x1, z1) = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    dx, dz = float(x1 - x0), float(z1 - z0)
    chord = float(np.hypot(dx, dz))
    if abs(bulge) * chord / 2.0 <= flat:
        return None
    # The centre lies beside the middle of the chord, to its left for less than half a turn to the left.
    aside = (1.0 - bulge**2) / (4.0 * bulge)
    x, z = float(x0 + x1) / 2.0 - aside * dz, float(z0 + z1) / 2.0 + aside * dx
    radius = chord * (1.0 + bulge**2) / (4.0 * abs(bulge))
    first = float(np.arctan2(z0 - z, x0 - x))
    return Oval(x, z, radius, radius, first, first + 4.0 * float(np.arctan(bulge)))


def bulged_outline(corners: ArrayLike, bulges: ArrayLike, *, tolerance: float) -> Outline:
    """Outline of corners and of the bulges of the edges that start there.

    Parameters
    ----------
    corners : (k, 2) array-like, m
    bulges : (k,) array-like
    tolerance : float, m
        How far the polygon may leave the arcs.

    Examples
    --------
    >>> outline = bulged_outline([[0, 0], [2, 0]], [0.0, 1.0], tolerance=0.001)
    >>> [(arc.x, arc.a) for arc in outline.arcs]
    [(1.0, 1.0), (1.0, 1.0)]
    """
    points = np.asarray(corners, dtype=np.float64)
    edges = zip(points, np.roll(points, -1, axis=0), np.asarray(bulges, dtype=np.float64), strict=True)
    ovals = {number: bulge_oval(start, end, float(bulge)) for number, (start, end, bulge) in enumerate(edges)}
    return joined_outline(
        points, {number: oval for number, oval in ovals.items() if oval is not None}, tolerance=tolerance
    )


def joined_outline(corners: FloatArray, ovals: Mapping[int, Oval], *, tolerance: float) -> Outline:
    """A `curved_outline` in which neighbouring pieces of one ellipse are one curve."""
    count = len(corners)
    starts = [number for number in range(count) if not _goes_on(ovals, number, count)]
    if not starts:
        return oval_outline(ovals[0], tolerance=tolerance)
    joined = {}
    for place, (start, following) in enumerate(zip(starts, [*starts[1:], starts[0] + count], strict=True)):
        if start in ovals:
            more = [ovals[number % count] for number in range(start + 1, following)]
            sweep = sum(oval.end - oval.start for oval in more)
            joined[place] = replace(ovals[start], end=ovals[start].end + sweep)
    return curved_outline(corners[starts], joined, tolerance=tolerance)


def _goes_on(ovals: Mapping[int, Oval], number: int, count: int) -> bool:
    """Whether the edge that starts at a corner is of the same ellipse as the one that ends there."""
    before, after = ovals.get((number - 1) % count), ovals.get(number)
    if before is None or after is None or (before.end > before.start) != (after.end > after.start):
        return False
    one, other = ((oval.x, oval.z, oval.a, oval.b) for oval in (before, after))
    return bool(np.abs(np.subtract(one, other)).max() < SAME)
