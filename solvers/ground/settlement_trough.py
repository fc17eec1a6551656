"""Settlement of a wall's base in the trough over a tunnel that passes it at any angle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive
from solvers.ground.limits import check_movement
from solvers.ground.trough import (
    Soil,
    across_axis,
    axis_distance,
    horizontal_movement,
    max_settlement,
    soil_trough_width,
    trough_settlement,
    trough_volume,
    trough_width,
)

__all__ = ["PeckTrough", "SettlementTrough", "settlement_trough", "trough_displacement"]

LARGEST_VOLUME_LOSS = 0.2
"""A volume loss over this was given in per cent."""

USUAL_K = 0.5
"""Trough width parameter where neither it nor a soil is given (Peck's usual value for clay)."""

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class SettlementTrough:
    """The Gaussian trough over a tunnel, by its measures.

    Attributes
    ----------
    smax : float, m
        Settlement over the axis, downwards.
    width : float, m
        Distance i of the inflection from the axis.
    depth : float, m
        Of the tunnel's axis under the base, to which the ground moves.
    centre : float, m
        Where along the wall the axis passes under the plane y = 0, facade frame.
    skew : float, degrees
        Angle from the wall's normal to the tunnel's axis, -90 to 90, clockwise seen from above: 0 is a
        tunnel square to the wall, 90 one along it.
    offset : float, m
        Distance from the axis to the point (`centre`, 0) of the wall, square to the axis: positive where
        `centre` lies to the right of it, seen along the tunnel into the wall; at a skew of 90°, where the
        tunnel runs behind the wall.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    smax: float
    width: float
    depth: float
    centre: float = 0.0
    skew: float = 0.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        for name in ("width", "depth"):
            check_positive(name, getattr(self, name))
        check_movement("smax", self.smax)
        if self.smax < 0.0:
            msg = f"Invalid 'smax': expected a settlement, which counts downwards, got {self.smax} m."
            raise InputError(msg)
        _check_position(self.centre, self.skew, self.offset)


@dataclass(frozen=True)
class PeckTrough:
    """The Gaussian trough over a tunnel, by the tunnel and the ground it loses.

    Attributes
    ----------
    volume_loss : float
        Ground lost over the tunnel's cross-section: 0.01 is 1 %.
    diameter, depth : float, m
        Of the tunnel and of its axis under the base.
    k : float or None
        Trough width parameter K of i = K z0; 0.5 where neither it nor `soil` is given.
    centre : float, m
        Where along the wall the axis passes under the plane y = 0, facade frame.
    skew : float, degrees
        Angle from the wall's normal to the tunnel's axis, -90 to 90; see `SettlementTrough`.
    offset : float, m
        Distance from the axis to the point (`centre`, 0) of the wall; see `SettlementTrough`.
    soil : Soil or None
        Takes the width from O'Reilly & New's regression for this soil, instead of from `k`.

    Raises
    ------
    InputError
        If a value is out of its range, both `k` and `soil` are given, or the tunnel would reach the base.
    """

    volume_loss: float
    diameter: float
    depth: float
    k: float | None = None
    centre: float = 0.0
    skew: float = 0.0
    offset: float = 0.0
    soil: Soil | None = None

    def __post_init__(self) -> None:
        if self.k is None and self.soil is None:
            object.__setattr__(self, "k", USUAL_K)
        for name in ("diameter", "depth"):
            check_positive(name, getattr(self, name))
        if not 0.0 <= self.volume_loss <= LARGEST_VOLUME_LOSS:
            msg = (
                f"Invalid 'volume_loss': expected a fraction between 0 and {LARGEST_VOLUME_LOSS} "
                f"(0.01 is 1 %), got {self.volume_loss}."
            )
            raise InputError(msg)
        if self.depth <= self.diameter / 2:
            msg = (
                f"Invalid 'depth': a tunnel of {self.diameter} m with its axis at {self.depth} m "
                "reaches the base."
            )
            raise InputError(msg)
        _check_position(self.centre, self.skew, self.offset)
        _peck_width(self)


def _check_position(centre: float, skew: float, offset: float) -> None:
    for name, value in (("centre", centre), ("offset", offset)):
        if not np.isfinite(value):
            msg = f"Invalid '{name}': expected a finite number, got {value}."
            raise InputError(msg)
    if not abs(skew) <= 90.0:
        msg = f"Invalid 'skew': expected an angle between -90 and 90 degrees, got {skew}."
        raise InputError(msg)


def _peck_width(trough: PeckTrough) -> float:
    """The width i, m, by `k` or by the soil, whichever the record has."""
    if trough.soil is None and trough.k is not None:
        return trough_width(trough.depth, k=check_positive("k", trough.k))
    if trough.soil is None or trough.k is not None:
        msg = f"Give either k or soil of a trough, not both: k = {trough.k}, soil = {trough.soil}."
        raise InputError(msg)
    width = soil_trough_width(trough.depth, soil=Soil(trough.soil))
    if width <= 0.0:
        msg = f"Invalid 'depth': {trough.depth} m is too shallow for the width of a trough in {trough.soil}."
        raise InputError(msg)
    return width


def settlement_trough(trough: PeckTrough) -> SettlementTrough:
    """The measures of the trough over a tunnel.

    Examples
    --------
    >>> trough = settlement_trough(PeckTrough(volume_loss=0.01, diameter=6.0, depth=15.0))
    >>> round(trough.smax, 8), trough.width
    (0.01503977, 7.5)
    """
    width = _peck_width(trough)
    return SettlementTrough(
        smax=max_settlement(trough_volume(trough.volume_loss, trough.diameter), width),
        width=width,
        depth=trough.depth,
        centre=trough.centre,
        skew=trough.skew,
        offset=trough.offset,
    )


def trough_displacement(trough: SettlementTrough, points: FloatArray) -> FloatArray:
    """Displacement of the ground: -S along z, and -S d / z0 across the tunnel, towards its axis.

    Parameters
    ----------
    trough : SettlementTrough
    points : (n, 2) float array, m
        x along the wall, y into it.

    Returns
    -------
    displacement : (n, 3) float array, m
        Facade frame.
    """
    distance = axis_distance(points, centre=trough.centre, offset=trough.offset, skew=trough.skew)
    across = horizontal_movement(distance, smax=trough.smax, width=trough.width, depth=trough.depth)
    down = trough_settlement(distance, smax=trough.smax, width=trough.width)
    return np.column_stack([across[:, None] * across_axis(trough.skew), -down])
