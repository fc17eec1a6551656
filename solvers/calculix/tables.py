"""The tables of a ``.dat`` file of CalculiX."""

import re

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import NumericsError

__all__ = ["DIGITS", "last_table"]

DIGITS = 7
"""Significant digits that CalculiX prints in a ``.dat`` file. Its ``.frd`` file has no more: six as text,
single precision in its binary form."""

NO_LETTER = re.compile(r"(?<=\d)([+-]\d{3})(?!\d)")
"""Fortran leaves the E out before an exponent of three digits: 1.234567-101."""


def last_table(printed: str, name: str, *, columns: int) -> NDArray[np.float64]:
    r"""The last table of a quantity.

    Parameters
    ----------
    printed : str
        Text of the file.
    name : str
        How the quantity's heading begins.
    columns : int

    Returns
    -------
    table : (r, columns) float array

    Raises
    ------
    NumericsError
        If there is no such table, or it is not made of so many columns of finite numbers.

    Examples
    --------
    >>> text = " forces (fx,fy,fz) for set BASE and time  0.1E+01\n\n  7 -5.0E+00  1.5-101  2.0E+02\n\n"
    >>> last_table(text, "forces", columns=4).tolist()
    [[7.0, -5.0, 1.5e-101, 200.0]]
    """
    # Under the heading come an empty line, the rows and an empty line.
    heading = printed.rfind(f" {name} (")
    start = printed.find("\n\n", heading) + 2
    if heading < 0 or start < 2:
        msg = f"CalculiX printed no {name}: the deck must ask for them."
        raise NumericsError(msg)
    end = printed.find("\n\n", start)
    rows = printed[start : end if end >= 0 else None].splitlines()
    try:
        table = _numbers(rows)
    except ValueError as error:
        msg = f"CalculiX printed {name} that are no numbers ({error})."
        raise NumericsError(msg.replace("\n", " ")) from error
    if table.shape[1] != columns or not np.isfinite(table).all():
        msg = f"CalculiX printed {name} that are damaged or not finite: the analysis did not succeed."
        raise NumericsError(msg)
    return table


def _numbers(rows: list[str]) -> NDArray[np.float64]:
    """The rows as an array.

    Raises
    ------
    ValueError
        If there are none, their lengths differ, or they hold anything but numbers.
    """
    if not rows:
        msg = "no rows"
        raise ValueError(msg)
    try:
        return np.loadtxt(rows, ndmin=2, comments=None)
    except ValueError:
        return np.loadtxt([NO_LETTER.sub(r"E\1", row) for row in rows], ndmin=2, comments=None)
