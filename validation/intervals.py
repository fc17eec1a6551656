"""Mean, spread and confidence interval of errors: Appendix B of the paper, after Oberkampf & Barone."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array
from validation.criterion import check_fraction

__all__ = [
    "ConfidenceInterval",
    "mean_error",
    "normal_interval",
    "normal_interval_from_moments",
    "standard_deviation",
    "standard_uncertainty",
    "t_interval",
    "t_interval_from_moments",
]


@dataclass(frozen=True)
class ConfidenceInterval:
    """Where the mean of the population lies, with what confidence.

    `estimate`, `lower` and `upper` have the unit of the errors; `level` is the two-sided confidence
    level, `n` the number of values, `method` the distribution ("t" or "normal").
    """

    estimate: float
    lower: float
    upper: float
    level: float
    n: int
    method: str


def _as_errors(errors: ArrayLike) -> NDArray[np.float64]:
    """Check that there are at least two errors, all finite."""
    values: NDArray[np.float64] = as_array("errors", errors, (None,))
    _check_count(len(values))
    return values


def _check_count(n: int) -> None:
    if n < 2:
        msg = f"Invalid number of errors: a spread needs at least 2, got {n}."
        raise InputError(msg)


def mean_error(errors: ArrayLike) -> float:
    """Mean of (n,) errors: equation 11.

    Raises
    ------
    InputError
        If there are fewer than two errors, or one is not finite.
    """
    return float(_as_errors(errors).mean())


def standard_deviation(errors: ArrayLike) -> float:
    """Sample standard deviation of (n,) errors, with n - 1 in the denominator: equation 12.

    Raises
    ------
    InputError
        If there are fewer than two errors, or one is not finite.

    Examples
    --------
    >>> standard_deviation([1.0, 2.0, 3.0])
    1.0
    """
    return float(_as_errors(errors).std(ddof=1))


def standard_uncertainty(std: float, *, n: int) -> float:
    """Type A standard uncertainty of the mean of `n` errors, std / √n: equation 13.

    Raises
    ------
    InputError
        If `n` is less than 2, or `std` is negative or not finite.

    Examples
    --------
    Opening dimensions of the paper's Building 2, NS00 (table 3, mm):

    >>> round(standard_uncertainty(119.6, n=16), 1)
    29.9
    """
    _check_count(n)
    if not (math.isfinite(std) and std >= 0.0):
        msg = f"Invalid 'std': expected a finite number, 0 or more, got {std}."
        raise InputError(msg)
    return float(std / math.sqrt(n))


def t_interval_from_moments(mean: float, std: float, *, n: int, level: float = 0.90) -> ConfidenceInterval:
    """Interval of Student's t distribution with n - 1 degrees of freedom: equation 9.

    Parameters
    ----------
    mean, std : float
        Mean and sample standard deviation of the errors, in one unit.
    n : int
        Number of errors, at least 2.
    level : float
        Two-sided confidence level, between 0 and 1.

    Raises
    ------
    InputError
        If an argument is out of its range.

    Examples
    --------
    Opening dimensions of the paper's Building 2, S50 (table 3, mm):

    >>> interval = t_interval_from_moments(-0.4, 132.9, n=16)
    >>> round(interval.lower, 1), round(interval.upper, 1)
    (-58.6, 57.8)
    """
    from scipy.special import stdtrit

    _check_count(n)
    quantile = float(stdtrit(n - 1, 0.5 * (1.0 + check_fraction("level", level))))
    return _interval(mean, quantile * standard_uncertainty(std, n=n), level=level, n=n, method="t")


def normal_interval_from_moments(
    mean: float, std: float, *, n: int, level: float = 0.90
) -> ConfidenceInterval:
    """Interval of the normal distribution: equation 8, for n > 40; arguments as the t interval's.

    Raises
    ------
    InputError
        If an argument is out of its range.
    """
    from scipy.special import ndtri

    quantile = float(ndtri(0.5 * (1.0 + check_fraction("level", level))))
    return _interval(mean, quantile * standard_uncertainty(std, n=n), level=level, n=n, method="normal")


def _interval(mean: float, half_width: float, *, level: float, n: int, method: str) -> ConfidenceInterval:
    if not math.isfinite(mean):
        msg = f"Invalid 'mean': expected a finite number, got {mean}."
        raise InputError(msg)
    return ConfidenceInterval(float(mean), mean - half_width, mean + half_width, level, n, method)


def t_interval(errors: ArrayLike, *, level: float = 0.90) -> ConfidenceInterval:
    """Interval of the mean of (n,) errors by Student's t: equation 9; good from two errors on.

    Raises
    ------
    InputError
        If there are fewer than two errors, one is not finite, or `level` is not between 0 and 1.
    """
    values = _as_errors(errors)
    return t_interval_from_moments(mean_error(values), standard_deviation(values), n=len(values), level=level)


def normal_interval(errors: ArrayLike, *, level: float = 0.90) -> ConfidenceInterval:
    """Interval of the mean of (n,) errors by the normal distribution: equation 8; for n > 40.

    Raises
    ------
    InputError
        If there are fewer than two errors, one is not finite, or `level` is not between 0 and 1.
    """
    values = _as_errors(errors)
    return normal_interval_from_moments(
        mean_error(values), standard_deviation(values), n=len(values), level=level
    )
