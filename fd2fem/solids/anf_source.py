"""The records of a neutral file as they stand there, with their line for messages."""

import re
from collections.abc import Iterator, Sequence
from itertools import chain, pairwise
from typing import Any, BinaryIO, NoReturn

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError

__all__ = ["Record", "integers", "reals", "records"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

# Line ends are searched for literally, which is several times faster than to have the pattern know lines.
HEAD = re.compile(rb"\n[ \t]*(?:kpt|lcurv|asurf|vbody)[ \t]*,", re.IGNORECASE)
OTHER = re.compile(rb"\n[ \t]*[^\s\d.+-]")
"""The end of a line before one that holds no numbers."""
BLOCK = 1 << 23
"""Bytes read at once: what bounds the memory."""


class Record:
    """One record: its command in lower case, the fields beside it, and the words on the lines after it.

    `what` is how messages call it: the command, until its number is known.
    """

    __slots__ = ("_name", "_number", "command", "fields", "what", "words")

    def __init__(self, name: str, number: int, text: bytes) -> None:
        self._name, self._number = name, number
        head = text.find(b"\n")
        identifier = text.find(b"\n", head + 1)  # the CAD identifier, on a line of its own
        command, *self.fields = text[: head if head >= 0 else None].split(b",")
        self.command = self.what = command.strip().lower().decode("ascii")
        if identifier < 0:
            self.fail(f"the file ends inside {self.what}")
        other = OTHER.search(text, identifier)
        self.words = text[identifier : other.start() if other else None].split()

    def check_size(self, size: int) -> None:
        """Raise unless there are `size` words."""
        if len(self.words) != size:
            amount = "fewer" if len(self.words) < size else "more"
            self.fail(f"{self.what} has {amount} numbers than it announces")

    def fail(self, reason: str) -> NoReturn:
        """Raise for the line with which this record begins."""
        msg = f"{self._name}, line {self._number}: {reason}; write the neutral file anew."
        raise InputError(msg) from None


def integers(members: Sequence[Record], words: Sequence[list[bytes]]) -> IntArray:
    """Words (n, k) of n records as integers."""
    return _numbers(members, words, int, "integers")


def reals(members: Sequence[Record], words: Sequence[list[bytes]]) -> FloatArray:
    """Words (n, k) of n records as floats."""
    return _numbers(members, words, float, "numbers")


def _numbers(
    members: Sequence[Record], words: Sequence[list[bytes]], kind: type[int | float], noun: str
) -> NDArray[Any]:
    """Words as numbers, all at once; only if that fails is it sought where."""
    try:
        values = list(map(kind, chain.from_iterable(words)))
        return np.array(values, dtype=np.intp if kind is int else np.float64).reshape(len(members), -1)
    except (ValueError, OverflowError):
        for record, part in zip(members, words, strict=True):
            try:
                np.array(list(map(kind, part)), dtype=np.intp if kind is int else np.float64)
            except (ValueError, OverflowError):
                record.fail(f"{record.what} needs {noun} here")
        raise


def records(name: str, file: BinaryIO) -> Iterator[Record]:
    """All KPT, LCURV, ASURF and VBODY of a file, in its order; other commands are passed over.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    file : binary file

    Raises
    ------
    InputError
        If the file is not plain text.
    """
    rest, number = b"\n", 0
    while block := file.read(BLOCK):
        if not block.isascii():
            msg = f"{name} is not a neutral file: it is not plain text."
            raise InputError(msg)
        text = rest + block
        starts = [match.start() for match in HEAD.finditer(text)]
        # The last record, or else the last line, may go on in the next block.
        starts = starts or [max(text.rfind(b"\n"), 0)]
        number += text.count(b"\n", 0, starts[0])
        for begin, end in pairwise(starts):
            yield Record(name, number + 1, text[begin + 1 : end + 1])
            number += text.count(b"\n", begin, end)
        rest = text[starts[-1] :]
    if HEAD.match(rest):
        yield Record(name, number + 1, rest[1:])
