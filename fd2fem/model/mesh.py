"""The finite element mesh of a facade."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, as_points

__all__ = ["ElementKind", "MeshQuality", "VolumeMesh"]


class ElementKind(StrEnum):
    """Kinds of elements, by meshio's names."""

    HEXAHEDRON = "hexahedron"
    HEXAHEDRON20 = "hexahedron20"
    TETRA10 = "tetra10"

    @property
    def nodes(self) -> int:
        """Nodes of an element."""
        return {"hexahedron": 8, "hexahedron20": 20, "tetra10": 10}[self.value]

    @property
    def facet_nodes(self) -> int:
        """Nodes of a facet."""
        return {"hexahedron": 4, "hexahedron20": 8, "tetra10": 6}[self.value]

    @property
    def facet_corners(self) -> int:
        """Corners of a facet, which come first among its nodes."""
        return 3 if self is ElementKind.TETRA10 else 4


@dataclass(frozen=True, eq=False)
class VolumeMesh:
    """Nodes, elements and named groups of facets.

    Attributes
    ----------
    nodes : (n, 3) float array, m
        Facade frame.
    elements : (e, 8), (e, 20) or (e, 10) int array
        Nodes of each element from 0, in VTK's order, positive volume.
    kind : ElementKind
    groups : mapping of str to (f, 4), (f, 8) or (f, 6) int arrays
        Facets by name (:data:`~fd2fem.model.GROUPS`): nodes of each, corners first, right-handed about the
        outward normal; then the middles of its edges.

    Raises
    ------
    InputError
        If an element or a facet names a node that is not there, or a node belongs to no element.
    """

    nodes: NDArray[np.float64]
    elements: NDArray[np.intp]
    kind: ElementKind
    groups: Mapping[str, NDArray[np.intp]]

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", as_points("nodes", self.nodes, dim=3))
        object.__setattr__(
            self, "elements", as_array("elements", self.elements, (None, self.kind.nodes), dtype=np.intp)
        )
        groups = {
            name: as_array(f"group {name}", facets, (None, self.kind.facet_nodes), dtype=np.intp)
            for name, facets in self.groups.items()
        }
        object.__setattr__(self, "groups", MappingProxyType(groups))
        used = np.zeros(len(self.nodes), dtype=bool)
        for name, table in (("elements", self.elements), *groups.items()):
            if table.size and (table.min() < 0 or table.max() >= len(self.nodes)):
                wrong = int(table.min() if table.min() < 0 else table.max())
                msg = f"Invalid '{name}': node {wrong} of a mesh with {len(self.nodes)} nodes."
                raise InputError(msg)
            if name == "elements":
                used[table] = True
        if not used.all():
            msg = f"Invalid 'nodes': {int((~used).sum())} of {len(used)} nodes belong to no element."
            raise InputError(msg)

    def group_nodes(self, name: str) -> NDArray[np.intp]:
        """Sorted node indices of a group.

        Raises
        ------
        InputError
            If the mesh has no such group, or it is empty.
        """
        if name not in self.groups or not len(self.groups[name]):
            msg = f"The mesh has no group '{name}'; it has: {', '.join(self.groups) or 'none'}."
            raise InputError(msg)
        return np.unique(self.groups[name])


@dataclass(frozen=True)
class MeshQuality:
    """How good the elements are.

    `scaled_jacobian` is 1 for a cube and 0 or less for a folded element; `aspect` is the longest
    over the shortest edge; `volume` is the sum over the elements, m³.
    """

    elements: int
    nodes: int
    min_scaled_jacobian: float
    mean_scaled_jacobian: float
    max_aspect: float
    volume: float
