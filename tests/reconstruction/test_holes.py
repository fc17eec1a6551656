import numpy as np
import pytest
from scenes import STATION, scene
from synthetic import cleaned_cloud, facade_of

from fd2fem.errors import InputError
from fd2fem.model import HoleKind, PointCloud, Side
from fd2fem.reconstruction.boundary import find_boundary
from fd2fem.reconstruction.holes import classify_holes
from fd2fem.reconstruction.options import Override, ReconstructionOptions
from fd2fem.reconstruction.plane import find_facade
from fd2fem.reconstruction.rays import cast_shadows, ray_map

OPTIONS = ReconstructionOptions()
WALL = facade_of(7.0, 5.0, [(1.0, 1.0, 1.2, 1.6)])


def holes_of(cloud, options=OPTIONS):
    points = find_facade(cloud, options=options)
    boundary = find_boundary(points, options=options)
    (left, bottom), (right, top) = points.xz.min(axis=0), points.xz.max(axis=0)
    outline = np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
    shadows = cast_shadows(ray_map(cloud, points))
    return points, classify_holes(points, boundary, shadows, outline=outline, options=options)


def test_openings_and_occlusions_by_size():
    # A window, a slot too narrow, a band too long, and a door down to the ground.
    house = facade_of(
        8.0, 6.0, [(1.0, 1.0, 1.0, 1.5), (3.0, 1.0, 0.3, 2.0), (1.0, 4.0, 4.0, 0.6), (5.5, 0.0, 1.1, 2.2)]
    )
    _, holes = holes_of(cleaned_cloud(house, 0.02))
    found = sorted((hole.width, hole.height, hole.kind) for hole in holes)
    truth = [(0.3, 2.0, "occlusion"), (1.0, 1.5, "opening"), (1.1, 2.2, "opening"), (4.0, 0.6, "occlusion")]
    assert [kind for *_, kind in found] == [kind for *_, kind in truth]
    for (*size, _), (*true_size, _) in zip(found, truth, strict=True):
        # Histograms give the character of a hole; its lines give the exact sizes later.
        assert size == pytest.approx(true_size, abs=0.15)


def test_ragged_hole_is_an_occlusion():
    points = cleaned_cloud(facade_of(6.0, 5.0, []), 0.02).points
    # A triangle fills half of its rectangle.
    away = points[:, [0, 2]] - [2.0, 1.5]
    inside = (away > 0).all(axis=1) & (away.sum(axis=1) < 2.0)
    _, holes = holes_of(PointCloud(points[~inside], "triangle"))
    assert [hole.kind for hole in holes] == [HoleKind.OCCLUSION]
    assert "rectangle" in holes[0].reason


def test_window_shaped_shadow_is_filled_when_the_scanner_is_known():
    cloud = scene(WALL, 0.02, panels=[(-2.0, 3.6, 2.0, 0.8, 1.2)])
    _, holes = holes_of(cloud)
    assert [hole.kind for hole in holes].count(HoleKind.OPENING) == 1
    shadow = next(hole for hole in holes if hole.kind is HoleKind.OCCLUSION)
    # By similar triangles: 10/8 of the panel.
    assert [shadow.width, shadow.height] == pytest.approx([1.0, 1.5], abs=0.06)
    assert "shadow" in shadow.reason
    assert shadow.confidence > 0.9


def test_without_the_scanner_what_is_seen_inside_decides():
    # By equation 1 the shadow is an opening, and in a cleaned scan there is nothing else to go by.
    cloud = scene(WALL, 0.02, panels=[(-2.0, 3.6, 2.0, 0.8, 1.2)], told=False)
    _, holes = holes_of(cloud)
    kinds = {round(hole.width, 1): hole.kind for hole in holes if hole.area > 0.5}
    assert kinds == {1.2: HoleKind.OPENING, 1.0: HoleKind.OCCLUSION}
    on_wall = np.abs(cloud.points[:, 1]) < 0.01
    _, holes = holes_of(PointCloud(cloud.points[on_wall], "cleaned"))
    assert all(hole.kind is HoleKind.OPENING for hole in holes if hole.area > 0.5)
    assert all(hole.evidence["scanners"] == 0 for hole in holes)


def test_window_that_is_partly_in_shadow_keeps_what_is_seen_of_it():
    # Hides the window's right part and the wall beside it: from x = 1.8 to 2.8.
    low = STATION[[0, 2]] + (np.array([1.8, 0.7]) - STATION[[0, 2]]) * 0.8
    high = STATION[[0, 2]] + (np.array([2.8, 2.9]) - STATION[[0, 2]]) * 0.8
    cloud = scene(WALL, 0.02, panels=[(-2.0, *low, *(high - low))])
    points, holes = holes_of(cloud)
    window = next(hole for hole in holes if hole.kind is HoleKind.OPENING)
    left = window.x + points.frame.origin[0]
    assert left == pytest.approx(1.0, abs=0.04)
    assert [window.z + points.frame.origin[2], window.height] == pytest.approx([1.0, 1.6], abs=0.06)
    assert set(window.unseen) == {Side.RIGHT}
    # The interval holds all of the shadow, and no more than three cells of 60 mm beyond it.
    first, last = np.array(window.unseen[Side.RIGHT]) + points.frame.origin[0]
    assert 1.8 - 0.18 < first < 1.8
    assert 2.8 - 0.06 < last < 2.8 + 0.18


def test_shadow_that_joins_two_windows_does_not_lose_them():
    pair = facade_of(7.0, 5.0, [(1.0, 1.0, 1.2, 1.6), (3.0, 1.0, 1.2, 1.6)])
    low = STATION[[0, 2]] + (np.array([0.8, 0.2]) - STATION[[0, 2]]) * 0.8
    high = STATION[[0, 2]] + (np.array([4.6, 1.5]) - STATION[[0, 2]]) * 0.8
    points, holes = holes_of(scene(pair, 0.02, panels=[(-2.0, *low, *(high - low))]))
    windows = sorted((hole for hole in holes if hole.kind is HoleKind.OPENING), key=lambda hole: hole.x)
    assert [hole.x + points.frame.origin[0] for hole in windows] == pytest.approx([1.0, 3.0], abs=0.04)
    assert [hole.width for hole in windows] == pytest.approx([1.2, 1.2], abs=0.06)
    assert all(set(hole.unseen) == {Side.BOTTOM} for hole in windows)


def test_post_before_a_window_leaves_one_window():
    low = STATION[[0, 2]] + (np.array([1.5, -2.0]) - STATION[[0, 2]]) * 0.8
    high = STATION[[0, 2]] + (np.array([1.7, 4.0]) - STATION[[0, 2]]) * 0.8
    _, holes = holes_of(scene(WALL, 0.02, panels=[(-2.0, *low, *(high - low))]))
    windows = [hole for hole in holes if hole.kind is HoleKind.OPENING]
    assert [(hole.width, hole.height) for hole in windows] == [pytest.approx((1.2, 1.6), abs=0.06)]


def test_override_is_obeyed_and_recorded():
    cloud = scene(WALL, 0.02, panels=[(-2.0, 3.6, 2.0, 0.8, 1.2)])
    _, before = holes_of(cloud)
    shadow = next(hole for hole in before if hole.kind is HoleKind.OCCLUSION)
    at = (shadow.x + shadow.width / 2, shadow.z + shadow.height / 2)
    _, after = holes_of(cloud, ReconstructionOptions(overrides=(Override(*at, HoleKind.OPENING),)))
    changed = next(hole for hole in after if "override" in hole.evidence)
    assert (changed.kind, changed.confidence) == (HoleKind.OPENING, 1.0)
    assert "set by the user" in changed.reason
    assert shadow.reason in changed.reason
    with pytest.raises(InputError, match="no hole at x = 90"):
        holes_of(cloud, ReconstructionOptions(overrides=(Override(90.0, 1.0, HoleKind.OPENING),)))


def test_low_sill_is_a_window_and_a_missing_foot_a_door():
    house = facade_of(6.0, 5.0, [(1.0, 0.25, 1.2, 2.0), (3.5, 0.0, 1.2, 2.0)])
    points, holes = holes_of(cleaned_cloud(house, 0.02))
    bottoms = sorted(hole.z - points.xz[:, 1].min() for hole in holes)
    assert bottoms == pytest.approx([0.0, 0.25], abs=0.03)
