"""The gaps in a wall's points: their outlines, and their parts where a shadow covers some of them.

A gap is what the triangles of one cluster cover. Where the shadow of a car joins two windows, or hides the
foot of one, its unhidden parts are what can be told of it; the edges that lie in the shadow are unseen, and
the interval that each can lie in is kept.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from shapely.geometry.base import BaseGeometry

from fd2fem.model import Boundary, FacadePoints, RayMap, Side
from fd2fem.reconstruction.boundary import triangle_areas
from fd2fem.reconstruction.histogram import histogram_peaks
from fd2fem.reconstruction.rays import Shadows

__all__ = ["Gap", "cell_middles", "cells_inside", "find_gaps", "polygons_of"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

SMALLEST = 0.25
"""Gaps smaller than this share of the smallest opening's area are not holes but missed points."""
EDGE_SHOWN, ENOUGH = 0.2, 0.2
"""An edge shows when so much of a hole's extent along it is seen, or so many metres."""
SLIGHT = 0.03
"""A shadow on less of a gap than this share is not worth a look."""
BRIDGED = 0.75
"""Parts of a gap that a shadow narrower than this share of the smallest opening parts belong together."""
INNER = 2.0
"""An unhidden part may end so many cells beyond the edge that lies in shadow."""
PART = 0.5
"""A part must hold a square of this share of the smallest opening, free of shadow."""


@dataclass(frozen=True, eq=False)
class Gap:
    """A gap in the wall's points, or an unhidden part of one.

    Attributes
    ----------
    shape : shapely.Polygon, m
        What it covers; of several pieces the largest.
    points : (b,) int array
        The boundary points around it.
    area : float, m²
        With all pieces.
    low, high : (2,) float arrays, m
        Rough rectangle, between the peaks of its coordinate histograms.
    unseen : mapping of Side to (float, float), m
        Edges in shadow, and the interval that each can lie in.
    """

    shape: shapely.Polygon
    points: IntArray
    area: float
    low: FloatArray
    high: FloatArray
    unseen: Mapping[Side, tuple[float, float]] = field(default_factory=dict)


def find_gaps(points: FacadePoints, boundary: Boundary, shadows: Shadows) -> list[Gap]:
    """Outline every gap that is large enough to matter, and part those that shadows cover.

    Parameters
    ----------
    points : FacadePoints
    boundary : Boundary
    shadows : Shadows

    Returns
    -------
    list of Gap
        The largest first.
    """
    areas = triangle_areas(points.xz[boundary.triangles])
    inner = boundary.hole_of_triangle >= 0
    total = np.bincount(boundary.hole_of_triangle[inner], areas[inner])
    large = np.flatnonzero(total > SMALLEST * boundary.min_opening**2)
    found: list[Gap] = []
    for cluster in large[np.argsort(-total[large], kind="stable")].tolist():
        gap = _outline(points, boundary, boundary.hole_of_triangle == cluster)
        found += _unhidden(gap, points, boundary, shadows)
    return found


def polygons_of(region: BaseGeometry) -> list[shapely.Polygon]:
    """The polygons that a geometry is made of; points and lines are left out."""
    return [piece for piece in getattr(region, "geoms", [region]) if isinstance(piece, shapely.Polygon)]


def _outline(points: FacadePoints, boundary: Boundary, members: BoolArray) -> Gap:
    """A gap from the triangles of its cluster."""
    triangles = boundary.triangles[members]
    region = shapely.coverage_union_all(shapely.polygons(points.xz[triangles]))
    pieces = polygons_of(region)
    shape = max(pieces, key=lambda piece: piece.area)
    box = np.array(shape.bounds).reshape(2, 2)
    low, high = _rectangle(_seen_segments(shape, boundary.threshold), box, points.spacing)
    return Gap(shape, np.unique(triangles), float(region.area), low, high)


def _seen_segments(shape: shapely.Polygon, threshold: float) -> tuple[FloatArray, FloatArray]:
    """Middle and extent, each (m, 2), of the segments of an outline that run along an edge of the wall.

    Longer ones bridge what is hidden, or cut a corner.
    """
    corners = np.array(shape.exterior.coords)
    middle, run = (corners[1:] + corners[:-1]) / 2.0, np.abs(np.diff(corners, axis=0))
    seen = np.hypot(run[:, 0], run[:, 1]) <= threshold
    return middle[seen], run[seen]


def _rectangle(
    segments: tuple[FloatArray, FloatArray], box: FloatArray, spacing: float
) -> tuple[FloatArray, FloatArray]:
    """Lower left and upper right corner of the rough rectangle, by the histograms of the outline."""
    # The corners of the box weigh nothing, but say how far the gap reaches where no edge shows.
    middle = np.concatenate([segments[0], box])
    run = np.concatenate([segments[1], np.zeros((2, 2))])
    centre, least = box.mean(axis=0), np.minimum(EDGE_SHOWN * np.ptp(box, axis=0), ENOUGH)
    width = max(2.0 * spacing, 0.02)
    pairs = [
        histogram_peaks(
            middle[:, axis], run[:, 1 - axis], centre=centre[axis], width=width, least=least[1 - axis]
        )
        for axis in (0, 1)
    ]
    corners = np.array(pairs)
    return corners[:, 0], corners[:, 1]


def cells_inside(shape: shapely.Polygon, rays: RayMap) -> tuple[tuple[slice, slice], BoolArray]:
    """The part of the rasters around a shape, and which of its cells have their middle inside.

    Parameters
    ----------
    shape : shapely.Polygon, m
    rays : RayMap

    Returns
    -------
    window : two slices into a raster
    inside : (mx, mz) bool array
        A margin of one cell around the shape is included where the raster has it.
    """
    left, bottom, right, top = shape.bounds
    first = np.floor((np.array([left, bottom]) - rays.low) / rays.cell).astype(int) - 1
    last = np.floor((np.array([right, top]) - rays.low) / rays.cell).astype(int) + 2
    first, last = np.clip(first, 0, rays.wall.shape), np.clip(last, 0, rays.wall.shape)
    window = (slice(first[0], last[0]), slice(first[1], last[1]))
    inside: BoolArray = shapely.contains_xy(shape, *cell_middles(window, rays))
    return window, inside


def cell_middles(window: tuple[slice, slice], rays: RayMap) -> list[FloatArray]:
    """Places along the wall and up, each (mx, mz), m, of the middles of cells in a part of the rasters."""
    along = [rays.low[k] + rays.cell * (np.arange(window[k].start, window[k].stop) + 0.5) for k in (0, 1)]
    return list(np.meshgrid(*along, indexing="ij"))


def _unhidden(gap: Gap, points: FacadePoints, boundary: Boundary, shadows: Shadows) -> list[Gap]:
    """The parts of a gap that no shadow covers, or the gap as it is where that does not part it."""
    rays = shadows.rays
    window, inside = cells_inside(gap.shape, rays)
    dark = inside & shadows.dark[window]
    # Without a station, a gap that shows nothing at all may be dark for another reason.
    if dark.sum() <= SLIGHT * inside.sum() or not (rays.stations or (inside & shadows.passed[window]).any()):
        return [gap]
    boxes = _bright_boxes(inside & ~dark, inside, boundary.min_opening, rays.cell)
    origin = rays.low + rays.cell * np.array([window[0].start, window[1].start])
    parts = []
    for box in boxes:
        corners = origin + rays.cell * box
        part = _part(gap, corners, points, boundary, rays)
        if part is not None:
            parts.append(replace(part, unseen=_unseen_edges(part, boundary, shadows)))
    # Nothing but shadow: the verdict on the whole gap will say so.
    return sorted(parts, key=lambda part: -part.area) or [gap]


def _bright_boxes(bright: BoolArray, inside: BoolArray, min_opening: float, cell: float) -> list[FloatArray]:
    """Bounding boxes (2, 2) in cells, upper ends exclusive, of the unhidden parts of a gap."""
    # A shadow touches up to two cells more than it is wide.
    reach = 2 * (int(np.ceil(BRIDGED * min_opening / cell) + 2) // 2) + 1
    joined = bright
    for shape in ((reach, 1), (1, reach)):
        margin = max(shape)
        closed = ndimage.binary_closing(np.pad(bright, margin), np.ones(shape))
        joined = joined | (closed[margin:-margin, margin:-margin] & inside)
    # Along the rim of a shadow, cells are bright by mistake: a part must hold a square.
    side = max(2, int(np.ceil(PART * min_opening / cell)))
    core = ndimage.binary_opening(np.pad(joined, side), np.ones((side, side)))[side:-side, side:-side]
    label, _ = ndimage.label(core)
    return [
        np.array([[part[0].start, part[1].start], [part[0].stop, part[1].stop]], dtype=np.float64)
        for part in ndimage.find_objects(label)
    ]


def _part(gap: Gap, box: FloatArray, points: FacadePoints, boundary: Boundary, rays: RayMap) -> Gap | None:
    """The part of a gap in a box, with the edges of the wall that show beside it."""
    margin = 1.5 * rays.cell
    near = shapely.box(*(box[0] - margin), *(box[1] + margin))
    cut = gap.shape.intersection(near)
    pieces = polygons_of(cut)
    if not pieces:
        return None
    shape = max(pieces, key=lambda piece: piece.area)
    middle, run = _seen_segments(gap.shape, boundary.threshold)
    beside = ((middle > box[0] - margin) & (middle < box[1] + margin)).all(axis=1)
    bounds = np.array(shape.bounds).reshape(2, 2)
    extent = np.array([np.maximum(box[0], bounds[0]), np.minimum(box[1], bounds[1])])
    low, high = _rectangle((middle[beside], run[beside]), extent, points.spacing)
    around = points.xz[gap.points]
    members = gap.points[((around > box[0] - margin) & (around < box[1] + margin)).all(axis=1)]
    return replace(gap, shape=shape, points=members, area=float(cut.area), low=low, high=high)


def _unseen_edges(part: Gap, boundary: Boundary, shadows: Shadows) -> dict[Side, tuple[float, float]]:
    """Edges of a part beside which no wall shows but shadow, and how far that reaches."""
    rays = shadows.rays
    middle, run = _seen_segments(part.shape, boundary.threshold)
    unseen = {}
    for side in Side:
        axis = 0 if side.vertical else 1
        corner = part.low if side in {Side.LEFT, Side.BOTTOM} else part.high
        near = np.abs(middle[:, axis] - corner[axis]) < 2.0 * rays.cell
        # What shows beyond the ends of the edge belongs to the shadow's own outline.
        near &= (
            np.abs(middle - (part.low + part.high) / 2.0)[:, 1 - axis]
            < (part.high - part.low)[1 - axis] / 2.0
        )
        # The cut through a shadow runs along the box; its segments are long, or few.
        shown = float(run[near, 1 - axis].sum())
        if shown >= min(EDGE_SHOWN * (part.high - part.low)[1 - axis], ENOUGH):
            continue
        reach = _shadow_reach(part, side, shadows)
        if reach > 1.0:
            # The part's own end is known to its cells only, and may lie beyond the edge.
            outward = -1.0 if side in {Side.LEFT, Side.BOTTOM} else 1.0
            inner = float(corner[axis]) - INNER * outward * rays.cell
            outer = float(corner[axis]) + reach * outward * rays.cell
            unseen[side] = (min(inner, outer), max(inner, outer))
    return unseen


def _shadow_reach(part: Gap, side: Side, shadows: Shadows) -> float:
    """How many cells a shadow reaches outwards from an edge: the median over its middle half."""
    rays, dark = shadows.rays, shadows.dark
    axis = 0 if side.vertical else 1
    raster = dark if axis == 0 else dark.T
    low, high = (part.low - rays.low) / rays.cell, (part.high - rays.low) / rays.cell
    quarter = (high - low)[1 - axis] / 4.0
    first, last = int(low[1 - axis] + quarter), int(np.ceil(high[1 - axis] - quarter))
    outward = side in {Side.RIGHT, Side.TOP}
    # Begin a cell inside: the edge of the part is known to a cell.
    start = int(high[axis] - 1.0) if outward else int(low[axis] + 1.0)
    strip = raster[start:, first:last] if outward else raster[start::-1, first:last]
    if not strip.size:
        return 0.0
    # The first cells may be bright still; count up to the last dark one of the first dark run.
    lit = np.cumsum(strip, axis=0)
    ended = (lit > 0) & ~strip
    length = np.where(ended.any(axis=0), ended.argmax(axis=0), len(strip))
    length = np.where(lit[-1] > 0, length, 0)
    begin = np.where(lit[-1] > 0, strip.argmax(axis=0), len(strip))
    length = np.where(begin <= 3, length, 0)
    return float(np.median(length)) - 1.0
