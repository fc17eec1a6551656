"""Step 1.1: boundary points by the Delaunay criterion, and the holes that they ring.

Where a wall has a gap, the triangles over its points have long sides (figures 3 and 4 of the paper).
Triangles with a side above the threshold are taken together when they share a side that is wide
enough to pass an opening, so that the shadow of a lamp post does not join the windows it crosses.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, QhullError

from fd2fem.errors import ReconstructionError
from fd2fem.model import Boundary, FacadePoints
from fd2fem.reconstruction.options import ReconstructionOptions

__all__ = ["OUTSIDE", "find_boundary", "length_threshold", "triangle_areas"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

OUTSIDE = -1
"""Cluster number of the long triangles that lie along the border of the triangulation."""
TYPICAL = 4.0
"""The threshold in median edge lengths: under one edge in ten thousand of evenly random points is longer."""
SPARSE = 0.28
"""Points whose median distance is a larger share of the smallest opening do not show it."""
MISSED = 0.08
"""Gaps too small for an opening may cover so much of the wall; random points thin out to this."""
PASSAGE = 0.75
"""Holes joined by a passage narrower than this share of the smallest opening are two holes."""


def length_threshold(edge_lengths: FloatArray, *, min_opening: float) -> float:
    """Longest edge expected inside a fully scanned wall, m, from the distribution of the edge lengths.

    Four times the median, but at least a quarter and at most half of the smallest opening: shorter,
    and every missed point is a gap; longer, and triangles could bridge an opening.

    Parameters
    ----------
    edge_lengths : (e,) float array, m
    min_opening : float, m

    Raises
    ------
    ReconstructionError
        If the points are so far apart that the smallest opening does not show.

    Examples
    --------
    >>> length_threshold(np.array([0.03, 0.04, 0.05]), min_opening=0.4)
    0.16
    """
    median = float(np.median(edge_lengths))
    if median > SPARSE * min_opening:
        msg = (
            f"The points lie {1000 * median:.0f} mm apart, too far to show openings of {min_opening} m: "
            f"scan more densely, or set min_opening to {np.ceil(10 * median / SPARSE) / 10:.1f} m or more."
        )
        raise ReconstructionError(msg)
    return float(np.clip(TYPICAL * median, min_opening / 4, min_opening / 2))


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
    triangulation = _triangulate(points.xz)
    triangles = triangulation.simplices.astype(np.intp)
    # Side k lies opposite to corner k, as the neighbours do.
    sides = points.xz[np.roll(triangles, -1, axis=1)] - points.xz[np.roll(triangles, -2, axis=1)]
    lengths = np.hypot(sides[..., 0], sides[..., 1])
    threshold = (
        length_threshold(lengths.ravel(), min_opening=options.min_opening)
        if options.threshold is None
        else options.threshold
    )
    long = np.flatnonzero((lengths > threshold).any(axis=1))
    outer = np.unique(triangulation.convex_hull)
    outside = _along_border(points.xz, triangles[long], threshold)
    passage = max(PASSAGE * options.min_opening, threshold)
    cluster = np.full(len(long), OUTSIDE)
    inner = long[~outside]
    cluster[~outside] = _cluster(
        triangulation.neighbors[inner],
        lengths[inner],
        names=inner,
        areas=triangle_areas(points.xz[triangles[inner]]),
        widths=(threshold, passage),
    )
    _check_gaps(points.xz, triangles[long], cluster, threshold, options)
    return Boundary(
        threshold=threshold,
        points=np.union1d(np.unique(triangles[long]), outer).astype(np.intp),
        triangles=triangles[long],
        hole_of_triangle=cluster,
        outer=np.union1d(outer, np.unique(triangles[long[outside]])).astype(np.intp),
        edge_lengths=lengths.ravel(),
    )


def _triangulate(xz: FloatArray) -> Delaunay:
    """Delaunay triangulation of the wall's points, all of them used."""
    try:
        triangulation = Delaunay(xz - xz.mean(axis=0))
    except QhullError as error:
        reason = str(error).split("\n", 1)[0]
        msg = f"The wall's points cannot be triangulated ({reason}): they may lie on one line."
        raise ReconstructionError(msg) from error
    if len(triangulation.coplanar) > 0.001 * len(xz):
        msg = (
            f"The triangulation left out {len(triangulation.coplanar)} of {len(xz)} points: "
            "the coordinates lack precision."
        )
        raise ReconstructionError(msg)
    return triangulation


def _along_border(xz: FloatArray, triangles: IntArray, threshold: float) -> NDArray[np.bool_]:
    """Whether each triangle lies wholly within a threshold of one side of the bounding box.

    The border of a scanned wall is ragged, and long thin triangles fill it up to the convex hull;
    through them, two doors would join.
    """
    corners = xz[triangles]
    near_low = corners - xz.min(axis=0) < threshold
    near_high = xz.max(axis=0) - corners < threshold
    along: NDArray[np.bool_] = (near_low.all(axis=1) | near_high.all(axis=1)).any(axis=1)
    return along


def _check_gaps(
    xz: FloatArray,
    triangles: IntArray,
    cluster: IntArray,
    threshold: float,
    options: ReconstructionOptions,
) -> None:
    """Raise if gaps between single points, rather than holes, make up much of the wall."""
    inner = cluster >= 0
    total = np.bincount(cluster[inner], triangle_areas(xz[triangles[inner]]))
    small = float(total[total < 0.5 * options.min_opening**2].sum())
    share = small / float(np.ptp(xz, axis=0).prod())
    if share > MISSED:
        msg = (
            f"{100 * share:.0f} % of the wall lies in gaps over {threshold:.3f} m wide, yet no openings: "
            "scan more densely, or raise min_opening and threshold."
        )
        raise ReconstructionError(msg)


def triangle_areas(corners: FloatArray) -> FloatArray:
    """Areas, m², of (t, 3, 2) triangles."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area: FloatArray = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    return area


def _cluster(
    neighbours: IntArray,
    lengths: FloatArray,
    *,
    names: IntArray,
    areas: FloatArray,
    widths: tuple[float, float],
) -> IntArray:
    """Number the holes that the long triangles make up.

    Triangles joined through sides wider than a passage are the cores of holes. What lies between a core
    and the wall (cut-off corners, the rim) joins the core that it borders on; the rest are narrow gaps,
    joined through their long sides.
    """
    threshold, passage = widths
    position = np.full(int(max(names.max(initial=-1), neighbours.max(initial=-1))) + 2, -1)
    position[names] = np.arange(len(names))
    # Neighbour -1 (none) reads the last entry, which stays -1.
    other = position[neighbours]
    core = _components(other, (lengths > passage) & (other >= 0))
    size = np.bincount(core, areas, minlength=1)
    is_core = size[core] > 0.5 * (passage / PASSAGE) ** 2 if len(core) else np.zeros(0, dtype=bool)
    reachable = (lengths > threshold) & (other >= 0)
    result = np.where(is_core, core, -1)
    for side in range(3):
        joins = ~is_core & (result < 0) & reachable[:, side]
        joins[joins] = is_core[other[joins, side]]
        result[joins] = core[other[joins, side]]
    rest = result < 0
    among_rest = reachable & rest[:, None] & np.where(other >= 0, rest[other], False)
    gaps = _components(other, among_rest)
    result[rest] = gaps[rest] + len(core)
    return np.unique(result, return_inverse=True)[1].astype(np.intp).ravel()


def _components(other: IntArray, linked: NDArray[np.bool_]) -> IntArray:
    """Connected components of triangles, given each one's neighbours and which of these count."""
    first, side = np.nonzero(linked)
    shape = (len(other), len(other))
    graph = sparse.coo_array((np.ones(len(first)), (first, other[first, side])), shape=shape)
    component: IntArray = connected_components(graph, directed=False)[1].astype(np.intp)
    return component
