import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import cleaned_cloud, facade_of

from fd2fem.model import CellState
from fd2fem.reconstruction.boundary import find_boundary
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import find_facade
from fd2fem.reconstruction.quadtree import addresses, build_quadtree, divide, leaf_of_points


@settings(max_examples=50, deadline=None)
@given(st.floats(0.5, 40), st.floats(0.5, 40), st.floats(0.05, 0.5))
def test_leaves_tile_the_root_and_are_small_enough(length, height, limit):
    lower, upper, depth = divide(np.zeros(2), np.array([length, height]), max_size=limit)
    sizes = upper - lower
    assert sizes.max() <= limit * (1 + 1e-12)
    assert len(lower) == 4**depth
    assert sizes.prod(axis=1).sum() == pytest.approx(length * height)
    # One division fewer would not do.
    assert depth == 0 or 2 * sizes.max() > limit


def test_states_follow_the_points():
    options = ReconstructionOptions()
    points = find_facade(cleaned_cloud(facade_of(6.0, 5.0, [(2.0, 1.5, 2.0, 2.0)]), 0.02), options=options)
    boundary = find_boundary(points, options=options)
    tree = build_quadtree(points, boundary, max_size=0.19)
    leaf = leaf_of_points(points.xz, tree.lower[0], tree.upper[-1], tree.depth)
    assert (points.xz >= tree.lower[leaf] - 1e-9).all()
    assert (points.xz <= tree.upper[leaf] + 1e-9).all()
    occupied = np.isin(np.arange(len(tree.lower)), leaf)
    assert ((tree.state == CellState.EMPTY) == ~occupied).all()
    with_boundary = np.isin(np.arange(len(tree.lower)), leaf[boundary.points])
    assert ((tree.state == CellState.PARTIAL) == with_boundary).all()
    centre = (tree.lower + tree.upper) / 2 - points.xz.min(axis=0)
    in_window = ((centre > [2.2, 1.7]) & (centre < [3.8, 3.3])).all(axis=1)
    assert (tree.state[in_window] == CellState.EMPTY).all()


def test_addresses_are_unique_paths_from_the_root():
    options = ReconstructionOptions()
    points = find_facade(cleaned_cloud(facade_of(3.0, 3.0, []), 0.03), options=options)
    tree = build_quadtree(points, find_boundary(points, options=options), max_size=0.19)
    names = addresses(tree)
    assert len(set(names)) == len(names)
    assert {len(name) for name in names} == {tree.depth}
    # The first digit says which quarter: 3 is the upper right.
    centre = (tree.lower + tree.upper) / 2
    quarter = (centre > (tree.lower[0] + tree.upper[-1]) / 2) @ [1, 2]
    assert [int(name[0]) for name in names] == quarter.tolist()
