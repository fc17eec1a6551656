"""Read back an ANSYS neutral file with a solid of straight lines and plane areas.

What :func:`~fd2fem.solids.write_anf` writes comes back as it was; files from elsewhere too, as long
as each area is a convex quadrilateral with one loop that runs with the surface, and each volume has one
shell. Anything else is refused, never approximated.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import SolidModel
from fd2fem.solids.anf import line_points, patch_points
from fd2fem.solids.anf_records import Nets, Table, Tables, read_tables
from fd2fem.solids.loops import loop_ends, vector_areas

__all__ = ["read_anf"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

CLOSE = 1e-6
"""How far, m, control points may lie from where a straight line or a plane area has them."""


def read_anf(path: Path) -> SolidModel:
    """Read an ANSYS neutral file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    solid : SolidModel
        In the units of the file; keypoints, lines, areas and volumes in its order.

    Raises
    ------
    InputError
        If the file is not text, is cut short, refers to something that it does not define, or holds
        curves, bent areas, areas with several loops or volumes with several shells.
    """
    tables = read_tables(path)
    if not tables.volumes.place:
        msg = f"{path.name} is not a neutral file of a solid: it has no VBODY record."
        raise InputError(msg)
    try:
        return _solid(tables)
    except InputError as error:
        msg = f"{path.name}: {error}"
        raise InputError(msg) from error


def _solid(tables: Tables) -> SolidModel:
    """The record of what was read; ids become places from 1."""
    keypoints = np.concatenate([points[:, 0] for _, points in tables.keypoints.nets])
    lines = np.array(_places("line", tables.lines, "keypoint", tables.keypoints), dtype=np.intp) - 1
    corners = _corners(tables.areas)
    _check_plane(corners)
    _check_points("line", tables.lines.nets, keypoints[lines], line_points)
    _check_points("area", tables.areas.nets, corners, patch_points)
    areas = _places("area", tables.areas, "line", tables.lines)
    solid = SolidModel(
        keypoints=keypoints,
        lines=lines,
        areas=areas,
        patches=np.zeros((len(areas), 4), dtype=np.intp),
        volumes=_places("volume", tables.volumes, "area", tables.areas),
    )
    _check_closed(solid)
    solid = replace(solid, patches=_patches(solid, corners))
    _check_sense(solid, corners)
    return solid


def _places(what: str, table: Table, of: str, targets: Table) -> tuple[tuple[int, ...], ...]:
    """Signed ids of `targets` as signed places from 1."""
    place = {number: index + 1 for number, index in targets.place.items()}
    if of != "keypoint":
        place |= {-number: -index for number, index in place.items()}
    try:
        return tuple(tuple([place[i] for i in ids]) for ids in table.refers)
    except KeyError as error:
        msg = f"a {what} refers to {of} {error.args[0]}, which the file does not define."
        raise InputError(msg) from None


def _corners(areas: Table) -> FloatArray:
    """Corners (a, 4, 3) of square nets of control points, u fastest, in turn around them."""
    corners = np.empty((len(areas.place), 4, 3))
    for members, points in areas.nets:
        count = points.shape[1]
        order = round(count**0.5)
        corners[members] = points[:, [0, order - 1, count - 1, count - order]]
    return corners


def _quad_vectors(corners: FloatArray) -> FloatArray:
    """Vector area (a, 3) of quadrilaterals (a, 4, 3)."""
    half: FloatArray = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2.0
    return half


def _check_plane(corners: FloatArray) -> None:
    """Raise unless the corners (a, 4, 3) are those of plane and convex quadrilaterals."""
    vector = _quad_vectors(corners)
    size = np.maximum(np.linalg.norm(vector, axis=1), np.finfo(float).tiny)
    normal = vector / size[:, None]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    turns = np.einsum("ajk,ak->aj", np.cross(ahead, back), normal)
    off = np.abs(np.einsum("ajk,ak->aj", ahead, normal)).max(axis=1)
    bad = np.flatnonzero((off > CLOSE) | (turns <= 0.0).any(axis=1))
    if len(bad):
        msg = (
            f"area at place {bad[0] + 1} has a surface that is not a plane and convex quadrilateral; "
            "only straight lines and plane quadrilaterals can be read."
        )
        raise InputError(msg)


def _check_points(
    what: str, nets: Nets, corners: FloatArray, expected: Callable[[FloatArray, int], FloatArray]
) -> None:
    """Raise unless the control points are those of straight lines or plane areas between the corners."""
    for members, points in nets:
        order = points.shape[1] if what == "line" else round(points.shape[1] ** 0.5)
        off = np.abs(points - expected(corners[members], order)).max(axis=(1, 2))
        if not off.max() <= CLOSE:  # not a number fails, too
            msg = (
                f"{what} at place {members[off.argmax()] + 1} is bent or misses its keypoints by "
                f"{off.max():.3g} m; only straight lines and plane quadrilaterals can be read."
            )
            raise InputError(msg)


def _patches(solid: SolidModel, corners: FloatArray) -> IntArray:
    """Keypoint of each area's loop at each corner of its surface."""
    start, _, area = loop_ends(solid)
    patches = np.full((len(corners), 4), -1, dtype=np.intp)
    for k in range(4):
        hit = np.abs(solid.keypoints[start] - corners[area, k]).max(axis=1) < CLOSE
        patches[area[hit], k] = start[hit]
    lost = np.flatnonzero((patches < 0).any(axis=1))
    if len(lost):
        msg = f"area at place {lost[0] + 1} has a surface corner that is no keypoint of its loop."
        raise InputError(msg)
    return patches


def _check_closed(solid: SolidModel) -> None:
    """Raise unless every loop runs head to tail."""
    start, end, area = loop_ends(solid)
    first = np.flatnonzero(np.diff(area, prepend=-1))
    following = np.arange(1, len(area) + 1)
    following[np.append(first[1:], len(area)) - 1] = first
    broken = np.flatnonzero(end != start[following])
    if len(broken):
        msg = f"area at place {area[broken[0]] + 1} has a loop that is not closed head to tail."
        raise InputError(msg)


def _check_sense(solid: SolidModel, corners: FloatArray) -> None:
    """Raise unless every loop runs once around its surface, in its sense."""
    surface = _quad_vectors(corners)
    off = np.abs(vector_areas(solid) - surface).max(axis=1)
    bad = np.flatnonzero(off > CLOSE * np.maximum(1.0, np.abs(surface).max(axis=1)))
    if len(bad):
        msg = f"area at place {bad[0] + 1} has a loop that does not run around its surface, in its sense."
        raise InputError(msg)
