"""Which way a solid stands that was drawn elsewhere, and which of its surfaces are a wall's base, front, ...

Both are told by the facets of its mesh alone, so it does not matter which program made the solid, in which
format, and into how many faces it divided a surface.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import GROUPS, FacadeFrame, Group
from fd2fem.model.sides import side_groups

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

__all__ = ["Facets", "group_facets", "wall_frame"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

TURN = 1e-3
"""Directions that differ by less than this, radians, are one."""
ALIGNED = 1.0 - TURN**2 / 2.0
"""Cosine of that angle."""
PARALLEL = 1e-6
"""A wall that leaves the direction of y by less than this, radians, runs along it."""
SAME = 1e-4
"""Planes closer than this, m, are one."""


@dataclass(frozen=True, eq=False)
class Facets:
    """Plane triangles: `centre` (f, 3), m; `normal` (f, 3), outward, of unit length; `area` (f,), m²."""

    centre: FloatArray
    normal: FloatArray
    area: FloatArray

    @classmethod
    def of(cls, nodes: FloatArray, facets: IntArray) -> "Facets":
        """Those between the first three of the nodes (n, 3) of each facet (f, 3 or more)."""
        corner = nodes[facets[:, :3]]
        vector = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2.0
        area = np.linalg.norm(vector, axis=1)
        return cls(corner.mean(axis=1), vector / area[:, None], area)


def wall_frame(nodes: FloatArray, facets: IntArray) -> FacadeFrame:
    """The facade frame of a wall whose boundary is `facets` (f, 3 or more) between `nodes` (n, 3), m.

    The largest vertical plane says how the wall runs; of the largest planes on its two sides, the one that
    looks towards -y (towards -x where the wall runs along y) is the front, y = 0. The lowest point of the
    solid is z = 0, its leftmost one x = 0.

    Raises
    ------
    InputError
        If there is no vertical plane.
    """
    sides = Facets.of(nodes, facets)
    upright = np.abs(sides.normal[:, 2]) < TURN
    if not upright.any():
        msg = "The solid has no vertical plane face: z must point up."
        raise InputError(msg)
    heading = np.mod(np.arctan2(sides.normal[upright, 1], sides.normal[upright, 0]), np.pi)
    best, direction = 0.0, np.array([0.0, -1.0, 0.0])
    for angles in _runs(heading, tolerance=TURN):
        chosen = np.flatnonzero(upright)[angles]
        normal = sides.normal[chosen[np.argmax(sides.area[chosen])]] * [1.0, 1.0, 0.0]
        normal = _outward((normal / np.linalg.norm(normal)).round(12))
        depth = sides.centre[chosen] @ normal
        largest = max(float(sides.area[chosen[plane]].sum()) for plane in _runs(depth, tolerance=SAME))
        if largest > best:
            best, direction = largest, normal
    axes = np.array([np.cross(-direction, [0.0, 0.0, 1.0]), -direction, [0.0, 0.0, 1.0]])
    local = nodes @ axes.T
    facing = np.flatnonzero(sides.normal @ direction > ALIGNED)
    depth = sides.centre[facing] @ axes[1]
    front = max(_runs(depth, tolerance=SAME), key=lambda plane: float(sides.area[facing[plane]].sum()))
    origin = np.array([local[:, 0].min(), float(np.median(depth[front])), local[:, 2].min()])
    return FacadeFrame(origin @ axes, axes)


def group_facets(nodes: FloatArray, facets: IntArray, *, tolerance: float) -> dict[str, IntArray]:
    """The facets (f, 6) of a wall by the surfaces that they are on: see :class:`~fd2fem.model.Group`.

    FRONT and BACK are all plane faces that look towards -y and +y. The front as one sees it along y says
    what is the wall's outline, a door or an opening. LEDGES are level and lie apart from all of their edges.

    Parameters
    ----------
    nodes : (n, 3) float array, m
        Facade frame.
    facets : (f, 6) int array
        Outward.
    tolerance : float, m
        How far facets may leave a curved surface.
    """
    import shapely

    sides = Facets.of(nodes, facets)
    front, back = (sense * sides.normal[:, 1] > ALIGNED for sense in (-1.0, 1.0))
    beside = np.flatnonzero(~front & ~back)
    outlines, rims = _rings(nodes[:, [0, 2]].round(9), facets[front, :3])
    centre, normal = (a[beside][:, [0, 2]] for a in (sides.centre, sides.normal))
    flat = normal / np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    edges = shapely.union_all([shapely.LinearRing(ring) for ring in (*outlines, *rims)])
    corners = shapely.points(nodes[facets[beside, :3]][..., [0, 2]])
    apart = shapely.distance(corners, edges).max(axis=1) > tolerance
    ledge = (np.abs(normal[:, 1]) > ALIGNED) & apart & (centre[:, 1] > tolerance)
    named = np.full(len(facets), "", dtype="<U8")
    named[front], named[back] = Group.FRONT, Group.BACK
    named[beside] = [group or "" for group in side_groups(centre, flat, outlines=outlines, rims=rims)]
    named[beside[ledge]] = Group.LEDGES
    return {name: facets[named == name] for name in GROUPS if (named == name).any()}


def _rings(nodes: FloatArray, triangles: IntArray) -> tuple[list[FloatArray], list[FloatArray]]:
    """Outlines of the wall, its doors filled, and rims of its openings.

    `nodes` (n, 2), m, in x and z; `triangles` (t, 3): all that look to the front, of one plane or several.
    """
    import shapely

    parts = shapely.get_parts(_silhouette(nodes, triangles))
    ground = min(part.bounds[1] for part in parts)
    outlines, rims = [], []
    for part in parts:
        corners = shapely.get_coordinates(part.exterior)
        standing = corners[corners[:, 1] < ground + SAME, 0]
        base = (
            shapely.LineString([(standing.min(), ground), (standing.max(), ground)])
            if len(standing)
            else None
        )
        filled = shapely.union_all(shapely.polygonize([shapely.union_all([part.exterior, base])]))
        doors = shapely.get_parts(filled.difference(shapely.Polygon(part.exterior)))
        outlines += [shapely.get_coordinates(whole.exterior) for whole in shapely.get_parts(filled)]
        rims += [shapely.get_coordinates(ring) for ring in part.interiors]
        rims += [shapely.get_coordinates(door.exterior) for door in doors if door.area > SAME**2]
    return outlines, rims


def _silhouette(nodes: FloatArray, triangles: IntArray) -> "BaseGeometry":
    """What the triangles cover: the cells between their free edges, those with a triangle in them."""
    import shapely

    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    edges, count = np.unique(edges, axis=0, return_counts=True)
    lines = shapely.union_all(shapely.linestrings(nodes[edges[count == 1]]))
    cells = shapely.get_parts(shapely.polygonize([lines]))
    tree = shapely.STRtree([shapely.Polygon(corner) for corner in nodes[triangles]])
    inside, _ = tree.query(shapely.point_on_surface(cells), predicate="intersects")
    return shapely.union_all(cells[np.unique(inside)])


def _runs(values: FloatArray, *, tolerance: float) -> list[IntArray]:
    """Indices of values that follow one another, once sorted, in steps of no more than `tolerance`."""
    order = np.argsort(values)
    runs: list[IntArray] = np.split(order, np.flatnonzero(np.diff(values[order]) > tolerance) + 1)
    return runs


def _outward(normal: FloatArray) -> FloatArray:
    """The horizontal unit vector, or its opposite, that looks towards -y, or else towards -x."""
    inward = normal[1] > PARALLEL or (abs(normal[1]) <= PARALLEL and normal[0] > 0.0)
    return np.asarray(-normal if inward else normal)
