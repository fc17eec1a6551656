"""Interpolation and rigid motions against polynomials, rotations and VTK's own elements."""

import numpy as np
import pytest
from exported_meshes import hexahedra20
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, VolumeMesh
from validation import common_displacements, without_rigid_motion
from validation.sampling import interpolate

GRADIENT = np.array([[1.0, -2.0, 0.5], [0.3, 1.7, -1.1], [2.2, 0.4, 0.9]])


def linear(x):
    return x @ GRADIENT.T + [0.1, -0.2, 0.3]


def quadratic(x):
    return np.column_stack([x[:, 0] * x[:, 1] + x[:, 2] ** 2, x[:, 0] ** 2 - x[:, 1], x[:, 1] * x[:, 2]])


def tetra10(corners, cells):
    """Straight quadratic tetrahedra in VTK's order (midsides 01, 12, 02, 03, 13, 23), nodes not shared."""
    ends = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    nodes = [
        np.vstack([corners[list(c)], *[[0.5 * (corners[c[a]] + corners[c[b]])] for a, b in ends]])
        for c in cells
    ]
    elements = np.arange(10 * len(cells)).reshape(-1, 10)
    return VolumeMesh(np.vstack(nodes), elements, ElementKind.TETRA10, {})


@pytest.fixture
def cube_of_tets():
    """Unit cube as six tetrahedra around its diagonal (Kuhn's division)."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)
    cells = []
    for path in ((4, 2, 1), (4, 1, 2), (2, 4, 1), (2, 1, 4), (1, 4, 2), (1, 2, 4)):
        a, b = path[0], path[0] + path[1]
        cell = [0, a, b, 7]
        sides = corners[cell[1:]] - corners[0]
        cells.append(tuple(cell) if np.linalg.det(sides) > 0 else (0, b, a, 7))
    return tetra10(corners, cells)


def test_linear_field_is_exact_on_a_distorted_grid(grid_mesh):
    mesh = grid_mesh([0, 1, 2.5, 4], [0, 0.2, 0.4], [0, 0.7, 1.5, 3])
    rng = np.random.default_rng(1)
    nodes = mesh.nodes + rng.uniform(-0.06, 0.06, mesh.nodes.shape)
    warped = VolumeMesh(nodes, mesh.elements, mesh.kind, {})
    points = rng.uniform([0.1, 0.08, 0.1], [3.9, 0.32, 2.9], (500, 3))
    values, inside = interpolate(warped, linear(nodes), points)
    assert inside.all()
    assert values == pytest.approx(linear(points), abs=1e-10)


def test_trilinear_field_is_exact_on_bricks(grid_mesh):
    mesh = grid_mesh([0, 1, 4], [0, 0.3], [0, 2, 2.5])
    points = np.random.default_rng(2).uniform([0, 0, 0], [4, 0.3, 2.5], (200, 3))

    def field(x):
        return np.column_stack([x[:, 0] * x[:, 1] * x[:, 2], x[:, 0] * x[:, 2], x[:, 1]])

    values, inside = interpolate(mesh, field(mesh.nodes), points)
    assert inside.all()
    assert values == pytest.approx(field(points), abs=1e-12)


def test_quadratic_field_is_exact_on_tetrahedra(cube_of_tets):
    points = np.random.default_rng(3).uniform(0.0, 1.0, (300, 3))
    values, inside = interpolate(cube_of_tets, quadratic(cube_of_tets.nodes), points)
    assert inside.all()
    assert values == pytest.approx(quadratic(points), abs=1e-12)


def test_quadratic_field_is_exact_on_20_node_bricks(grid_mesh):
    mesh = hexahedra20(grid_mesh([0, 1, 4], [0, 0.3], [0, 2, 2.5], holes=[(1, 1)]))
    points = np.random.default_rng(2).uniform([0, 0, 0], [4, 0.3, 2], (300, 3))
    values, inside = interpolate(mesh, quadratic(mesh.nodes), points)
    assert inside.all()
    assert values == pytest.approx(quadratic(points), abs=1e-12)


def test_points_in_an_opening_or_outside_are_left_out(grid_mesh):
    mesh = grid_mesh([0, 1, 2, 3], [0, 0.4], [0, 1, 2, 3], holes=[(1, 1)])
    points = np.array([[1.5, 0.2, 1.5], [0.5, 0.2, 0.5], [0.5, 0.5, 0.5], [3.2, 0.2, 1.0], [2.99, 0.4, 2.0]])
    values, inside = interpolate(mesh, linear(mesh.nodes), points)
    assert inside.tolist() == [False, True, False, False, True]
    assert values == pytest.approx(linear(points[inside]), abs=1e-12)


def test_no_point_near(grid_mesh):
    mesh = grid_mesh([0, 1], [0, 1], [0, 1])
    values, inside = interpolate(mesh, linear(mesh.nodes), np.array([[9.0, 9.0, 9.0]]))
    assert (values.shape, inside.tolist()) == ((0, 3), [False])


@pytest.mark.parametrize("nodes", [8, 20])
@pytest.mark.parametrize("swap", [True, False])
def test_hexahedra_and_tetrahedra_of_one_cube_agree(grid_mesh, response_on, cube_of_tets, swap, nodes):
    cube = grid_mesh([0, 0.4, 1], [0, 1], [0, 0.5, 1])
    models = [
        response_on(cube if nodes == 8 else hexahedra20(cube), linear),
        response_on(cube_of_tets, linear),
    ]
    candidate, reference = models[::-1] if swap else models
    common = common_displacements(candidate, reference)
    assert common.share == pytest.approx(1.0)
    assert common.weights.sum() == pytest.approx(1.0, rel=1e-12)
    assert np.average(common.points, axis=0, weights=common.weights) == pytest.approx([0.5] * 3)
    assert common.candidate == pytest.approx(common.reference, abs=1e-12)


def test_share_is_the_common_volume(grid_mesh, response_on):
    reference = response_on(grid_mesh([0, 1, 2, 3, 4], [0, 1], [0, 2]), linear)
    candidate = response_on(grid_mesh([0, 1.4, 3.0], [0, 1], [0, 2]), linear)
    common = common_displacements(candidate, reference)
    assert common.share == pytest.approx(0.75)
    assert common.weights == pytest.approx([2.0, 2.0, 2.0])


def test_refuses_models_without_a_common_wall(grid_mesh, response_on):
    metres = response_on(grid_mesh([0, 2, 4], [0, 0.3], [0, 3, 6]), linear)
    millimetres = response_on(grid_mesh([0, 2000, 4000], [0, 300], [0, 3000, 6000]), linear)
    with pytest.raises(InputError, match=r"Only 0 % of the reference's volume .* metres"):
        common_displacements(metres, millimetres)


def test_refuses_folded_elements(grid_mesh, response_on):
    mesh = grid_mesh([0, 1, 2], [0, 1], [0, 1])
    folded = VolumeMesh(mesh.nodes, mesh.elements[:, [4, 5, 6, 7, 0, 1, 2, 3]], mesh.kind, {})
    with pytest.raises(InputError, match="2 of the reference's 2 elements have no positive volume"):
        common_displacements(response_on(mesh, linear), response_on(folded, linear))


vectors = st.tuples(*[st.floats(-0.05, 0.05)] * 3)


@settings(max_examples=40, deadline=None)
@given(vectors, vectors, st.integers(0, 2**31))
def test_a_rigid_motion_leaves_nothing(shift, turn, seed):
    rng = np.random.default_rng(seed)
    points, weights = rng.uniform(0, 12, (30, 3)), rng.uniform(0.5, 2.0, 30)
    motion = np.asarray(shift) + np.cross(turn, points)
    assert np.abs(without_rigid_motion(points, motion, weights=weights)).max() < 1e-13


def test_a_large_rotation_leaves_its_second_order_part():
    # R = 1 + θ× + (θ²/2)(in-plane shrinking): at 5.4 mrad a radius of 6 m leaves at most 6·θ²/2 = 87 µm.
    turn, points = 5.4e-3, np.random.default_rng(4).uniform([0, 0, 0], [5, 0.3, 12], (400, 3))
    moved = Rotation.from_rotvec([0.0, turn, 0.0]).apply(points) - points
    left = without_rigid_motion(points, moved, weights=np.ones(400))
    assert 1e-6 < np.abs(left).max() < 7.0 * turn**2 / 2


def test_a_pure_strain_is_untouched():
    # A symmetric gradient about the centre of a box has no mean displacement and no mean rotation.
    points = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], dtype=float)
    strain = points @ np.array([[1.0, 0.2, 0.1], [0.2, -0.5, 0.3], [0.1, 0.3, 0.4]]) * 1e-3
    centre, sunk = np.array([3.0, 0.2, 6.0]), np.array([0.0, 0.0, -0.04])
    found = without_rigid_motion(points + centre, strain + sunk, weights=np.ones(8))
    assert found == pytest.approx(strain, abs=1e-15)


def test_weights_count_as_copies_of_points():
    rng = np.random.default_rng(5)
    points, field = rng.normal(size=(10, 3)), rng.normal(size=(10, 3))
    twice = without_rigid_motion(
        np.vstack([points, points[:4]]), np.vstack([field, field[:4]]), weights=np.ones(14)
    )
    weights = np.where(np.arange(10) < 4, 2.0, 1.0)
    assert without_rigid_motion(points, field, weights=weights) == pytest.approx(twice[:10], abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "name", "scale"),
    [
        (ElementKind.HEXAHEDRON, "vtkHexahedron", 1.0),
        (ElementKind.HEXAHEDRON20, "vtkQuadraticHexahedron", 1.0),
        (ElementKind.TETRA10, "vtkQuadraticTetra", 0.3),
    ],
)
def test_one_element_is_vtks(grid_mesh, kind, name, scale):
    # VTK evaluates place and weights from its own parametric coordinates, 0 to 1 in both kinds.
    from vtkmodules import vtkCommonDataModel
    from vtkmodules.vtkCommonCore import reference

    rng = np.random.default_rng(6)
    if kind is not ElementKind.TETRA10:
        box = grid_mesh([0, 1], [0, 0.5], [0, 2])
        warped = VolumeMesh(box.nodes + rng.uniform(-0.1, 0.1, (8, 3)), box.elements, box.kind, {})
        warped = hexahedra20(warped) if kind is ElementKind.HEXAHEDRON20 else warped
        nodes = warped.nodes[warped.elements[0]]
    else:
        nodes = tetra10(np.array([[0, 0, 0], [2, 0.1, 0], [0.2, 1, 0], [0.3, 0.2, 3]]), [(0, 1, 2, 3)]).nodes
    mesh = VolumeMesh(nodes, [range(len(nodes))], kind, {})
    field = rng.normal(size=nodes.shape)
    cell = getattr(vtkCommonDataModel, name)()
    for k, node in enumerate(nodes):
        cell.GetPointIds().SetId(k, k)
        cell.GetPoints().SetPoint(k, node)
    for natural in scale * rng.uniform(0.01, 0.99, (20, 3)):
        place, weights = [0.0] * 3, [0.0] * len(nodes)
        cell.EvaluateLocation(reference(0), natural, place, weights)
        values, inside = interpolate(mesh, field, np.array([place]))
        assert inside.all()
        assert values[0] == pytest.approx(np.array(weights) @ field, abs=1e-10)


def test_a_point_in_the_box_of_an_element_may_lie_outside_it(grid_mesh, cube_of_tets):
    # A brick sheared by 1 in x per unit of z: its bounding box holds (1.9, 0.5, 0.1), the brick does not.
    brick = grid_mesh([0, 1], [0, 1], [0, 1])
    sheared = VolumeMesh(brick.nodes @ [[1, 0, 0], [0, 1, 0], [1, 0, 1]], brick.elements, brick.kind, {})
    _, inside = interpolate(sheared, sheared.nodes, np.array([[1.9, 0.5, 0.1], [1.9, 0.5, 0.95]]))
    assert inside.tolist() == [False, True]
    corner = VolumeMesh(cube_of_tets.nodes[:10], [range(10)], ElementKind.TETRA10, {})
    # The first of the six holds x ≥ y ≥ z.
    _, inside = interpolate(corner, corner.nodes, np.array([[0.7, 0.3, 0.1], [0.1, 0.3, 0.7]]))
    assert inside.tolist() == [True, False]
