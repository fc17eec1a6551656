"""Loose parts of a mesh."""

import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import VolumeMesh
from solvers.connectivity import check_supported


def test_a_wall_with_an_opening_stands(punched_wall, tetrahedra):
    check_supported(punched_wall)
    check_supported(tetrahedra(punched_wall))


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
