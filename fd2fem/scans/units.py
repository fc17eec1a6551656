"""The unit of length of a file of points: said by the user, by the file, or certain from its height."""

from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError

__all__ = ["Units", "check_height", "guess_units", "per_metre", "to_metres"]

TALLEST_M = 200.0
"""No wall, and no street around it, is taller, m."""
TALLEST_CM = 5_000.0
"""No wall that somebody measured in centimetres is taller, cm."""
TALLEST_MM = 200_000.0
TALLEST_SCENE = 1_000.0
"""No scan of a facade reaches higher, whatever its file says, m."""


class Units(StrEnum):
    """The unit of length of a file of points."""

    AUTO = "auto"
    M = "m"
    CM = "cm"
    MM = "mm"
    FT = "ft"
    US_FT = "us-ft"
    IN = "in"


METRES = {
    Units.M: (1.0, 1.0),
    Units.CM: (1.0, 100.0),
    Units.MM: (1.0, 1000.0),
    Units.FT: (0.3048, 1.0),
    Units.US_FT: (1200.0, 3937.0),
    Units.IN: (0.0254, 1.0),
}
"""Metres in a unit, as numerator and denominator: 1/1000 is no binary number, dividing by 1000 is exact."""


def to_metres(values: NDArray[np.float64], units: Units) -> NDArray[np.float64]:
    """Convert lengths to metres; metres come back as they are, not copied.

    Examples
    --------
    >>> to_metres(np.array([12160.0, 1.0]), Units.MM).tolist()
    [12.16, 0.001]
    """
    numerator, denominator = METRES[units]
    metres = values if numerator == 1.0 else values * numerator
    return metres if denominator == 1.0 else metres / denominator


def per_metre(units: Units) -> float:
    """How many of a unit make a metre."""
    numerator, denominator = METRES[units]
    return denominator / numerator


def guess_units(z: ArrayLike, *, source: str = "the scan") -> Units:
    """Tell metres from millimetres by the vertical extent of a scan.

    The extent runs from the 0.1th to the 99.9th percentile, so that stray returns from the sky do not
    count. Under 200 it is metres. From 5000 to 200,000 it is millimetres: 5 to 200 m, where centimetres
    would be 50 m or more. Between, several units make sense. Feet cannot be told from metres,
    nor inches: where a file is in these, only the user or the file can say so.

    Parameters
    ----------
    z : (n,) array-like, the file's units
    source : str
        What a message calls the scan.

    Returns
    -------
    units : Units
        `Units.M` or `Units.MM`.

    Raises
    ------
    InputError
        If the extent lies between 200 and 5000 or above 200,000.

    Examples
    --------
    >>> guess_units([0.0, 5.5, 12.1]).value
    'm'
    >>> guess_units([0.0, 5500.0, 12100.0]).value
    'mm'
    """
    extent = _extent(z)
    if extent < TALLEST_M:
        return Units.M
    if TALLEST_CM <= extent <= TALLEST_MM:
        return Units.MM
    meanings = [
        f"{extent * METRES[unit][0] / METRES[unit][1]:.3g} m if in {unit}"
        for unit in (Units.M, Units.CM, Units.MM, Units.FT, Units.IN)
    ]
    msg = f"{source} is {extent:.4g} high, {', '.join(meanings)}: say --units m, cm, mm, ft, us-ft or in."
    raise InputError(msg)


def check_height(z: ArrayLike, units: Units, *, source: str) -> None:
    """Raise if a scan is higher than any, in the unit that its format or its header says.

    Raises
    ------
    InputError
        If it reaches over more than 1000 m.
    """
    extent = _extent(z) / per_metre(units)
    if extent > TALLEST_SCENE:
        msg = (
            f"{source} is {extent:.4g} m high in the unit that it says it is in, {units}: "
            "if that is wrong, say --units m, cm, mm, ft, us-ft or in."
        )
        raise InputError(msg)


def _extent(z: ArrayLike) -> float:
    """Height over which all but 0.2 % of the points lie."""
    low, high = np.percentile(np.asarray(z, dtype=np.float64), [0.1, 99.9])
    return float(high - low)
