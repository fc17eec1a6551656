"""Voxels and other cells to a conformal boundary representation (Appendix A of the paper).

Seen from outside, the wall is a division of the plane into cells with corners and sides. It is drawn out
into the wall through levels: y = 0, the flush front, and every thickness that occurs. Between two levels
lies a slab, and a cell has slabs up to its own thickness. A corner becomes a keypoint on each level and a
line through each slab, a side a line on each level and an area through each slab, a cell an area on each
level and a volume in each slab; what neighbours have in common is there once.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import SolidModel, VoxelModel, WallCells
from fd2fem.solids.cells import divide_cells
from fd2fem.solids.division import Division, divide_voxels
from fd2fem.solids.grid import merged
from fd2fem.solids.joints import check_joined

__all__ = ["solid_from_cells", "solid_from_voxels"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
Ids = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class _Layers:
    """Numbers of a solid's parts, from 0: a row per level or slab, a column per corner, side or cell.

    -1 stands where the wall does not reach. `y` (l,), m, are the levels; `slabs` (c,) is how many slabs each
    cell has; `first` (slabs, s) where in the division's rings each side's area is used first: its loop suits
    that cell.
    """

    y: FloatArray
    slabs: IntArray
    keypoints: IntArray
    side_lines: IntArray
    through_lines: IntArray
    cell_areas: IntArray
    side_areas: IntArray
    first: IntArray


def solid_from_voxels(voxels: VoxelModel) -> SolidModel:
    """Boundary representation with one volume for each full voxel, and for each slab of it.

    Neighbours share their keypoints, lines and areas. Where they differ in size, the larger one's
    edges are cut at every keypoint on them, so that its front and back are loops of more than four
    lines. Where they differ in thickness, the thicker one is cut at the other's back. Coordinates within
    1e-7 m of each other are one, and voxels narrower than that vanish.

    Parameters
    ----------
    voxels : VoxelModel
        Only the full ones count.

    Returns
    -------
    solid : SolidModel
        Keypoints by level, the front first. Areas: fronts, the following levels, then sides by slab. Volumes
        by slab, each in the order of the full voxels.

    Raises
    ------
    InputError
        If no voxel is full, one is inverted or has no thickness, or two overlap.

    References
    ----------
    Appendix A of the paper: eight keypoints, twelve lines, six areas and a volume for a voxel; loops
    after the right-hand rule about the outward normal, negative numbers for reversed lines.

    Examples
    --------
    >>> two = VoxelModel([[0, 0], [2, 0]], [[2, 3], [4, 3]], [1, 1], 0.5)
    >>> solid = solid_from_voxels(two)
    >>> len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes)
    (12, 20, 11, 2)

    One half thinner than the other:

    >>> stepped = solid_from_voxels(VoxelModel([[0, 0], [2, 0]], [[2, 3], [4, 3]], [1, 1], [0.5, 0.3]))
    >>> stepped.keypoints[:, 1].tolist().count(0.5), len(stepped.volumes)
    (4, 3)
    """
    return _drawn_out(divide_voxels(voxels))


def solid_from_cells(cells: WallCells) -> SolidModel:
    """Boundary representation with one volume for each quadrilateral cell, and for each slab of it.

    Parameters
    ----------
    cells : WallCells

    Returns
    -------
    solid : SolidModel
        Ordered like that of :func:`solid_from_voxels`.

    Raises
    ------
    InputError
        If there is no cell, one is not convex or not counter-clockwise, two overlap or meet along a part of
        an edge only, or the wall falls into pieces or hangs together by an edge.

    Examples
    --------
    >>> trapezoid = WallCells([[0, 0], [4, 0], [3, 2], [1, 2]], [[0, 1, 2, 3]], 0.5)
    >>> solid = solid_from_cells(trapezoid)
    >>> len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes)
    (8, 12, 6, 1)
    """
    solid = _drawn_out(divide_cells(cells))
    check_joined(solid)
    return solid


def _drawn_out(plan: Division) -> SolidModel:
    """The solid of a division, volume by volume."""
    layers = _layers(plan)
    levels = [_present(layers.keypoints[level]) for level in range(len(layers.y))]
    keypoints = [
        np.column_stack([plan.points[corner, 0], np.full(len(corner), y), plan.points[corner, 1]])
        for corner, y in zip(levels, layers.y, strict=True)
    ]
    areas, patches = _areas(plan, layers)
    return SolidModel(
        keypoints=np.concatenate(keypoints),
        lines=_lines(plan, layers),
        areas=areas,
        patches=patches,
        volumes=_volumes(plan, layers),
    )


def _layers(plan: Division) -> _Layers:
    """Number what there is, level by level and slab by slab."""
    depths, last = merged(plan.thickness)
    count, slabs = len(depths), last + 1
    side_slabs = np.zeros(len(plan.sides), dtype=np.intp)
    np.maximum.at(side_slabs, plan.rings, slabs[plan.cell_of])
    corner_slabs = np.zeros(len(plan.points), dtype=np.intp)
    np.maximum.at(corner_slabs, plan.sides.ravel(), np.repeat(side_slabs, 2))
    side_lines = _numbers(side_slabs + 1, count + 1)
    cell_areas = _numbers(slabs + 1, count + 1)
    return _Layers(
        y=np.concatenate([[0.0], depths]),
        slabs=slabs,
        keypoints=_numbers(corner_slabs + 1, count + 1),
        side_lines=side_lines,
        through_lines=_numbers(corner_slabs, count, after=side_lines),
        cell_areas=cell_areas,
        side_areas=_numbers(side_slabs, count, after=cell_areas),
        first=np.stack([_first_users(plan, slabs > slab) for slab in range(count)]),
    )


def _numbers(heights: IntArray, rows: int, *, after: IntArray | None = None) -> IntArray:
    """Number the first `heights[k]` entries of each column k of a table, row by row; -1 elsewhere."""
    present = np.arange(rows)[:, None] < heights
    begin = 0 if after is None else int(after.max()) + 1
    running = np.cumsum(present.ravel()).reshape(present.shape) - 1 + begin
    return np.where(present, running, -1)


def _present(row: IntArray) -> IntArray:
    """Columns that have a number in a row."""
    return np.flatnonzero(row >= 0)


def _first_users(plan: Division, reaches: NDArray[np.bool_]) -> IntArray:
    """Place in the rings where each side is used first by a cell that reaches a slab; -1 where none does."""
    places = np.flatnonzero(reaches[plan.cell_of])
    used, first = np.unique(plan.rings[places], return_index=True)
    found = np.full(len(plan.sides), -1, dtype=np.intp)
    found[used] = places[first]
    return found


def _lines(plan: Division, layers: _Layers) -> IntArray:
    """Ends of all lines: along the sides level by level, then through the slabs."""
    along = [
        keypoints[plan.sides[_present(row)]]
        for row, keypoints in zip(layers.side_lines, layers.keypoints, strict=True)
    ]
    through = [
        np.column_stack([layers.keypoints[slab], layers.keypoints[slab + 1]])[_present(row)]
        for slab, row in enumerate(layers.through_lines)
    ]
    return np.concatenate([*along, *through])


def _areas(plan: Division, layers: _Layers) -> tuple[tuple[Ids, ...], IntArray]:
    """Loops and patches of all areas: of the cells level by level, then of the sides slab by slab."""
    loops: list[Ids] = []
    patches: list[IntArray] = []
    for level, row in enumerate(layers.cell_areas):
        cells = _present(row)
        signed = plan.sense * (layers.side_lines[level][plan.rings] + 1)
        # The front looks towards -y; the other levels are backs of the slab before them.
        loops += _slices(signed, plan.start, cells) if level == 0 else _reversed(signed, plan.start, cells)
        corners = plan.corner_of[cells] if level == 0 else plan.corner_of[cells][:, [0, 3, 2, 1]]
        patches.append(layers.keypoints[level][corners])
    for slab in range(len(layers.side_areas)):
        side_loops, side_patches = _side_areas(plan, layers, slab)
        loops += map(tuple, side_loops.tolist())
        patches.append(side_patches)
    return tuple(loops), np.concatenate(patches)


def _side_areas(plan: Division, layers: _Layers, slab: int) -> tuple[IntArray, IntArray]:
    """Loops (n, 4) and patches (n, 4) of the sides' areas in a slab."""
    sides = _present(layers.side_areas[slab])
    sense = plan.sense[layers.first[slab][sides]]
    # The front area runs p -> q along the side, so the side's own area runs q -> p there.
    p = np.where(sense > 0, plan.sides[sides, 0], plan.sides[sides, 1])
    q = np.where(sense > 0, plan.sides[sides, 1], plan.sides[sides, 0])
    near, far = layers.side_lines[slab][sides] + 1, layers.side_lines[slab + 1][sides] + 1
    through = layers.through_lines[slab] + 1
    loops = np.column_stack([-sense * near, through[p], sense * far, -through[q]])
    front, back = layers.keypoints[slab], layers.keypoints[slab + 1]
    return loops, np.column_stack([front[q], front[p], back[p], back[q]])


def _volumes(plan: Division, layers: _Layers) -> tuple[Ids, ...]:
    """Signed areas of each volume: near, far, then the sides; negative where it is the second user."""
    volumes: list[Ids] = []
    for slab, first in enumerate(layers.first):
        cells = np.flatnonzero(layers.slabs > slab)
        owned = first[plan.rings] == np.arange(len(plan.rings))
        sides = np.where(owned, 1, -1) * (layers.side_areas[slab][plan.rings] + 1)
        near = (1 if slab == 0 else -1) * (layers.cell_areas[slab][cells] + 1)
        far = layers.cell_areas[slab + 1][cells] + 1
        shells = zip(near.tolist(), far.tolist(), _slices(sides, plan.start, cells), strict=True)
        volumes += [(a, b, *rest) for a, b, rest in shells]
    return tuple(volumes)


def _slices(values: IntArray, start: IntArray, cells: IntArray) -> list[Ids]:
    """The values that belong to each of some cells."""
    listed = values.tolist()
    bounds = zip(start[cells].tolist(), start[cells + 1].tolist(), strict=True)
    return [tuple(listed[a:b]) for a, b in bounds]


def _reversed(values: IntArray, start: IntArray, cells: IntArray) -> list[Ids]:
    """The values that belong to each of some cells, the other way round."""
    return [part[::-1] for part in _slices(-values, start, cells)]
