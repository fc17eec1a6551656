"""From boundary lines to the facade: its own frame, closed rings, filled occlusions."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fd2fem.errors import InputError, ReconstructionError
from fd2fem.model import (
    Boundary,
    BoundaryLine,
    EdgeSigma,
    Facade,
    FacadePoints,
    FilledHole,
    Hole,
    HoleKind,
    Opening,
    OpeningKind,
    RayMap,
    Side,
    number_by_rows,
    rectangle,
)
from fd2fem.reconstruction.completion import Draft, complete_edges
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.outline import WallOutline

__all__ = ["assemble_facade", "draft_openings", "move_to_corner"]

FloatArray = NDArray[np.float64]
Holes = tuple[Hole, ...]


def move_to_corner(
    points: FacadePoints, boundary: Boundary, rays: RayMap, outline: WallOutline
) -> tuple[FacadePoints, Boundary, RayMap, WallOutline]:
    """Shift the records so that the wall's lower left corner is the origin of the facade frame."""
    corner = outline.ring.min(axis=0)
    spacing = boundary.spacing
    if spacing is not None:
        spacing = replace(spacing, origin=spacing.origin - corner)
    return (
        points.moved(*corner.tolist()),
        replace(boundary, spacing=spacing),
        replace(rays, low=rays.low - corner),
        replace(outline, ring=outline.ring - corner),
    )


def draft_openings(holes: Holes, lines: Sequence[BoundaryLine]) -> list[Draft]:
    """Put the lines of each opening together, and complete the edges that lie in shadow.

    Parameters
    ----------
    holes : tuple of Hole
    lines : sequence of BoundaryLine
    """
    drafts = [
        _draft(number, hole, {line.side: line for line in lines if line.hole == number})
        for number, hole in enumerate(holes)
        if hole.kind is HoleKind.OPENING
    ]
    return complete_edges(drafts)


def _draft(number: int, hole: Hole, edges: Mapping[Side, BoundaryLine]) -> Draft:
    """An opening from its lines; the ground closes a door's, and rough edges stand for hidden ones."""
    rough = dict(zip((Side.LEFT, Side.BOTTOM, Side.RIGHT, Side.TOP), (*hole.low, *hole.high), strict=True))
    position = {side: edges[side].position if side in edges else float(rough[side]) for side in Side}
    sigma = {side: edges[side].sigma if side in edges else 0.0 for side in Side}
    door = Side.BOTTOM not in edges and (Side.BOTTOM not in hole.unseen or hole.unseen[Side.BOTTOM][0] <= 0.0)
    if door:
        position[Side.BOTTOM] = 0.0
    for low, high in ((Side.LEFT, Side.RIGHT), (Side.BOTTOM, Side.TOP)):
        if position[low] >= position[high]:
            # Edges that hardly show can come out anywhere: the rough ones stand for both.
            for side in (low, high):
                sigma[side] = max(abs(position[side] - rough[side]), sigma[side])
                position[side] = float(rough[side])
    return Draft(number, hole, position, sigma, door)


def assemble_facade(
    points: FacadePoints,
    outline: WallOutline,
    drafts: Sequence[Draft],
    occlusions: Sequence[Hole],
    *,
    options: ReconstructionOptions,
) -> Facade:
    """Close the openings into rings and fill the occlusions.

    Parameters
    ----------
    points : FacadePoints
    outline : WallOutline
        Its bounding box starts at (0, 0).
    drafts : sequence of Draft
    occlusions : sequence of Hole
    options : ReconstructionOptions

    Raises
    ------
    ReconstructionError
        If the lines of an opening cross, or openings touch.
    """
    openings = [_opening(draft) for draft in drafts]
    filled = [_filled(hole, outline.ring) for hole in occlusions]
    try:
        return Facade(
            outline.ring,
            options.thickness,
            number_by_rows(openings),
            tuple(hole for hole in filled if hole is not None),
            points.frame,
        )
    except InputError as error:
        msg = f"What was found is no facade ({str(error).rstrip('.')}): check threshold and min_opening."
        raise ReconstructionError(msg) from error


def _opening(draft: Draft) -> Opening:
    """A finished opening."""
    hole = draft.hole
    left, right, bottom, top = (draft.position[side] for side in Side)
    if right <= left or top <= bottom:
        msg = (
            f"The lines of the hole at x = {hole.x:.2f}, z = {hole.z:.2f} m cross: its edges do not show; "
            "scan more densely there."
        )
        raise ReconstructionError(msg)
    evidence = {"verdict": hole.reason, "shape": draft.shape, **hole.evidence}
    if draft.notes:
        evidence["hidden_edges"] = {side.value: note for side, note in draft.notes.items()}
    return Opening(
        id=0,
        kind=OpeningKind.DOOR if draft.door else OpeningKind.WINDOW,
        outline=rectangle(left, bottom, right - left, top - bottom) if draft.ring is None else draft.ring,
        confidence=round(hole.confidence, 3),
        evidence=evidence,
        sigma=EdgeSigma(**{side.value: draft.sigma[side] for side in Side}),
    )


def _filled(hole: Hole, ring: FloatArray) -> FilledHole | None:
    """The largest part of an occlusion that lies on the wall."""
    on_wall = shapely.Polygon(hole.loop).intersection(shapely.Polygon(ring))
    pieces = [piece for piece in getattr(on_wall, "geoms", [on_wall]) if isinstance(piece, shapely.Polygon)]
    pieces = [piece for piece in pieces if piece.area > 0.0]
    if not pieces:
        return None
    largest = max(pieces, key=lambda piece: piece.area)
    return FilledHole(np.array(largest.exterior.coords), hole.reason, hole.evidence)
