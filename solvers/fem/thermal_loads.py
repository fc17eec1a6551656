"""What a change of temperature does to an elastic body.

A body that is heated by T expands by alpha T in all directions; where it cannot, it is stressed. With
temperatures at the points that carry displacements, interpolated like these,

    f = ∫ Bᵀ D (alpha T, alpha T, alpha T, 0, 0, 0) dV,     stress = D (strain - alpha T).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model.checks import as_array
from solvers.fem.assembly import point_volumes
from solvers.fem.elements import STRESS_ORDER, Space
from solvers.fem.rules import space_rule, stiffness_order
from solvers.materials import Material, lame_parameters

__all__ = ["held_stress", "thermal_forces"]

FloatArray = NDArray[np.float64]


def thermal_forces(
    space: Space, material: Material, temperature: ArrayLike, *, expansion: float
) -> FloatArray:
    """Nodal forces that would expand a body as a change of temperature does.

    Parameters
    ----------
    space : Space
    material : Material
    temperature : (m,) array-like, K
        Change of temperature at the space's points.
    expansion : float, 1/K
        Coefficient of thermal expansion.

    Returns
    -------
    f : (3m,) float array, N
    """
    change = as_array("temperature", temperature, (len(space.points),))
    rule = space_rule(space, stiffness_order(space))
    volumes = point_volumes(space, rule)
    nodes = space.points[space.connectivity[:, : rule.geometry.shape[2]]]
    gradients = np.linalg.solve(rule.geometry @ nodes[:, None], rule.gradients[None])
    pressure = _pressure(material, expansion) * (change[space.connectivity] @ rule.values.T)
    forces = np.zeros((len(space.points), 3))
    np.add.at(forces, space.connectivity, np.einsum("eq,eqib->ebi", pressure * volumes, gradients))
    return forces.ravel()


def held_stress(space: Space, material: Material, temperature: ArrayLike, *, expansion: float) -> FloatArray:
    """Stress at the points of the stress rule of a heated body that cannot expand at all.

    Add it to that of the displacements.

    Parameters
    ----------
    space, material, temperature, expansion
        As for `thermal_forces`.

    Returns
    -------
    stress : (e, q, 6) float array, Pa
    """
    change = as_array("temperature", temperature, (len(space.points),))
    rule = space_rule(space, STRESS_ORDER[space.kind])
    pressure = _pressure(material, expansion) * (change[space.connectivity] @ rule.values.T)
    return np.asarray(-pressure[..., None] * [1, 1, 1, 0, 0, 0], dtype=np.float64)


def _pressure(material: Material, expansion: float) -> float:
    """Pressure per kelvin in a body that is held: (3 lambda + 2 G) alpha, Pa/K."""
    lame = lame_parameters(material)
    return (3.0 * lame.first + 2.0 * lame.shear) * expansion
