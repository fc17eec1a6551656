"""Rays from a scanner against a facade and its scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Facade, Opening
from fd2fem.scans.scene import Scene
from fd2fem.scans.surfaces import (
    Hits,
    Material,
    box_chord,
    hit_plane,
    hit_prism,
    nearest,
    no_hits,
)

if TYPE_CHECKING:
    import shapely

__all__ = ["Target", "cast_rays", "prepare_target"]

FloatArray = NDArray[np.float64]

ROOM_SIDE = 0.5
"""How much farther than its opening a room reaches to each side, m."""
ROOM_BELOW = 0.9
"""How far below its opening a room's floor lies, m, at most down to the ground."""
ROOM_ABOVE = 0.3
"""How far above its opening a room's ceiling lies, m."""


@dataclass(frozen=True, eq=False)
class _Hollow:
    """An opening made ready: its polygon, the part of it that is glass, and the room behind."""

    ring: FloatArray
    polygon: shapely.Polygon
    glass: shapely.Geometry
    room_lower: tuple[float, float, float]
    room_upper: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Target:
    """A facade and its scene, made ready for rays by :func:`prepare_target`."""

    facade: Facade
    scene: Scene
    outline: shapely.Polygon
    wall: shapely.Geometry
    hollows: tuple[_Hollow, ...]


def prepare_target(facade: Facade, scene: Scene) -> Target:
    """Make the polygons of wall, openings and glass ready for many rays."""
    import shapely

    outline = shapely.Polygon(facade.outline)
    hollows = tuple(_prepare_opening(opening, scene) for opening in facade.openings)
    wall = outline.difference(shapely.union_all([hollow.polygon for hollow in hollows]))
    shapely.prepare([outline, wall])
    return Target(facade, scene, outline, wall, hollows)


def _prepare_opening(opening: Opening, scene: Scene) -> _Hollow:
    """The opening with its frame cut out and its room laid behind."""
    import shapely

    polygon = shapely.Polygon(opening.outline)
    half = 0.5 * scene.frame_width
    middle = opening.x + 0.5 * opening.width
    top = opening.z + opening.height
    mullion = shapely.box(middle - half, opening.z, middle + half, top)
    glass = polygon.buffer(-scene.frame_width).difference(mullion) if half > 0.0 else polygon
    shapely.prepare([polygon, glass])
    lower = (opening.x - ROOM_SIDE, scene.reveal_depth, max(0.0, opening.z - ROOM_BELOW))
    upper = (
        opening.x + opening.width + ROOM_SIDE,
        scene.reveal_depth + scene.room_depth,
        top + ROOM_ABOVE,
    )
    return _Hollow(opening.outline, polygon, glass, lower, upper)


def cast_rays(
    target: Target, origin: FloatArray, *, directions: FloatArray, chance: FloatArray, glass_return: float
) -> Hits:
    """The nearest surface that each ray meets.

    Parameters
    ----------
    target : Target
    origin : (3,) float array, m
        Where the scanner stands, facade frame, in front of the wall.
    directions : (n, 3) float array
        Unit vectors.
    chance : (n, 2) float array
        Random numbers in [0, 1) of each ray: a pane of glass returns it if the first is below
        `glass_return`, the second decides about leaves.
    glass_return : float
        Share of the rays that return from glass; the others go on into the room.
    """
    scene = target.scene
    hits = _hit_facade(target, origin, directions=directions, chance=chance[:, 0], glass_return=glass_return)
    if scene.ground:
        hits = nearest(hits, _hit_ground(target, origin, directions))
    for body in scene.bodies:
        hits = nearest(hits, body.hits(origin, directions, chance[:, 1]))
    return hits


def _hit_facade(
    target: Target, origin: FloatArray, *, directions: FloatArray, chance: FloatArray, glass_return: float
) -> Hits:
    """Rays against wall, flanks and openings: where a ray crosses y = 0 decides which of them it can meet."""
    import shapely

    face = hit_plane(origin, directions, point=(0, 0, 0), normal=(0, 1, 0), material=Material.WALL)
    reached = np.where(np.isfinite(face.distance), face.distance, 0.0)
    x = origin[0] + reached * directions[:, 0]
    z = origin[2] + reached * directions[:, 2]
    ahead = np.isfinite(face.distance)
    on_wall = ahead & shapely.contains_xy(target.wall, x, z)
    distance = np.where(on_wall, face.distance, np.inf)
    hits = Hits(distance, face.cosine, face.material)
    inside = ahead & ~on_wall & shapely.contains_xy(target.outline, x, z)
    for hollow in target.hollows:
        rays = np.flatnonzero(inside)
        rays = rays[shapely.contains_xy(hollow.polygon, x[rays], z[rays])]
        found = _hit_opening(
            target.scene,
            hollow,
            origin=origin,
            directions=directions[rays],
            chance=chance[rays],
            glass_return=glass_return,
        )
        _put(hits, rays, found)
    if target.scene.flank_depth > 0.0:
        rays = np.flatnonzero(ahead & ~on_wall & ~inside)
        ring, depth = target.facade.outline, target.scene.flank_depth
        _put(hits, rays, hit_prism(origin, directions[rays], ring=ring, depth=depth, material=Material.WALL))
    return hits


def _put(hits: Hits, rays: NDArray[np.intp], found: Hits) -> None:
    """Write what was found for some `rays` into all `hits`."""
    hits.distance[rays] = found.distance
    hits.cosine[rays] = found.cosine
    hits.material[rays] = found.material


def _hit_opening(
    scene: Scene,
    hollow: _Hollow,
    *,
    origin: FloatArray,
    directions: FloatArray,
    chance: FloatArray,
    glass_return: float,
) -> Hits:
    """Rays that enter an opening: its reveals, then frame or glass, then the room behind."""
    import shapely

    hits = no_hits(len(directions))
    if scene.reveal_depth > 0.0:
        hits = hit_prism(
            origin, directions, ring=hollow.ring, depth=scene.reveal_depth, material=Material.REVEAL
        )
    if scene.room_depth == 0.0:
        return hits
    pane = hit_plane(
        origin, directions, point=(0, scene.reveal_depth, 0), normal=(0, 1, 0), material=Material.GLASS
    )
    x = origin[0] + pane.distance * directions[:, 0]
    z = origin[2] + pane.distance * directions[:, 2]
    glazed = shapely.contains_xy(hollow.glass, x, z)
    pane.material[~glazed] = Material.FRAME
    through = glazed & (chance >= glass_return)
    _put(pane, np.flatnonzero(through), _hit_room(hollow, origin, directions[through]))
    return nearest(hits, pane)


def _hit_room(hollow: _Hollow, origin: FloatArray, directions: FloatArray) -> Hits:
    """Where rays that came in through the glass leave the room: a wall, its floor or ceiling."""
    chord = box_chord(origin, directions, lower=hollow.room_lower, upper=hollow.room_upper)
    at = origin + chord.leave[:, None] * directions
    gap = np.minimum(np.abs(at - hollow.room_lower), np.abs(at - hollow.room_upper))
    axis = gap.argmin(axis=1)
    cosine = np.abs(np.take_along_axis(directions, axis[:, None], axis=1)[:, 0])
    return Hits(chord.leave, cosine, np.full(len(directions), Material.ROOM, dtype=np.uint8))


def _hit_ground(target: Target, origin: FloatArray, directions: FloatArray) -> Hits:
    """Rays against the street: before the wall, and beside it as far as the neighbours stand back."""
    hits = hit_plane(origin, directions, point=(0, 0, 0), normal=(0, 0, 1), material=Material.GROUND)
    reached = np.where(np.isfinite(hits.distance), hits.distance, 0.0)
    x = origin[0] + reached * directions[:, 0]
    y = origin[1] + reached * directions[:, 1]
    street = (y <= 0.0) | (x < 0.0) | (x > target.facade.length)
    return hits._replace(distance=np.where(street, hits.distance, np.inf))
