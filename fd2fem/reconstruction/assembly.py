"""From boundary lines to the facade: its own frame, closed rings, filled occlusions."""

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fd2fem.errors import InputError, ReconstructionError
from fd2fem.model import (
    BoundaryLine,
    EdgeSigma,
    Facade,
    FacadePoints,
    FilledHole,
    Hole,
    HoleKind,
    Opening,
    OpeningKind,
    QuadTree,
    Side,
    number_by_rows,
    rectangle,
)
from fd2fem.reconstruction.options import ReconstructionOptions

__all__ = ["assemble_facade", "complete_sills", "move_to_corner"]

ALIKE = 0.1
"""Openings are alike whose heads differ by less, m, and whose widths by a smaller share."""
HIDDEN_SIGMA = 0.05
"""Standard error of a sill that was not seen, m."""
Lines = tuple[BoundaryLine, ...]
Holes = tuple[Hole, ...]


def move_to_corner(
    points: FacadePoints, holes: Holes, tree: QuadTree, lines: Lines
) -> tuple[FacadePoints, Holes, QuadTree, Lines]:
    """Shift all records into the facade frame, whose origin is the wall's lower left corner."""
    wall = {line.side: line.position for line in lines if line.hole < 0}
    corner = np.array([wall[Side.LEFT], wall[Side.BOTTOM]])
    away = np.insert(corner, 1, 0.0)
    moved_points = replace(
        points,
        xz=points.xz - corner,
        front=points.front - away,
        behind=points.behind - away,
        scanners=points.scanners - away,
        frame=points.frame.moved(*corner),
        ground=None if points.ground is None else points.ground - float(corner[1]),
    )
    moved_holes = tuple(
        replace(hole, loop=hole.loop - corner, x=hole.x - float(corner[0]), z=hole.z - float(corner[1]))
        for hole in holes
    )
    moved_tree = replace(tree, lower=tree.lower - corner, upper=tree.upper - corner)
    return moved_points, moved_holes, moved_tree, tuple(_moved_line(line, corner) for line in lines)


def _moved_line(line: BoundaryLine, corner: NDArray[np.float64]) -> BoundaryLine:
    shift = float(corner[0] if line.side.vertical else corner[1])
    return replace(line, start=line.start - corner, end=line.end - corner, position=line.position - shift)


def assemble_facade(
    points: FacadePoints, holes: Holes, lines: Lines, *, options: ReconstructionOptions
) -> Facade:
    """Close the lines into rings and fill the occlusions.

    Parameters
    ----------
    points : FacadePoints
    holes : tuple of Hole
    lines : tuple of BoundaryLine
        All of these in the facade frame.
    options : ReconstructionOptions

    Raises
    ------
    ReconstructionError
        If the lines of an opening cross, or openings touch.
    """
    wall = {line.side: line.position for line in lines if line.hole < 0}
    outline = rectangle(0.0, 0.0, wall[Side.RIGHT], wall[Side.TOP])
    openings = [
        _opening(hole, {line.side: line for line in lines if line.hole == number})
        for number, hole in enumerate(holes)
        if hole.kind is HoleKind.OPENING
    ]
    filled = [_filled(hole, outline) for hole in holes if hole.kind is HoleKind.OCCLUSION]
    try:
        return Facade(
            outline,
            options.thickness,
            number_by_rows(complete_sills(openings, options=options)),
            tuple(hole for hole in filled if hole is not None),
            points.frame,
        )
    except InputError as error:
        msg = f"What was found is no facade ({str(error).rstrip('.')}): check threshold and min_opening."
        raise ReconstructionError(msg) from error


def complete_sills(openings: list[Opening], *, options: ReconstructionOptions) -> list[Opening]:
    """Give hidden sills the height of those of like openings.

    An opening whose foot lies in shadow may be a window or a door. If its width and head are those of two
    windows or more, it is one of their row.

    Parameters
    ----------
    openings : list of Opening
    options : ReconstructionOptions
    """
    completed = []
    for opening in openings:
        like = [
            other
            for other in openings
            if other.kind is OpeningKind.WINDOW
            and abs(other.width - opening.width) < ALIKE * opening.width
            and abs(other.z + other.height - opening.z - opening.height) < ALIKE
        ]
        hidden = opening.evidence.get("foot_in_shadow", 0.0) > options.max_shadow
        if opening.kind is OpeningKind.DOOR and hidden and len(like) >= 2:
            sills = np.array([other.z for other in like])
            outline = np.maximum(opening.outline, [-np.inf, float(np.median(sills))])
            completed.append(
                replace(
                    opening,
                    kind=OpeningKind.WINDOW,
                    outline=outline,
                    sigma=replace(opening.sigma, bottom=float(max(np.std(sills), HIDDEN_SIGMA))),
                    evidence={**opening.evidence, "sill": f"hidden; taken from {len(like)} openings like it"},
                )
            )
        else:
            completed.append(opening)
    return completed


def _opening(hole: Hole, edges: dict[Side, BoundaryLine]) -> Opening:
    """An opening from its three or four lines; the ground closes a door's."""
    left, right, top = (edges[side].position for side in (Side.LEFT, Side.RIGHT, Side.TOP))
    bottom = edges[Side.BOTTOM].position if Side.BOTTOM in edges else 0.0
    if right <= left or top <= bottom:
        msg = (
            f"The lines of the hole at x = {hole.x:.2f}, z = {hole.z:.2f} m cross: its edges do not show; "
            "scan more densely there."
        )
        raise ReconstructionError(msg)
    return Opening(
        id=0,
        kind=OpeningKind.WINDOW if Side.BOTTOM in edges else OpeningKind.DOOR,
        outline=rectangle(left, bottom, right - left, top - bottom),
        confidence=round(hole.confidence, 3),
        evidence={"verdict": hole.reason, **hole.evidence},
        sigma=EdgeSigma(**{side.value: line.sigma for side, line in edges.items()}),
    )


def _filled(hole: Hole, outline: NDArray[np.float64]) -> FilledHole | None:
    """The largest part of an occlusion that lies on the wall."""
    on_wall = shapely.Polygon(hole.loop).intersection(shapely.Polygon(outline))
    pieces = [piece for piece in getattr(on_wall, "geoms", [on_wall]) if isinstance(piece, shapely.Polygon)]
    pieces = [piece for piece in pieces if piece.area > 0.0]
    if not pieces:
        return None
    largest = max(pieces, key=lambda piece: piece.area)
    return FilledHole(np.array(largest.exterior.coords), hole.reason, hole.evidence)
