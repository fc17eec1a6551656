"""The face of a wall, cell by cell: small planes that join where one goes on in the next.

A wall that bulges goes on smoothly from cell to cell; a neighbour's wall, a frame or a course stands off by a
step, and a wall that crosses the plane at an angle changes its slope. So what belongs together is told by
what is next to each other, and not by the distance from one plane.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from fd2fem.reconstruction.thinning import pick
from fd2fem.reconstruction.walls import FACED, NEAR_PLANE, largest_part, wall_density

__all__ = ["connected_face"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

CELL = 0.5
"""Edge of the cells, m: a pier of 0.3 m still fills one enough."""
CROWD = 4.0
"""And as many point spacings, so that some points lie in each."""
ENOUGH = 0.25
"""A face holds at least this share of the points near the plane."""
BIN = 0.01
"""Depth is counted in steps of this to find the surface in a cell, m."""
FAR = 0.12
"""A patch counts the less, the farther it lies from the plane, and nothing beyond this, m."""
THICK = 0.025
"""Points so close to a cell's plane are on it, m."""
FEWEST = 5
"""Points that show a plane in a cell."""
STEEP = 0.05
"""Slope that a small or crowded cell may have at most by itself: the scatter of the slopes of a bow."""
KINK = 0.07
"""Slopes that differ more between neighbouring cells are those of two walls."""
STEP = 0.012
"""Planes that miss each other by more than this and the scatter of their points do not join, m."""
NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 0), (0, 2), (2, 1), (2, -1), (1, 2), (1, -2))
"""Cells that may join: an empty one may lie between them."""


@dataclass(frozen=True, eq=False)
class _Patches:
    """The planes y = level + slope_x (x - x0) + slope_z (z - z0) of the cells with enough points.

    `cell`: edge, m. `place`: column and row of each. `centre`: (x0, z0), m. `member`: number of the patch
    that each point lies on, -1 for none. `scatter`: of the points on them, m.
    """

    cell: float
    place: IntArray
    centre: FloatArray
    level: FloatArray
    slope: FloatArray
    member: IntArray
    scatter: float


def connected_face(near: FloatArray, box: tuple[FloatArray, FloatArray], scanners: FloatArray) -> IntArray:
    """Indices of the points of the largest connected face in a plane; one that a scanner faces counts more.

    Where hardly any cells join, as on sparse points of a rough wall, the connected points near the plane are
    taken for its face.

    Parameters
    ----------
    near : (m, 3) float array, m
        Points beside the plane, in its frame.
    box : two (2,) float arrays, m
        Lower and upper corner of the part of the plane to look in; the face may reach out of it.
    scanners : (s, 3) float array, m
    """
    plain = np.abs(near[:, 1]) < NEAR_PLANE
    for values, low, high in zip((near[:, 0], near[:, 2]), *box, strict=True):
        plain &= (values > low - CELL) & (values < high + CELL)
    on_plane = np.flatnonzero(plain)
    if len(on_plane) == 0:
        return on_plane
    xz = pick(near[:, [0, 2]], on_plane)
    patches = _patches(near, max(CELL, CROWD / float(np.sqrt(wall_density(xz)))))
    if len(patches.place):
        group = _join(patches)
        chosen = np.append(group == _largest(patches, group, box, scanners), False)
        part = np.flatnonzero(chosen[patches.member])
        if len(part) > ENOUGH * len(on_plane):
            return part
    return on_plane[largest_part(xz)]


def _largest(
    patches: _Patches, group: IntArray, box: tuple[FloatArray, FloatArray], scanners: FloatArray
) -> int:
    """The group of patches that covers most of a box in the plane."""
    half = patches.cell / 2
    inside = ((patches.centre > box[0] - half) & (patches.centre < box[1] + half)).all(axis=1)
    # The plane may have been laid through two walls, and lie off the middle of both.
    size = np.bincount(group, inside * np.maximum(0.0, 1.0 - (patches.level / FAR) ** 2))
    for number in np.flatnonzero(size > size.max() / FACED):
        x = patches.centre[group == number, 0]
        if ((scanners[:, 0] > x.min() - half) & (scanners[:, 0] < x.max() + half)).any():
            size[number] *= FACED
    return int(np.argmax(size))


def _patches(near: FloatArray, size: float) -> _Patches:
    """Fit a plane to the densest depth of each cell."""
    x, y, z = near.T
    column, row = (np.floor(values / size).astype(np.intp) for values in (x, z))
    low = np.array([column.min(), row.min()])
    rows = int(row.max()) - low[1] + 1
    cells, cell = np.unique((column - low[0]) * rows + row - low[1], return_inverse=True)
    centre = (low + np.column_stack(np.divmod(cells, rows)) + 0.5) * size
    depth = np.floor((y - y.min()) / BIN).astype(np.intp)
    bins = int(depth.max()) + 3
    count = np.bincount(cell * bins + depth + 1, minlength=len(cells) * bins).reshape(-1, bins)
    thick = count[:, :-2] + count[:, 1:-1] + count[:, 2:]
    level = y.min() + (np.argmax(thick, axis=1) + 0.5) * BIN
    slope = np.zeros((len(cells), 2))
    u, v = x - centre[cell, 0], z - centre[cell, 1]
    for _ in range(3):
        off = y - (level[cell] + slope[cell, 0] * u + slope[cell, 1] * v)
        on = np.abs(off) < THICK
        level, slope = _fit(cell[on], np.column_stack([u[on], v[on]]), y[on], len(cells))
    off = y - (level[cell] + slope[cell, 0] * u + slope[cell, 1] * v)
    on = np.abs(off) < THICK
    held = np.bincount(cell[on], minlength=len(cells)) >= FEWEST
    number = np.where(held, np.cumsum(held) - 1, -1)
    scatter = float(1.4826 * np.median(np.abs(off[on]))) if on.any() else 0.0
    place = low + np.column_stack(np.divmod(cells, rows))
    return _Patches(
        size, place[held], centre[held], level[held], slope[held], np.where(on, number[cell], -1), scatter
    )


def _fit(cell: IntArray, uv: FloatArray, y: FloatArray, cells: int) -> tuple[FloatArray, FloatArray]:
    """Least-squares level and slope of each cell's points; few or crowded points leave it level."""

    def total(values: FloatArray) -> FloatArray:
        return np.bincount(cell, values, minlength=cells).astype(np.float64)

    u, v = uv.T
    count = np.maximum(np.bincount(cell, minlength=cells), 1.0)
    mean_u, mean_v, mean_y = total(u) / count, total(v) / count, total(y) / count
    u, v, y = u - mean_u[cell], v - mean_v[cell], y - mean_y[cell]
    calm = (THICK / 4.0 / STEEP) ** 2
    uu, vv, uv_, uy, vy = total(u * u) + calm, total(v * v) + calm, total(u * v), total(u * y), total(v * y)
    det = uu * vv - uv_**2
    slope = np.column_stack([(uy * vv - vy * uv_) / det, (vy * uu - uy * uv_) / det])
    return mean_y - slope[:, 0] * mean_u - slope[:, 1] * mean_v, slope


def _join(patches: _Patches) -> IntArray:
    """Number the groups of patches that go on in one another."""
    low = patches.place.min(axis=0) - 2
    shape = patches.place.max(axis=0) - low + 3
    image = np.full(shape, -1)
    image[tuple((patches.place - low).T)] = np.arange(len(patches.place))
    step = STEP + patches.scatter
    first, second = [], []
    for offset in NEIGHBOURS:
        other = image[tuple((patches.place - low + offset).T)]
        one = np.flatnonzero(other >= 0)
        other = other[one]
        half = 0.5 * patches.cell * np.array(offset)
        gap = patches.level[other] - patches.level[one]
        gap -= (patches.slope[other] + patches.slope[one]) @ half
        kink = np.abs(patches.slope[other] - patches.slope[one]).max(axis=1)
        joined = (np.abs(gap) < step) & (kink < KINK * (patches.cell / CELL) * np.abs(offset).max())
        first.append(one[joined])
        second.append(other[joined])
    ends = (np.concatenate(first), np.concatenate(second))
    size = (len(patches.place), len(patches.place))
    graph = sparse.coo_array((np.ones(len(ends[0])), ends), shape=size)
    group: IntArray = connected_components(graph, directed=False)[1].astype(np.intp)
    return group
