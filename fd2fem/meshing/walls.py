"""The front of a wall as closed rings: the outline with its doors as notches, then the windows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.model import Facade, OpeningKind
from fd2fem.model.checks import signed_area

__all__ = ["WallRings", "is_rectilinear", "wall_rings"]

FloatArray = NDArray[np.float64]

SAME = 1e-11
"""Coordinates closer than this, m, differ by rounding alone: they are one and the same."""
GROUND = 2e-6
"""A door stands on the ground to within the tolerance of its record, m."""


@dataclass(frozen=True, eq=False)
class WallRings:
    """Rings of corners (k, 2), m: `outer` counter-clockwise, each of `holes` clockwise; no idle corners."""

    outer: FloatArray
    holes: tuple[FloatArray, ...]

    @property
    def all(self) -> tuple[FloatArray, ...]:
        """The outer ring, then the holes."""
        return (self.outer, *self.holes)


def wall_rings(facade: Facade) -> WallRings:
    """Rings of the wall of `facade`; coordinates that differ by rounding become equal.

    Raises
    ------
    MeshError
        If the openings cut the wall in two.
    """
    import shapely

    rings = _snap((facade.outline, *(opening.outline for opening in facade.openings)))
    wall: shapely.geometry.base.BaseGeometry = shapely.Polygon(rings[0])
    windows = []
    ground = rings[0][:, 1].min()
    for opening, ring in zip(facade.openings, rings[1:], strict=True):
        if opening.kind is OpeningKind.DOOR:
            ring[ring[:, 1] < ground + GROUND, 1] = ground
            wall = wall.difference(shapely.Polygon(ring))
        else:
            windows.append(_orient(_corners(ring), counter_clockwise=False))
    if not isinstance(wall, shapely.Polygon) or wall.interiors:
        msg = "The openings cut the wall into pieces that do not hang together: mesh the pieces one by one."
        raise MeshError(msg)
    outer = _orient(_corners(np.asarray(wall.exterior.coords)[:-1]), counter_clockwise=True)
    return WallRings(outer=outer, holes=tuple(windows))


def is_rectilinear(rings: WallRings) -> bool:
    """Whether all edges are horizontal or vertical."""
    return all(bool((np.roll(ring, -1, axis=0) == ring).any(axis=1).all()) for ring in rings.all)


def _snap(rings: tuple[FloatArray, ...]) -> list[FloatArray]:
    """Give coordinates that differ by rounding one value, so that == can compare them."""
    stacked = np.vstack(rings)
    for axis in (0, 1):
        order = np.argsort(stacked[:, axis], kind="stable")
        values = stacked[order, axis]
        first = np.r_[True, np.diff(values) > SAME]
        stacked[order, axis] = values[first][np.cumsum(first) - 1]
    return np.split(stacked, np.cumsum([len(ring) for ring in rings])[:-1])


def _corners(ring: FloatArray) -> FloatArray:
    """Drop repeated corners and those in the middle of a horizontal or vertical edge."""
    ring = ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)]
    before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
    corners: FloatArray = ring[~((before == ring) & (after == ring)).any(axis=1)]
    return corners


def _orient(ring: FloatArray, *, counter_clockwise: bool) -> FloatArray:
    return ring if (signed_area(ring) > 0.0) == counter_clockwise else ring[::-1]
