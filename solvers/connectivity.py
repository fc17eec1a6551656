"""Whether every part of a mesh stands on the base."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, VolumeMesh

__all__ = ["check_supported", "parts"]

FACETS = {
    ElementKind.HEXAHEDRON: np.array(
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [0, 4, 7, 3], [1, 2, 6, 5]]
    ),
    ElementKind.TETRA10: np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
}
"""Corners of each element's facets, VTK's order."""


def parts(element_facets: NDArray[np.intp]) -> NDArray[np.intp]:
    """Part, numbered from 0, that each element belongs to.

    Elements belong together that share a facet; a shared edge or node is a hinge, which holds nothing.

    Parameters
    ----------
    element_facets : (e, f) int array
        Number of each element's facets, the same in both neighbours.

    Examples
    --------
    Three bars in a row, each with a left and a right end; the last one stands apart.

    >>> parts(np.array([[0, 1], [1, 2], [3, 4]])).tolist()
    [0, 0, 1]
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count, per_element = element_facets.shape
    element = np.repeat(np.arange(count), per_element)
    facet = count + element_facets.ravel()
    size = int(facet.max()) + 1
    links = coo_array((np.ones(len(facet)), (element, facet)), shape=(size, size))
    _, label = connected_components(links, directed=False)
    number: NDArray[np.intp] = np.unique(label[:count], return_inverse=True)[1]
    return number


def check_supported(mesh: VolumeMesh) -> None:
    """Check that every part of a mesh has a facet on the base.

    Raises
    ------
    InputError
        If the mesh has no base, a facet of the base belongs to no element, or a part is loose.
    """
    mesh.group_nodes("base")
    corners = FACETS[mesh.kind]
    of_elements = mesh.elements[:, corners].reshape(-1, corners.shape[1])
    of_base = mesh.groups["base"][:, : corners.shape[1]]
    together = np.sort(np.vstack([of_elements, of_base]), axis=1)
    number = np.unique(together, axis=0, return_inverse=True)[1].ravel()
    element_facets = number[: len(of_elements)].reshape(len(mesh.elements), -1)
    base_facets = number[len(of_elements) :]
    strays = int((~np.isin(base_facets, element_facets)).sum())
    if strays:
        msg = f"Invalid group 'base': {strays} of its {len(of_base)} facets belong to no element."
        raise InputError(msg)
    part = parts(element_facets)
    on_base = np.isin(element_facets, base_facets).any(axis=1)
    loose = ~np.isin(part, part[on_base])
    if loose.any():
        first = part == part[loose][0]
        x, _, z = mesh.nodes[np.unique(mesh.elements[first])].mean(axis=0)
        msg = (
            f"A loose part of {int(first.sum())} elements around x = {x:.3g}, z = {z:.3g} m is not connected "
            f"to the base through facets ({int(loose.sum())} loose elements in all): correct the facade."
        )
        raise InputError(msg)
