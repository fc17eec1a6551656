"""Elements: scikit-fem's shape functions and quadrature, and the points that carry displacements.

By default a mesh of 8-node hexahedra carries 20-node serendipity displacements: the plain 8-node element
is far too stiff in bending (a cantilever one element deep moves a third of what it should). The points in
the middle of the edges are added behind the mesh's own nodes, in the order of VTK's quadratic
hexahedron, which is also that of CalculiX's C3D20. A mesh of 20-node hexahedra brings these points
along and answers the same.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind, VolumeMesh
from fd2fem.model.topology import EDGES

__all__ = ["ElementTable", "ElementType", "Space", "displacement_space", "shape_functions", "tabulate"]

FloatArray = NDArray[np.float64]

HEXAHEDRON_CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=np.float64
)
HEXAHEDRON_EDGES = np.array(EDGES[ElementKind.HEXAHEDRON])
TETRAHEDRON_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float64)
TETRAHEDRON_EDGES = np.array(EDGES[ElementKind.TETRA10])

STIFFNESS_ORDER = {ElementKind.HEXAHEDRON: 5, ElementKind.HEXAHEDRON20: 5, ElementKind.TETRA10: 2}
"""Degree that the stiffness is integrated to: 27 and 4 points, those of C3D20 and C3D10."""

STRESS_ORDER = {ElementKind.HEXAHEDRON: 3, ElementKind.HEXAHEDRON20: 3, ElementKind.TETRA10: 2}
"""Degree of the rule whose points the stresses are taken at: 8 and 4, where they are most accurate."""


class ElementType(StrEnum):
    """What carries the displacements.

    HEXAHEDRON20 is the serendipity element at 27 points, CalculiX's C3D20. INCOMPATIBLE is the 8-node
    hexahedron with incompatible modes: a quarter of the unknowns on the same mesh, as good in bending while
    the elements are near to boxes. HEXAHEDRON8, the same without them (C3D8), locks in bending and is meant
    for comparisons with other programs. TETRA10 is the quadratic tetrahedron at 4 points, C3D10.
    """

    HEXAHEDRON20 = "hexahedron20"
    INCOMPATIBLE = "incompatible"
    HEXAHEDRON8 = "hexahedron8"
    TETRA10 = "tetra10"

    @property
    def eight_nodes(self) -> bool:
        """Whether the corners alone carry displacements."""
        return self in {ElementType.INCOMPATIBLE, ElementType.HEXAHEDRON8}


@dataclass(frozen=True, eq=False)
class ElementTable:
    """Shape functions of a reference element at the points of a quadrature rule.

    Attributes
    ----------
    weights : (q,) float array
    values : (q, b) float array
        Of the b displacement functions.
    gradients : (q, 3, b) float array
    geometry_gradients : (q, 3, g) float array
        Of the functions that map the element's g mesh nodes.
    extrapolation : (g, q) float array
        Values at the mesh nodes of the (tri)linear field that fits values at the points best.
    """

    weights: FloatArray
    values: FloatArray
    gradients: FloatArray
    geometry_gradients: FloatArray
    extrapolation: FloatArray


@dataclass(frozen=True, eq=False)
class Space:
    """The points that carry displacements.

    Attributes
    ----------
    kind : ElementKind
        Of the mesh.
    element : ElementType
    points : (m, 3) float array, m
        The mesh's nodes, then the added mid-edge points.
    connectivity : (e, b) int array
        Points of each element; the first ones are the mesh's nodes.
    base : (k,) int array
        Sorted points of the group "base".
    """

    kind: ElementKind
    element: ElementType
    points: FloatArray
    connectivity: NDArray[np.intp]
    base: NDArray[np.intp]

    @property
    def unknowns(self) -> int:
        """Number of displacement components, prescribed ones included."""
        return 3 * len(self.points)


def displacement_space(mesh: VolumeMesh, element: ElementType = ElementType.HEXAHEDRON20) -> Space:
    """Points of the displacements on a mesh.

    Parameters
    ----------
    mesh : VolumeMesh
    element : ElementType
        What a mesh of 8-node hexahedra becomes; 20-node hexahedra and tetrahedra are taken as they are.

    Raises
    ------
    InputError
        If the mesh has no group "base".
    """
    base = mesh.group_nodes("base")
    if mesh.kind is not ElementKind.HEXAHEDRON or element.eight_nodes:
        own = element if mesh.kind is ElementKind.HEXAHEDRON else ElementType(mesh.kind.value)
        # Copies: the compiled functions would be compiled once more for arrays that are read-only.
        return Space(mesh.kind, own, mesh.nodes.copy(), mesh.elements.copy(), base)
    n = len(mesh.nodes)
    ends = np.sort(mesh.elements[:, HEXAHEDRON_EDGES].reshape(-1, 2), axis=1)
    keys, edge = np.unique(ends[:, 0] * n + ends[:, 1], return_inverse=True)
    middle = 0.5 * (mesh.nodes[keys // n] + mesh.nodes[keys % n])
    facets = mesh.groups["base"]
    sides = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    on_base = np.flatnonzero(np.isin(keys, sides[:, 0] * n + sides[:, 1]))
    return Space(
        kind=mesh.kind,
        element=ElementType.HEXAHEDRON20,
        points=np.vstack([mesh.nodes, middle]),
        connectivity=np.hstack([mesh.elements, n + edge.reshape(-1, len(HEXAHEDRON_EDGES))]),
        base=np.concatenate([base, n + on_base]),
    )


def tabulate(kind: ElementKind, order: int) -> ElementTable:
    """Shape functions at the points of a rule that is exact to the polynomial degree `order`."""
    import skfem
    from skfem.quadrature import get_quadrature

    if kind is ElementKind.TETRA10:
        linear, quadratic = skfem.ElementTetP1(), skfem.ElementTetP2()
        corners, edges = TETRAHEDRON_CORNERS, TETRAHEDRON_EDGES
    else:
        linear, quadratic = skfem.ElementHex1(), skfem.ElementHexS2()
        corners, edges = HEXAHEDRON_CORNERS, HEXAHEDRON_EDGES
    geometry = linear if kind is ElementKind.HEXAHEDRON else quadratic
    nodes = np.vstack([corners, corners[edges].mean(axis=1)])
    points, weights = get_quadrature(quadratic, order)
    values, gradients = shape_functions(quadratic, nodes, points)
    geometry_nodes = nodes[: kind.nodes]
    _, geometry_gradients = shape_functions(geometry, geometry_nodes, points)
    at_points, _ = shape_functions(linear, corners, points)
    at_nodes, _ = shape_functions(linear, corners, geometry_nodes.T)
    return ElementTable(
        weights=weights,
        values=values,
        gradients=gradients,
        geometry_gradients=geometry_gradients,
        extrapolation=at_nodes @ np.linalg.pinv(at_points),
    )


def shape_functions(element: Any, nodes: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (q, b) and gradients (q, 3, b) of scikit-fem's functions, in the order of `nodes`."""
    distance = np.abs(element.doflocs[None] - nodes[:, None]).max(axis=2)
    own = [element.lbasis(points.copy(), int(i)) for i in distance.argmin(axis=1)]
    values = np.stack([np.broadcast_to(value, points.shape[1]) for value, _ in own], axis=-1)
    gradients = np.stack([np.broadcast_to(g.T, points.T.shape) for _, g in own], axis=-1)
    return values, gradients
