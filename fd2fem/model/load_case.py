"""What a mesh needs beside its elements to be analysed: material, self-weight, movement of its base."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive

__all__ = ["LoadCase"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A settlement of a wall of one elastic material, for the files of other programs.

    Attributes
    ----------
    young : float, Pa
    poisson : float
    density : float, kg/m³
    gravity : float, m/s²
        Downwards; 0 leaves self-weight out.
    base : callable
        Displacements (k, 3), m, of points (k, 3), m, of the base; facade frame.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    young: float
    poisson: float
    density: float
    gravity: float
    base: Callable[[FloatArray], FloatArray]

    def __post_init__(self) -> None:
        check_positive("young", self.young)
        check_positive("density", self.density)
        if not 0.0 <= self.poisson < 0.5:
            msg = f"Invalid 'poisson': expected at least 0 and under 0.5, got {self.poisson}."
            raise InputError(msg)
        if not 0.0 <= self.gravity < np.inf:
            msg = f"Invalid 'gravity': expected 0 or a positive number, got {self.gravity}."
            raise InputError(msg)
