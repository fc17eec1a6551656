"""How good a mesh is: shape of its elements, and their volume."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind, MeshQuality, VolumeMesh
from fd2fem.model.topology import EDGES

__all__ = ["element_aspects", "element_volumes", "mesh_quality", "scaled_jacobians", "tetrahedron_shapes"]

FloatArray = NDArray[np.float64]

# The three neighbours of each corner, so that the triple product is positive in VTK's order.
_HEX_NEIGHBOURS = ((1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3))
_HEX_SIGNS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
)


def mesh_quality(mesh: VolumeMesh) -> MeshQuality:
    """Shape and volume of the elements.

    Examples
    --------
    >>> from fd2fem.meshing import mesh_facade
    >>> from fd2fem.model import Facade, rectangle
    >>> quality = mesh_quality(mesh_facade(Facade(outline=rectangle(0, 0, 2, 1), thickness=0.5)))
    >>> round(quality.min_scaled_jacobian, 9), round(quality.max_aspect, 9), round(quality.volume, 9)
    (1.0, 1.0, 1.0)
    """
    shape = scaled_jacobians(mesh)
    return MeshQuality(
        elements=len(mesh.elements),
        nodes=len(mesh.nodes),
        min_scaled_jacobian=float(shape.min()),
        mean_scaled_jacobian=float(shape.mean()),
        max_aspect=float(element_aspects(mesh).max()),
        volume=float(element_volumes(mesh).sum()),
    )


def scaled_jacobians(mesh: VolumeMesh) -> FloatArray:
    """Scaled Jacobian (e,) of each element: 1 for a cube or regular tetrahedron, 0 or less when folded.

    Of a hexahedron the least over its corners of the triple product of the unit edges; of a tetrahedron
    √2 times its Jacobian over the largest product of three edges that share a corner. Quadratic
    elements are judged by their corners.

    References
    ----------
    Stimpson et al., The Verdict Geometric Quality Library, SAND2007-1751, 2007.
    """
    corner = mesh.nodes[mesh.elements]
    if mesh.kind is not ElementKind.TETRA10:
        worst = np.full(len(corner), np.inf)
        for own, (first, second, third) in enumerate(_HEX_NEIGHBOURS):
            a, b, c = (_unit(corner[:, other] - corner[:, own]) for other in (first, second, third))
            worst = np.minimum(worst, _triple(a, b, c))
        return worst
    return tetrahedron_shapes(corner[:, :4])


def tetrahedron_shapes(corners: FloatArray) -> FloatArray:
    """Scaled Jacobian (e,) of tetrahedra by their corners (e, 4, 3); see `scaled_jacobians`."""
    p, q, r, s = np.moveaxis(corners, (1, 2), (0, 1))  # each (3, e)
    a, b, c = q - p, r - p, s - p
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    jacobian = x * c[0] + y * c[1] + z * c[2]
    (pq, pr, ps, qr, qs, rs) = (
        v[0] * v[0] + v[1] * v[1] + v[2] * v[2] for v in (a, b, c, r - q, s - q, s - r)
    )
    largest = np.maximum(np.maximum(pq * pr * ps, pq * qr * qs), np.maximum(pr * qr * rs, ps * qs * rs))
    return np.asarray(np.sqrt(2.0 / np.maximum(largest, np.finfo(float).tiny)) * jacobian)


def element_aspects(mesh: VolumeMesh) -> FloatArray:
    """Longest over shortest edge (e,) of each element, between its corners."""
    corner = mesh.nodes[mesh.elements]
    lengths = np.stack([np.linalg.norm(corner[:, i] - corner[:, j], axis=1) for i, j in EDGES[mesh.kind]])
    return np.asarray(lengths.max(axis=0) / np.maximum(lengths.min(axis=0), np.finfo(float).tiny))


def element_volumes(mesh: VolumeMesh) -> FloatArray:
    """Volume (e,), m³, of each element.

    Hexahedra by 2 × 2 × 2 Gauss points, of 20 nodes by 3 × 3 × 3, which is exact, also where they are
    curved; tetrahedra by their corners.
    """
    corner = mesh.nodes[mesh.elements]
    if mesh.kind is ElementKind.TETRA10:
        p = corner[:, :4]
        return _triple(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], p[:, 3] - p[:, 0]) / 6.0
    linear = mesh.kind is ElementKind.HEXAHEDRON
    gradient, count = (_linear_gradient, 2) if linear else (_quadratic_gradient, 3)
    place, weight = np.polynomial.legendre.leggauss(count)
    volume = np.zeros(len(corner))
    for i, j, k in np.ndindex(count, count, count):
        jacobian = np.einsum("nj,eni->eij", gradient(place[[i, j, k]]), corner)
        volume += weight[i] * weight[j] * weight[k] * np.linalg.det(jacobian)
    return volume


def _linear_gradient(point: FloatArray) -> FloatArray:
    """Derivatives (8, 3) of the shape functions of a hexahedron of 8 nodes, at (3,) within ±1."""
    factors = 1.0 + _HEX_SIGNS * point
    return np.asarray(_HEX_SIGNS * factors[:, [1, 0, 0]] * factors[:, [2, 2, 1]] / 8.0)


def _quadratic_gradient(point: FloatArray) -> FloatArray:
    """Derivatives (20, 3) of the shape functions of a hexahedron of 20 nodes, at (3,) within ±1.

    At a corner N = (1 + aξ)(1 + bη)(1 + cζ)(aξ + bη + cζ - 2)/8; half the middle of each of its three
    edges taken from a linear one says the same.
    """
    linear = _linear_gradient(point)
    ends = np.array(EDGES[ElementKind.HEXAHEDRON])
    signs = _HEX_SIGNS[ends].mean(axis=1)
    factors = 1.0 + signs * point
    along = signs == 0.0
    factors = np.where(along, 1.0 - point**2, factors)
    slopes = np.where(along, -2.0 * point, signs)
    middle = slopes * factors[:, [1, 0, 0]] * factors[:, [2, 2, 1]] / 4.0
    corner = linear.copy()
    for side in (0, 1):
        np.subtract.at(corner, ends[:, side], middle / 2.0)
    return np.vstack([corner, middle])


def _unit(vectors: FloatArray) -> FloatArray:
    """Unit vectors; zero where there is no direction."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _triple(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Triple product a · (b × c)."""
    return np.asarray(np.einsum("ei,ei->e", a, np.cross(b, c)))
