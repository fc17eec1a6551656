"""A drawing as DXF: closed polylines on layers.

The wall is the largest closed polyline on a layer whose name contains "wall", "outline" or "facade",
or the largest of all where there is no such layer. The closed polylines inside it are its openings; of
nested ones (panes in a window) the outer one counts, and what lies outside (frames, details) is left
out. An opening is a door where its layer's name contains "door" or it stands on the wall's lower edge.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.drawings.placing import DEFAULT_THICKNESS, DrawnShape, place_facade
from fd2fem.errors import InputError
from fd2fem.model import Facade, OpeningKind, number_by_rows

if TYPE_CHECKING:
    import shapely

__all__ = ["facade_from_dxf"]

UNITS = {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 14: 0.1}
"""Metres per drawing unit, by $INSUNITS: inch, foot, millimetre, centimetre, metre, decimetre."""
LONGEST_M = 200.0
"""A drawing without units that is larger than this is in millimetres."""
SAGITTA = 0.001
"""Arcs become chords at most this far from them, m."""
SNAP = 0.001
"""An opening this close to the wall's lower edge stands on it, m."""
SMALLEST = 1e-4
"""A closed polyline with less area is a stroke, m²."""
WALL_LAYERS, DOOR_LAYERS = ("wall", "outline", "facade"), ("door",)


@dataclass(frozen=True, eq=False)
class _Polygon:
    """A closed polyline: its layer's name in small letters and its shape in metres."""

    layer: str
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
        If it is not a DXF file, has no closed polyline, or these do not make a facade.
    """
    polygons = _polygons(path, _read(path))
    if not polygons:
        msg = f"{path} is not a facade: it has no closed polyline; single lines do not count, join them."
        raise InputError(msg)
    named = [polygon for polygon in polygons if polygon.on(WALL_LAYERS)]
    wall = max(named or polygons, key=lambda polygon: float(polygon.shape.area))
    low = wall.shape.bounds[1]
    shapes = [_drawn(polygon, low) for polygon in _inside(wall, polygons)]
    facade = place_facade(
        np.array(wall.shape.exterior.coords),
        shapes,
        source=str(path),
        thickness=DEFAULT_THICKNESS if thickness is None else thickness,
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
    """All closed polylines of the model space, also those in blocks."""
    import shapely
    from ezdxf.disassemble import recursive_decompose
    from ezdxf.entities.polyline import Polyline
    from ezdxf.path import make_path

    entities = [
        entity
        for entity in recursive_decompose(drawing.modelspace())
        if entity.dxftype() == "LWPOLYLINE"
        or (isinstance(entity, Polyline) and (entity.is_2d_polyline or entity.is_3d_polyline))
    ]
    outlines = [(str(entity.dxf.layer).lower(), make_path(entity)) for entity in entities]
    closed = [(layer, outline) for layer, outline in outlines if len(outline) and outline.is_closed]
    if not closed:
        return []
    corners = np.array([tuple(v) for _, outline in closed for v in outline.control_vertices()])
    metres = _metres_per_unit(path, drawing, np.ptp(corners, axis=0).max())
    # An elevation may be drawn upright in space: then it has no extent in y.
    upright = np.ptp(corners[:, 1]) * metres < SNAP
    polygons = []
    for layer, outline in closed:
        points = np.array([tuple(v) for v in outline.flattening(SAGITTA / metres)])
        shape = shapely.Polygon(points[:, [0, 2 if upright else 1]] * metres)
        if shape.area < SMALLEST and shape.convex_hull.area < SMALLEST:
            continue
        if not shape.is_valid:
            msg = f"{path}: a closed polyline on layer '{layer}' is wrong: {shapely.is_valid_reason(shape)}."
            raise InputError(msg)
        polygons.append(_Polygon(layer, shape))
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
    outline: NDArray[np.float64] = np.array(polygon.shape.exterior.coords)
    outline[np.abs(outline[:, 1] - low) < SNAP, 1] = low
    is_door = polygon.on(DOOR_LAYERS) or bool(outline[:, 1].min() == low)
    return DrawnShape(outline, OpeningKind.DOOR if is_door else OpeningKind.WINDOW)
