"""Facets and edges of the elements, by VTK's numbering."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind

__all__ = ["EDGES", "FACETS", "boundary_facets", "facet_keys"]

IntArray = NDArray[np.intp]

EDGES: Mapping[ElementKind, tuple[tuple[int, int], ...]] = MappingProxyType(
    {
        ElementKind.HEXAHEDRON: (
            (0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7),
        ),
        ElementKind.HEXAHEDRON20: (
            (0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7),
        ),
        ElementKind.TETRA10: ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    }
)  # fmt: skip
"""Corners at the ends of each edge; a quadratic element's middles follow its corners in this order."""

FACETS: Mapping[ElementKind, tuple[tuple[int, ...], ...]] = MappingProxyType(
    {
        ElementKind.HEXAHEDRON: (
            (0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7),
        ),
        ElementKind.HEXAHEDRON20: (
            (0, 3, 2, 1, 11, 10, 9, 8), (4, 5, 6, 7, 12, 13, 14, 15), (0, 1, 5, 4, 8, 17, 12, 16),
            (1, 2, 6, 5, 9, 18, 13, 17), (2, 3, 7, 6, 10, 19, 14, 18), (3, 0, 4, 7, 11, 16, 15, 19),
        ),
        ElementKind.TETRA10: (
            (0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (2, 0, 3, 6, 7, 9),
        ),
    }
)  # fmt: skip
"""Nodes of each facet, right-handed about the outward normal: corners, then middles of its edges."""


def facet_keys(facets: IntArray, *, nodes: int) -> IntArray:
    """A number per facet (f, 3, 4, 6 or 8) that, within one call, only facets with the same corners share.

    The three lowest corners tell a facet: two facets of sound elements share no more than an edge.
    """
    corners = np.sort(facets[:, :3] if facets.shape[1] in (3, 6) else facets[:, :4], axis=1)
    if nodes > 2_000_000:
        # The packed number would not fit 64 bits.
        _, key = np.unique(corners, axis=0, return_inverse=True)
        return np.asarray(key.reshape(-1))
    packed: IntArray = (corners[:, 0] * nodes + corners[:, 1]) * nodes + corners[:, 2]
    return packed


def boundary_facets(elements: IntArray, kind: ElementKind, *, nodes: int) -> IntArray:
    """Facets (f, 4, 6 or 8) that belong to a single element, outward."""
    facets = elements[:, np.array(FACETS[kind])].reshape(-1, kind.facet_nodes)
    _, first, count = np.unique(facet_keys(facets, nodes=nodes), return_index=True, return_counts=True)
    single: IntArray = facets[np.sort(first[count == 1])]
    return single
