"""Stresses of a cracked wall at its nodes.

In an intact element the stress varies linearly between the integration points, and so it does up to the
nodes, as far as the material stands it: where the extrapolation would exceed the tensile strength, it is
drawn in towards the element's mean until it does not. In a cracked element the stress jumps, and
extrapolating it gives nonsense; a node takes what the nearest point has. Other programs do the same (ANSYS's
ERESX,DEFA).

The mean over the elements at a node, which is what is drawn, levels cracked elements with their intact
neighbours. The largest stress is therefore taken at the points.
"""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem.elements import HEXAHEDRON_EDGES, TETRAHEDRON_EDGES
from solvers.fem.stress import principal_stress

__all__ = ["element_stress", "mean_at_nodes"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

EDGES = {ElementKind.HEXAHEDRON20: HEXAHEDRON_EDGES, ElementKind.TETRA10: TETRAHEDRON_EDGES}
CORNERS = {ElementKind.HEXAHEDRON: 8, ElementKind.HEXAHEDRON20: 8, ElementKind.TETRA10: 4}
BISECTIONS = 40


def element_stress(
    kind: ElementKind,
    extrapolation: FloatArray,
    stress: FloatArray,
    *,
    cracked: BoolArray,
    strength: float,
) -> FloatArray:
    """Stresses at the nodes of each element by itself.

    Parameters
    ----------
    kind : ElementKind
    extrapolation : (g, q) float array
        From the integration points to the nodes.
    stress : (e, q, 6) float array, Pa
        At the integration points.
    cracked : (e,) bool array
    strength : float, Pa
        Tensile strength.

    Returns
    -------
    at_nodes : (e, g, 6) float array, Pa
    """
    corners = extrapolation[: CORNERS[kind]]
    at_corners = corners @ stress
    at_corners[cracked] = stress[cracked][:, np.abs(corners).argmax(axis=1)]
    over = np.flatnonzero(~cracked & (_largest(at_corners) > strength))
    at_corners[over] = _drawn_in(at_corners[over], stress[over], strength)
    if kind not in EDGES:
        return at_corners
    return np.concatenate([at_corners, at_corners[:, EDGES[kind]].mean(axis=2)], axis=1)


def _largest(stress: FloatArray) -> FloatArray:
    """Largest first principal stress (e,), Pa, in each element."""
    largest: FloatArray = principal_stress(stress)[..., 0].max(axis=1)
    return largest


def _drawn_in(at_nodes: FloatArray, stress: FloatArray, strength: float) -> FloatArray:
    """Stresses drawn in towards the element's mean as far as the strength asks: bisection of the share."""
    mean = stress.mean(axis=1, keepdims=True)
    # A point may reach the strength to the last digit.
    limit = np.maximum(strength, _largest(stress))
    low, high = np.zeros(len(stress)), np.ones(len(stress))
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        fits = _largest(mean + middle[:, None, None] * (at_nodes - mean)) <= limit
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    drawn: FloatArray = mean + low[:, None, None] * (at_nodes - mean)
    return drawn


def mean_at_nodes(mesh: VolumeMesh, at_nodes: FloatArray) -> FloatArray:
    """Mean (n, 6), Pa, over the elements at each node of their stresses (e, g, 6) there."""
    total = np.zeros((len(mesh.nodes), 6))
    np.add.at(total, mesh.elements, at_nodes)
    count = np.bincount(mesh.elements.ravel(), minlength=len(mesh.nodes))
    mean: FloatArray = total / count[:, None]
    return mean
