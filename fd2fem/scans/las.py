"""LAS and LAZ files (ASPRS LAS 1.0 to 1.4), read and written through laspy.

Positions of the scanner travel in a variable length record of our own:

=========== ========= ==============================================================================
user id     record id payload
=========== ========= ==============================================================================
``fd2fem``  1         UTF-8 JSON, ``{"scanners": [[x, y, z], ...], "station": "point_source_id"}``
=========== ========= ==============================================================================

Where it has the entry ``station``, the point source ID of a point is the number of its scanner in that
list, from 1; 0 is unknown. Other programs give that ID other meanings.
"""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import PointCloud
from fd2fem.scans.crs import declared_units
from fd2fem.scans.raw import RawScan, check_finite

__all__ = ["read_las", "write_las"]

USER_ID = "fd2fem"
RECORD_ID = 1
SCALE = 1e-4
"""Step of the coordinates that are written, m."""
STRONGEST = 65535
"""Intensity is an unsigned 16-bit number."""
MOST_STATIONS = 65535
"""The point source ID is an unsigned 16-bit number, too."""
CHUNK = 1_000_000
"""Points decoded at a time, so that a damaged count cannot claim all memory."""


def read_las(path: Path) -> RawScan:
    """Read a LAS or LAZ file, in the file's units.

    Raises
    ------
    InputError
        If it is not such a file, is cut short, or holds a coordinate that is no number.
    """
    import laspy
    import lazrs

    _check_header(path)
    try:
        with laspy.open(path, read_evlrs=False) as file:
            chunks = [
                (
                    np.column_stack((chunk.x, chunk.y, chunk.z)),
                    np.array(chunk.intensity),
                    np.array(chunk.point_source_id),
                )
                for chunk in file.chunk_iterator(CHUNK)
            ]
            scanners, numbered = _scanners(path, file.header.vlrs)
            units, doubt = declared_units(path, file.header.vlrs)
            expected = file.header.point_count
    except (
        laspy.errors.LaspyException,
        lazrs.LazrsError,
        OSError,
        ValueError,
        OverflowError,
        LookupError,
        struct.error,
    ) as error:
        if isinstance(error, InputError):
            raise
        msg = f"{path} cannot be read as LAS or LAZ, it may be cut short: {_first_line(error)}."
        raise InputError(msg) from error
    points = np.concatenate([np.empty((0, 3)), *(xyz for xyz, _, _ in chunks)])
    if len(points) != expected:
        msg = f"{path} is cut short: its header says {expected} points, the file holds {len(points)}."
        raise InputError(msg)
    check_finite(path, points)
    counts, sources = (
        np.concatenate([np.empty(0, dtype=np.uint16), *(chunk[column] for chunk in chunks)])
        for column in (1, 2)
    )
    # Every LAS file has the field; writers that measured none leave it 0.
    intensity = counts / STRONGEST if counts.any() else np.empty(0)
    station = sources.astype(np.int32) - np.int32(1) if numbered else np.empty(0, dtype=np.int32)
    if len(station) and station.max() >= len(scanners):
        station = np.empty(0, dtype=np.int32)  # another program has numbered them anew
    return RawScan(points, intensity, scanners, station, units=units, doubt=doubt)


def write_las(cloud: PointCloud, path: Path) -> None:
    """Write a cloud as LAS or, where the suffix says so, as LAZ.

    Coordinates are kept to 0.05 mm at any survey offset, intensity to 1/65535, the station of each point for
    up to 65535 of them.

    Parameters
    ----------
    cloud : PointCloud
        At least one point; within 214 km of its smallest coordinates.
    path : Path
        Ends in ``.las`` or ``.laz``; its folder exists.

    Raises
    ------
    InputError
        If the suffix is another, the cloud does not fit, or the file cannot be written.
    """
    import laspy

    if path.suffix.lower() not in {".las", ".laz"}:
        msg = f"{path} must end in .las or .laz."
        raise InputError(msg)
    if not len(cloud):
        msg = f"{path} is not written: the cloud has no points."
        raise InputError(msg)
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.generating_software = USER_ID
    header.scales = np.full(3, SCALE)
    header.offsets = np.floor(cloud.points.min(axis=0))
    steps = np.rint((cloud.points - header.offsets) / SCALE)
    if steps.max() > np.iinfo(np.int32).max:
        reach = np.ptp(cloud.points, axis=0).max()
        msg = f"{path} is not written: the points are {reach:.6g} m apart, LAS at {SCALE} m holds 214 km."
        raise InputError(msg)
    numbered = len(cloud.station) > 0 and len(cloud.scanners) <= MOST_STATIONS
    if len(cloud.scanners):
        record = {"scanners": cloud.scanners.tolist()} | ({"station": "point_source_id"} if numbered else {})
        payload = json.dumps(record).encode()
        header.vlrs.append(laspy.VLR(USER_ID, RECORD_ID, "positions of the scanner", payload))
    las = laspy.LasData(header)
    las.X, las.Y, las.Z = steps.astype(np.int32).T
    if numbered:
        las.point_source_id = (cloud.station + 1).astype(np.uint16)
    if len(cloud.intensity):
        las.intensity = np.rint(np.clip(cloud.intensity, 0.0, 1.0) * STRONGEST).astype(np.uint16)
    try:
        las.write(path, do_compress=path.suffix.lower() == ".laz")
    except OSError as error:
        msg = f"{path} cannot be written: {error.strerror}."
        raise InputError(msg) from error


def _check_header(path: Path) -> None:
    """Raise unless the public header block fits the file: laspy would allocate whatever it says."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(375)
    if head[:4] != b"LASF":
        msg = f"{path} is not a LAS or LAZ point cloud: it does not begin with LASF."
        raise InputError(msg)
    if len(head) < 227:
        msg = f"{path} is cut short: {size} bytes do not hold a LAS header."
        raise InputError(msg)
    header_size, start, vlrs, form, length, count = struct.unpack_from("<HIIBHI", head, 94)
    if head[25] >= 4 and len(head) == 375:
        count = max(count, struct.unpack_from("<Q", head, 247)[0])
    if header_size + 54 * vlrs > start or start > size or not length:
        msg = f"{path} is damaged: its LAS header names sizes that do not fit the {size} bytes of the file."
        raise InputError(msg)
    compressed = form & 0x80
    if not compressed and start + count * length > size:
        msg = (
            f"{path} is cut short: its header says {count} points, "
            f"the file holds {max(0, size - start) // length}."
        )
        raise InputError(msg)


def _scanners(path: Path, records: list[Any]) -> tuple[NDArray[np.float64], bool]:
    """Positions of the scanner from our own record, if the file has it, and whether it numbers the points."""
    for record in records:
        if record.user_id == USER_ID and record.record_id == RECORD_ID:
            try:
                entries = json.loads(record.record_data)
                positions = np.array(entries["scanners"], dtype=np.float64).reshape(-1, 3)
            except (ValueError, TypeError, KeyError) as error:
                msg = f"{path}: the record of scanner positions is damaged: write the scan anew."
                raise InputError(msg) from error
            check_finite(path, positions)
            return positions, entries.get("station") == "point_source_id"
    return np.empty((0, 3)), False


def _first_line(error: Exception) -> str:
    """First line of another program's message, without its full stop."""
    return (str(error).splitlines() or [type(error).__name__])[0].rstrip(".")
