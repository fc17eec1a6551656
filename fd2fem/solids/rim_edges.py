"""From a polygon, some of whose corners stand for curves, to straight and curved edges of the same area."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model import Arc, arc_angles, arc_corners
from fd2fem.model.checks import as_points, signed_area
from fd2fem.model.outlines import Oval

__all__ = ["Edge", "Point", "edge_points", "rim_edges", "without_idle_corners"]

FloatArray = NDArray[np.float64]
Point = tuple[float, float]

STRAIGHT = 1e-9
"""A corner closer than this to the chord of its neighbours, m, is none."""
SHORT = 1e-7
"""Edges shorter than this, m, are none: OpenCASCADE's own tolerance."""
SAME_CURVE = 1e-6
"""Centres and half axes that differ by less, m, are those of one curve."""
EXACT = 1e-13
"""A curve that misses its ends and its area by less, m, needs no more fitting."""
FITTED = 1e-9
"""A curve has its ends and its area to within this, m; else its corners are drawn as they are."""
MOVED = 0.01
"""A fitted curve differs from the given one by less than this part of its half axes."""
ROUND = 1e-9
"""Half axes that differ by less than this part of them are a circle's."""
CHORDS = 64
"""Chords of a curve where only the sense and the place of a rim are asked for."""
FULL_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Edge:
    """An edge from `start` to `end` (x, z), m: straight, or where `oval` is given, that curve.

    The oval passes through both ends at its own two angles; start and end of a closed curve are equal.
    """

    start: Point
    end: Point
    oval: Oval | None = None


@dataclass(frozen=True, eq=False)
class _Run:
    """Corners (k, 2), m, that stand for one edge, both ends included, and the curve that they stand for."""

    corners: FloatArray
    arc: Arc | None = None


def edge_points(start: Point, oval: Oval | None) -> FloatArray:
    """Points (k, 2), m, along an edge, without its end: enough to see the sense and the place of a rim."""
    if oval is None:
        return np.array([start])
    angle = np.linspace(oval.start, oval.end, CHORDS, endpoint=False)
    return np.column_stack([oval.x + oval.a * np.cos(angle), oval.z + oval.b * np.sin(angle)])


def rim_edges(ring: ArrayLike, arcs: Sequence[Arc]) -> tuple[Edge, ...]:
    """Edges of an outline in turn; corners in the middle of an edge, straight or curved, vanish.

    Parameters
    ----------
    ring : (k, 2) array-like, m
        The outline's corners.
    arcs : sequence of Arc
        Which of its corners stand for curves. Neighbours on one curve become one edge.

    Returns
    -------
    tuple of Edge
        Starting at the outline's first corner, or at the next one that is an edge's end.

    Examples
    --------
    >>> [edge.start for edge in rim_edges([[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]], ())]
    [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
    """
    runs = _merged(_runs(as_points("ring", ring, dim=2), arcs))
    edges: list[Edge] = []
    for run in runs:
        oval = None if run.arc is None else _fitted(run.corners, run.arc)
        edges += _edges(run.corners, oval)
    return without_idle_corners(edges)


def _edges(corners: FloatArray, oval: Oval | None) -> list[Edge]:
    """One edge along a curve, or straight ones from corner to corner."""
    points: list[Point] = [(x, z) for x, z in corners.tolist()]
    if oval is None:
        return [Edge(a, b) for a, b in pairwise(points)]
    if points[0] == points[-1]:
        seam = (float(oval.x + oval.a * np.cos(oval.start)), float(oval.z + oval.b * np.sin(oval.start)))
        return [Edge(seam, seam, oval)]
    return [Edge(points[0], points[-1], oval)]


def _runs(ring: FloatArray, arcs: Sequence[Arc]) -> list[_Run]:
    """One run for each arc and for each edge between arcs, from the first corner that no arc passes."""
    by_first = {arc.first: arc for arc in arcs}
    count = len(ring)
    inside = {
        (arc.first + step) % count
        for arc in arcs
        for step in range(1, (arc.last - arc.first) % count or count)
    }
    start = next(corner for corner in range(count) if corner not in inside)
    runs, done = [], 0
    while done < count:
        corner = (start + done) % count
        arc = by_first.get(corner)
        corners = ring[[corner, (corner + 1) % count]] if arc is None else arc_corners(arc, ring)
        runs.append(_Run(corners, arc))
        done += len(corners) - 1
    return runs


def _merged(runs: list[_Run]) -> list[_Run]:
    """Runs with neighbours on one curve made one; all of them, where they close it."""
    merged = runs[:1]
    for run in runs[1:]:
        if _continues(merged[-1], run):
            merged[-1] = replace(merged[-1], corners=np.concatenate([merged[-1].corners, run.corners[1:]]))
        else:
            merged.append(run)
    if len(merged) > 1 and _continues(merged[-1], merged[0]):
        first = merged.pop(0)
        merged[-1] = replace(merged[-1], corners=np.concatenate([merged[-1].corners, first.corners[1:]]))
    return merged


def _continues(run: _Run, following: _Run) -> bool:
    """Whether two runs in turn lie on one curve and go on in the same sense."""
    one, other = run.arc, following.arc
    if one is None or other is None:
        return False
    gaps = np.abs([one.x - other.x, one.z - other.z, one.a - other.a, one.b - other.b])
    senses = [np.diff(_angles(r.corners, one))[0] > 0.0 for r in (run, following)]
    return bool(gaps.max() < SAME_CURVE) and senses[0] == senses[1]


def _angles(corners: FloatArray, arc: Arc) -> tuple[float, float]:
    """Angles of a run's ends about the centre of `arc`."""
    if _is_closed(corners):
        return arc_angles(replace(arc, first=0, last=0), corners[:-1])
    return arc_angles(replace(arc, first=0, last=len(corners) - 1), corners)


def _is_closed(corners: FloatArray) -> bool:
    return bool((corners[0] == corners[-1]).all())


def _fitted(corners: FloatArray, arc: Arc) -> Oval | None:
    """A curve moved by the little that makes it meet the ends of its corners and have their area.

    Corners are rounded in files, so that ends lie on their curve to a micrometre only; CAD wants more.
    None where that needs more than a little.
    """
    if _is_closed(corners):
        return _fitted_whole(corners, arc)
    is_circle = abs(arc.a - arc.b) < ROUND * max(arc.a, arc.b)
    given = np.array([arc.x, arc.z, arc.a] if is_circle else [arc.x, arc.z, arc.a, arc.b])
    steps = 1e-6 * min(arc.a, arc.b) * np.eye(len(given))
    values = given
    for _ in range(8):
        misfit = _misfit(corners, values)
        if np.abs(misfit).max() < EXACT:
            break
        rises = [_misfit(corners, values + step) - _misfit(corners, values - step) for step in steps]
        slope = np.column_stack(rises) / (2.0 * steps[0, 0])
        values = values - np.linalg.lstsq(slope, misfit, rcond=1e-9)[0]
    is_little = np.abs(values - given).max() < MOVED * min(arc.a, arc.b)
    if not (is_little and np.abs(_misfit(corners, values)).max() < FITTED):
        return None
    fitted = _with(arc, values)
    return Oval(fitted.x, fitted.z, fitted.a, fitted.b, *_angles(corners, fitted))


def _fitted_whole(corners: FloatArray, arc: Arc) -> Oval:
    """A closed curve scaled to the area of its corners; it begins at the end of its major axis."""
    scale = float(np.sqrt(abs(signed_area(corners[:-1])) / (np.pi * arc.a * arc.b)))
    is_round = abs(arc.a - arc.b) < ROUND * max(arc.a, arc.b)
    a, b = scale * arc.a, scale * (arc.a if is_round else arc.b)
    start = 0.0 if a >= b else FULL_TURN / 4.0
    turn = FULL_TURN if signed_area(corners[:-1]) > 0.0 else -FULL_TURN
    return Oval(arc.x, arc.z, a, b, start, start + turn)


def _misfit(corners: FloatArray, values: FloatArray) -> FloatArray:
    """How far the ends lie outside a curve, m, and the area that it lacks, m² per m of its size."""
    arc = _with(Arc(0, 0, 0.0, 0.0, 1.0, 1.0), values)
    size = min(arc.a, arc.b)
    outside = (np.hypot(*((corners[[0, -1]] - [arc.x, arc.z]) / [arc.a, arc.b]).T) - 1.0) * size
    start, end = _angles(corners, arc)
    area = 0.5 * arc.a * arc.b * ((end - start) - np.sin(end - start))
    return np.append(outside, (signed_area(corners) - area) / size)


def _with(arc: Arc, values: FloatArray) -> Arc:
    """An arc with the centre and half axes (x, z, a, b) or (x, z, radius)."""
    x, z, a, *rest = values.tolist()
    return replace(arc, x=x, z=z, a=a, b=rest[0] if rest else a)


def without_idle_corners(edges: Iterable[Edge]) -> tuple[Edge, ...]:
    """Edges without those too short for CAD; straight ones that continue each other become one."""
    kept: list[Edge] = []
    for edge in edges:
        if kept and _is_idle(kept[-1], edge):
            kept[-1] = Edge(kept[-1].start, edge.end)
        else:
            kept.append(edge)
    if len(kept) > 2 and _is_idle(kept[-1], kept[0]):
        kept[0] = Edge(kept.pop().start, kept[0].end)
    return tuple(kept)


def _is_idle(before: Edge, after: Edge) -> bool:
    """Whether the corner between two edges is none."""
    if before.oval is not None or after.oval is not None:
        return False
    arm = np.subtract(before.end, before.start)
    chord = np.subtract(after.end, before.start)
    length = float(np.hypot(*chord))
    if min(np.hypot(*arm), np.hypot(*(chord - arm))) < SHORT:
        return True
    return length > 0.0 and abs(float(chord[0] * arm[1] - chord[1] * arm[0])) < STRAIGHT * length
