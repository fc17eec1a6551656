"""The virtual scanner against geometry: shadows by projection, noise and shares by statistics."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree
from scipy.stats import chi2

from fd2fem.errors import InputError
from fd2fem.model import Facade, FacadeFrame, Opening, OpeningKind, rectangle
from fd2fem.scans.rays import step_for_spacing
from fd2fem.scans.scanner import ScannerOptions, simulate_scan
from fd2fem.scans.scene import Neighbour, Post, Scene, Vehicle

EXACT = ScannerOptions(angular_step=0.3, range_noise=0.0, mixed_pixels=0.0)
STATION = np.array([2.4, -8.0, 1.6])
AT_STATION = replace(EXACT, stations=(tuple(STATION),))


def plain(length=5.0, height=6.0):
    return Facade(rectangle(0, 0, length, height), thickness=0.35)


def two_windows():
    openings = (
        Opening(1, OpeningKind.DOOR, rectangle(0.8, 0.0, 1.2, 2.4)),
        Opening(2, OpeningKind.WINDOW, rectangle(2.6, 3.0, 1.4, 1.8)),
    )
    return Facade(rectangle(0, 0, 5, 6), thickness=0.35, openings=openings)


def gable_with_arch():
    turn = np.linspace(0.0, np.pi, 13)
    arch = np.column_stack([1.5 + 0.7 * np.cos(turn), 2.2 + 0.7 * np.sin(turn)])
    openings = (
        Opening(1, OpeningKind.DOOR, np.vstack([[0.8, 0.0], [2.2, 0.0], arch])),
        Opening(2, OpeningKind.WINDOW, rectangle(2.8, 5.0, 1.2, 1.5)),
    )
    outline = np.array([[0, 0], [7, 0], [7, 6], [3.5, 9], [0, 6]])
    return Facade(outline, thickness=0.35, openings=openings)


def stand_in(length, height, openings):
    shapes = tuple(
        Opening(i + 1, OpeningKind.DOOR if box[1] == 0 else OpeningKind.WINDOW, rectangle(*box))
        for i, box in enumerate(openings)
    )
    return Facade(rectangle(0, 0, length, height), thickness=0.35, openings=shapes)


BUILDING_1 = stand_in(
    4.95, 12.16, [(0.6, 0, 3.75, 3.0), *((0.85, z, 3.25, h) for z, h in ((4, 2.3), (7, 2), (9.7, 1.72)))]
)
BUILDING_2 = stand_in(4.9, 13.28, [(x, 3.3 * row, 1.85, 2.3) for row in range(4) for x in (0.4, 2.65)])
BUILDING_3 = stand_in(
    19.36, 17.0, [(0.7 + 2.7 * i, 4.2 * row, 1.43, 2.4) for row in range(4) for i in range(7)]
)


def wall_of(facade):
    return shapely.Polygon(facade.outline).difference(
        shapely.union_all([shapely.Polygon(opening.outline) for opening in facade.openings])
    )


def angles(points, station=STATION):
    """Azimuth from the wall's normal, elevation."""
    ray = points - station
    return np.arctan2(ray[:, 0], ray[:, 1]), np.arctan2(ray[:, 2], np.hypot(ray[:, 0], ray[:, 1]))


def grid_nodes(facade, options, scene):
    """Points keyed by their direction to a thousandth of the step, so that two scans can be compared."""
    points = simulate_scan(facade, options=options, scene=scene).points
    keys = np.round(np.column_stack(angles(points)) / np.radians(options.angular_step) * 1000).astype(int)
    return {tuple(key): point for key, point in zip(keys.tolist(), points, strict=True)}


@pytest.mark.parametrize("facade", [plain(), two_windows(), gable_with_arch()], ids=["plain", "two", "gable"])
def test_cleaned_cloud_lies_on_the_wall_and_covers_it(facade):
    options = replace(EXACT, angular_step=step_for_spacing(facade, 0.05))
    points = simulate_scan(facade, options=options, scene=Scene.empty()).points
    assert np.abs(points[:, 1]).max() < 1e-9
    wall = wall_of(facade)
    assert shapely.contains_xy(wall.buffer(1e-9), points[:, 0], points[:, 2]).all()
    # No place on the wall is farther from a point than a cell of the grid is long (high up, 1.5 x wider).
    places = np.random.default_rng(0).random((20_000, 2)) * [facade.length, facade.height]
    places = places[shapely.contains_xy(wall, *places.T)]
    assert cKDTree(points[:, [0, 2]]).query(places)[0].max() < 0.1


def test_rays_stand_on_a_regular_grid():
    points = simulate_scan(plain(), options=AT_STATION, scene=Scene.empty()).points
    for angle in angles(points):
        steps = np.degrees(np.diff(np.unique(np.round(angle, 9)))) / 0.3
        np.testing.assert_allclose(steps, 1.0, atol=1e-4)


@pytest.mark.parametrize(
    ("facade", "count"),
    [(BUILDING_1, 264_931), (BUILDING_2, 190_865), (BUILDING_3, 650_306)],
    ids=["building 1", "building 2", "building 3"],
)
def test_step_gives_the_paper_s_number_of_points(facade, count):
    # Table 1 of the paper, NS00.
    step = step_for_spacing(facade, np.sqrt(facade.wall_area / count))
    cloud = simulate_scan(facade, options=ScannerOptions(angular_step=step), scene=Scene.empty())
    assert len(cloud) == pytest.approx(count, rel=0.01)


def test_depth_noise_is_the_range_noise_times_the_cosine():
    noise = 0.004
    options = replace(AT_STATION, angular_step=0.1, range_noise=noise)
    points = simulate_scan(plain(), options=options, scene=Scene.empty()).points
    ray = points - STATION
    cosine = ray[:, 1] / np.linalg.norm(ray, axis=1)
    assert cosine.min() < 0.9  # or the test could not tell
    for low, high in ((0.0, 0.9), (0.9, 0.97), (0.97, 1.0)):
        chosen = (cosine > low) & (cosine <= high)
        score = points[chosen, 1] / (noise * cosine[chosen])
        n = np.count_nonzero(chosen)
        lower, upper = chi2.ppf([1e-4, 1 - 1e-4], n) / n
        assert lower < np.mean(score**2) < upper
        assert abs(score.mean()) < 4.0 / np.sqrt(n)


def test_shadow_of_a_post_is_where_its_tangents_say():
    post = Post(1.6, -2.5, radius=0.12, height=3.0)
    bare = grid_nodes(plain(), AT_STATION, Scene.empty())
    behind = grid_nodes(plain(), AT_STATION, replace(Scene.empty(), objects=(post,)))
    points = np.array(list(bare.values()))
    missing = np.array([np.abs(behind[key][1]) > 1e-6 for key in bare])
    azimuth, elevation = angles(points)
    east, north = post.x - STATION[0], post.y - STATION[1]
    away = np.hypot(east, north)
    off_axis = azimuth - np.arctan2(east, north)
    within = np.abs(off_axis) < np.arcsin(post.radius / away)
    # Law of sines: where in plan the ray enters the circle; below the top there, it is stopped. A ray
    # that clears the rim in front is stopped by nothing, for it rises.
    chord = np.sqrt(np.maximum(post.radius**2 - (away * np.sin(off_axis)) ** 2, 0.0))
    entry = away * np.cos(off_axis) - chord
    expected = within & (STATION[2] + entry * np.tan(elevation) < post.height)
    assert 20 < expected.sum() < 0.2 * len(expected)
    np.testing.assert_array_equal(missing, expected)


def test_shadow_of_a_car_is_the_projection_of_its_boxes():
    car = Vehicle(2.0, -3.0)
    bare = grid_nodes(plain(), AT_STATION, Scene.empty())
    behind = grid_nodes(plain(), AT_STATION, replace(Scene.empty(), objects=(car,)))
    shadows = []
    for lower, upper in car.boxes:
        corners = np.array(np.meshgrid(*zip(lower, upper, strict=True))).reshape(3, -1).T
        reach = -STATION[1] / (corners[:, 1] - STATION[1])
        onto = STATION + reach[:, None] * (corners - STATION)
        shadows.append(shapely.MultiPoint(onto[:, [0, 2]]).convex_hull)
    points = np.array(list(bare.values()))
    expected = shapely.contains_xy(shapely.union_all(shadows), points[:, 0], points[:, 2])
    missing = np.array([np.abs(behind[key][1]) > 1e-6 for key in bare])
    assert 100 < expected.sum() < 0.5 * len(expected)
    np.testing.assert_array_equal(missing, expected)


def test_no_point_on_the_wall_is_inside_an_opening():
    facade = two_windows()
    options = replace(EXACT, angular_step=0.15, seed=4)
    points = simulate_scan(facade, options=options).points  # the street
    on_wall = np.abs(points[:, 1]) < 1e-6
    z_free = points[:, 2] > 1e-6  # the street ends at y = 0 too
    xz = points[on_wall & z_free][:, [0, 2]]
    assert len(xz) > 5000
    for opening in facade.openings:
        inner = shapely.Polygon(opening.outline).buffer(-1e-9)
        assert not shapely.contains_xy(inner, xz[:, 0], xz[:, 1]).any()


def test_an_opening_shows_reveal_frame_glass_and_room():
    facade, scene = two_windows(), Scene(ground=False, flank_depth=0.0, margin=0.02)
    share = 0.3
    options = replace(AT_STATION, angular_step=0.05, glass_return=share)
    points = simulate_scan(facade, options=options, scene=scene).points
    x, y, z = points.T
    opening = shapely.Polygon(facade.openings[1].outline)
    # Between face and frame: on the outline's extrusion.
    reveal = (y > 1e-6) & (y < scene.reveal_depth - 1e-6) & (z > 2.5)
    assert reveal.sum() > 100
    assert shapely.distance(shapely.points(x[reveal], z[reveal]), opening.boundary).max() < 1e-9
    # Where each ray towards this window crosses the panes.
    reach = (scene.reveal_depth - STATION[1]) / (y - STATION[1])
    across = STATION + reach[:, None] * (points - STATION)
    middle = 2.6 + 0.7
    panes = opening.buffer(-0.06).difference(shapely.box(middle - 0.03, 3.0, middle + 0.03, 4.8))
    beyond = y > scene.reveal_depth - 1e-9
    glazed = beyond & shapely.contains_xy(panes, across[:, 0], across[:, 2])
    framed = beyond & shapely.contains_xy(opening.difference(panes), across[:, 0], across[:, 2])
    assert framed.sum() > 100
    np.testing.assert_allclose(y[framed], scene.reveal_depth, atol=1e-9)
    returned = np.abs(y[glazed] - scene.reveal_depth) < 1e-9
    n = glazed.sum()
    assert n > 2000
    assert abs(returned.mean() - share) < 4.0 * np.sqrt(share * (1.0 - share) / n)
    room = points[glazed][~returned]
    # From below, the rays through an upper window meet the ceiling, 0.3 m above its head.
    assert (room[:, 1] <= scene.reveal_depth + scene.room_depth + 1e-9).all()
    np.testing.assert_allclose(room[room[:, 1] < 3.0][:, 2], 4.8 + 0.3, atol=1e-9)


def test_without_rooms_an_opening_returns_its_reveals_alone():
    scene = replace(Scene.empty(), reveal_depth=0.2)
    points = simulate_scan(two_windows(), options=AT_STATION, scene=scene).points
    inside = points[points[:, 1] > 1e-6]
    assert len(inside) > 20
    assert inside[:, 1].max() <= 0.2 + 1e-9


def test_ground_neighbours_and_flank_close_the_street():
    facade = plain()
    scene = Scene(neighbours=(Neighbour(-8.0, 0.0, -0.25, 5.0), Neighbour(5.0, 13.0, 0.3, 7.0)), margin=2.0)
    x, y, z = simulate_scan(facade, options=AT_STATION, scene=scene).points.T
    left, right = x < -1e-6, x > 5.0 + 1e-6
    raised = z > 1e-6
    np.testing.assert_allclose(y[left & raised], -0.25, atol=1e-9)
    np.testing.assert_allclose(y[right & raised], 0.3, atol=1e-9)
    flank = (np.abs(x) < 1e-9) & raised & (y < -1e-9)
    assert flank.sum() > 5
    assert y[flank].min() >= -0.25 - 1e-9
    assert z.min() > -1e-9
    lowest = np.degrees(angles(np.column_stack([x, y, z]))[1].min())
    assert -30.0 <= lowest < -29.0


def test_the_wall_s_own_flank_is_seen_from_the_side():
    options = replace(EXACT, stations=((-3.0, -4.0, 1.5),))
    x, y, _ = simulate_scan(plain(), options=options, scene=Scene(ground=False, flank_depth=0.35)).points.T
    flank = y > 1e-6
    assert flank.sum() > 20
    np.testing.assert_allclose(x[flank], 0.0, atol=1e-9)
    assert y[flank].max() <= 0.35


def test_mixed_pixels_lie_between_the_surfaces_and_are_as_many_as_the_beam_is_wide():
    post = Post(2.4, -4.0, radius=0.2, height=20.0)
    scene = replace(Scene.empty(), objects=(post,))
    divergence, step = 0.004, 0.05
    options = replace(
        AT_STATION, angular_step=step, beam_divergence=divergence, mixed_pixels=1.0, max_range=20.0
    )
    points = simulate_scan(plain(), options=options, scene=scene).points
    azimuth, elevation = angles(points)
    to_axis = np.hypot(points[:, 0] - post.x, points[:, 1] - post.y)
    mixed = (points[:, 1] < -1e-6) & (to_axis > post.radius + 1e-6)
    assert points[mixed, 1].max() < 0.0
    assert points[mixed, 1].min() > post.y - post.radius
    # A displacement by half the divergence, a, on a random side crosses an edge from either side with a mean
    # of 2a/π; azimuths are stretched by 1/cos of the elevation. Two edges as high as the wall is seen.
    heights = np.arange(elevation.min(), elevation.max(), np.radians(step))
    across = 2.0 * (0.5 * divergence) / np.pi / np.cos(heights) / np.radians(step)
    assert mixed.sum() == pytest.approx(2.0 * across.sum(), rel=0.12)
    assert np.abs(azimuth[mixed]).max() < np.arcsin(0.2 / 4.0) + 2 * divergence
    half = simulate_scan(plain(), options=replace(options, mixed_pixels=0.5), scene=scene).points
    to_axis = np.hypot(half[:, 0] - post.x, half[:, 1] - post.y)
    fewer = np.count_nonzero((half[:, 1] < -1e-6) & (to_axis > post.radius + 1e-6))
    assert fewer == pytest.approx(0.5 * mixed.sum(), rel=0.2)


def test_intensity_follows_material_and_incidence():
    options = replace(AT_STATION, angular_step=0.1, glass_return=1.0)
    cloud = simulate_scan(two_windows(), options=options, scene=Scene(ground=False, flank_depth=0, margin=0))
    points, strength = cloud.points, cloud.intensity
    assert strength.min() >= 0.0
    assert strength.max() <= 1.0
    ray = points - STATION
    cosine = ray[:, 1] / np.linalg.norm(ray, axis=1)
    wall = np.abs(points[:, 1]) < 1e-6
    slope = (strength[wall] @ cosine[wall]) / (cosine[wall] @ cosine[wall])
    assert slope == pytest.approx(0.55, abs=0.005)  # brick, as documented in REFLECTANCE
    assert np.std(strength[wall] - slope * cosine[wall]) == pytest.approx(0.02, rel=0.1)
    panes = np.abs(points[:, 1] - 0.12) < 1e-9
    assert np.median(strength[panes]) < 0.5 * np.median(strength[wall])


def test_same_seed_same_cloud():
    first, again, other = (
        simulate_scan(two_windows(), options=ScannerOptions(angular_step=0.5, seed=seed))
        for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(first.points, again.points)
    np.testing.assert_array_equal(first.intensity, again.intensity)
    assert len(other) != len(first) or not np.array_equal(other.points, first.points)
    assert first.source == "virtual scan, seed 3"


def test_world_coordinates_keep_survey_offsets_exact():
    turn = np.radians(37.0)
    axes = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    frame = FacadeFrame(np.array([3_692_001.234, 5_334_002.345, 519.6]), axes)
    here = simulate_scan(two_windows(), options=EXACT)
    there = simulate_scan(replace(two_windows(), frame=frame), options=EXACT)
    # By hand, in extended precision: origin + x X + y Y + z Z.
    expected = np.longdouble(frame.origin) + np.longdouble(here.points) @ np.longdouble(axes)
    assert float(np.abs(there.points - expected).max()) < 1e-6
    np.testing.assert_allclose(there.scanners, frame.to_world(here.scanners), atol=1e-6)
    np.testing.assert_allclose(here.scanners, [[0.53 * 5.0, -8.0, 1.6]])


def test_two_stations_each_scan_the_wall():
    options = replace(EXACT, stations=((1.0, -7.0, 1.6), (4.0, -9.0, 1.4)))
    both = simulate_scan(plain(), options=options, scene=Scene.empty())
    counts = [
        len(simulate_scan(plain(), options=replace(options, stations=(s,)), scene=Scene.empty()))
        for s in options.stations
    ]
    assert len(both) == pytest.approx(sum(counts), rel=0.02)
    np.testing.assert_allclose(both.scanners, options.stations)
    # Seen from its own station a point is on the grid of rays, which has few elevations.
    for number, station in enumerate(options.stations):
        for own in (True, False):
            seen = angles(both.points[(both.station == number) == own], np.array(station))[1]
            elevations = np.unique(seen.round(6))
            assert (len(elevations) < 0.05 * len(seen)) == own


def test_nothing_returns_from_beyond_the_range():
    cloud = simulate_scan(plain(), options=replace(AT_STATION, max_range=8.5), scene=Scene.empty())
    away = np.linalg.norm(cloud.points - STATION, axis=1)
    assert 8.4 < away.max() <= 8.5


def test_a_street_scan_shows_the_wall():
    cloud = simulate_scan(BUILDING_1)
    assert np.count_nonzero(np.abs(cloud.points[:, 1]) < 0.01) > 150_000


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"angular_step": -0.1}, "Invalid 'angular_step': expected a positive number, got -0.1"),
        ({"angular_step": 0.0}, "Invalid 'angular_step'"),
        ({"angular_step": 60.0}, "Invalid 'angular_step': expected 0 to 45, got 60"),
        ({"range_noise": -0.001}, "Invalid 'range_noise': expected 0 to 1, got -0.001"),
        ({"range_noise": np.nan}, "Invalid 'range_noise'"),
        ({"beam_divergence": 0.3}, "Invalid 'beam_divergence': expected 0 to 0.1, got 0.3"),
        ({"mixed_pixels": 1.5}, "Invalid 'mixed_pixels'"),
        ({"glass_return": -0.1}, "Invalid 'glass_return'"),
        ({"max_range": 0.0}, "Invalid 'max_range'"),
        ({"seed": -1}, "Invalid 'seed': expected 0 or more, got -1"),
        ({"stations": ((1.0, 2.0, 1.6),)}, "is in or behind the wall"),
        ({"stations": ((1.0, 0.0, 1.6),)}, "is in or behind the wall"),
        ({"stations": ((1.0, -8.0),)}, "expected three finite coordinates"),
        ({"stations": ((1.0, -8.0, np.inf),)}, "expected three finite coordinates"),
    ],
)
def test_bad_options_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        ScannerOptions(**change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"angular_step": 45.0, "stations": ((2.5, -200.0, 1.6),), "max_range": 500.0},
            "No ray meets the wall",
        ),
        ({"max_range": 2.0}, "No ray meets the wall: decrease the angular step"),
        ({"angular_step": 1e-4}, "asks for .* rays, more than 2e\\+08; increase it"),
        ({"stations": ((2.0, -3.0, -0.5),)}, "is under the ground; z must be positive"),
        ({"stations": ((2.0, -3.0, 0.6),)}, "is inside a vehicle; move it"),
    ],
)
def test_scans_that_cannot_be_made_are_refused(change, message):
    scene = Scene(objects=(Vehicle(2.0, -3.0),))
    with pytest.raises(InputError, match=message):
        simulate_scan(plain(), options=replace(EXACT, **change), scene=scene)


@pytest.mark.parametrize("spacing", [0.0, -1.0, np.nan])
def test_bad_spacing_is_refused(spacing):
    with pytest.raises(InputError, match="Invalid 'spacing'"):
        step_for_spacing(plain(), spacing)
