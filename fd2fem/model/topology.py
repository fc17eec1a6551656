"""Edges and facets of each kind of element, by VTK's numbering."""

from collections.abc import Mapping
from types import MappingProxyType

from fd2fem.model.mesh import ElementKind

__all__ = ["EDGES", "FACETS"]

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
