"""PTX files (Leica Cyclone): scans one after the other, each a grid of rays in the frame of its scanner.

========= ==================================================================================
lines     content
========= ==================================================================================
1, 2      number of columns, number of rows
3         position of the scanner
4 to 6    its axes x, y, z
7 to 10   transformation to the world, 4 x 4, for row vectors: the translation is the last row
the rest  columns x rows lines ``x y z intensity [r g b]``, column by column
========= ==================================================================================

A ray that did not come back is ``0 0 0 ...``. Lengths are in metres. Layout: https://paulbourke.net/dataformats/ptx/.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.scans.pose import trusted_position
from fd2fem.scans.raw import RawScan, as_strength, joined
from fd2fem.scans.rows import Rows, line_of
from fd2fem.scans.units import Units

__all__ = ["read_ptx"]

FloatArray = NDArray[np.float64]

HEADER = 10
"""Lines before the points of a scan."""
WIDTHS = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
"""Numbers on each of them."""
RIGID = 1e-3
"""How far a rotation may be from one, by rounding."""
SAME_PLACE = 0.01
"""Two statements of the scanner's position that differ by less agree, m."""


@dataclass(frozen=True, eq=False)
class Scan:
    """One scan: `points` in the world; `strength` NaN where a line has none; `scanner` or NaN."""

    points: FloatArray
    strength: FloatArray
    scanner: FloatArray
    no_returns: int


@dataclass(frozen=True, eq=False)
class Header:
    """Header of a scan: `axes` of the scanner as rows; world = p @ `rotation` + `translation`."""

    columns: int
    rows: int
    position: FloatArray
    axes: FloatArray
    rotation: FloatArray
    translation: FloatArray


def read_ptx(path: Path) -> RawScan:
    """Read the scans of a PTX file, in metres, world frame.

    Raises
    ------
    InputError
        If a header is damaged, a scan has fewer or more points than its header says, or a point lacks a
        coordinate.
    """
    rows = Rows(path)
    scans: list[Scan] = []
    while not rows.at_end():
        header = _header(path, rows)
        scans.append(_scan(path, rows, header))
    if not scans:
        msg = f"{path} is not a PTX point cloud: it holds no numbers."
        raise InputError(msg)
    strength = joined([scan.strength for scan in scans])
    counts = [len(scan.points) for scan in scans]
    return RawScan(
        joined([scan.points for scan in scans]),
        np.empty(0) if np.isnan(strength).all() else as_strength(path, strength),
        np.array([scan.scanner for scan in scans]),
        np.repeat(np.arange(len(scans), dtype=np.int32), counts),
        units=Units.M,
        no_returns=sum(scan.no_returns for scan in scans),
    )


def _header(path: Path, rows: Rows) -> Header:
    """Read and check the ten lines of a header."""
    start = rows.taken
    head = rows.take(HEADER)
    for index, width in enumerate(WIDTHS):
        good = index < len(head) and np.isfinite(head[index, :width]).all()
        if not good or not np.isnan(head[index, width:]).all():
            where = line_of(path, start + index)
            msg = f"{path} is damaged or not a PTX point cloud: {where} should hold {width} " + (
                f"number{'s' * (width > 1)}, line {index + 1} of the header of a scan."
            )
            raise InputError(msg)
    columns, count = head[0, 0], head[1, 0]
    if not (columns >= 0 and count >= 0 and columns % 1 == 0 and count % 1 == 0):
        msg = f"{path}: a scan has {columns:g} columns and {count:g} rows: the file is damaged, export anew."
        raise InputError(msg)
    rotation, translation = _transformation(path, head[6:])
    return Header(int(columns), int(count), head[2, :3], head[3:6, :3], rotation, translation)


def _transformation(path: Path, matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation and translation for row vectors; some programs write the matrix for column vectors."""
    last = np.array([0.0, 0.0, 0.0, 1.0])
    if not np.array_equal(matrix[:, 3], last):
        matrix = matrix.T
    rotation = matrix[:3, :3]
    error = np.abs(rotation @ rotation.T - np.eye(3)).max()
    if not np.array_equal(matrix[:, 3], last) or error > RIGID or np.linalg.det(rotation) < 0.0:
        msg = f"{path}: the transformation of a scan does not rotate and move it only: export anew."
        raise InputError(msg)
    return rotation, matrix[3, :3]


def _scan(path: Path, rows: Rows, header: Header) -> Scan:
    """Read the points of a scan and place them in the world."""
    expected = header.columns * header.rows
    first = rows.taken
    local, strength, rays = [np.empty((0, 3))], [np.empty(0)], [np.empty(0, dtype=np.intp)]
    for piece in rows.pieces(expected):
        start = rows.taken - len(piece)
        bad = np.flatnonzero(~np.isfinite(piece[:, :3]).all(axis=1))
        if len(bad):
            where = line_of(path, start + int(bad[0]))
            msg = f"{path}: {where} does not hold three finite coordinates of a point: export anew."
            raise InputError(msg)
        back = np.flatnonzero(piece[:, :3].any(axis=1))
        local.append(piece[back, :3])
        strength.append(piece[back, 3])
        rays.append(back + (start - first))
    held = rows.taken - first
    if held < expected:
        msg = f"{path} is cut short: a header says {expected} points, the file holds {held} more."
        raise InputError(msg)
    own = np.concatenate(local)
    points = own @ header.rotation
    points += header.translation
    position = _position(header, own, points=points, ray=np.concatenate(rays))
    turned = not np.array_equal(header.rotation, np.eye(3))
    return Scan(
        points,
        np.concatenate(strength),
        trusted_position(position, points, turned=turned),
        held - len(points),
    )


def _position(header: Header, own: FloatArray, *, points: FloatArray, ray: NDArray[np.intp]) -> FloatArray:
    """Where the scanner stood: where the transformation puts the origin of its frame.

    A header that names another position does so in a frame from before the transformation; or its
    points are in the world already, and the transformation is none. Seen from the scanner, the rays
    are a grid of angles: that tells which.
    """
    if np.abs(header.position - header.translation).max() < SAME_PLACE or not header.position.any():
        return header.translation
    if min(header.rows, header.columns) < 3:  # no grid
        moved = header.translation.any() or not np.array_equal(header.rotation, np.eye(3))
        return header.translation if moved else header.position
    from_origin = _scatter(own, ray, rows=header.rows)
    from_named = _scatter((points - header.position) @ header.axes.T, ray, rows=header.rows)
    return header.position if from_named < from_origin else header.translation


def _scatter(seen: FloatArray, ray: NDArray[np.intp], *, rows: int) -> float:
    """Variance of the azimuth in a column and of the elevation in a row, as share of that of all.

    Parameters
    ----------
    seen : (n, 3) float array
        Points in the frame of a scanner.
    ray : (n,) int array
        Index of each in the grid, column by column.
    rows : int
        Of the grid.
    """
    east, north, up = (seen / np.maximum(np.linalg.norm(seen, axis=1), 1e-300)[:, np.newaxis]).T
    middle = np.arctan2(north.sum(), east.sum())
    azimuth = np.angle(np.exp(1j * (np.arctan2(north, east) - middle)))
    within, overall = 0.0, 0.0
    for angle, group in ((azimuth, ray // rows), (np.arcsin(np.clip(up, -1.0, 1.0)), ray % rows)):
        mean = np.bincount(group, angle) / np.maximum(np.bincount(group), 1)
        within += float(np.square(angle - mean[group]).sum())
        overall += float(np.square(angle - angle.mean()).sum())
    return within / overall if overall else 1.0
