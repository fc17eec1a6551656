"""Step 2: re-voxelisation along the boundary lines, and the flying-voxel tests (figures 9 and 10).

Upright and level lines cut the voxels that they cross in two. A line that is neither, the chord of an arch or
the slope of a gable, has the voxels that it crosses divided into four again and again, until they are small.

A voxel's centre "flies" along straight segments. The first set (LS1) leads to the four sides of the bounding
box: the voxel lies outside the wall when they cross its outline an even number of times. The paper asks for
no crossing at all, which fails in a notch, where the centre sees the wall sideways; parity is what Jordan's
theorem says. The second set (LS2) leads to the centre of each opening: the voxel lies inside the opening
whose boundary lines it reaches the centre of without a crossing. For openings that are not convex, parity
decides here too.
"""

from enum import IntEnum

import numpy as np
import shapely
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import CellState, Facade, VoxelModel
from fd2fem.model.checks import check_positive
from fd2fem.reconstruction.quadtree import divide

__all__ = ["Case", "crossings", "fly", "refine", "revoxelise", "voxelise"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

COINCIDE = 1e-6
"""A line closer than this to a voxel's side coincides with it, m."""
MOST = 4e6
"""Voxels at the most along slanted lines."""


class Case(IntEnum):
    """Where a voxel is (figure 10)."""

    OUTSIDE = 1
    IN_OPENING = 2
    IN_WALL = 3


def voxelise(facade: Facade, *, max_size: float, tolerance: float = 0.02) -> VoxelModel:
    """Divide a facade into voxels along its boundary lines and tell the full ones from the empty ones.

    Parameters
    ----------
    facade : Facade
    max_size : float, m
        Largest voxel.
    tolerance : float, m
        Largest voxel across a slanted or curved edge: the steps in which the voxels follow it.

    Returns
    -------
    VoxelModel
        With upright and level edges only, its full voxels fill the wall exactly. Along the others they keep
        within half of a voxel's diagonal of the edge, so that its area is off by less than 0.71 x tolerance x
        the length of such edges; as the steps lie now inside, now outside, by far less: under 0.1 % of the
        wall, and of each arched opening, at the default.

    Raises
    ------
    InputError
        If `tolerance` asks for too many voxels.
    """
    rings = [facade.outline, *(opening.outline for opening in facade.openings)]
    lower, upper, _ = divide(facade.outline.min(axis=0), facade.outline.max(axis=0), max_size=max_size)
    levels = [np.array([[-1.0, s.z], [facade.length + 1.0, s.z]]) for s in facade.storeys]
    lower, upper = revoxelise(lower, upper, [*rings, *levels])
    lower, upper = refine(lower, upper, rings, tolerance=tolerance)
    case = fly((lower + upper) / 2.0, facade.outline, tuple(opening.outline for opening in facade.openings))
    state = np.where(case == Case.IN_WALL, int(CellState.FULL), int(CellState.EMPTY))
    tops = np.array([band.high for band in facade.bands])[:-1]
    band = np.searchsorted(tops, (lower[:, 1] + upper[:, 1]) / 2.0)
    thickness = np.array([band.thickness for band in facade.bands])[band]
    return VoxelModel(lower=lower, upper=upper, state=state, thickness=thickness)


def refine(
    lower: FloatArray, upper: FloatArray, rings: list[FloatArray], *, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Divide the voxels that slanted lines cross, in height and length, until both are at most `tolerance`.

    Parameters
    ----------
    lower, upper : (v, 2) float arrays, m
    rings : list of (k, 2) float arrays, m
        Closed polygons; their upright and level lines divide nothing here.
    tolerance : float, m

    Returns
    -------
    lower, upper : (w, 2) float arrays, m

    Raises
    ------
    InputError
        If that makes too many voxels.

    Examples
    --------
    >>> triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]])
    >>> low, high = refine(np.zeros((1, 2)), np.ones((1, 2)), [triangle], tolerance=0.5)
    >>> low.tolist()
    [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]]
    """
    check_positive("tolerance", tolerance)
    starts, ends = np.concatenate(rings), np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    slanted = np.min(np.abs(ends - starts), axis=1) > COINCIDE
    lines: NDArray[np.object_] = np.atleast_1d(
        np.asarray(shapely.linestrings(np.stack([starts[slanted], ends[slanted]], axis=1)))
    )
    if 3.0 * float(shapely.length(lines).sum()) / tolerance > MOST:
        msg = f"Voxels of {tolerance:g} m along the slanted edges are too many: take a larger tolerance."
        raise InputError(msg)
    done: list[tuple[FloatArray, FloatArray]] = []
    while len(lower) and len(lines):
        crossed = _crossed(lower, upper, lines) & ((upper - lower).max(axis=1) > tolerance + COINCIDE)
        done.append((lower[~crossed], upper[~crossed]))
        lower, upper = lower[crossed], upper[crossed]
        for axis in (0, 1):
            lower, upper = _halve(lower, upper, axis, tolerance)
    done.append((lower, upper))
    return np.concatenate([pair[0] for pair in done]), np.concatenate([pair[1] for pair in done])


def _crossed(lower: FloatArray, upper: FloatArray, lines: NDArray[np.object_]) -> NDArray[np.bool_]:
    """Whether a line passes through the inside of each voxel."""
    inset = np.minimum((upper - lower) / 4.0, COINCIDE)
    inside: NDArray[np.object_] = np.asarray(shapely.box(*(lower + inset).T, *(upper - inset).T))
    _, hit = shapely.STRtree(inside).query(lines, predicate="intersects")
    crossed = np.zeros(len(lower), dtype=bool)
    crossed[hit] = True
    return crossed


def _halve(
    lower: FloatArray, upper: FloatArray, axis: int, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Halve the voxels that are longer than the tolerance along an axis."""
    large = upper[:, axis] - lower[:, axis] > tolerance + COINCIDE
    near_upper, far_lower = upper[large].copy(), lower[large].copy()
    near_upper[:, axis] = far_lower[:, axis] = (lower[large, axis] + upper[large, axis]) / 2.0
    return (
        np.concatenate([lower[~large], lower[large], far_lower]),
        np.concatenate([upper[~large], near_upper, upper[large]]),
    )


def revoxelise(
    lower: FloatArray, upper: FloatArray, rings: list[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Divide the voxels that boundary lines cross: two children for one line, four for two (figure 9).

    Parameters
    ----------
    lower, upper : (v, 2) float arrays, m
    rings : list of (k, 2) float arrays, m
        Closed polygons; only their upright and level lines cut.

    Returns
    -------
    lower, upper : (w, 2) float arrays, m
        No such line passes through the inside of a voxel.

    Examples
    --------
    >>> ring = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 1.0], [0.0, 1.0]])
    >>> low, high = revoxelise(np.zeros((1, 2)), np.ones((1, 2)), [ring])
    >>> low.tolist(), high.tolist()
    ([[0.0, 0.0], [0.4, 0.0]], [[0.4, 1.0], [1.0, 1.0]])
    """
    # Only voxels on some line are cut; the many others need not be gone through line by line.
    touched = _touched(lower, upper, rings)
    aside = lower[~touched], upper[~touched]
    lower, upper = lower[touched], upper[touched]
    for axis in (0, 1):
        for ring in rings:
            starts, ends = ring, np.roll(ring, -1, axis=0)
            for start, end in zip(starts, ends, strict=True):
                if abs(start[axis] - end[axis]) > COINCIDE:
                    continue
                low, high = sorted((start[1 - axis], end[1 - axis]))
                lower, upper = _cut(lower, upper, axis, (start[axis] + end[axis]) / 2.0, (low, high))
    return np.concatenate([aside[0], lower]), np.concatenate([aside[1], upper])


def _touched(lower: FloatArray, upper: FloatArray, rings: list[FloatArray]) -> NDArray[np.bool_]:
    """Whether the box around any line of the rings meets each voxel."""
    left, foot, right, head = (np.ascontiguousarray(column) for column in (*lower.T, *upper.T))
    touched = np.zeros(len(lower), dtype=bool)
    for ring in rings:
        ends = np.stack([ring, np.roll(ring, -1, axis=0)])
        for low, high in zip(ends.min(axis=0), ends.max(axis=0), strict=True):
            touched |= (left <= high[0]) & (right >= low[0]) & (foot <= high[1]) & (head >= low[1])
    return touched


def _cut(
    lower: FloatArray, upper: FloatArray, axis: int, position: float, span: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Cut the voxels in two that a line at `position` crosses within its span."""
    crosses = (lower[:, axis] < position - COINCIDE) & (upper[:, axis] > position + COINCIDE)
    crosses &= (lower[:, 1 - axis] < span[1] - COINCIDE) & (upper[:, 1 - axis] > span[0] + COINCIDE)
    crossed = np.flatnonzero(crosses)
    if len(crossed) == 0:
        return lower, upper
    # The near parts take the place of the whole voxels, the far ones come last.
    count = len(lower)
    lower, upper = np.concatenate([lower, lower[crossed]]), np.concatenate([upper, upper[crossed]])
    upper[crossed, axis] = position
    lower[count:, axis] = position
    return lower, upper


def crossings(start: FloatArray, end: FloatArray, ring: FloatArray) -> IntArray:
    """How often each segment crosses a closed polygon.

    Parameters
    ----------
    start, end : (n, 2) float arrays, m
    ring : (k, 2) float array, m

    Returns
    -------
    (n,) int array
        A corner of the ring on a segment counts once where the ring passes through, not where it only
        touches.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> crossings(np.array([[0.5, 0.5], [-1.0, 0.5]]), np.array([[2.0, 0.5], [2.0, 0.5]]), square).tolist()
    [1, 2]
    """
    total = np.zeros(len(start), dtype=np.intp)
    along = end - start
    offset = _cross(along, ring[0] - start)
    for first, second in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        next_offset = _cross(along, second - start)
        # "On the segment" counts as left of it, so that a corner counts once.
        passes = np.flatnonzero((offset >= 0.0) != (next_offset >= 0.0))
        side = second - first
        about_start = _cross(side, start[passes] - first)
        about_end = _cross(side, end[passes] - first)
        total[passes] += about_start * about_end < 0.0
        offset = next_offset
    return total


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    product: FloatArray = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return product


def fly(centres: FloatArray, outline: FloatArray, openings: tuple[FloatArray, ...]) -> IntArray:
    """Case of each voxel by the tests LS1 and LS2.

    Parameters
    ----------
    centres : (n, 2) float array, m
        Centres of gravity of the voxels; none lies on a boundary line.
    outline : (k, 2) float array, m
    openings : tuple of (·, 2) float arrays, m

    Returns
    -------
    (n,) int array
        `Case` of each.
    """
    low, high = outline.min(axis=0) - 1.0, outline.max(axis=0) + 1.0
    odd = np.zeros(len(centres), dtype=np.intp)
    for axis, value in ((0, low[0]), (0, high[0]), (1, low[1]), (1, high[1])):
        end = centres.copy()
        end[:, axis] = value
        odd += crossings(centres, end, outline) % 2
    # All four agree unless a centre lies on a line within rounding; then the majority decides.
    case = np.where(odd >= 2, int(Case.IN_WALL), int(Case.OUTSIDE))
    x, z = np.ascontiguousarray(centres.T)
    for ring in openings:
        shape = shapely.Polygon(ring)
        (left, foot), (right, head) = ring.min(axis=0), ring.max(axis=0)
        near = np.flatnonzero((x > left) & (x < right) & (z > foot) & (z < head))
        if shape.convex_hull.area - shape.area < 1e-9 * shape.area:
            target = np.broadcast_to(np.array(shape.centroid.coords[0]), (len(near), 2))
            inside = crossings(centres[near], target, ring) == 0
        else:
            end = np.column_stack([np.full(len(near), high[0]), centres[near, 1]])
            inside = crossings(centres[near], end, ring) % 2 == 1
        case[near[inside]] = Case.IN_OPENING
    return case
