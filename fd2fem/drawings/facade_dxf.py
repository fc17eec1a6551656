"""A drawing as DXF: closed polylines, circles and ellipses on layers.

The wall is the largest closed curve on a layer whose name contains "wall", "outline" or "facade", or the
largest of all where there is no such layer. The closed curves inside it are its openings; of nested ones
(panes in a window) the outer one counts, and what lies outside (frames, details) is left out. An opening is
a door where its layer's name contains "door" or it stands on the wall's lower edge.

Polylines may have arcs (bulges). Arcs of circles and of ellipses with level and upright axes are kept as the
arcs of the facade, whose corners bound exactly their area and leave them by at most 1 mm; of ellipses that
lean, only such corners are kept.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fd2fem.drawings.dxf_curves import closed_curves, outline_in_plane
from fd2fem.drawings.placing import DEFAULT_THICKNESS, SAGITTA, DrawnShape, DrawnWall, place_facade
from fd2fem.errors import InputError
from fd2fem.model import Facade, OpeningKind, number_by_rows
from fd2fem.model.outlines import Outline

if TYPE_CHECKING:
    import shapely

__all__ = ["facade_from_dxf"]

UNITS = {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 14: 0.1}
"""Metres per drawing unit, by $INSUNITS: inch, foot, millimetre, centimetre, metre, decimetre."""
LONGEST_M = 200.0
"""A drawing without units that is larger than this is in millimetres."""
SNAP = 0.001
"""An opening this close to the wall's lower edge stands on it, m."""
SMALLEST = 1e-4
"""A closed curve with less area is a stroke, m²."""
EXACT = 1e-7
"""An opening whose lowest corner is this close to it has been set down, m."""
WALL_LAYERS, DOOR_LAYERS = ("wall", "outline", "facade"), ("door",)


@dataclass(frozen=True, eq=False)
class _Polygon:
    """A closed curve: its layer's name in small letters, its outline and shape in metres."""

    layer: str
    outline: Outline
    shape: "shapely.Polygon"

    def on(self, words: Sequence[str]) -> bool:
        """Whether the name of the layer contains one of the words."""
        return any(word in self.layer for word in words)


def facade_from_dxf(path: Path, *, thickness: float | None = None) -> Facade:
    """Facade of a DXF drawing, in its own frame.

    Units come from $INSUNITS; a drawing without is in millimetres if it is larger than 200, otherwise in
    metres. The openings are numbered by rows from the ground, left to right.

    Parameters
    ----------
    path : Path
    thickness : float, m, or None
        None: 0.35 m, for a drawing of a facade does not say.

    Raises
    ------
    InputError
        If it is not a DXF file, has no closed curve, or these do not make a facade.
    """
    polygons = _polygons(path, _read(path))
    if not polygons:
        msg = f"{path} is not a facade: it has no closed polyline; single lines do not count, join them."
        raise InputError(msg)
    named = [polygon for polygon in polygons if polygon.on(WALL_LAYERS)]
    wall = max(named or polygons, key=lambda polygon: float(polygon.shape.area))
    low = float(wall.shape.bounds[1])
    facade = place_facade(
        DrawnWall(wall.outline, DEFAULT_THICKNESS if thickness is None else thickness),
        [_drawn(polygon, low) for polygon in _inside(wall, polygons)],
        source=str(path),
        frame=None,
        record={"source": path.name},
    )
    return replace(facade, openings=number_by_rows(facade.openings))


def _read(path: Path) -> Any:
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFError

    try:
        return readfile(path)
    except (OSError, DXFError, ValueError, LookupError, StopIteration) as error:
        msg = f"{path} is not a DXF drawing that can be read: save it anew as DXF R2010."
        raise InputError(msg) from error


def _polygons(path: Path, drawing: Any) -> list[_Polygon]:
    """All closed curves of the model space, also those in blocks."""
    import shapely

    try:
        curves = closed_curves(drawing.modelspace())
    except InputError as error:
        msg = f"{path}: {error}"
        raise InputError(msg) from error
    if not curves:
        return []
    extremes = np.concatenate([curve.extremes for curve in curves])
    metres = _metres_per_unit(path, drawing, np.ptp(extremes, axis=0).max())
    # An elevation may be drawn upright in space: then it has no extent in y.
    upright = np.ptp(extremes[:, 1]) * metres < SNAP
    projection = metres * np.eye(3)[:, [0, 2 if upright else 1]]
    polygons = []
    for curve in curves:
        outline = outline_in_plane(curve, projection, tolerance=SAGITTA)
        if len(outline.ring) < 3:
            continue
        shape = shapely.Polygon(outline.ring)
        if shape.area < SMALLEST and shape.convex_hull.area < SMALLEST:
            continue
        if not shape.is_valid:
            reason = shapely.is_valid_reason(shape)
            msg = f"{path}: a closed polyline on layer '{curve.layer}' is wrong: {reason}; correct it there."
            raise InputError(msg)
        polygons.append(_Polygon(curve.layer, outline, shape))
    return polygons


def _metres_per_unit(path: Path, drawing: Any, extent: float) -> float:
    code = int(drawing.header.get("$INSUNITS", 0))
    if code == 0:
        return UNITS[4] if extent > LONGEST_M else UNITS[6]
    if code not in UNITS:
        msg = f"{path}: $INSUNITS is {code}, which is not read; set it to 4 (mm), 5 (cm) or 6 (m)."
        raise InputError(msg)
    return UNITS[code]


def _inside(wall: _Polygon, polygons: Sequence[_Polygon]) -> list[_Polygon]:
    """The outermost polygons that lie in the wall, or cross its edge, which the facade will refuse."""
    kept: list[_Polygon] = []
    for polygon in sorted(polygons, key=lambda p: -float(p.shape.area)):
        if polygon is wall or polygon.shape.buffer(SNAP).covers(wall.shape):
            continue  # also a sheet's frame around the wall
        if polygon.shape.intersection(wall.shape).area < SMALLEST:
            continue
        if not any(other.shape.buffer(SNAP).covers(polygon.shape) for other in kept):
            kept.append(polygon)
    return kept


def _drawn(polygon: _Polygon, low: float) -> DrawnShape:
    """The opening, set down on the wall's lower edge `low` where it is within `SNAP` of it."""
    outline = _set_down(polygon.outline, low)
    is_door = polygon.on(DOOR_LAYERS) or bool(abs(outline.ring[:, 1].min() - low) < EXACT)
    return DrawnShape(outline, OpeningKind.DOOR if is_door else OpeningKind.WINDOW)


def _set_down(outline: Outline, low: float) -> Outline:
    """The outline with its feet at the height `low`: corners move alone, but an arc with all of the shape."""
    near = np.abs(outline.ring[:, 1] - low) < SNAP
    if not near.any():
        return outline
    count = len(outline.ring)
    for arc in outline.arcs:
        steps = (arc.last - arc.first) % count or count
        if near[(arc.first + np.arange(steps + 1)) % count].any():
            return outline.moved(0.0, low - float(outline.ring[:, 1].min()))
    ring = outline.ring.copy()
    ring[near, 1] = low
    return Outline(ring, outline.arcs)
