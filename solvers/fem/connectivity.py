"""Whether every part of a mesh stands on the base, and is held there."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import VolumeMesh, topology

__all__ = ["check_held", "check_supported", "mesh_parts", "parts", "rigid_motions"]

FACETS = {kind: np.array(facets)[:, : kind.facet_corners] for kind, facets in topology.FACETS.items()}
"""Corners of each element's facets, without the middles of their edges."""

MOTIONS = ("shift along x", "shift along y", "shift along z", "turn about x", "turn about y", "turn about z")
"""Rigid motions, in the order of :func:`rigid_motions`."""
LOOSE = 1e-6
"""What holds a rigid motion at less than this part of the wall's size does not hold it."""


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


def mesh_parts(mesh: VolumeMesh) -> NDArray[np.intp]:
    """Part, numbered from 0, that each element of a mesh belongs to."""
    corners = FACETS[mesh.kind]
    facets = np.sort(mesh.elements[:, corners].reshape(-1, corners.shape[1]), axis=1)
    return parts(_numbers(facets).reshape(len(mesh.elements), -1))


def _numbers(facets: NDArray[np.intp]) -> NDArray[np.intp]:
    """The same number (f,) for equal rows of an (f, k) array, from 0: numpy's unique, eight times as fast."""
    number, base = facets[:, 0], int(facets.max()) + 1
    for column in facets.T[1:]:
        number = np.unique(number * base + column, return_inverse=True)[1]
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
    number = _numbers(together)
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


def check_held(mesh: VolumeMesh, points: NDArray[np.float64], held: NDArray[np.bool_]) -> None:
    """Check that no part of a mesh can move without being strained.

    Parameters
    ----------
    mesh : VolumeMesh
    points : (m, 3) float array, m
        That carry displacements, the mesh's nodes first.
    held : (m, 3) bool array
        Displacements that a support or a spring holds.

    Raises
    ------
    InputError
        If a part can shift or turn freely.
    """
    part = mesh_parts(mesh)
    on_nodes = held[: len(mesh.nodes)]
    for number in range(int(part.max()) + 1):
        nodes = np.unique(mesh.elements[part == number])
        motions = rigid_motions(points[nodes])[on_nodes[nodes].ravel()]
        sizes, directions = np.linalg.eigh(motions.T @ motions / max(1, len(motions)))
        if sizes[0] <= LOOSE**2:
            x, _, z = points[nodes].mean(axis=0)
            motion = MOTIONS[int(np.abs(directions[:, 0]).argmax())]
            msg = (
                f"The wall is not held well enough: its part around x = {x:.3g}, z = {z:.3g} m "
                f"is free to move ({motion}). Tie its base."
            )
            raise InputError(msg)


def rigid_motions(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Motions that strain nothing: three shifts, and three turns about the middle.

    Parameters
    ----------
    points : (m, 3) float array, m

    Returns
    -------
    motions : (3m, 6) float array
        Components x, y, z of each point in turn; the turns in units of the longest distance from the middle,
        so that all six are of one size.
    """
    arm = points - points.mean(axis=0)
    arm /= np.abs(arm).max() or 1.0
    x, y, z = arm.T
    motions = np.zeros((len(points), 3, 6))
    motions[:, range(3), range(3)] = 1.0
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 0, 4], motions[:, 2, 4] = z, -x
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions.reshape(-1, 6)
