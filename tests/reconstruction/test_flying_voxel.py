from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import facade_of

from fd2fem.errors import InputError
from fd2fem.model import CellState, Facade, Opening, OpeningKind, Storey, rectangle
from fd2fem.reconstruction.flying_voxel import Case, crossings, fly, revoxelise, voxelise

NOTCHED = np.array([[0, 0], [6, 0], [6, 4], [4, 4], [4, 2], [2, 2], [2, 4], [0, 4]], dtype=float)


def test_voxels_fill_the_wall_exactly():
    facade = facade_of(4.95, 12.16, [(0.425, 0, 4.1, 2.956), (0.875, 4.1, 3.2, 2.3), (1.0, 7.3, 3.0, 2.1)])
    voxels = voxelise(facade, max_size=0.198)
    assert voxels.volume == pytest.approx(facade.wall_area * 0.35, rel=1e-12)
    assert (voxels.upper - voxels.lower).max() <= 0.198
    assert (voxels.upper - voxels.lower).prod(axis=1).sum() == pytest.approx(4.95 * 12.16, rel=1e-12)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(0.2, 5.8), st.floats(0.1, 0.9)), max_size=3, unique_by=lambda s: round(s[0], 3)
    )
)
def test_voxels_have_the_thickness_of_their_storey(levels):
    # Openings across the levels and below them, in a wall with a notch.
    storeys = tuple(Storey(z, thickness) for z, thickness in sorted(levels))
    outline = np.array([[0, 0], [6, 0], [6, 6], [4, 6], [4, 4.5], [0, 4.5]])
    windows = (rectangle(1.0, 0.7, 1.1, 1.3), rectangle(4.2, 1.0, 1.5, 4.0))
    openings = tuple(Opening(i, OpeningKind.WINDOW, ring) for i, ring in enumerate(windows, start=1))
    facade = Facade(outline, 0.5, openings, storeys=storeys)
    voxels = voxelise(facade, max_size=0.4)
    # By shapely: the wall's area in each strip times its thickness.
    wall = shapely.Polygon(outline, windows)
    bounds, thick = [0.0, *(s.z for s in storeys), 6.0], [0.5, *(s.thickness for s in storeys)]
    strips = [shapely.box(0, low, 6, high) for low, high in pairwise(bounds)]
    volume = sum(wall.intersection(strip).area * t for strip, t in zip(strips, thick, strict=True))
    assert voxels.volume == pytest.approx(volume, rel=1e-6)
    assert facade.volume == pytest.approx(volume, rel=1e-9)
    for low, high, t in zip(bounds, bounds[1:], thick, strict=False):
        inside = (voxels.lower[:, 1] > low - 1e-5) & (voxels.upper[:, 1] < high + 1e-5)
        assert (voxels.thickness[inside] == t).all()
    straddling = [
        (voxels.lower[:, 1] < s.z - 2e-6) & (voxels.upper[:, 1] > s.z + 2e-6) for s in facade.storeys
    ]
    assert not np.any(straddling)


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


def arched(left, bottom, width, height, *, chords=24):
    """An opening with a round head, drawn in chords."""
    angle = np.linspace(0.0, np.pi, chords + 1)
    head = [left, bottom + height - width / 2] + width / 2 * np.column_stack(
        [1.0 + np.cos(angle), np.sin(angle)]
    )
    return np.vstack([[[left, bottom], [left + width, bottom]], head])


def arcade():
    """28 arched windows on four floors."""
    places = [(1.0 + 2.6 * column, 1.0 + 4.0 * row) for row in range(4) for column in range(7)]
    return Facade(
        rectangle(0, 0, 19.36, 17.0),
        0.35,
        tuple(
            Opening(number, OpeningKind.WINDOW, arched(x, z, 1.31, 2.13))
            for number, (x, z) in enumerate(places, start=1)
        ),
    )


def test_arches_are_followed_to_the_tolerance():
    facade = arcade()
    voxels = voxelise(facade, max_size=0.198, tolerance=0.02)
    size = voxels.upper - voxels.lower
    assert size.prod(axis=1).sum() == pytest.approx(19.36 * 17.0, rel=1e-12)
    # Oracle: the polygons' areas; every opening's is kept to 0.1 %, and so is the wall's.
    assert voxels.volume == pytest.approx(facade.wall_area * 0.35, rel=1e-3)
    empty = voxels.state == CellState.EMPTY
    middle = (voxels.lower + voxels.upper) / 2
    for opening in facade.openings:
        low, high = opening.outline.min(axis=0), opening.outline.max(axis=0)
        inside = ((middle > low) & (middle < high)).all(axis=1)
        assert size[empty & inside].prod(axis=1).sum() == pytest.approx(opening.area, rel=1e-3)
    # Voxels are small at the arches only.
    assert len(size) < 35_000
    assert (size.max(axis=1) > 0.1).sum() > 8_000


def test_no_full_voxel_reaches_far_into_an_arch():
    facade = Facade(
        rectangle(0, 0, 4, 4), 0.35, (Opening(1, OpeningKind.WINDOW, arched(1.03, 0.7, 1.37, 2.2)),)
    )
    voxels = voxelise(facade, max_size=0.198, tolerance=0.03)
    full = voxels.state == CellState.FULL
    boxes = shapely.box(*voxels.lower[full].T, *voxels.upper[full].T)
    inner = shapely.Polygon(facade.openings[0].outline).buffer(-0.03 / np.sqrt(2.0))
    assert not shapely.intersects(boxes, inner).any()


def test_jambs_and_sill_of_an_arch_are_exact():
    ring = arched(1.03, 0.7, 1.37, 2.2)
    voxels = voxelise(
        Facade(rectangle(0, 0, 4, 4), 0.35, (Opening(1, OpeningKind.WINDOW, ring),)), max_size=0.19
    )
    empty = voxels.state == CellState.EMPTY
    assert voxels.lower[empty, 1].min() == 0.7
    assert voxels.lower[empty, 0].min() == pytest.approx(1.03, abs=1e-12)
    assert voxels.upper[empty, 0].max() == pytest.approx(2.40, abs=1e-12)


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (10, 0), (10, 10), (5, 15), (0, 10)],
        [(0, 0), (8.3, 0), (8.1, 9.7), (4.2, 13.1), (0, 9.7)],
        [(0, 0), (6, 0), (6, 4), (5, 4), (4.2, 5.1), (0, 4)],
    ],
)
def test_gables_keep_their_area(corners):
    gable = Facade(np.array(corners, dtype=float), 0.35)
    voxels = voxelise(gable, max_size=0.19, tolerance=0.02)
    assert voxels.volume == pytest.approx(gable.wall_area * 0.35, rel=1e-3)
    box = np.ptp(gable.outline, axis=0).prod()
    assert (voxels.upper - voxels.lower).prod(axis=1).sum() == pytest.approx(box, rel=1e-12)


def test_finer_tolerance_comes_closer():
    facade = Facade(
        rectangle(0, 0, 4, 4), 0.35, (Opening(1, OpeningKind.WINDOW, arched(1.03, 0.7, 1.37, 2.2)),)
    )
    bound = np.pi / 2 * 1.37 * 0.35 / np.sqrt(2.0)
    for tolerance in (0.1, 0.05, 0.02, 0.01):
        error = voxelise(facade, max_size=0.19, tolerance=tolerance).volume - facade.wall_area * 0.35
        assert abs(error) < bound * tolerance / 4


def test_absurd_tolerance_is_refused():
    gable = Facade(np.array([[0, 0], [4, 0], [4, 3], [2, 5], [0, 3]]), 0.35)
    with pytest.raises(InputError, match="take a larger tolerance"):
        voxelise(gable, max_size=0.19, tolerance=1e-6)
    with pytest.raises(InputError, match="tolerance"):
        voxelise(gable, max_size=0.19, tolerance=0.0)


def test_door_is_open_to_the_ground():
    voxels = voxelise(facade_of(4.0, 4.0, [(1.5, 0.0, 1.0, 2.0)]), max_size=0.19)
    low = (voxels.lower[:, 1] == 0) & (voxels.lower[:, 0] >= 1.5) & (voxels.upper[:, 0] <= 2.5)
    assert low.any()
    assert (voxels.state[low] == CellState.EMPTY).all()
