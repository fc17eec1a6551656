"""What a file of points holds, in its own units, and the checks that every format shares."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError

__all__ = ["RawScan", "as_strength", "check_file", "check_finite", "check_spread"]

FloatArray = NDArray[np.float64]

THINNEST = 1e-3
"""A cloud narrower than this fraction of its length is a line: rounding to 1 mm alone makes 1e-4."""
FARTHEST = 10.0
"""Points farther from the middle than this many times the median distance are stray returns."""


@dataclass(frozen=True, eq=False)
class RawScan:
    """The content of one file, in the units of the file.

    Attributes
    ----------
    points : (n, 3) float array
    intensity : (n,) float array, or (0,)
        Between 0 and 1; empty where the file has none.
    scanners : (s, 3) float array
        Positions of the scanner; empty where the file has none.
    step : float
        Distance between two neighbouring coordinates that the file's number type can tell apart,
        where that type is float32; 0 otherwise.
    """

    points: FloatArray
    intensity: FloatArray = field(default_factory=lambda: np.empty(0))
    scanners: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    step: float = 0.0


def check_file(path: Path) -> None:
    """Raise `InputError` unless `path` is a file with something in it."""
    if path.is_dir():
        msg = f"{path} is a folder: name a point cloud file."
        raise InputError(msg)
    if not path.exists():
        msg = f"{path}: no such file."
        raise InputError(msg)
    if path.stat().st_size == 0:
        msg = f"{path} is empty: expected a point cloud."
        raise InputError(msg)


def check_finite(path: Path, points: FloatArray) -> None:
    """Raise `InputError`, naming how many and the first, if a point has a coordinate that is no number."""
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        msg = (
            f"{path}: {len(bad)} of {len(points)} points have a coordinate that is NaN or infinite, "
            f"the first is point {bad[0] + 1}: export without them."
        )
        raise InputError(msg)


def check_spread(path: Path, points: FloatArray) -> None:
    """Raise `InputError` if there are fewer than four points, or all lie on one line or in one place."""
    if len(points) < 4:
        msg = f"{path} has {len(points)} point{'s' * (len(points) != 1)}: a facade needs at least 4."
        raise InputError(msg)
    middle = np.median(points, axis=0)
    offset = points - middle
    distance = np.abs(offset).max(axis=1)
    near = offset[distance <= FARTHEST * np.median(distance)]  # stray returns must not stretch the cloud
    near = near if near.any() else offset
    size = np.abs(near).max()
    if size <= 1e-9 * np.abs(middle).max():
        msg = f"{path}: all {len(points)} points are in one place: a facade needs points all over the wall."
        raise InputError(msg)
    near = (near - near.mean(axis=0)) / size
    # The singular values of `near`, from its 3 x 3 product: the points are millions.
    spread = np.sqrt(np.linalg.svd(near.T @ near, compute_uv=False))
    if spread[1] < THINNEST * spread[0]:
        msg = f"{path}: all {len(points)} points lie on one line: a facade needs points all over the wall."
        raise InputError(msg)


def as_strength(path: Path, values: NDArray[np.generic]) -> FloatArray:
    """Return strengths as numbers between 0 and 1; empty if all are the same, which says nothing.

    Values up to 1 stay, values up to 255 or 65535 are divided by these; others (Leica counts from
    -2048 to 2047) are stretched from their smallest and largest.

    Examples
    --------
    >>> as_strength(Path("scan.ply"), np.array([0, 51, 255], dtype=np.uint8)).tolist()
    [0.0, 0.2, 1.0]
    """
    strength = values.astype(np.float64)
    bad = int((~np.isfinite(strength)).sum())
    if bad:
        msg = f"{path}: {bad} of {len(strength)} intensities are NaN or infinite: export without that column."
        raise InputError(msg)
    low, high = (strength.min(), strength.max()) if len(strength) else (0.0, 0.0)
    if low == high:
        return np.empty(0)
    for scale in (1.0, 255.0, 65535.0):
        if low >= 0.0 and high <= scale:
            return strength / scale
    return (strength - low) / (high - low)
