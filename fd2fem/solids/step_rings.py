"""From the wires of a CAD face to edges in the facade frame, and from a rim to outlines of wall and doors."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import FacadeFrame
from fd2fem.model.checks import signed_area
from fd2fem.model.outlines import Outline, Oval, curved_outline
from fd2fem.solids.rim_edges import Edge, Point, edge_points, without_idle_corners
from fd2fem.solids.rims import backwards_rim

if TYPE_CHECKING:
    from cadquery import Wire

__all__ = ["moved_rim", "outline_of", "rim_of", "split_doors"]

FloatArray = NDArray[np.float64]

FLATTEN = 1e-3
"""Curved edges become chords that leave them by no more than this, m."""
TOUCH = 1e-6
"""Points closer to the ground than this, m, stand on it."""
PARALLEL = 1e-6
"""Directions whose unit vectors differ by less than this are one."""
ON_CURVE = 5e-7
"""A curve is an arc if its points lie on one within this, m."""
FLAT = 1000.0
"""Curves of a larger radius, m, are none."""
SAMPLES = 9
"""Points along an edge that say which way it runs round a centre."""


def rim_of(wire: "Wire", frame: FacadeFrame) -> tuple[Edge, ...]:
    """Edges of a wire in the plane of a frame's x and z, counter-clockwise, from the lower left corner.

    Circles, and ellipses with level and upright axes, stay; other curves become chords.
    """
    from OCP.BRepTools import BRepTools_WireExplorer

    edges: list[Edge] = []
    explorer = BRepTools_WireExplorer(wire.wrapped)
    while explorer.More():
        edges += _edges(explorer.Current(), frame)
        explorer.Next()
    rim = without_idle_corners(_joined(edges))
    if signed_area(np.concatenate([edge_points(edge.start, edge.oval) for edge in rim])) < 0.0:
        rim = backwards_rim(rim)
    # To a micrometre: in the file, a level edge's ends differ in the last digits.
    first = min(range(len(rim)), key=lambda number: (round(rim[number].start[1], 6), rim[number].start[0]))
    return (*rim[first:], *rim[:first])


def moved_rim(rim: Sequence[Edge], x: float, z: float) -> tuple[Edge, ...]:
    """A rim shifted by (x, z), m; what then nearly stands on the ground at z = 0 does."""

    def moved(point: Point) -> Point:
        up = float(round(point[1] + z, 9))
        return float(round(point[0] + x, 9)), 0.0 if abs(up) < TOUCH else up

    def moved_oval(oval: Oval | None) -> Oval | None:
        if oval is None:
            return None
        return replace(oval, x=float(round(oval.x + x, 9)), z=float(round(oval.z + z, 9)))

    return tuple(Edge(moved(edge.start), moved(edge.end), moved_oval(edge.oval)) for edge in rim)


def outline_of(rim: Sequence[Edge]) -> Outline:
    """The polygon of a rim, with arcs."""
    ovals = {number: edge.oval for number, edge in enumerate(rim) if edge.oval is not None}
    return curved_outline([edge.start for edge in rim], ovals, tolerance=FLATTEN)


def split_doors(rim: Sequence[Edge]) -> tuple[tuple[Edge, ...], list[tuple[Edge, ...]]]:
    """A wall's rim with its notches on the ground at z = 0 filled, and the notches, counter-clockwise.

    Examples
    --------
    >>> corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (2.0, 2.0), (2.0, 0.0), (4.0, 0.0), (4.0, 3.0)]
    >>> outline, doors = split_doors([Edge(a, b) for a, b in zip(corners, corners[1:] + corners[:1])])
    >>> [edge.start for edge in outline], [edge.start for edge in doors[0]]
    ([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)], [(1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 2.0)])
    """
    standing = [number for number, edge in enumerate(rim) if edge.start[1] == 0.0]
    if not standing:
        return tuple(rim), []
    first = min(standing, key=lambda number: rim[number].start[0])
    turned = [*rim[first:], *rim[:first]]
    # The rim meets the ground from left to right: what lies between two such points, above the ground and
    # right of the rim's sense, is a door; only the last stretch goes back, over the top of the wall.
    outline: list[Edge] = []
    doors: list[tuple[Edge, ...]] = []
    stretch: list[Edge] = []
    for edge in turned:
        stretch.append(edge)
        if edge.end[1] != 0.0:
            continue
        start, end = stretch[0].start, stretch[-1].end
        if end[0] > start[0] and (len(stretch) > 1 or edge.oval is not None):
            doors.append((Edge(start, end), *backwards_rim(stretch)))
            stretch = [Edge(start, end)]
        outline += stretch
        stretch = []
    return without_idle_corners(outline), doors


def _joined(edges: list[Edge]) -> list[Edge]:
    """Edges in turn, each starting where the one before ends, to the last digit."""
    ends = [edge.start for edge in edges[1:]] + [edges[0].start]
    return [replace(edge, end=end) for edge, end in zip(edges, ends, strict=True)]


def _edges(edge: Any, frame: FacadeFrame) -> list[Edge]:
    """An edge of a wire, in its sense: one, or for other curves than arcs several chords."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GCPnts import GCPnts_QuasiUniformDeflection
    from OCP.GeomAbs import GeomAbs_Line
    from OCP.TopAbs import TopAbs_REVERSED

    curve = BRepAdaptor_Curve(edge)
    steps = np.linspace(curve.FirstParameter(), curve.LastParameter(), SAMPLES).tolist()
    if edge.Orientation() == TopAbs_REVERSED:
        steps.reverse()
    along = _points([curve.Value(step) for step in steps], frame)
    if curve.GetType() == GeomAbs_Line:
        return [Edge(along[0], along[-1])]
    form = _form(curve, edge)
    oval = None if form is None else _oval(form, along, frame)
    if oval is not None:
        return [Edge(along[0], along[-1], oval)]
    division = GCPnts_QuasiUniformDeflection(curve, FLATTEN)
    points = _points([division.Value(number + 1) for number in range(division.NbPoints())], frame)
    if edge.Orientation() == TopAbs_REVERSED:
        points.reverse()
    return [Edge(start, end) for start, end in pairwise(points)]


def _points(points: Sequence[Any], frame: FacadeFrame) -> list[Point]:
    """Points of OpenCASCADE as x and z in a frame."""
    local = frame.to_facade([(point.X(), point.Y(), point.Z()) for point in points])
    return [(float(x), float(z)) for x, z in local[:, [0, 2]].round(9)]


def _form(curve: Any, edge: Any) -> Any:
    """The circle or the ellipse that an edge lies on, or None; also where a file has it as a spline."""
    from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Ellipse
    from OCP.gp import gp_Circ, gp_Elips
    from OCP.ShapeAnalysis import ShapeAnalysis_CanonicalRecognition

    if curve.GetType() == GeomAbs_Circle:
        return curve.Circle()
    if curve.GetType() == GeomAbs_Ellipse:
        return curve.Ellipse()
    circle, ellipse = gp_Circ(), gp_Elips()
    recognition = ShapeAnalysis_CanonicalRecognition(edge)
    if recognition.IsCircle(ON_CURVE, circle):
        return circle
    return ellipse if recognition.IsEllipse(ON_CURVE, ellipse) else None


def _oval(form: Any, along: Sequence[Point], frame: FacadeFrame) -> Oval | None:
    """The part of a circle or an ellipse on which points lie, or None if it is neither level nor upright."""
    is_circle = hasattr(form, "Radius")
    radii = [form.Radius()] * 2 if is_circle else [form.MajorRadius(), form.MinorRadius()]
    if max(radii) > FLAT:
        return None
    direction = form.XAxis().Direction()
    major = frame.axes @ [direction.X(), direction.Y(), direction.Z()]
    if not is_circle and np.abs(major[[0, 2]]).max() < 1.0 - PARALLEL:
        return None
    a, b = (float(round(radius, 9)) for radius in (radii if abs(major[0]) > abs(major[2]) else radii[::-1]))
    ((x, z),) = _points([form.Location()], frame)
    local = (np.array(along) - [x, z]) / [a, b]
    if np.abs(np.hypot(*local.T) - 1.0).max() * max(a, b) > ON_CURVE:
        return None
    angle = np.unwrap(np.arctan2(local[:, 1], local[:, 0]))
    return Oval(x, z, a, b, float(angle[0]), float(angle[-1]))
