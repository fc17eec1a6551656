"""Drawings that stand in for the three buildings of the paper.

The paper gives their length, height, number and area of openings and the smallest opening dimension
(Table 2 and section 3); the positions are not published and are made up here.
"""

from importlib.resources import files

from fd2fem.drawings.facade_toml import facade_from_toml
from fd2fem.errors import InputError
from fd2fem.model import Facade

__all__ = ["STAND_INS", "stand_in"]

STAND_INS = ("building1", "building2", "building3")


def stand_in(name: str) -> Facade:
    """One of the drawings in `STAND_INS`.

    Raises
    ------
    InputError
        If there is none of that name.

    Examples
    --------
    >>> facade = stand_in("building1")
    >>> facade.length, facade.height, len(facade.openings), round(facade.opening_area, 3)
    (4.95, 12.16, 4, 30.699)
    """
    if name not in STAND_INS:
        msg = f"there is no stand-in '{name}': choose {', '.join(STAND_INS)}."
        raise InputError(msg)
    text = (files("fd2fem.drawings") / "data" / f"{name}.toml").read_text(encoding="utf-8")
    return facade_from_toml(text, source=f"{name}.toml")
