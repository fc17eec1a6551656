"""Walls as convex cells, exactly."""

import numpy as np
import pytest
from curved_walls import CURVED_WALLS, arcade, plain
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError, MeshError
from fd2fem.meshing import front_cells
from fd2fem.model import Facade, Storey, rectangle


def corner_sines(cells):
    corner = cells.points[cells.corners]
    after, before = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    cross = after[..., 0] * before[..., 1] - after[..., 1] * before[..., 0]
    return cross / np.linalg.norm(after, axis=2) / np.linalg.norm(before, axis=2)


def assert_exact(cells, facade):
    """All convex, of the facade's volume, with all its corners, meeting along whole edges."""
    import shapely

    assert corner_sines(cells).min() > 0.15
    assert cells.volume == pytest.approx(facade.volume, rel=1e-10)
    rings = [facade.outline, *(opening.outline for opening in facade.openings)]
    for corner in np.vstack(rings):
        if corner[1] > 1e-6 or not any(corner is ring for ring in rings):
            assert np.abs(cells.points - corner).max(axis=1).min() < 1e-9 or on_ground(corner, facade)
    edges = np.sort(
        np.stack([cells.corners, np.roll(cells.corners, 1, axis=1)], axis=2).reshape(-1, 2), axis=1
    )
    unique, count = np.unique(edges, axis=0, return_counts=True)
    assert set(count.tolist()) == {1, 2}
    # the edges of single cells are just the wall's boundary: nothing hangs inside it
    single = shapely.linestrings(cells.points[unique[count == 1]])
    wall = shapely.Polygon(facade.outline).difference(
        shapely.union_all([shapely.Polygon(opening.outline) for opening in facade.openings])
    )
    assert shapely.length(single).sum() == pytest.approx(wall.length, rel=1e-9)
    assert shapely.distance(single, wall.boundary).max() < 1e-9
    assert set(np.unique(cells.corners).tolist()) == set(range(len(cells.points)))


def on_ground(corner, facade):
    return corner[1] < 1e-6 and 0.0 < corner[0] < facade.length


@pytest.mark.parametrize("name", CURVED_WALLS)
def test_curved_walls(name):
    facade = CURVED_WALLS[name]
    cells = front_cells(facade, size=0.4)
    assert_exact(cells, facade)
    edges = cells.points[cells.corners] - np.roll(cells.points[cells.corners], 1, axis=1)
    assert np.linalg.norm(edges, axis=2).max() < 2.2 * 0.4


def test_an_arcade():
    facade = arcade()
    cells = front_cells(facade, size=0.5)
    assert_exact(cells, facade)
    assert len(cells.corners) < 15_000


def test_cells_end_at_the_levels():
    facade = CURVED_WALLS["gabled"]
    cells = front_cells(facade, size=0.4)
    z = cells.points[cells.corners, 1]
    for level in (1.17, 4.0):
        assert ((z.min(axis=1) >= level - 1e-9) | (z.max(axis=1) <= level + 1e-9)).all()
    expected = np.select([z.mean(axis=1) < 1.17, z.mean(axis=1) < 4.0], [0.4, 0.35], 0.3)
    np.testing.assert_array_equal(cells.thickness, expected)


def test_a_level_that_grazes_a_slope():
    # the roof rises 5 mm in 4 m: a cell there has an angle of 0.07 degrees
    facade = Facade(np.array([[0, 0], [4, 0], [4, 3.005], [0, 3]]), 0.4, storeys=(Storey(3.002, 0.3),))
    with pytest.raises(MeshError, match="too sharp an angle"):
        front_cells(facade, size=0.4)


def test_a_size_that_is_none():
    with pytest.raises(InputError, match="size"):
        front_cells(CURVED_WALLS["gabled"], size=0.0)


@settings(max_examples=10, deadline=None)
@given(st.randoms(use_true_random=False))
def test_random_quadrilateral_walls(random):
    length, height = random.uniform(3, 9), random.uniform(3, 7)
    lean = [random.uniform(0.0, 0.4) for _ in range(3)]
    outline = np.array([[0, 0], [length, 0], [length - lean[0], height], [lean[1], height - lean[2]]])
    openings = (plain(1, 0.7, 0.9, 0.8, 1.2), plain(2, length - 1.4, random.choice([0.0, 0.5]), 0.6, 1.5))
    storeys = (Storey(round(random.uniform(0.3, 2.5), 2), 0.3),)
    facade = Facade(outline, 0.4, openings, storeys=storeys)
    assert_exact(front_cells(facade, size=random.uniform(0.2, 0.6)), facade)


def test_rectilinear_walls_too():
    facade = Facade(rectangle(0, 0, 5, 4), 0.3, (plain(1, 1, 1, 1, 1), plain(2, 3, 0, 1, 2)))
    assert_exact(front_cells(facade, size=0.5), facade)
