"""What the user should know before trusting a facade: where the points do not show what was assumed."""

from collections.abc import Sequence

import numpy as np
import shapely

from fd2fem.model import BoundaryLine, Facade, Hole, HoleKind, OpeningKind
from fd2fem.reconstruction.completion import Draft
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.strips import Place, View, edge_beside, sampling_at, seen_place

__all__ = ["edge_warnings", "hole_warnings", "opening_warnings"]

SEEN_THROUGH = 0.3
"""A hole that rays passed in so much of it is hardly an occlusion."""
UNSURE = 0.7
"""A verdict with less confidence than this is worth a second look."""
SURE = 5.0
"""The halves of an edge must differ by so many standard errors: a facade has hundreds of edges."""
LONG = 20.0
"""Of an edge shorter than so many point spacings, the halves tell too little."""
SLANT = np.radians(2.0)
"""An edge that leans more, and by more than its errors explain, is reported."""


def hole_warnings(holes: tuple[Hole, ...], facade: Facade, options: ReconstructionOptions) -> list[str]:
    """Holes that were filled and may be openings."""
    wall = shapely.Polygon(facade.outline)
    warnings = []
    for hole in holes:
        large = hole.area > options.min_opening**2 and min(hole.width, hole.height) >= options.min_opening
        if hole.kind is HoleKind.OPENING or not large or "override" in hole.evidence:
            continue
        where = f"A hole of {hole.area:.1f} m² at x = {hole.x:.2f}, z = {hole.z:.2f} m was filled"
        if hole.evidence["seen_through"] > SEEN_THROUGH:
            share = 100 * hole.evidence["seen_through"]
            warnings.append(f"{where}, though {share:.0f} % of it was seen through: {hole.reason}.")
        elif hole.confidence < UNSURE and wall.contains(shapely.Polygon(hole.loop)):
            warnings.append(f"{where}, with a confidence of {hole.confidence:.2f}: {hole.reason}.")
    return warnings


def opening_warnings(facade: Facade, options: ReconstructionOptions) -> list[str]:
    """Openings whose edges were not all seen, or that may be none."""
    warnings = []
    for opening in facade.openings:
        for side, note in opening.evidence.get("hidden_edges", {}).items():
            warnings.append(f"The {side} edge of opening {opening.id} is {note}.")
        in_shadow = (
            opening.kind is OpeningKind.DOOR and opening.evidence["foot_in_shadow"] > options.max_shadow
        )
        if in_shadow and "hidden_edges" not in opening.evidence:
            warnings.append(
                f"The foot of opening {opening.id} lies in shadow: it may be a window, not a door."
            )
        if opening.confidence < UNSURE:
            warnings.append(f"Opening {opening.id} has a confidence of {opening.confidence:.2f} only.")
    return warnings


def edge_warnings(view: View, lines: tuple[BoundaryLine, ...], drafts: Sequence[Draft]) -> list[str]:
    """Edges of rectangular openings that were taken as upright or level, and are not."""
    rectangles = {draft.number for draft in drafts if draft.outline is None}
    warnings = []
    for line in lines:
        if line.hole not in rectangles:
            continue
        along = 1 if line.side.vertical else 0
        run = np.abs(line.end - line.start)
        if run[along] < view.boundary.min_opening or run[1 - along] < np.tan(SLANT) * run[along]:
            continue
        slope = _slope(view, line)
        if abs(slope) > np.tan(SLANT):
            warnings.append(
                f"The {line.side} edge of the opening at x = {view.holes[line.hole].x:.2f} m is off by "
                f"{1000 * abs(slope):.0f} mm a metre; it was taken as upright or level."
            )
    return warnings


def _slope(view: View, line: BoundaryLine) -> float:
    """Slope of an edge by the wall beside its two halves, 0 where their errors explain it."""
    place = seen_place(line.hole, view.holes[line.hole])
    along = 1 if line.side.vertical else 0
    middle = (place.low + place.high) / 2.0
    length = float((place.high - place.low)[along])
    if length < LONG * sampling_at(view, middle).spacing:
        return 0.0
    found = []
    for half in (0, 1):
        low, high = place.low.copy(), place.high.copy()
        (high if half == 0 else low)[along] = middle[along]
        guess = (line.start, line.end)[half][1 - along]
        found.append(edge_beside(view, Place(line.hole, low, high), line.side, float(guess)))
    change = found[1][0] - found[0][0]
    error = float(np.hypot(found[0][1], found[1][1]))
    return 2.0 * change / length if abs(change) > SURE * error else 0.0
