"""Whether the surface that was found is the flat front of a wall, or a strip of a round one."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.reconstruction.face import Face

__all__ = ["check_not_round"]

FloatArray = NDArray[np.float64]

ENOUGH = 100_000
"""So many points of the sample show the surface."""
COLUMN = 0.1
"""Width of the columns in which the surface is followed, m; more where points are few."""
REACH = 0.03
"""The next column lies so near to where the last ones point, m."""
HELD = 0.25
"""A column of the surface holds at least this share of the usual points."""
LARGEST_BOW = 0.12
"""A surface that leaves its plane farther than this on both sides is round, m."""
LARGE_BOW = 0.05
"""So is one that does on one side, if it bulges more than this before, m."""


def check_not_round(face: Face) -> None:
    """Raise if the surface goes on smoothly out of its plane on both sides, as that of a tower does.

    Parameters
    ----------
    face : Face

    Raises
    ------
    ReconstructionError
    """
    local = face.local[:ENOUGH]
    width = max(COLUMN, 3.0 * face.spacing * float(np.sqrt(len(face.local) / len(local))))
    (_, low), (_, high) = face.box
    x, y, z = local.T
    near = np.flatnonzero((np.abs(y) < 3.0 * LARGEST_BOW) & (z > low) & (z < high))
    column = ((x[near] - x[near].min()) / width).astype(np.uint16)
    order = np.argsort(column, kind="stable")
    column, depth = column[order].astype(np.intp), y[near[order]]
    # A band that was given holds the wall's layers, of which none need lie on its plane.
    on_plane = np.bincount(column[np.abs(depth) < max(REACH, face.band)] - column[0])
    # Openings leave a column fewer points, but hardly none.
    usual = float(np.median(on_plane[on_plane > 0]))
    rows = face.relief.values[len(face.relief.values) // 2]
    middle = face.relief.low[0] + face.relief.cell * (len(face.relief.values) // 2)
    start = int((middle - x[near].min()) / width)
    level = 0.0 if np.isnan(rows).all() else float(np.nanmedian(rows))
    ends = [_follow(column, depth, (start, level), step, HELD * usual) - level for step in (-1, 1)]
    bow = float(np.nanmax(face.relief.values) - np.nanmin(face.relief.values))
    far = [abs(end) > LARGEST_BOW for end in ends]
    # The scan may end before the surface has come as far on one side.
    if (all(far) and ends[0] * ends[1] > 0.0) or (any(far) and bow > LARGE_BOW):
        msg = (
            "No wall found: the best upright surface is round, it curves out of its plane by more than "
            f"{1000 * LARGEST_BOW:.0f} mm; cut the scan to a flat wall."
        )
        raise ReconstructionError(msg)


def _follow(
    column: NDArray[np.intp], depth: FloatArray, start: tuple[int, float], step: int, least: float
) -> float:
    """Depth, m, to which the surface goes on from a column and depth in steps of +1 or -1."""
    (number, level), slope = start, 0.0
    while abs(level - start[1]) < 2.0 * LARGEST_BOW:
        first, end = np.searchsorted(column, [number, number + 1])
        held = depth[first:end]
        held = held[np.abs(held - (level + slope)) < REACH]
        if len(held) < max(least, 3.0):
            break
        last, level = level, float(np.median(held))
        slope = 0.5 * (slope + level - last)
        number += step
    return level
