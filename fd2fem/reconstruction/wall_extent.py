"""Where the wall ends: at joints to its neighbours, and at the pavement."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.errors import ReconstructionError
from fd2fem.reconstruction.face import Box, Face
from fd2fem.reconstruction.relief import depth_behind
from fd2fem.reconstruction.thinning import pick
from fd2fem.reconstruction.walls import MIN_POINTS, MIN_WALL, NEAR_PLANE, largest_part

__all__ = ["Joint", "WallCut", "cut_wall", "find_joints", "part_between"]

FloatArray = NDArray[np.float64]

LAYERS = 6
"""Layers beside the wall that it is compared with, as thick as it."""
DENSER = 1.3
"""A wall holds so many times the points of the usual layer beside it."""
JOINT = 0.1
"""A joint between two walls is at least so wide, m."""
SPACINGS = 4.0
"""And so many point spacings, or it might be chance."""
BINS = 5
"""Columns of the wall that the narrowest joint holds."""
BARE = 0.02
"""A column with less than this share of the usual points is empty; stray points do not fill it."""
ROW = 0.25
"""Height of the rows in which a shadow is looked for, m."""
SHADED = 0.5
"""A gap that things before the wall hide over more of its height is no joint."""


@dataclass(frozen=True)
class Joint:
    """A strip without points over the full height of the wall, from `low` to `high` along x, m."""

    low: float
    high: float


@dataclass(frozen=True, eq=False)
class WallCut:
    """The points of the wall, cut out of what lies in its plane.

    Attributes
    ----------
    local : (n, 3) float array, m
        In the frame of the face.
    depth : (n,) float array, m
        Behind the face.
    joints : tuple of Joint
        At which neighbours were cut off.
    """

    local: FloatArray
    depth: FloatArray
    joints: tuple[Joint, ...]

    @property
    def box(self) -> Box:
        """Lower and upper corner of the wall, m."""
        if len(self.depth) == 0:
            return np.zeros(2), np.zeros(2)
        x, _, z = self.local.T
        return np.array([x.min(), z.min()]), np.array([x.max(), z.max()])


def cut_wall(near: FloatArray, face: Face, *, spacing: float, scanners: FloatArray) -> WallCut:
    """Take the wall's points out of those beside its face: without pavement and neighbours.

    Parameters
    ----------
    near : (m, 3) float array, m
        In the frame of the face.
    face : Face
    spacing : float, m
        Typical distance between neighbours on the wall.
    scanners : (s, 3) float array, m
        In the frame of the face.

    Raises
    ------
    ReconstructionError
        If what is left is too small, or no denser than the space beside it.
    """
    depth = depth_behind(face.relief, near)
    on_wall = np.abs(depth) < face.band
    if face.pavement is not None:
        on_wall &= face.pavement.clear_of(near, face.scatter)
    local, depth = _kept(near, depth, on_wall)
    joints: tuple[Joint, ...] = ()
    if len(local):
        local, depth = _part(local, depth, face.xz)
        joints = find_joints(local[:, ::2], spacing, face.local[face.depth < -face.band], scanners)
    if joints:
        start, end = part_between(local[:, ::2], joints, scanners)
        kept = (local[:, 0] > start) & (local[:, 0] < end)
        local, depth = _part(*_kept(local, depth, kept), face.xz)
    cut = WallCut(local, depth, joints)
    _check_wall(cut, face)
    (left, _), (right, _) = cut.box
    return replace(cut, joints=tuple(joint for joint in joints if _bounds(joint, left, right)))


def _kept(local: FloatArray, depth: FloatArray, kept: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Some of the points and their depths."""
    return (local, depth) if kept.all() else (pick(local, kept), depth[kept])


def _part(local: FloatArray, depth: FloatArray, around: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Of some points and their depths, the connected part that holds most of some places."""
    part = largest_part(local[:, ::2], around=around)
    return (local, depth) if len(part) == len(local) else (pick(local, part), depth[part])


def _bounds(joint: Joint, left: float, right: float) -> bool:
    """Whether a wall from `left` to `right` ends at a joint."""
    return abs(joint.high - left) < 2.0 * JOINT or abs(joint.low - right) < 2.0 * JOINT


def _check_wall(cut: WallCut, face: Face) -> None:
    """Raise unless the chosen points make a wall: large enough, and denser than the space beside it."""
    low, high = cut.box
    if len(cut.depth) < MIN_POINTS or (high - low).min() < MIN_WALL:
        msg = (
            f"No wall found: the largest vertical plane holds {len(cut.depth)} points on "
            f"{high[0] - low[0]:.2f} x {high[1] - low[1]:.2f} m, expected at least {MIN_POINTS} points "
            f"on {MIN_WALL} x {MIN_WALL} m; check the units and that z points up."
        )
        raise ReconstructionError(msg)
    x, _, z = face.local.T
    within = (x >= low[0]) & (x <= high[0]) & (z >= low[1]) & (z <= high[1])
    layers, _ = np.histogram(np.abs(face.depth[within]), NEAR_PLANE * np.arange(LAYERS + 2))
    # Frames and courses make one or the other of the layers beside a wall dense, but not most of them.
    if layers[0] < DENSER * np.median(layers[1:]):
        msg = "No wall found: no vertical plane is denser than the space beside it."
        raise ReconstructionError(msg)


def find_joints(
    wall_xz: FloatArray, spacing: float, front: FloatArray, scanners: FloatArray
) -> tuple[Joint, ...]:
    """Find the strips without points that part a wall from its flush neighbours.

    A strip that something before the wall hides (a lamp post, a downpipe) is no joint.

    Parameters
    ----------
    wall_xz : (n, 2) float array, m
        Points on the wall and its neighbours, above the pavement.
    spacing : float, m
    front : (k, 3) float array, m
        Points before the wall.
    scanners : (s, 3) float array, m
    """
    joint = max(JOINT, SPACINGS * spacing)
    width = joint / BINS
    x = wall_xz[:, 0]
    low, high = x.min(), x.max()
    start = np.floor(low / width) * width
    count = np.bincount(((x - start) / width).astype(np.intp))
    empty = count <= BARE * np.median(count[count > 0])
    label, runs = ndimage.label(empty)
    found = []
    for run in range(1, runs + 1):
        columns = np.flatnonzero(label == run)
        gap = Joint(float(start + columns[0] * width), float(start + (columns[-1] + 1) * width))
        inside = gap.low > low and gap.high < high
        if inside and len(columns) >= BINS - 1 and not _is_shaded(gap, wall_xz, front, scanners):
            found.append(gap)
    return tuple(found)


def _is_shaded(gap: Joint, wall_xz: FloatArray, front: FloatArray, scanners: FloatArray) -> bool:
    """Whether things before the wall hide most of a gap's height from every scanner."""
    beside = wall_xz[(wall_xz[:, 0] > gap.low - 1.0) & (wall_xz[:, 0] < gap.high + 1.0), 1]
    foot, top = np.percentile(beside, [2, 98]) if len(beside) else (0.0, 0.0)
    rows = max(int((top - foot) / ROW), 1)
    edges = np.linspace(foot, top, rows + 1)
    if not len(scanners):
        return _has_upright(gap, front, edges)
    for scanner in scanners:
        between = front[(front[:, 1] > scanner[1] + 0.5)]
        share = scanner[1] / (scanner[1] - between[:, 1])
        x = scanner[0] + (between[:, 0] - scanner[0]) * share
        z = scanner[2] + (between[:, 2] - scanner[2]) * share
        shadow = z[(x > gap.low) & (x < gap.high)]
        if (np.histogram(shadow, edges)[0] > 0).mean() < SHADED:
            return False
    return True


def _has_upright(gap: Joint, front: FloatArray, edges: FloatArray) -> bool:
    """Whether something slim stands before the wall near a gap, that may hide it from an unknown place."""
    aside = np.abs(front[:, 0] - 0.5 * (gap.low + gap.high))
    near = front[(front[:, 1] > -4.0) & (aside < 2.0)]
    columns = np.floor(near[:, 0] / 0.3).astype(np.intp)
    for column in np.unique(columns):
        if (np.histogram(near[columns == column, 2], edges)[0] > 0).mean() > SHADED:
            return True
    return False


def part_between(wall_xz: FloatArray, joints: tuple[Joint, ...], scanners: FloatArray) -> tuple[float, float]:
    """Where the part of the wall to keep starts and ends along x, m: what a scanner faces, else the largest.

    Parameters
    ----------
    wall_xz : (n, 2) float array, m
    joints : tuple of Joint
        In ascending order.
    scanners : (s, 3) float array, m
    """
    starts = [-np.inf, *(0.5 * (joint.low + joint.high) for joint in joints)]
    ends = [*starts[1:], np.inf]
    best, most = (starts[0], ends[0]), (False, -1.0)
    for start, end in zip(starts, ends, strict=True):
        part = wall_xz[(wall_xz[:, 0] > start) & (wall_xz[:, 0] < end)]
        if len(part) == 0:
            continue
        (left, bottom), (right, top) = part.min(axis=0), np.percentile(part, 99, axis=0)
        faced = bool(((scanners[:, 0] > left) & (scanners[:, 0] < right)).any())
        rank = (faced, float((right - left) * (top - bottom)))
        if rank > most:
            best, most = (start, end), rank
    return best
