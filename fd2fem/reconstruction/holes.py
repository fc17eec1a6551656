"""Step 1.2: what each hole is, by the histograms of its boundary points and equation 1.

Where the scanner's position is known, the points before the wall are thrown along their rays onto
it: a hole that their shadow covers, and behind which nothing was seen, is an occlusion whatever its
shape.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from fd2fem.model import Boundary, FacadePoints, Hole, HoleKind
from fd2fem.reconstruction.boundary import triangle_areas
from fd2fem.reconstruction.options import ReconstructionOptions

__all__ = ["RayEvidence", "classify_holes", "equation_1", "histogram_peaks", "ray_evidence"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

SMALLEST = 0.25
"""Gaps smaller than this share of the smallest opening's area are not holes but missed points."""
RAY_CELL = 3.0
"""Edge of the cells that rays are counted in, in point spacings."""
EDGE_SHOWN = 0.2
"""An edge shows when so much of a hole's extent along it is seen."""
PEAK = 0.5
"""Share of the highest bin from which on a bin is a peak."""


def equation_1(height: float, length: float, *, options: ReconstructionOptions) -> str:
    """Why a hole of this size is no opening by equation 1 of the paper, or an empty string if it may be one.

    Parameters
    ----------
    height, length : float, m

    Examples
    --------
    >>> equation_1(1.5, 1.0, options=ReconstructionOptions())
    ''
    >>> equation_1(3.0, 0.2, options=ReconstructionOptions())
    'length 0.20 m is under 0.40 m'
    """
    if length < options.min_opening:
        return f"length {length:.2f} m is under {options.min_opening:.2f} m"
    if height < options.min_opening:
        return f"height {height:.2f} m is under {options.min_opening:.2f} m"
    if height / length < options.min_aspect:
        return f"height/length {height / length:.2f} is under {options.min_aspect:.2f}"
    if height / length > options.max_aspect:
        return f"height/length {height / length:.2f} is over {options.max_aspect:.2f}"
    return ""


def histogram_peaks(
    values: FloatArray, weights: FloatArray, *, centre: float, width: float, least: float = 0.0
) -> tuple[float, float]:
    """Positions of the two opposite edges of a hole: the peaks of a coordinate histogram (figure 5).

    On either side of the centre it is the outermost peak that counts, a peak being at least half as high as
    the highest. So a long edge across, whose points are spread over many bins, does not pass for one.

    Parameters
    ----------
    values : (b,) float array, m
        One coordinate of the hole's boundary.
    weights : (b,) float array
        How much of an edge lies there: points, or length along the edge.
    centre : float, m
        Inside the hole; one peak lies on either side of it.
    width : float, m
        Of a bin.
    least : float
        Weight below which nothing is a peak.

    Returns
    -------
    low, high : float, m
        Weighted medians in the peak bins; the extreme values where a side has no peak.

    Examples
    --------
    >>> jambs = np.array([1.0, 1.0, 1.01, 1.4, 1.7, 2.0, 2.0, 1.99])
    >>> histogram_peaks(jambs, np.ones(8), centre=1.5, width=0.05)
    (1.0, 2.0)
    """
    found = []
    for sign in (-1.0, 1.0):
        outward = sign * (values - centre)
        side = outward > 0
        if not side.any():
            found.append(float(values.min() if sign < 0 else values.max()))
            continue
        edges = np.arange(0.0, outward.max() + 3 * width, width)
        count, _ = np.histogram(outward[side], edges, weights=weights[side])
        # Pairs of bins, so that a peak that falls on a bin's edge is not halved.
        pair = count[:-1] + count[1:]
        if pair.max() < least:
            found.append(float(values.min() if sign < 0 else values.max()))
            continue
        peak = int(np.flatnonzero(pair >= PEAK * pair.max())[-1])
        if peak > 0 and pair[peak - 1] > pair[peak]:
            peak -= 1
        inside = np.flatnonzero(side & (outward >= edges[peak]) & (outward <= edges[peak + 2]))
        order = inside[np.argsort(values[inside], kind="stable")]
        half = np.searchsorted(np.cumsum(weights[order]), weights[order].sum() / 2.0)
        found.append(float(values[order[min(half, len(order) - 1)]]))
    return found[0], found[1]


@dataclass(frozen=True, eq=False)
class RayEvidence:
    """Where the rays that missed the wall's plane cross it; one array for each station.

    Attributes
    ----------
    shadow : tuple of (·, 2) float arrays, m
        Of the points before the wall, thrown along their rays onto it.
    seen_through : tuple of (·, 2) float arrays, m
        Where the rays to the points behind the wall pass it.
    """

    shadow: tuple[FloatArray, ...]
    seen_through: tuple[FloatArray, ...]


def ray_evidence(points: FacadePoints) -> RayEvidence:
    """Throw the points before and behind the wall along their rays onto its plane.

    Without a scanner's position both are empty. With several stations, each point is thrown from all
    of them: a joined scan does not say which one saw it, and what stands before the wall hides it from each.
    """
    return RayEvidence(
        shadow=tuple(_thrown(points.front, scanner) for scanner in points.scanners),
        seen_through=tuple(_thrown(points.behind, scanner) for scanner in points.scanners),
    )


def _thrown(away: FloatArray, scanner: FloatArray) -> FloatArray:
    """Where the rays from a scanner to points cross the wall's plane, (·, 2), m."""
    run = away[:, 1] - scanner[1]
    usable = run > 1e-6
    share = -scanner[1] / run[usable]
    crossing: FloatArray = scanner[[0, 2]] + share[:, None] * (away[usable][:, [0, 2]] - scanner[[0, 2]])
    return crossing


def classify_holes(
    points: FacadePoints, boundary: Boundary, *, options: ReconstructionOptions
) -> tuple[Hole, ...]:
    """Tell openings from occlusions.

    Parameters
    ----------
    points : FacadePoints
    boundary : Boundary
    options : ReconstructionOptions

    Returns
    -------
    tuple of Hole
        The largest first. Gaps much smaller than an opening are left out.
    """
    areas = triangle_areas(points.xz[boundary.triangles])
    inner = boundary.hole_of_triangle >= 0
    total = np.bincount(boundary.hole_of_triangle[inner], areas[inner])
    rays = ray_evidence(points)
    large = np.flatnonzero(total > SMALLEST * options.min_opening**2)
    found = [
        _classify(points, boundary, int(cluster), rays, options)
        for cluster in large[np.argsort(-total[large], kind="stable")]
    ]
    return tuple(_without_fragments(found, boundary.threshold))


def _classify(
    points: FacadePoints, boundary: Boundary, cluster: int, rays: RayEvidence, options: ReconstructionOptions
) -> Hole:
    """The verdict on one cluster of long triangles."""
    triangles = boundary.triangles[boundary.hole_of_triangle == cluster]
    region = shapely.union_all(shapely.polygons(points.xz[triangles]))
    pieces = [piece for piece in getattr(region, "geoms", [region]) if isinstance(piece, shapely.Polygon)]
    shape = max(pieces, key=lambda piece: piece.area)
    left, bottom, right, top = _rectangle(shape, boundary.threshold, points.spacing)
    foot = float(points.xz[:, 1].min()) if points.ground is None else points.ground
    cell = RAY_CELL * points.spacing
    foot_in_shadow = 0.0
    if _open_below(points, shape, (left, right), foot, boundary.threshold):
        bottom = foot
        lowest = shapely.box(left, foot, right, min(foot + options.min_opening, top))
        foot_in_shadow, _ = _share_of_cells(lowest, rays, cell=cell)
    box = shapely.box(left, bottom, right, top)
    filled = float(shape.intersection(box).area) + _fragments(points, boundary, cluster, box)
    filled = min(filled / max(float(box.area), 1e-12), 1.0)
    shadow, through = _share_of_cells(shape, rays, cell=cell)
    against = _against(right - left, top - bottom, filled, (shadow, through), options)
    return Hole(
        loop=np.array(shape.exterior.coords),
        points=np.unique(triangles),
        kind=HoleKind.OCCLUSION if against else HoleKind.OPENING,
        reason=against or "size, height/length and rectangularity are those of an opening (equation 1)",
        x=left,
        z=bottom,
        width=right - left,
        height=top - bottom,
        area=float(region.area),
        confidence=float(np.clip(filled * (1.0 - shadow * (1.0 - through)), 0.0, 1.0)),
        evidence={
            "aspect": round((top - bottom) / max(right - left, 1e-9), 3),
            "rectangularity": round(filled, 3),
            "in_shadow": round(shadow, 3),
            "seen_through": round(through, 3),
            "foot_in_shadow": round(foot_in_shadow, 3),
            "scanners": len(points.scanners),
        },
    )


def _fragments(points: FacadePoints, boundary: Boundary, cluster: int, box: shapely.Polygon) -> float:
    """Area of the other clusters in a hole's rectangle, m²: its cut-off corners."""
    corners = points.xz[boundary.triangles[boundary.hole_of_triangle != cluster]]
    low, high = np.array(box.bounds[:2]), np.array(box.bounds[2:])
    inside = ((corners > low) & (corners < high)).all(axis=(1, 2))
    return float(triangle_areas(corners[inside]).sum())


def _rectangle(shape: shapely.Polygon, threshold: float, spacing: float) -> tuple[float, float, float, float]:
    """Left, bottom, right and top of a hole by the histograms of its boundary, m."""
    corners = np.array(shape.exterior.coords)
    middle, run = (corners[1:] + corners[:-1]) / 2.0, np.abs(np.diff(corners, axis=0))
    # Longer segments bridge what is hidden, or cut a corner: no edge of the wall runs along them.
    seen = np.hypot(run[:, 0], run[:, 1]) <= threshold
    # The corners weigh nothing, but say how far the hole reaches where no edge shows.
    middle = np.concatenate([middle[seen], corners])
    run = np.concatenate([run[seen], np.zeros_like(corners)])
    centre, least = shape.centroid, EDGE_SHOWN * np.ptp(corners, axis=0)
    width = max(2.0 * spacing, 0.02)
    left, right = histogram_peaks(middle[:, 0], run[:, 1], centre=centre.x, width=width, least=least[1])
    bottom, top = histogram_peaks(middle[:, 1], run[:, 0], centre=centre.y, width=width, least=least[0])
    return left, bottom, right, top


def _against(
    length: float, height: float, filled: float, rays: tuple[float, float], options: ReconstructionOptions
) -> str:
    """Why a hole is an occlusion, or an empty string if it is an opening."""
    shadow, through = rays
    reason = equation_1(height, length, options=options)
    if reason:
        return reason
    if filled < options.min_rectangularity:
        return f"fills {100 * filled:.0f} % of its rectangle, under {100 * options.min_rectangularity:.0f} %"
    if shadow > options.max_shadow and through < 0.5 * shadow:
        return f"{100 * shadow:.0f} % of it lies in the shadow of things before the wall"
    return ""


def _open_below(
    points: FacadePoints, shape: shapely.Polygon, jambs: tuple[float, float], foot: float, threshold: float
) -> bool:
    """Whether a hole reaches the ground: its lowest point is near it, and no wall shows below."""
    lowest = shape.bounds[1]
    if lowest - foot > 3.0 * threshold:
        return False
    low, high = jambs[0] + threshold, jambs[1] - threshold
    columns = np.arange(low, high, threshold)
    if not len(columns):
        return False
    xz = points.xz
    below = (xz[:, 0] > low) & (xz[:, 0] < high) & (xz[:, 1] < max(lowest, foot + threshold))
    shown = np.unique(np.floor((xz[below, 0] - low) / threshold))
    # A car may hide most of the wall under a shop window; a door has none.
    return len(shown) < 0.2 * len(columns)


def _share_of_cells(shape: shapely.Polygon, rays: RayEvidence, *, cell: float) -> tuple[float, float]:
    """Shares of a hole's cells that are hidden from every station, and that a ray of any passed through."""
    left, bottom, right, top = shape.bounds
    columns = np.arange(left + cell / 2, right, cell)
    rows = np.arange(bottom + cell / 2, top, cell)
    inside = shapely.contains_xy(shape, *(grid.ravel() for grid in np.meshgrid(columns, rows, indexing="ij")))
    if not inside.any() or not rays.shadow:
        return 0.0, 0.0

    def hit(crossing: FloatArray) -> NDArray[np.bool_]:
        index = np.floor((crossing - [left, bottom]) / cell).astype(np.intp)
        index = index[((index >= 0) & (index < [len(columns), len(rows)])).all(axis=1)]
        cells = np.zeros((len(columns), len(rows)), dtype=bool)
        cells[index[:, 0], index[:, 1]] = True
        hits: NDArray[np.bool_] = cells.ravel()[inside]
        return hits

    hidden = np.all([hit(crossing) for crossing in rays.shadow], axis=0)
    passed = np.any([hit(crossing) for crossing in rays.seen_through], axis=0)
    return float(hidden.mean()), float(passed.mean())


def _without_fragments(holes: list[Hole], margin: float) -> list[Hole]:
    """Leave out occlusions that are only cut-off corners of an opening."""
    openings = [
        shapely.box(
            hole.x - margin, hole.z - margin, hole.x + hole.width + margin, hole.z + hole.height + margin
        )
        for hole in holes
        if hole.kind is HoleKind.OPENING
    ]
    return [
        hole
        for hole in holes
        if hole.kind is HoleKind.OPENING
        or not any(box.contains(shapely.Polygon(hole.loop)) for box in openings)
    ]
