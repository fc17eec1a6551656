"""The reconstruction from a point cloud to a facade, step by step as in the paper's figure 1."""

from dataclasses import asdict
from time import perf_counter

import numpy as np
import shapely

from fd2fem.errors import ReconstructionError
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
    PointCloud,
    Reconstruction,
    Side,
    rectangle,
)
from fd2fem.reconstruction.boundary import find_boundary
from fd2fem.reconstruction.boundary_lines import boundary_lines, check_size
from fd2fem.reconstruction.flying_voxel import voxelise
from fd2fem.reconstruction.holes import classify_holes
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import NOTHING_TELLS, find_facade
from fd2fem.reconstruction.quadtree import build_quadtree

__all__ = ["reconstruct"]

SLANT = np.radians(2.0)
"""An edge that leans more, and by more than the points' spacing explains, is reported."""


DEFAULTS = ReconstructionOptions()


def reconstruct(cloud: PointCloud, *, options: ReconstructionOptions = DEFAULTS) -> Reconstruction:
    """Reconstruct a facade from a scan.

    Parameters
    ----------
    cloud : PointCloud
    options : ReconstructionOptions

    Returns
    -------
    Reconstruction
        The facade and every intermediate result.

    Raises
    ------
    ReconstructionError
        If the points show no wall, or are too sparse for its openings.
    """
    clock = {}
    start = perf_counter()
    points = find_facade(cloud, options=options)
    clock["plane"] = perf_counter()
    boundary = find_boundary(points, options=options)
    clock["boundary"] = perf_counter()
    holes = classify_holes(points, boundary, options=options)
    clock["holes"] = perf_counter()
    tree = build_quadtree(points, boundary, max_size=options.voxel_limit)
    clock["quadtree"] = perf_counter()
    lines = boundary_lines(points, boundary, tree, holes, options)
    check_size(lines, options)
    clock["boundary_lines"] = perf_counter()
    facade = _facade(points, holes, lines, options)
    voxels = voxelise(facade, max_size=options.voxel_limit)
    clock["flying_voxel"] = perf_counter()
    record = {
        "points": {"read": len(cloud), "on_facade": len(points.xz)},
        "options": asdict(options) | {"threshold": boundary.threshold, "max_voxel": options.voxel_limit},
        "timings_s": _durations(start, clock),
        "source": cloud.source,
        "spacing": points.spacing,
        "plane_rms": points.rms,
        "outside_by": points.outside_by,
        "warnings": _warnings(points, lines),
    }
    facade = Facade(
        facade.outline, facade.thickness, facade.openings, facade.filled_holes, facade.frame, record
    )
    return Reconstruction(points, boundary, holes, tree, lines, voxels, facade)


def _durations(start: float, clock: dict[str, float]) -> dict[str, float]:
    """Seconds each step took."""
    ends = list(clock.values())
    return {
        name: round(end - begin, 4) for name, begin, end in zip(clock, [start, *ends], ends, strict=False)
    }


def _facade(
    points: FacadePoints,
    holes: tuple[Hole, ...],
    lines: tuple[BoundaryLine, ...],
    options: ReconstructionOptions,
) -> Facade:
    """Close the lines into rings, and put the origin at the wall's lower left corner."""
    wall = {line.side: line for line in lines if line.hole < 0}
    left, bottom = wall[Side.LEFT].position, wall[Side.BOTTOM].position
    length, height = wall[Side.RIGHT].position - left, wall[Side.TOP].position - bottom
    openings = []
    for number, hole in enumerate(holes):
        if hole.kind is HoleKind.OPENING:
            edges = {line.side: line for line in lines if line.hole == number}
            openings.append(_opening(hole, edges, left, bottom))
    openings.sort(key=lambda opening: (round(opening.z / options.min_opening), opening.x))
    openings = [
        Opening(number, o.kind, o.outline, o.confidence, o.evidence, o.sigma)
        for number, o in enumerate(openings, start=1)
    ]
    filled = [
        _filled(hole, left, bottom, length, height) for hole in holes if hole.kind is HoleKind.OCCLUSION
    ]
    frame = points.frame.moved(left, bottom)
    return Facade(
        rectangle(0.0, 0.0, length, height),
        options.thickness,
        tuple(openings),
        tuple(hole for hole in filled if hole is not None),
        frame,
    )


def _opening(hole: Hole, edges: dict[Side, BoundaryLine], left: float, bottom: float) -> Opening:
    """An opening from its three or four lines; the ground closes a door's."""
    door = Side.BOTTOM not in edges
    low_x, high_x = edges[Side.LEFT].position - left, edges[Side.RIGHT].position - left
    high_z = edges[Side.TOP].position - bottom
    low_z = 0.0 if door else edges[Side.BOTTOM].position - bottom
    if high_x <= low_x or high_z <= low_z:
        msg = (
            f"The lines of a hole at x = {low_x:.2f}, z = {low_z:.2f} m cross: its edges do not show; "
            "scan more densely there."
        )
        raise ReconstructionError(msg)
    return Opening(
        id=0,
        kind=OpeningKind.DOOR if door else OpeningKind.WINDOW,
        outline=rectangle(low_x, low_z, high_x - low_x, high_z - low_z),
        confidence=round(hole.confidence, 3),
        evidence={"verdict": hole.reason, **hole.evidence},
        sigma=EdgeSigma(
            left=edges[Side.LEFT].sigma,
            right=edges[Side.RIGHT].sigma,
            bottom=0.0 if door else edges[Side.BOTTOM].sigma,
            top=edges[Side.TOP].sigma,
        ),
    )


def _filled(hole: Hole, left: float, bottom: float, length: float, height: float) -> FilledHole | None:
    """The part of an occlusion that lies on the wall."""
    moved = shapely.Polygon(hole.loop - [left, bottom]).intersection(shapely.box(0.0, 0.0, length, height))
    pieces = [piece for piece in getattr(moved, "geoms", [moved]) if isinstance(piece, shapely.Polygon)]
    pieces = [piece for piece in pieces if piece.area > 0.0]
    if not pieces:
        return None
    largest = max(pieces, key=lambda piece: piece.area)
    return FilledHole(np.array(largest.exterior.coords), hole.reason, hole.evidence)


def _warnings(points: FacadePoints, lines: tuple[BoundaryLine, ...]) -> list[str]:
    """What the user should know before trusting the facade."""
    warnings = []
    if points.outside_by == NOTHING_TELLS:
        warnings.append(
            "Nothing in the scan tells the outside of the wall: if the facade comes out mirrored, "
            "give the scanner's position."
        )
    for line in lines:
        if line.hole < 0 and line.side is Side.BOTTOM and points.ground is not None:
            continue
        along = 1 if line.side.vertical else 0
        run = np.abs(line.end - line.start)
        if run[1 - along] > max(4.0 * points.spacing, np.tan(SLANT) * run[along]):
            name = "wall" if line.hole < 0 else f"opening at x = {line.position:.2f} m"
            warnings.append(
                f"The {line.side} edge of the {name} is off by {1000 * run[1 - along] / run[along]:.0f} mm a "
                "metre; it was taken as upright or level."
            )
    return warnings
