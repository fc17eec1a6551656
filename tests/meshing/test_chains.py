import numpy as np
import pytest
from curved_walls import CURVED_WALLS, plain
from hypothesis import given
from hypothesis import strategies as st

from fd2fem.meshing.chains import Chain, cut_ring, thin, turns, wall_chains
from fd2fem.meshing.dividing import divide_chain
from fd2fem.meshing.sizes import SizeField
from fd2fem.meshing.walls import wall_rings
from fd2fem.model import Facade, rectangle

EVERYWHERE = SizeField(np.empty((0, 2)), np.empty(0), 0.25)


def area_beside(corners):
    """Between a run of corners and the origin, m²."""
    return 0.5 * np.sum(corners[:-1, 0] * corners[1:, 1] - corners[1:, 0] * corners[:-1, 1])


def test_a_ring_is_cut_exactly_at_the_levels():
    ring = cut_ring(np.array([[0, 0], [3, 0], [0, 3.3]]), [1.1, 2.2])
    expected = [[0, 0], [3, 0], [2, 1.1], [1, 2.2], [0, 3.3], [0, 2.2], [0, 1.1]]
    np.testing.assert_allclose(ring, expected, atol=1e-15)
    assert set(ring[:, 1].tolist()) == {0.0, 1.1, 2.2, 3.3}


def test_a_corner_just_beside_a_level_moves_onto_it():
    ring = cut_ring(np.array([[0, 0], [3, 0], [3, 1.1 + 1e-12], [0, 3.3]]), [1.1])
    assert (ring[:, 1] == 1.1).sum() == 2
    assert len(ring) == 5


def test_levels_run_from_edge_to_edge():
    facade = Facade(rectangle(0, 0, 6, 4), 0.4, (plain(1, 1, 1, 1, 1), plain(2, 4, 1.5, 1, 1.5)))
    levels = [c.corners.tolist() for c in wall_chains(wall_rings(facade), [1.5]) if c.level]
    # the second window's sill lies on the level: no line along it
    assert levels == [[[0, 1.5], [1, 1.5]], [[2, 1.5], [4, 1.5]], [[5, 1.5], [6, 1.5]]]


def test_chains_bend_gently_and_close():
    facade = CURVED_WALLS["stepped"]
    chains = wall_chains(wall_rings(facade), [])
    assert all(np.abs(turns(chain.corners)[1:-1]).max(initial=0.0) < np.radians(30) for chain in chains)
    total = sum(area_beside(chain.corners) for chain in chains)
    assert total == pytest.approx(facade.wall_area, rel=1e-12)


def test_a_smooth_ring_is_one_closed_chain():
    chains = [c for c in wall_chains(wall_rings(CURVED_WALLS["oculi"]), []) if c.ring == 1]
    assert len(chains) == 1
    np.testing.assert_array_equal(chains[0].corners[0], chains[0].corners[-1])


@given(st.lists(st.floats(-0.01, 0.01), min_size=4, max_size=60), st.floats(0.001, 0.05))
def test_thinning_keeps_ends_and_area(rough, tolerance):
    x = np.linspace(0.0, 3.0, len(rough))
    chain = Chain(np.column_stack([x, 0.3 * x**2 / 3 + rough]), ring=0, level=False)
    thinned = thin(chain, tolerance=tolerance)
    np.testing.assert_array_equal(thinned.corners[[0, -1]], chain.corners[[0, -1]])
    assert area_beside(thinned.corners) == pytest.approx(area_beside(chain.corners), abs=1e-12)
    assert len(thinned.corners) <= len(chain.corners) + 1


def test_thinning_two_thousand_chords():
    angle = np.linspace(0.0, np.pi / 2, 2001)
    quarter = Chain(np.column_stack([np.cos(angle), np.sin(angle)]), ring=0, level=False)
    thinned = thin(quarter, tolerance=0.005)
    # kept corners and one between each two; a chord of 5 mm sagitta spans 0.2 m
    assert 9 <= len(thinned.corners) <= 40
    assert np.abs(np.linalg.norm(thinned.corners, axis=1) - 1.0).max() < 0.005


def test_dividing_keeps_all_corners_and_an_even_number_of_edges():
    for facade in CURVED_WALLS.values():
        for chain in wall_chains(wall_rings(facade), [storey.z for storey in facade.storeys]):
            nodes = divide_chain(chain, EVERYWHERE)
            assert len(nodes) % 2 == 1
            assert {tuple(c) for c in chain.corners.tolist()} <= {tuple(n) for n in nodes.tolist()}
            assert area_beside(nodes) == pytest.approx(area_beside(chain.corners), abs=1e-12)
            assert np.linalg.norm(np.diff(nodes, axis=0), axis=1).max() < 1.5 * 0.25


def test_an_odd_number_of_short_edges_by_hand():
    corners = np.array([[0, 0], [0.1, 0], [0.3, 0.01], [0.4, 0.02]])
    nodes = divide_chain(Chain(corners, ring=0, level=False), EVERYWHERE)
    expected = [[0, 0], [0.1, 0], [0.2, 0.005], [0.3, 0.01], [0.4, 0.02]]  # the longest is halved
    np.testing.assert_allclose(nodes, expected, atol=1e-15)
