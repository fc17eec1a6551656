"""The edges of a wall seen from outside, as CAD draws them: straight ones and true arcs, no idle corners.

A facade's polygons say which of their corners stand for a curve. Here each such run of corners becomes one
edge again, and the doors become notches of the wall's outer rim.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Facade, Opening, OpeningKind
from fd2fem.model.outlines import Oval
from fd2fem.solids.rim_edges import Edge, rim_edges

__all__ = ["WallRims", "backwards_rim", "rim_points", "wall_extent", "wall_rims"]

FloatArray = NDArray[np.float64]

GROUND = 2e-6
"""A door stands on the ground to within the tolerance of its record, m."""
QUARTER = np.pi / 2.0


@dataclass(frozen=True)
class WallRims:
    """Closed chains of edges with the wall on their left: `outer`, and `holes`, one for each window."""

    outer: tuple[Edge, ...]
    holes: tuple[tuple[Edge, ...], ...]

    @property
    def all(self) -> tuple[tuple[Edge, ...], ...]:
        """The outer rim, then the holes."""
        return (self.outer, *self.holes)


def wall_rims(facade: Facade) -> WallRims:
    """Rims of the wall of `facade`.

    Raises
    ------
    InputError
        If a door parts the wall, or leaves a piece that hangs by a point.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> door = Opening(1, OpeningKind.DOOR, rectangle(1, 0, 1, 2))
    >>> rims = wall_rims(Facade(rectangle(0, 0, 4, 3), 0.3, (door,)))
    >>> [edge.start for edge in rims.outer]
    [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (2.0, 2.0), (2.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]
    """
    ground = float(facade.outline[:, 1].min())
    outer = rim_edges(facade.outline, facade.arcs)
    holes: list[tuple[Edge, ...]] = []
    for opening in facade.openings:
        if opening.kind is OpeningKind.DOOR:
            outer = _notched(outer, opening, ground)
        else:
            holes.append(backwards_rim(rim_edges(opening.outline, opening.arcs)))
    return WallRims(outer, tuple(holes))


def wall_extent(facade: Facade) -> FloatArray:
    """Extent (3,), m, of the wall in x, y and z, its curved edges taken as curves.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> wall_extent(Facade(rectangle(0, 0, 4, 3), 0.3)).tolist()
    [4.0, 0.3, 3.0]
    """
    width, height = np.ptp(rim_points(wall_rims(facade).outer), axis=0)
    return np.array([width, max(band.thickness for band in facade.bands), height])


def rim_points(rim: Sequence[Edge]) -> FloatArray:
    """Points (k, 2), m, as far as a rim extends: its corners, and where curves are level or upright."""
    points: list[tuple[float, float]] = []
    for edge in rim:
        points.append(edge.start)
        if edge.oval is not None:
            points += _extremes(edge.oval)
    return np.array(points)


def _extremes(oval: Oval) -> list[tuple[float, float]]:
    """Where a piece of an ellipse is level or upright, m."""
    low, high = sorted((oval.start, oval.end))
    turns = QUARTER * np.arange(np.ceil(low / QUARTER), np.floor(high / QUARTER) + 1.0)
    return [(float(oval.x + oval.a * np.cos(t)), float(oval.z + oval.b * np.sin(t))) for t in turns]


def backwards_rim(rim: Sequence[Edge]) -> tuple[Edge, ...]:
    """The edges of a rim the other way round."""
    turned = []
    for edge in reversed(rim):
        oval = edge.oval
        if oval is not None:
            oval = replace(oval, start=oval.end, end=oval.start)
        turned.append(Edge(edge.end, edge.start, oval))
    return tuple(turned)


def _notched(outer: Sequence[Edge], door: Opening, ground: float) -> tuple[Edge, ...]:
    """The outer rim around a door."""
    outline = door.outline.copy()
    outline[outline[:, 1] < ground + GROUND, 1] = ground
    rim = rim_edges(outline, door.arcs)
    standing = [edge for edge in rim if edge.start[1] == ground]
    feet = [n for n, edge in enumerate(rim) if edge.start[1] == edge.end[1] == ground and edge.oval is None]
    if len(feet) != 1 or len(standing) != 2:
        msg = (
            f"opening {door.id} (door, at x = {door.x:.3f}) stands on the ground in {len(standing)} corners, "
            "expected the two of one foot: the wall would fall into pieces or hang together by an edge."
        )
        raise InputError(msg)
    foot = rim[feet[0]]
    notch = backwards_rim((*rim[feet[0] + 1 :], *rim[: feet[0]]))
    left, right = foot.start[0], foot.end[0]
    for number, edge in enumerate(outer):
        level = edge.oval is None and max(edge.start[1], edge.end[1]) < ground + GROUND
        if level and edge.start[0] < left and right < edge.end[0]:
            before, after = Edge(edge.start, foot.start), Edge(foot.end, edge.end)
            return (*outer[:number], before, *notch, after, *outer[number + 1 :])
    msg = (
        f"opening {door.id} (door, at x = {door.x:.3f}) does not stand on a level part of the wall's "
        "outline: move it or correct the outline."
    )
    raise InputError(msg)
