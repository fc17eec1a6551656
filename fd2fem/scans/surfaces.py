"""Where rays meet surfaces: closed forms over many rays at once.

Every function takes one origin (3,) and unit directions (n, 3) and tells how far along each ray the
surface lies. Lengths in m; any right-handed frame with z up.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "REFLECTANCE",
    "Chord",
    "Hits",
    "Material",
    "box_chord",
    "ellipsoid_chord",
    "hit_box",
    "hit_cylinder",
    "hit_plane",
    "hit_prism",
    "hit_rectangle",
    "nearest",
    "no_hits",
]

FloatArray = NDArray[np.float64]

OUT_OF_REACH = 1e9
"""A hit farther away than this, m, is a ray along the surface."""


class Material(IntEnum):
    """What a ray met."""

    NOTHING = 0
    WALL = 1
    REVEAL = 2
    FRAME = 3
    GLASS = 4
    ROOM = 5
    GROUND = 6
    NEIGHBOUR = 7
    POST = 8
    VEHICLE = 9
    FOLIAGE = 10


REFLECTANCE: FloatArray = np.array([0.0, 0.55, 0.6, 0.85, 0.15, 0.4, 0.25, 0.5, 0.3, 0.7, 0.45])
"""Share of the light that each `Material` sends back at normal incidence; plausible, not measured."""


class Hits(NamedTuple):
    """Where n rays met a surface.

    Attributes
    ----------
    distance : (n,) float array, m
        Along the ray; infinite where it missed.
    cosine : (n,) float array
        Of the angle between the ray and the surface's normal, 0 to 1.
    material : (n,) int array
        `Material` of the surface; meaningless where the ray missed.
    """

    distance: FloatArray
    cosine: FloatArray
    material: NDArray[np.uint8]


class Chord(NamedTuple):
    """The part of each ray inside a convex body: from `enter` to `leave`, m; none where enter >= leave.

    `axis` (n,) is the coordinate axis of the face through which a ray enters, where the body has faces.
    """

    enter: FloatArray
    leave: FloatArray
    axis: NDArray[np.intp]


def no_hits(count: int) -> Hits:
    """`count` rays that meet nothing.

    Examples
    --------
    >>> no_hits(2).distance.tolist()
    [inf, inf]
    """
    return Hits(np.full(count, np.inf), np.zeros(count), np.zeros(count, dtype=np.uint8))


def nearest(first: Hits, second: Hits) -> Hits:
    """For each ray the nearer one of two hits."""
    closer = second.distance < first.distance
    return Hits(
        np.where(closer, second.distance, first.distance),
        np.where(closer, second.cosine, first.cosine),
        np.where(closer, second.material, first.material),
    )


def hit_plane(
    origin: ArrayLike,
    directions: FloatArray,
    *,
    point: ArrayLike,
    normal: ArrayLike,
    material: Material,
) -> Hits:
    """Rays against an infinite plane through `point` (3,) with unit `normal` (3,).

    Examples
    --------
    >>> down = np.array([[0.0, 0.0, -1.0]])
    >>> hits = hit_plane([0, 0, 2], down, point=[0, 0, 0], normal=[0, 0, 1], material=Material.GROUND)
    >>> hits.distance.tolist()
    [2.0]
    """
    direction = np.asarray(normal, dtype=np.float64)
    towards = directions @ direction
    height = float((np.asarray(point, dtype=np.float64) - np.asarray(origin, dtype=np.float64)) @ direction)
    return _as_hits(height / _nonzero(towards), np.abs(towards), material=material)


def hit_rectangle(
    origin: ArrayLike,
    directions: FloatArray,
    *,
    corner: ArrayLike,
    sides: ArrayLike,
    material: Material,
) -> Hits:
    """Rays against a rectangle with one `corner` (3,) and two orthogonal `sides` (2, 3) from there."""
    start = np.asarray(corner, dtype=np.float64)
    first, second = np.asarray(sides, dtype=np.float64)
    normal = np.cross(first, second)
    normal /= np.linalg.norm(normal)
    hits = hit_plane(origin, directions, point=start, normal=normal, material=material)
    offset = np.asarray(origin, dtype=np.float64) - start
    met = np.isfinite(hits.distance)
    for side in (first, second):
        along = offset @ side + np.where(met, hits.distance, 0.0) * (directions @ side)
        met &= (along >= 0.0) & (along <= side @ side)
    return hits._replace(distance=np.where(met, hits.distance, np.inf))


def hit_prism(
    origin: ArrayLike, directions: FloatArray, *, ring: FloatArray, depth: float, material: Material
) -> Hits:
    """Rays against the sides of a polygon `ring` (k, 2) in x and z, extruded from y = 0 to `depth`.

    One rectangle for each segment of the ring: the reveals of an opening, or the flanks of a wall.
    """
    hits = no_hits(len(directions))
    for (x0, z0), (x1, z1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        sides = [[x1 - x0, 0.0, z1 - z0], [0.0, depth, 0.0]]
        side = hit_rectangle(origin, directions, corner=[x0, 0.0, z0], sides=sides, material=material)
        hits = nearest(hits, side)
    return hits


def box_chord(origin: ArrayLike, directions: FloatArray, *, lower: ArrayLike, upper: ArrayLike) -> Chord:
    """The part of each ray inside a box along the axes, by slabs.

    References
    ----------
    Kay, T. L. and Kajiya, J. T. (1986): Ray tracing complex scenes. SIGGRAPH 20(4), 269-278.

    Examples
    --------
    >>> chord = box_chord([0, 0, 0], np.array([[0.0, 1.0, 0.0]]), lower=[-1, 2, -1], upper=[1, 5, 1])
    >>> chord.enter.tolist(), chord.leave.tolist()
    ([2.0], [5.0])
    """
    start = np.asarray(origin, dtype=np.float64)
    steps = _nonzero(directions)
    low = (np.asarray(lower, dtype=np.float64) - start) / steps
    high = (np.asarray(upper, dtype=np.float64) - start) / steps
    near = np.minimum(low, high)
    axis = near.argmax(axis=1)
    enter = np.take_along_axis(near, axis[:, None], axis=1)[:, 0]
    return Chord(enter, np.maximum(low, high).min(axis=1), axis)


def hit_box(
    origin: ArrayLike, directions: FloatArray, *, lower: ArrayLike, upper: ArrayLike, material: Material
) -> Hits:
    """Rays against the outside of a box along the axes."""
    chord = box_chord(origin, directions, lower=lower, upper=upper)
    return _enter(chord, np.abs(np.take_along_axis(directions, chord.axis[:, None], axis=1)[:, 0]), material)


def hit_cylinder(
    origin: ArrayLike,
    directions: FloatArray,
    *,
    base: tuple[float, float],
    radius: float,
    height: float,
    material: Material,
) -> Hits:
    """Rays against a closed upright cylinder on the ground: axis at `base` (x, y), from z = 0 to `height`.

    Examples
    --------
    >>> ahead = np.array([[0.0, 1.0, 0.0]])
    >>> hits = hit_cylinder([0, 0, 1], ahead, base=(0, 5), radius=0.5, height=2, material=Material.POST)
    >>> hits.distance.tolist()
    [4.5]
    """
    start = np.asarray(origin, dtype=np.float64)
    offset = start[:2] - np.asarray(base, dtype=np.float64)
    mantle = _quadratic_chord(
        np.sum(directions[:, :2] ** 2, axis=1), directions[:, :2] @ offset, float(offset @ offset) - radius**2
    )
    steps = _nonzero(directions[:, 2])
    ends = (-start[2] / steps, (height - start[2]) / steps)
    slab = np.minimum(*ends)
    capped = slab > mantle.enter
    chord = Chord(
        np.maximum(slab, mantle.enter), np.minimum(np.maximum(*ends), mantle.leave), np.where(capped, 2, 0)
    )
    along = np.where(chord.enter < chord.leave, chord.enter, 0.0)
    radial = np.einsum("ij,ij->i", offset + along[:, None] * directions[:, :2], directions[:, :2]) / radius
    return _enter(
        chord, np.where(capped, np.abs(directions[:, 2]), np.minimum(np.abs(radial), 1.0)), material
    )


def ellipsoid_chord(
    origin: ArrayLike, directions: FloatArray, *, centre: ArrayLike, radii: ArrayLike
) -> Chord:
    """The part of each ray inside an ellipsoid with its `radii` (3,) along the axes.

    Examples
    --------
    >>> chord = ellipsoid_chord([0, 0, 0], np.array([[0.0, 1.0, 0.0]]), centre=[0, 5, 0], radii=[1, 2, 1])
    >>> chord.enter.tolist(), chord.leave.tolist()
    ([3.0], [7.0])
    """
    scale = np.asarray(radii, dtype=np.float64)
    offset = (np.asarray(origin, dtype=np.float64) - np.asarray(centre, dtype=np.float64)) / scale
    steps = directions / scale
    return _quadratic_chord(np.sum(steps**2, axis=1), steps @ offset, float(offset @ offset) - 1.0)


def _quadratic_chord(a: FloatArray, half_b: FloatArray, c: float) -> Chord:
    """Where a t² + 2 half_b t + c < 0; empty chords run from inf to -inf."""
    a = _nonzero(a)
    discriminant = half_b**2 - a * c
    root = np.sqrt(np.maximum(discriminant, 0.0))
    inside = discriminant > 0.0
    enter = np.where(inside, (-half_b - root) / a, np.inf)
    leave = np.where(inside, (-half_b + root) / a, -np.inf)
    return Chord(enter, leave, np.zeros(len(a), dtype=np.intp))


def _enter(chord: Chord, cosine: FloatArray, material: Material) -> Hits:
    """Hits where the rays enter a body."""
    return _as_hits(np.where(chord.enter < chord.leave, chord.enter, np.inf), cosine, material=material)


def _as_hits(distance: FloatArray, cosine: FloatArray, *, material: Material) -> Hits:
    """Hits of one material; what lies behind the origin, or a parallel plane, is missed."""
    ahead = np.where((distance > 0.0) & (distance < OUT_OF_REACH), distance, np.inf)
    return Hits(ahead, cosine, np.full(len(distance), material, dtype=np.uint8))


def _nonzero(values: FloatArray) -> FloatArray:
    """`values` with zeros made so small that a quotient is out of reach, but finite."""
    return np.where(np.abs(values) < 1e-30, 1e-30, values)
