"""Settlement of a wall's base as a table of measured or computed movements."""

import re
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array
from solvers.ground.limits import check_movement

__all__ = ["LengthUnit", "SettlementTable", "check_covers", "read_settlement_table", "table_displacement"]

COLUMNS = ("x", "ux", "uy", "uz")
NEEDED = ("x", "uz")

BASE_MISFIT = 0.005
"""How far a table may end short of the wall, relative to the wall's length: a scan makes a wall some
millimetres longer than the drawing that the table was made for. Beyond its ends the ground moves as there."""

HEADING = re.compile(r"(?P<name>[a-z]+)(?:[\[(](?P<unit>m|mm)[\])])?")

FloatArray = NDArray[np.float64]


class LengthUnit(StrEnum):
    """Unit of a table's movements."""

    METRE = "m"
    MILLIMETRE = "mm"


METRES = {LengthUnit.METRE: 1.0, LengthUnit.MILLIMETRE: 1e-3}


@dataclass(frozen=True)
class SettlementTable:
    """Movements of the base at positions along the wall, linear between them; facade frame.

    Attributes
    ----------
    x : tuple of float, m
        Positions along the wall, ascending, at least two. They must reach from one end of the base to the
        other.
    uz : tuple of float, m
        Upwards: settlements are negative.
    ux, uy : tuple of float, m
        To the right and into the wall; left out, nothing moves that way.

    Raises
    ------
    InputError
        If the columns differ in length, positions do not ascend, a value is not finite, or a movement is
        larger than a metre.

    Examples
    --------
    >>> SettlementTable(x=(0, 5), uz=(-0.02, -0.01)).ux
    (0.0, 0.0)
    """

    x: tuple[float, ...]
    uz: tuple[float, ...]
    ux: tuple[float, ...] = ()
    uy: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in COLUMNS:
            values = getattr(self, name)
            if name not in NEEDED and len(values) == 0:
                values = [0.0] * len(self.x)
            column = as_array(name, values, (None,))
            if len(column) != len(self.x):
                msg = f"Invalid '{name}': {len(column)} values for {len(self.x)} positions x."
                raise InputError(msg)
            object.__setattr__(self, name, tuple(column.tolist()))
        if len(self.x) < 2:
            msg = f"Invalid 'x': a settlement table needs at least 2 rows, got {len(self.x)}."
            raise InputError(msg)
        for row, (before, after) in enumerate(zip(self.x, self.x[1:], strict=False), start=2):
            if after <= before:
                msg = f"Invalid 'x': positions must ascend, but row {row} has {after} m after {before} m."
                raise InputError(msg)
        for name in COLUMNS[1:]:
            for row, value in enumerate(getattr(self, name), start=1):
                check_movement(f"{name} of row {row}", value)


def check_covers(table: SettlementTable, extent: tuple[float, float]) -> None:
    """Refuse a table that does not reach both ends of the base.

    Raises
    ------
    InputError
        With what the table covers and what it should.
    """
    left, right = extent
    slack = BASE_MISFIT * (right - left)
    if table.x[0] > left + slack or table.x[-1] < right - slack:
        msg = (
            f"The settlement table covers x = {table.x[0]:.6g} to {table.x[-1]:.6g} m, but the wall's base "
            f"runs from {left:.6g} to {right:.6g} m: add rows for its ends."
        )
        raise InputError(msg)


def table_displacement(table: SettlementTable, x: FloatArray) -> FloatArray:
    """Displacement at positions along the wall, linear between the rows.

    Parameters
    ----------
    table : SettlementTable
    x : (n,) float array, m

    Returns
    -------
    displacement : (n, 3) float array, m
    """
    return np.column_stack([np.interp(x, table.x, getattr(table, name)) for name in COLUMNS[1:]])


def read_settlement_table(path: Path, *, unit: LengthUnit = LengthUnit.METRE) -> SettlementTable:
    """Read a table of movements from a text file.

    The first line names the columns, ``x``, ``uz`` and, if there are, ``ux``, ``uy``, in any order; columns
    are parted by semicolons (then a comma may be the decimal mark), commas, or blanks. What follows ``#``
    is a comment. A column's heading may give its unit: ``uz [mm]``.

    Parameters
    ----------
    path : Path
    unit : LengthUnit
        Of the movements whose heading gives none; ``x`` is in metres unless its own heading says otherwise.

    Returns
    -------
    table : SettlementTable

    Raises
    ------
    InputError
        If the file cannot be read, lacks a column or has one that is not known, holds something that is
        not a number, or is no table of a settlement.
    """
    (number, heading), *lines = _lines(path)
    # The unit belongs to its heading, also where blanks part the columns.
    heading = re.sub(r"\s+(?=[\[(])", "", heading.lower())
    separator = next((mark for mark in ";," if mark in heading), None)
    units = _columns(_cells(heading, separator), unit, f"{path}, line {number}")
    rows = [_row(_cells(text, separator), separator, len(units), f"{path}, line {at}") for at, text in lines]
    values = {name: [row[k] * METRES[units[name]] for row in rows] for k, name in enumerate(units)}
    try:
        return SettlementTable(**{name: tuple(column) for name, column in values.items()})
    except InputError as error:
        msg = f"{path}: {error}"
        raise InputError(msg) from error


def _lines(path: Path) -> list[tuple[int, str]]:
    """Lines that hold something, at least one, without comments, and their numbers."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        msg = f"Cannot read the settlement table {path}: {error.strerror}."
        raise InputError(msg) from error
    except UnicodeDecodeError as error:
        msg = f"The settlement table {path} is not text in UTF-8."
        raise InputError(msg) from error
    kept = ((number, line.partition("#")[0].strip()) for number, line in enumerate(text.split("\n"), start=1))
    lines = [(number, line) for number, line in kept if line]
    if not lines:
        msg = f"The settlement table {path} is empty."
        raise InputError(msg)
    return lines


def _cells(line: str, separator: str | None) -> list[str]:
    return [cell.strip().strip('"').strip() for cell in line.split(separator)]


def _columns(headings: list[str], unit: LengthUnit, where: str) -> dict[str, LengthUnit]:
    """Units by the names of the columns, in their order."""
    units: dict[str, LengthUnit] = {}
    for heading in headings:
        match = HEADING.fullmatch(heading)
        if match is None or match["name"] not in COLUMNS or match["name"] in units:
            msg = (
                f"{where}: unknown or repeated column '{heading}'; "
                "expected x, ux, uy, uz, with [m], [mm] or no unit."
            )
            raise InputError(msg)
        name = match["name"]
        units[name] = LengthUnit(match["unit"] or (LengthUnit.METRE if name == "x" else unit))
    for name in NEEDED:
        if name not in units:
            msg = f"{where}: the settlement table has no column '{name}'."
            raise InputError(msg)
    return units


def _row(cells: list[str], separator: str | None, count: int, where: str) -> list[float]:
    """The numbers of a row."""
    if len(cells) != count:
        msg = f"{where}: {len(cells)} values, expected {count}."
        raise InputError(msg)
    try:
        return [float(cell.replace(",", ".") if separator == ";" else cell) for cell in cells]
    except ValueError as error:
        msg = f"{where}: {error}."
        raise InputError(msg) from error
