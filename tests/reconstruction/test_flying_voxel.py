import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import facade_of

from fd2fem.errors import InputError
from fd2fem.model import CellState, Facade, Opening, OpeningKind, rectangle
from fd2fem.reconstruction.flying_voxel import Case, crossings, fly, revoxelise, voxelise

NOTCHED = np.array([[0, 0], [6, 0], [6, 4], [4, 4], [4, 2], [2, 2], [2, 4], [0, 4]], dtype=float)


def test_voxels_fill_the_wall_exactly():
    facade = facade_of(4.95, 12.16, [(0.425, 0, 4.1, 2.956), (0.875, 4.1, 3.2, 2.3), (1.0, 7.3, 3.0, 2.1)])
    voxels = voxelise(facade, max_size=0.198)
    assert voxels.volume == pytest.approx(facade.wall_area * 0.35, rel=1e-12)
    assert (voxels.upper - voxels.lower).max() <= 0.198
    assert (voxels.upper - voxels.lower).prod(axis=1).sum() == pytest.approx(4.95 * 12.16, rel=1e-12)


def test_notch_is_outside_where_the_papers_wording_fails():
    # A voxel in the notch sees the facade to its left, right and below: LS1 crosses, yet it is outside.
    centre = np.array([[3.0, 3.0]])
    sideways = crossings(centre, np.array([[7.0, 3.0]]), NOTCHED)
    assert sideways.tolist() == [2]
    assert fly(centre, NOTCHED, ()).tolist() == [Case.OUTSIDE]


def test_all_three_cases():
    window = rectangle(0.5, 0.5, 1.0, 1.0)
    centres = np.array([[3.0, 3.5], [1.0, 1.0], [5.0, 1.0], [1.4, 1.4]])
    assert fly(centres, NOTCHED, (window,)).tolist() == [
        Case.OUTSIDE,
        Case.IN_OPENING,
        Case.IN_WALL,
        Case.IN_OPENING,
    ]


def test_opening_that_is_not_convex():
    ell = np.array([[1, 1], [3, 1], [3, 1.5], [1.5, 1.5], [1.5, 3], [1, 3]])
    wall = rectangle(0, 0, 6, 4)
    centres = np.array([[1.2, 2.8], [2.8, 1.2], [2.5, 2.5]])
    assert fly(centres, wall, (ell,)).tolist() == [Case.IN_OPENING, Case.IN_OPENING, Case.IN_WALL]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_agrees_with_shapely_on_random_rectilinear_walls(seed):
    rng = np.random.default_rng(seed)
    steps = np.sort(rng.uniform(0.5, 7.5, rng.integers(1, 5)))
    heights = rng.uniform(3.0, 6.0, len(steps) + 1)
    top = [(x, h) for x, a, b in zip(steps, heights, heights[1:], strict=False) for h in (a, b)]
    outline = np.array([(0, 0), (8, 0), (8, heights[-1]), *top[::-1], (0, heights[0])])
    openings = (rectangle(1.0, 0.7, 1.1, 1.3), rectangle(4.0, 1.0, 2.0, 1.5))
    centres = rng.uniform(-0.5, 8.5, (400, 2))
    case = fly(centres, outline, openings)
    wall = shapely.Polygon(outline)
    for ring in openings:
        wall = wall.difference(shapely.Polygon(ring))
    assert ((case == Case.IN_WALL) == shapely.contains_xy(wall, centres)).all()


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(*[st.floats(0.1, 0.9)] * 4), min_size=1, max_size=3))
def test_no_line_passes_through_a_voxel(boxes):
    rings = [rectangle(min(a, b), min(c, d), abs(b - a) + 0.01, abs(d - c) + 0.01) for a, b, c, d in boxes]
    lower, upper = revoxelise(np.zeros((1, 2)), np.ones((1, 2)), rings)
    assert (upper - lower).prod(axis=1).sum() == pytest.approx(1.0)
    for ring in rings:
        border = shapely.Polygon(ring).boundary
        for low, high in zip(lower, upper, strict=True):
            assert border.intersection(shapely.box(*(low + 2e-6), *(high - 2e-6))).length < 1e-9


def test_slanted_edge_is_refused():
    gable = Facade(np.array([[0, 0], [4, 0], [4, 3], [2, 5], [0, 3]]), 0.35)
    with pytest.raises(InputError, match="the wall's outline has a slanted one"):
        voxelise(gable, max_size=0.19)
    arch = Opening(7, OpeningKind.WINDOW, np.array([[1, 1], [2, 1], [2, 2], [1.5, 2.5], [1, 2]]))
    with pytest.raises(InputError, match="opening 7 has a slanted one"):
        voxelise(Facade(rectangle(0, 0, 4, 4), 0.35, (arch,)), max_size=0.19)


def test_door_is_open_to_the_ground():
    voxels = voxelise(facade_of(4.0, 4.0, [(1.5, 0.0, 1.0, 2.0)]), max_size=0.19)
    low = (voxels.lower[:, 1] == 0) & (voxels.lower[:, 0] >= 1.5) & (voxels.upper[:, 0] <= 2.5)
    assert low.any()
    assert (voxels.state[low] == CellState.EMPTY).all()
