"""Step 1.2: what each gap in the wall's points is.

The paper tells openings from occlusions by their size and shape alone. Here the rays join in: where the
scanner stood is known, they say what hid a gap, what was seen behind it, and what returned nothing.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
import shapely.affinity
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Boundary, FacadePoints, Hole, HoleKind, Side
from fd2fem.reconstruction.boundary import triangle_areas
from fd2fem.reconstruction.gaps import Gap, cell_middles, cells_inside, find_gaps
from fd2fem.reconstruction.options import Override, ReconstructionOptions
from fd2fem.reconstruction.rays import Shadows
from fd2fem.reconstruction.sampling import points_in_box
from fd2fem.reconstruction.verdicts import Evidence, weigh

__all__ = ["classify_holes"]

FloatArray = NDArray[np.float64]

ON_WALL = 0.5
"""A gap is in the wall when more of it than this share is."""
MOSTLY = 0.5
"""A row of cells lies in shadow when more of it does."""
TOUCHING = 0.02
"""A gap that comes so near to an end or the top of the wall, m, reaches it."""
SHOWN = 0.3
"""A strip that holds a smaller share of the points that it would as wall is none."""
SHOWS = 0.1
"""A gap shows what is behind it when so much of it was seen through."""
SAME_SIZE = 0.1
"""Gaps are alike whose sizes differ by a smaller share and that line up to so many metres."""


def classify_holes(
    points: FacadePoints,
    boundary: Boundary,
    shadows: Shadows,
    *,
    outline: FloatArray,
    options: ReconstructionOptions,
) -> tuple[Hole, ...]:
    """Tell openings from occlusions.

    Parameters
    ----------
    points : FacadePoints
    boundary : Boundary
    shadows : Shadows
    outline : (k, 2) float array, m
        Of the wall: gaps outside of it are no holes.
    options : ReconstructionOptions

    Returns
    -------
    tuple of Hole
        The largest first. Gaps much smaller than an opening are left out.

    Raises
    ------
    InputError
        If an override names a place where there is no gap.
    """
    wall = shapely.Polygon(outline)
    gaps = [
        _to_the_ground(gap, points, boundary, shadows)
        for gap in find_gaps(points, boundary, shadows)
        if wall.intersection(gap.shape).area > ON_WALL * gap.shape.area
    ]
    loose = _loose_triangles(points, boundary)
    evidence = _with_company(gaps, [_evidence(gap, shadows, loose) for gap in gaps], options)
    evidence = [
        replace(said, at_edge=_at_edge(gap, wall, points, near=1.2 * boundary.threshold))
        for gap, said in zip(gaps, evidence, strict=True)
    ]
    holes = [_hole(gap, said, shadows, options) for gap, said in zip(gaps, evidence, strict=True)]
    return _overridden(tuple(_without_fragments(holes, boundary.threshold)), options.overrides)


def _to_the_ground(gap: Gap, points: FacadePoints, boundary: Boundary, shadows: Shadows) -> Gap:
    """A gap that is open to the ground, as a door is, reaches down to it."""
    foot = float(points.xz[:, 1].min()) if points.ground is None else points.ground
    if not _open_below(points, gap, foot, boundary.threshold):
        return gap
    unseen = dict(gap.unseen)
    if Side.BOTTOM in unseen:
        unseen[Side.BOTTOM] = (foot, unseen[Side.BOTTOM][1])
    return _hidden_foot(replace(gap, low=np.array([gap.low[0], foot]), unseen=unseen), shadows)


def _hidden_foot(gap: Gap, shadows: Shadows) -> Gap:
    """A door whose lowest part lies in shadow may be a window: its foot is not seen up to there."""
    box = shapely.box(*gap.low, *gap.high)
    window, inside = cells_inside(box, shadows.rays)
    rows = np.flatnonzero(inside.any(axis=0))
    if Side.BOTTOM in gap.unseen or not len(rows):
        return gap
    hidden = (shadows.hidden[window] & inside)[:, rows].sum(axis=0) / inside[:, rows].sum(axis=0)
    dark = int(np.argmin(np.append(hidden > MOSTLY, False)))
    if not dark:
        return gap
    # The row above may lie half in the shadow.
    top = float(gap.low[1]) + (dark + 1) * shadows.rays.cell
    return replace(gap, unseen={**gap.unseen, Side.BOTTOM: (float(gap.low[1]), top)})


def _open_below(points: FacadePoints, gap: Gap, foot: float, threshold: float) -> bool:
    """Whether a gap reaches the ground: its lowest point is near it, and no wall shows below."""
    lowest = gap.unseen.get(Side.BOTTOM, (gap.shape.bounds[1], 0.0))[0]
    if lowest - foot > 3.0 * threshold:
        return False
    low, high = gap.low[0] + threshold, gap.high[0] - threshold
    columns = np.arange(low, high, threshold)
    if not len(columns):
        return False
    first, last = np.searchsorted(points.xz[:, 0], [low, high])
    xz = points.xz[first:last]
    below = xz[xz[:, 1] < max(lowest, foot + threshold), 0]
    shown = np.unique(np.floor((below - low) / threshold))
    # A car may hide most of the wall under a shop window; a door has none.
    return len(shown) < 0.2 * len(columns)


def _at_edge(gap: Gap, wall: shapely.Polygon, points: FacadePoints, *, near: float) -> bool:
    """Whether a gap leaves the wall, or reaches its end or top with hardly any wall between."""
    # A door may reach the ground: the wall goes on below it here.
    below = shapely.affinity.translate(wall, yoff=-1.0)
    inner = wall.union(below).buffer(-max(points.spacing, TOUCHING))
    if not inner.contains(shapely.box(*gap.low, *gap.high)):
        return True
    (left, bottom, right, top), limits = gap.shape.bounds, wall.bounds
    quarter = (right - left) / 4.0, (top - bottom) / 4.0
    strips = (
        (limits[0], bottom + quarter[1], left, top - quarter[1]),
        (right, bottom + quarter[1], limits[2], top - quarter[1]),
        (left + quarter[0], top, right - quarter[0], limits[3]),
    )
    return any(_is_bare(points, strip, near) for strip in strips)


def _is_bare(points: FacadePoints, strip: tuple[float, float, float, float], near: float) -> bool:
    """Whether a strip (left, bottom, right, top) is narrower than `near`, m, and shows hardly any wall."""
    low, high = np.array(strip[:2]), np.array(strip[2:])
    if (high - low).min() > near:
        return False
    expected = float(np.prod(np.maximum(high - low, 0.0))) / points.spacing**2
    return len(points_in_box(points, low, high)) < max(SHOWN * expected, 1.0)


def _loose_triangles(points: FacadePoints, boundary: Boundary) -> tuple[FloatArray, FloatArray]:
    """Centres and areas of all long triangles: the cut-off corners of a gap are clusters of their own."""
    corners = points.xz[boundary.triangles]
    return corners.mean(axis=1), triangle_areas(corners)


def _evidence(gap: Gap, shadows: Shadows, loose: tuple[FloatArray, FloatArray]) -> Evidence:
    """What size, shape and rays say of a gap."""
    size = gap.high - gap.low
    box = shapely.box(*gap.low, *gap.high)
    centres, areas = loose
    within = ((centres > gap.low) & (centres < gap.high)).all(axis=1)
    filled = max(float(gap.shape.intersection(box).area), float(areas[within].sum()))
    rays = shadows.rays
    # What a shadow hides of the rectangle speaks neither for it nor against it.
    window, inside = cells_inside(box, rays)
    beside = inside & ~shapely.contains_xy(gap.shape, *cell_middles(window, rays))
    filled += rays.cell**2 * float(np.count_nonzero(beside & shadows.hidden[window]))
    window, inside = cells_inside(gap.shape, rays)
    hidden, passed = shadows.hidden[window][inside], shadows.passed[window][inside]
    aimed = rays.stations > 0 and len(hidden) > 0
    return Evidence(
        length=float(size[0]),
        height=float(size[1]),
        rectangularity=min(filled / max(float(box.area), 1e-12), 1.0),
        in_shadow=float(hidden.mean()) if len(hidden) else 0.0,
        seen_through=float(passed.mean()) if len(passed) else 0.0,
        missing=float((~hidden & ~passed).mean()) if aimed else 0.0,
        stations=rays.stations,
    )


def _with_company(
    gaps: list[Gap], evidence: list[Evidence], options: ReconstructionOptions
) -> list[Evidence]:
    """Add what the gaps say of one another: how many are alike, and whether any show their inside."""
    show = any(said.seen_through > SHOWS for said in evidence)
    size = np.array([[said.length, said.height] for said in evidence]).reshape(-1, 2)
    low = np.array([gap.low for gap in gaps]).reshape(-1, 2)
    high = low + size
    good = np.array([said.in_shadow < options.max_shadow for said in evidence], dtype=bool)
    completed = []
    for number, said in enumerate(evidence):
        same = (np.abs(size - size[number]) < SAME_SIZE * np.maximum(size[number], 1e-9)).all(axis=1)
        lined = (np.minimum(np.abs(low - low[number]), np.abs(high - high[number])) < SAME_SIZE).any(axis=1)
        alike = int(np.count_nonzero(same & lined & good)) - int(good[number])
        completed.append(replace(said, alike=alike, others_show=show))
    return completed


def _hole(gap: Gap, said: Evidence, shadows: Shadows, options: ReconstructionOptions) -> Hole:
    """The verdict on a gap."""
    kind, reason, confidence = weigh(said, options=options)
    return Hole(
        loop=np.array(gap.shape.exterior.coords),
        points=gap.points,
        kind=kind,
        reason=reason,
        x=float(gap.low[0]),
        z=float(gap.low[1]),
        width=said.length,
        height=said.height,
        area=gap.area,
        confidence=confidence,
        evidence=_figures(gap, said, shadows, options),
        unseen=gap.unseen,
    )


def _figures(gap: Gap, said: Evidence, shadows: Shadows, options: ReconstructionOptions) -> Mapping[str, Any]:
    """The numbers behind a verdict, as facade.json keeps them."""
    rays = shadows.rays
    window, inside = cells_inside(gap.shape, rays)
    count, depth = int(rays.inside[window][inside].sum()), float(rays.recess[window][inside].sum())
    foot = shapely.box(
        float(gap.low[0]),
        float(gap.low[1]),
        float(gap.high[0]),
        float(min(gap.low[1] + options.min_opening, gap.high[1])),
    )
    below, cells = cells_inside(foot, rays)
    foot_hidden = shadows.hidden[below][cells]
    return {
        "aspect": round(said.height / max(said.length, 1e-9), 3),
        "rectangularity": round(said.rectangularity, 3),
        "in_shadow": round(said.in_shadow, 3),
        "seen_through": round(said.seen_through, 3),
        "no_return": round(said.missing, 3),
        "recess_m": round(depth / count, 3) if count else None,
        "foot_in_shadow": round(float(foot_hidden.mean()) if len(foot_hidden) else 0.0, 3),
        "alike": said.alike,
        "scanners": said.stations,
    }


def _overridden(holes: tuple[Hole, ...], overrides: tuple[Override, ...]) -> tuple[Hole, ...]:
    """Put the user's verdicts in the place of ours, and record both."""
    found = list(holes)
    for override in overrides:
        place = shapely.Point(override.x, override.z)
        number = next(
            (
                number
                for number, hole in enumerate(found)
                if shapely.box(*hole.low, *hole.high).union(shapely.Polygon(hole.loop)).contains(place)
            ),
            None,
        )
        if number is None:
            where = ", ".join(
                f"({hole.x + hole.width / 2:.2f}, {hole.z + hole.height / 2:.2f})" for hole in found
            )
            msg = (
                f"Invalid override: there is no hole at x = {override.x:g}, z = {override.z:g} m; "
                f"their middles are {where or 'none'}."
            )
            raise InputError(msg)
        hole = found[number]
        kind = HoleKind(override.verdict)
        before = hole.evidence.get("override")
        if before == kind.value:
            continue
        if before is not None:
            msg = (
                f"Invalid override: the hole at x = {override.x:g}, z = {override.z:g} m has two, "
                f"{before} and {kind.value}."
            )
            raise InputError(msg)
        found[number] = replace(
            hole,
            kind=kind,
            reason=f"set by the user; without that, {hole.kind.value}: {hole.reason}",
            confidence=1.0,
            evidence={**hole.evidence, "override": kind.value},
        )
    return tuple(found)


def _without_fragments(holes: list[Hole], margin: float) -> list[Hole]:
    """Leave out occlusions that are only cut-off corners of an opening."""
    openings = [
        shapely.box(
            hole.x - margin, hole.z - margin, hole.x + hole.width + margin, hole.z + hole.height + margin
        )
        for hole in holes
        if hole.kind is HoleKind.OPENING
    ]
    return [
        hole
        for hole in holes
        if hole.kind is HoleKind.OPENING
        or not any(box.contains(shapely.Polygon(hole.loop)) for box in openings)
    ]
