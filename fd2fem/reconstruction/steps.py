"""The reconstruction from a point cloud to a facade, step by step as in the paper's figure 1."""

from dataclasses import asdict, replace
from time import perf_counter

import numpy as np

from fd2fem.model import BoundaryLine, Facade, FacadePoints, Hole, HoleKind, PointCloud, Reconstruction, Side
from fd2fem.reconstruction.assembly import assemble_facade, move_to_corner
from fd2fem.reconstruction.boundary import find_boundary
from fd2fem.reconstruction.boundary_lines import boundary_lines, check_size
from fd2fem.reconstruction.flying_voxel import voxelise
from fd2fem.reconstruction.holes import classify_holes
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import find_facade
from fd2fem.reconstruction.quadtree import build_quadtree

__all__ = ["reconstruct"]

SLANT = np.radians(2.0)
"""An edge that leans more, and by more than the points' spacing explains, is reported."""


SEEN_THROUGH = 0.3
"""A hole that rays passed in so much of it is hardly an occlusion."""
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
    points, holes, tree, lines = move_to_corner(points, holes, tree, lines)
    clock["boundary_lines"] = perf_counter()
    facade = assemble_facade(points, holes, lines, options=options)
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
        "warnings": _warnings(points, holes, lines, facade, options),
    }
    return Reconstruction(points, boundary, holes, tree, lines, voxels, replace(facade, record=record))


def _durations(start: float, clock: dict[str, float]) -> dict[str, float]:
    """Seconds each step took."""
    ends = list(clock.values())
    return {
        name: round(end - begin, 4) for name, begin, end in zip(clock, [start, *ends], ends, strict=False)
    }


def _warnings(
    points: FacadePoints,
    holes: tuple[Hole, ...],
    lines: tuple[BoundaryLine, ...],
    facade: Facade,
    options: ReconstructionOptions,
) -> list[str]:
    """What the user should know before trusting the facade."""
    warnings = [*points.warnings]
    warnings += [
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
