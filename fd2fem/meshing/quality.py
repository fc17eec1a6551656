"""How good a mesh is: shape of its elements, and their volume."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.topology import EDGES
from fd2fem.model import ElementKind, MeshQuality, VolumeMesh

__all__ = ["element_aspects", "element_volumes", "mesh_quality", "scaled_jacobians"]

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
    tetrahedra are judged by their corners.

    References
    ----------
    Stimpson et al., The Verdict Geometric Quality Library, SAND2007-1751, 2007.
    """
    corner = mesh.nodes[mesh.elements]
    if mesh.kind is ElementKind.HEXAHEDRON:
        worst = np.full(len(corner), np.inf)
        for own, (first, second, third) in enumerate(_HEX_NEIGHBOURS):
            a, b, c = (_unit(corner[:, other] - corner[:, own]) for other in (first, second, third))
            worst = np.minimum(worst, _triple(a, b, c))
        return worst
    p = corner[:, :4]
    jacobian = _triple(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], p[:, 3] - p[:, 0])
    sides = np.linalg.norm(p[:, :, None] - p[:, None, :], axis=3) + np.eye(4)
    return np.asarray(
        np.sqrt(2.0) * jacobian / np.maximum(sides.prod(axis=2).max(axis=1), np.finfo(float).tiny)
    )


def element_aspects(mesh: VolumeMesh) -> FloatArray:
    """Longest over shortest edge (e,) of each element, between its corners."""
    corner = mesh.nodes[mesh.elements]
    lengths = np.stack([np.linalg.norm(corner[:, i] - corner[:, j], axis=1) for i, j in EDGES[mesh.kind]])
    return np.asarray(lengths.max(axis=0) / np.maximum(lengths.min(axis=0), np.finfo(float).tiny))


def element_volumes(mesh: VolumeMesh) -> FloatArray:
    """Volume (e,), m³, of each element.

    Hexahedra by 2 × 2 × 2 Gauss points, which is exact for trilinear ones; tetrahedra by their corners.
    """
    corner = mesh.nodes[mesh.elements]
    if mesh.kind is ElementKind.TETRA10:
        p = corner[:, :4]
        return _triple(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], p[:, 3] - p[:, 0]) / 6.0
    volume = np.zeros(len(corner))
    for point in _HEX_SIGNS / np.sqrt(3.0):
        factors = 1.0 + _HEX_SIGNS * point
        gradient = _HEX_SIGNS * factors[:, [1, 0, 0]] * factors[:, [2, 2, 1]] / 8.0
        volume += np.linalg.det(np.einsum("nj,eni->eij", gradient, corner))
    return volume


def _unit(vectors: FloatArray) -> FloatArray:
    """Unit vectors; zero where there is no direction."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _triple(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Triple product a · (b × c)."""
    return np.asarray(np.einsum("ei,ei->e", a, np.cross(b, c)))
