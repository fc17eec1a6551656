"""Read back an ANSYS neutral file with a solid of straight lines and plane areas.

What :func:`~fd2fem.solids.write_anf` writes comes back as it was; files from elsewhere too, as long
as each area is a parallelogram with one loop that runs with the surface, and each volume has one
shell. Anything else is refused, never approximated.
"""

from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import SolidModel
from fd2fem.solids.anf import line_points, patch_points
from fd2fem.solids.anf_source import Source
from fd2fem.solids.loops import loop_ends, vector_areas

__all__ = ["read_anf"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

CLOSE = 1e-6
"""How far, m, control points may lie from where a straight line or a plane area has them."""


@dataclass
class _Nets:
    """Control points of all lines or areas: coordinates one after the other, and how many each has.

    Compact, because they are most of what a file holds.
    """

    reals: "array[float]" = field(default_factory=lambda: array("d"))
    sizes: list[int] = field(default_factory=list)

    def add(self, reals: list[float]) -> None:
        """Append one net."""
        self.reals.extend(reals)
        self.sizes.append(len(reals))

    def by_size(self) -> Iterator[tuple[IntArray, FloatArray]]:
        """Places of the nets of one size, and their points (n, ·, 3), for each size."""
        sizes = np.array(self.sizes, dtype=np.intp)
        reals = np.frombuffer(self.reals, dtype=np.float64)
        begin = np.cumsum(sizes) - sizes
        for size in np.unique(sizes).tolist():
            members = np.flatnonzero(sizes == size)
            points = reals[begin[members][:, None] + np.arange(size)]
            yield members, points.reshape(len(members), -1, 3)


@dataclass
class _Tables:
    """What was read, by the ids of the file."""

    keypoints: dict[int, list[float]] = field(default_factory=dict)
    lines: dict[int, list[int]] = field(default_factory=dict)
    line_nets: _Nets = field(default_factory=_Nets)
    areas: dict[int, list[int]] = field(default_factory=dict)
    area_nets: _Nets = field(default_factory=_Nets)
    volumes: dict[int, list[int]] = field(default_factory=dict)


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
    try:
        with path.open(encoding="ascii") as file:
            tables = _read_records(Source(path.name, file))
    except OSError as error:
        msg = f"{path}: cannot be read ({error.strerror}); give the path of a neutral file."
        raise InputError(msg) from error
    except UnicodeDecodeError as error:
        msg = f"{path.name} is not a neutral file: it is not plain text."
        raise InputError(msg) from error
    if not tables.volumes:
        msg = f"{path.name} is not a neutral file of a solid: it has no VBODY record."
        raise InputError(msg)
    try:
        return _solid(tables)
    except InputError as error:
        msg = f"{path.name}: {error}"
        raise InputError(msg) from error


def _read_records(source: Source) -> _Tables:
    """All records; other commands are passed over."""
    readers: dict[str, tuple[int, Callable[[Source, list[str], _Tables], None]]] = {
        "kpt": (4, _read_keypoint),
        "lcurv": (6, _read_line),
        "asurf": (8, _read_area),
        "vbody": (3, _read_volume),
    }
    tables = _Tables()
    while (text := source.line()) is not None:
        command, *fields = text.strip().split(",")
        if command.lower() not in readers:
            continue
        size, reader = readers[command.lower()]
        if len(fields) != size:
            source.fail(f"{command} has {len(fields)} fields, expected {size}")
        if source.line() is None:  # the CAD identifier
            source.fail(f"the file ends inside {command}")
        reader(source, fields, tables)
    return tables


def _read_keypoint(source: Source, fields: list[str], tables: _Tables) -> None:
    (number,) = source.ints(fields[:1], "KPT")
    _put(source, tables.keypoints, number, source.floats(fields[1:], f"keypoint {number}"))


def _read_line(source: Source, fields: list[str], tables: _Tables) -> None:
    number, kind, *ends = source.ints(fields[:4], "LCURV")
    what = f"line {number}"
    _, order, rational, knots, points = source.ints(source.words(5, what), what)
    if kind != 1 or not _single_span(source, what, [order], [knots], [points]):
        source.fail(f"{what} is not a straight line of one span")
    reals = source.floats(source.words(3 * points, what), what)
    source.words(points * rational, what)
    _put(source, tables.lines, number, ends)
    tables.line_nets.add(reals)


def _read_area(source: Source, fields: list[str], tables: _Tables) -> None:
    number, kind, loops = source.ints(fields[:3], "ASURF")
    what = f"area {number}"
    if kind != 1 or loops != 1:
        source.fail(f"{what} has {loops} loops or is not a B-spline")
    _, size = source.ints(source.words(2, what), what)
    loop = source.ints(source.words(size, what), what)
    header = source.ints(source.words(8, what), what)
    orders, rational, knots, points = header[1:3], header[3], header[4:6], header[6:]
    if not _single_span(source, what, orders, knots, points) or points[0] != points[1]:
        source.fail(f"{what} is not a plane area of one span")
    count = points[0] * points[1]
    reals = source.floats(source.words(3 * count, what), what)
    weights = source.floats(source.words(count * rational, what), what)
    if weights and min(weights) != max(weights):
        source.fail(f"{what} has weights that differ")
    _put(source, tables.areas, number, loop)
    tables.area_nets.add(reals)


def _read_volume(source: Source, fields: list[str], tables: _Tables) -> None:
    number, shells = source.ints(fields[:2], "VBODY")
    what = f"volume {number}"
    if shells != 1:
        source.fail(f"{what} has {shells} shells")
    _, size = source.ints(source.words(2, what), what)
    _put(source, tables.volumes, number, source.ints(source.words(size, what), what))


def _single_span(source: Source, what: str, orders: list[int], knots: list[int], points: list[int]) -> bool:
    """Read the knots; whether each direction is one Bézier span, so that its corners are control points."""
    found = [
        order == point_count and _clamped(order, tuple(source.words(knot_count, what)))
        for order, knot_count, point_count in zip(orders, knots, points, strict=True)
    ]
    return all(found)


@lru_cache(maxsize=64)
def _clamped(order: int, knots: tuple[str, ...]) -> bool:
    """Whether the knots are two ascending values, each as often as the order says."""
    try:
        values = [float(knot) for knot in knots]
    except ValueError:
        return False
    return (
        order >= 2
        and len(values) == 2 * order
        and values == [values[0]] * order + [values[-1]] * order
        and values[0] < values[-1]
    )


def _put(source: Source, table: dict[int, list[Any]], number: int, values: list[Any]) -> None:
    if number in table:
        source.fail(f"number {number} is defined twice")
    table[number] = values


def _solid(tables: _Tables) -> SolidModel:
    """The record of what was read; ids become places from 1."""
    keypoints = np.array(list(tables.keypoints.values()), dtype=np.float64).reshape(-1, 3)
    ends = _places("line", tables.lines, "keypoint", tables.keypoints)
    lines = np.array(ends, dtype=np.intp).reshape(-1, 2) - 1
    corners = _corners(tables.area_nets)
    _check_points("line", tables.line_nets, keypoints[lines], line_points)
    _check_points("area", tables.area_nets, corners, patch_points)
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


def _places(
    what: str, table: dict[int, list[int]], of: str, targets: dict[int, Any]
) -> tuple[tuple[int, ...], ...]:
    """Signed ids of `targets` as signed places from 1."""
    place = {number: index for index, number in enumerate(targets, start=1)}
    if of != "keypoint":
        place |= {-number: -index for number, index in place.items()}
    try:
        return tuple(tuple(place[i] for i in ids) for ids in table.values())
    except KeyError as error:
        msg = f"a {what} refers to {of} {error.args[0]}, which the file does not define."
        raise InputError(msg) from None


def _corners(nets: _Nets) -> FloatArray:
    """Corners (a, 4, 3) of square nets of control points, u fastest, in turn around them."""
    corners = np.empty((len(nets.sizes), 4, 3))
    for members, points in nets.by_size():
        count = points.shape[1]
        order = round(count**0.5)
        corners[members] = points[:, [0, order - 1, count - 1, count - order]]
    return corners


def _check_points(
    what: str, nets: _Nets, corners: FloatArray, expected: Callable[[FloatArray, int], FloatArray]
) -> None:
    """Raise unless the control points are those of straight lines or plane areas between the corners."""
    for members, points in nets.by_size():
        order = points.shape[1] if what == "line" else round(points.shape[1] ** 0.5)
        off = np.abs(points - expected(corners[members], order)).max(axis=(1, 2))
        if not off.max() <= CLOSE:  # not a number fails, too
            msg = (
                f"{what} at place {members[off.argmax()] + 1} is bent or misses its keypoints by "
                f"{off.max():.3g} m; only straight lines and parallelograms can be read."
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
    surface = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    off = np.abs(vector_areas(solid) - surface).max(axis=1)
    bad = np.flatnonzero(off > CLOSE * np.maximum(1.0, np.abs(surface).max(axis=1)))
    if len(bad):
        msg = f"area at place {bad[0] + 1} has a loop that does not run around its surface, in its sense."
        raise InputError(msg)
