"""Element matrices against scikit-fem's forms and closed forms."""

import numpy as np
import pytest
import skfem
from skfem.models.elasticity import linear_elasticity

from fd2fem.model import ElementKind, VolumeMesh
from solvers.compiled import jit
from solvers.compiled.stiffness import elastic_matrices, element_volumes
from solvers.fem.assembly import body_force, elastic_body, internal_force, stiffness
from solvers.fem.connectivity import rigid_motions
from solvers.fem.elements import STIFFNESS_ORDER, ElementType, displacement_space
from solvers.fem.rules import incompatible_rule, space_rule, stiffness_order, trilinear_rule
from solvers.materials import Material, lame_parameters

MATERIAL = Material(young=3.48e9, poisson=0.3)
LAME = lame_parameters(MATERIAL)
FROM_VTK = [6, 2, 5, 7, 1, 3, 4, 0]
"""VTK's corners as scikit-fem's reference hexahedron has them."""


def _matrices(space):
    body = elastic_body(space, MATERIAL)
    width = 3 * space.connectivity.shape[1]
    matrices = np.empty((len(space.connectivity), width, width))
    elastic_matrices(body.points, body.connectivity, body.rule, body.lame, body.shear, matrices)
    return matrices


def _scikit_fem(mesh, element, order):
    """Element matrices by scikit-fem, one-element meshes, in the order of our points."""
    for corners in mesh.elements:
        nodes = mesh.nodes[corners]
        if mesh.kind is ElementKind.TETRA10:
            # Numbered as they come: scikit-fem would sort the corners.
            grid = skfem.MeshTet(nodes[:4].T.copy(), np.arange(4).reshape(4, 1), sort_t=False)
        else:
            grid = skfem.MeshHex(nodes.T.copy(), np.array(FROM_VTK)[:, None])
        basis = skfem.Basis(grid, skfem.ElementVector(element), intorder=order)
        yield basis, linear_elasticity(LAME.first, LAME.shear).assemble(basis).toarray()


@pytest.mark.parametrize(
    ("kind", "own", "other"),
    [
        ("hexahedron", ElementType.HEXAHEDRON20, skfem.ElementHexS2()),
        ("hexahedron", ElementType.HEXAHEDRON8, skfem.ElementHex1()),
        ("tetra10", ElementType.HEXAHEDRON20, skfem.ElementTetP2()),
    ],
)
def test_element_matrices_are_scikit_fems(grid, tetrahedra, kind, own, other):
    mesh = grid([0, 1, 1.8], [0, 0.4], [0, 0.7], warp=0.05)
    mesh = tetrahedra(mesh) if kind == "tetra10" else mesh
    space = displacement_space(mesh, own)
    for element, (basis, theirs) in enumerate(_scikit_fem(mesh, other, stiffness_order(space))):
        points = space.points[space.connectivity[element]]
        distance = np.linalg.norm(basis.doflocs.T[:, None] - points[None], axis=2)
        assert distance.min(axis=1).max() < 1e-12
        component = np.empty(basis.N, dtype=int)
        per_point = basis.N // 3
        component[basis.element_dofs.ravel()] = np.tile([0, 1, 2], per_point)
        number = 3 * distance.argmin(axis=1) + component
        ours = _matrices(space)[element][np.ix_(number, number)]
        assert np.abs(ours - theirs).max() < 1e-12 * np.abs(theirs).max()


def _spaces(grid, tetrahedra):
    mesh = grid([0, 1, 1.8], [0, 0.4], [0, 0.7, 1.5], warp=0.05)
    hexahedra = (ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE, ElementType.HEXAHEDRON8)
    yield from (displacement_space(mesh, element) for element in hexahedra)
    yield displacement_space(tetrahedra(mesh))


def test_six_rigid_motions_and_no_other_need_no_force(grid, tetrahedra):
    for space in _spaces(grid, tetrahedra):
        matrices = _matrices(space)
        assert np.allclose(matrices, matrices.transpose(0, 2, 1), rtol=0, atol=1e-14 * np.abs(matrices).max())
        for matrix, points in zip(matrices, space.connectivity, strict=True):
            sizes = np.linalg.eigvalsh(matrix)
            assert np.abs(sizes[:6]).max() < 1e-12 * sizes[-1]
            assert sizes[6] > 1e-6 * sizes[-1]
            assert np.abs(matrix @ rigid_motions(space.points[points])).max() < 1e-12 * sizes[-1]


def test_forces_from_stresses_are_those_of_the_matrix(grid, tetrahedra):
    rng = np.random.default_rng(3)
    for space in _spaces(grid, tetrahedra):
        u = rng.normal(size=(len(space.points), 3))
        force, bound = internal_force(elastic_body(space, MATERIAL), u)
        expected = (stiffness(space, MATERIAL) @ u.ravel()).reshape(-1, 3)
        assert np.abs(force - expected).max() < 1e-12 * np.abs(expected).max()
        assert (bound >= np.abs(force)).all()


def test_modes_let_a_box_bend():
    """Pure bending of a cube, ν = 0: E I κ² L / 2 = E / 24 with the modes, half as much again without.

    The corners move by u_x = κ x z; what bends is exact, and what does not carries a parasitic shear.
    """
    corners = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float
    )
    x, _, z = (corners - 0.5).T
    u = np.zeros((8, 3))
    u[:, 0] = x * z
    energies = []
    for rule in (incompatible_rule(), trilinear_rule()):
        matrix = np.empty((1, 24, 24))
        elastic_matrices(corners, np.arange(8).reshape(1, 8), rule, 0.0, 0.5, matrix)
        energies.append(0.5 * u.ravel() @ matrix[0] @ u.ravel())
    assert energies == pytest.approx([1 / 24, 1.5 / 24], rel=1e-12)


def test_volumes_add_up(grid, tetrahedra):
    # A sheared box keeps its volume.
    mesh = grid([0, 1, 1.8], [0, 0.4], [0, 0.7, 1.5])
    nodes = mesh.nodes + 0.3 * mesh.nodes[:, [2, 0, 1]] * [1, 0, 0]
    sheared = VolumeMesh(nodes=nodes, elements=mesh.elements, kind=mesh.kind, groups=mesh.groups)
    for space in (displacement_space(sheared), displacement_space(tetrahedra(sheared))):
        rule = space_rule(space, STIFFNESS_ORDER[space.kind])
        volumes = element_volumes(space.points, space.connectivity, rule)
        assert volumes.sum() == pytest.approx(1.8 * 0.4 * 1.5, rel=1e-12)


@pytest.mark.parametrize("element", [ElementType.INCOMPATIBLE, ElementType.HEXAHEDRON8])
def test_corners_share_the_weight_of_a_box(grid, element):
    space = displacement_space(grid([0, 2], [0, 0.5], [0, 3]), element)
    assert np.allclose(body_force(space, [0, 0, -8.0]).reshape(-1, 3), [0, 0, -3.0])


def test_any_number_of_cores_gives_the_same_sums(grid, monkeypatch):
    monkeypatch.setattr(jit, "CHUNK", 7)
    space = displacement_space(grid(np.arange(6), [0, 0.4], np.arange(6)))
    sums = []
    for cores in (1, 4):
        monkeypatch.setattr(jit, "_cores", lambda cores=cores: cores)
        sums.append(stiffness(space, MATERIAL).data)
    assert np.array_equal(*sums)


def test_an_error_in_a_chunk_comes_through(monkeypatch):
    monkeypatch.setattr(jit, "CHUNK", 2)

    def fail(part):
        if part.start == 4:
            raise ValueError(part.start)
        return part.start

    with pytest.raises(ValueError, match="4"):
        list(jit.in_chunks(20, fail))
    assert [start for _, start in jit.in_chunks(4, fail)] == [0, 2]
    assert list(jit.in_chunks(0, fail)) == []
