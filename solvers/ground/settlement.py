"""Settlement of the ground: what moves the base of a wall.

The loads are displacements in the facade frame, m: x to the right, y into the wall, z up. They are pure
functions of the position, so that any share of a load is that share of its displacements.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, as_points, check_positive
from solvers.ground.limits import check_movement, check_profile
from solvers.ground.settlement_trough import (
    PeckTrough,
    SettlementTrough,
    settlement_trough,
    trough_displacement,
)
from solvers.ground.table import (
    LengthUnit,
    SettlementTable,
    check_covers,
    read_settlement_table,
    table_displacement,
)
from solvers.ground.trough import (
    Soil,
    horizontal_movement,
    horizontal_strain,
    max_settlement,
    settlement_slope,
    soil_trough_width,
    trough_settlement,
    trough_volume,
    trough_width,
)

__all__ = [
    "FunctionSettlement",
    "LengthUnit",
    "LinearSettlement",
    "PeckTrough",
    "Settlement",
    "SettlementTable",
    "SettlementTrough",
    "Soil",
    "base_displacement",
    "base_stations",
    "horizontal_movement",
    "horizontal_strain",
    "max_settlement",
    "read_settlement_table",
    "settlement_record",
    "settlement_slope",
    "settlement_trough",
    "soil_trough_width",
    "swap_horizontal",
    "trough_settlement",
    "trough_volume",
    "trough_width",
]

STATIONS = 1001
"""Positions at which a settlement's profile along the wall is looked at."""

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class LinearSettlement:
    """Base displacements that vary linearly between the wall's ends, m, positive up and to the right.

    The defaults are Building 1 of Truong-Hong & Laefer: the ground sinks and moves to -x, both most at
    the left end. The paper does not say at which end it moves most to the side: `swap_horizontal` gives
    the other reading.

    Attributes
    ----------
    vertical_left, vertical_right : float, m
    horizontal_left, horizontal_right : float, m

    Raises
    ------
    InputError
        If a value is not finite or larger than a metre.

    Examples
    --------
    >>> ends = base_displacement(LinearSettlement(), [0.0, 4.95], extent=(0.0, 4.95))
    >>> ends.tolist()
    [[-0.0283, 0.0, -0.0445], [-0.0177, 0.0, -0.0178]]
    """

    vertical_left: float = -0.0445
    vertical_right: float = -0.0178
    horizontal_left: float = -0.0283
    horizontal_right: float = -0.0177

    def __post_init__(self) -> None:
        for item in fields(self):
            check_movement(item.name, getattr(self, item.name))


def swap_horizontal(settlement: LinearSettlement) -> LinearSettlement:
    """The same settlement with the horizontal movements of its ends exchanged.

    Where a source prints the largest and the smallest horizontal movement without their places, one of
    the two readings stretches the base and the other presses it together.

    Examples
    --------
    >>> other = swap_horizontal(LinearSettlement())
    >>> other.vertical_left, other.horizontal_left, other.horizontal_right
    (-0.0445, -0.0177, -0.0283)
    """
    return replace(
        settlement,
        horizontal_left=settlement.horizontal_right,
        horizontal_right=settlement.horizontal_left,
    )


@dataclass(frozen=True)
class FunctionSettlement:
    """Base displacements by a function of one's own.

    Attributes
    ----------
    function : callable
        Takes positions along the wall, (n,), m, and returns displacements (n, 3), m, facade frame. It must
        give the same for the same position.

    Examples
    --------
    >>> def sag(x):
    ...     return np.column_stack([0 * x, 0 * x, -0.001 * x * (4 - x)])
    >>> base_displacement(FunctionSettlement(sag), [2.0], extent=(0.0, 4.0)).tolist()
    [[0.0, 0.0, -0.004]]
    """

    function: Callable[[FloatArray], ArrayLike]

    def __post_init__(self) -> None:
        if not callable(self.function):
            msg = f"Invalid 'function': expected a function of positions, got {self.function!r}."
            raise InputError(msg)


Settlement = LinearSettlement | SettlementTable | PeckTrough | SettlementTrough | FunctionSettlement
"""What can be imposed on the base."""


def base_displacement(
    settlement: Settlement, points: ArrayLike, *, extent: tuple[float, float]
) -> FloatArray:
    """Displacement of the base under a wall.

    Parameters
    ----------
    settlement : Settlement
    points : (n, 3) or (n,) array-like, m
        Points of the base, or only their positions along the wall, facade frame. Only the trough of a skew
        tunnel varies through the wall's thickness; without y it is taken in the plane y = 0.
    extent : (float, float), m
        Positions of the wall's left and right ends.

    Returns
    -------
    displacement : (n, 3) float array, m
        Facade frame.

    Raises
    ------
    InputError
        If `extent` is empty; if somewhere along it the base moves more than a tenth of the wall's length
        or a metre, or deforms by more than 5 %; or if a table does not reach both ends.
    """
    length = check_positive("extent", extent[1] - extent[0])
    if isinstance(settlement, SettlementTable):
        check_covers(settlement, extent)
    stations = base_stations(settlement, extent=extent)
    check_profile(stations, _displacement(settlement, _plan(stations), extent[0], length))
    return _displacement(settlement, _plan(points), extent[0], length)


def base_stations(settlement: Settlement, *, extent: tuple[float, float]) -> FloatArray:
    """Positions along the wall that show a settlement's profile: the rows of a table, or evenly spaced ones.

    Parameters
    ----------
    settlement : Settlement
    extent : (float, float), m
        Positions of the wall's left and right ends.

    Returns
    -------
    x : (n,) float array, m
        Ascending, both ends included.
    """
    left, right = extent
    if not isinstance(settlement, SettlementTable):
        return np.linspace(left, right, STATIONS)
    rows = np.array(settlement.x)
    return np.concatenate([[left], rows[(rows > left) & (rows < right)], [right]])


def settlement_record(settlement: Settlement) -> dict[str, Any]:
    """A settlement as JSON values; of a function only its name.

    Examples
    --------
    >>> settlement_record(SettlementTable(x=(0, 1), uz=(0, -0.001)))["uz"]
    [0.0, -0.001]
    """
    kind = {"kind": type(settlement).__name__}
    if isinstance(settlement, FunctionSettlement):
        return kind | {"function": getattr(settlement.function, "__qualname__", repr(settlement.function))}
    values = asdict(settlement).items()
    return kind | {name: list(value) if isinstance(value, tuple) else value for name, value in values}


def _plan(points: ArrayLike) -> FloatArray:
    """Points in plan, (n, 2); positions along the wall lie in the plane y = 0."""
    array: FloatArray = np.asarray(points, dtype=np.float64)
    if array.ndim == 1:
        x = as_array("points", array, (None,))
        return np.column_stack([x, np.zeros_like(x)])
    return as_points("points", array, dim=3)[:, :2]


def _displacement(settlement: Settlement, plan: FloatArray, left: float, length: float) -> FloatArray:
    """Displacement (n, 3), m, of points in plan, whatever its size."""
    x = plan[:, 0]
    if isinstance(settlement, LinearSettlement):
        return _linear_displacement(settlement, (x - left) / length)
    if isinstance(settlement, SettlementTable):
        return table_displacement(settlement, x)
    if isinstance(settlement, FunctionSettlement):
        return as_array("settlement function", settlement.function(x), (len(x), 3))
    trough = settlement_trough(settlement) if isinstance(settlement, PeckTrough) else settlement
    return trough_displacement(trough, plan)


def _linear_displacement(settlement: LinearSettlement, share: FloatArray) -> FloatArray:
    """Displacement at a share of the wall's length from its left end."""
    across = (1 - share) * settlement.horizontal_left + share * settlement.horizontal_right
    up = (1 - share) * settlement.vertical_left + share * settlement.vertical_right
    return np.column_stack([across, np.zeros_like(share), up])
