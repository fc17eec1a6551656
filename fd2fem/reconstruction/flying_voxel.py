"""Step 2: re-voxelisation along the boundary lines, and the flying-voxel tests (figures 9 and 10).

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
from fd2fem.reconstruction.quadtree import divide

__all__ = ["Case", "crossings", "fly", "revoxelise", "voxelise"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

COINCIDE = 1e-6
"""A line closer than this to a voxel's side coincides with it, m."""


class Case(IntEnum):
    """Where a voxel is (figure 10)."""

    OUTSIDE = 1
    IN_OPENING = 2
    IN_WALL = 3


def voxelise(facade: Facade, *, max_size: float) -> VoxelModel:
    """Divide a facade into voxels along its boundary lines and tell the full ones from the empty ones.

    Parameters
    ----------
    facade : Facade
        With horizontal and vertical edges only.
    max_size : float, m
        Largest voxel.

    Returns
    -------
    VoxelModel
        Its full voxels fill the wall exactly.

    Raises
    ------
    InputError
        If an edge is slanted: rectangular voxels cannot follow it.
    """
    rings = [facade.outline, *(opening.outline for opening in facade.openings)]
    for number, ring in enumerate(rings):
        if np.min(np.abs(np.roll(ring, -1, axis=0) - ring), axis=1).max() > COINCIDE:
            name = f"opening {facade.openings[number - 1].id}" if number else "the wall's outline"
            msg = f"Voxels need horizontal and vertical edges, and {name} has a slanted one."
            raise InputError(msg)
    lower, upper, _ = divide(facade.outline.min(axis=0), facade.outline.max(axis=0), max_size=max_size)
    lower, upper = revoxelise(lower, upper, rings)
    case = fly((lower + upper) / 2.0, facade.outline, tuple(opening.outline for opening in facade.openings))
    state = np.where(case == Case.IN_WALL, int(CellState.FULL), int(CellState.EMPTY))
    return VoxelModel(lower=lower, upper=upper, state=state, thickness=facade.thickness)


def revoxelise(
    lower: FloatArray, upper: FloatArray, rings: list[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Divide the voxels that boundary lines cross: two children for one line, four for two (figure 9).

    Parameters
    ----------
    lower, upper : (v, 2) float arrays, m
    rings : list of (k, 2) float arrays, m
        Closed polygons of horizontal and vertical lines.

    Returns
    -------
    lower, upper : (w, 2) float arrays, m
        No line passes through the inside of a voxel.

    Examples
    --------
    >>> ring = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 1.0], [0.0, 1.0]])
    >>> low, high = revoxelise(np.zeros((1, 2)), np.ones((1, 2)), [ring])
    >>> low.tolist(), high.tolist()
    ([[0.0, 0.0], [0.4, 0.0]], [[0.4, 1.0], [1.0, 1.0]])
    """
    for axis in (0, 1):
        for ring in rings:
            starts, ends = ring, np.roll(ring, -1, axis=0)
            for start, end in zip(starts, ends, strict=True):
                if abs(start[axis] - end[axis]) > COINCIDE:
                    continue
                low, high = sorted((start[1 - axis], end[1 - axis]))
                lower, upper = _cut(lower, upper, axis, (start[axis] + end[axis]) / 2.0, (low, high))
    return lower, upper


def _cut(
    lower: FloatArray, upper: FloatArray, axis: int, position: float, span: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Cut the voxels in two that a line at `position` crosses within its span."""
    crossed = (lower[:, axis] < position - COINCIDE) & (upper[:, axis] > position + COINCIDE)
    crossed &= (lower[:, 1 - axis] < span[1] - COINCIDE) & (upper[:, 1 - axis] > span[0] + COINCIDE)
    if not crossed.any():
        return lower, upper
    near_upper, far_lower = upper[crossed].copy(), lower[crossed].copy()
    near_upper[:, axis] = position
    far_lower[:, axis] = position
    return (
        np.concatenate([lower[~crossed], lower[crossed], far_lower]),
        np.concatenate([upper[~crossed], near_upper, upper[crossed]]),
    )


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
    for first, second in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        # "On the segment" counts as left of it, so that a corner counts once.
        left_first = _cross(along, first - start) >= 0.0
        left_second = _cross(along, second - start) >= 0.0
        side = second - first
        about_start = _cross(side, start - first)
        about_end = _cross(side, end - first)
        total += (left_first != left_second) & (about_start * about_end < 0.0)
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
    for ring in openings:
        shape = shapely.Polygon(ring)
        near = np.flatnonzero(((centres > ring.min(axis=0)) & (centres < ring.max(axis=0))).all(axis=1))
        if shape.convex_hull.area - shape.area < 1e-9 * shape.area:
            target = np.broadcast_to(np.array(shape.centroid.coords[0]), (len(near), 2))
            inside = crossings(centres[near], target, ring) == 0
        else:
            end = np.column_stack([np.full(len(near), high[0]), centres[near, 1]])
            inside = crossings(centres[near], end, ring) % 2 == 1
        case[near[inside]] = Case.IN_OPENING
    return case
