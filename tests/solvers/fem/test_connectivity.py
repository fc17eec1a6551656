"""Loose parts of a mesh."""

import numpy as np
import pytest
from exported_meshes import hexahedra20

from fd2fem.errors import InputError
from fd2fem.model import VolumeMesh
from solvers.fem.connectivity import check_held, check_supported, rigid_motions


def test_a_wall_with_an_opening_stands(punched_wall, tetrahedra):
    check_supported(punched_wall)
    check_supported(tetrahedra(punched_wall))
    check_supported(hexahedra20(punched_wall))


def test_two_walls_side_by_side_stand(make_mesh):
    check_supported(make_mesh([0, 1, 2, 3], [0, 1], [0, 1, 2], keep=lambda c: np.abs(c[:, 0] - 1.5) > 0.5))


def test_a_floating_part_is_named(make_mesh):
    mesh = make_mesh([0, 1, 2], [0, 1], [0, 1, 2, 3], keep=lambda c: np.abs(c[:, 2] - 1.5) > 0.5)
    count = len(mesh.elements) // 2
    with pytest.raises(InputError, match=f"loose part of {count} elements around x = 1, z = 2.5 m"):
        check_supported(mesh)


def test_a_hinge_is_no_support(grid):
    # The second storey's brick touches the first one along an edge only.
    mesh = grid([0, 1, 2], [0, 1], [0, 1, 2], keep=lambda c: (c[:, 0] > 1) == (c[:, 2] > 1))
    with pytest.raises(InputError, match="loose part of 1 elements"):
        check_supported(mesh)


def test_a_base_of_foreign_facets_is_refused(grid):
    mesh = grid([0, 1], [0, 1], [0, 1])
    odd = VolumeMesh(
        nodes=mesh.nodes, elements=mesh.elements, kind=mesh.kind, groups={"base": np.array([[0, 2, 5, 7]])}
    )
    with pytest.raises(InputError, match="1 of its 1 facets belong to no element"):
        check_supported(odd)


def test_a_missing_base_is_refused(grid):
    mesh = grid([0, 1], [0, 1], [0, 1])
    with pytest.raises(InputError, match="no group 'base'"):
        check_supported(VolumeMesh(nodes=mesh.nodes, elements=mesh.elements, kind=mesh.kind, groups={}))


def _held(mesh, components):
    held = np.zeros((len(mesh.nodes), 3), dtype=bool)
    held[np.ix_(mesh.group_nodes("base"), components)] = True
    return held


def test_a_tied_base_holds(make_mesh):
    # One element across: held even where the base is narrow beside the wall's height.
    mesh = make_mesh([0, 0.5], [0, 0.3], np.linspace(0, 20, 21))
    check_held(mesh, mesh.nodes, _held(mesh, [0, 1, 2]))


@pytest.mark.parametrize(
    ("components", "motion"),
    [([1, 2], "shift along x"), ([0, 2], "shift along y"), ([0, 1], "shift along z|turn about [xy]")],
)
def test_a_base_that_may_slide_is_refused(make_mesh, components, motion):
    mesh = make_mesh([0, 1, 2], [0, 0.4], [0, 1, 2])
    with pytest.raises(
        InputError, match=rf"not held well enough: its part around x = 1,.*free to move \({motion}"
    ):
        check_held(mesh, mesh.nodes, _held(mesh, components))


def test_a_base_held_at_one_node_may_turn(make_mesh):
    mesh = make_mesh([0, 1, 2], [0, 0.4], [0, 1, 2])
    held = np.zeros((len(mesh.nodes), 3), dtype=bool)
    held[mesh.group_nodes("base")[0]] = True
    with pytest.raises(InputError, match="free to move"):
        check_held(mesh, mesh.nodes, held)


def test_each_part_needs_its_own_hold(make_mesh):
    mesh = make_mesh([0, 1, 2, 3], [0, 1], [0, 1, 2], keep=lambda c: np.abs(c[:, 0] - 1.5) > 0.5)
    held = _held(mesh, [0, 1, 2])
    check_held(mesh, mesh.nodes, held)
    held[mesh.nodes[:, 0] > 1.5] = False
    with pytest.raises(InputError, match=r"part around x = 2\.5, z = 1 m is free to move"):
        check_held(mesh, mesh.nodes, held)


def test_rigid_motions_keep_distances():
    points = np.random.default_rng(1).normal(size=(20, 3))
    motions = rigid_motions(points).reshape(20, 3, 6)
    # A small motion keeps the length of every line: (a - b) · (u(a) - u(b)) = 0.
    lines = points[:, None] - points[None]
    change = motions[:, None] - motions[None]
    assert np.abs(np.einsum("abi,abim->abm", lines, change)).max() < 1e-12
    assert np.linalg.matrix_rank(motions.reshape(60, 6)) == 6
