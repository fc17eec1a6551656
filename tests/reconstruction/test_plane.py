import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import cleaned_cloud, facade_of, survey_frame

from fd2fem.errors import InputError, ReconstructionError
from fd2fem.model import PointCloud
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import NOTHING_TELLS, find_facade, point_spacing
from fd2fem.reconstruction.thinning import thin_points

OPTIONS = ReconstructionOptions()
HOUSE = facade_of(6.0, 5.0, [(1.0, 1.0, 1.2, 1.6)])


def street(seed=0):
    """Ground before the wall, a room behind it, a neighbour set back, a car's flank near the scanner."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-5, 11, 40_000), rng.uniform(-9, 0, 40_000)
    ground = np.column_stack([x, y, rng.normal(0, 0.003, 40_000)])
    room = np.column_stack([rng.uniform(0.5, 2.5, 500), np.full(500, 4.0), rng.uniform(0.8, 2.8, 500)])
    neighbour = np.column_stack([rng.uniform(6, 10, 8000), np.full(8000, 0.3), rng.uniform(0, 6, 8000)])
    car = np.column_stack([rng.uniform(1, 5, 60_000), np.full(60_000, -6.0), rng.uniform(0.2, 1.5, 60_000)])
    return np.concatenate([ground, room, neighbour, car])


@settings(max_examples=10, deadline=None)
@given(st.floats(0, 360), st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_frame_is_found_wherever_the_wall_stands(degrees, east, north):
    frame = survey_frame(degrees, (east, north, 40.0))
    found = find_facade(cleaned_cloud(HOUSE, 0.03, frame=frame), options=OPTIONS)
    assert np.abs(found.frame.axes - frame.axes).max() < 1e-3
    local = frame.to_facade(found.frame.to_world(np.insert(found.xz, 1, 0.0, axis=1)))
    assert np.abs(local[:, 1]).max() < 0.001


def test_wall_is_found_in_a_street():
    frame = survey_frame()
    wall = cleaned_cloud(HOUSE, 0.02, frame=frame)
    cloud = PointCloud(
        np.concatenate([wall.points, frame.to_world(street())]), "street", scanners=wall.scanners
    )
    found = find_facade(cloud, options=OPTIONS)
    assert np.abs(found.frame.axes - frame.axes).max() < 1e-3
    assert len(found.xz) == pytest.approx(len(wall), rel=0.02)
    assert np.ptp(found.xz, axis=0) == pytest.approx([6.0, 5.0], abs=0.06)
    assert found.front[:, 1].max() < 0 < found.behind[:, 1].min()
    assert found.ground == pytest.approx(found.frame.to_facade(frame.to_world([[0, 0, 0]]))[0, 2], abs=0.005)


@pytest.mark.parametrize("degrees", [0.0, 100.0, 200.0, 300.0])
def test_pavement_tells_the_outside_without_a_scanner(degrees):
    frame = survey_frame(degrees)
    wall = cleaned_cloud(HOUSE, 0.02, frame=frame)
    cloud = PointCloud(np.concatenate([wall.points, frame.to_world(street())]), "street")
    found = find_facade(cloud, options=OPTIONS)
    assert found.outside_by == "the pavement before the wall"
    assert found.frame.axes[1] @ frame.axes[1] > 0.999


def test_bare_wall_is_seen_as_drawn_and_says_so():
    cloud = cleaned_cloud(HOUSE, 0.03)
    found = find_facade(PointCloud(cloud.points, "bare"), options=OPTIONS)
    assert found.outside_by == NOTHING_TELLS
    assert found.frame.axes[1] == pytest.approx([0, 1, 0], abs=1e-3)


def test_rms_is_the_noise():
    found = find_facade(cleaned_cloud(HOUSE, 0.02, noise=0.004), options=OPTIONS)
    assert found.rms == pytest.approx(0.004, rel=0.03)


def noise_box():
    return np.random.default_rng(0).uniform(0, 5, (5000, 3))


def level_ground():
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(0, 20, (5000, 2)), rng.normal(0, 0.004, 5000)])


def slope():
    rng = np.random.default_rng(0)
    xy = rng.uniform(0, 8, (9000, 2))
    return np.column_stack([xy, 3.0 * xy[:, 0]])


def tiny():
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(0, 0.4, 900), rng.normal(0, 0.001, 900), rng.uniform(0, 0.4, 900)])


@pytest.mark.parametrize("points", [noise_box, level_ground, slope, tiny])
def test_no_wall_is_said(points):
    with pytest.raises(ReconstructionError, match="No wall found"):
        find_facade(PointCloud(points(), "none"), options=OPTIONS)


@pytest.mark.parametrize("pattern", ["random", "grid"])
def test_spacing_is_that_of_the_points(pattern):
    cloud = cleaned_cloud(facade_of(6.0, 5.0, []), 0.04, pattern=pattern)
    assert point_spacing(cloud.points[:, [0, 2]]) == pytest.approx(0.04, rel=0.15)


def test_thinning_keeps_one_point_a_cell():
    points = np.random.default_rng(1).uniform(0, 1, (5000, 3))
    kept = thin_points(points, 0.2)
    assert len(kept) == 125
    assert len(np.unique(np.floor((points[kept] - points.min(axis=0)) / 0.2), axis=0)) == 125


@pytest.mark.parametrize(
    ("scanners", "message"),
    [
        ([[3.0, 0.02, 1.6]], "0.02.* m from the wall's plane"),
        ([[3.0, -1e30, 1.6]], "1e\\+30 m from the wall's plane"),
        ([[3.0, -8.0, 1.6], [3.0, 8.0, 1.6]], "lie on both sides of the wall"),
    ],
)
def test_impossible_scanner_positions_are_refused(scanners, message):
    cloud = cleaned_cloud(HOUSE, 0.04)
    with pytest.raises(InputError, match=message):
        find_facade(PointCloud(cloud.points, "wall", scanners=np.array(scanners)), options=OPTIONS)


def test_room_seen_through_a_large_opening_is_not_the_wall():
    # A shop front of 5.2 x 2.8 m in a wall of 6 x 4 m: the room's back wall holds more points than the wall.
    wall = cleaned_cloud(facade_of(6.0, 4.0, [(0.4, 0.0, 5.2, 2.8)]), 0.02)
    rng = np.random.default_rng(1)
    x, z = rng.uniform(0.0, 6.0, 60_000), rng.uniform(0.0, 3.9, 60_000)
    back = np.column_stack([x, np.full(60_000, 4.1), z])
    cloud = PointCloud(np.concatenate([wall.points, back]), "shop", scanners=wall.scanners)
    found = find_facade(cloud, options=OPTIONS)
    assert abs(found.frame.origin[1]) < 0.01


def test_strip_of_a_blank_neighbour_loses_to_a_wall_of_windows():
    windows = [(0.4, 0.0, 4.1, 2.9), (0.6, 4.0, 3.7, 2.6), (0.6, 7.5, 3.7, 2.4), (0.7, 10.4, 3.5, 1.2)]
    wall = cleaned_cloud(facade_of(4.95, 12.0, windows), 0.03)
    rng = np.random.default_rng(2)
    x, z = rng.uniform(4.95, 7.0, 33_000), rng.uniform(0.0, 14.0, 33_000)
    strip = np.column_stack([x, np.full(33_000, 0.3), z])
    for scanners in (wall.scanners, np.empty((0, 3))):
        cloud = PointCloud(np.concatenate([wall.points, strip]), "street", scanners=scanners)
        found = find_facade(cloud, options=OPTIONS)
        assert np.ptp(found.xz, axis=0) == pytest.approx([4.95, 12.0], abs=0.1)


def test_wall_that_goes_on_in_another_plane_is_reported():
    low = cleaned_cloud(facade_of(6.0, 5.0, []), 0.03)
    high = low.points + np.array([0.0, 0.08, 5.0])
    found = find_facade(
        PointCloud(np.concatenate([low.points, high]), "two", scanners=low.scanners), options=OPTIONS
    )
    assert any("m² of what may be the same wall" in warning for warning in found.warnings)


def test_wall_that_nearly_matches_the_chosen_one_is_reported():
    wall = cleaned_cloud(facade_of(6.0, 5.0, []), 0.03).points
    other = wall + np.array([9.0, 1.0, 0.0])
    found = find_facade(PointCloud(np.concatenate([wall, other]), "two"), options=OPTIONS)
    assert any(warning.startswith("Another wall spans") for warning in found.warnings)


def test_wall_that_the_scanner_faces_wins_over_a_larger_one():
    wall = cleaned_cloud(HOUSE, 0.03)
    rng = np.random.default_rng(3)
    x, z = rng.uniform(7.0, 14.0, 56_000), rng.uniform(0.0, 7.0, 56_000)
    blank = np.column_stack([x, np.full(56_000, 0.4), z])
    cloud = PointCloud(np.concatenate([wall.points, blank]), "street", scanners=wall.scanners)
    found = find_facade(cloud, options=OPTIONS)
    assert np.ptp(found.xz, axis=0) == pytest.approx([6.0, 5.0], abs=0.1)


def test_blinds_behind_the_openings_are_not_the_wall():
    windows = [(0.3, 0.3, 2.6, 2.1), (3.1, 0.3, 2.6, 2.1), (0.3, 2.7, 2.6, 2.1), (3.1, 2.7, 2.6, 2.1)]
    wall = cleaned_cloud(facade_of(6.0, 5.0, windows), 0.03)
    rng = np.random.default_rng(4)
    blinds = []
    for x, z, width, height in windows:
        count = int(width * height / 0.03**2)
        across, up = rng.uniform(x, x + width, count), rng.uniform(z, z + height, count)
        blinds.append(np.column_stack([across, np.full(count, 0.15), up]))
    cloud = PointCloud(np.concatenate([wall.points, *blinds]), "blinds", scanners=wall.scanners)
    found = find_facade(cloud, options=OPTIONS)
    assert abs(found.frame.origin[1]) < 0.01


def test_origin_near_the_wall_stands_for_the_scanner():
    # The same wall from the other side of the origin is seen from the other side.
    for sign in (-1.0, 1.0):
        points = cleaned_cloud(HOUSE, 0.04).points + np.array([0.0, sign * 10.0, 0.0])
        found = find_facade(PointCloud(points, "local"), options=OPTIONS)
        assert found.outside_by.startswith("the origin")
        assert found.frame.axes[1] == pytest.approx([0.0, sign, 0.0], abs=1e-3)
