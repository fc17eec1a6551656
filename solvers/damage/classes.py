"""Classes of damage to a masonry building, and the measures of deformation that they are read from.

References
----------
.. [1] J. B. Burland, B. B. Broms, V. F. B. de Mello, "Behaviour of foundations and structures", 9th ICSMFE,
   Tokyo, 1977.
.. [2] M. D. Boscardin, E. J. Cording, "Building response to excavation-induced settlement", J. Geotech.
   Eng. 115 (1989) 1-21.
.. [3] M. Son, E. J. Cording, "Estimation of building damage due to excavation-induced ground movements",
   J. Geotech. Geoenviron. Eng. 131 (2005) 162-177.
.. [4] W. J. Rankin, "Ground movements resulting from urban tunnelling: predictions and effects", Geol. Soc.
   Eng. Geol. Spec. Publ. 5 (1988) 79-92.
.. [5] P. A. Korswagen, M. Longo, E. Meulman, J. G. Rots, "Crack initiation and propagation in unreinforced
   masonry specimens subjected to repeated in-plane loading during light damage", Bull. Earthq. Eng. 17
   (2019) 4651-4687.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array

__all__ = [
    "DamageAssessment",
    "DamageClass",
    "assess_damage",
    "assessment_to_dict",
    "crack_damage_class",
    "crack_damage_parameter",
    "distortion_damage_class",
    "distortion_strain",
    "rankin_negligible",
    "strain_damage_class",
    "strain_label",
]

STRAIN_LIMITS = 0.05e-2, 0.075e-2, 0.15e-2, 0.30e-2
"""Limiting tensile strains between the classes 0, 1, 2, 3 and 4 (Boscardin & Cording 1989, table 1)."""

CRACK_LIMITS = 0.1e-3, 1e-3, 5e-3, 15e-3, 25e-3
"""Crack widths, m, between the classes 0 to 5 (Burland, Broms & de Mello 1977, table 1)."""

MODERATE_CRACK = 3e-3
"""Several cracks this wide, m, are moderate damage (the same table)."""

SEVERAL = 3
"""How many cracks are several: the table says "a number of"."""

DISTORTION_LIMITS = 0.5e-3, 0.75e-3, 1.67e-3, 3.33e-3
"""Principal tensile strains between the classes (Son & Cording 2005)."""


class DamageClass(IntEnum):
    """Category of visible damage (Burland, Broms & de Mello 1977)."""

    NEGLIGIBLE = 0
    VERY_SLIGHT = 1
    SLIGHT = 2
    MODERATE = 3
    SEVERE = 4
    VERY_SEVERE = 5

    @property
    def label(self) -> str:
        """Its name in words.

        Examples
        --------
        >>> DamageClass(1).label
        'very slight'
        """
        return self.name.lower().replace("_", " ")


def _class_between(value: float, limits: Sequence[float]) -> DamageClass:
    """The class between limits: only the first excludes the value itself ("less than", then "up to")."""
    if np.isnan(value):
        msg = "The measure of damage is not a number."
        raise InputError(msg)
    if value < limits[0]:
        return DamageClass.NEGLIGIBLE
    return DamageClass(1 + int(np.searchsorted(limits[1:], value, side="left")))


def strain_damage_class(strain: float) -> DamageClass:
    """Class by the largest tensile strain (Boscardin & Cording 1989).

    Over 0.30 % the table does not part class 4 from 5: `DamageClass.SEVERE` then means both.

    Parameters
    ----------
    strain : float
        Positive in tension.

    Raises
    ------
    InputError
        If the strain is not a number.

    Examples
    --------
    >>> strain_damage_class(1e-3).label
    'slight'
    """
    return _class_between(strain, STRAIN_LIMITS)


def strain_label(damage: DamageClass) -> str:
    """A class by strain in words; the last one stands for two.

    Examples
    --------
    >>> strain_label(strain_damage_class(4e-3))
    'severe to very severe'
    """
    return "severe to very severe" if damage is DamageClass.SEVERE else damage.label


def crack_damage_class(widths: ArrayLike) -> DamageClass:
    """Class by the widths of the cracks (Burland, Broms & de Mello 1977).

    The table adds that width is only one aspect of damage: severe and very severe also depend on the
    number of cracks and on what they cut.

    Parameters
    ----------
    widths : (n,) array-like, m
        One for each crack; none at all is class 0.

    Raises
    ------
    InputError
        If a width is negative or not finite.

    Examples
    --------
    >>> crack_damage_class([4e-3]).label, crack_damage_class([4e-3, 3e-3, 3e-3]).label
    ('slight', 'moderate')
    """
    cracks = _measures("widths", widths)
    by_width = _class_between(float(cracks.max(initial=0.0)), CRACK_LIMITS)
    several = int((cracks >= MODERATE_CRACK).sum()) >= SEVERAL
    return max(by_width, DamageClass.MODERATE) if several else by_width


def _measures(name: str, values: ArrayLike) -> np.ndarray[Any, np.dtype[np.float64]]:
    array = as_array(name, values, (None,))
    if (array < 0.0).any():
        msg = f"Invalid '{name}': {array.min():.4g} m is negative."
        raise InputError(msg)
    return array


def distortion_strain(angular_distortion: float, lateral_strain: float) -> float:
    """Principal tensile strain of a bay that is sheared and stretched (Son & Cording 2005).

    εp = εL cos²θ + β sin θ cos θ with tan 2θ = β / εL, in which θ is the angle of the strain's direction to
    the horizontal. With the double angle, εp = εL/2 + √(εL² + β²)/2.

    Parameters
    ----------
    angular_distortion : float
        β, the settlement's slope less the bay's tilt.
    lateral_strain : float
        εL, positive in tension.

    Examples
    --------
    >>> round(distortion_strain(2e-3, 5e-4), 9)
    0.001280776
    """
    return float(lateral_strain / 2 + np.hypot(lateral_strain, angular_distortion) / 2)


def distortion_damage_class(strain: float) -> DamageClass:
    """Class by the principal strain of `distortion_strain` (Son & Cording 2005).

    Their two upper classes overlap: `DamageClass.MODERATE` means moderate to severe, `SEVERE` severe to
    very severe.

    Raises
    ------
    InputError
        If the strain is not a number.
    """
    return _class_between(strain, DISTORTION_LIMITS)


def rankin_negligible(settlement: float, slope: float) -> bool:
    """Whether the first screen of Rankin (1988) lets a building pass: under 10 mm and 1/500.

    Parameters
    ----------
    settlement : float, m
        The largest under the building.
    slope : float
        The steepest of the ground under it.

    Examples
    --------
    >>> rankin_negligible(0.009, 1 / 600), rankin_negligible(0.009, 1 / 400)
    (True, False)
    """
    return abs(settlement) < 10e-3 and abs(slope) < 1 / 500


def crack_damage_parameter(widths: ArrayLike, lengths: ArrayLike) -> float:
    """Damage parameter ψ of light damage in masonry (Korswagen et al. 2019).

    ψ = 2 n^0.15 c^0.3, with n cracks and their mean width c = Σ w² L / Σ w L in millimetres. One crack of
    0.1 mm is ψ = 1, the first that can be seen; one of 1 mm is ψ = 2.

    Parameters
    ----------
    widths : (n,) array-like, m
        The largest of each crack; cracks of no width do not count.
    lengths : (n,) array-like, m

    Raises
    ------
    InputError
        If the arrays differ in length, or hold a value that is negative or not finite.

    Examples
    --------
    >>> round(crack_damage_parameter([1e-3], [0.8]), 6), round(crack_damage_parameter([1e-4], [0.8]), 2)
    (2.0, 1.0)
    """
    w, L = _measures("widths", widths) * 1e3, _measures("lengths", lengths)
    if len(w) != len(L):
        msg = f"Invalid 'lengths': {len(L)} values for {len(w)} widths."
        raise InputError(msg)
    count = int(((w > 0.0) & (L > 0.0)).sum())
    if count == 0:
        return 0.0
    mean_width = float((w**2 * L).sum() / (w * L).sum())
    return float(2 * count**0.15 * mean_width**0.3)


@dataclass(frozen=True)
class DamageAssessment:
    """The damage of a wall by both measures, beside each other: neither is the other's check.

    Attributes
    ----------
    tensile_strain : float
        The largest.
    strain_class : DamageClass
        From it; `SEVERE` means severe to very severe.
    crack_width : float, m
        The largest.
    crack_class : DamageClass
        From the widths of all cracks.
    """

    tensile_strain: float
    strain_class: DamageClass
    crack_width: float
    crack_class: DamageClass


def assess_damage(*, tensile_strain: float, crack_widths: ArrayLike) -> DamageAssessment:
    """Both classes of damage of a wall.

    Parameters
    ----------
    tensile_strain : float
    crack_widths : (n,) array-like, m

    Examples
    --------
    >>> damage = assess_damage(tensile_strain=6e-4, crack_widths=[2e-3])
    >>> damage.strain_class.label, damage.crack_class.label
    ('very slight', 'slight')
    """
    return DamageAssessment(
        tensile_strain=float(tensile_strain),
        strain_class=strain_damage_class(tensile_strain),
        crack_width=float(_measures("crack_widths", crack_widths).max(initial=0.0)),
        crack_class=crack_damage_class(crack_widths),
    )


def assessment_to_dict(damage: DamageAssessment) -> dict[str, Any]:
    """An assessment as JSON values: the classes by number and in words."""
    return asdict(damage) | {
        "strain_class": int(damage.strain_class),
        "strain_label": strain_label(damage.strain_class),
        "crack_class": int(damage.crack_class),
        "crack_label": damage.crack_class.label,
    }
