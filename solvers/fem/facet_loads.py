"""Nodal forces of a pressure on a group of facets."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh
from solvers.fem.elements import shape_functions

if TYPE_CHECKING:
    import skfem

__all__ = ["pressure_forces"]

FloatArray = NDArray[np.float64]

QUAD = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5]])
TRIANGLE = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]])
ORDER = 5
"""Polynomial degree that facets are integrated to: enough for curved ones."""


def pressure_forces(mesh: VolumeMesh, group: str, pressure: float) -> FloatArray:
    """Nodal forces of a pressure, consistent with the shape functions of the facets.

    Parameters
    ----------
    mesh : VolumeMesh
    group : str
        Facets that the pressure acts on.
    pressure : float, Pa
        Positive: it pushes at the body; negative: it pulls.

    Returns
    -------
    f : (3n,) float array, N
        Components x, y, z of each node in turn.

    Raises
    ------
    InputError
        If the mesh has no such group, or it is empty.
    """
    from skfem.quadrature import get_quadrature

    mesh.group_nodes(group)
    facets = mesh.groups[group]
    element, nodes = _facet_element(facets.shape[1])
    points, weights = get_quadrature(element, ORDER)
    values, gradients = shape_functions(element, nodes, points)
    along = np.einsum("qdb,fbi->fqdi", gradients, mesh.nodes[facets])
    # The cross product of both tangents is the outward normal times the area per reference area.
    normal = np.cross(along[:, :, 0], along[:, :, 1])
    forces = np.zeros((len(mesh.nodes), 3))
    np.add.at(forces, facets, -pressure * np.einsum("q,qb,fqi->fbi", weights, values, normal))
    return forces.ravel()


def _facet_element(count: int) -> "tuple[skfem.Element, FloatArray]":
    """scikit-fem's element of a facet with so many nodes, and where on it they lie."""
    import skfem

    if count == 6:
        return skfem.ElementTriP2(), TRIANGLE
    return (skfem.ElementQuad1(), QUAD[:4]) if count == 4 else (skfem.ElementQuadS2(), QUAD)
