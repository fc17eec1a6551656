"""Edges, faces and solids of OpenCASCADE, each made once and then shared by its neighbours."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fd2fem.model.outlines import Oval

__all__ = [
    "backwards",
    "curve_edge",
    "curved_face",
    "line_edge",
    "make_solid",
    "plane_face",
    "turned",
    "vertex",
]

TOLERANCE = 1e-7
"""OpenCASCADE's own, m."""
FULL_TURN = 2.0 * np.pi


def vertex(x: float, y: float, z: float) -> Any:
    """A vertex at a point, m."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.gp import gp_Pnt

    return BRepBuilderAPI_MakeVertex(gp_Pnt(x, y, z)).Vertex()


def line_edge(start: Any, end: Any) -> Any:
    """A straight edge between two vertices."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge

    return BRepBuilderAPI_MakeEdge(start, end).Edge()


def curve_edge(oval: Oval, y: float, start: Any, end: Any) -> Any:
    """A curved edge at the depth `y`, m, between two vertices, in the sense of `oval`."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge

    curve, shift = _curve(oval, y)
    first, last = oval.start + shift, oval.end + shift
    if last > first:
        return BRepBuilderAPI_MakeEdge(curve, start, end, first, last).Edge()
    return backwards(BRepBuilderAPI_MakeEdge(curve, end, start, last, first).Edge())


def _curve(oval: Oval, y: float) -> tuple[Any, float]:
    """Circle or ellipse at the depth `y`, and how much its parameter exceeds the oval's angle."""
    from OCP.Geom import Geom_Circle, Geom_Ellipse
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    centre, outwards = gp_Pnt(oval.x, y, oval.z), gp_Dir(0.0, -1.0, 0.0)
    level = gp_Ax2(centre, outwards, gp_Dir(1.0, 0.0, 0.0))
    if oval.a == oval.b:
        return Geom_Circle(level, oval.a), 0.0
    if oval.a > oval.b:
        return Geom_Ellipse(level, oval.a, oval.b), 0.0
    # OpenCASCADE counts the angle from the major axis, which here is upright.
    upright = gp_Ax2(centre, outwards, gp_Dir(0.0, 0.0, 1.0))
    return Geom_Ellipse(upright, oval.b, oval.a), -np.pi / 2.0


def backwards(edge: Any) -> Any:
    """An edge in the other sense."""
    from OCP.TopoDS import TopoDS

    return TopoDS.Edge_s(edge.Reversed())


def turned(edges: Sequence[Any]) -> list[Any]:
    """A chain of edges the other way round."""
    return [backwards(edge) for edge in reversed(edges)]


def plane_face(point: ArrayLike, normal: ArrayLike, loops: Iterable[Sequence[Any]]) -> Any:
    """A plane face.

    Parameters
    ----------
    point, normal : (3,) array-like, m
        A point of it, and its direction outwards.
    loops : iterable of sequences of edges
        Closed chains with the face on their left, seen from outside; the outer one first.
    """
    from OCP.Geom import Geom_Plane
    from OCP.gp import gp_Dir, gp_Pnt

    at, direction = np.asarray(point).tolist(), np.asarray(normal).tolist()
    return _face(Geom_Plane(gp_Pnt(*at), gp_Dir(*direction)), map(_wire, loops))


def curved_face(oval: Oval, loop: Sequence[tuple[Any, float]]) -> Any:
    """The face that a curve sweeps along y, on the right of the curve's sense.

    Parameters
    ----------
    oval : Oval
    loop : sequence of (edge, float) pairs
        Edges along the curve at some depth, or along y; the face on their left, seen from outside. With
        each the angle on `oval`, radians, where it starts, in the curve's sense, or where it stands.
    """
    from OCP.BRep import BRep_Builder
    from OCP.Geom import Geom_CylindricalSurface, Geom_SurfaceOfLinearExtrusion
    from OCP.gp import gp_Ax3, gp_Dir
    from OCP.TopAbs import TopAbs_FORWARD
    from OCP.TopoDS import TopoDS

    curve, shift = _curve(oval, 0.0)
    if oval.a == oval.b:
        surface: Any = Geom_CylindricalSurface(gp_Ax3(curve.Circ().Position()), oval.a)
    else:
        surface = Geom_SurfaceOfLinearExtrusion(curve, gp_Dir(0.0, -1.0, 0.0))
    is_forward = oval.end > oval.start  # else the surface's own normal looks into the wall
    edges = [edge for edge, _ in loop]
    face = _face(surface, [_wire(edges if is_forward else turned(edges))])
    builder = BRep_Builder()
    for number, (edge, angle) in enumerate(loop):
        line = _line_on_surface(edge, angle + shift, is_forward=is_forward)
        # Where a face closes, it meets itself in one edge, which then has a line for either sense.
        twins = [k for k, other in enumerate(edges) if k != number and other.IsSame(edge)]
        if not twins:
            builder.UpdateEdge(edge, line, face, TOLERANCE)
        elif (edge.Orientation() == TopAbs_FORWARD) == is_forward:
            twin = _line_on_surface(edge, loop[twins[0]][1] + shift, is_forward=is_forward)
            builder.UpdateEdge(TopoDS.Edge_s(edge.Oriented(TopAbs_FORWARD)), line, twin, face, TOLERANCE)
    return face if is_forward else face.Reversed()


def _line_on_surface(edge: Any, angle: float, *, is_forward: bool) -> Any:
    """An edge of a swept face in the surface's parameters: the curve's own, and -y."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.Geom2d import Geom2d_Line
    from OCP.GeomAbs import GeomAbs_Line
    from OCP.gp import gp_Dir2d, gp_Pnt2d

    curve = BRepAdaptor_Curve(edge)
    first, last = curve.FirstParameter(), curve.LastParameter()
    down = -curve.Value(first).Y()
    if curve.GetType() == GeomAbs_Line:
        return Geom2d_Line(gp_Pnt2d(angle, down), gp_Dir2d(0.0, -1.0))
    # OpenCASCADE lets the parameters of a curve begin in its first turn.
    turns = round((angle - (first if is_forward else last)) / FULL_TURN)
    return Geom2d_Line(gp_Pnt2d(turns * FULL_TURN, down), gp_Dir2d(1.0, 0.0))


def _wire(edges: Sequence[Any]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Wire

    wire, builder = TopoDS_Wire(), BRep_Builder()
    builder.MakeWire(wire)
    for edge in edges:
        builder.Add(wire, edge)
    wire.Closed(True)
    return wire


def _face(surface: Any, wires: Iterable[Any]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Face

    face, builder = TopoDS_Face(), BRep_Builder()
    builder.MakeFace(face, surface, TOLERANCE)
    for wire in wires:
        builder.Add(face, wire)
    return face


def make_solid(faces: Iterable[Any]) -> Any:
    """A solid bounded by faces that share their edges and look outwards."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    shell, solid, builder = TopoDS_Shell(), TopoDS_Solid(), BRep_Builder()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face)
    shell.Closed(True)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid
