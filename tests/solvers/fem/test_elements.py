"""Shape functions and the points that carry displacements."""

import numpy as np
import pytest
from exported_meshes import hexahedra20

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem.elements import displacement_space, tabulate

KINDS = [(ElementKind.HEXAHEDRON, 5, 27), (ElementKind.HEXAHEDRON20, 5, 27), (ElementKind.TETRA10, 2, 4)]
REFERENCE_VOLUME = {ElementKind.HEXAHEDRON: 1.0, ElementKind.HEXAHEDRON20: 1.0, ElementKind.TETRA10: 1 / 6}

# Nodes 9 to 20 of a C3D20, each with the pair it lies between (CalculiX manual, twenty-node brick).
C3D20_EDGES = [(1, 2), (2, 3), (3, 4), (4, 1), (5, 6), (6, 7), (7, 8), (8, 5), (1, 5), (2, 6), (3, 7), (4, 8)]


def _quadratic(points):
    x, y, z = points.T
    return 1 + 2 * x - y + 3 * z + x * x - 2 * y * y + z * z + x * y - 3 * y * z + 2 * x * z


def _quadratic_gradient(points):
    x, y, z = points.T
    return np.stack([2 + 2 * x + y + 2 * z, -1 - 4 * y + x - 3 * z, 3 + 2 * z - 3 * y + 2 * x], axis=-1)


def _reference_nodes(kind):
    if kind is ElementKind.TETRA10:
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
        edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    else:
        corners = np.array(
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
            dtype=float,
        )
        edges = [(a - 1, b - 1) for a, b in C3D20_EDGES]
    return np.vstack([corners, [(corners[a] + corners[b]) / 2 for a, b in edges]])


@pytest.mark.parametrize(("kind", "order", "count"), KINDS)
def test_functions_reproduce_a_quadratic_field(kind, order, count):
    table = tabulate(kind, order)
    nodes = _reference_nodes(kind)
    points = table.values @ nodes
    assert len(table.weights) == count
    assert table.weights.sum() == pytest.approx(REFERENCE_VOLUME[kind])
    assert np.allclose(table.values.sum(axis=1), 1.0)
    assert np.allclose(table.values @ _quadratic(nodes), _quadratic(points), atol=1e-13)
    assert np.allclose(table.gradients @ _quadratic(nodes), _quadratic_gradient(points), atol=1e-13)


@pytest.mark.parametrize(("kind", "order", "count"), [(KINDS[0][0], 3, 8), (KINDS[1][0], 3, 8), KINDS[2]])
def test_extrapolation_of_a_linear_field(kind, order, count):
    table = tabulate(kind, order)
    nodes = _reference_nodes(kind)
    linear = np.array([2.0, -1.0, 3.0])
    at_nodes = table.extrapolation @ (1 + table.values @ nodes @ linear)
    assert table.extrapolation.shape == (kind.nodes, count)
    assert np.allclose(at_nodes, 1 + nodes[: kind.nodes] @ linear, atol=1e-13)


def test_mid_edge_points_follow_c3d20(grid):
    mesh = grid([0, 1], [0, 2], [0, 3], warp=0.1)
    space = displacement_space(mesh)
    assert space.points.shape == (20, 3)
    assert space.unknowns == 60
    own = space.points[space.connectivity[0]]
    for point, (a, b) in zip(own[8:], C3D20_EDGES, strict=True):
        assert np.allclose(point, (own[a - 1] + own[b - 1]) / 2)


def test_neighbours_share_points_and_the_base_has_its_edges(grid):
    # 2 x 1 x 1 bricks: 12 corners and 20 edges; the base has 6 corners and 7 edges.
    space = displacement_space(grid([0, 1, 2], [0, 1], [0, 1]))
    assert len(space.points) == 32
    assert len(space.base) == 13
    assert np.array_equal(space.base, np.flatnonzero(space.points[:, 2] == 0.0))


@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10"])
def test_quadratic_elements_carry_their_own_nodes(grid, tetrahedra, kind):
    change = tetrahedra if kind == "tetra10" else hexahedra20
    mesh = change(grid([0, 1, 3], [0, 1], [0, 1]))
    space = displacement_space(mesh)
    assert np.array_equal(space.points, mesh.nodes)
    assert np.array_equal(space.connectivity, mesh.elements)
    assert np.array_equal(space.base, np.flatnonzero(space.points[:, 2] == 0.0))


def test_a_quadratic_map_may_bend():
    # The reference cube pulled into a barrel, x = X (1 + Z (1 - Z)): det J = 1 + Z (1 - Z), volume 7/6.
    nodes = _reference_nodes(ElementKind.HEXAHEDRON20)
    x, y, z = nodes.T
    bent = np.column_stack([x * (1 + z * (1 - z)), y, z])
    table = tabulate(ElementKind.HEXAHEDRON20, 5)
    determinant = np.linalg.det(table.geometry_gradients @ bent)
    assert determinant @ table.weights == pytest.approx(7 / 6)


def test_a_mesh_needs_a_base(grid):
    mesh = grid([0, 1], [0, 1], [0, 1])
    bare = VolumeMesh(nodes=mesh.nodes, elements=mesh.elements, kind=mesh.kind, groups={})
    with pytest.raises(InputError, match="no group 'base'"):
        displacement_space(bare)
