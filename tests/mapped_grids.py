"""Structured grids of hexahedra, mapped onto curved bodies; for benchmarks."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem.elements import HEXAHEDRON_CORNERS, HEXAHEDRON_EDGES

FloatArray = NDArray[np.float64]
Mapping3 = Callable[[FloatArray], FloatArray]

FACETS = {
    "w0": (0, 3, 2, 1),
    "w1": (4, 5, 6, 7),
    "v0": (0, 1, 5, 4),
    "u1": (1, 2, 6, 5),
    "v1": (2, 3, 7, 6),
    "u0": (3, 0, 4, 7),
}
"""Corners of a hexahedron's facets, right-handed about the outward normal, named by where they lie."""


def mapped_mesh(planes: Sequence[ArrayLike], mapping: Mapping3, *, kind: ElementKind) -> VolumeMesh:
    """Hexahedra between planes u, v, w, mapped by (n, 3) -> (n, 3); their middles are mapped as well.

    Groups are "u0" to "w1", the outer facets of the grid, and "base", which is "w0".
    """
    steps = [np.asarray(p, dtype=float) for p in planes]
    halves = [np.interp(np.arange(2 * len(p) - 1) / 2, np.arange(len(p)), p) for p in steps]
    shape = tuple(len(p) for p in halves)
    cells = np.stack(np.meshgrid(*(2 * np.arange(len(p) - 1) for p in steps), indexing="ij"), -1).reshape(
        -1, 3
    )
    local = 2 * HEXAHEDRON_CORNERS.astype(int)
    if kind is ElementKind.HEXAHEDRON20:
        local = np.vstack([local, local[HEXAHEDRON_EDGES].sum(axis=1) // 2])
    lattice = cells[:, None] + local
    number = np.ravel_multi_index(tuple(np.moveaxis(lattice, -1, 0)), shape)
    used, elements = np.unique(number, return_inverse=True)
    u, v, w = np.unravel_index(used, shape)
    nodes = mapping(np.column_stack([halves[0][u], halves[1][v], halves[2][w]]))
    elements = elements.reshape(number.shape)
    groups = _groups(lattice, elements, shape)
    return VolumeMesh(nodes=nodes, elements=elements, kind=kind, groups=groups | {"base": groups["w0"]})


def _groups(
    lattice: NDArray[np.intp], elements: NDArray[np.intp], shape: tuple[int, ...]
) -> dict[str, NDArray[np.intp]]:
    groups = {}
    for name, corners in FACETS.items():
        axis, end = "uvw".index(name[0]), int(name[1])
        local = list(corners)
        if elements.shape[1] == 20:
            edges = [tuple(sorted(edge)) for edge in HEXAHEDRON_EDGES.tolist()]
            sides = zip(corners, corners[1:] + corners[:1], strict=True)
            local += [8 + edges.index((min(side), max(side))) for side in sides]
        at_end = (lattice[:, corners, axis] == end * (shape[axis] - 1)).all(axis=1)
        groups[name] = elements[at_end][:, local]
    return groups


def joined(*meshes: VolumeMesh) -> VolumeMesh:
    """Meshes that touch, made one: nodes that coincide are merged, groups of one name put together."""
    nodes = np.vstack([mesh.nodes for mesh in meshes])
    size = float(np.ptp(nodes, axis=0).max())
    keys, inverse = np.unique(np.round(nodes / (1e-7 * size)).astype(np.int64), axis=0, return_inverse=True)
    number, at = inverse.ravel(), np.cumsum([0] + [len(mesh.nodes) for mesh in meshes])
    merged = np.empty((len(keys), 3))
    merged[number] = nodes
    elements = np.vstack([number[mesh.elements + a] for mesh, a in zip(meshes, at[:-1], strict=True)])
    groups = {
        name: np.vstack([number[mesh.groups[name] + a] for mesh, a in zip(meshes, at[:-1], strict=True)])
        for name in meshes[0].groups
    }
    return VolumeMesh(nodes=merged, elements=elements, kind=meshes[0].kind, groups=groups)


def graded(start: float, stop: float, count: int, ratio: float) -> FloatArray:
    """`count` steps from start to stop; the last is `ratio` times the first."""
    sizes = ratio ** (np.arange(count) / max(count - 1, 1))
    planes: FloatArray = start + (stop - start) * np.concatenate([[0.0], np.cumsum(sizes)]) / sizes.sum()
    return planes
