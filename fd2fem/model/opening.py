"""The openings of a facade, and the gaps in its points that are none."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.arcs import Arc, check_arcs
from fd2fem.model.checks import as_ring, signed_area

__all__ = [
    "EdgeSigma",
    "FilledHole",
    "Opening",
    "OpeningKind",
    "check_openings",
    "number_by_rows",
    "outline_with_arcs",
    "rectangle",
]

TOUCH = 1e-6
"""Two edges closer than this, m, are taken to touch."""
NARROW = 1e-3
"""No opening is as narrow as this, m: its size is wrong, or its unit."""


class OpeningKind(StrEnum):
    """What an opening is: a door reaches the ground, a window does not."""

    WINDOW = "window"
    DOOR = "door"


def rectangle(x: float, z: float, width: float, height: float) -> NDArray[np.float64]:
    """Corners (4, 2), counter-clockwise from the lower left one.

    Examples
    --------
    >>> rectangle(1, 2, 3, 4).tolist()
    [[1.0, 2.0], [4.0, 2.0], [4.0, 6.0], [1.0, 6.0]]
    """
    return np.array([[x, z], [x + width, z], [x + width, z + height], [x, z + height]], dtype=np.float64)


@dataclass(frozen=True)
class EdgeSigma:
    """Standard error of each edge of an opening, m."""

    left: float = 0.0
    right: float = 0.0
    bottom: float = 0.0
    top: float = 0.0


@dataclass(frozen=True, eq=False)
class Opening:
    """A window or door.

    Attributes
    ----------
    id : int
        Number within the facade, from 1, by rows from the ground, left to right.
    kind : OpeningKind
    outline : (k, 2) float array, m
        Facade frame, counter-clockwise, not closed.
    confidence : float
        Between 0 and 1; 1 in a drawing.
    evidence : mapping
        What spoke for the verdict; JSON values.
    sigma : EdgeSigma
    arcs : tuple of Arc
        Which corners of the outline stand for a curved edge.
    """

    id: int
    kind: OpeningKind
    outline: NDArray[np.float64]
    confidence: float = 1.0
    evidence: Mapping[str, Any] = field(default_factory=dict)
    sigma: EdgeSigma = field(default_factory=EdgeSigma)
    arcs: tuple[Arc, ...] = ()

    def __post_init__(self) -> None:
        name = f"outline of opening {self.id}"
        arcs = tuple(self.arcs)
        object.__setattr__(self, "outline", outline_with_arcs(name, self.outline, arcs))
        object.__setattr__(self, "arcs", check_arcs(name, self.outline, arcs))
        object.__setattr__(self, "evidence", MappingProxyType(dict(self.evidence)))

    @property
    def x(self) -> float:
        """Left edge of the bounding rectangle, m."""
        return float(self.outline[:, 0].min())

    @property
    def z(self) -> float:
        """Lower edge of the bounding rectangle, m."""
        return float(self.outline[:, 1].min())

    @property
    def width(self) -> float:
        """Width of the bounding rectangle, m."""
        return float(np.ptp(self.outline[:, 0]))

    @property
    def height(self) -> float:
        """Height of the bounding rectangle, m."""
        return float(np.ptp(self.outline[:, 1]))

    @property
    def area(self) -> float:
        """Area of the outline, m²."""
        return signed_area(self.outline)


def number_by_rows(openings: Iterable[Opening]) -> tuple[Opening, ...]:
    """Number openings from 1: row by row from the ground, in a row from left to right.

    A row ends where an opening starts above the lowest head in it.

    Examples
    --------
    >>> boxes = [rectangle(3, 1.5, 1, 1), rectangle(1, 4, 1, 1), rectangle(1, 1, 1, 1)]
    >>> numbered = number_by_rows(Opening(0, OpeningKind.WINDOW, box) for box in boxes)
    >>> [(opening.id, opening.x, opening.z) for opening in numbered]
    [(1, 1.0, 1.0), (2, 3.0, 1.5), (3, 1.0, 4.0)]
    """
    rows: list[list[Opening]] = []
    head = -np.inf
    for opening in sorted(openings, key=lambda opening: opening.z):
        if opening.z >= head:
            rows.append([])
            head = np.inf
        rows[-1].append(opening)
        head = min(head, opening.z + opening.height)
    ordered = [opening for row in rows for opening in sorted(row, key=lambda opening: opening.x)]
    return tuple(replace(opening, id=number) for number, opening in enumerate(ordered, start=1))


@dataclass(frozen=True, eq=False)
class FilledHole:
    """A gap in the points that is not an opening: the wall goes on behind it.

    `outline` (k, 2), m, facade frame, counter-clockwise; `reason` is one sentence.
    """

    outline: NDArray[np.float64]
    reason: str
    evidence: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "outline", as_ring("outline of a filled hole", self.outline))
        object.__setattr__(self, "evidence", MappingProxyType(dict(self.evidence)))

    @property
    def area(self) -> float:
        """Area of the outline, m²."""
        return signed_area(self.outline)


def outline_with_arcs(name: str, outline: NDArray[np.float64], arcs: tuple[Arc, ...]) -> NDArray[np.float64]:
    """The outline as a ring; with arcs, whose numbers it keeps, it must be one already."""
    ring = as_ring(name, outline)
    if arcs and not np.array_equal(ring, np.asarray(outline, dtype=np.float64)):
        msg = f"Invalid '{name}': with arcs it must run counter-clockwise and not repeat a corner."
        raise InputError(msg)
    return ring


def check_openings(outline: NDArray[np.float64], openings: tuple[Opening, ...]) -> None:
    """Raise unless each opening lies in the wall (a door may reach the ground) and apart from the others."""
    import shapely
    from shapely.geometry.base import BaseGeometry

    wall = shapely.Polygon(outline)
    shapes = [shapely.Polygon(opening.outline) for opening in openings]
    ground = shapely.LineString([(wall.bounds[0], 0.0), (wall.bounds[2], 0.0)]).buffer(2 * TOUCH)
    for opening, shape in zip(openings, shapes, strict=True):
        edges: BaseGeometry = wall.boundary
        if min(opening.width, opening.height) < NARROW:
            msg = f"{_name(opening)} is narrower than a millimetre: correct its size, or leave it out."
            raise InputError(msg)
        if not wall.buffer(TOUCH).contains(shape):
            msg = f"{_name(opening)} does not lie inside the wall: move it or correct the wall's outline."
            raise InputError(msg)
        if opening.kind is OpeningKind.DOOR:
            if opening.z > TOUCH:
                msg = f"{_name(opening)} does not reach the ground at z = 0: call it a window or lower it."
                raise InputError(msg)
            edges = edges.difference(ground)
        elif opening.z < TOUCH:
            msg = f"{_name(opening)} touches the edge of the wall at the ground: call it a door or raise it."
            raise InputError(msg)
        if edges.distance(shape) < TOUCH:
            msg = f"{_name(opening)} touches the edge of the wall: leave wall there or change the outline."
            raise InputError(msg)
    tree = shapely.STRtree(shapes)
    for first, shape in enumerate(shapes):
        for second in tree.query(shape.buffer(TOUCH)):
            if first < second and shapes[second].distance(shape) < TOUCH:
                msg = (
                    f"openings {openings[first].id} and {openings[second].id} touch or overlap: "
                    "leave wall between them, or make them one."
                )
                raise InputError(msg)


def _name(opening: Opening) -> str:
    """An opening as a message names it."""
    return (
        f"opening {opening.id} ({opening.kind}, {opening.width:.3f} x {opening.height:.3f} m "
        f"at x = {opening.x:.3f}, z = {opening.z:.3f})"
    )
