"""Structured grids cut into 10-node tetrahedra and mapped onto curved bodies; for benchmarks."""

from collections.abc import Sequence

import numpy as np
from exported_meshes import SPLIT
from mapped_grids import Mapping3
from numpy.typing import ArrayLike, NDArray

from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem.elements import HEXAHEDRON_CORNERS, TETRAHEDRON_EDGES

FACETS = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
"""Corners of a tetrahedron's facets, right-handed about the outward normal."""


def mapped_tetrahedra(planes: Sequence[ArrayLike], mapping: Mapping3) -> VolumeMesh:
    """Six tetrahedra in each brick between planes u, v, w; the middles of their edges are mapped as well.

    Groups as those of `mapped_grids.mapped_mesh`.
    """
    steps = [np.asarray(p, dtype=float) for p in planes]
    halves = [np.interp(np.arange(2 * len(p) - 1) / 2, np.arange(len(p)), p) for p in steps]
    shape = tuple(len(p) for p in halves)
    cells = np.stack(np.meshgrid(*(2 * np.arange(len(p) - 1) for p in steps), indexing="ij"), -1)
    bricks = cells.reshape(-1, 1, 3) + 2 * HEXAHEDRON_CORNERS.astype(int)
    corners = bricks[:, SPLIT].reshape(-1, 4, 3)
    lattice = np.concatenate([corners, corners[:, TETRAHEDRON_EDGES].sum(axis=2) // 2], axis=1)
    number = np.ravel_multi_index(tuple(np.moveaxis(lattice, -1, 0)), shape)
    used, elements = np.unique(number, return_inverse=True)
    where = np.unravel_index(used, shape)
    nodes = mapping(np.column_stack([half[at] for half, at in zip(halves, where, strict=True)]))
    groups = _groups(lattice, elements.reshape(number.shape), shape)
    return VolumeMesh(nodes, elements.reshape(number.shape), ElementKind.TETRA10, groups)


def _groups(
    lattice: NDArray[np.intp], elements: NDArray[np.intp], shape: tuple[int, ...]
) -> dict[str, NDArray[np.intp]]:
    edges = [frozenset(edge) for edge in TETRAHEDRON_EDGES.tolist()]
    facets = np.array(
        [
            [*facet, *(4 + edges.index(frozenset(p)) for p in zip(facet, facet[1:] + facet[:1], strict=True))]
            for facet in FACETS
        ]
    )
    places, nodes = lattice[:, facets].reshape(-1, 6, 3), elements[:, facets].reshape(-1, 6)
    groups = {}
    for axis, letter in enumerate("uvw"):
        for end in (0, 1):
            groups[f"{letter}{end}"] = nodes[(places[..., axis] == end * (shape[axis] - 1)).all(axis=1)]
    return groups | {"base": groups["w0"]}
