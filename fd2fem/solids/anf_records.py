"""The numbers of a neutral file's records, in tables by the ids of the file.

Records of one shape (as many words, the same orders and counts) are read together, thousands at a time:
record by record, reading would take several times as long as writing.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.solids.anf_source import Record, integers, reals, records

__all__ = ["Nets", "Table", "Tables", "read_tables"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
Nets = list[tuple[IntArray, FloatArray]]
"""Control points of lines or areas: places in their table (n,), and points (n, k, 3)."""

CHUNK = 4096
"""Records read together at the most: what bounds the memory."""


@dataclass
class Table:
    """What records of one kind refer to, in the order of the file, and their places by their ids."""

    noun: str
    refers: list[tuple[int, ...]] = field(default_factory=list)
    place: dict[int, int] = field(default_factory=dict)
    nets: Nets = field(default_factory=list)

    def add(self, members: Sequence[Record], numbers: list[int]) -> int:
        """Enter the ids of records; returns the place of the first."""
        begin = len(self.place)
        for record, number in zip(members, numbers, strict=True):
            if number in self.place:
                record.fail(f"number {number} is defined twice")
            self.place[number] = len(self.place)
            record.what = f"{self.noun} {number}"
        return begin


@dataclass
class Tables:
    """What was read."""

    keypoints: Table = field(default_factory=lambda: Table("keypoint"))
    lines: Table = field(default_factory=lambda: Table("line"))
    areas: Table = field(default_factory=lambda: Table("area"))
    volumes: Table = field(default_factory=lambda: Table("volume"))


def read_tables(path: Path) -> Tables:
    """Read all records of a file.

    Raises
    ------
    InputError
        If the file cannot be read or is not text, or a record is not what this package can read.
    """
    tables = Tables()
    readers = {
        "kpt": (4, tables.keypoints, _read_keypoints),
        "lcurv": (6, tables.lines, _read_lines),
        "asurf": (8, tables.areas, _read_areas),
        "vbody": (3, tables.volumes, _read_volumes),
    }
    try:
        with path.open("rb") as file:
            source = records(path.name, file)
            while chunk := list(islice(source, CHUNK)):
                for command, (size, table, read) in readers.items():
                    members = [record for record in chunk if record.command == command]
                    _check_fields(members, size)
                    if members:
                        read(members, table)
    except OSError as error:
        msg = f"{path}: cannot be read ({error.strerror}); give the path of a neutral file."
        raise InputError(msg) from error
    return tables


def _check_fields(members: list[Record], size: int) -> None:
    for record in members:
        if len(record.fields) != size:
            record.fail(f"{record.command} has {len(record.fields)} fields, expected {size}")


def _read_keypoints(members: list[Record], table: Table) -> None:
    begin = table.add(members, integers(members, [record.fields[:1] for record in members])[:, 0].tolist())
    for record in members:
        record.check_size(0)
    points = reals(members, [record.fields[1:] for record in members])
    table.nets.append((begin + np.arange(len(members)), points[:, None]))


def _read_lines(members: list[Record], table: Table) -> None:
    heads = integers(members, [record.fields[:4] for record in members])
    begin = table.add(members, heads[:, 0].tolist())
    table.refers += map(tuple, heads[:, 2:].tolist())
    for places in _alike([(r.fields[1], *r.words[:5], len(r.words)) for r in members]):
        group = [members[place] for place in places]
        _, order, rational, knots, points = _header(group[0], 0, 5)
        other = _first_other(group, 5, [order], [knots], [points])
        if other or heads[places[0], 1] != 1:
            other = other or group[0]
            other.fail(f"{other.what} is not a straight line of one span")
        end = 5 + knots + 3 * points
        group[0].check_size(end + points * rational)
        net = reals(group, [record.words[5 + knots : end] for record in group])
        table.nets.append((begin + np.array(places), net.reshape(len(group), points, 3)))


def _read_areas(members: list[Record], table: Table) -> None:
    heads = integers(members, [record.fields[:3] for record in members])
    begin = table.add(members, heads[:, 0].tolist())
    loops: list[tuple[int, ...]] = [()] * len(members)
    sizes = [_header(record, 0, 2)[1] for record in members]
    keys = [
        (*record.fields[1:3], size, *record.words[2 + size : 10 + size], len(record.words))
        for record, size in zip(members, sizes, strict=True)
    ]
    for places in _alike(keys):
        group, size = [members[place] for place in places], sizes[places[0]]
        if heads[places[0], 1:].tolist() != [1, 1]:
            group[0].fail(f"{group[0].what} has {heads[places[0], 2]} loops or is not a B-spline")
        net = _surface_nets(group, 2 + size)
        _enter(loops, places, integers(group, [record.words[2 : 2 + size] for record in group]))
        table.nets.append((begin + np.array(places), net))
    table.refers += loops


def _surface_nets(group: list[Record], at: int) -> FloatArray:
    """Control points (n, k, 3) of surfaces whose headers begin at the word `at`."""
    first = group[0]
    _, *orders, rational, knots_u, knots_v, points_u, points_v = _header(first, at, 8)
    other = _first_other(group, at + 8, orders, [knots_u, knots_v], [points_u, points_v])
    if other or points_u != points_v:
        other = other or first
        other.fail(f"{other.what} is not a plane area of one span")
    count, begin = points_u * points_v, at + 8 + knots_u + knots_v
    first.check_size(begin + 3 * count + count * rational)
    if rational:
        weights = reals(group, [record.words[begin + 3 * count :] for record in group])
        uneven = np.flatnonzero(np.ptp(weights, axis=1) != 0.0)
        if len(uneven):
            group[uneven[0]].fail(f"{group[uneven[0]].what} has weights that differ")
    net = reals(group, [record.words[begin : begin + 3 * count] for record in group])
    return net.reshape(len(group), count, 3)


def _read_volumes(members: list[Record], table: Table) -> None:
    heads = integers(members, [record.fields[:2] for record in members])
    table.add(members, heads[:, 0].tolist())
    shells: list[tuple[int, ...]] = [()] * len(members)
    for places in _alike([(r.fields[1], *r.words[1:2], len(r.words)) for r in members]):
        group, count = [members[place] for place in places], heads[places[0], 1]
        if count != 1:
            group[0].fail(f"{group[0].what} has {count} shells")
        group[0].check_size(2 + _header(group[0], 0, 2)[1])
        _enter(shells, places, integers(group, [record.words[2:] for record in group]))
    table.refers += shells


def _enter(lists: list[tuple[int, ...]], places: list[int], values: IntArray) -> None:
    """Put the rows of `values` where they belong."""
    for place, row in zip(places, values.tolist(), strict=True):
        lists[place] = tuple(row)


def _alike(keys: Sequence[tuple[object, ...]]) -> Iterator[list[int]]:
    """Places of equal keys."""
    groups: dict[tuple[object, ...], list[int]] = defaultdict(list)
    for place, key in enumerate(keys):
        groups[key].append(place)
    return iter(groups.values())


def _header(record: Record, at: int, size: int) -> list[int]:
    """Read `size` counts from the word `at`; none is negative."""
    words = record.words[at : at + size]
    if len(words) < size:
        record.fail(f"{record.what} has fewer numbers than it announces")
    try:
        values = list(map(int, words))
    except ValueError:
        record.fail(f"{record.what} needs integers here")
    if min(values) < 0:
        record.fail(f"{record.what} has a negative count")
    return values


def _first_other(
    group: list[Record], at: int, orders: list[int], knots: list[int], points: list[int]
) -> Record | None:
    """The first record that is not one Bézier span in each direction; knots begin at the word `at`.

    Of one span, the corners are control points.
    """
    for order, count, point_count in zip(orders, knots, points, strict=True):
        if order != point_count:
            return group[0]
        for record in group:
            if not _clamped(order, tuple(record.words[at : at + count])):
                return record
        at += count
    return None


@lru_cache(maxsize=64)
def _clamped(order: int, knots: tuple[bytes, ...]) -> bool:
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
