"""Hexahedra that were swept through a wall, cut into tetrahedra."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.quality import tetrahedron_shapes
from fd2fem.meshing.relocation import relocate
from fd2fem.meshing.topology import boundary_facets, facet_keys
from fd2fem.model import ElementKind, VolumeMesh
from fd2fem.model.topology import EDGES, FACETS

__all__ = ["quadratic_tetrahedra", "split_hexahedra", "tetrahedron_boundary", "worst_split"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_DIAGONALS = (((0, 1, 2), (0, 2, 3)), ((0, 1, 3), (1, 2, 3)))
"""Triangles of a quadrilateral, by either diagonal."""


def worst_split(mesh: VolumeMesh) -> float:
    """Least scaled Jacobian of the tetrahedra that hexahedra are cut into, before any node is moved."""
    corners = _tetrahedra(mesh.nodes, _prisms(mesh.nodes, mesh.elements))
    return float(tetrahedron_shapes(mesh.nodes[corners]).min())


def split_hexahedra(mesh: VolumeMesh, *, target: float) -> VolumeMesh:
    """The same wall, with the same groups, in 10-node tetrahedra: six for each hexahedron.

    Each quadrilateral of the front is divided by its better diagonal; that makes prisms, each of which
    becomes three tetrahedra. The diagonals of their sides start where the node's number is lower, so that
    neighbours agree. At the end, nodes are moved where tetrahedra are worse than `target`, but no surface.

    Parameters
    ----------
    mesh : VolumeMesh
        Hexahedra of 8 nodes; corners 0 to 3 and 4 to 7 of each look at one another through the wall.
    target : float
        Scaled Jacobian.

    References
    ----------
    Dompierre, Labbé, Vallet and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra,
    8th International Meshing Roundtable, 1999.
    """
    corners = _tetrahedra(mesh.nodes, _prisms(mesh.nodes, mesh.elements))
    nodes = relocate(mesh.nodes, corners, tetrahedron_boundary(corners, nodes=len(mesh.nodes)), target=target)
    nodes, elements = quadratic_tetrahedra(nodes, corners)
    facets = boundary_facets(elements, ElementKind.TETRA10, nodes=len(nodes))
    halves = {
        name: quads[:, np.array(_DIAGONALS).reshape(-1, 3)].reshape(-1, 3)
        for name, quads in mesh.groups.items()
    }
    keys = facet_keys(np.vstack([facets[:, :3], *halves.values()]), nodes=len(nodes))
    own, *others = np.split(keys, np.cumsum([len(facets), *map(len, halves.values())])[:-1])
    groups = {name: facets[np.isin(own, other)] for name, other in zip(halves, others, strict=True)}
    return VolumeMesh(nodes=nodes, elements=elements, kind=ElementKind.TETRA10, groups=groups)


def quadratic_tetrahedra(nodes: FloatArray, corners: IntArray) -> tuple[FloatArray, IntArray]:
    """Give tetrahedra (e, 4) between nodes (n, 3) their middles: nodes (m, 3), elements (e, 10).

    Examples
    --------
    >>> nodes, elements = quadratic_tetrahedra(np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2, 3]]))
    >>> elements.tolist(), nodes[4].tolist()
    ([[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]], [0.5, 0.0, 0.0])
    """
    edges = np.sort(corners[:, np.array(EDGES[ElementKind.TETRA10])], axis=2)
    packed = edges[..., 0].astype(np.int64) * len(nodes) + edges[..., 1]
    _, first, index = np.unique(packed, return_index=True, return_inverse=True)
    number = np.argsort(np.argsort(first))  # in the order in which they appear
    middles = nodes[edges.reshape(-1, 2)[np.sort(first)]].mean(axis=1)
    elements = np.hstack([corners, len(nodes) + number[index.reshape(edges.shape[:2])]])
    return np.vstack([nodes, middles]), elements


def tetrahedron_boundary(corners: IntArray, *, nodes: int) -> IntArray:
    """Facets (f, 3) of tetrahedra (e, 4) that belong to one of them only, outward."""
    facets = corners[:, np.array(FACETS[ElementKind.TETRA10])[:, :3]].reshape(-1, 3)
    _, first, count = np.unique(facet_keys(facets, nodes=nodes), return_index=True, return_counts=True)
    single: IntArray = facets[first[count == 1]]
    return single


def _prisms(nodes: FloatArray, hexahedra: IntArray) -> IntArray:
    """Two prisms (2 e, 6) for each hexahedron (e, 8): three corners, then those beyond them."""
    flat = nodes[hexahedra[:, :4]]
    worst = [
        np.minimum(*(_triangle_shapes(flat[:, list(corner)]) for corner in triangles))
        for triangles in _DIAGONALS
    ]
    second = worst[1] > worst[0]
    triangles = np.where(second[:, None, None], np.array(_DIAGONALS[1]), np.array(_DIAGONALS[0]))
    near = np.take_along_axis(hexahedra[:, None, :4], triangles, axis=2)
    far = np.take_along_axis(hexahedra[:, None, 4:], triangles, axis=2)
    return np.concatenate([near, far], axis=2).reshape(-1, 6)


def _triangle_shapes(corner: FloatArray) -> FloatArray:
    """Sine (t,) of the least angle of triangles (t, 3, 3), about: twice the area over the longest edge²."""
    sides = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2)
    double = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return np.asarray(double / sides.max(axis=1) ** 2)


def _tetrahedra(nodes: FloatArray, prisms: IntArray) -> IntArray:
    """Three tetrahedra (3 p, 4), of positive volume, for each prism (p, 6)."""
    order = np.argsort(prisms[:, :3], axis=1)
    near = np.take_along_axis(prisms[:, :3], order, axis=1)
    far = np.take_along_axis(prisms[:, 3:], order, axis=1)
    stairs = [np.hstack([near[:, : k + 1], far[:, k:]]) for k in range(3)]
    corners = np.stack(stairs, axis=1).reshape(-1, 4)
    inverted = tetrahedron_shapes(nodes[corners]) < 0.0
    corners[inverted] = corners[inverted][:, [1, 0, 2, 3]]
    return corners
