import numpy as np
import pytest
from curved_walls import CURVED_WALLS, plain, round_headed

from fd2fem.meshing.chains import wall_chains
from fd2fem.meshing.dividing import divide_chain
from fd2fem.meshing.options import default_size
from fd2fem.meshing.sizes import GROWTH, SizeField, opening_corners, size_field
from fd2fem.meshing.walls import wall_rings
from fd2fem.model import Facade, Storey, rectangle


def field(facade, *, size=0.25, pier_elements=2, **more):
    levels = [storey.z for storey in facade.storeys]
    chains = wall_chains(wall_rings(facade), levels)
    return size_field(chains, size=size, pier_elements=pier_elements, **more)


def at(sizes, *places):
    return sizes.at(np.array(places, dtype=float))


def test_sizes_grow_from_their_sources():
    sizes = SizeField(np.array([[1.0, 0.0]]), np.array([0.05]), 0.25)
    expected = [0.05, 0.05 + 0.5 * GROWTH, 0.25]
    np.testing.assert_allclose(at(sizes, (1, 0), (1, 0.5), (9, 9)), expected)


def test_a_pier_between_windows():
    facade = Facade(rectangle(0, 0, 6, 4), 0.4, (plain(1, 1, 1, 1.4, 1.5), plain(2, 2.6, 1, 1.4, 1.5)))
    assert at(field(facade), (2.4, 1.7), (2.6, 1.7)) == pytest.approx([0.1, 0.1])
    assert at(field(facade, pier_elements=4), (2.4, 1.7)) == pytest.approx(0.05)
    assert at(field(facade), (0, 2), (6, 2), (1, 1.7)) == pytest.approx([0.25] * 3)


def test_a_pier_beside_a_door_in_the_same_ring():
    facade = Facade(rectangle(0, 0, 6, 4), 0.4, (plain(1, 0.2, 0, 1, 2),))
    assert at(field(facade), (0, 1), (0.2, 1)) == pytest.approx([0.1, 0.1])
    assert at(field(facade), (6, 1)) == pytest.approx(0.25)


def test_windows_that_come_close_at_their_corners():
    facade = Facade(rectangle(0, 0, 6, 6), 0.4, (plain(1, 1, 1, 1, 1), plain(2, 2.06, 2.08, 1, 1)))
    assert at(field(facade), (2, 2)) == pytest.approx(0.05)  # 0.1 m apart, two elements


def test_a_level_close_to_a_sill():
    facade = Facade(rectangle(0, 0, 6, 6), 0.4, (plain(1, 2, 3.1, 2, 1),), storeys=(Storey(3.0, 0.3),))
    assert at(field(facade), (3, 3.1), (3, 3.0)) == pytest.approx([0.05, 0.05])


def test_sharp_corners_are_no_piers():
    # the two slopes meet at the ridge: nothing to be refined
    gable = Facade(CURVED_WALLS["church"].outline, 0.4)
    np.testing.assert_allclose(at(field(gable), *gable.outline), 0.25)


def test_chords_of_curves_bound_the_size():
    facade = CURVED_WALLS["oculi"]
    ring = facade.openings[0].outline
    chord = np.linalg.norm(ring[1] - ring[0])
    assert at(field(facade), (ring[0] + ring[1]) / 2) == pytest.approx(chord)


def test_corners_of_openings():
    facade = Facade(
        rectangle(0, 0, 8, 4), 0.4, (plain(1, 1, 1, 1, 1), plain(2, 3, 0, 1, 2), round_headed(3, 5, 1, 1, 1))
    )
    expected = {(1, 1), (2, 1), (2, 2), (1, 2), (3, 2), (4, 2), (5, 1), (6, 1)}
    assert {tuple(corner) for corner in opening_corners(facade).tolist()} == expected


def test_nodes_grow_from_a_refined_corner():
    facade = Facade(rectangle(0, 0, 8, 4), 0.4, (plain(1, 3, 1, 2, 2),))
    sizes = field(facade, corners=opening_corners(facade), corner_size=0.05)
    sill = next(c for c in wall_chains(wall_rings(facade), []) if c.corners[:, 1].max() == 1.0)
    steps = np.linalg.norm(np.diff(divide_chain(sill, sizes), axis=0), axis=1)
    assert steps[[0, -1]] == pytest.approx([0.05, 0.05], rel=0.2)
    assert steps.max() == pytest.approx(0.25, rel=0.25)
    assert (steps[1:] / steps[:-1]).max() < 1.0 + 1.5 * GROWTH


@pytest.mark.parametrize(
    ("length", "height", "thickness", "expected"),
    [
        (4.95, 12.16, 0.35, 0.25),  # a usual facade
        (19.36, 17.0, 0.35, 0.25),
        (6.0, 4.0, 0.1, 0.072),  # two elements through a thin wall
        (1.2, 3.0, 0.5, 0.1),  # twelve along a narrow one
        (100.0, 20.0, 0.35, (700.0 / 40_000) ** (1 / 3)),  # 40,000 elements in a long one
    ],
)
def test_the_default_size_by_hand(length, height, thickness, expected):
    assert default_size(Facade(rectangle(0, 0, length, height), thickness)) == pytest.approx(expected)


def test_the_default_size_goes_by_the_thinnest_storey():
    facade = Facade(rectangle(0, 0, 6, 9), 0.5, storeys=(Storey(3, 0.3), Storey(6, 0.2)))
    assert default_size(facade) == pytest.approx(0.144)
