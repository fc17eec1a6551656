"""Isotropic linear elasticity: the material and its 6 x 6 matrix.

Stress and strain vectors are ordered xx, yy, zz, xy, yz, xz; shear strains are engineering ones
(γ = 2ε).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive

__all__ = ["LameParameters", "Material", "elasticity_matrix", "lame_parameters"]


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material.

    Attributes
    ----------
    young : float, Pa
        Young's modulus.
    poisson : float
        Poisson's ratio, at least 0 and under 0.5.
    density : float, kg/m³
    source : str
        Where the values come from.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    young: float = 3.48e9
    poisson: float = 0.16
    density: float = 1900.0
    source: str = "Truong-Hong & Laefer, medium masonry; density assumed"

    def __post_init__(self) -> None:
        check_positive("young", self.young)
        check_positive("density", self.density)
        if not 0.0 <= self.poisson < 0.5:
            msg = (
                f"Invalid 'poisson': expected at least 0 and under 0.5 (incompressible), got {self.poisson}."
            )
            raise InputError(msg)


@dataclass(frozen=True)
class LameParameters:
    """Lamé's parameters, Pa: `first` (λ) and `shear`, the shear modulus (μ or G)."""

    first: float
    shear: float


def lame_parameters(material: Material) -> LameParameters:
    """λ = Eν / ((1 + ν)(1 - 2ν)) and G = E / (2(1 + ν)).

    Examples
    --------
    >>> lame_parameters(Material(young=2.5, poisson=0.25))
    LameParameters(first=1.0, shear=1.0)
    """
    E, nu = material.young, material.poisson
    return LameParameters(first=E * nu / ((1 + nu) * (1 - 2 * nu)), shear=E / (2 * (1 + nu)))


def elasticity_matrix(material: Material) -> NDArray[np.float64]:
    """Stress from strain: σ = D ε.

    Returns
    -------
    D : (6, 6) float array, Pa
        Order xx, yy, zz, xy, yz, xz; engineering shear strains.

    Examples
    --------
    >>> elasticity_matrix(Material(young=2.5, poisson=0.25))[0].tolist()
    [3.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    """
    lame = lame_parameters(material)
    D = np.zeros((6, 6))
    D[:3, :3] = lame.first
    D[range(3), range(3)] += 2 * lame.shear
    D[range(3, 6), range(3, 6)] = lame.shear
    return D
