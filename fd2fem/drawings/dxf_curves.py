"""The closed curves of a DXF drawing: polylines, circles and ellipses, also those in blocks."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.drawings.bulges import FLAT, bulge_oval, joined_outline
from fd2fem.errors import InputError
from fd2fem.model import Arc, facet_arc
from fd2fem.model.outlines import Outline, Oval, chord_count

if TYPE_CHECKING:
    from ezdxf.math import Matrix44

__all__ = ["ClosedCurve", "closed_curves", "outline_in_plane"]

FloatArray = NDArray[np.float64]

CLOSES = 1e-6
"""A polyline whose ends are closer together is closed, in drawing units."""
UPRIGHT = 1e-8
"""An ellipse whose axes lean by less is one with level and upright axes, radians about."""
LARGEST = 1e12
"""No coordinate of a drawing is larger, drawing units; nor is a bulge."""
STRAIGHT = 1e-9
"""A bulge that is less is none."""
FRAME_CONTROL = 16
"""Flag of a vertex that a smoothed polyline does not pass through."""
MOST_NESTED = 16
"""Blocks in blocks in blocks; deeper ones are taken for circular."""


@dataclass(frozen=True, eq=False)
class Bow:
    """A piece of an ellipse in space: centre + u cos t + v sin t from `start` to `end`, drawing units."""

    centre: FloatArray
    u: FloatArray
    v: FloatArray
    start: float
    end: float

    @property
    def middle(self) -> FloatArray:
        """The point half-way."""
        t = (self.start + self.end) / 2.0
        point: FloatArray = self.centre + self.u * np.cos(t) + self.v * np.sin(t)
        return point

    def mapped(self, turn: FloatArray, shift: FloatArray | float = 0.0) -> "Bow":
        """The bow of the points p @ turn + shift."""
        return Bow(self.centre @ turn + shift, self.u @ turn, self.v @ turn, self.start, self.end)


@dataclass(frozen=True, eq=False)
class ClosedCurve:
    """A closed curve on a layer, whose name is in small letters.

    `corners` (k, 3), drawing units; `bows` are the curved edges by the corner where they start.
    """

    layer: str
    corners: FloatArray
    bows: Mapping[int, Bow] = field(default_factory=dict)

    @property
    def extremes(self) -> FloatArray:
        """Corners and middles of the curved edges, (n, 3), drawing units."""
        middles = [bow.middle for bow in self.bows.values()]
        return np.concatenate([self.corners, np.reshape(middles, (-1, 3))])


def closed_curves(space: Iterable[Any]) -> list[ClosedCurve]:
    """All closed polylines, circles and whole ellipses among entities of ezdxf.

    What a block has on layer 0 is on the layer where the block is inserted.

    Raises
    ------
    InputError
        If one has a coordinate that is not finite.
    """
    return list(_curves(space, None, "0", 0))


def _curves(
    entities: Iterable[Any], placed: "Matrix44 | None", layer: str, depth: int
) -> Iterator[ClosedCurve]:
    """The closed curves of a block that is `placed` into the world on a `layer`."""
    for entity in entities:
        own = str(entity.dxf.get("layer", "0")).lower()
        on = layer if own == "0" else own
        if entity.dxftype() == "INSERT":
            block = entity.block()
            if block is None or depth >= MOST_NESTED:
                continue
            for one in entity.multi_insert() if entity.mcount > 1 else [entity]:
                matrix = one.matrix44()
                yield from _curves(block, matrix if placed is None else matrix * placed, on, depth + 1)
            continue
        read = READERS.get(entity.dxftype())
        curve = read(entity, on) if read else None
        if curve is not None:
            yield curve if placed is None else _transformed(curve, placed)


def _transformed(curve: ClosedCurve, matrix: "Matrix44") -> ClosedCurve:
    """A curve of a block in the world."""
    values = np.array([tuple(row) for row in matrix.rows()])
    turn, shift = values[:3, :3], values[3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        bows = {number: bow.mapped(turn, shift) for number, bow in curve.bows.items()}
        placed = ClosedCurve(curve.layer, curve.corners @ turn + shift, bows)
    _check_finite(curve.layer, placed.corners)
    for bow in bows.values():
        _check_finite(curve.layer, [bow.centre, bow.u, bow.v])
    return placed


def _circle(entity: Any, layer: str) -> ClosedCurve:
    _check_finite(layer, [*entity.dxf.center, entity.dxf.radius])
    ocs = entity.ocs()
    u, v = (entity.dxf.radius * np.array(axis) for axis in (ocs.ux, ocs.uy))
    return _whole(layer, np.array(ocs.to_wcs(entity.dxf.center)), u, v)


def _ellipse(entity: Any, layer: str) -> ClosedCurve | None:
    """None for a piece of an ellipse."""
    _check_finite(layer, [*entity.dxf.center, *entity.dxf.major_axis, entity.dxf.ratio])
    turn = abs(entity.dxf.end_param - entity.dxf.start_param)
    if abs(turn - 2.0 * np.pi) > CLOSES:
        return None
    return _whole(
        layer, np.array(entity.dxf.center), np.array(entity.dxf.major_axis), np.array(entity.minor_axis)
    )


def _light_polyline(entity: Any, layer: str) -> ClosedCurve | None:
    vertices = [(x, y, entity.dxf.elevation, bulge) for x, y, bulge in entity.get_points("xyb")]
    return _polyline(layer, vertices, entity.closed, entity.ocs())


def _heavy_polyline(entity: Any, layer: str) -> ClosedCurve | None:
    """None also for meshes, which DXF calls polylines too."""
    if not (entity.is_2d_polyline or entity.is_3d_polyline):
        return None
    on_curve = [vertex for vertex in entity.vertices if not vertex.dxf.flags & FRAME_CONTROL]
    if entity.is_2d_polyline:
        level = _elevation(entity)
        vertices = [(v.dxf.location.x, v.dxf.location.y, level, v.dxf.bulge) for v in on_curve]
        return _polyline(layer, vertices, entity.is_closed, entity.ocs())
    corners = np.array([tuple(vertex.dxf.location) for vertex in on_curve]).reshape(-1, 3)
    _check_finite(layer, corners)
    closes = len(corners) > 1 and np.abs(corners[0] - corners[-1]).max() < CLOSES
    return ClosedCurve(layer, corners) if len(corners) and (entity.is_closed or closes) else None


def _check_finite(layer: str, values: ArrayLike) -> None:
    """Raise if a coordinate is NaN, infinite, or of no drawing."""
    if not (np.abs(values) < LARGEST).all():
        what = "has coordinates that are not finite or too large"
        msg = f"a closed curve on layer '{layer}' {what}: draw it anew."
        raise InputError(msg)


def _elevation(polyline: Any) -> float:
    """Height of a 2D polyline above its own plane."""
    given = polyline.dxf.hasattr("elevation") or not polyline.vertices
    return float(polyline.dxf.elevation.z if given else polyline.vertices[0].dxf.location.z)


def _whole(layer: str, centre: FloatArray, u: FloatArray, v: FloatArray) -> ClosedCurve:
    """A whole ellipse, in two halves."""
    halves = {0: Bow(centre, u, v, 0.0, np.pi), 1: Bow(centre, u, v, np.pi, 2.0 * np.pi)}
    return ClosedCurve(layer, np.array([centre + u, centre - u]), halves)


def _polyline(
    layer: str, vertices: list[tuple[float, float, float, float]], closed: bool, ocs: Any
) -> ClosedCurve | None:
    """A polyline with bulges, from its own plane into space; None if it is open."""
    if len(vertices) < 2:
        return None
    values = np.array(vertices, dtype=np.float64)
    _check_finite(layer, values)
    closes = np.abs(values[0, :2] - values[-1, :2]).max() < CLOSES
    if not (closed or closes):
        return None
    if closes and len(values) > 2:
        values = values[:-1]
    axes = np.array([tuple(ocs.ux), tuple(ocs.uy), tuple(ocs.uz)])
    bows = {}
    for number, (start, end) in enumerate(zip(values, np.roll(values, -1, axis=0), strict=True)):
        oval = bulge_oval(start[:2], end[:2], start[3], flat=0.0) if abs(start[3]) > STRAIGHT else None
        if oval is not None:
            centre = np.array([oval.x, oval.z, start[2]]) @ axes
            bows[number] = Bow(centre, oval.a * axes[0], oval.b * axes[1], oval.start, oval.end)
    return ClosedCurve(layer, values[:, :3] @ axes, bows)


def outline_in_plane(curve: ClosedCurve, projection: FloatArray, *, tolerance: float) -> Outline:
    """A closed curve as an outline with exactly its area.

    Parameters
    ----------
    curve : ClosedCurve
    projection : (3, 2) float array
        From drawing units in space to metres on the wall.
    tolerance : float, m
        How far the polygon may leave the curve.

    Returns
    -------
    Outline
        Pieces of circles and of ellipses with level and upright axes become arcs; others only corners.
    """
    corners: list[FloatArray] = []
    ovals: dict[int, Oval] = {}
    for number, corner in enumerate(curve.corners @ projection):
        corners.append(corner)
        if number not in curve.bows:
            continue
        flat = curve.bows[number].mapped(projection)
        following = curve.corners[(number + 1) % len(curve.corners)] @ projection
        if np.hypot(*(flat.middle - (corner + following) / 2.0)) < FLAT:
            continue
        oval = _oval(flat)
        if oval is not None:
            ovals[len(corners) - 1] = oval
        else:
            corners.extend(_leaning(flat, tolerance)[1:-1])
    return joined_outline(np.array(corners), ovals, tolerance=tolerance)


def _oval(bow: Bow) -> Oval | None:
    """The piece of an ellipse that a bow in the plane is, if its axes are level and upright."""
    axes = np.column_stack([bow.u, bow.v])
    square = axes @ axes.T
    a, b = np.sqrt(np.diag(square))
    if min(a, b) < FLAT or abs(square[0, 1]) > UPRIGHT * np.trace(square):
        return None
    # On the unit circle, the bow is turned by `first`, and mirrored where its area is negative.
    turned = axes / np.array([[a], [b]])
    first = float(np.arctan2(turned[1, 0], turned[0, 0]))
    sense = 1.0 if np.linalg.det(turned) > 0.0 else -1.0
    x, z = bow.centre.tolist()
    return Oval(x, z, float(a), float(b), first + sense * bow.start, first + sense * bow.end)


def _leaning(bow: Bow, tolerance: float) -> FloatArray:
    """Corners (k, 2) of a polygon with exactly the area of a bow whose axes lean, both ends included."""
    longest = float(np.linalg.norm(np.column_stack([bow.u, bow.v]), 2))
    count = chord_count(longest, bow.end - bow.start, tolerance)
    # An affine map keeps ratios of areas.
    unit = facet_arc(Arc(0, 0, 0.0, 0.0, 1.0, 1.0), bow.start, bow.end, count=count)
    corners: FloatArray = bow.centre + unit @ np.array([bow.u, bow.v])
    return corners


READERS: Mapping[str, Callable[[Any, str], ClosedCurve | None]] = {
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _light_polyline,
    "POLYLINE": _heavy_polyline,
}
"""What makes a curve of an entity on a layer, by the entity's type."""
