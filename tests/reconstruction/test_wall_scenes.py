"""Walls that bulge or lean, and what stands beside and before them: scenes made of planes, truth known."""

import numpy as np
import pytest
from synthetic import cleaned_cloud, facade_of, survey_frame

from fd2fem.errors import ReconstructionError
from fd2fem.model import FacadeFrame, PointCloud
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import facade_depth, find_facade

OPTIONS = ReconstructionOptions()
WINDOWS = [(1.0, 1.0, 1.2, 1.6), (3.8, 1.0, 1.2, 1.6)]
HOUSE = facade_of(6.0, 5.0, WINDOWS)
SCANNER = np.array([[3.0, -10.0, 1.6]])
RNG = np.random.default_rng(11)
NOISE = 0.003


def upright(x, y, z, density=2500):
    """Points on a rectangle parallel to the wall."""
    count = int((x[1] - x[0]) * (z[1] - z[0]) * density)
    depth = np.full(count, y) + RNG.normal(0, NOISE, count)
    return np.column_stack([RNG.uniform(*x, count), depth, RNG.uniform(*z, count)])


def across(x, y, z, density=2500):
    """Points on a rectangle square to the wall."""
    return upright(y, x, z, density)[:, [1, 0, 2]]


def level(x, y, z, density=2500):
    """Points on a level rectangle."""
    return upright(x, z, y, density)[:, [0, 2, 1]]


def box(x, y, z):
    return np.concatenate(
        [upright(x, y[0], z), *(across(end, y, z) for end in x), *(level(x, y, end) for end in z)]
    )


def wall(facade=HOUSE, spacing=0.025, at=(0.0, 0.0, 0.0), seed=0):
    return cleaned_cloud(facade, spacing, noise=NOISE, seed=seed).points + np.array(at)


def street():
    return level((-5, 11), (-9, 0), 0.0, density=300)


def car():
    return np.concatenate([box((1.0, 5.0), (-4.2, -2.5), (0.2, 1.5))])


def post(x, y, height=6.0):
    turn = RNG.uniform(0, 2 * np.pi, 5000)
    return np.column_stack([x + 0.1 * np.cos(turn), y + 0.1 * np.sin(turn), RNG.uniform(0, height, 5000)])


def find(*parts, scanners=SCANNER, frame=None, options=OPTIONS):
    frame = frame or FacadeFrame.identity()
    points = frame.to_world(np.concatenate(parts))
    away = frame.to_world(scanners) if len(scanners) else np.empty((0, 3))
    return find_facade(PointCloud(points, "scene", scanners=away), options=options)


def extent(found, frame=None):
    """Lower and upper corner of the wall's points in the frame of the scene."""
    frame = frame or FacadeFrame.identity()
    world = found.frame.to_world(np.insert(found.xz, 1, 0.0, axis=1))
    return frame.to_facade(world).min(axis=0), frame.to_facade(world).max(axis=0)


def assert_is_house(found):
    low, high = extent(found)
    assert low[[0, 2]] == pytest.approx([0.0, 0.02], abs=0.02)
    assert high[[0, 2]] == pytest.approx([6.0, 5.0], abs=0.02)


@pytest.mark.parametrize(("length", "bow"), [(6.0, 0.06), (4.0, 0.08), (10.0, -0.07)])
@pytest.mark.parametrize("spacing", [0.025, 0.075])
def test_bulging_wall_is_followed_to_its_ends(length, bow, spacing):
    facade = facade_of(length, 5.0, [(1.0, 1.0, 1.2, 1.6)])
    points = wall(facade, spacing)
    x = points[:, 0]
    depth = -4.0 * bow * x / length * (1.0 - x / length)
    found = find(np.column_stack([x, points[:, 1] + depth, points[:, 2]]))
    assert len(found.xz) > 0.998 * len(points)
    assert np.ptp(found.xz[:, 0]) == pytest.approx(length, abs=spacing)
    assert found.rms == pytest.approx(NOISE, rel=0.1)
    # Points without noise on the parabola lie on the face that was found.
    true = found.frame.to_facade(np.column_stack([x, depth, points[:, 2]]))
    off = facade_depth(found, true)
    assert np.sqrt(np.mean(off**2)) < 0.0012
    assert np.abs(off).max() < 0.008
    # The map's values reach up to a quarter of a metre beyond the wall, where the parabola goes on.
    assert abs(bow) * 0.95 < np.ptp(found.relief.values[~np.isnan(found.relief.values)]) < abs(bow) * 1.4
    assert any(warning.startswith("The wall's face bulges") for warning in found.warnings)


def test_flat_wall_has_no_relief():
    found = find(wall())
    assert np.nanmax(np.abs(found.relief.values)) < 1e-4
    assert not any("bulges" in warning for warning in found.warnings)


def test_frames_in_the_openings_do_not_bend_the_face():
    frames = [upright((x, x + width), 0.12, (z, z + height), density=3000) for x, z, width, height in WINDOWS]
    found = find(wall(), *frames)
    assert np.nanmax(np.abs(found.relief.values)) < 1e-4
    assert found.rms == pytest.approx(NOISE, rel=0.05)
    low, _ = extent(found)
    moved = found.xz - found.xz.min(axis=0) + low[[0, 2]]
    inside = [
        ((moved > [x + 0.1, z + 0.1]) & (moved < [x + 1.1, z + 1.5])).all(axis=1) for x, z, *_ in WINDOWS
    ]
    assert not np.any(inside)


@pytest.mark.parametrize("degrees", [3.0, 9.5, -9.5])
def test_frame_follows_a_leaning_wall(degrees):
    lean = np.radians(degrees)
    turned = np.array([[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]])
    found = find(wall() @ turned, street(), car())
    # Rows of `turned` are where the wall's own axes come to lie.
    assert found.frame.axes == pytest.approx(turned, abs=2e-4)
    assert np.ptp(found.xz, axis=0) == pytest.approx([6.0, 5.0], abs=0.04)


def test_plane_that_leans_too_much_is_no_wall():
    lean = np.radians(14.0)
    turned = np.array([[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]])
    with pytest.raises(ReconstructionError, match="leans by more than 10 degrees"):
        find(wall() @ turned)


@pytest.mark.parametrize("gap", [0.15, 0.4])
@pytest.mark.parametrize("scanners", [SCANNER, np.empty((0, 3))])
def test_flush_neighbour_beyond_a_joint_is_cut_off(gap, scanners):
    neighbour = wall(facade_of(4.0, 6.0, [(1, 1, 1, 1.5)]), at=(6.0 + gap, 0, 0), seed=3)
    found = find(wall(), neighbour, street(), scanners=scanners)
    assert_is_house(found)
    assert any("beyond a joint" in warning for warning in found.warnings)


def test_scanner_tells_which_side_of_a_joint_is_the_wall():
    neighbour = wall(facade_of(4.0, 6.0, [(1, 1, 1, 1.5)]), at=(6.15, 0, 0), seed=3)
    low, high = extent(find(wall(), neighbour, street(), scanners=np.array([[8.0, -9.0, 1.6]])))
    assert [low[0], high[0]] == pytest.approx([6.15, 10.15], abs=0.02)


@pytest.mark.parametrize("before", [0.15, 1.2])
@pytest.mark.parametrize("scanners", [SCANNER, np.empty((0, 3))])
def test_strip_in_the_shadow_of_a_post_is_no_joint(before, scanners):
    points = wall(facade_of(6.0, 5.0, []))
    # The post at x = 3.3 hides about 0.2 m of wall over its full height.
    at = 3.0 + (3.3 - 3.0) * 10.0 / (10.0 - before)
    points = points[np.abs(points[:, 0] - at) > 0.11]
    found = find(points, post(3.3, -before, height=6.0), street(), scanners=scanners)
    assert_is_house(found)


@pytest.mark.parametrize("step", [0.05, 0.1, 0.3, -0.05, -0.1, -0.3])
def test_neighbour_whose_face_is_set_off_does_not_join(step):
    neighbour = wall(facade_of(4.0, 6.0, [(1, 1, 1, 1.5)]), at=(6.0, step, 0), seed=3)
    found = find(wall(), neighbour, street())
    assert_is_house(found)
    assert np.nanmax(np.abs(found.relief.values)) < 0.003


@pytest.mark.parametrize("spacing", [0.025, 0.075])
def test_wall_on_thin_piers_is_one_wall(spacing):
    shop = facade_of(6.0, 4.0, [(0.3, 0, 1.65, 3.6), (2.25, 0, 1.5, 3.6), (4.05, 0, 1.65, 3.6)])
    found = find(wall(shop, spacing), street())
    assert np.ptp(found.xz, axis=0) == pytest.approx([6.0, 4.0], abs=1.5 * spacing + 0.02)


@pytest.mark.parametrize("radius", [2.0, 5.0, 20.0])
def test_round_wall_is_refused(radius):
    turn = RNG.uniform(-1.2, 1.2, 100_000) * min(1.0, 6.0 / radius)
    tower = np.column_stack(
        [radius * np.sin(turn), radius * (1.0 - np.cos(turn)), RNG.uniform(0, 8, len(turn))]
    )
    with pytest.raises(ReconstructionError, match="is round"):
        find(tower + RNG.normal(0, 0.002, tower.shape), scanners=np.array([[0.0, -12.0, 1.6]]))


def two_facades():
    side = wall(facade_of(7.0, 4.0, [(1, 1, 1, 1.5)]), seed=2)[:, [1, 0, 2]] + np.array([10.0, -8.0, 0.0])
    return wall(), side, street()


def test_walls_are_listed_and_picked_by_number():
    first = find(*two_facades())
    assert_is_house(first)
    assert [candidate.chosen for candidate in first.walls] == [True, False]
    assert [candidate.length for candidate in first.walls] == pytest.approx([6.0, 7.0], abs=0.1)
    assert [candidate.height for candidate in first.walls] == pytest.approx([5.0, 4.0], abs=0.1)
    # 60 and 53 points in each square decimetre, estimated from a sample.
    assert first.walls[0].points == pytest.approx(len(first.xz), rel=0.05)
    # The scanner stands south of the one and west of the other.
    assert [candidate.facing for candidate in first.walls] == pytest.approx([180.0, 270.0], abs=0.1)
    assert first.walls[1].centre == pytest.approx([10.0, -4.5, 2.0], abs=0.1)
    second = find(*two_facades(), options=ReconstructionOptions(wall=2))
    assert [candidate.chosen for candidate in second.walls] == [False, True]
    low, high = extent(second)
    assert low == pytest.approx([10.0, -8.0, 0.02], abs=0.02)
    assert high == pytest.approx([10.0, -1.0, 4.0], abs=0.02)
    assert second.frame.axes[1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)


def test_second_wall_may_stand_in_the_plane_of_the_first():
    other = wall(facade_of(7.0, 4.0, [(1, 1, 1, 1.5)]), at=(8.5, 0, 0), seed=2)
    low, high = extent(find(wall(), other, street(), options=ReconstructionOptions(wall=2)))
    assert [low[0], high[0]] == pytest.approx([8.5, 15.5], abs=0.02)


def test_wall_that_is_not_there_is_refused():
    with pytest.raises(ReconstructionError, match=r"shows 2 walls \(1: 6.0 x 5.0 m, 2: 7.\d x 4.0 m\)"):
        find(*two_facades(), options=ReconstructionOptions(wall=3))


@pytest.mark.parametrize("scanners", [SCANNER, np.empty((0, 3))])
def test_attachments_are_told_apart_and_free_standing_things_are_none(scanners):
    things = [
        box((0.0, 6.0), (-0.3, 0.0), (4.7, 5.0)),  # cornice
        box((0.3, 0.42), (-0.18, -0.06), (0.0, 4.7)),  # downpipe that runs up to it
        box((2.4, 3.6), (-1.0, 0.0), (2.9, 3.05)),  # balcony
        upright((2.4, 3.6), -1.0, (3.05, 3.95), density=600),  # and its railing
        box((4.7, 5.8), (-0.8, 0.0), (0.7, 3.0)),  # bay window
    ]
    found = find(wall(), *things, car(), post(1.6, -1.2), street(), scanners=scanners)
    assert_is_house(found)
    low, _ = extent(found)
    shift = low[[0, 2]] - found.xz.min(axis=0)
    boxes = {
        each.kind: (each.x + shift[0], each.z + shift[1], each.width, each.height, each.projection)
        for each in found.attachments
    }
    assert len(found.attachments) == len(boxes) == 4
    # Where a pipe meets a cornice, and near the wall's ends and the ground, a box is cut; voxels are 0.15 m.
    assert boxes["cornice"] == pytest.approx((0.1, 4.7, 5.8, 0.3, 0.3), abs=0.17)
    assert boxes["downpipe"] == pytest.approx((0.3, 0.5, 0.12, 4.1, 0.18), abs=0.17)
    assert boxes["balcony"] == pytest.approx((2.4, 2.9, 1.2, 1.05, 1.0), abs=0.08)
    assert boxes["bay"] == pytest.approx((4.7, 0.7, 1.1, 2.3, 0.8), abs=0.08)


def test_rooms_ceilings_and_roofs_do_not_matter():
    room = [
        upright((0.5, 5.5), 4.0, (0.2, 2.6), density=3000),
        level((0.5, 5.5), (0.5, 4.0), 2.6, density=3000),
        level((-0.3, 6.3), (-0.4, 3.0), 5.6, density=1500),
    ]
    assert_is_house(find(wall(), *room, street(), car()))


def test_pavement_may_rise_along_the_wall():
    points, ground = wall(), street()
    rise = 0.05
    points = points[points[:, 2] > rise * (points[:, 0] - 3.0)]
    ground[:, 2] += rise * (ground[:, 0] - 3.0)
    found = find(points, ground, car())
    assert found.ground_slope == pytest.approx(rise, abs=5e-4)
    low, _ = extent(found)
    assert found.ground - found.xz[:, 1].min() + low[2] == pytest.approx(0.0, abs=0.003)
    assert np.ptp(found.xz, axis=0) == pytest.approx([6.0, 5.0], abs=0.06)


def test_rest_of_a_building_lies_behind_its_faces():
    # Four sides, no scanner, no ground, and the origin, which could be taken for the scanner, inside.
    length, width = 12.0, 7.0
    sides = np.concatenate(
        [
            wall(facade_of(length, 5.0, [(2, 1, 1, 1.5)])),
            wall(facade_of(length, 5.0, [(2, 1, 1, 1.5)]), at=(0, width, 0)),
            across(0.0, (0, width), (0, 5), density=1600),
            across(length, (0, width), (0, 5), density=1600),
        ]
    ) - np.array([length / 2, width / 2, 0.0])
    for number in (1, 2):
        found = find(sides, scanners=np.empty((0, 3)), options=ReconstructionOptions(wall=number))
        # y points to the middle of the building.
        assert found.frame.axes[1][1] * found.frame.origin[1] < 0.0
        assert {round(candidate.facing) % 360 for candidate in found.walls[:2]} == {0, 180}
        assert not found.outside_by.startswith("the origin")


@pytest.mark.parametrize(("degrees", "origin"), [(0.0, (0.0, 0.0, 0.0)), (143.0, (715_830.0, 5e6, 412.5))])
def test_order_rotation_and_offset_give_the_same_wall(degrees, origin):
    neighbour = wall(facade_of(4.0, 6.0, [(1, 1, 1, 1.5)]), at=(6.0, 0.25, 0), seed=3)
    parts = np.concatenate([wall(), neighbour, np.random.default_rng(5).permutation(street_and_car())])
    frame = survey_frame(degrees, origin)
    here = find(parts)
    there = find(np.random.default_rng(6).permutation(parts), frame=frame)
    assert there.frame.axes @ frame.axes.T == pytest.approx(here.frame.axes, abs=1e-7)
    assert abs(len(there.xz) - len(here.xz)) <= 2
    # The pavement's level moves by hundredths of a millimetre, and single points beside it come or go.
    assert np.concatenate(extent(there, frame)) == pytest.approx(np.concatenate(extent(here)), abs=5e-4)
    assert there.spacing == pytest.approx(here.spacing, rel=1e-3)


def street_and_car():
    rng = np.random.default_rng(4)
    x, y = rng.uniform(-5, 11, 20_000), rng.uniform(-9, 0, 20_000)
    ground = np.column_stack([x, y, rng.normal(0, 0.003, 20_000)])
    flank = np.column_stack([rng.uniform(1, 5, 8000), np.full(8000, -2.5), rng.uniform(0.2, 1.5, 8000)])
    return np.concatenate([ground, flank])


def test_dense_wall_is_thinned_and_stays_as_it_was():
    # 3.3 mm apart: more than twice as dense as needed.
    count = 90_000 * 6
    xz = np.random.default_rng(8).uniform(0.0, 1.0, (count, 2)) * [3.0, 2.0]
    depth = np.random.default_rng(9).normal(0.0, 0.002, count)
    found = find(np.insert(xz, 1, depth, axis=1), scanners=np.array([[1.5, -5.0, 1.0]]))
    assert len(found.xz) == pytest.approx(40_000 * 6, rel=0.1)
    assert found.spacing == pytest.approx(0.005, rel=0.06)
    assert np.ptp(found.xz, axis=0) == pytest.approx([3.0, 2.0], abs=0.001)
    # Evenly random still: a tenth of the area holds a tenth of the points.
    share = np.histogram2d(*found.xz.T, bins=(5, 2))[0] / len(found.xz)
    assert share == pytest.approx(np.full((5, 2), 0.1), abs=0.003)
