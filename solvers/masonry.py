"""Masonry that cracks: Drucker-Prager in compression and shear, a softening tensile cut-off.

Tension is positive and principal stresses are sorted, s1 >= s2 >= s3. The yield functions are

    F_D = alpha I1 + sqrt(J2) - k         Drucker-Prager, with the flow potential  eta I1 + sqrt(J2)
    F_i = s_i - ft(kappa), i = 1, 2, 3    Rankine, associated

whose multipliers add up as Koiter says. The tensile strength falls with kappa, the sum of the Rankine
multipliers, so that a crack band of the width h takes the energy Gf per area of crack whatever the mesh:
ft(kappa) = ft max(exp(-kappa h ft / Gf), floor). A crack is then h kappa wide.

The paper's analysis ran SOLID65 of ANSYS (Drucker-Prager with Willam-Warnke's cracking). There, a crack opens
in a fixed direction and up to three at right angles; its stress drops at a rate that does not depend on the
element's size, so that results hang on the mesh; shear across it is a constant share. Here, cracks turn with
the principal axes, one kappa serves all directions, and the energy is that of the material.

References
----------
.. [1] D. C. Drucker, W. Prager, "Soil mechanics and plastic analysis or limit design", 1952.
.. [2] Z. P. Bazant, B. H. Oh, "Crack band theory for fracture of concrete", Mater. Constr. 16, 1983.
.. [3] E. A. de Souza Neto, D. Peric, D. R. J. Owen, "Computational Methods for Plasticity", 2008.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, check_positive
from solvers.compiled.return_map import PointLaw
from solvers.materials import Material, lame_parameters

__all__ = [
    "MasonryLaw",
    "characteristic_length",
    "cone_intercept",
    "cone_slope",
    "point_law",
    "softening_strain",
]

FloatArray = NDArray[np.float64]

FLOOR = 1e-3
"""Part of the tensile strength that a wide crack keeps, so that the stiffness stays regular."""


def cone_slope(angle: float) -> float:
    """Slope of the Drucker-Prager cone through the compressive meridian of Mohr-Coulomb.

    alpha (eta) = 2 sin(phi) / (sqrt(3) (3 - sin(phi))); `angle` of friction (dilatancy), degrees.

    Examples
    --------
    >>> round(cone_slope(35.0), 6), round(cone_slope(10.0), 6)
    (0.272957, 0.070944)
    """
    sine = np.sin(np.radians(angle))
    return float(2.0 * sine / (np.sqrt(3.0) * (3.0 - sine)))


def cone_intercept(cohesion: float, angle: float) -> float:
    """Strength k of the cone in pure shear, Pa: k = 6 c cos(phi) / (sqrt(3) (3 - sin(phi))).

    Examples
    --------
    >>> round(cone_intercept(6.81e6, 35.0), 1)
    7964080.5
    """
    phi = np.radians(angle)
    return float(6.0 * cohesion * np.cos(phi) / (np.sqrt(3.0) * (3.0 - np.sin(phi))))


@dataclass(frozen=True)
class MasonryLaw:
    """Strengths of masonry, beside its elastic `Material`.

    Attributes
    ----------
    tensile_strength : float, Pa
    fracture_energy : float, N/m
        Energy that a crack takes per area. The paper has none; 50 to 200 N/m are usual for masonry.
    cohesion : float, Pa
    friction_angle, dilatancy_angle : float, degrees
    source : str
        Where the values come from.

    Raises
    ------
    InputError
        If a value is out of its range, or the tensile strength lies beyond the apex of the cone.
    """

    tensile_strength: float = 1.15e6
    fracture_energy: float = 100.0
    cohesion: float = 6.81e6
    friction_angle: float = 35.0
    dilatancy_angle: float = 10.0
    source: str = "Truong-Hong & Laefer; fracture energy assumed"

    def __post_init__(self) -> None:
        for name in ("tensile_strength", "fracture_energy", "cohesion"):
            check_positive(name, getattr(self, name))
        if not 0.0 < self.friction_angle < 60.0:
            msg = f"Invalid 'friction_angle': expected degrees between 0 and 60, got {self.friction_angle}."
            raise InputError(msg)
        if not 0.0 <= self.dilatancy_angle <= self.friction_angle:
            msg = (
                "Invalid 'dilatancy_angle': expected degrees from 0 to the friction angle of "
                f"{self.friction_angle}, got {self.dilatancy_angle}."
            )
            raise InputError(msg)
        apex = cone_intercept(self.cohesion, self.friction_angle) / (3.0 * cone_slope(self.friction_angle))
        if self.tensile_strength > apex:
            msg = (
                f"Invalid 'tensile_strength': {self.tensile_strength:.4g} Pa is more than cohesion and "
                f"friction allow ({apex:.4g} Pa at the cone's apex)."
            )
            raise InputError(msg)


def softening_strain(law: MasonryLaw, band: ArrayLike) -> FloatArray:
    """Inelastic strain at which the tensile strength has fallen to 1/e: Gf / (h ft).

    Parameters
    ----------
    law : MasonryLaw
    band : (...) array-like, m
        Width h of the crack band.
    """
    return np.asarray(law.fracture_energy / (np.asarray(band) * law.tensile_strength), dtype=np.float64)


def characteristic_length(material: Material, law: MasonryLaw) -> float:
    """Irwin's length E Gf / ft², m: wider crack bands snap back.

    Examples
    --------
    >>> round(characteristic_length(Material(), MasonryLaw()), 3)
    0.263
    """
    return material.young * law.fracture_energy / law.tensile_strength**2


def point_law(material: Material, law: MasonryLaw) -> PointLaw:
    """The constants that the return map takes, in Pa.

    Examples
    --------
    >>> law = point_law(Material(), MasonryLaw())
    >>> round(law.shear / 1e6), round(law.bulk / 1e6, 2), round(law.lame / 1e6, 2)
    (1500, 1705.88, 705.88)
    """
    lame = lame_parameters(material)
    return PointLaw(
        alpha=cone_slope(law.friction_angle),
        cone=cone_intercept(law.cohesion, law.friction_angle),
        eta=cone_slope(law.dilatancy_angle),
        hardening=0.0,
        least_cone=0.0,
        shear=lame.shear,
        bulk=lame.first + 2.0 * lame.shear / 3.0,
        lame=lame.first,
    )


def check_band(material: Material, law: MasonryLaw, band: ArrayLike) -> tuple[str, ...]:
    """Warnings if elements are so large that a crack would set free more energy than it takes.

    Parameters
    ----------
    band : (e,) array-like, m
        Crack band width of each element.
    """
    widths = as_array("band", band, (None,))
    longest = characteristic_length(material, law)
    wide = int((widths > longest).sum())
    if not wide:
        return ()
    return (
        f"{wide} of {len(widths)} elements are wider than E Gf / ft² = {longest:.3f} m: their cracks open at "
        "once and take more energy than the material has; take smaller elements or a larger fracture energy",
    )
