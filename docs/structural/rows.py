"""A table of the page: what each line says, and where its targets come from."""

import json
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ORACLES = Path(__file__).parents[2] / "tests" / "oracles"

ROUND_OFF = 1e-12
"""Relative differences below this are none."""


@dataclass(frozen=True)
class Row:
    """One line of a table; `target` and `found` in the unit that `case` names.

    >>> print(Row("a beam, N", "Petersson", 200.0, 201.0))
    | a beam, N | Petersson | 200 | 201 | +0.5 % |
    """

    case: str
    source: str
    target: float
    found: float

    def __str__(self) -> str:
        difference = self.found - self.target
        told = f"{100 * difference / abs(self.target):+.2g} %" if self.target else f"{difference:.1g}"
        if abs(difference) <= ROUND_OFF * abs(self.target):
            told = "0"
        return f"| {self.case} | {self.source} | {self.target:.7g} | {self.found:.7g} | {told} |"


Rows = Iterator[Row]


def read_targets(name: str) -> dict[str, Any]:
    """Targets of a file in `tests/oracles`."""
    return tomllib.loads((ORACLES / f"{name}.toml").read_text(encoding="utf-8"))


def read_json(path: Path) -> dict[str, Any]:
    """Values of a file."""
    values: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return values


def table(rows: Iterable[Row]) -> str:
    """A table of Markdown."""
    head = "| Case | Source | Target | Ours | Difference |\n|---|---|---:|---:|---:|"
    return "\n".join([head, *map(str, rows)])
