"""Stiffness and body force against closed forms, the patch test and scikit-fem's own assembly."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from elastic_states import hold

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem.assembly import body_force, stiffness
from solvers.fem.elements import STIFFNESS_ORDER, ElementType, displacement_space
from solvers.fem.stress import nodal_stress, point_stress
from solvers.materials import Material

ORACLES = Path(__file__).parents[2] / "oracles"
HEXAHEDRA = [ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE, ElementType.HEXAHEDRON8]
PATCH = tomllib.loads((ORACLES / "structural.toml").read_text(encoding="utf-8"))["patch_test"]


@pytest.fixture
def patch(grid):
    """MacNeal and Harder's cube: one warped brick inside, one between it and each side of the unit cube."""
    outer = grid([0, 1], [0, 1], [0, 1])
    corners = outer.nodes[outer.elements[0]]
    nodes = np.vstack([corners, PATCH["inner_nodes"]])
    sides = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    # Seen from inside, an outer side runs clockwise about its outward normal, so it is an element's bottom.
    around = [[*side[::-1], *(8 + np.array(side[::-1]))] for side in sides]
    elements = np.array([np.arange(8, 16), *around])
    base = np.array([[0, 3, 2, 1]])
    return VolumeMesh(nodes=nodes, elements=elements, kind=ElementKind.HEXAHEDRON, groups={"base": base})


@pytest.fixture
def tetrahedral_patch(grid, tetrahedra):
    """The unit cube in unequal tetrahedra, its inner corner off the planes."""
    mesh = grid([0, 0.3, 1], [0, 0.6, 1], [0, 0.45, 1])
    nodes = mesh.nodes.copy()
    nodes[(nodes == [0.3, 0.6, 0.45]).all(axis=1)] = 0.42, 0.51, 0.58
    return tetrahedra(VolumeMesh(nodes=nodes, elements=mesh.elements, kind=mesh.kind, groups=mesh.groups))


@pytest.mark.parametrize(
    ("fixture", "element"),
    [("tetrahedral_patch", HEXAHEDRA[0]), *(("patch", element) for element in HEXAHEDRA)],
)
def test_patch_test(fixture, element, request):
    mesh = request.getfixturevalue(fixture)
    space = displacement_space(mesh, element)
    material = Material(young=PATCH["young"], poisson=PATCH["poisson"])
    exact = 1e-3 * space.points @ np.array([[2, 1, 1], [1, 2, 1], [1, 1, 2]]) / 2
    boundary = np.flatnonzero(((space.points < 1e-9) | (space.points > 1 - 1e-9)).any(axis=1))
    state = hold(space, material, np.zeros(space.unknowns), points=boundary, values=exact[boundary])
    stress = point_stress(space, material, displacement=state.displacement)
    expected = [PATCH["direct_stress"]] * 3 + [PATCH["shear_stress"]] * 3
    assert len(boundary) < len(space.points)
    assert np.allclose(state.displacement, exact, rtol=0, atol=1e-15)
    assert np.allclose(stress.stress, expected, rtol=1e-10)
    assert np.allclose(nodal_stress(mesh, stress), expected, rtol=1e-10)
    # ½ σ·ε over a unit volume: ½ (3 * 2000 * 1e-3 + 3 * 400 * 1e-3).
    assert state.strain_energy == pytest.approx(3.6)
    assert stress.volume.sum() == pytest.approx(1.0)


def test_stiffness_is_scikit_fems(grid):
    import skfem
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    mesh = grid([0, 1, 1.8], [0, 0.4], [0, 0.7, 1.5], warp=0.05)
    space = displacement_space(mesh)
    own = stiffness(space, Material()).toarray()
    theirs_from_vtk = [6, 2, 5, 7, 1, 3, 4, 0]
    other = skfem.Basis(
        skfem.MeshHex(mesh.nodes.T.copy(), mesh.elements[:, theirs_from_vtk].T.copy()),
        skfem.ElementVector(skfem.ElementHexS2()),
        intorder=STIFFNESS_ORDER[mesh.kind],
    )
    theirs = linear_elasticity(*lame_parameters(3.48e9, 0.16)).assemble(other).toarray()
    # Their numbering is another one: find our point at each of their places; components repeat 0, 1, 2.
    distance = np.linalg.norm(other.doflocs.T[:, None] - space.points[None], axis=2)
    component = np.empty(other.N, dtype=int)
    component[other.element_dofs.ravel()] = np.repeat(np.tile([0, 1, 2], 20), other.element_dofs.shape[1])
    own_number = 3 * distance.argmin(axis=1) + component
    assert distance.min(axis=1).max() < 1e-12
    assert np.allclose(theirs, own[np.ix_(own_number, own_number)], rtol=0, atol=1e-12 * np.abs(own).max())


def test_rigid_motions_need_no_force(make_mesh):
    space = displacement_space(make_mesh([0, 1, 1.8], [0, 0.4], [0, 0.7, 1.5], warp=0.05))
    K = stiffness(space, Material())
    x, y, z = space.points.T
    zero = np.zeros_like(x)
    for motion in ([zero + 1, zero, zero], [z, zero, -x], [-y, x, zero], [zero, -z, y]):
        force = K @ np.stack(motion, axis=-1).ravel()
        assert np.abs(force).max() < 1e-12 * np.abs(K.data).max()


def test_body_force_is_the_weight_of_the_box(make_mesh):
    space = displacement_space(make_mesh([0, 1, 2], [0, 0.5], [0, 1.5, 3]))
    total = body_force(space, [0.0, 7.0, -10.0]).reshape(-1, 3)
    assert np.allclose(total.sum(axis=0), [0.0, 21.0, -30.0])
    # Its moment about the x axis: the weight acts at the middle of the thickness.
    assert total[:, 2] @ space.points[:, 1] == pytest.approx(-30.0 * 0.25)


@pytest.mark.parametrize(
    ("element", "ratio"),
    [
        (ElementType.HEXAHEDRON20, 1.0),
        (ElementType.INCOMPATIBLE, 1.0),
        (ElementType.TETRA10, 1.0),
        # Bending strains of a box that cannot curve: 1 + (1 - ν) (length / depth)² / 2 times too stiff.
        (ElementType.HEXAHEDRON8, 1.0 / 1.5),
    ],
)
def test_cantilever_one_element_deep(grid, tetrahedra, element, ratio):
    """Horizontal load on a slender column: Timoshenko's deflection qL⁴/8EI + qL²/2κGA, κ = 5/6."""
    length, depth, width, E, q = 10.0, 1.0, 0.5, 3.48e9, 1000.0
    mesh = grid([0, depth], [0, width], np.linspace(0, length, 11))
    space = (
        displacement_space(tetrahedra(mesh))
        if element is ElementType.TETRA10
        else displacement_space(mesh, element)
    )
    force = body_force(space, [q / (depth * width), 0, 0])
    still = np.zeros((len(space.base), 3))
    state = hold(space, Material(young=E, poisson=0.0), force, points=space.base, values=still)
    inertia = width * depth**3 / 12
    exact = q * length**4 / (8 * E * inertia) + q * length**2 / (2 * 5 / 6 * E / 2 * depth * width)
    tip = state.displacement[space.points[:, 2] == length, 0].mean()
    assert tip == pytest.approx(ratio * exact, rel=0.02)


@pytest.mark.parametrize(
    "order", [[3, 2, 1, 0, 7, 6, 5, 4], [0, 1, 2, 3, 0, 1, 2, 3]], ids=["folded", "flat"]
)
def test_bad_elements_are_refused(grid, order):
    mesh = grid([0, 1], [0, 1], [0, 1])
    elements = mesh.elements[:, order]
    used, inverse = np.unique(elements, return_inverse=True)
    bad = VolumeMesh(
        nodes=mesh.nodes[used],
        elements=inverse.reshape(-1, 8),
        kind=mesh.kind,
        groups={"base": inverse.reshape(-1, 8)[:, :4]},
    )
    with pytest.raises(InputError, match=r"Element 0 at .* is folded or has no volume"):
        body_force(displacement_space(bad), [0, 0, 1])
