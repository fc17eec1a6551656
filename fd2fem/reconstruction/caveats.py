"""What the user should know before trusting a facade: where the points do not show what was assumed."""

import numpy as np
import shapely

from fd2fem.model import Boundary, BoundaryLine, Facade, FacadePoints, Hole, HoleKind, Side
from fd2fem.reconstruction.options import ReconstructionOptions

__all__ = ["opening_warnings", "outline_warnings"]

SEEN_THROUGH = 0.3
"""A hole that rays passed in so much of it is hardly an occlusion."""
CUT_OFF = 0.02
"""Share of the wall's rectangle that may lie outside of its points' hull before it is worth a word."""
SLANT = np.radians(2.0)
"""An edge that leans more, and by more than the points' spacing explains, is reported."""


def outline_warnings(
    points: FacadePoints,
    boundary: Boundary,
    holes: tuple[Hole, ...],
    facade: Facade,
    options: ReconstructionOptions,
) -> list[str]:
    """Where the wall may not be the rectangle that it was taken for."""
    warnings = []
    # The foot may be hidden by cars from end to end: it counts as seen.
    foot = [(0.0, 0.0), (facade.length, 0.0)]
    hull = shapely.MultiPoint(np.vstack([points.xz[boundary.outer], foot])).convex_hull
    missing = 1.0 - hull.area / (facade.length * facade.height)
    if missing > CUT_OFF:
        warnings.append(
            f"{100 * missing:.0f} % of the wall's rectangle lies outside of the points' convex hull: the "
            "wall may end in a gable or slope; it was taken as a rectangle."
        )
    for hole in holes:
        touched = [
            side.value
            for side in (Side.LEFT, Side.RIGHT, Side.TOP)
            if _reaches(points, hole, facade, side, near=1.2 * boundary.threshold)
        ]
        large = hole.area > 2.0 * options.min_opening**2
        if touched and large and hole.evidence["in_shadow"] < SEEN_THROUGH:
            warnings.append(
                f"A hole of {hole.area:.1f} m² at x = {hole.x:.2f}, z = {hole.z:.2f} m reaches the wall's "
                f"{' and '.join(touched)} edge: the wall may be notched there; it was taken as a rectangle."
            )
    return warnings


def _reaches(points: FacadePoints, hole: Hole, facade: Facade, side: Side, *, near: float) -> bool:
    """Whether the wall's edge is near a hole's side, and no wall shows between their middle halves."""
    low, high = hole.loop.min(axis=0), hole.loop.max(axis=0)
    axis = 0 if side.vertical else 1
    quarter = (high - low)[1 - axis] / 4.0
    low[1 - axis] += quarter
    high[1 - axis] -= quarter
    if side is Side.LEFT:
        low[0], high[0] = 0.0, low[0]
    elif side is Side.RIGHT:
        low[0], high[0] = high[0], facade.length
    else:
        low[1], high[1] = high[1], facade.height
    if (high - low)[axis] > near:
        return False
    expected = float(np.prod(np.maximum(high - low, 0.0))) / points.spacing**2
    shown = np.count_nonzero(((points.xz > low) & (points.xz < high)).all(axis=1))
    return bool(shown < max(0.3 * expected, 1.0))


def opening_warnings(
    points: FacadePoints,
    holes: tuple[Hole, ...],
    lines: tuple[BoundaryLine, ...],
    facade: Facade,
    options: ReconstructionOptions,
) -> list[str]:
    """Holes and edges that may be something else than what they were taken for."""
    warnings = [
        f"A hole of {hole.area:.1f} m² at x = {hole.x:.2f}, z = {hole.z:.2f} m was filled, though "
        f"{100 * hole.evidence['seen_through']:.0f} % of it was seen through: {hole.reason}."
        for hole in holes
        if hole.kind is HoleKind.OCCLUSION
        and hole.evidence["seen_through"] > SEEN_THROUGH
        and hole.area > options.min_opening**2
        and min(hole.width, hole.height) >= options.min_opening
    ]
    for opening in facade.openings:
        if "sill" in opening.evidence:
            warnings.append(f"The sill of opening {opening.id} is {opening.evidence['sill']}.")
        elif opening.evidence["foot_in_shadow"] > options.max_shadow:
            warnings.append(
                f"The foot of opening {opening.id} lies in shadow: it may be a window, not a door."
            )
    for line in lines:
        if line.hole < 0 and line.side is Side.BOTTOM and points.ground is not None:
            continue
        along = 1 if line.side.vertical else 0
        run = np.abs(line.end - line.start)
        long = run[along] >= options.min_opening
        if long and run[1 - along] > max(4.0 * points.spacing, np.tan(SLANT) * run[along]):
            name = "wall" if line.hole < 0 else f"opening at x = {holes[line.hole].x:.2f} m"
            warnings.append(
                f"The {line.side} edge of the {name} is off by {1000 * run[1 - along] / run[along]:.0f} mm a "
                "metre; it was taken as upright or level."
            )
    return warnings
