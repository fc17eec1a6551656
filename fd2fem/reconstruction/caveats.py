"""What the user should know before trusting a facade: where the points do not show what was assumed."""

import numpy as np
import shapely

from fd2fem.model import BoundaryLine, Facade, Hole, HoleKind
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.sampling import Sampling

__all__ = ["edge_warnings", "hole_warnings", "opening_warnings"]

SEEN_THROUGH = 0.3
"""A hole that rays passed in so much of it is hardly an occlusion."""
UNSURE = 0.7
"""A verdict with less confidence than this is worth a second look."""
SLANT = np.radians(2.0)
"""An edge that leans more, and by more than the points' spacing explains, is reported."""


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
        if "hidden_edges" not in opening.evidence and opening.evidence["foot_in_shadow"] > options.max_shadow:
            warnings.append(
                f"The foot of opening {opening.id} lies in shadow: it may be a window, not a door."
            )
        if opening.confidence < UNSURE:
            warnings.append(f"Opening {opening.id} has a confidence of {opening.confidence:.2f} only.")
    return warnings


def edge_warnings(
    lines: tuple[BoundaryLine, ...],
    holes: tuple[Hole, ...],
    options: ReconstructionOptions,
    sampling: Sampling,
) -> list[str]:
    """Edges of openings that were taken as upright or level, and are not."""
    warnings = []
    for line in lines:
        along = 1 if line.side.vertical else 0
        run = np.abs(line.end - line.start)
        long = run[along] >= options.min_opening
        if long and run[1 - along] > max(4.0 * sampling.spacing, np.tan(SLANT) * run[along]):
            warnings.append(
                f"The {line.side} edge of the opening at x = {holes[line.hole].x:.2f} m is off by "
                f"{1000 * run[1 - along] / run[along]:.0f} mm a metre; it was taken as upright or level."
            )
    return warnings
