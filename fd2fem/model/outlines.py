"""Outlines with curved edges: from corners and the curves between them to a polygon of the same area."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model.arcs import Arc, facet_arc
from fd2fem.model.checks import ONE_CORNER, as_points, check_positive, signed_area

__all__ = ["Outline", "Oval", "chord_count", "curved_outline", "oval_outline"]

FloatArray = NDArray[np.float64]

QUARTER = np.pi / 2.0
SLIVER = 0.02
"""A curve that ends less than this beyond an extreme of its ellipse has no corner there, radians."""
MOST = 10_000
"""Chords of one curve at the most, enough for a circle of 20 km at 1 mm: larger ones are mistakes."""
WIDEST = np.pi / 4.0
"""No chord spans more of an ellipse, radians: its corners would lie too far outside."""


@dataclass(frozen=True)
class Oval:
    """A piece of an ellipse with level and upright axes (of a circle, where they are equal).

    At the angle t it passes through (x + a cos t, z + b sin t); it runs from `start` to `end`, radians,
    clockwise where `end` is less. `x`, `z`: centre, `a`, `b`: half axes, m.
    """

    x: float
    z: float
    a: float
    b: float
    start: float
    end: float


@dataclass(frozen=True, eq=False)
class Outline:
    """A closed polygon, `ring` (k, 2), m, and which of its corners stand for curves."""

    ring: FloatArray
    arcs: tuple[Arc, ...] = ()

    def moved(self, x: float, z: float) -> "Outline":
        """The outline shifted by (x, z), m.

        Examples
        --------
        >>> moved = oval_outline(Oval(0, 0, 1, 1, 0, 2 * np.pi), tolerance=0.01).moved(3.0, 2.0)
        >>> moved.arcs[0].x, moved.ring[0].tolist()
        (3.0, [4.0, 2.0])
        """
        arcs = tuple(replace(arc, x=arc.x + x, z=arc.z + z) for arc in self.arcs)
        return Outline(self.ring + np.array([x, z]), arcs)


def curved_outline(corners: ArrayLike, ovals: Mapping[int, Oval], *, tolerance: float) -> Outline:
    """Outline of straight and curved edges that has exactly their area.

    Curves have corners where they are farthest right, up, left and down, so that the polygon is as wide and
    as high as the shape.

    Parameters
    ----------
    corners : (k, 2) array-like, m
        Where the edges meet, in order; a single one for a closed curve.
    ovals : mapping of int to Oval
        The curved edges, by the corner where they start; they end at the next one.
    tolerance : float, m
        How far the polygon may leave the curves.

    Returns
    -------
    Outline
        Counter-clockwise, without edges of no length: empty, if there are no others.

    Examples
    --------
    >>> lunette = curved_outline([[0, 0], [2, 0]], {1: Oval(1, 0, 1, 1, 0, np.pi)}, tolerance=0.001)
    >>> bool(abs(signed_area(lunette.ring) - np.pi / 2) < 1e-12), lunette.ring.max(axis=0).tolist()
    (True, [2.0, 1.0])
    """
    check_positive("tolerance", tolerance)
    points = as_points("corners", corners, dim=2)
    taken: list[FloatArray] = []
    found: list[tuple[int, int, Oval]] = []
    for number, (corner, following) in enumerate(zip(points, np.roll(points, -1, axis=0), strict=True)):
        oval = ovals.get(number)
        if oval is None:
            if np.hypot(*(following - corner)) > ONE_CORNER:
                taken.append(corner)
            continue
        for piece in _between_extremes(oval):
            facets = _facets(piece, tolerance)
            if piece.start == oval.start:
                facets[0] = corner
            found.append((len(taken), len(taken) + len(facets) - 1, piece))
            taken.extend(facets[:-1])
    ring = np.array(taken).reshape(-1, 2)
    count = len(ring)
    if count == 0:
        return Outline(ring)
    arcs = tuple(Arc(first, last % count, o.x, o.z, o.a, o.b) for first, last, o in found)
    if signed_area(ring) < 0.0:
        ring = ring[::-1].copy()
        arcs = tuple(replace(arc, first=count - 1 - arc.last, last=count - 1 - arc.first) for arc in arcs)
    return Outline(ring, arcs)


def oval_outline(oval: Oval, *, tolerance: float) -> Outline:
    """Outline of a whole ellipse, with exactly its area; see `curved_outline`."""
    whole = replace(oval, start=0.0, end=2.0 * np.pi)
    return curved_outline([[oval.x + oval.a, oval.z]], {0: whole}, tolerance=tolerance)


def _between_extremes(oval: Oval) -> list[Oval]:
    """Divide a piece of an ellipse where it is level or upright."""
    low, high = sorted((oval.start, oval.end))
    extremes = QUARTER * np.arange(np.ceil(low / QUARTER), np.floor(high / QUARTER) + 1.0)
    inner = extremes[(extremes > low + SLIVER) & (extremes < high - SLIVER)]
    ends = [low, *inner.tolist(), high]
    if oval.end < oval.start:
        ends.reverse()
    return [replace(oval, start=s, end=e) for s, e in pairwise(ends)]


def chord_count(radius: float, sweep: float, tolerance: float) -> int:
    """How many chords keep within a tolerance, m, of an arc of a circle, for the polygon to have its area.

    An ellipse needs as many as the circle about it. At least 2, at most `MOST`, none of more than 45 degrees.

    Examples
    --------
    >>> chord_count(1.0, np.pi, 0.001)
    36
    """
    # A chord of the angle s leaves the arc by radius (1 - cos s/2) = 2 radius sin² s/4.
    share = min(tolerance / max(radius, tolerance), 0.5)
    step = min(4.0 * float(np.arcsin(np.sqrt(share / 2.0))), WIDEST)
    count = max(2, min(int(np.ceil(abs(sweep) / step - 1e-9)), MOST))
    # The one corner between two chords lies farther outside of the arc than they lie inside.
    half = abs(sweep) / 2.0
    return 3 if count == 2 and half - np.sin(half) > share * np.sin(half) else count


def _facets(oval: Oval, tolerance: float) -> FloatArray:
    """Corners (k, 2), m, of a piece of an ellipse, both ends included."""
    count = chord_count(max(oval.a, oval.b), oval.end - oval.start, tolerance)
    return facet_arc(Arc(0, 0, oval.x, oval.z, oval.a, oval.b), oval.start, oval.end, count=count)
