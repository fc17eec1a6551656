"""Cracks from strains, bays from displacements, and stresses at nodes, by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fd2fem.model import ElementKind
from solvers.damage.bays import bay_strain
from solvers.damage.cracks import crack_widths, element_cracks, principal_axes
from solvers.fem.elements import STRESS_ORDER, tabulate
from solvers.fem.nodal_stress import element_stress, mean_at_nodes
from solvers.fem.stress import principal_stress
from solvers.steps.supports import BaseKind, BaseOptions, base_areas, lifted, spring_forces, support_of


@given(arrays(np.float64, 6, elements=st.floats(-100, 100)))
def test_principal_axes_rebuild_the_tensor(tensor):
    values, axes = principal_axes(tensor)
    matrix = tensor[[0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(3, 3)
    assert np.allclose(axes.T @ np.diag(values) @ axes, matrix, atol=1e-9)
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert values[0] >= values[1] >= values[2]


def test_a_slanted_crack():
    # Across n = (0.6, 0, 0.8), 2 and 1 mm per metre: a band of 2 m opens by their mean, 1.5 mm, times 2.
    n = np.array([0.6, 0.0, 0.8])
    strain = 2e-3 * np.array([n[0] ** 2, 0.0, n[2] ** 2, 0.0, 0.0, 2 * n[0] * n[2]])
    strains = np.stack([[strain, 0.5 * strain], np.zeros((2, 6))])
    cracks = element_cracks(strains, np.ones((2, 2)), np.array([2.0, 2.0]))
    assert cracks.opening.tolist() == pytest.approx([3e-3, 0.0])
    assert np.allclose(cracks.normal, [n, [0, 0, 0]])


def test_of_two_cracks_the_wider_one_counts():
    strains = np.array([[[1e-3, 0.0, 3e-3, 0.0, 0.0, 0.0]]])
    cracks = element_cracks(strains, np.ones((1, 1)), np.array([1.0]))
    assert cracks.opening.tolist() == pytest.approx([3e-3])
    assert np.allclose(cracks.normal, [[0, 0, 1]])


def test_elements_side_by_side_make_one_crack(make_mesh):
    mesh = make_mesh(np.arange(6), [0, 1], [0, 1])
    cell = np.floor(mesh.nodes[mesh.elements].mean(axis=1)[:, 0]).astype(int)
    opening = np.array([3e-3, 1e-3, 0.05e-3, 0.0, 4e-3])[cell]
    assert crack_widths(mesh, opening).tolist() == [4e-3, 3e-3]
    assert crack_widths(mesh, 0 * opening).tolist() == []


def test_bay_strain_of_a_linear_field(make_mesh):
    # By hand: exx = 1e-3, ezz = 0, γxz = 2e-3: 0.5e-3 + √(0.5² + 1²) 1e-3; a rotation adds nothing.
    mesh = make_mesh(np.linspace(0, 4, 5), [0, 0.4], np.linspace(0, 2, 3))
    x, _, z = mesh.nodes.T
    turn = 0.01
    moved = np.column_stack([1e-3 * x + 1e-3 * z - turn * z, 0 * x, 1e-3 * x + turn * x])
    assert bay_strain(mesh, moved) == pytest.approx(0.5e-3 + np.hypot(0.5e-3, 1e-3), rel=1e-9)
    assert bay_strain(mesh, np.column_stack([-turn * z, 0 * x, turn * x])) == pytest.approx(0.0, abs=1e-12)


def test_bay_strain_finds_the_bay_that_is_stretched(grid):
    mesh = grid(np.linspace(0, 4, 9), [0, 0.4], np.linspace(0, 2, 5))
    x = mesh.nodes[:, 0]
    moved = np.column_stack([np.maximum(0.0, x - 2.0) * 1e-3, 0 * x, 0 * x])
    assert bay_strain(mesh, moved) == pytest.approx(1e-3, rel=1e-9)


def _at_nodes(stress, *, cracked, strength=1e6, kind=ElementKind.HEXAHEDRON):
    table = tabulate(kind, STRESS_ORDER[kind])
    return element_stress(kind, table.extrapolation, stress, cracked=np.array([cracked]), strength=strength)


def test_stress_is_extrapolated_as_far_as_the_strength():
    # Linear from 0 to 0.9 MPa between the points: beyond them, 1.23 MPa at the nodes.
    table = tabulate(ElementKind.HEXAHEDRON, 3)
    corners = np.zeros((8, 6))
    corners[[1, 2, 5, 6], 0] = 1.0
    points = (np.linalg.inv(table.extrapolation) @ corners)[None] * 1.2e6
    free = _at_nodes(points, cracked=False, strength=2e6)
    assert np.allclose(free, 1.2e6 * corners[None], atol=1.0)
    limited = _at_nodes(points, cracked=False)
    assert principal_stress(limited)[..., 0].max() == pytest.approx(1e6, rel=1e-9)
    assert np.allclose(limited.mean(axis=1), points.mean(axis=1))


def test_nodes_of_a_cracked_element_take_the_nearest_point():
    points = np.random.default_rng(1).normal(size=(1, 8, 6))
    at_nodes = _at_nodes(points, cracked=True)
    assert sorted(at_nodes[0, :, 0]) == sorted(points[0, :, 0])


@pytest.mark.parametrize("kind", list(ElementKind))
def test_constant_stress_stays_constant(kind):
    count = tabulate(kind, STRESS_ORDER[kind]).weights.size
    points = np.broadcast_to(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), (1, count, 6)).copy()
    for cracked in (False, True):
        at_nodes = _at_nodes(points, cracked=cracked, kind=kind)
        assert at_nodes.shape == (1, kind.nodes, 6)
        assert np.allclose(at_nodes, points[:, :1], atol=1e-12)


def test_mean_at_a_node_between_two_elements(grid):
    mesh = grid([0, 1, 2], [0, 1], [0, 1])
    at_nodes = np.zeros((2, 8, 6))
    at_nodes[0], at_nodes[1] = 1.0, 3.0
    mean = mean_at_nodes(mesh, at_nodes)
    side = mesh.elements[np.argsort(mesh.nodes[mesh.elements].mean(axis=1)[:, 0])]
    only = np.setdiff1d(side[0], side[1]), np.intersect1d(side[0], side[1]), np.setdiff1d(side[1], side[0])
    assert np.unique(mean[only[1]]).tolist() == [2.0]
    assert set(np.unique(mean[np.concatenate([only[0], only[2]])])) == {1.0, 3.0}


def test_areas_of_the_base_add_up(make_mesh):
    mesh = make_mesh([0, 0.5, 2], [0, 0.4], [0, 1])
    areas = base_areas(mesh)
    base = np.zeros(len(areas), dtype=bool)
    base[mesh.group_nodes("base")] = True
    assert areas.sum() == pytest.approx(0.8)
    assert (areas[base] > 0.0).all()
    assert not areas[~base].any()


def test_a_joint_pushes_and_does_not_pull(grid):
    mesh = grid([0, 1], [0, 1], [0, 1])
    base = mesh.group_nodes("base")
    options = BaseOptions(BaseKind.NO_TENSION, normal_stiffness=4e6, shear_stiffness=4e5)
    support = support_of(mesh, mesh.nodes, base, options=options)
    moved = np.zeros((8, 3))
    moved[base, 0], moved[base, 2] = 1e-3, [-1e-3, -1e-3, 1e-3, 1e-3]
    loose = lifted(support, moved, np.zeros((4, 3)))
    force, stiffness = spring_forces(support, moved, np.zeros((4, 3)), loose=loose)
    # A quarter of a square metre each: 1e6 N/m times 1 mm.
    assert force.reshape(-1, 3)[base, 2] == pytest.approx([-1e3, -1e3, 1e-3, 1e-3])
    # Where it was open, it bears no shear either.
    assert force.reshape(-1, 3)[base, 0] == pytest.approx([1e2, 1e2, 1e-4, 1e-4])
    assert (stiffness.reshape(-1, 3)[base] > 0.0).all()


def test_each_building_of_a_row_is_held_along_the_wall(grid):
    mesh = grid([0, 1, 2, 3, 4, 5], [0, 1], [0, 1], keep=lambda c: np.abs(c[:, 0] - 2.5) > 0.5)
    support = support_of(mesh, mesh.nodes, mesh.group_nodes("base"), options=BaseOptions(BaseKind.VERTICAL))
    held = support.prescribed.reshape(-1, 3)
    assert np.unique(mesh.nodes[held[:, 0], 0]).tolist() == [1.0, 4.0]
    assert held[mesh.nodes[:, 2] == 0.0, 1:].all()
