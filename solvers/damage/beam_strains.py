"""Strains of the equivalent beam: what bending, shear and stretching do to a wall without openings.

References
----------
.. [1] J. B. Burland, C. P. Wroth, "Settlement of buildings and associated damage", Conf. Settlement of
   Structures, Cambridge, 1974.
.. [2] R. J. Mair, R. N. Taylor, J. B. Burland, "Prediction of ground movements and assessment of risk of
   building damage due to bored tunnelling", Geotech. Aspects of Underground Construction, London, 1996.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from fd2fem.model.checks import check_positive

__all__ = [
    "EquivalentBeam",
    "ZoneKind",
    "bending_strain",
    "combined_bending_strain",
    "combined_diagonal_strain",
    "diagonal_strain",
]


class ZoneKind(StrEnum):
    """How the ground bends: convex upwards, concave upwards, or not."""

    HOGGING = "hogging"
    SAGGING = "sagging"
    STRAIGHT = "straight"


@dataclass(frozen=True)
class EquivalentBeam:
    """A wall as a rectangular beam of unit breadth.

    A sagging beam bends about its middle; a hogging one about its lower edge, where the foundation and
    the ground hold it together (Burland & Wroth 1974).

    Attributes
    ----------
    kind : ZoneKind
    length, height : float, m
    e_over_g : float
        E / G; 2.6 for an isotropic wall with ν = 0.3, larger for one whose openings weaken it in shear.

    Raises
    ------
    InputError
        If a measure is not positive.
    """

    kind: ZoneKind
    length: float
    height: float
    e_over_g: float = 2.6

    def __post_init__(self) -> None:
        for name in ("length", "height", "e_over_g"):
            check_positive(name, getattr(self, name))

    @property
    def outer_fibre(self) -> float:
        """Distance t of the outer fibre from the neutral axis, m."""
        return self.height / 2 if self.kind is ZoneKind.SAGGING else self.height

    @property
    def second_moment(self) -> float:
        """Second moment I of the section about the neutral axis, m⁴ per metre of breadth."""
        return self.height**3 / (12 if self.kind is ZoneKind.SAGGING else 3)


def bending_strain(deflection_ratio: float, beam: EquivalentBeam) -> float:
    """Largest bending strain: Δ/L = [L/12t + 3 I E / (2 t L H G)] εb (Burland & Wroth 1974).

    Parameters
    ----------
    deflection_ratio : float
        Δ / L.
    beam : EquivalentBeam

    Examples
    --------
    >>> round(bending_strain(1e-3, EquivalentBeam(ZoneKind.HOGGING, length=10.0, height=10.0)), 7)
    0.0007229
    """
    t, L, H = beam.outer_fibre, beam.length, beam.height
    return deflection_ratio / (L / (12 * t) + 3 * beam.second_moment * beam.e_over_g / (2 * t * L * H))


def diagonal_strain(deflection_ratio: float, beam: EquivalentBeam) -> float:
    """Largest diagonal strain: Δ/L = [1 + H L² G / (18 I E)] εd (Burland & Wroth 1974).

    Parameters
    ----------
    deflection_ratio : float
        Δ / L.
    beam : EquivalentBeam

    Examples
    --------
    >>> round(diagonal_strain(1e-3, EquivalentBeam(ZoneKind.HOGGING, length=10.0, height=10.0)), 7)
    0.0009398
    """
    L, H = beam.length, beam.height
    return deflection_ratio / (1 + H * L**2 / (18 * beam.second_moment * beam.e_over_g))


def combined_bending_strain(bending: float, horizontal: float) -> float:
    """Strain of the outer fibre, εbt = εb + εh (Mair, Taylor & Burland 1996)."""
    return bending + horizontal


def combined_diagonal_strain(diagonal: float, horizontal: float, *, poisson: float) -> float:
    """Principal strain of shear and horizontal strain (Mair, Taylor & Burland 1996).

    εdt = εh (1 - ν)/2 + √([εh (1 + ν)/2]² + εd²): the wall, free in height, contracts by ν εh.

    Examples
    --------
    >>> round(combined_diagonal_strain(4e-4, 5e-4, poisson=0.3), 8)
    0.00069039
    """
    return float(horizontal * (1 - poisson) / 2 + np.hypot(horizontal * (1 + poisson) / 2, diagonal))
