"""Which of our integration points is which of CalculiX's."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind
from solvers.fem.elements import (
    HEXAHEDRON_CORNERS,
    HEXAHEDRON_EDGES,
    TETRAHEDRON_CORNERS,
    TETRAHEDRON_EDGES,
    Space,
)
from solvers.fem.rules import space_rule, stiffness_order

__all__ = ["order_of_points"]

FloatArray = NDArray[np.float64]


def order_of_points(space: Space) -> NDArray[np.intp]:
    """Which point of our rule for the stiffness each of CalculiX's is.

    CalculiX numbers the points of a hexahedron along its first edge direction first, then the second, then
    the third; those of a tetrahedron by the corner that they are near to.

    Parameters
    ----------
    space : Space

    Returns
    -------
    order : (q,) int array
        Our index of CalculiX's points.
    """
    values = space_rule(space, stiffness_order(space)).values
    if space.kind is ElementKind.TETRA10:
        corners, edges = TETRAHEDRON_CORNERS, TETRAHEDRON_EDGES
    else:
        corners, edges = HEXAHEDRON_CORNERS, HEXAHEDRON_EDGES
    nodes = np.vstack([corners, corners[edges].mean(axis=1)])[: values.shape[1]]
    distance = np.linalg.norm(_their_points(space)[:, None] - values @ nodes, axis=2)
    order: NDArray[np.intp] = distance.argmin(axis=1)
    return order


def _their_points(space: Space) -> FloatArray:
    """CalculiX's integration points, on our reference elements with edges from 0 to 1."""
    if space.kind is ElementKind.TETRA10:
        near = float(5.0 - np.sqrt(5.0)) / 20.0
        return near + (1.0 - 4.0 * near) * TETRAHEDRON_CORNERS
    line = 0.5 + 0.5 * np.polynomial.legendre.leggauss(2 if space.element.eight_nodes else 3)[0]
    third, second, first = np.meshgrid(line, line, line, indexing="ij")
    points: FloatArray = np.stack([first, second, third], axis=-1).reshape(-1, 3)
    return points
