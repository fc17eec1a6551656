"""Reading of scans: one function for all formats, metres and float64 out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import PointCloud
from fd2fem.scans.e57 import read_e57
from fd2fem.scans.las import read_las
from fd2fem.scans.pcd import read_pcd
from fd2fem.scans.ply import read_ply
from fd2fem.scans.pts import read_pts
from fd2fem.scans.ptx import read_ptx
from fd2fem.scans.raw import UNKNOWN, RawScan, check_file, check_spread, joined
from fd2fem.scans.text import read_text
from fd2fem.scans.units import Units, check_height, guess_units, per_metre, to_metres

__all__ = ["Units", "guess_units", "read_scan", "read_scans"]

READERS: dict[str, Callable[[Path], RawScan]] = {
    ".las": read_las,
    ".laz": read_las,
    ".e57": read_e57,
    ".ply": read_ply,
    ".pcd": read_pcd,
    ".pts": read_pts,
    ".ptx": read_ptx,
    ".xyz": read_text,
    ".csv": read_text,
    ".txt": read_text,
}
COARSEST = 0.002
"""Largest step between neighbouring float32 coordinates that is accepted, m."""
FARTHEST = 1e8
"""Largest coordinate that a place on earth can have in any survey system, with a margin, m."""


@dataclass(frozen=True, eq=False)
class _File:
    """A file that was read, and the unit it is in; `guessed` if nobody says so."""

    path: Path
    raw: RawScan
    units: Units
    guessed: bool


def read_scan(
    path: Path, *, units: Units = Units.AUTO, scanners: Sequence[Sequence[float]] = ()
) -> PointCloud:
    """Read a point cloud by the suffix: LAS, LAZ, E57, PLY, PCD, PTS, PTX, or XYZ, CSV, TXT.

    The same as :func:`read_scans` of one file.
    """
    return read_scans([path], units=units, scanners=scanners)


def read_scans(
    paths: Sequence[Path], *, units: Units = Units.AUTO, scanners: Sequence[Sequence[float]] = ()
) -> PointCloud:
    """Read the scans of one facade, all in the same world frame, and join them.

    Parameters
    ----------
    paths : sequence of Path
    units : Units
        Of all files. `Units.AUTO`: what a file says (E57 and PTX are in metres by definition, LAS may
        name its coordinate system), else as `guess_units` finds.
    scanners : sequence of (x, y, z), m
        Positions of the scanner, world frame, in place of those that the files hold: one of each scan,
        or one of each file, in their order, or a single one for all. With another number of
        positions it is not known which of them measured a point.

    Returns
    -------
    cloud : PointCloud
        In metres; survey offsets are kept in float64. Intensity only if every file has it.

    Raises
    ------
    InputError
        If there is no file, or one is missing, empty, not a point cloud, cut short, holds NaN or
        infinite coordinates, has lost precision as float32, or has fewer than four points or all of
        them on one line; if the unit must be asked for, or files seem to be in different ones.
    """
    if not paths:
        msg = "no scan is given: name at least one file."
        raise InputError(msg)
    files = [_read(Path(path), Units(units)) for path in paths]
    for file in files[1:]:
        if file.units is not files[0].units and (file.guessed or files[0].guessed):
            msg = (
                f"{files[0].path} seems to be in {files[0].units} and {file.path} in {file.units}: "
                "convert one of them, or say --units if that is wrong."
            )
            raise InputError(msg)
    positions, station = _stations(files, np.array(scanners, dtype=np.float64).reshape(-1, 3))
    has_intensity = all(len(file.raw.intensity) for file in files)
    return PointCloud(
        points=_fixed([to_metres(file.raw.points, file.units) for file in files]),
        source=", ".join(file.path.name for file in files),
        intensity=_fixed([file.raw.intensity for file in files]) if has_intensity else np.empty(0),
        scanners=positions,
        station=station,
        no_returns=sum(file.raw.no_returns for file in files),
    )


def _read(path: Path, units: Units) -> _File:
    """Read and check one file."""
    check_file(path)
    suffix = path.suffix.lower()
    if suffix not in READERS:
        what = f"'{path.suffix}' files are" if suffix else "a file without a suffix is"
        msg = f"{path}: {what} not read; convert to LAS, LAZ, E57, PLY, PCD, PTS, PTX, XYZ or CSV."
        raise InputError(msg)
    try:
        raw = READERS[suffix](path)
    except OSError as error:
        msg = f"{path} cannot be read: {error.strerror or error}."
        raise InputError(msg) from error
    check_spread(path, raw.points)
    file = _File(path, raw, *_find_units(path, raw, units))
    _check_coordinates(path, raw, per_metre(file.units))
    return file


def _find_units(path: Path, raw: RawScan, units: Units) -> tuple[Units, bool]:
    """The unit of a file, and whether it is a guess."""
    if units is not Units.AUTO:
        return units, False
    if raw.doubt:
        raise InputError(raw.doubt)
    if raw.units is Units.AUTO:
        return guess_units(raw.points[:, 2], source=str(path)), True
    check_height(raw.points[:, 2], raw.units, source=str(path))
    return raw.units, False


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


def _stations(
    files: Sequence[_File], given: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Positions of the scanners in m, and which of them measured each point (see `read_scans`)."""
    held = [to_metres(_positions(file.raw), file.units) for file in files]
    scans = np.concatenate(held)
    first = np.cumsum([0, *map(len, held)])
    station = np.concatenate(
        [_of_scan(file.raw, int(start)) for file, start in zip(files, first[:-1], strict=True)]
    )
    if len(given) not in {0, len(scans)}:
        if len(given) == 1:
            station = np.zeros_like(station)
        elif len(given) == len(files):
            lengths = [len(file.raw.points) for file in files]
            station = np.repeat(np.arange(len(files), dtype=np.int32), lengths)
        else:
            station = np.full_like(station, -1)
    positions = given if len(given) else scans
    known = np.isfinite(positions).all(axis=1)
    number = np.append(np.where(known, np.cumsum(known) - 1, -1), -1).astype(np.int32)
    station = number[station]  # -1 is the last of them: it stays -1
    return positions[known], station if (station >= 0).any() else np.empty(0, dtype=np.int32)


def _positions(raw: RawScan) -> NDArray[np.float64]:
    """Position of the scanner in each scan of a file, at least one, NaN where it is not known."""
    return raw.scanners if len(raw.scanners) else np.array([UNKNOWN])


def _of_scan(raw: RawScan, first: int) -> NDArray[np.int32]:
    """Scan that each point belongs to, from `first`; -1 where the file has several and does not say."""
    if len(raw.station):
        return np.where(raw.station >= 0, raw.station + np.int32(first), np.int32(-1))
    return np.full(len(raw.points), first if len(raw.scanners) < 2 else -1, dtype=np.int32)


def _fixed(parts: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Join arrays into one that is read-only, so that the cloud takes it without a copy."""
    whole = joined(parts)
    whole.setflags(write=False)
    return whole
