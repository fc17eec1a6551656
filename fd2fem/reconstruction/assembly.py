"""From boundary lines to the facade: its own frame, closed rings, filled occlusions."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import shapely
import shapely.affinity
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
from fd2fem.model.outlines import Outline
from fd2fem.reconstruction.completion import Draft, complete_edges
from fd2fem.reconstruction.gaps import polygons_of
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.outline import WallOutline

__all__ = ["assemble_facade", "draft_openings", "move_to_corner", "settle_conflicts"]

FloatArray = NDArray[np.float64]
Holes = tuple[Hole, ...]

APART = 0.001
"""Openings closer together than this, or to the wall's edge, leave no wall between, m."""


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


def settle_conflicts(drafts: Sequence[Draft], ring: FloatArray) -> tuple[list[Draft], dict[int, Hole]]:
    """Part the openings that a wall can have together from those that it cannot.

    Of two that touch, the less certain or the smaller one goes, and so does what leaves the wall or
    touches its edge goes, or whose edges cross. These are filled, with the reason.

    Parameters
    ----------
    drafts : sequence of Draft
    ring : (k, 2) float array, m
        The wall's outline; its bounding box starts at (0, 0).

    Returns
    -------
    kept : list of Draft
        In their order.
    refused : dict of int to Hole
        By the number of the hole.
    """
    wall = shapely.Polygon(ring)
    # A door reaches the ground: for it, the wall goes on below.
    ground = wall.union(shapely.affinity.translate(wall, yoff=-1.0))
    kept: list[tuple[Draft, shapely.Polygon]] = []
    refused = {}
    for draft in sorted(drafts, key=lambda draft: (-draft.hole.confidence, -draft.hole.area)):
        reason = ""
        left, right, bottom, top = (draft.position[side] for side in Side)
        shape = shapely.Polygon(_outline(draft).ring) if right > left and top > bottom else None
        if shape is None:
            reason = "its edges do not show"
        elif not (ground if draft.door else wall).buffer(-APART).contains(shape):
            reason = "it reaches the wall's edge"
        else:
            other = next((other for other, taken in kept if taken.distance(shape) < APART), None)
            if other is not None:
                reason = f"it touches the opening at x = {other.hole.x:.2f}, z = {other.hole.z:.2f} m"
        if reason and "override" not in draft.hole.evidence:
            kind, text = HoleKind.OCCLUSION, f"{reason}; else an opening: {draft.hole.reason}"
            refused[draft.number] = replace(draft.hole, kind=kind, reason=text, confidence=0.5)
        else:
            kept.append((draft, shape if shape is not None else shapely.Polygon()))
    order = {draft.number: index for index, draft in enumerate(drafts)}
    return sorted((draft for draft, _ in kept), key=lambda draft: order[draft.number]), refused


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
    InputError
        If the storeys of the options do not rise, or lie above the wall.
    """
    openings = [_opening(draft) for draft in drafts]
    # A filled hole is there to be looked at: its ragged outline need not be kept to every point.
    filled = [_filled(hole, outline.ring, points.spacing / 2.0) for hole in occlusions]
    try:
        facade = Facade(
            outline.ring,
            options.thickness,
            number_by_rows(openings),
            tuple(hole for hole in filled if hole is not None),
            points.frame,
        )
    except InputError as error:
        msg = f"What was found is no facade ({str(error).rstrip('.')}): check threshold and min_opening."
        raise ReconstructionError(msg) from error
    return replace(facade, storeys=options.storeys)


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
    outline = _outline(draft)
    return Opening(
        id=0,
        kind=OpeningKind.DOOR if draft.door else OpeningKind.WINDOW,
        outline=outline.ring,
        confidence=round(hole.confidence, 3),
        evidence=evidence,
        sigma=EdgeSigma(**{side.value: draft.sigma[side] for side in Side}),
        arcs=outline.arcs,
    )


def _outline(draft: Draft) -> Outline:
    """Outline of an opening."""
    if draft.outline is not None:
        return draft.outline
    left, right, bottom, top = (draft.position[side] for side in Side)
    return Outline(rectangle(left, bottom, right - left, top - bottom))


def _filled(hole: Hole, ring: FloatArray, tolerance: float) -> FilledHole | None:
    """The largest part of an occlusion that lies on the wall."""
    on_wall = shapely.Polygon(hole.loop).intersection(shapely.Polygon(ring))
    pieces = [piece for piece in polygons_of(on_wall) if piece.area > 0.0]
    if not pieces:
        return None
    largest = shapely.Polygon(max(pieces, key=lambda piece: piece.area).exterior.simplify(tolerance).coords)
    return FilledHole(np.array(largest.exterior.coords), hole.reason, hole.evidence)
