"""The Gaussian trough over a tunnel.

Its equations follow Peck (1969) [1]_, its width O'Reilly & New (1982) [2]_, the horizontal movement their
assumption that the ground moves towards the tunnel's axis. In them `x` is the distance from the axis, m,
and the settlement S counts downwards.

References
----------
.. [1] R. B. Peck, "Deep excavations and tunneling in soft ground", 7th ICSMFE, Mexico City, 1969.
.. [2] M. P. O'Reilly, B. M. New, "Settlements above tunnels in the United Kingdom", Tunnelling '82.
"""

from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Soil",
    "across_axis",
    "axis_distance",
    "horizontal_movement",
    "horizontal_strain",
    "max_settlement",
    "settlement_slope",
    "soil_trough_width",
    "trough_settlement",
    "trough_volume",
    "trough_width",
]

FloatArray = NDArray[np.float64]


class Soil(StrEnum):
    """Ground for which O'Reilly & New fitted the trough's width to measurements."""

    CLAY = "clay"
    SAND = "sand"


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


def soil_trough_width(depth: float, *, soil: Soil) -> float:
    """Distance i of the trough's inflection from the axis, m, by the regressions of O'Reilly & New (1982).

    i = 0.43 z0 + 1.1 in clay, i = 0.28 z0 - 0.1 in sand, z0 and i in metres.

    Parameters
    ----------
    depth : float, m
        Depth z0 of the tunnel's axis.
    soil : Soil

    Examples
    --------
    >>> [round(soil_trough_width(15.0, soil=soil), 2) for soil in Soil]
    [7.55, 4.1]
    """
    return 0.43 * depth + 1.1 if soil is Soil.CLAY else 0.28 * depth - 0.1


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


def across_axis(skew: float) -> FloatArray:
    """Horizontal unit vector (x, y) across a tunnel whose axis makes an angle with the wall's normal.

    Seen from above, with x to the right along the wall and y up the page into it, the tunnel runs along
    t = (sin ω, cos ω): with ω = 0 square to the wall, with ω > 0 turned clockwise, towards +x. What is
    square to t and becomes +x at ω = 0 is n = (cos ω, -sin ω).

    Parameters
    ----------
    skew : float, degrees
        The angle ω.

    Returns
    -------
    normal : (2,) float array

    Examples
    --------
    >>> across_axis(30.0).round(4).tolist()
    [0.866, -0.5]
    """
    angle = np.deg2rad(skew)
    return np.array([np.cos(angle), -np.sin(angle)])


def axis_distance(points: ArrayLike, *, centre: float, offset: float, skew: float) -> FloatArray:
    """Distance d of points from a tunnel's axis in plan, m: d = (x - centre) cos ω - y sin ω + offset.

    With n of `across_axis`, d = (p - p0) · n + offset: the point p0 = (centre, 0) of the wall lies `offset`
    from the axis, on the side of n. For a distance d the ground moves by -S d / z0 along n, which is
    ux = -(S d / z0) cos ω and uy = +(S d / z0) sin ω. For example: a tunnel at ω = 45° passes under
    (0, 0) towards (1, 1); (1, 0) lies to its right, d > 0, and moves to the left and into the wall.

    Parameters
    ----------
    points : (n, 2) array-like, m
        x along the wall, y into it.
    centre : float, m
    offset : float, m
    skew : float, degrees

    Returns
    -------
    distance : (n,) float array, m

    Examples
    --------
    >>> axis_distance([[1.0, 0.0], [0.0, 1.0]], centre=0.0, offset=0.0, skew=45.0).round(4).tolist()
    [0.7071, -0.7071]
    """
    plan: FloatArray = np.asarray(points, dtype=np.float64)
    return np.asarray((plan - [centre, 0.0]) @ across_axis(skew) + offset, dtype=np.float64)
