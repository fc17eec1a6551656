"""Pressure on facets: resultants by hand, and a state that it holds in balance."""

import numpy as np
import pytest
from mapped_grids import mapped_mesh

from fd2fem.errors import InputError
from fd2fem.model import ElementKind
from solvers.fem.facet_loads import pressure_forces

HEXAHEDRA = [ElementKind.HEXAHEDRON, ElementKind.HEXAHEDRON20]


def _box(kind):
    return mapped_mesh(([0, 1, 3], [0, 0.5, 2], [0, 1.5, 2]), lambda grid: grid, kind=kind)


def _bent(kind):
    """A quarter of a tube, radii 1 and 2, 3 m long."""

    def mapping(grid):
        r, y, angle = grid.T
        return np.column_stack([r * np.cos(angle), y, r * np.sin(angle)])

    return mapped_mesh(([1, 2], [0, 3], np.linspace(0, np.pi / 2, 5)), mapping, kind=kind)


@pytest.mark.parametrize("kind", HEXAHEDRA)
def test_resultant_on_a_plane(kind):
    mesh = _box(kind)
    force = pressure_forces(mesh, "u1", 5.0).reshape(-1, 3)
    # 5 Pa on 2 x 2 m, against the outward normal; about the middle of the face they have no moment.
    assert force.sum(axis=0) == pytest.approx([-20.0, 0, 0], abs=1e-13)
    assert np.cross(mesh.nodes - [3, 1, 1], force).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-13)
    assert not np.delete(force, mesh.group_nodes("u1"), axis=0).any()


def test_share_of_a_quadratic_facet():
    # Zienkiewicz & Taylor: -1/12 of the force at the corners of a serendipity facet, 1/3 in the middles.
    mesh = mapped_mesh(([0, 1], [0, 1], [0, 1]), lambda grid: grid, kind=ElementKind.HEXAHEDRON20)
    facet = mesh.groups["w1"][0]
    force = pressure_forces(mesh, "w1", 12.0).reshape(-1, 3)
    assert force[facet, 2] == pytest.approx([1.0] * 4 + [-4.0] * 4)


def test_quadratic_triangles(tetrahedra, grid):
    mesh = tetrahedra(grid([0, 1, 2], [0, 0.5], [0, 1]))
    force = pressure_forces(mesh, "base", 6.0).reshape(-1, 3)
    assert force.sum(axis=0) == pytest.approx([0, 0, 6.0])
    # A straight triangle hands a third to each middle, nothing to its corners.
    corners = np.unique(mesh.groups["base"][:, :3])
    assert force[corners] == pytest.approx(np.zeros((len(corners), 3)), abs=1e-15)


@pytest.mark.parametrize("kind", HEXAHEDRA)
def test_resultant_on_a_curved_face(kind):
    # Of a pressure on any surface, the resultant is that on its projection: 2 m x 3 m each way.
    force = pressure_forces(_bent(kind), "u1", 7.0).reshape(-1, 3)
    assert force.sum(axis=0) == pytest.approx([-42.0, 0.0, -42.0], abs=1e-10)


@pytest.mark.parametrize("kind", HEXAHEDRA)
def test_pressure_from_all_sides_cancels(kind):
    mesh = _bent(kind)
    total = sum(pressure_forces(mesh, name, 3.0) for name in ("u0", "u1", "v0", "v1", "w0", "w1"))
    assert total.reshape(-1, 3).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    moment = np.cross(mesh.nodes, total.reshape(-1, 3)).sum(axis=0)
    assert moment == pytest.approx(np.zeros(3), abs=1e-11)


def test_a_group_must_be_there():
    with pytest.raises(InputError, match="no group 'roof'"):
        pressure_forces(_box(ElementKind.HEXAHEDRON), "roof", 1.0)
