"""The reconstruction from a point cloud to a facade, step by step as in the paper's figure 1."""

from dataclasses import asdict, replace
from time import perf_counter

from fd2fem.model import PointCloud, Reconstruction
from fd2fem.reconstruction.assembly import assemble_facade, move_to_corner
from fd2fem.reconstruction.boundary import find_boundary
from fd2fem.reconstruction.boundary_lines import boundary_lines, check_size
from fd2fem.reconstruction.caveats import opening_warnings, outline_warnings
from fd2fem.reconstruction.flying_voxel import voxelise
from fd2fem.reconstruction.holes import classify_holes
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import find_facade
from fd2fem.reconstruction.quadtree import build_quadtree

__all__ = ["reconstruct"]

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
        "warnings": [
            *points.warnings,
            *outline_warnings(points, boundary, holes, facade, options),
            *opening_warnings(points, holes, lines, facade, options),
        ],
    }
    return Reconstruction(points, boundary, holes, tree, lines, voxels, replace(facade, record=record))


def _durations(start: float, clock: dict[str, float]) -> dict[str, float]:
    """Seconds each step took."""
    ends = list(clock.values())
    return {
        name: round(end - begin, 4) for name, begin, end in zip(clock, [start, *ends], ends, strict=False)
    }
