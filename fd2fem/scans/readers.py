"""Reading of scans: one function for all formats, metres and float64 out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fd2fem.errors import InputError
from fd2fem.model import PointCloud
from fd2fem.scans.las import read_las
from fd2fem.scans.ply import read_ply
from fd2fem.scans.raw import RawScan, check_file, check_spread
from fd2fem.scans.text import read_text

__all__ = ["Units", "guess_units", "read_scan", "read_scans"]

READERS: dict[str, Callable[[Path], RawScan]] = {
    ".las": read_las,
    ".laz": read_las,
    ".ply": read_ply,
    ".xyz": read_text,
    ".csv": read_text,
    ".txt": read_text,
}
COARSEST = 0.002
"""Largest step between neighbouring float32 coordinates that is accepted, m."""
FARTHEST = 1e8
"""Largest coordinate that a place on earth can have in any survey system, with a margin, m."""
TALLEST_M, SHORTEST_MM = 200.0, 1000.0


class Units(StrEnum):
    """The unit of length of a file of points."""

    AUTO = "auto"
    M = "m"
    MM = "mm"


PER_METRE = {Units.M: 1.0, Units.MM: 1000.0}


@dataclass(frozen=True, eq=False)
class _File:
    """A file that was read, and the unit it is in."""

    path: Path
    raw: RawScan
    units: Units


def read_scan(path: Path, *, units: Units = Units.AUTO) -> PointCloud:
    """Read a point cloud: LAS, LAZ, PLY, or XYZ, CSV, TXT, by the suffix.

    Parameters
    ----------
    path : Path
    units : Units
        Of the file; by default as `guess_units` finds.

    Returns
    -------
    cloud : PointCloud
        In metres; survey offsets are kept in float64.

    Raises
    ------
    InputError
        If the file is missing, empty, not a point cloud, cut short, holds NaN or infinite coordinates,
        has lost precision as float32, or has fewer than four points or all of them on one line.
    """
    return _to_cloud(_read(Path(path), Units(units)))


def read_scans(paths: Sequence[Path], *, units: Units = Units.AUTO) -> PointCloud:
    """Read the scans of one facade, all in the same world frame, and join them.

    Parameters
    ----------
    paths : sequence of Path
    units : Units
        Of all files; `Units.AUTO` finds it for each, and they must agree.

    Returns
    -------
    cloud : PointCloud
        Intensity only if every file has it; the scanners of all.

    Raises
    ------
    InputError
        As `read_scan`; also if there is no file, or they seem to be in different units.
    """
    if not paths:
        msg = "no scan is given: name at least one file."
        raise InputError(msg)
    files = [_read(Path(path), Units(units)) for path in paths]
    for file in files[1:]:
        if file.units is not files[0].units:
            msg = (
                f"{files[0].path} seems to be in {files[0].units} and {file.path} in {file.units}: "
                "convert one of them, or say --units m or --units mm if that is wrong."
            )
            raise InputError(msg)
    clouds = [_to_cloud(file) for file in files]
    if len(clouds) == 1:
        return clouds[0]
    has_intensity = all(len(cloud.intensity) for cloud in clouds)
    return PointCloud(
        points=np.concatenate([cloud.points for cloud in clouds]),
        source=", ".join(cloud.source for cloud in clouds),
        intensity=np.concatenate([cloud.intensity for cloud in clouds]) if has_intensity else np.empty(0),
        scanners=np.concatenate([cloud.scanners for cloud in clouds]),
    )


def guess_units(z: ArrayLike, *, source: str = "the scan") -> Units:
    """Tell metres from millimetres by the vertical extent of a scan.

    The extent runs from the 0.1th to the 99.9th percentile, so that stray returns from the sky do not
    count. Above 1000 it is millimetres (a wall over 1 m), under 200 metres (a wall under 200 m).

    Parameters
    ----------
    z : (n,) array-like, the file's units
    source : str
        What a message calls the scan.

    Returns
    -------
    units : Units
        `Units.M` or `Units.MM`.

    Raises
    ------
    InputError
        If the extent lies between 200 and 1000.

    Examples
    --------
    >>> guess_units([0.0, 5.5, 12.1]).value
    'm'
    >>> guess_units([0.0, 5500.0, 12100.0]).value
    'mm'
    """
    low, high = np.percentile(np.asarray(z, dtype=np.float64), [0.1, 99.9])
    extent = high - low
    if extent < TALLEST_M:
        return Units.M
    if extent > SHORTEST_MM:
        return Units.MM
    msg = f"{source} is {extent:.4g} high: metres or millimetres? Say --units m or --units mm."
    raise InputError(msg)


def _read(path: Path, units: Units) -> _File:
    """Read and check one file."""
    check_file(path)
    suffix = path.suffix.lower()
    if suffix not in READERS:
        what = f"'{path.suffix}' files are" if suffix else "a file without a suffix is"
        msg = f"{path}: {what} not read yet; convert to LAS, LAZ, PLY, XYZ or CSV."
        raise InputError(msg)
    try:
        raw = READERS[suffix](path)
    except OSError as error:
        msg = f"{path} cannot be read: {error.strerror or error}."
        raise InputError(msg) from error
    check_spread(path, raw.points)
    if units is Units.AUTO:
        units = guess_units(raw.points[:, 2], source=str(path))
    _check_coordinates(path, raw, PER_METRE[units])
    return _File(path, raw, units)


def _check_coordinates(path: Path, raw: RawScan, scale: float) -> None:
    """Raise if coordinates are too coarse for a facade, or larger than any on earth."""
    step = raw.step / scale
    if step > COARSEST:
        msg = (
            f"{path} has lost precision: float32 coordinates this large are {step * 1000:.3g} mm apart; "
            "export with double coordinates or with local ones."
        )
        raise InputError(msg)
    far = np.flatnonzero((np.abs(raw.points) > FARTHEST * scale).any(axis=1))
    if len(far):
        msg = (
            f"{path}: {len(far)} of {len(raw.points)} points have a coordinate beyond {FARTHEST:.0e} m, "
            f"the first is point {far[0] + 1}: the file is damaged or in another unit."
        )
        raise InputError(msg)


def _to_cloud(file: _File) -> PointCloud:
    """Convert to metres. Division, because 1/1000 is no binary number, keeps millimetres exact."""
    scale = PER_METRE[file.units]
    raw = file.raw
    return PointCloud(raw.points / scale, file.path.name, raw.intensity, raw.scanners / scale)
