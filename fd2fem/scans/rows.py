"""Rows of numbers in a text file, read in pieces: what PTS and PTX files are made of."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError

__all__ = ["Rows", "line_of"]

FloatArray = NDArray[np.float64]

USED = 4
"""Numbers of a line that are read: x, y, z, intensity."""
HEAD = 100
"""Lines that are looked at to see how many numbers they hold."""
CHUNK = 500_000
"""Lines that are read at a time."""


class Rows:
    """The lines of a text file that are not blank, as rows of four numbers, in their order.

    A row ends in NaN where its line holds fewer numbers.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.taken = 0
        self._chunks = _chunks(path)
        self._rest = np.empty((0, USED))

    def pieces(self, count: int) -> Iterator[FloatArray]:
        """Yield the next `count` rows, or as many as there are, in pieces of limited size.

        Raises
        ------
        InputError
            If one of the first four words of a line is no number.
        """
        while count > 0 and self._fill():
            piece, self._rest = self._rest[:count], self._rest[count:]
            count -= len(piece)
            self.taken += len(piece)
            yield piece

    def take(self, count: int) -> FloatArray:
        """Return the next `count` rows, or as many as there are, as a (k, 4) array."""
        return np.concatenate([np.empty((0, USED)), *self.pieces(count)])

    def at_end(self) -> bool:
        """Whether no row is left."""
        return not self._fill()

    def _fill(self) -> bool:
        """Read on if need be; whether there is a row."""
        if not len(self._rest):
            self._rest = next(self._chunks, self._rest)
        return len(self._rest) > 0


def _chunks(path: Path) -> Iterator[FloatArray]:
    import pandas as pd

    width = _width(path)
    options: dict[str, Any] = {
        "sep": r"\s+",
        "header": None,
        "names": range(width),
        "usecols": range(width),  # with these, whatever else a line holds is skipped
        "dtype": np.float64,
        "index_col": False,
        "encoding": "utf-8-sig",
        "encoding_errors": "replace",
        "quoting": 3,
        "chunksize": CHUNK,
    }
    try:
        with pd.read_csv(path, **options) as reader:
            for table in reader:
                rows = table.to_numpy()
                yield (
                    rows
                    if width == USED
                    else np.pad(rows, [(0, 0), (0, USED - width)], constant_values=np.nan)
                )
    except pd.errors.EmptyDataError:
        return
    except (pd.errors.ParserError, ValueError) as error:
        raise _not_numbers(path) from error


def _width(path: Path) -> int:
    """Numbers on the longest of the first lines, at most as many as are read."""
    return min(USED, max((len(line.split()) for _, line in islice(_lines(path), HEAD)), default=1))


def _not_numbers(path: Path) -> InputError:
    """Find the line that is to blame."""
    for number, line in _lines(path):
        words = line.split()
        if not _are_numbers(words[:USED]):
            text = line.strip()[:60]
            return InputError(
                f"{path} is damaged or not a point cloud: line {number} holds no numbers: {text!r}."
            )
    return InputError(f"{path} is not a point cloud: it cannot be read as lines of numbers.")


def _are_numbers(words: list[str]) -> bool:
    try:
        for word in words:
            float(word)
    except ValueError:
        return False
    return True


def line_of(path: Path, row: int) -> str:
    """Where and what a row is, for a message: its line, and what the line holds.

    Parameters
    ----------
    path : Path
    row : int
        From 0, blank lines not counted.
    """
    for index, (number, line) in enumerate(_lines(path)):
        if index == row:
            return f"line {number}, {line.strip()[:60]!r},"
    return "the end of the file"


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """The lines that are not blank, with their numbers from 1."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            if line.strip():
                yield number, line
