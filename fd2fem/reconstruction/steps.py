"""The reconstruction from a point cloud to a facade, step by step as in the paper's figure 1."""

from dataclasses import asdict, replace
from time import perf_counter
from typing import Any

from fd2fem.model import Boundary, FacadePoints, HoleKind, PointCloud, Reconstruction
from fd2fem.reconstruction.assembly import assemble_facade, draft_openings, move_to_corner, settle_conflicts
from fd2fem.reconstruction.boundary import find_boundary
from fd2fem.reconstruction.boundary_lines import boundary_lines
from fd2fem.reconstruction.caveats import edge_warnings, hole_warnings, opening_warnings
from fd2fem.reconstruction.edges import exclusion_distance
from fd2fem.reconstruction.flying_voxel import voxelise
from fd2fem.reconstruction.holes import classify_holes
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.outline import wall_outline
from fd2fem.reconstruction.plane import find_facade
from fd2fem.reconstruction.quadtree import build_quadtree
from fd2fem.reconstruction.rays import cast_shadows, ray_map
from fd2fem.reconstruction.sampling import Sampling
from fd2fem.reconstruction.strips import View
from fd2fem.reconstruction.tops import fit_tops
from fd2fem.reconstruction.wall_points import measured_noise

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
    clock = {"start": perf_counter()}
    points = find_facade(cloud, options=options)
    clock["plane"] = perf_counter()
    boundary = find_boundary(points, options=options)
    # Sparse points may not show the smallest openings that were asked for.
    options = replace(options, min_opening=max(options.min_opening, boundary.min_opening))
    clock["boundary"] = perf_counter()
    rays = ray_map(cloud, points)
    clock["rays"] = perf_counter()
    sampling = Sampling(points.spacing, points.rms, exclusion_distance(points.xz))
    # In a band that was given, pilasters, panels and set-backs are no noise; a wall ends without reveals.
    noise = points.rms if options.wall_band is None else measured_noise(points.xz, points.depth)
    outline = wall_outline(points, boundary, cast_shadows(rays), replace(sampling, noise=noise))
    points, boundary, rays, outline = move_to_corner(points, boundary, rays, outline)
    clock["outline"] = perf_counter()
    shadows = cast_shadows(rays)
    holes = classify_holes(points, boundary, shadows, outline=outline.ring, options=options)
    clock["holes"] = perf_counter()
    tree = build_quadtree(points, boundary, max_size=options.voxel_limit)
    clock["quadtree"] = perf_counter()
    view = View(points, boundary, holes, shadows, sampling)
    lines = boundary_lines(view, tree)
    drafts = fit_tops(view, draft_openings(holes, lines), options=options)
    clock["boundary_lines"] = perf_counter()
    drafts, refused = settle_conflicts(drafts, outline.ring)
    holes = tuple(refused.get(number, hole) for number, hole in enumerate(holes))
    filled = [hole for hole in holes if hole.kind is HoleKind.OCCLUSION]
    facade = assemble_facade(points, outline, drafts, filled, options=options)
    voxels = voxelise(facade, max_size=options.voxel_limit, tolerance=options.voxel_tolerance)
    clock["flying_voxel"] = perf_counter()
    warnings = [
        *points.warnings,
        *boundary.warnings,
        *outline.warnings,
        *hole_warnings(holes, facade, options),
        *opening_warnings(facade, options),
        *edge_warnings(view, lines, drafts),
    ]
    record = {
        "points": {"read": len(cloud), "on_facade": len(points.xz)},
        "timings_s": _durations(clock),
        "source": cloud.source,
        **_settings(boundary, options),
        **_findings(points),
        "outline_sigma": list(outline.sigma),
        "warnings": warnings,
    }
    facade = replace(facade, record=record)
    return Reconstruction(points, boundary, rays, holes, tree, lines, voxels, facade)


def _settings(boundary: Boundary, options: ReconstructionOptions) -> dict[str, Any]:
    """The options in force."""
    in_force = {
        "threshold": boundary.threshold,
        "max_voxel": options.voxel_limit,
    }
    return {"options": asdict(options) | in_force}


def _findings(points: FacadePoints) -> dict[str, Any]:
    """What the scan shows of the wall besides its outline and openings."""
    relief = points.relief
    return {
        "spacing": points.spacing,
        "plane_rms": points.rms,
        "outside_by": points.outside_by,
        "walls": [asdict(wall) | {"centre": wall.centre.tolist()} for wall in points.walls],
        "attachments": [asdict(thing) for thing in points.attachments],
        "out_of_plane": {
            "low": relief.low.tolist(),
            "cell": relief.cell,
            "values": relief.values.round(4).tolist(),
        },
    }


def _durations(clock: dict[str, float]) -> dict[str, float]:
    """Seconds each step took."""
    names, ends = list(clock), list(clock.values())
    return {name: round(end - begin, 4) for name, begin, end in zip(names[1:], ends, ends[1:], strict=False)}
