"""Words and numbers of a neutral file, with the line they stand on for messages."""

from collections.abc import Iterable
from typing import NoReturn

from fd2fem.errors import InputError

__all__ = ["Source"]


class Source:
    """Lines of a file, and their number for messages."""

    def __init__(self, name: str, lines: Iterable[str]) -> None:
        self._name = name
        self._lines = iter(lines)
        self._number = 0

    def line(self) -> str | None:
        """The next line, `None` at the end."""
        self._number += 1
        return next(self._lines, None)

    def words(self, count: int, what: str) -> list[str]:
        """Exactly `count` words, the last of which ends its line."""
        words: list[str] = []
        while len(words) < count:
            line = self.line()
            if line is None:
                self.fail(f"the file ends inside {what}")
            words += line.split()
        if len(words) > count:
            self.fail(f"{what} has more numbers than it announces")
        return words

    def ints(self, words: Iterable[str], what: str) -> list[int]:
        """Words as integers."""
        try:
            return [int(word) for word in words]
        except ValueError:
            self.fail(f"{what} needs integers here")

    def floats(self, words: Iterable[str], what: str) -> list[float]:
        """Words as floats."""
        try:
            return [float(word) for word in words]
        except ValueError:
            self.fail(f"{what} needs numbers here")

    def fail(self, reason: str) -> NoReturn:
        """Raise for the current line."""
        msg = f"{self._name}, line {self._number}: {reason}; write the neutral file anew."
        raise InputError(msg) from None
