"""Curved edges: runs of an outline's corners that stand for a piece of an ellipse or a circle.

Outlines are polygons everywhere. Where one is a polygon only because the true edge is curved, an `Arc` says
so, and CAD files can have the true curve. The corners between an arc's ends lie so far outside of it that
the polygon has exactly the area of the true shape; so all files of a facade have one volume.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_points, check_positive

__all__ = ["Arc", "arc_angles", "arc_corners", "check_arcs", "facet_arc"]

FloatArray = NDArray[np.float64]

ON_CURVE = 1e-6
"""The ends of an arc lie on it within this, m."""
SAME_AREA = 1e-6
"""Largest difference of area between an arc and its corners, relative to its radii's product."""
WIDEST = 2.0 * np.pi / 3.0
"""Largest angle of a chord, radians."""
NEAR = 0.2
"""Corners of an arc lie within this part of its radii of it."""


@dataclass(frozen=True)
class Arc:
    """A piece of an ellipse with level and upright axes (of a circle, where they are equal).

    Attributes
    ----------
    first, last : int
        The corners of the outline where it begins and ends, in the outline's order, which may pass the
        end of the list; equal where the whole outline is the curve, whose corners then are all outside.
    x, z : float, m
        Centre.
    a, b : float, m
        Half axes along x and z.
    """

    first: int
    last: int
    x: float
    z: float
    a: float
    b: float

    def __post_init__(self) -> None:
        check_positive("a", self.a)
        check_positive("b", self.b)

    @property
    def whole(self) -> bool:
        """Whether the curve is closed."""
        return self.first == self.last


def arc_corners(arc: Arc, ring: ArrayLike) -> FloatArray:
    """Corners (k, 2), m, of an arc within its outline, in order, both ends included.

    Examples
    --------
    >>> square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    >>> arc_corners(Arc(3, 1, 0.0, 0.0, 1.0, 1.0), square).tolist()
    [[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]
    """
    points = as_points("ring", ring, dim=2)
    count = len(points)
    steps = (arc.last - arc.first) % count or count
    taken: FloatArray = points[(arc.first + np.arange(steps + 1)) % count]
    return taken


def arc_angles(arc: Arc, ring: ArrayLike) -> tuple[float, float]:
    """Angles of an arc's two ends, radians, about its centre; the second is less where it runs clockwise.

    At the angle t lies the point (x + a cos t, z + b sin t).

    Examples
    --------
    >>> quarter = [[1.0, 0.0], [0.8, 0.8], [0.0, 1.0], [0.0, 0.0]]
    >>> [round(float(np.degrees(angle)), 9) for angle in arc_angles(Arc(0, 2, 0.0, 0.0, 1.0, 1.0), quarter)]
    [0.0, 90.0]
    """
    corners = arc_corners(arc, ring)
    angle = np.arctan2((corners[:, 1] - arc.z) / arc.b, (corners[:, 0] - arc.x) / arc.a)
    turned = np.unwrap(angle)
    return float(turned[0]), float(turned[-1])


def facet_arc(arc: Arc, start: float, end: float, *, count: int) -> FloatArray:
    """Corners (count + 1, 2), m, of a polygon that has the area of an arc; its two ends lie on the arc.

    Parameters
    ----------
    arc : Arc
        Its centre and half axes count.
    start, end : float, radians
        Angles of its ends.
    count : int
        Chords, at least 2.

    Raises
    ------
    InputError
        If there are fewer, or each spans more than a third of the circle.

    Examples
    --------
    >>> from fd2fem.model.checks import signed_area
    >>> half = facet_arc(Arc(0, 0, 0.0, 0.0, 1.0, 1.0), 0.0, np.pi, count=6)
    >>> bool(abs(signed_area(half) - np.pi / 2) < 1e-12)
    True
    """
    if count < 2 or abs(end - start) > count * WIDEST:
        msg = f"Invalid 'count': an arc needs at least 2 chords, of at most 120 degrees each, got {count}."
        raise InputError(msg)
    angle = np.linspace(start, end, count + 1)
    step = abs(end - start) / count
    # About the centre, in units of a·b/2: 2 k sin(step) + (count - 2) k² sin(step) = |end - start|.
    inner, sector = float(count - 2), step * count / np.sin(step)
    scale = sector / 2.0 if inner == 0.0 else (np.sqrt(1.0 + inner * sector) - 1.0) / inner
    factor = np.full(count + 1, scale)
    factor[[0, -1]] = 1.0
    return np.column_stack([arc.x + arc.a * factor * np.cos(angle), arc.z + arc.b * factor * np.sin(angle)])


def check_arcs(name: str, ring: FloatArray, arcs: Iterable[Arc]) -> tuple[Arc, ...]:
    """Return arcs that agree with the outline `ring` (k, 2), m.

    Raises
    ------
    InputError
        If one names a corner that is not there, overlaps another one, leaves its corners, or has another
        area than they.
    """
    checked = tuple(arcs)
    taken = np.zeros(len(ring), dtype=bool)
    for number, arc in enumerate(checked, start=1):
        where = f"Invalid arc {number} of '{name}'"
        if not (0 <= arc.first < len(ring) and 0 <= arc.last < len(ring)):
            msg = f"{where}: corners {arc.first} to {arc.last} of an outline of {len(ring)} corners."
            raise InputError(msg)
        steps = (arc.last - arc.first) % len(ring) or len(ring)
        chords = (arc.first + np.arange(steps)) % len(ring)
        if taken[chords].any():
            msg = f"{where}: it overlaps another arc; give each edge of the outline to one."
            raise InputError(msg)
        taken[chords] = True
        _check_fit(where, arc, ring)
    return checked


def _check_fit(where: str, arc: Arc, ring: FloatArray) -> None:
    corners = arc_corners(arc, ring)
    local = (corners - [arc.x, arc.z]) / [arc.a, arc.b]
    radius = np.hypot(*local.T)
    if not arc.whole and np.abs(radius[[0, -1]] - 1.0).max() * max(arc.a, arc.b) > ON_CURVE:
        msg = f"{where}: its ends do not lie on the curve; correct its centre or half axes, or leave it out."
        raise InputError(msg)
    if np.abs(radius - 1.0).max() > NEAR:
        msg = f"{where}: its corners leave the curve; correct its centre or half axes, or leave it out."
        raise InputError(msg)
    start, end = arc_angles(arc, ring)
    sectors = local[:-1, 0] * local[1:, 1] - local[1:, 0] * local[:-1, 1]
    if abs(float(sectors.sum()) - (end - start)) > SAME_AREA:
        msg = f"{where}: its corners bound another area than the curve; facet it anew, or leave it out."
        raise InputError(msg)
