"""PLY files: the vertices, with their intensity if there is one.

Text and both binary byte orders, scalar properties of any type in any order. Other elements are
skipped; before the vertices they must have a fixed size, that is no list.
"""

from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.scans.raw import RawScan, as_strength, check_finite, cut_short, float32_step

__all__ = ["read_ply"]

TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
INTENSITY = ("intensity", "scalar_Intensity", "scalar_intensity", "Intensity")
LONGEST_LINE = 4096
MOST_LINES = 10_000


@dataclass(frozen=True)
class Element:
    """One element of the header: `properties` are (name, numpy type) pairs, a list's type is ''."""

    name: str
    count: int
    properties: tuple[tuple[str, str], ...]

    @property
    def fixed(self) -> bool:
        """Whether each of its entries takes the same number of bytes."""
        return all(code for _, code in self.properties)


@dataclass(frozen=True)
class Header:
    """The header: `byte_order` is '' in a text file; the data begin at byte `start`, line `lines` + 1."""

    byte_order: str
    elements: tuple[Element, ...]
    start: int
    lines: int


def read_ply(path: Path) -> RawScan:
    """Read the vertices of a PLY file, in the file's units.

    Raises
    ------
    InputError
        If it is not a PLY file with vertices x, y, z, is cut short, or holds a coordinate that is no
        number.
    """
    header = _read_header(path)
    before, vertex = _vertex(path, header)
    names = [name for name, _ in vertex.properties]
    intensity = next((name for name in INTENSITY if name in names), None)
    wanted = ["x", "y", "z"] + ([intensity] if intensity else [])
    read = _read_binary if header.byte_order else _read_text
    columns = read(path, header, before, wanted)
    points = np.column_stack([columns[name].astype(np.float64) for name in "xyz"])
    check_finite(path, points)
    strength = as_strength(path, columns[intensity]) if intensity else np.empty(0)
    codes = dict(vertex.properties)
    single = "f4" in {codes[name] for name in "xyz"}
    return RawScan(points, strength, step=float32_step(points, declared=single))


def _read_header(path: Path) -> Header:
    """Parse the lines up to ``end_header``."""
    with path.open("rb") as file:
        if file.readline(LONGEST_LINE).strip() != b"ply":
            msg = f"{path} is not a PLY point cloud: it does not begin with the line 'ply'."
            raise InputError(msg)
        return _parse_header(path, file)


def _parse_header(path: Path, file: BinaryIO) -> Header:
    byte_order: str | None = None
    elements: list[Element] = []
    for number in range(2, MOST_LINES):
        line = file.readline(LONGEST_LINE).decode("latin-1")
        match line.split():
            case ["end_header"] if byte_order is not None:
                return Header(byte_order, tuple(elements), file.tell(), number)
            case ["format", name, _] if name in BYTE_ORDERS:
                byte_order = BYTE_ORDERS[name]
            case ["element", name, count] if count.isdecimal():
                elements.append(Element(name, int(count), ()))
            case ["property", "list", _, _, name] if elements:
                elements[-1] = _with_property(elements[-1], name, "")
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1] = _with_property(elements[-1], name, TYPES[kind])
            case ["comment" | "obj_info", *_]:
                pass
            case _:
                text = line.strip()[:60] or "the end of the file or an empty line"
                msg = f"{path} is not a PLY point cloud: line {number} of its header is {text!r}."
                raise InputError(msg)
    msg = f"{path} is not a PLY point cloud: its header does not end."
    raise InputError(msg)


def _with_property(element: Element, name: str, code: str) -> Element:
    return Element(element.name, element.count, (*element.properties, (name, code)))


def _vertex(path: Path, header: Header) -> tuple[tuple[Element, ...], Element]:
    """Return the elements before the vertices, and the vertices."""
    names = [element.name for element in header.elements]
    if "vertex" not in names:
        msg = (
            f"{path} is not a point cloud: it has no element 'vertex', only {', '.join(names) or 'a header'}."
        )
        raise InputError(msg)
    index = names.index("vertex")
    before, vertex = header.elements[:index], header.elements[index]
    properties = [name for name, _ in vertex.properties]
    missing = [name for name in "xyz" if name not in properties]
    if missing or len(set(properties)) < len(properties):
        msg = f"{path} is not a point cloud: its vertices need one each of x, y, z, and have {properties}."
        raise InputError(msg)
    for element in (*before, vertex):
        if not element.fixed:
            msg = (
                f"{path}: element '{element.name}', before or among the vertices, holds lists: "
                "export the points only."
            )
            raise InputError(msg)
    return before, vertex


def _read_binary(
    path: Path, header: Header, before: tuple[Element, ...], wanted: list[str]
) -> dict[str, NDArray[np.generic]]:
    """Map the vertices of a binary file and pick the wanted properties."""
    vertex = header.elements[len(before)]
    record = _record(vertex, header.byte_order)
    offset = header.start + sum(e.count * _record(e, header.byte_order).itemsize for e in before)
    held = max(0, path.stat().st_size - offset) // record.itemsize
    if held < vertex.count:
        raise cut_short(path, vertex.count, held)
    if not vertex.count:
        return {name: np.empty(0) for name in wanted}
    data = np.memmap(path, dtype=record, mode="r", offset=offset, shape=(vertex.count,))
    return {name: np.array(data[name]) for name in wanted}


def _record(element: Element, byte_order: str) -> np.dtype[np.void]:
    """Layout of one entry; properties are numbered, since an element that is skipped may repeat a name."""
    named = element.name == "vertex"
    return np.dtype(
        [(name if named else str(i), byte_order + code) for i, (name, code) in enumerate(element.properties)]
    )


def _read_text(
    path: Path, header: Header, before: tuple[Element, ...], wanted: list[str]
) -> dict[str, NDArray[np.generic]]:
    """Read the lines of the vertices and pick the wanted properties."""
    import pandas as pd

    vertex = header.elements[len(before)]
    first = header.lines + sum(element.count for element in before)
    names = [name for name, _ in vertex.properties]
    try:
        table = pd.read_csv(
            path,
            sep=r"\s+",
            header=None,
            names=names,
            usecols=wanted,
            dtype=np.float64,
            skiprows=first,
            nrows=vertex.count,
            skip_blank_lines=False,
            index_col=False,
            encoding="latin-1",
        )
    except (pd.errors.EmptyDataError, pd.errors.ParserError, ValueError) as error:
        _check_lines(path, first, vertex.count, [names.index(name) for name in wanted])
        raise cut_short(path, vertex.count, 0) from error
    if len(table) < vertex.count:
        raise cut_short(path, vertex.count, len(table))
    columns = {name: table[name].to_numpy() for name in wanted}
    if not all(np.isfinite(column).all() for column in columns.values()):
        _check_lines(path, first, vertex.count, [names.index(name) for name in wanted])
    return columns


def _check_lines(path: Path, first: int, count: int, columns: list[int]) -> None:
    """Raise for the first line after line `first` that lacks a number; NaN is one here."""
    with path.open(encoding="latin-1") as file:
        for number, line in enumerate(islice(file, first, first + count), start=first + 1):
            if not _numeric(line.split(), columns):
                msg = f"{path}: line {number} is no vertex: {line.strip()[:60]!r}."
                raise InputError(msg)


def _numeric(cells: list[str], columns: list[int]) -> bool:
    try:
        for column in columns:
            float(cells[column])
    except (ValueError, IndexError):
        return False
    return True
