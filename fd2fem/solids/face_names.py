"""Which named group of the wall's surface each face of a CAD shape bears."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Facade, Group, edge_groups

if TYPE_CHECKING:
    from cadquery import Face, Shape

__all__ = ["face_groups"]

FloatArray = NDArray[np.float64]

SAME = 1e-6
"""Places, m, and components of unit normals that differ by less are equal."""
STEP = 1e-3
"""Length of the piece of an edge that stands for it, m."""


def face_groups(shape: "Shape", facade: Facade) -> tuple[Group | None, ...]:
    """The group of each face of a wall, by the rule that names the facets of its meshes too.

    A curved face bears the group of its middle.

    Parameters
    ----------
    shape : cadquery.Shape
        In the facade frame, m: `cad_wall(facade)`, or cells of the same wall.
    facade : Facade

    Returns
    -------
    tuple of Group or None
        For each of `shape.Faces()`; None between cells and for the undersides of projections.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> from fd2fem.solids.wall_solid import cad_wall
    >>> facade = Facade(rectangle(0, 0, 4, 3), 0.5)
    >>> sorted(str(group) for group in face_groups(cad_wall(facade), facade))
    ['back', 'base', 'front', 'left', 'right', 'top']
    """
    faces = shape.Faces()
    middles = [_middle(face) for face in faces]
    point = np.array([place for place, _ in middles]).reshape(-1, 3)
    normal = np.array([direction for _, direction in middles]).reshape(-1, 3)
    across = np.abs(normal[:, 1]) > 1.0 - SAME
    is_curved = np.array([face.geomType() != "PLANE" for face in faces])
    on_rim = _on_rims(facade, point[:, [0, 2]]) | is_curved
    # Pieces of edges with the wall on their left; any direction will do for fronts and backs.
    along = np.where(across[:, None], [[STEP, 0.0]], STEP * np.column_stack([-normal[:, 2], normal[:, 0]]))
    sides = edge_groups(facade, point[:, [0, 2]] - along / 2.0, point[:, [0, 2]] + along / 2.0)
    groups: list[Group | None] = []
    for number, (side, is_inner) in enumerate(zip(sides, _are_inner(shape, faces), strict=True)):
        if is_inner:
            groups.append(None)
        elif across[number]:
            groups.append(Group.FRONT if point[number, 1] < SAME else Group.BACK)
        else:
            groups.append(side if on_rim[number] else Group.LEDGES)
    return tuple(groups)


def _on_rims(facade: Facade, point: FloatArray) -> NDArray[np.bool_]:
    """Which points (k, 2), m, lie on the wall's outline or on an opening's."""
    import shapely

    rings = [facade.outline, *(opening.outline for opening in facade.openings)]
    rims = shapely.MultiLineString([shapely.LinearRing(ring) for ring in rings])
    distance: FloatArray = np.atleast_1d(shapely.distance(shapely.points(point), rims))
    return distance < SAME


def _are_inner(shape: "Shape", faces: list["Face"]) -> list[bool]:
    """Whether each face lies between two solids."""
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
    from OCP.TopExp import TopExp
    from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

    owners = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape.wrapped, TopAbs_FACE, TopAbs_SOLID, owners)
    return [owners.FindFromKey(face.wrapped).Extent() > 1 for face in faces]


def _middle(face: "Face") -> tuple[list[float], list[float]]:
    """A point in the middle of a face or, if it is curved, of its curve, and the direction outwards there."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.BRepGProp import BRepGProp
    from OCP.GeomAbs import GeomAbs_Plane
    from OCP.gp import gp_Pnt, gp_Vec
    from OCP.GProp import GProp_GProps
    from OCP.TopAbs import TopAbs_REVERSED

    surface = BRepAdaptor_Surface(face.wrapped)
    if surface.GetType() == GeomAbs_Plane:
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face.wrapped, properties)
        middle, axis = properties.CentreOfMass(), surface.Plane().Position()
        normal = gp_Vec(axis.XDirection()).Crossed(gp_Vec(axis.YDirection()))
    else:
        middle, along_u, along_v = gp_Pnt(), gp_Vec(), gp_Vec()
        u = (surface.FirstUParameter() + surface.LastUParameter()) / 2.0
        v = (surface.FirstVParameter() + surface.LastVParameter()) / 2.0
        surface.D1(u, v, middle, along_u, along_v)
        normal = along_u.Crossed(along_v).Normalized()
    if face.wrapped.Orientation() == TopAbs_REVERSED:
        normal.Reverse()
    return [middle.X(), middle.Y(), middle.Z()], [normal.X(), normal.Y(), normal.Z()]
