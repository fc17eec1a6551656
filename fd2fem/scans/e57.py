"""E57 files (ASTM E2807), read through pye57, that is libE57Format.

Each scan of a file is in the frame of its scanner; its pose places it in the world. Points that the file
marks as invalid are rays that did not come back. Lengths are in metres.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.scans.pose import rotation_of_quaternion, trusted_position
from fd2fem.scans.raw import (
    UNKNOWN,
    RawScan,
    as_strength,
    check_finite,
    cut_short,
    float32_step,
    is_no_return,
    joined,
)
from fd2fem.scans.units import Units

__all__ = ["read_e57"]

FloatArray = NDArray[np.float64]

CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
CHUNK = 1_000_000
"""Points decoded at a time, so that a damaged count cannot claim all memory."""


@dataclass(frozen=True, eq=False)
class Scan:
    """One scan: `points` in the world; `strength` may be empty; `scanner` or NaN; `step` of float32."""

    points: FloatArray
    strength: FloatArray
    scanner: FloatArray
    step: float
    no_returns: int


def read_e57(path: Path) -> RawScan:
    """Read the scans of an E57 file, in metres, world frame.

    Raises
    ------
    InputError
        If pye57 is missing, or the file is no E57, is damaged, or holds a scan without coordinates.
    """
    pye57 = _library(path)
    with path.open("rb") as raw:
        signature = raw.read(8)
    if signature != b"ASTM-E57":
        msg = f"{path} is not an E57 point cloud: it does not begin with ASTM-E57."
        raise InputError(msg)
    try:
        with pye57.E57(str(path)) as file:
            scans = [_read_scan(path, file, index) for index in range(file.scan_count)]
    except pye57.libe57.E57Exception as error:
        msg = f"{path} cannot be read as E57, it may be cut short or damaged: {_first_line(error)}."
        raise InputError(msg) from error
    if not scans:
        msg = f"{path} holds no scan: expected a point cloud."
        raise InputError(msg)
    known = all(len(scan.strength) == len(scan.points) for scan in scans)
    strength = joined([scan.strength for scan in scans]) if known else np.empty(0)
    counts = [len(scan.points) for scan in scans]
    return RawScan(
        joined([scan.points for scan in scans]),
        as_strength(path, strength),
        np.array([scan.scanner for scan in scans]),
        np.repeat(np.arange(len(scans), dtype=np.int32), counts),
        step=max(scan.step for scan in scans),
        units=Units.M,
        no_returns=sum(scan.no_returns for scan in scans),
    )


def _library(path: Path) -> Any:
    """The module pye57, which has no wheels for some platforms."""
    try:
        import pye57
    except ImportError as error:
        msg = f"{path} needs pye57 to be read: pip install pye57, or convert the scan to LAS or PTX."
        raise InputError(msg) from error
    return pye57


def _read_scan(path: Path, file: Any, index: int) -> Scan:
    """Read one scan and place it in the world."""
    header = file.get_header(index)
    names = header.point_fields
    kind = next((kind for kind in (CARTESIAN, SPHERICAL) if set(kind) <= set(names)), None)
    if kind is None:
        msg = f"{path}: scan {index + 1} has no coordinates, only {', '.join(names)}: export it anew."
        raise InputError(msg)
    invalid = "cartesianInvalidState" if kind is CARTESIAN else "sphericalInvalidState"
    extra = [name for name in ("intensity", invalid) if name in names]
    own, strength, no_returns = _read_points(file, header, [*kind, *extra])
    if len(own) + no_returns != header.point_count:
        raise cut_short(path, header.point_count, len(own) + no_returns)
    check_finite(path, own)
    step = float32_step(own)
    pose = _pose(path, header)
    if pose is None:
        # Ranges and angles are measured from the scanner; coordinates without a pose from anywhere.
        at_origin = np.zeros(3) if kind is SPHERICAL else np.array(UNKNOWN)
        return Scan(own, strength, trusted_position(at_origin, own, turned=False), step, no_returns)
    rotation, translation = pose
    points = own @ rotation.T
    points += translation
    turned = not np.array_equal(rotation, np.eye(3))
    scanner = trusted_position(translation, points, turned=turned)
    return Scan(points, strength, scanner, step, no_returns)


def _read_points(file: Any, header: Any, fields: list[str]) -> tuple[FloatArray, FloatArray, int]:
    """Points in the frame of the scanner, their strengths if `fields` has them, and rays without a return."""
    capacity = max(1, min(CHUNK, header.point_count))
    arrays, buffers = file.make_buffers(fields, capacity)
    reader = header.points.reader(buffers)
    points, strength, read = [np.empty((0, 3))], [np.empty(0)], 0
    while count := reader.read():
        chunk = {name: array[:count] for name, array in arrays.items()}
        xyz = np.column_stack([chunk[name] for name in fields[:3]])
        if fields[0] == SPHERICAL[0]:
            xyz = _cartesian(xyz)
        valid = np.ones(count, dtype=np.bool_)
        for name in fields[3:]:
            if name.endswith("InvalidState"):  # 1: the direction alone is valid, 2: nothing is
                valid = chunk[name] == 0
        points.append(xyz[valid])
        if "intensity" in fields:
            strength.append(chunk["intensity"][valid].astype(np.float64))
        read += count
    reader.close()
    own, strengths = np.concatenate(points), np.concatenate(strength)
    zero = is_no_return(own)
    if zero.any():
        own, strengths = own[~zero], strengths[~zero] if len(strengths) else strengths
    return own, strengths, read - len(own)


def _cartesian(spherical: FloatArray) -> FloatArray:
    """Coordinates from range, azimuth and elevation, m and rad."""
    distance, azimuth, elevation = spherical.T
    level = distance * np.cos(elevation)
    return np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), distance * np.sin(elevation)])


def _pose(path: Path, header: Any) -> tuple[FloatArray, FloatArray] | None:
    """Rotation matrix and translation of a scan, or None where the file does not give its pose."""
    if not header.has_pose():
        return None
    pose = header["pose"]
    rotation, translation = np.eye(3), np.zeros(3)
    if pose.isDefined("translation"):
        translation = np.array([pose["translation"][name].value() for name in "xyz"])
    if pose.isDefined("rotation"):
        quaternion = np.array([pose["rotation"][name].value() for name in "wxyz"])
        if not (np.isfinite(quaternion).all() and quaternion.any()):
            msg = f"{path}: the pose of a scan has the rotation {quaternion.tolist()}: export it anew."
            raise InputError(msg)
        rotation = rotation_of_quaternion(quaternion)
    return rotation, translation


def _first_line(error: Exception) -> str:
    """First line of another program's message, without its full stop."""
    return (str(error).splitlines() or [type(error).__name__])[0].rstrip(".")
