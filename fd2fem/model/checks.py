"""Checks that records and steps make on their arguments.

Each returns what it checked in the form that the code wants (float64, read-only), or raises
:class:`~fd2fem.errors.InputError` naming the argument, the rule and the given value.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError

__all__ = ["as_array", "as_points", "as_ring", "check_positive", "signed_area"]

FloatArray = NDArray[np.float64]

ONE_CORNER = 1e-7
"""Corners closer together than this are one, m: CAD programs tell no nearer points apart."""


def as_array(
    name: str, values: ArrayLike, shape: Sequence[int | None], *, dtype: type = np.float64
) -> NDArray[Any]:
    """Copy `values` into a read-only array of `dtype` and check its shape (``None``: any length).

    Raises
    ------
    InputError
        If the shape differs, or a float is not finite.

    Examples
    --------
    >>> as_array("origin", [1, 2, 3], (3,)).tolist()
    [1.0, 2.0, 3.0]
    """
    array: NDArray[Any] = np.array(values, dtype=dtype)
    if np.issubdtype(array.dtype, np.integer) and not np.array_equal(array, np.asarray(values)):
        msg = f"Invalid '{name}': expected whole numbers."
        raise InputError(msg)
    expected = tuple(shape)
    if array.ndim != len(expected) or any(
        want is not None and want != have for want, have in zip(expected, array.shape, strict=True)
    ):
        text = ", ".join("n" if want is None else str(want) for want in expected)
        msg = f"Invalid '{name}': expected shape ({text}), got {array.shape}."
        raise InputError(msg)
    if np.issubdtype(array.dtype, np.floating) and not np.isfinite(array).all():
        msg = f"Invalid '{name}': {int((~np.isfinite(array)).sum())} of {array.size} values are not finite."
        raise InputError(msg)
    array.setflags(write=False)
    return array


def as_points(name: str, points: ArrayLike, *, dim: int) -> FloatArray:
    """Copy `points` into a read-only (n, `dim`) float array.

    Raises
    ------
    InputError
        If the shape is another, or a coordinate is not finite.
    """
    array = np.asarray(points, dtype=np.float64)
    if array.size == 0:
        array = array.reshape(0, dim)
    return as_array(name, array, (None, dim))


def signed_area(ring: ArrayLike) -> float:
    """Area of a closed polygon, m², positive when it runs counter-clockwise.

    Parameters
    ----------
    ring : (k, 2) array-like, m
        Corners; the first is not repeated at the end.

    Examples
    --------
    >>> signed_area([[0, 0], [2, 0], [2, 1], [0, 1]])
    2.0
    """
    corners = np.asarray(ring, dtype=np.float64)
    # About its first corner: far from the origin, the products would lose digits.
    x, z = (corners - corners[0]).T
    return float(0.5 * np.sum(x * np.roll(z, -1) - np.roll(x, -1) * z))


def as_ring(name: str, ring: ArrayLike) -> FloatArray:
    """Copy a closed polygon into a read-only (k, 2) array, counter-clockwise, no corner repeated.

    Raises
    ------
    InputError
        If it has fewer than three corners, no area, or crosses or touches itself.
    """
    import shapely

    points = as_points(name, ring, dim=2)
    points = points[np.hypot(*(np.roll(points, -1, axis=0) - points).T) > ONE_CORNER]
    if len(points) < 3:
        msg = f"Invalid '{name}': a closed polygon needs at least 3 corners, got {len(points)}."
        raise InputError(msg)
    polygon = shapely.Polygon(points)
    if not polygon.is_valid or polygon.area <= 0.0:
        reason = shapely.is_valid_reason(polygon)
        msg = (
            f"Invalid '{name}': {reason}; expected a polygon with area that does not cross itself: "
            "correct its corners there."
        )
        raise InputError(msg)
    if signed_area(points) < 0.0:
        points = points[::-1]
    return as_points(name, points, dim=2)


def check_positive(name: str, value: float) -> float:
    """Return `value` as a float if it is a positive, finite number.

    Raises
    ------
    InputError
        If it is not.

    Examples
    --------
    >>> check_positive("thickness", 0.35)
    0.35
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not (np.isfinite(number) and number > 0.0):
        msg = f"Invalid '{name}': expected a positive number, got {value}."
        raise InputError(msg)
    return number
