"""What a file of points holds, in its own units, and the checks that every format shares."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.scans.units import Units

__all__ = [
    "UNKNOWN",
    "RawScan",
    "as_strength",
    "check_file",
    "check_finite",
    "check_spread",
    "cut_short",
    "float32_step",
    "is_no_return",
    "joined",
]

FloatArray = NDArray[np.float64]
ScalarT = TypeVar("ScalarT", bound=np.generic)

THINNEST = 1e-3
"""A cloud narrower than this fraction of its length is a line: rounding to 1 mm alone makes 1e-4."""
FARTHEST = 10.0
"""Points farther from the middle than this many times the median distance are stray returns."""
ENOUGH = 100_000
"""So many points, drawn from a cloud, show how it is spread."""
UNKNOWN = (np.nan, np.nan, np.nan)
"""A position that is not known."""
LARGEST_FLOAT32 = float(np.finfo(np.float32).max)
FEWEST = 100
"""From so many points on it is no accident if all coordinates are float32 numbers."""


@dataclass(frozen=True, eq=False)
class RawScan:
    """The content of one file, which may hold several scans, in the units of the file.

    Attributes
    ----------
    points : (n, 3) float array
    intensity : (n,) float array, or (0,)
        Between 0 and 1; empty where the file has none.
    scanners : (s, 3) float array
        Position of the scanner in each scan of the file, NaN where it is not known; empty where the
        file knows of no scans.
    station : (n,) int array, or (0,)
        Index into `scanners` of the scan that each point belongs to, -1 where that is not known; empty
        where it is known of no point.
    step : float
        Distance between two neighbouring coordinates that the file's number type can tell apart,
        where that type is float32; 0 otherwise.
    units : Units
        What the format or the header says; `Units.AUTO` where they say nothing.
    doubt : str
        Why the unit must be asked for, where the file contradicts itself.
    no_returns : int
        Rays of which the file says that nothing came back.
    """

    points: FloatArray
    intensity: FloatArray = field(default_factory=lambda: np.empty(0))
    scanners: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    station: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, dtype=np.int32))
    step: float = 0.0
    units: Units = Units.AUTO
    doubt: str = ""
    no_returns: int = 0


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
    # Drawn at random: every hundredth point may be one row of the scanner's grid, and so a line.
    if len(points) > ENOUGH and not _flaw(points[np.random.default_rng(0).integers(0, len(points), ENOUGH)]):
        return
    flaw = _flaw(points)
    if flaw:
        msg = f"{path}: all {len(points)} points {flaw}: a facade needs points all over the wall."
        raise InputError(msg)


def _flaw(points: FloatArray) -> str:
    """What is wrong with points that lie in one place or on one line; empty for others."""
    middle = np.median(points, axis=0)
    offset = points - middle
    distance = np.abs(offset).max(axis=1)
    near = offset[distance <= FARTHEST * np.median(distance)]  # stray returns must not stretch the cloud
    near = near if near.any() else offset
    size = np.abs(near).max()
    if size <= 1e-9 * np.abs(middle).max():
        return "are in one place"
    near = (near - near.mean(axis=0)) / size
    # The singular values of `near`, from its 3 x 3 product: the points are millions.
    spread = np.sqrt(np.linalg.svd(near.T @ near, compute_uv=False))
    return "lie on one line" if spread[1] < THINNEST * spread[0] else ""


def as_strength(path: Path, values: NDArray[np.generic]) -> FloatArray:
    """Return strengths as numbers between 0 and 1; empty if all are the same, which says nothing.

    Values up to 1 stay, values up to 255 or 65535 are divided by these, values from -2048 to 2047
    (Leica's counts) run from 0 to 1; others are stretched from their smallest and largest.

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
    if low >= -2048.0 and high <= 2047.0:
        return (strength + 2048.0) / 4095.0
    return (strength - low) / (high - low)


def is_no_return(points: FloatArray) -> NDArray[np.bool_]:
    """Which of the points of one scan, in the frame of the scanner, are rays that did not come back.

    Scanners write these as 0, 0, 0. One point alone may just be there.

    Examples
    --------
    >>> is_no_return(np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0]])).tolist()
    [True, False, True]
    >>> is_no_return(np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])).tolist()
    [False, False]
    """
    zero = (points == 0.0).all(axis=1)
    return zero if np.count_nonzero(zero) > 1 else np.zeros(len(points), dtype=np.bool_)


def float32_step(points: FloatArray, *, declared: bool = False) -> float:
    """Distance between neighbouring float32 numbers at the points, if their coordinates are such.

    Parameters
    ----------
    points : (n, 3) float array
    declared : bool
        The file says that it holds float32. Otherwise fewer than 100 points prove nothing.

    Returns
    -------
    float
        At the largest coordinate of a typical point; 0 if the points have more digits. Text may have
        rounded float32 to 8 digits; it still shows.

    Examples
    --------
    >>> wall = np.random.default_rng(0).uniform(0, 12, (500, 3)) + [715_830, 734_120, 0]
    >>> float32_step(wall), float32_step(np.float32(wall).astype(np.float64).round(2))
    (0.0, 0.0625)
    """
    if not len(points) or (not declared and len(points) < FEWEST):
        return 0.0
    if len(points) > ENOUGH and not _is_float32(points[:ENOUGH]):
        return 0.0
    scale = np.float32(min(np.median(np.abs(points).max(axis=1)), LARGEST_FLOAT32))
    return float(np.spacing(scale)) if _is_float32(points) else 0.0


def _is_float32(points: FloatArray) -> bool:
    """Whether all coordinates but small ones, which text rounds too much, are next to float32 numbers."""
    scale = np.median(np.abs(points).max(axis=1))
    large = points[np.abs(points) >= 0.1 * scale]
    with np.errstate(over="ignore", invalid="ignore"):
        single = large.astype(np.float32)
        return bool((np.abs(single - large) <= 0.25 * np.spacing(np.abs(single))).all())


def joined(parts: Sequence[NDArray[ScalarT]]) -> NDArray[ScalarT]:
    """Join arrays along their first axis; a single one comes back as it is, not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def cut_short(path: Path, expected: int, held: int) -> InputError:
    """Error about a file that holds fewer points than it says."""
    return InputError(f"{path} is cut short: its header says {expected} points, the file holds {held}.")
