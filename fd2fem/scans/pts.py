"""PTS files (Leica Cyclone): blocks of a count and as many lines ``x y z [intensity] [r g b]``.

Without a count, the whole file is one block. All blocks are in one world frame; no position of a scanner
is kept. Layout: https://paulbourke.net/dataformats/pts/ (colours from 0 to 255; Leica's intensities from
-2048 to 2047, other programs' from 0 to 1 or 255).
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.scans.raw import UNKNOWN, RawScan, as_strength, float32_step, is_no_return
from fd2fem.scans.rows import Rows, line_of

__all__ = ["read_pts"]

WITH_INTENSITY = {4, 7, 10}
"""Numbers on a line that has an intensity after x, y, z; colours and normals take three each."""
EVERYTHING = 2**62


def read_pts(path: Path) -> RawScan:
    """Read a PTS file, in the file's units; a block counts as a scan, from where nobody knows.

    Raises
    ------
    InputError
        If it holds anything but numbers, a point lacks a coordinate, or a block does not have as many
        points as it says.
    """
    rows = Rows(path).take(EVERYTHING)
    alone = np.isnan(rows[:, 1])  # a single number on a line: the count of a block
    starts = np.flatnonzero(alone)
    _check_counts(path, rows, starts)
    points = rows[~alone, :3]
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        where = line_of(path, int(np.flatnonzero(~alone)[bad[0]]))
        msg = f"{path}: {len(bad)} lines lack a finite coordinate, the first is {where} export it anew."
        raise InputError(msg)
    block = (np.cumsum(alone) - min(len(starts), 1)).astype(np.int32)[~alone]
    strength = rows[~alone, 3] if _width(path) in WITH_INTENSITY else np.empty(0)
    del rows
    lost = is_no_return(points)
    if lost.any():
        points, block, strength = points[~lost], block[~lost], strength[~lost] if len(strength) else strength
    return RawScan(
        points,
        as_strength(path, strength),
        np.array([UNKNOWN] * max(len(starts), 1)),
        block,
        step=float32_step(points),
        no_returns=int(np.count_nonzero(lost)),
    )


def _check_counts(path: Path, rows: NDArray[np.float64], starts: NDArray[np.intp]) -> None:
    """Raise unless each count is followed by as many points."""
    if not len(rows):
        msg = f"{path} is not a point cloud: it holds no numbers."
        raise InputError(msg)
    if not len(starts):
        return
    held = np.diff([*starts, len(rows)]) - 1
    counts = rows[starts, 0]
    wrong = np.flatnonzero(counts != held)
    if starts[0] != 0:
        msg = f"{path}: {line_of(path, int(starts[0]))} does not hold three coordinates: export anew."
        raise InputError(msg)
    if len(wrong):
        where = line_of(path, int(starts[wrong[0]]))
        msg = f"{path} is damaged: {where} counts the points, but {held[wrong[0]]} follow: export it anew."
        raise InputError(msg)


def _width(path: Path) -> int:
    """Numbers on the line of the first point."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        widths = (len(line.split()) for line in file)
        return next((width for width in widths if width > 1), 0)
