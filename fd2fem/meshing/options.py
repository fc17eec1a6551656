"""How fine a mesh is to be, and how good it must be."""

from dataclasses import dataclass

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive

__all__ = ["DEFAULT_OPTIONS", "MeshOptions", "divisions"]

ROUND_UP_FROM = 0.37
"""Fraction of an element from which one more is made. Drawings are full of halves of the usual element
sizes (1.25 m at 0.1 m), where rounding at one half would let a millimetre decide."""


@dataclass(frozen=True)
class MeshOptions:
    """What a mesh should be like.

    Attributes
    ----------
    size : float, m
        Target edge of an element; edges lie between about two thirds and four thirds of it.
    layers : int
        Elements through the thickness; 0: as many as `divisions` finds for the size, at least one.
    pier_elements : int
        At least so many elements across each pier and spandrel.
    min_scaled_jacobian : float
        Worst element that passes; 1 is a brick, 0 a folded element.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    size: float = 0.25
    layers: int = 0
    pier_elements: int = 2
    min_scaled_jacobian: float = 0.3

    def __post_init__(self) -> None:
        check_positive("size", self.size)
        for name, value, least in (("layers", self.layers, 0), ("pier_elements", self.pier_elements, 1)):
            if int(value) != value or value < least:
                msg = f"Invalid '{name}': expected a whole number of at least {least}, got {value}."
                raise InputError(msg)
        if not 0.0 <= self.min_scaled_jacobian < 1.0:
            msg = (
                "Invalid 'min_scaled_jacobian': expected a number from 0 up to, not including, 1, "
                f"got {self.min_scaled_jacobian}."
            )
            raise InputError(msg)

    def layers_through(self, thickness: float) -> int:
        """Elements through a wall of this thickness, m."""
        return int(self.layers) or divisions(thickness, self.size)


DEFAULT_OPTIONS = MeshOptions()


def divisions(length: float, size: float) -> int:
    """Elements of about `size` along `length`, both in m: at least one.

    Examples
    --------
    >>> [divisions(length, 0.25) for length in (0.01, 0.34, 0.35, 1.0)]
    [1, 1, 2, 4]
    """
    return max(1, int(length / size + 1.0 - ROUND_UP_FROM))
