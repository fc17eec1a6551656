"""From 8-node to 20-node hexahedra: the points in the middle of the edges become nodes."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind, VolumeMesh
from fd2fem.model.topology import EDGES

__all__ = ["quadratic_mesh"]

IntArray = NDArray[np.intp]


def quadratic_mesh(mesh: VolumeMesh) -> VolumeMesh:
    """The same wall in quadratic elements: 8-node hexahedra get a node in the middle of each edge.

    The nodes of `mesh` keep their numbers; the new ones follow, sorted by the lower and then the higher
    node at the ends of their edge. They are the very points that carry the displacements when `solvers`
    analyses the 8-node mesh. Quadratic meshes are returned as they are.

    Parameters
    ----------
    mesh : VolumeMesh

    Returns
    -------
    mesh : VolumeMesh
        Of kind HEXAHEDRON20 or TETRA10; groups keep their facets, with the middles of their edges.

    Examples
    --------
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    >>> groups = {"base": np.array([[0, 3, 2, 1]])}
    >>> cube = VolumeMesh(np.array(corners), np.arange(8)[None], ElementKind.HEXAHEDRON, groups)
    >>> quadratic_mesh(cube).nodes[8].tolist()
    [0.5, 0.0, 0.0]
    >>> quadratic_mesh(cube).groups["base"].shape
    (1, 8)
    """
    if mesh.kind is not ElementKind.HEXAHEDRON:
        return mesh
    count = len(mesh.nodes)
    ends = mesh.elements[:, np.array(EDGES[mesh.kind])]
    keys, edge = np.unique(_keys(ends, count), return_inverse=True)
    middle = 0.5 * (mesh.nodes[keys // count] + mesh.nodes[keys % count])
    groups = {}
    for name, facets in mesh.groups.items():
        sides = np.stack([facets, np.roll(facets, -1, axis=1)], axis=-1)
        groups[name] = np.hstack([facets, count + np.searchsorted(keys, _keys(sides, count))])
    return VolumeMesh(
        nodes=np.vstack([mesh.nodes, middle]),
        elements=np.hstack([mesh.elements, count + edge.reshape(len(mesh.elements), -1)]),
        kind=ElementKind.HEXAHEDRON20,
        groups=groups,
    )


def _keys(ends: IntArray, count: int) -> IntArray:
    """One number per edge, from the nodes (..., 2) at its ends, whichever comes first."""
    keys: IntArray = ends.min(axis=-1) * count + ends.max(axis=-1)
    return keys
