"""Clusters of triangles on strips small enough to name by hand."""

import numpy as np

from fd2fem.reconstruction.clusters import cluster_triangles

SMALLEST = 0.08
"""Half of a 0.4 m square, m²."""


def strip(links, areas):
    """Clusters of a row of triangles; each link says how the next one is reached: wide, narrow, or not."""
    count = len(areas)
    other = np.full((count, 3), -1)
    wide, narrow = np.zeros((count, 3), dtype=bool), np.zeros((count, 3), dtype=bool)
    for left, link in enumerate(links):
        other[left, 1], other[left + 1, 0] = left + 1, left
        for triangle, side in ((left, 1), (left + 1, 0)):
            wide[triangle, side] = link == "wide"
            narrow[triangle, side] = link in {"wide", "narrow"}
    return cluster_triangles(other, (narrow, wide), np.array(areas, dtype=float), SMALLEST).tolist()


def test_wide_sides_make_one_hole():
    assert strip(["wide", "wide"], [0.1, 0.1, 0.1]) == [0, 0, 0]


def test_a_narrow_passage_keeps_two_holes_apart():
    assert strip(["wide", "narrow", "wide"], [0.3, 0.3, 0.1, 0.1]) == [0, 0, 1, 1]


def test_the_largest_comes_first():
    assert strip(["wide", "narrow", "wide"], [0.1, 0.1, 0.3, 0.3]) == [1, 1, 0, 0]


def test_triangles_without_a_long_side_between_them_stay_apart():
    assert strip(["wide", "short"], [0.3, 0.3, 0.2]) == [0, 0, 1]


def test_the_rim_and_a_cut_off_corner_join_their_hole():
    assert strip(["wide", "narrow", "narrow", "narrow"], [0.3, 0.3, 0.01, 0.01, 0.01]) == [0] * 5


def test_a_posts_shadow_between_two_holes_joins_neither_beyond_the_rim():
    links = ["wide", "narrow", "narrow", "narrow", "narrow", "wide"]
    assert strip(links, [0.5, 0.3, 0.01, 0.01, 0.01, 0.3, 0.3]) == [0, 0, 0, 2, 1, 1, 1]


def test_a_long_shadow_from_one_hole_is_a_gap_of_its_own():
    assert strip(["wide", "narrow", "narrow", "narrow"], [0.3, 0.3, 0.01, 0.05, 0.05]) == [0, 0, 0, 1, 1]


def test_narrow_gaps_are_joined_through_their_long_sides():
    assert strip(["narrow", "narrow", "short"], [0.01, 0.01, 0.01, 0.01]) == [0, 0, 0, 1]


def test_no_triangles():
    nothing = np.zeros((0, 3), dtype=bool)
    empty = cluster_triangles(np.zeros((0, 3), dtype=np.intp), (nothing, nothing), np.zeros(0), SMALLEST)
    assert empty.shape == (0,)
