"""Settlement of the ground: the Gaussian trough over a tunnel, and what moves the base of a wall.

The trough's equations follow Peck (1969) [1]_, its width O'Reilly & New (1982) [2]_, the horizontal
movement their assumption that the ground moves towards the tunnel's axis. In them `x` is the distance
from the axis, m, and the settlement S counts downwards. The loads, by contrast, are displacements in
the facade frame: z up, x to the right.

References
----------
.. [1] R. B. Peck, "Deep excavations and tunneling in soft ground", 7th ICSMFE, Mexico City, 1969.
.. [2] M. P. O'Reilly, B. M. New, "Settlements above tunnels in the United Kingdom", Tunnelling '82.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, check_positive

__all__ = [
    "LinearSettlement",
    "PeckTrough",
    "Settlement",
    "base_displacement",
    "horizontal_movement",
    "horizontal_strain",
    "max_settlement",
    "settlement_slope",
    "trough_settlement",
    "trough_volume",
    "trough_width",
]

LARGEST_DISPLACEMENT = 1.0
"""A base that moves more than this, m, was given in another unit."""

LARGEST_SHARE = 0.1
"""A base that moves more than this share of the wall's length was given in another unit."""

LARGEST_VOLUME_LOSS = 0.2
"""A volume loss over this was given in per cent."""

FloatArray = NDArray[np.float64]


def trough_width(depth: float, *, k: float = 0.5) -> float:
    """Distance i of the trough's inflection from the axis, m: i = K z0 (O'Reilly & New 1982).

    Parameters
    ----------
    depth : float, m
        Depth z0 of the tunnel's axis.
    k : float
        Trough width parameter: 0.4 to 0.6 in clay, 0.25 to 0.45 in sand.

    Examples
    --------
    >>> trough_width(15.0, k=0.5)
    7.5
    """
    return k * depth


def trough_volume(volume_loss: float, diameter: float) -> float:
    """Volume of the trough per metre of tunnel, m³/m: Vs = VL π D² / 4.

    Examples
    --------
    >>> round(trough_volume(0.01, 6.0), 6)
    0.282743
    """
    return volume_loss * np.pi * diameter**2 / 4


def max_settlement(volume: float, width: float) -> float:
    """Settlement over the axis, m, from Vs = √(2π) i Smax.

    Examples
    --------
    >>> round(max_settlement(0.282743339, 7.5), 8)
    0.01503977
    """
    return float(volume / (np.sqrt(2 * np.pi) * width))


def trough_settlement(x: ArrayLike, *, smax: float, width: float) -> FloatArray:
    """Settlement, m, downwards: S = Smax exp(-x² / 2i²) (Peck 1969)."""
    distance: FloatArray = np.asarray(x, dtype=np.float64)
    return np.asarray(smax * np.exp(-(distance**2) / (2 * width**2)), dtype=np.float64)


def settlement_slope(x: ArrayLike, *, smax: float, width: float) -> FloatArray:
    """Slope dS/dx = -S x / i²; its magnitude is largest, 0.6065 Smax / i, at x = ± i."""
    distance: FloatArray = np.asarray(x, dtype=np.float64)
    return -trough_settlement(distance, smax=smax, width=width) * distance / width**2


def horizontal_movement(x: ArrayLike, *, smax: float, width: float, depth: float) -> FloatArray:
    """Movement along +x, m, of ground that moves towards the tunnel's axis: -S x / z0.

    Its magnitude is largest, 0.6065 Smax i / z0, at x = ± i.
    """
    distance: FloatArray = np.asarray(x, dtype=np.float64)
    return -trough_settlement(distance, smax=smax, width=width) * distance / depth


def horizontal_strain(x: ArrayLike, *, smax: float, width: float, depth: float) -> FloatArray:
    """Derivative of `horizontal_movement`, tension positive: -(Smax / z0)(1 - x²/i²) exp(-x² / 2i²).

    It runs from -Smax / z0 over the axis to 0.4463 Smax / z0 at x = ± √3 i.
    """
    distance: FloatArray = np.asarray(x, dtype=np.float64)
    S = trough_settlement(distance, smax=smax, width=width)
    return -S * (1 - distance**2 / width**2) / depth


@dataclass(frozen=True)
class LinearSettlement:
    """Base displacements that vary linearly between the wall's ends, m, positive up and to the right.

    The defaults are Building 1 of Truong-Hong & Laefer: the ground sinks and moves to -x, both most at
    the left end.

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
            value = getattr(self, item.name)
            if not abs(value) <= LARGEST_DISPLACEMENT:
                msg = f"Invalid '{item.name}': {value} m is no settlement of a wall; give metres."
                raise InputError(msg)


@dataclass(frozen=True)
class PeckTrough:
    """The Gaussian trough over a tunnel that runs square to the wall.

    Attributes
    ----------
    volume_loss : float
        Ground lost over the tunnel's cross-section: 0.01 is 1 %.
    diameter, depth : float, m
        Of the tunnel and of its axis under the base.
    k : float
        Trough width parameter K of i = K z0.
    centre : float, m
        Where along the wall the axis lies, facade frame.

    Raises
    ------
    InputError
        If a value is out of its range, or the tunnel would reach the base.
    """

    volume_loss: float
    diameter: float
    depth: float
    k: float = 0.5
    centre: float = 0.0

    def __post_init__(self) -> None:
        for name in ("diameter", "depth", "k"):
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
        if not np.isfinite(self.centre):
            msg = f"Invalid 'centre': expected a finite number, got {self.centre}."
            raise InputError(msg)


Settlement = LinearSettlement | PeckTrough
"""What can be imposed on the base."""


def base_displacement(settlement: Settlement, x: ArrayLike, *, extent: tuple[float, float]) -> FloatArray:
    """Displacement of the base under a wall.

    Parameters
    ----------
    settlement : Settlement
    x : (n,) array-like, m
        Positions along the wall, facade frame.
    extent : (float, float), m
        Positions of the wall's left and right ends.

    Returns
    -------
    displacement : (n, 3) float array, m
        Facade frame; nothing moves along y.

    Raises
    ------
    InputError
        If `extent` is empty, or the base moves more than a tenth of the wall's length or a metre.
    """
    x = as_array("x", x, (None,))
    left, right = extent
    length = check_positive("extent", right - left)
    displacement = np.zeros((len(x), 3))
    if isinstance(settlement, LinearSettlement):
        share = (x - left) / length
        ends = settlement.horizontal_left, settlement.horizontal_right
        displacement[:, 0] = (1 - share) * ends[0] + share * ends[1]
        ends = settlement.vertical_left, settlement.vertical_right
        displacement[:, 2] = (1 - share) * ends[0] + share * ends[1]
    else:
        distance = x - settlement.centre
        width = trough_width(settlement.depth, k=settlement.k)
        smax = max_settlement(trough_volume(settlement.volume_loss, settlement.diameter), width)
        displacement[:, 0] = horizontal_movement(distance, smax=smax, width=width, depth=settlement.depth)
        displacement[:, 2] = -trough_settlement(distance, smax=smax, width=width)
    largest = float(np.abs(displacement).max(initial=0.0))
    if largest > min(LARGEST_DISPLACEMENT, LARGEST_SHARE * length):
        msg = f"The base of a wall of {length:.4g} m would move {largest:.4g} m: check the settlement's unit."
        raise InputError(msg)
    return displacement
