"""Facets of a mesh: which are the same, which lie on its boundary."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind
from fd2fem.model.topology import FACETS

__all__ = ["boundary_facets", "facet_keys"]

IntArray = NDArray[np.intp]


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
