"""20-node hexahedra against gmsh's own, and against the points that the analysis adds."""

import gmsh
import numpy as np
import pytest
from exported_meshes import HEX_FACETS, all_kinds, groups_of, hexahedra, hexahedra20
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.meshing import write_mesh
from fd2fem.meshing.order import quadratic_mesh
from fd2fem.meshing.session import gmsh_session
from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem.elements import displacement_space

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])


@pytest.fixture(scope="module")
def mesh():
    return hexahedra()


def test_the_points_are_those_of_the_analysis(mesh):
    space = displacement_space(mesh)
    quadratic = quadratic_mesh(mesh)
    np.testing.assert_array_equal(quadratic.nodes, space.points)
    np.testing.assert_array_equal(quadratic.elements, space.connectivity)
    np.testing.assert_array_equal(quadratic.group_nodes("base"), space.base)


def test_as_made_by_hand(mesh):
    ours, theirs = quadratic_mesh(mesh), hexahedra20(mesh)
    assert ours.kind is ElementKind.HEXAHEDRON20
    np.testing.assert_array_equal(ours.nodes, theirs.nodes)
    np.testing.assert_array_equal(ours.elements, theirs.elements)
    assert set(ours.groups) == set(theirs.groups)
    for name, facets in theirs.groups.items():
        np.testing.assert_array_equal(ours.groups[name], facets)


def test_as_gmsh_raises_the_order(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.msh")
    with gmsh_session({"Mesh.SecondOrderIncomplete": 1.0}):
        gmsh.merge(str(tmp_path / "wall.msh"))
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, elements = gmsh.model.mesh.getElementsByType(17)
    place = np.empty((int(tags.max()) + 1, 3))
    place[tags.astype(int)] = coordinates.reshape(-1, 3)
    quadratic = quadratic_mesh(mesh)
    assert len(quadratic.nodes) == len(tags)
    # gmsh numbers the edges 01 03 04 12 15 23 26 37 45 47 56 67 (its manual, node ordering)
    vtk = [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]
    theirs = place[elements.astype(int).reshape(-1, 20)[:, vtk]]
    np.testing.assert_allclose(quadratic.nodes[quadratic.elements], theirs, atol=1e-14)


@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10"])
def test_quadratic_meshes_stay(kind):
    mesh = all_kinds()[kind]
    assert quadratic_mesh(mesh) is mesh


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.permutations(range(27)))
def test_any_numbering_of_warped_bricks(seed, number):
    rng = np.random.default_rng(seed)
    nodes = np.stack(np.meshgrid(*[range(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    first = np.stack(np.meshgrid(*[range(2)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    elements = np.asarray(number)[(first + CORNERS) @ [9, 3, 1]]
    placed = np.empty_like(nodes)
    placed[np.asarray(number)] = nodes
    groups = groups_of(placed, elements, HEX_FACETS)
    warped = placed + rng.uniform(-0.2, 0.2, placed.shape)
    mesh = quadratic_mesh(VolumeMesh(warped, elements, ElementKind.HEXAHEDRON, groups))
    # 27 corners; 54 edges, by Euler: a grid of 3 x 3 x 3 has 3 * 2 * 9
    assert len(mesh.nodes) == 27 + 54
    ends = np.array([0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7]).reshape(-1, 2)
    middle = mesh.nodes[mesh.elements[:, ends]].mean(axis=2)
    np.testing.assert_allclose(mesh.nodes[mesh.elements[:, 8:]], middle, atol=1e-15)
    for facets in mesh.groups.values():
        corners = mesh.nodes[facets[:, :4]]
        np.testing.assert_allclose(
            mesh.nodes[facets[:, 4:]], (corners + np.roll(corners, -1, axis=1)) / 2, atol=1e-15
        )
