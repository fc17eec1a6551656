"""What is still a settlement of a wall: larger movements were given in another unit, or mistyped."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError

__all__ = ["LARGEST_DISPLACEMENT", "LARGEST_GRADIENT", "LARGEST_SHARE", "check_movement", "check_profile"]

LARGEST_DISPLACEMENT = 1.0
"""A base that moves more than this, m, was given in another unit."""

LARGEST_SHARE = 0.1
"""A base that moves more than this share of the wall's length was given in another unit."""

LARGEST_GRADIENT = 0.05
"""A base that stretches, shears or slopes by more than this has no analysis by small displacements.

Turned by an angle θ, a body seems to such an analysis to shrink by θ²/2: at 0.05 that is 0.125 %, four
times the strain at which masonry cracks. Damage is called very severe from a strain of 0.3 % and a slope
of 1/50 on, so no wall that stands is refused.
"""

WINDOWS = 20
"""Parts of the wall over which the gradient is averaged: a step of the ground is no gradient without end."""


def check_movement(name: str, value: float) -> None:
    """Refuse a movement that is not a number or larger than a metre.

    Raises
    ------
    InputError
        Naming the movement and its value.
    """
    if not abs(value) <= LARGEST_DISPLACEMENT:
        msg = f"Invalid '{name}': {value} m is no settlement of a wall; give metres."
        raise InputError(msg)


def check_profile(x: NDArray[np.float64], displacement: NDArray[np.float64]) -> None:
    """Refuse a base that moves or deforms more than the ground under a standing wall can.

    Parameters
    ----------
    x : (n,) float array, m
        Stations from one end of the wall to the other, ascending.
    displacement : (n, 3) float array, m

    Raises
    ------
    InputError
        If the base moves more than a metre or a tenth of the wall's length, or if it stretches, shears or
        slopes by more than 5 % over a twentieth of that length.
    """
    length = float(x[-1] - x[0])
    largest = float(np.abs(displacement).max())
    if not largest <= min(LARGEST_DISPLACEMENT, LARGEST_SHARE * length):
        msg = f"The base of a wall of {length:.4g} m would move {largest:.4g} m: check the settlement's unit."
        raise InputError(msg)
    ends = np.linspace(x[0], x[-1], WINDOWS + 1)
    gradient = np.array([np.diff(np.interp(ends, x, u)) for u in displacement.T]) * WINDOWS / length
    axis, window = np.unravel_index(int(np.abs(gradient).argmax()), gradient.shape)
    steepest = float(gradient[axis, window])
    if abs(steepest) > LARGEST_GRADIENT:
        verb = ("stretch" if steepest > 0.0 else "shorten", "shear", "slope")[axis]
        msg = (
            f"The base would {verb} by {abs(steepest):.2g} between x = {ends[window]:.4g} and "
            f"{ends[window + 1]:.4g} m, more than {LARGEST_GRADIENT}: check the settlement's unit."
        )
        raise InputError(msg)
