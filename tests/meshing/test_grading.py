import numpy as np
import pytest
from curved_walls import plain
from mesh_oracles import assert_conformal, assert_fills, vtk_quality

from fd2fem.errors import InputError
from fd2fem.meshing import MeshOptions, mesh_facade
from fd2fem.meshing.grading import grade_lattice
from fd2fem.meshing.lattice import build_lattice
from fd2fem.meshing.sizes import GROWTH, opening_corners
from fd2fem.meshing.walls import wall_rings
from fd2fem.model import Facade, Storey, rectangle

WALL = Facade(rectangle(0, 0, 8, 7), 0.4, (plain(1, 2, 2, 1.5, 2), plain(2, 5, 0, 1.2, 2.3)))


def test_steps_grow_from_the_corners():
    lattice = build_lattice(wall_rings(WALL), tolerance=0.1)
    graded = grade_lattice(lattice, opening_corners(WALL), size=0.3, corner_size=0.05, pier_elements=2)
    steps = np.diff(graded.columns)
    beside = np.isin(graded.columns[:-1].round(9), [2, 3.5, 5, 6.2])
    assert steps[beside] == pytest.approx([0.05] * 4, rel=0.25)
    assert steps.max() == pytest.approx(0.3, rel=0.2)
    assert max((steps[1:] / steps[:-1]).max(), (steps[:-1] / steps[1:]).max()) < 1.0 + 1.5 * GROWTH
    area = np.diff(graded.columns)[:, None] * np.diff(graded.rows)
    assert area[graded.wall].sum() == pytest.approx(WALL.wall_area)


def test_a_refined_mesh_is_still_exact():
    options = MeshOptions(size=0.3, corner_size=0.06)
    mesh = mesh_facade(WALL, options=options)
    assert vtk_quality(mesh).min() > 0.99
    assert_conformal(mesh)
    assert_fills(mesh, WALL)
    plain_mesh = mesh_facade(WALL, options=MeshOptions(size=0.3))
    assert len(plain_mesh.elements) < len(mesh.elements) < 20 * len(plain_mesh.elements)


def test_with_storeys_and_edges_that_almost_line_up():
    openings = (plain(1, 2, 2, 1.5, 2), plain(2, 2.02, 4.6, 1.5, 1.5), plain(3, 5, 2.03, 1.2, 2))
    facade = Facade(rectangle(0, 0, 8, 7), 0.5, openings, storeys=(Storey(4.2, 0.3),))
    mesh = mesh_facade(facade, options=MeshOptions(size=0.3, corner_size=0.05))
    assert vtk_quality(mesh).min() > 0.8
    assert_conformal(mesh)
    assert_fills(mesh, facade)


def test_piers_get_their_elements():
    facade = Facade(rectangle(0, 0, 6, 4), 0.4, (plain(1, 1, 1, 1, 1), plain(2, 2.2, 1, 1, 1)))
    lattice = build_lattice(wall_rings(facade), tolerance=0.1)
    graded = grade_lattice(lattice, opening_corners(facade), size=0.5, corner_size=0.4, pier_elements=5)
    assert ((graded.columns > 2.0 - 1e-9) & (graded.columns < 2.2 - 1e-9)).sum() == 5


def test_no_openings_no_refinement():
    facade = Facade(rectangle(0, 0, 6, 4), 0.4)
    refined = mesh_facade(facade, options=MeshOptions(size=0.5, corner_size=0.05))
    assert len(refined.elements) == 12 * 8


def test_coarser_than_the_elements_is_refused():
    with pytest.raises(InputError, match=r"'corner_size': 0\.3 m is more than the size of 0\.25 m"):
        mesh_facade(WALL, options=MeshOptions(corner_size=0.3))
