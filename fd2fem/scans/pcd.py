"""PCD files (Point Cloud Library), version 0.5 to 0.7: text, binary, and compressed by LZF.

The points are in the world; ``VIEWPOINT`` says from where they were seen and does not move them. Points of
which a coordinate is NaN are rays that did not come back. Layout:
https://pointclouds.org/documentation/tutorials/pcd_file_format.html.
"""

import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.scans.pose import trusted_position
from fd2fem.scans.raw import UNKNOWN, RawScan, as_strength, cut_short, float32_step, is_no_return

__all__ = ["read_pcd"]

FloatArray = NDArray[np.float64]
Columns = dict[str, NDArray[np.generic]]

VERSIONS = {".5", ".6", ".7", "0.5", "0.6", "0.7"}
KINDS = {"ascii", "binary", "binary_compressed"}
TYPES = {"F": {4, 8}, "I": {1, 2, 4, 8}, "U": {1, 2, 4, 8}}
"""Bytes that a number of each type may take."""
INTENSITY = ("intensity", "Intensity", "scalar_Intensity", "reflectance", "i")
NO_VIEW = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
"""The viewpoint, position and quaternion w, x, y, z, that a file has by default."""
LONGEST_LINE = 65536
MOST_LINES = 1000


@dataclass(frozen=True)
class Header:
    """The header: `names`, numpy `codes` and `counts` of the fields; the data begin at byte `start`."""

    names: tuple[str, ...]
    codes: tuple[str, ...]
    counts: tuple[int, ...]
    points: int
    viewpoint: tuple[float, ...]
    kind: str
    start: int
    lines: int = field(default=0)


def read_pcd(path: Path) -> RawScan:
    """Read a PCD file, in the file's units.

    Raises
    ------
    InputError
        If it is not such a file with fields x, y, z, of a version that is not known, or cut short.
    """
    header = _read_header(path)
    intensity = next((name for name in INTENSITY if name in header.names), None)
    wanted = [*"xyz", *([intensity] if intensity else [])]
    read = {"ascii": _read_text, "binary": _read_binary, "binary_compressed": _read_compressed}[header.kind]
    columns = read(path, header, wanted)
    points = np.column_stack([columns[name].astype(np.float64) for name in "xyz"])
    back = np.isfinite(points).all(axis=1) & ~is_no_return(points)
    no_returns = len(points) - int(np.count_nonzero(back))
    if no_returns:
        points = points[back]
    codes = dict(zip(header.names, header.codes, strict=True))
    single = "f4" in {codes[name] for name in "xyz"}
    return RawScan(
        points,
        as_strength(path, columns[intensity][back]) if intensity else np.empty(0),
        _scanner(header, points),
        step=float32_step(points, declared=single),
        no_returns=no_returns,
    )


def _scanner(header: Header, points: FloatArray) -> FloatArray:
    """Position of the scanner, one NaN where the file has the default, which says nothing."""
    if header.viewpoint == NO_VIEW:
        return np.array([UNKNOWN])
    position = np.array(header.viewpoint[:3])
    turned = any(header.viewpoint[4:])
    return trusted_position(position, points, turned=turned)[np.newaxis]


def _read_header(path: Path) -> Header:
    """Parse the lines up to ``DATA``."""
    entries: dict[str, list[str]] = {}
    with path.open("rb") as file:
        for number in range(1, MOST_LINES):
            words = file.readline(LONGEST_LINE).decode("latin-1").split()
            if words and not words[0].startswith("#"):
                entries[words[0]] = words[1:]
            if words[:1] == ["DATA"]:
                return _parse_header(path, entries, start=file.tell(), lines=number)
            if not words and not file.peek(1):
                break
    msg = f"{path} is not a PCD point cloud: its header does not end with a line 'DATA ...'."
    raise InputError(msg)


def _parse_header(path: Path, entries: dict[str, list[str]], *, start: int, lines: int) -> Header:
    version = " ".join(entries.get("VERSION", []))
    if version not in VERSIONS:
        msg = f"{path} is a PCD file of version {version or 'unknown'!r}, not 0.7: export it anew."
        raise InputError(msg)
    try:
        names = tuple(entries["FIELDS"])
        types, sizes = entries["TYPE"], [int(text) for text in entries["SIZE"]]
        counts = tuple(int(text) for text in entries.get("COUNT", ["1"] * len(names)))
        points = int(entries["POINTS"][0] if "POINTS" in entries else entries["WIDTH"][0])
        size = [int(entries[name][0]) for name in ("WIDTH", "HEIGHT") if name in entries]
        view = tuple(float(text) for text in entries["VIEWPOINT"]) if "VIEWPOINT" in entries else NO_VIEW
        kind = entries["DATA"][0]
    except (KeyError, ValueError, IndexError) as error:
        msg = f"{path} is not a PCD point cloud: {error} in its header is missing or no number."
        raise InputError(msg) from error
    sound = (
        kind in KINDS
        and len(names) == len(types) == len(sizes) == len(counts)
        and all(size in TYPES.get(kind, ()) for kind, size in zip(types, sizes, strict=True))
        and min(points, *counts) >= 0
        and np.prod(size) in {points, 1}
        and len(view) == 7
    )
    if not sound or any(names.count(name) != 1 for name in "xyz"):
        msg = f"{path} is not a PCD point cloud with fields x, y and z: the lines of its header do not fit."
        raise InputError(msg)
    codes = tuple(f"{kind.lower()}{size}" for kind, size in zip(types, sizes, strict=True))
    return Header(names, codes, counts, points, view, kind, start, lines)


def _record(header: Header) -> np.dtype[np.void]:
    """Layout of one point; fields are numbered where they are not read, since ``_`` may repeat."""
    fields = zip(header.names, header.codes, header.counts, strict=True)
    used = {*"xyz", *INTENSITY}
    return np.dtype(
        [
            (name if name in used else f"_{index}", f"<{code}", (count,) if count != 1 else ())
            for index, (name, code, count) in enumerate(fields)
        ]
    )


def _read_binary(path: Path, header: Header, wanted: list[str]) -> Columns:
    """Map the points and pick the wanted fields."""
    record = _record(header)
    held = max(0, path.stat().st_size - header.start) // record.itemsize
    if held < header.points:
        raise cut_short(path, header.points, held)
    if not header.points:
        return {name: np.empty(0) for name in wanted}
    data = np.memmap(path, dtype=record, mode="r", offset=header.start, shape=(header.points,))
    return {name: np.array(data[name]) for name in wanted}


def _read_compressed(path: Path, header: Header, wanted: list[str]) -> Columns:
    """Decompress the fields, which lie one after the other, and pick the wanted ones."""
    import lzf

    record = _record(header)
    expected = header.points * record.itemsize
    with path.open("rb") as file:
        file.seek(header.start)
        packed, size = _sizes(path, file)
        if size != expected:
            msg = f"{path} is damaged: its points take {expected} bytes, it says {size}: export it anew."
            raise InputError(msg)
        content = file.read(packed)
    try:
        # No three bytes stand for more than 264, so a damaged size cannot claim all memory.
        sound = len(content) == packed and 0 < size <= 264 * packed
        data = lzf.decompress(content, size) if sound else b""
    except ValueError:
        data = None
    if data is None or len(data) != size:
        msg = f"{path} is cut short or damaged: its {header.points} points cannot be unpacked."
        raise InputError(msg)
    columns: Columns = {}
    offset = 0
    for name in record.names or ():
        base = record[name]
        if name in wanted:
            columns[name] = np.frombuffer(data, base, header.points, offset)
        offset += base.itemsize * header.points
    return columns


def _sizes(path: Path, file: BinaryIO) -> tuple[int, int]:
    """Number of bytes, packed and unpacked."""
    head = file.read(8)
    if len(head) < 8:
        msg = f"{path} is cut short: it ends after its header."
        raise InputError(msg)
    packed, size = struct.unpack("<II", head)
    return packed, size


def _read_text(path: Path, header: Header, wanted: list[str]) -> Columns:
    """Read the lines of the points and pick the wanted fields."""
    import pandas as pd

    first = np.concatenate([[0], np.cumsum(header.counts)])
    place = {name: int(first[header.names.index(name)]) for name in wanted}
    if not header.points:
        return {name: np.empty(0) for name in wanted}
    try:
        table = pd.read_csv(
            path,
            sep=r"\s+",
            header=None,
            names=range(int(first[-1])),
            usecols=sorted({*place.values(), int(first[-1]) - 1}),
            dtype=np.float64,
            skiprows=header.lines,
            nrows=header.points,
            index_col=False,
            encoding="latin-1",
            quoting=3,
        )
    except (pd.errors.EmptyDataError, pd.errors.ParserError, ValueError) as error:
        _check_lines(path, header, int(first[-1]))
        raise cut_short(path, header.points, 0) from error
    if len(table) < header.points:
        raise cut_short(path, header.points, len(table))
    if table.isna().to_numpy().any():  # NaN in the text, or a line that is too short
        _check_lines(path, header, int(first[-1]))
    return {name: table[column].to_numpy() for name, column in place.items()}


def _check_lines(path: Path, header: Header, width: int) -> None:
    """Raise for the first line of a point that does not hold `width` numbers; NaN is one here."""
    left = header.points
    with path.open(encoding="latin-1") as file:
        for number, line in enumerate(file, start=1):
            if number <= header.lines or not line.strip() or not left:
                continue
            left -= 1
            words = line.split()
            try:
                good = len(words) >= width and [float(word) for word in words[:width]]
            except ValueError:
                good = False
            if not good:
                msg = f"{path}: line {number} does not hold {width} numbers: {line.strip()[:60]!r}."
                raise InputError(msg)
