"""What surrounds a facade when it is scanned: ground, rooms, neighbours, and objects in the street.

All coordinates are in the facade frame, m: x along the wall, y into it (the street has y < 0), z up,
the ground at z = 0.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import checks
from fd2fem.scans.surfaces import (
    Hits,
    Material,
    ellipsoid_chord,
    hit_box,
    hit_cylinder,
    nearest,
    no_hits,
)

__all__ = ["Body", "Foliage", "Neighbour", "Post", "Scene", "Vehicle"]

FloatArray = NDArray[np.float64]
Point = tuple[float, float, float]

NEIGHBOUR_DEPTH = 8.0
"""How far a neighbouring building reaches back, m."""


class Body(Protocol):
    """Anything beside the facade that a ray can meet."""

    def hits(self, origin: FloatArray, directions: FloatArray, leaf: FloatArray) -> Hits:
        """Where rays from `origin` (3,) along `directions` (n, 3) meet it.

        `leaf` (n,) are the rays' random numbers in [0, 1): they decide whether leaves stop a ray.
        """
        ...

    def contains(self, point: Point) -> bool:
        """Whether a scanner cannot stand at `point`."""
        ...


@dataclass(frozen=True)
class Neighbour:
    """A neighbouring building: a plain wall from `start` to `end` along x with its front at y = `face`.

    Attributes
    ----------
    start, end, face, height : float, m
    """

    start: float
    end: float
    face: float
    height: float

    def __post_init__(self) -> None:
        checks.check_positive("height of a neighbour", self.height)
        checks.check_positive("length of a neighbour (end - start)", self.end - self.start)

    @property
    def corners(self) -> tuple[Point, Point]:
        """Lower and upper corner of its box."""
        return (self.start, self.face, 0.0), (self.end, self.face + NEIGHBOUR_DEPTH, self.height)

    def hits(self, origin: FloatArray, directions: FloatArray, leaf: FloatArray) -> Hits:  # noqa: ARG002
        """Where rays meet the building."""
        lower, upper = self.corners
        return hit_box(origin, directions, lower=lower, upper=upper, material=Material.NEIGHBOUR)

    def contains(self, point: Point) -> bool:
        """Whether `point` lies inside."""
        return _in_box(point, *self.corners)


@dataclass(frozen=True)
class Post:
    """An upright cylinder on the ground, say a lamp post.

    Attributes
    ----------
    x, y : float, m
        Its axis.
    radius, height : float, m
    """

    x: float
    y: float
    radius: float = 0.09
    height: float = 5.0

    def __post_init__(self) -> None:
        checks.check_positive("radius of a post", self.radius)
        checks.check_positive("height of a post", self.height)

    def hits(self, origin: FloatArray, directions: FloatArray, leaf: FloatArray) -> Hits:  # noqa: ARG002
        """Where rays meet the post."""
        return hit_cylinder(
            origin,
            directions,
            base=(self.x, self.y),
            radius=self.radius,
            height=self.height,
            material=Material.POST,
        )

    def contains(self, point: Point) -> bool:
        """Whether `point` lies inside."""
        return np.hypot(point[0] - self.x, point[1] - self.y) < self.radius and 0.0 <= point[2] < self.height


@dataclass(frozen=True)
class Vehicle:
    """A car parked along the wall: one box for the body, a shorter and narrower one on top for the cabin.

    Attributes
    ----------
    x, y : float, m
        Its middle.
    length, width, height : float, m
    clearance : float, m
        Between the ground and the body.
    """

    x: float
    y: float
    length: float = 4.2
    width: float = 1.75
    height: float = 1.5
    clearance: float = 0.2

    def __post_init__(self) -> None:
        for name in ("length", "width", "height"):
            checks.check_positive(f"{name} of a vehicle", getattr(self, name))
        if not 0.0 <= self.clearance < 0.5 * self.height:
            msg = (
                f"Invalid 'clearance' of a vehicle: expected 0 to half its height of {self.height} m, "
                f"got {self.clearance}."
            )
            raise InputError(msg)

    @property
    def boxes(self) -> tuple[tuple[Point, Point], tuple[Point, Point]]:
        """Lower and upper corners of body and cabin."""
        waist = self.clearance + 0.55 * (self.height - self.clearance)
        body = self._box(self.length, self.width, self.clearance, waist)
        return body, self._box(0.55 * self.length, 0.85 * self.width, waist, self.height)

    def _box(self, length: float, width: float, bottom: float, top: float) -> tuple[Point, Point]:
        lower = (self.x - 0.5 * length, self.y - 0.5 * width, bottom)
        return lower, (self.x + 0.5 * length, self.y + 0.5 * width, top)

    def hits(self, origin: FloatArray, directions: FloatArray, leaf: FloatArray) -> Hits:
        """Where rays meet body or cabin."""
        hits = no_hits(len(leaf))
        for lower, upper in self.boxes:
            box = hit_box(origin, directions, lower=lower, upper=upper, material=Material.VEHICLE)
            hits = nearest(hits, box)
        return hits

    def contains(self, point: Point) -> bool:
        """Whether `point` lies inside."""
        return any(_in_box(point, lower, upper) for lower, upper in self.boxes)


@dataclass(frozen=True)
class Foliage:
    """The crown of a tree, an ellipsoid of leaves that stop some rays, and its trunk.

    Attributes
    ----------
    centre, radii : (3,) tuples, m
    density : float, 1/m
        A ray that runs s metres through the leaves meets one with probability 1 - exp(-density·s).
    trunk_radius : float, m
        0: no trunk.
    """

    centre: Point
    radii: Point
    density: float = 2.0
    trunk_radius: float = 0.08

    def __post_init__(self) -> None:
        for radius in self.radii:
            checks.check_positive("radii of foliage", radius)
        checks.check_positive("density of foliage", self.density)
        if self.trunk_radius < 0.0:
            msg = f"Invalid 'trunk_radius' of foliage: expected 0 or more, got {self.trunk_radius}."
            raise InputError(msg)

    @property
    def trunk(self) -> tuple[Post, ...]:
        """The trunk up to the middle of the crown, or nothing."""
        if self.trunk_radius == 0.0:
            return ()
        return (Post(self.centre[0], self.centre[1], radius=self.trunk_radius, height=self.centre[2]),)

    def hits(self, origin: FloatArray, directions: FloatArray, leaf: FloatArray) -> Hits:
        """Where rays meet a leaf or the trunk."""
        chord = ellipsoid_chord(origin, directions, centre=self.centre, radii=self.radii)
        # The free path through leaves scattered at random is exponential; draw it by inversion.
        reach = chord.enter - np.log1p(-leaf) / self.density
        met = (chord.enter > 0.0) & (reach < chord.leave)
        hits = Hits(
            np.where(met, reach, np.inf),
            np.full(len(leaf), 0.7),  # leaves hang at all angles
            np.full(len(leaf), Material.FOLIAGE, dtype=np.uint8),
        )
        for post in self.trunk:
            hits = nearest(hits, post.hits(origin, directions, leaf))
        return hits

    def contains(self, point: Point) -> bool:
        """Whether `point` lies inside crown or trunk."""
        offset = (np.array(point) - self.centre) / self.radii
        return float(offset @ offset) < 1.0 or any(post.contains(point) for post in self.trunk)


@dataclass(frozen=True)
class Scene:
    """What a scanner sees besides the wall's front face.

    Attributes
    ----------
    ground : bool
        Whether there is a street at z = 0.
    reveal_depth : float, m
        From the wall's face to the window frames; the openings' reveals reach to there. 0: none.
    flank_depth : float, m
        How far back the wall's outer edges are seen. 0: not at all.
    frame_width : float, m
        Of the window frames and of the mullion in the middle.
    room_depth : float, m
        Of the room behind each opening. 0: nothing returns from an opening but its reveals.
    neighbours : tuple of Neighbour
    objects : tuple of Post, Vehicle or Foliage
    margin : float, m
        How far the scan reaches beyond the wall to the left, to the right and upwards.
    """

    ground: bool = True
    reveal_depth: float = 0.12
    flank_depth: float = 0.35
    frame_width: float = 0.06
    room_depth: float = 4.0
    neighbours: tuple[Neighbour, ...] = ()
    objects: tuple[Body, ...] = ()
    margin: float = 2.0

    def __post_init__(self) -> None:
        for name in ("reveal_depth", "flank_depth", "frame_width", "room_depth", "margin"):
            value = float(getattr(self, name))
            if not (np.isfinite(value) and value >= 0.0):
                msg = f"Invalid '{name}' of the scene: expected 0 or more, got {value}."
                raise InputError(msg)

    @classmethod
    def empty(cls) -> "Scene":
        """The wall's front face alone: openings and street return nothing, as in a cleaned scan."""
        return cls(
            ground=False, reveal_depth=0.0, flank_depth=0.0, frame_width=0.0, room_depth=0.0, margin=0.02
        )

    @property
    def bodies(self) -> tuple[Body, ...]:
        """Neighbours and objects."""
        return (*self.neighbours, *self.objects)


def _in_box(point: Point, lower: Point, upper: Point) -> bool:
    """Whether a point lies in a box along the axes."""
    return all(low <= value <= high for low, value, high in zip(lower, point, upper, strict=True))
