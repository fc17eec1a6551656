"""Step 2: boundary lines of the openings (figure 8 of the paper).

The partial voxels around an opening are clustered by flood fill. Those of one grid column hold a vertical
edge when their boundary points reach far enough and follow one another closely enough, those of one
grid row a horizontal edge. A least-squares line goes through the boundary points of each group, and the
position of the edge is then freed from the bias of the sampling.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.model import BoundaryLine, CellState, HoleKind, QuadTree, Side
from fd2fem.reconstruction.quadtree import leaf_of_points
from fd2fem.reconstruction.strips import Place, View, edge_beside, seen_place

__all__ = ["boundary_lines", "flood_cluster", "voxel_group"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Feature:
    """An opening as the lines see it: boundary points, their leaves, rough rectangle."""

    number: int
    members: IntArray
    leaf: IntArray
    low: FloatArray
    high: FloatArray

    @property
    def centre(self) -> FloatArray:
        return (self.low + self.high) / 2.0

    def edge(self, side: Side) -> float:
        """Rough position of an edge, m."""
        corner = self.low if side in {Side.LEFT, Side.BOTTOM} else self.high
        return float(corner[0 if side.vertical else 1])


def boundary_lines(view: View, tree: QuadTree) -> tuple[BoundaryLine, ...]:
    """Fit the edges of every opening that were seen.

    Doors, whose bottom is the ground, have three lines at the most; the ground closes the ring.

    Returns
    -------
    tuple of BoundaryLine
        Those of the openings by their index in `view.holes`.
    """
    lines = []
    for number, hole in enumerate(view.holes):
        if hole.kind is not HoleKind.OPENING:
            continue
        leaf = leaf_of_points(view.points.xz[hole.points], tree.lower[0], tree.upper[-1], tree.depth)
        kept = flood_cluster(tree, leaf, bridge=_bridge(view))
        place = seen_place(number, hole)
        feature = _Feature(number, hole.points[kept], leaf[kept], place.low, place.high)
        for side in Side:
            ground = side is Side.BOTTOM and hole.z < view.boundary.threshold / 2.0
            if not ground and side not in hole.unseen:
                lines.append(_line(view, tree, feature, side))
    return tuple(lines)


def _bridge(view: View) -> float:
    """Largest distance between neighbours along one edge, m: condition 2, or what sparse points need."""
    return max(view.boundary.min_opening / 2.0, 4.0 * view.sampling.spacing)


def flood_cluster(tree: QuadTree, leaf: IntArray, *, bridge: float) -> IntArray:
    """The boundary points of a hole whose partial voxels are connected, by flood fill.

    Parameters
    ----------
    tree : QuadTree
    leaf : (b,) int array
        Leaf of each of the hole's boundary points.
    bridge : float, m
        Partial voxels so far apart still belong together.

    Returns
    -------
    (k,) int array
        Indices into `leaf` of those in the largest connected cluster of partial voxels.
    """
    count = 2**tree.depth
    index = tree.index[leaf]
    low, high = index.min(axis=0), index.max(axis=0)
    size = tree.upper[0] - tree.lower[0]
    reach = np.ceil(bridge / size / 2.0).astype(int)
    image = np.zeros(high - low + 1 + 2 * reach, dtype=bool)
    place = index - low + reach
    image[place[:, 0], place[:, 1]] = tree.state[index[:, 0] * count + index[:, 1]] == CellState.PARTIAL
    grown = ndimage.maximum_filter(image, size=tuple((2 * reach + 1).tolist()), mode="constant")
    label, _ = ndimage.label(grown, structure=np.ones((3, 3)))
    of_member = label[place[:, 0], place[:, 1]]
    sizes = np.bincount(of_member)
    sizes[0] = 0
    largest: IntArray = np.flatnonzero(of_member == np.argmax(sizes))
    return largest


def voxel_group(
    across: IntArray, along: FloatArray, *, min_opening: float, bridge: float
) -> dict[int, IntArray]:
    """Grid columns (or rows) whose boundary points make an edge: the paper's two conditions.

    Parameters
    ----------
    across : (b,) int array
        Grid column (row) of each boundary point.
    along : (b,) float array, m
        Its coordinate along the column (row).
    min_opening : float, m
        Condition 1: the points reach at least so far.
    bridge : float, m
        Condition 2: neighbours lie at most so far apart; the paper takes half of the smallest opening.

    Returns
    -------
    dict of int to int array
        Column number to the indices of its points, only columns that qualify.

    Examples
    --------
    >>> z = np.array([0.0, 0.15, 0.3, 0.45, 0.0, 0.1])
    >>> groups = voxel_group(np.array([3, 3, 3, 3, 5, 5]), z, min_opening=0.4, bridge=0.2)
    >>> {column: group.tolist() for column, group in groups.items()}
    {3: [0, 1, 2, 3]}
    """
    order = np.lexsort((along, across))
    column, place = across[order], along[order]
    # A run ends where the column does, or where the next point lies too far away.
    ends = (np.diff(column) != 0) | (np.diff(place) > bridge)
    first = np.concatenate([[0], np.flatnonzero(ends) + 1])
    last = np.concatenate([first[1:], [len(order)]]) - 1
    reach = place[last] - place[first]
    groups: dict[int, IntArray] = {}
    # Of the runs of a column, the longest comes first.
    for run in np.flatnonzero(reach >= min_opening)[np.argsort(-reach[reach >= min_opening], kind="stable")]:
        groups.setdefault(int(column[first[run]]), order[first[run] : last[run] + 1])
    return groups


def _line(view: View, tree: QuadTree, feature: _Feature, side: Side) -> BoundaryLine:
    """One edge: voxel group, least-squares line, position without bias."""
    axis = 0 if side.vertical else 1
    xz = view.points.xz[feature.members]
    across, along = xz[:, axis], xz[:, 1 - axis]
    picked, slope, level = _robust_line(across, along, _pick(view, tree, feature, side))
    ends = np.array([along[picked].min(), along[picked].max()])
    fitted = level + slope * (ends - along[picked].mean())
    corners = np.column_stack([fitted, ends] if axis == 0 else [ends, fitted])
    if abs(level - feature.edge(side)) > _tolerance(view, tree, axis):
        # No boundary points are left near the edge; its strip of wall may tell it still.
        level = feature.edge(side)
    position, sigma = edge_beside(view, Place(feature.number, feature.low, feature.high), side, level)
    return BoundaryLine(
        corners[0], corners[1], feature.members[picked], side, feature.number, position, sigma
    )


def _tolerance(view: View, tree: QuadTree, axis: int) -> float:
    """How far an edge may lie from the histogram's peak, m."""
    size = float((tree.upper[0] - tree.lower[0])[axis])
    return max(1.5 * size, view.boundary.min_opening / 4.0)


def _pick(view: View, tree: QuadTree, feature: _Feature, side: Side) -> IntArray:
    """The members of the voxel groups that make up one side, or those near the histogram's peak."""
    axis = 0 if side.vertical else 1
    xz = view.points.xz[feature.members]
    across, along = xz[:, axis], xz[:, 1 - axis]
    smallest = view.boundary.min_opening
    columns = tree.index[feature.leaf, axis]
    groups = voxel_group(columns, along, min_opening=smallest, bridge=_bridge(view))
    low_side = side in {Side.LEFT, Side.BOTTOM}
    guess = feature.edge(side)
    chosen = [
        group
        for group in groups.values()
        if (np.mean(across[group]) < feature.centre[axis]) == low_side
        and abs(np.median(across[group]) - guess) < _tolerance(view, tree, axis)
    ]
    if chosen:
        return np.concatenate(chosen)
    # No column qualifies, as where much of an edge is hidden: the histogram's peak stands in.
    picked = np.flatnonzero(np.abs(across - guess) < smallest / 4)
    return picked if len(picked) >= 2 else np.argsort(np.abs(across - guess), kind="stable")[:2]


def _robust_line(across: FloatArray, along: FloatArray, picked: IntArray) -> tuple[IntArray, float, float]:
    """Least-squares line through the picked points, outliers left out: points, slope, value at their mean."""
    slope, level = 0.0, float(np.median(across[picked]))
    for _ in range(4):
        run = along[picked] - along[picked].mean()
        spread = float(run @ run)
        level = float(across[picked].mean())
        slope = float(run @ across[picked]) / spread if spread > 0.0 else 0.0
        off = np.abs(across[picked] - level - slope * run)
        keep = off <= max(2.5 * 1.4826 * float(np.median(off)), 1e-4)
        if keep.all() or keep.sum() < 3:
            break
        picked = picked[keep]
    return picked, slope, level
