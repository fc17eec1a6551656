"""Step 1.1: boundary points by the Delaunay criterion, and the holes that they ring.

Where a wall has a gap, the triangles over its points have long sides (figures 3 and 4 of the paper).
How long is too long follows from the point spacing around. The long triangles are taken together when they
share a side that is wide enough to pass an opening, so that the shadow of a lamp post does not join the
windows it crosses.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.errors import ReconstructionError
from fd2fem.model import Boundary, FacadePoints
from fd2fem.model.spacing import SpacingGrid
from fd2fem.reconstruction.clusters import PASSAGE, cluster_triangles
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.spacing import local_spacing
from fd2fem.reconstruction.triangulation import LongTriangles, long_triangles, side_lengths, triangle_areas

__all__ = ["OUTSIDE", "find_boundary", "length_threshold", "triangle_areas"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

OUTSIDE = -1
"""Cluster number of the long triangles that lie along the border of the triangulation."""
TYPICAL = 4.0
"""The threshold in local edge lengths: under one edge in ten thousand of evenly random points is longer."""
LEAST = 1.8
"""The threshold in local edge lengths that even regular points need."""
MISSED = 0.04
"""Share of the wall in gaps between single points from which on the threshold is raised there."""
RAISE, RAISES = 1.15, 6
"""Factor by which it is raised, and how often."""
SOLID = 0.1
"""A wall covers at least this share of its convex hull."""
SPARSE_SHARE = 0.05
"""Sparse points on a smaller share of the wall are not worth a word."""
SPARSE = 2.2
"""So much larger than asked for, at most, may the smallest opening be that the points can show."""


def length_threshold(edge: FloatArray, *, min_opening: float, raised: FloatArray | float = 1.0) -> FloatArray:
    """Longest edge expected inside a fully scanned wall, m, where the typical edge is known.

    Four times the typical edge, but at least a quarter and at most half of the smallest opening: shorter, and
    every missed point is a gap; longer, and triangles could bridge an opening. Where half an opening is
    less than 1.8 edges, these count.

    Parameters
    ----------
    edge : float array, m
        Typical edge lengths at some places.
    min_opening : float, m
    raised : float array or float
        Factor on the upper limit.

    Examples
    --------
    >>> length_threshold(np.array([0.005, 0.04, 0.09, 0.15]), min_opening=0.4).round(3).tolist()
    [0.1, 0.16, 0.2, 0.27]
    """
    highest = raised * np.maximum(min_opening / 2, LEAST * edge)
    return np.clip(TYPICAL * edge, min_opening / 4, highest)


def find_boundary(points: FacadePoints, *, options: ReconstructionOptions) -> Boundary:
    """Find the boundary points and cluster them by hole.

    Parameters
    ----------
    points : FacadePoints
    options : ReconstructionOptions

    Returns
    -------
    Boundary

    Raises
    ------
    ReconstructionError
        If the points cannot be triangulated, or are too sparse to show an opening.
    """
    xz = points.xz
    spacing = local_spacing(xz)
    gaps, over_wall = _gaps_by_local_threshold(xz, spacing, options)
    min_opening = max(options.min_opening, 2.0 * float(np.median(over_wall)))
    long, inner = gaps.long, gaps.cluster >= 0
    outer = np.union1d(long.hull, np.unique(long.corners[~inner]))
    return Boundary(
        threshold=float(np.median(over_wall)),
        points=np.union1d(np.unique(long.corners), outer),
        triangles=long.corners,
        hole_of_triangle=gaps.cluster,
        outer=outer,
        edge_lengths=spacing.edge_lengths,
        threshold_of_triangle=gaps.threshold,
        border_length=_border_lengths(gaps),
        min_opening=min_opening,
        spacing=spacing,
        warnings=_warnings(spacing, over_wall, min_opening, options),
    )


@dataclass(frozen=True, eq=False)
class _Gaps:
    """The long triangles (t,), the threshold at each, m, their sides (t, 3), m, areas, m², and clusters."""

    long: LongTriangles
    threshold: FloatArray
    sides: FloatArray
    areas: FloatArray
    cluster: IntArray

    @property
    def single(self) -> BoolArray:
        """Whether each triangle is of a gap that a few missed points can leave."""
        inner = self.cluster >= 0
        total = np.bincount(self.cluster[inner], self.areas[inner])
        # The last entry is for the triangles along the border.
        single: BoolArray = np.append(total, np.inf)[self.cluster] < self.threshold**2
        return single


def _gaps_by_local_threshold(
    xz: FloatArray, spacing: SpacingGrid, options: ReconstructionOptions
) -> tuple[_Gaps, FloatArray]:
    """The gaps, and the threshold in each coarse cell, m: so low that they do not lie all over the wall."""
    if options.threshold is not None:
        over_wall = np.full_like(spacing.edge, options.threshold)
        gaps = _find_gaps(xz, long_triangles(xz, options.threshold), spacing, over_wall, options.min_opening)
        _check_missed(xz, gaps, options.threshold)
        return gaps, over_wall
    raised = np.ones_like(spacing.edge)
    over_wall = higher = length_threshold(spacing.edge, min_opening=options.min_opening)
    long = long_triangles(xz, float(over_wall.min()))
    for _ in range(RAISES):
        over_wall = higher
        min_opening = max(options.min_opening, 2.0 * float(np.median(over_wall)))
        gaps = _find_gaps(xz, long, spacing, over_wall, min_opening)
        raised = np.where(_missed(xz, gaps, spacing) > MISSED, RAISE * raised, raised)
        higher = length_threshold(spacing.edge, min_opening=options.min_opening, raised=raised)
        if min_opening > SPARSE * options.min_opening or np.array_equal(higher, over_wall):
            break
    if min_opening > SPARSE * options.min_opening or _solid(xz, gaps) < SOLID:
        edge = float(np.median(spacing.edge))
        msg = (
            f"The points lie {1000 * edge:.0f} mm apart, too far to show openings of "
            f"{options.min_opening} m: scan more densely, or set min_opening to "
            f"{np.ceil(10 * max(min_opening, TYPICAL * edge)) / 10:.1f} m or more."
        )
        raise ReconstructionError(msg)
    return gaps, over_wall


def _find_gaps(
    xz: FloatArray, long: LongTriangles, spacing: SpacingGrid, over_wall: FloatArray, min_opening: float
) -> _Gaps:
    """Keep the triangles with a side over the local threshold and number the holes that they make up."""
    threshold = spacing.interpolate(over_wall, xz[long.corners].mean(axis=1))
    chosen = side_lengths(xz, long.corners).max(axis=1, initial=0.0) > threshold
    long, threshold = long.subset(chosen), threshold[chosen]
    sides, areas = side_lengths(xz, long.corners), triangle_areas(xz[long.corners])
    inner = ~_along_border(xz[long.hull], xz[long.corners], threshold)
    passage = np.maximum(PASSAGE * min_opening, threshold)
    wide = (sides > threshold[:, None])[inner], (sides > passage[:, None])[inner]
    cluster = np.full(len(long.corners), OUTSIDE)
    cluster[inner] = cluster_triangles(
        long.subset(inner).neighbours, wide, areas[inner], 0.5 * min_opening**2
    )
    return _Gaps(long, threshold, sides, areas, cluster)


def _missed(xz: FloatArray, gaps: _Gaps, spacing: SpacingGrid) -> FloatArray:
    """Share of the wall in gaps between single points, around each coarse cell."""
    cell = spacing.cell_of(xz[gaps.long.corners].mean(axis=1))
    shape, size = spacing.edge.shape, spacing.edge.size
    single = np.bincount(cell, gaps.areas * gaps.single, minlength=size).reshape(shape)
    holes = np.bincount(cell, gaps.areas * ~gaps.single, minlength=size).reshape(shape)
    solid = np.maximum(spacing.cell**2 - holes, SOLID * spacing.cell**2)
    smooth_single, smooth_solid = (ndimage.uniform_filter(a, size=3, mode="nearest") for a in (single, solid))
    share: FloatArray = smooth_single / smooth_solid
    return share


def _solid(xz: FloatArray, gaps: _Gaps) -> float:
    """Share of the convex hull that is not in gaps."""
    hull = shapely.MultiPoint(xz[gaps.long.hull]).convex_hull.area
    return 1.0 - float(gaps.areas.sum()) / hull


def _check_missed(xz: FloatArray, gaps: _Gaps, threshold: float) -> None:
    """Raise if the gaps that a given threshold shows are those between single points."""
    hull = shapely.MultiPoint(xz[gaps.long.hull]).convex_hull.area
    share = float(gaps.areas[gaps.single].sum()) / hull
    if share > 2.0 * MISSED or _solid(xz, gaps) < SOLID:
        msg = (
            f"{100 * (1.0 - _solid(xz, gaps)):.0f} % of the wall lies in gaps over {threshold:.3f} m wide, "
            "most of them between single points: scan more densely, or raise min_opening and threshold."
        )
        raise ReconstructionError(msg)


def _along_border(hull: FloatArray, corners: FloatArray, threshold: FloatArray) -> BoolArray:
    """Whether each of (t, 3, 2) triangles lies wholly within a threshold of one side of the convex hull.

    The border of a scanned wall is ragged, and long thin triangles fill it up to the convex hull;
    through them, two doors would join.
    """
    along = np.zeros(len(corners), dtype=np.bool_)
    if not len(corners):
        return along
    # Sides rather than the many short pieces that a ragged border has.
    wall = shapely.MultiPoint(hull).convex_hull.simplify(0.5 * float(np.median(threshold)))
    ring = shapely.get_coordinates(shapely.normalize(wall))[::-1]  # counter-clockwise: inside is to the left
    for start, run in zip(ring, np.diff(ring, axis=0), strict=False):
        normal = np.array([-run[1], run[0]]) / np.hypot(*run)
        along |= ((corners - start) @ normal < threshold[:, None]).all(axis=1)
    return along


def _border_lengths(gaps: _Gaps) -> FloatArray:
    """How much of each cluster's outline, m, lies on the hull or on the triangles along it."""
    # Neighbour -1 (none) reads the last entry.
    inner = np.append(gaps.cluster >= 0, True)
    counts = (gaps.long.on_hull | ~inner[gaps.long.neighbours]) & (gaps.sides > gaps.threshold[:, None])
    length = np.where(counts, gaps.sides, 0.0).sum(axis=1)[inner[:-1]]
    total: FloatArray = np.bincount(gaps.cluster[inner[:-1]], length).astype(np.float64)
    return total


def _warnings(
    spacing: SpacingGrid, over_wall: FloatArray, min_opening: float, options: ReconstructionOptions
) -> tuple[str, ...]:
    """What cannot be seen because the points are sparse."""
    sparse_cells = 2.0 * over_wall > 1.001 * min_opening
    if min_opening > 1.001 * options.min_opening:
        return (
            f"The points lie {1000 * np.median(spacing.edge):.0f} mm apart, too far to show openings of "
            f"{options.min_opening:g} m: those under {min_opening:.2f} m may be missing.",
        )
    # Beside gables and at ragged ends a few patches hold hardly any wall.
    if sparse_cells.mean() > SPARSE_SHARE:
        return (
            f"On {100 * sparse_cells.mean():.0f} % of the wall the points lie up to "
            f"{1000 * spacing.edge.max():.0f} mm apart: openings under {2 * over_wall.max():.2f} m may be "
            "missing there.",
        )
    return ()
