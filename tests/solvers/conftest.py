"""Meshes made by hand, so that these tests need no mesher."""

from collections.abc import Callable

import numpy as np
import pytest
from exported_meshes import hexahedra20
from numpy.typing import NDArray

from fd2fem.model import ElementKind, VolumeMesh

Keep = Callable[[NDArray[np.float64]], NDArray[np.bool_]]
MakeGrid = Callable[..., VolumeMesh]

# Six tetrahedra around the diagonal from corner 0 to corner 6 of a VTK hexahedron, positive volume.
SPLIT = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
TETRA_EDGES = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])
TETRA_FACETS = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]])


def _grid(xs, ys, zs, *, keep: Keep | None = None, warp: float = 0.0) -> VolumeMesh:
    """Hexahedra between the given planes; `keep` picks them by centre, `warp` moves nodes off the base."""
    shape = len(xs), len(ys), len(zs)
    number = np.arange(np.prod(shape)).reshape(shape)
    low, high = slice(None, -1), slice(1, None)
    corners = [
        number[a, b, c] for c in (low, high) for a, b in ((low, low), (high, low), (high, high), (low, high))
    ]
    elements = np.stack(corners, axis=-1).reshape(-1, 8)
    nodes = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    if keep is not None:
        elements = elements[keep(nodes[elements].mean(axis=1))]
    used, elements = np.unique(elements, return_inverse=True)
    nodes, elements = nodes[used], elements.reshape(-1, 8)
    on_base = nodes[:, 2] < 1e-9
    if warp:
        x, y, z = nodes.T.copy()
        nodes[:, 0] += warp * np.sin(3.1 * z + 0.7 * y + 0.3)
        nodes[:, 1] += warp * np.cos(2.3 * x + z)
        nodes[:, 2] += np.where(on_base, 0.0, warp * np.sin(1.7 * x + 2.9 * y + z))
    base = elements[on_base[elements[:, :4]].all(axis=1)][:, [0, 3, 2, 1]]
    return VolumeMesh(nodes=nodes, elements=elements, kind=ElementKind.HEXAHEDRON, groups={"base": base})


def _tetrahedra(mesh: VolumeMesh) -> VolumeMesh:
    """Every hexahedron cut into six straight quadratic tetrahedra."""
    corners = mesh.elements[:, SPLIT].reshape(-1, 4)
    ends = np.sort(corners[:, TETRA_EDGES].reshape(-1, 2), axis=1)
    edges, edge = np.unique(ends, axis=0, return_inverse=True)
    nodes = np.vstack([mesh.nodes, mesh.nodes[edges].mean(axis=1)])
    elements = np.hstack([corners, len(mesh.nodes) + edge.reshape(-1, 6)])
    facets = elements[:, TETRA_FACETS].reshape(-1, 6)
    base = facets[(nodes[facets][..., 2] < 1e-9).all(axis=1)]
    return VolumeMesh(nodes=nodes, elements=elements, kind=ElementKind.TETRA10, groups={"base": base})


@pytest.fixture(scope="session")
def grid() -> MakeGrid:
    return _grid


@pytest.fixture(scope="session")
def tetrahedra() -> Callable[[VolumeMesh], VolumeMesh]:
    return _tetrahedra


@pytest.fixture(scope="session", params=["hexahedron", "hexahedron20", "tetra10"])
def make_mesh(request: pytest.FixtureRequest) -> MakeGrid:
    """Grid of hexahedra, of 20-node hexahedra, or the same cut into tetrahedra."""
    if request.param == "hexahedron":
        return _grid
    change = hexahedra20 if request.param == "hexahedron20" else _tetrahedra
    return lambda *planes, **options: change(_grid(*planes, **options))


@pytest.fixture(scope="session")
def punched_wall(grid: MakeGrid) -> VolumeMesh:
    """A wall of 3 x 0.4 x 3 m with an opening of a square metre in the middle: 32 elements."""

    def keep(centre: NDArray[np.float64]) -> NDArray[np.bool_]:
        return (np.abs(centre[:, 0] - 1.5) > 0.5) | (np.abs(centre[:, 2] - 1.5) > 0.5)

    return grid(np.linspace(0, 3, 7), [0.0, 0.4], np.linspace(0, 3, 7), keep=keep)
