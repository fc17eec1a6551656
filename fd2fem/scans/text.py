"""Text files of points: one line each, three coordinates and whatever follows.

Commas, semicolons, tabs and blanks separate; a decimal comma is understood where another character
separates. Lines that begin with ``#`` or ``//`` are comments. The first line may hold the names of the
columns (also as a comment), or alone the number of points.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.scans.raw import RawScan, as_strength, float32_step

__all__ = ["read_text"]

BLANKS = r"\s+"
DIALECTS = ((";", "."), (";", ","), (",", "."), (BLANKS, "."), (BLANKS, ","))
"""Separator and decimal character, in the order in which they are tried."""
HEAD = 1000
"""Lines that are looked at to find the first point."""
INTENSITY = ("intensity", "scalar_intensity", "i")


@dataclass(frozen=True)
class Layout:
    """How a file is laid out: `skip` lines before the points; `columns` of x, y, z and maybe intensity."""

    separator: str
    decimal: str
    skip: int
    columns: tuple[int, ...]


def read_text(path: Path) -> RawScan:
    """Read a text file of points, in the file's units.

    Columns are found by the names x, y, z and intensity, or are the first three where there are no
    names.

    Raises
    ------
    InputError
        If it does not hold three columns of numbers; a cell that is no number is named by its line.
    """
    import pandas as pd

    layout = _find_layout(path)
    try:
        table = _read_table(path, layout, [])
    except (pd.errors.ParserError, ValueError):
        comments = [i for i, line in enumerate(_lines(path)) if _is_comment(line)]
        try:
            table = _read_table(path, layout, comments)
        except (pd.errors.ParserError, ValueError) as error:
            raise _bad_line(path, layout) from error
    if not np.isfinite(table[:, :3]).all():
        raise _bad_line(path, layout)
    strength = as_strength(path, table[:, 3]) if len(layout.columns) > 3 else np.empty(0)
    points = np.ascontiguousarray(table[:, :3])
    return RawScan(points, strength, step=float32_step(points))


def _read_table(path: Path, layout: Layout, comments: list[int]) -> NDArray[np.float64]:
    """Columns x, y, z and maybe intensity; cells that are missing are NaN."""
    import pandas as pd

    table = pd.read_csv(
        path,
        sep=layout.separator,
        decimal=layout.decimal,
        header=None,
        usecols=sorted(layout.columns),
        skiprows=sorted({*range(layout.skip), *comments}) if comments else layout.skip,
        comment="#",  # one character only, so comments by // take a second attempt
        dtype=np.float64,
        index_col=False,
        skipinitialspace=True,
        encoding="utf-8-sig",
        encoding_errors="replace",
    )
    return table[list(layout.columns)].to_numpy()


def _find_layout(path: Path) -> Layout:
    """Find the separator, the columns and the first point."""
    names: list[str] = []
    hint: list[str] = []  # a comment that may name the columns
    counted = False
    for number, line in enumerate(islice(_lines(path), HEAD)):
        if "\0" in line:
            break
        if not line.strip():
            continue
        if _is_comment(line):
            hint = found if {"x", "y", "z"} <= set(found := _names(line)) else hint
            continue
        layout = _layout_of(line, number, names, hint)
        if layout is not None:
            return layout
        if not counted and not names and line.strip().isdecimal():
            counted = True  # the number of points
        elif names or re.search(r"(^|[\s,;])[-+.]?\d", line):
            msg = f"{path} is not a point cloud: {_not_numbers(number + 1, line)}"
            raise InputError(msg)
        else:
            names = _header(path, line)
    msg = f"{path} is not a point cloud: none of its first lines holds three numbers."
    raise InputError(msg)


def _layout_of(line: str, number: int, names: list[str], hint: list[str]) -> Layout | None:
    """Layout of a file whose first point is `line`; None if it is none.

    A header must name as many columns as there are; a comment that does not is only a comment.
    """
    for separator, decimal in DIALECTS:
        cells = _cells(line, separator)
        if names and len(names) != len(cells):
            continue
        columns = _columns(names or (hint if len(hint) == len(cells) else []))
        if _numbers(cells, columns, decimal) is not None:
            return Layout(separator, decimal, number, columns)
    return None


def _header(path: Path, line: str) -> list[str]:
    """Names of the columns; raise unless they say where x, y and z are."""
    names = _names(line)
    if len(names) < 3 or (len(names) > 3 and not {"x", "y", "z"} <= set(names)):
        msg = f"{path} is not a point cloud: the first line has no columns x, y and z: {line.strip()[:60]!r}."
        raise InputError(msg)
    return names


def _names(line: str) -> list[str]:
    """Names in a header, in small letters, without quotation marks and units in brackets."""
    text = re.sub(r"[\[(].*?[\])]", "", line.strip().lstrip("#/").strip().lower())
    separator = next((c for c in ";,\t" if c in text), None)
    return [name.strip(" \"'") for name in text.split(separator)]


def _columns(names: list[str]) -> tuple[int, ...]:
    """Columns of x, y, z and, where named, intensity."""
    if not {"x", "y", "z"} <= set(names):
        return (0, 1, 2)
    intensity = [names.index(name) for name in INTENSITY if name in names]
    return (names.index("x"), names.index("y"), names.index("z"), *intensity[:1])


def _cells(line: str, separator: str) -> list[str]:
    text = line.partition("#")[0].strip()
    cells = text.split() if separator == BLANKS else text.split(separator)
    if len(cells) > 1 and not cells[-1]:
        cells.pop()  # a separator at the end of each line
    return [cell.strip(" \"'") for cell in cells]


def _numbers(cells: list[str], columns: tuple[int, ...], decimal: str) -> list[float] | None:
    """Return the coordinates in a line; None if one is missing or no number."""
    try:
        texts = [cells[column] for column in columns[:3]]
        if decimal == ",":
            texts = [text.replace(",", ".") for text in texts]
        return [float(text) for text in texts]
    except (ValueError, IndexError):
        return None


def _bad_line(path: Path, layout: Layout) -> InputError:
    """Find the line that is to blame for a file that could not be read, or whose numbers are not finite."""
    bad: list[int] = []
    for number, line in enumerate(_lines(path)):
        if number < layout.skip or not line.strip() or _is_comment(line):
            continue
        numbers = _numbers(_cells(line, layout.separator), layout.columns, layout.decimal)
        if numbers is None:
            return InputError(f"{path}: {_not_numbers(number + 1, line)}")
        if not all(map(math.isfinite, numbers)):
            bad.append(number + 1)
    if not bad:
        return InputError(f"{path} cannot be read as columns of numbers: export it as plain x y z.")
    return InputError(
        f"{path}: {len(bad)} point{'s' * (len(bad) > 1)} with a coordinate that is NaN or infinite, "
        f"the first on line {bad[0]}: export without them."
    )


def _not_numbers(number: int, line: str) -> str:
    return f"line {number} does not hold three numbers, as a point needs: {line.strip()[:60]!r}."


def _lines(path: Path) -> Iterator[str]:
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        yield from file


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(("#", "//"))
