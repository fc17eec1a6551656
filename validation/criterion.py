"""The 5 % criterion: relative error, what passes, and the sentence for what does not."""

import math
from dataclasses import dataclass

from fd2fem.errors import InputError

__all__ = ["ComparisonOptions", "check_fraction", "relative_error", "shortfall", "within_tolerance"]

ROUND_OFF = 1e-9
"""Relative slack on the tolerance, so that 4.2 m against 4.0 m passes at 5 % in floating point too."""


def check_fraction(name: str, value: float) -> float:
    """Return `value` if it lies between 0 and 1, both excluded.

    Raises
    ------
    InputError
        If it does not.
    """
    if not 0.0 < value < 1.0:
        msg = f"Invalid '{name}': expected a number between 0 and 1 (5 % is 0.05), got {value}."
        raise InputError(msg)
    return float(value)


@dataclass(frozen=True)
class ComparisonOptions:
    """How strictly two models are compared.

    Attributes
    ----------
    tolerance : float, default 0.05
        Largest relative difference that passes; 5 % is the paper's allowance for structural design.
    level : float, default 0.90
        Confidence level of the intervals of the openings' errors.

    Raises
    ------
    InputError
        If one of them does not lie between 0 and 1.
    """

    tolerance: float = 0.05
    level: float = 0.90

    def __post_init__(self) -> None:
        check_fraction("tolerance", self.tolerance)
        check_fraction("level", self.level)


def relative_error(candidate: float, reference: float) -> float | None:
    """(candidate - reference) / reference: equation 4, as a ratio; `None` where the reference is 0.

    Raises
    ------
    InputError
        If one of them is not finite.

    Examples
    --------
    The length of the paper's Building 1, scanned at full density against drawn:

    >>> round(relative_error(4.940, 4.950), 4)
    -0.002
    """
    for name, value in (("candidate", candidate), ("reference", reference)):
        if not math.isfinite(value):
            msg = f"Invalid '{name}': expected a finite number, got {value}; check the analysis it is from."
            raise InputError(msg)
    return (candidate - reference) / reference if reference else None


def within_tolerance(candidate: float, reference: float, *, tolerance: float) -> bool:
    """Whether the relative error is at most `tolerance` either way.

    Against a reference of 0 only 0 passes; what is not finite never does.

    Examples
    --------
    >>> within_tolerance(1.04, 1.0, tolerance=0.05), within_tolerance(0.94, 1.0, tolerance=0.05)
    (True, False)
    >>> within_tolerance(float("nan"), 1.0, tolerance=0.05)
    False
    """
    if not (math.isfinite(candidate) and math.isfinite(reference)):
        return False
    relative = relative_error(candidate, reference)
    return candidate == 0.0 if relative is None else abs(relative) <= tolerance * (1.0 + ROUND_OFF)


def shortfall(what: str, candidate: float, reference: float, *, tolerance: float, unit: str) -> str:
    """Sentence that says by how much a quantity misses the tolerance.

    Examples
    --------
    >>> shortfall("opening area", 6.372, 6.0, tolerance=0.05, unit="m²")
    'opening area is 6.2 % larger than the reference (tolerance 5 %): 6.372 against 6 m²'
    """
    relative = relative_error(candidate, reference)
    if relative is None:
        return f"{what} is {candidate:.4g} {unit} where the reference has none"
    side = "larger" if relative > 0.0 else "smaller"
    return (
        f"{what} is {100.0 * abs(relative):.3g} % {side} than the reference "
        f"(tolerance {100.0 * tolerance:.3g} %): {candidate:.4g} against {reference:.4g} {unit}"
    )
