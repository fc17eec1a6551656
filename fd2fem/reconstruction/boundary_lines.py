"""Step 2: boundary lines of the wall and its openings (figure 8 of the paper).

The partial voxels around a feature are clustered by flood fill. Those of one grid column hold a vertical
edge when their boundary points reach far enough and follow one another closely enough, those of one
grid row a horizontal edge. A least-squares line goes through the boundary points of each group, and the
position of the edge is then freed from the bias of the sampling.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.errors import ReconstructionError
from fd2fem.model import Boundary, BoundaryLine, CellState, FacadePoints, Hole, HoleKind, QuadTree, Side
from fd2fem.reconstruction.edges import edge_position
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.quadtree import leaf_of_points

__all__ = ["boundary_lines", "check_size", "flood_cluster", "voxel_group"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

REACH = 8.0
"""Depth of wall, in point spacings, that an edge's position is read from."""


@dataclass(frozen=True, eq=False)
class _Feature:
    """An opening or the wall, as the lines see it: boundary points, rough rectangle, which side is wall."""

    hole: int
    members: IntArray
    low: FloatArray
    high: FloatArray

    @property
    def centre(self) -> FloatArray:
        return (self.low + self.high) / 2.0

    def edge(self, side: Side) -> float:
        """Rough position of an edge, m."""
        corner = self.low if side in {Side.LEFT, Side.BOTTOM} else self.high
        return float(corner[0 if side.vertical else 1])

    def wall_sign(self, side: Side) -> float:
        """+1 where the wall lies at larger coordinates than the edge."""
        beyond = 1.0 if side in {Side.RIGHT, Side.TOP} else -1.0
        return beyond if self.hole >= 0 else -beyond


def boundary_lines(
    points: FacadePoints,
    boundary: Boundary,
    tree: QuadTree,
    holes: tuple[Hole, ...],
    options: ReconstructionOptions,
) -> tuple[BoundaryLine, ...]:
    """Fit the edges of the wall and of every opening.

    Doors, whose bottom is the ground, have three lines; the ground closes the ring.

    Returns
    -------
    tuple of BoundaryLine
        First those of the wall (`hole` -1), then those of the openings by their index in `holes`.
    """
    leaf = leaf_of_points(points.xz, tree.lower[0], tree.upper[-1], tree.depth)
    xz = points.xz
    wall = _Feature(-1, boundary.outer, xz.min(axis=0), xz.max(axis=0))
    lines = [_line(points, tree, leaf, wall, side, holes, options) for side in Side]
    ground = next(line.position for line in lines if line.side is Side.BOTTOM)
    for number, hole in enumerate(holes):
        if hole.kind is not HoleKind.OPENING:
            continue
        cluster = flood_cluster(tree, leaf, hole.points, bridge=_bridge(points, options))
        feature = _Feature(number, cluster, hole.low, hole.high)
        for side in Side:
            if side is Side.BOTTOM and hole.z - ground < boundary.threshold / 2.0:
                continue
            lines.append(_line(points, tree, leaf, feature, side, holes, options))
    return tuple(lines)


def _bridge(points: FacadePoints, options: ReconstructionOptions) -> float:
    """Largest distance between neighbours along one edge, m: condition 2, or what sparse points need."""
    return max(options.min_opening / 2.0, 4.0 * points.spacing)


def flood_cluster(tree: QuadTree, leaf: IntArray, members: IntArray, *, bridge: float) -> IntArray:
    """The boundary points of a hole whose partial voxels are connected, by flood fill.

    Parameters
    ----------
    tree : QuadTree
    leaf : (n,) int array
        Leaf of each of the wall's points.
    members : (b,) int array
        The hole's boundary points.
    bridge : float, m
        Partial voxels so far apart still belong together.

    Returns
    -------
    (k,) int array
        Those in the largest connected cluster of partial voxels.
    """
    count = 2**tree.depth
    image = np.zeros(count * count, dtype=bool)
    image[leaf[members]] = tree.state[leaf[members]] == CellState.PARTIAL
    size = tree.upper[0] - tree.lower[0]
    grown = ndimage.maximum_filter(
        image.reshape(count, count),
        size=tuple((2 * np.ceil(bridge / size / 2.0) + 1).astype(int)),
        mode="constant",
    )
    label, _ = ndimage.label(grown, structure=np.ones((3, 3)))
    of_member = label.ravel()[leaf[members]]
    sizes = np.bincount(of_member)
    sizes[0] = 0
    largest: IntArray = members[of_member == np.argmax(sizes)]
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
    groups = {}
    for column in np.unique(across).tolist():
        member = np.flatnonzero(across == column)
        member = member[np.argsort(along[member], kind="stable")]
        runs = np.split(member, np.flatnonzero(np.diff(along[member]) > bridge) + 1)
        longest = max(runs, key=lambda run: float(np.ptp(along[run])))
        if np.ptp(along[longest]) >= min_opening:
            groups[column] = longest
    return groups


def _line(
    points: FacadePoints,
    tree: QuadTree,
    leaf: IntArray,
    feature: _Feature,
    side: Side,
    holes: tuple[Hole, ...],
    options: ReconstructionOptions,
) -> BoundaryLine:
    """One edge: voxel group, least-squares line, position without bias."""
    axis = 0 if side.vertical else 1
    members = feature.members
    across, along = points.xz[members, axis], points.xz[members, 1 - axis]
    groups = voxel_group(
        tree.index[leaf[members], axis],
        along,
        min_opening=options.min_opening,
        bridge=_bridge(points, options),
    )
    low_side = side in {Side.LEFT, Side.BOTTOM}
    size = (tree.upper[0] - tree.lower[0])[axis]
    guess = feature.edge(side)
    chosen = [
        group
        for group in groups.values()
        if (np.mean(across[group]) < feature.centre[axis]) == low_side
        and abs(np.median(across[group]) - guess) < max(1.5 * size, options.min_opening / 4)
    ]
    if chosen:
        picked = np.concatenate(chosen)
    else:
        # No column qualifies, as where much of an edge is hidden: the histogram's peak stands in.
        picked = np.flatnonzero(np.abs(across - guess) < options.min_opening / 4)
        if len(picked) < 2:
            picked = np.argsort(np.abs(across - guess), kind="stable")[:2]
    picked, slope, level = _robust_line(across, along, picked)
    ends = np.array([along[picked].min(), along[picked].max()])
    fitted = level + slope * (ends - along[picked].mean())
    corners = np.column_stack([fitted, ends] if axis == 0 else [ends, fitted])
    position, sigma = _position(points, feature, side, level, holes)
    return BoundaryLine(corners[0], corners[1], members[picked], side, feature.hole, position, sigma)


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


def _position(
    points: FacadePoints, feature: _Feature, side: Side, level: float, holes: tuple[Hole, ...]
) -> tuple[float, float]:
    """Edge position from all wall points beside the line, and its standard error."""
    if feature.hole < 0 and side is Side.BOTTOM and points.ground is not None:
        return points.ground, points.spacing / 2.0
    axis = 0 if side.vertical else 1
    sign = feature.wall_sign(side)
    reach = min(max(REACH * points.spacing, 0.1), _free_depth(feature, side, level, holes))
    margin = 3.0 * points.spacing
    low, high = feature.low - margin, feature.high + margin
    low[axis], high[axis] = sorted((level - sign * margin, level + sign * reach))
    # Away from the corners, where the other edges' bias and cut-off points are.
    low[1 - axis] += 2.0 * margin
    high[1 - axis] -= 2.0 * margin
    near = np.flatnonzero(((points.xz > low) & (points.xz < high)).all(axis=1))
    # On the reveal, points lie deeper than on the wall's face; they would crowd the edge.
    near = near[np.abs(points.depth[near]) < max(2.0 * points.rms, 1e-4)]
    xz = points.xz[near]
    if feature.hole < 0:
        clear = np.ones(len(near), dtype=bool)
        for hole in holes:
            clear &= ~((xz > hole.low - margin) & (xz < hole.high + margin)).all(axis=1)
        xz = xz[clear]
    inward, along = sign * (xz[:, axis] - level), xz[:, 1 - axis]
    offset, sigma = edge_position(inward, along, spacing=points.spacing, reach=reach)
    return level + sign * offset, sigma


def _free_depth(feature: _Feature, side: Side, level: float, holes: tuple[Hole, ...]) -> float:
    """Distance from an edge into the wall up to the next hole beside it, m."""
    axis = 0 if side.vertical else 1
    sign = feature.wall_sign(side)
    depth = np.inf
    for number, hole in enumerate(holes):
        if number == feature.hole:
            continue
        low, high = hole.low, hole.high
        overlap = min(high[1 - axis], feature.high[1 - axis]) - max(low[1 - axis], feature.low[1 - axis])
        gap = (low[axis] - level) if sign > 0 else (level - high[axis])
        if feature.hole >= 0 and overlap > 0.0 and gap > 0.0:
            depth = min(depth, gap)
    return float(depth)


def check_size(lines: tuple[BoundaryLine, ...], options: ReconstructionOptions) -> None:
    """Raise unless the wall's lines enclose more than an opening."""
    edge = {line.side: line.position for line in lines if line.hole < 0}
    length, height = edge[Side.RIGHT] - edge[Side.LEFT], edge[Side.TOP] - edge[Side.BOTTOM]
    if min(length, height) <= options.min_opening:
        msg = f"The wall is {length:.2f} x {height:.2f} m, no larger than the smallest opening."
        raise ReconstructionError(msg)
