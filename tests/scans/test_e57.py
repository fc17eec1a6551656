"""E57 against files that pye57, that is libE57Format, writes."""

import sys
import uuid

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fd2fem.errors import InputError
from fd2fem.scans.e57 import read_e57
from fd2fem.scans.readers import read_scan
from fd2fem.scans.units import Units

pye57 = pytest.importorskip("pye57")  # no wheels for some platforms
libe57 = pye57.libe57

SURVEY = np.array([674321.0, 5403210.0, 512.0])
STATION = SURVEY + np.array([2.25, -9.5, 1.625])


def wall(n=300, seed=0):
    """Points on a wall of 5 x 12 m."""
    return np.random.default_rng(seed).uniform([0, -0.01, 0], [5, 0.01, 12], (n, 3))


def turn(degrees=37.0):
    return Rotation.from_euler("zx", [degrees, 0.5], degrees=True)


def write_simple(path, scans):
    """Write scans by pye57's own function, float32: (own points, rotation, translation, more fields)."""
    with pye57.E57(str(path), mode="w") as file:
        for own, rotation, translation, more in scans:
            data = {f"cartesian{name}": np.ascontiguousarray(own[:, i]) for i, name in enumerate("XYZ")}
            quaternion = rotation.as_quat()[[3, 0, 1, 2]]
            file.write_scan_raw(data | more, rotation=quaternion, translation=np.asarray(translation))
    return path


def write_fields(path, fields, *, pose=None, extra=None):
    """Write one scan node by node: `fields` maps names to (node of the prototype, values)."""
    with pye57.E57(str(path), mode="w") as file:
        image = file.image_file
        scan = libe57.StructureNode(image)
        scan.set("guid", libe57.StringNode(image, str(uuid.UUID(int=1))))
        if pose is not None:
            node = libe57.StructureNode(image)
            scan.set("pose", node)
            for name, numbers in pose.items():
                part = libe57.StructureNode(image)
                node.set(name, part)
                for axis, number in numbers.items():
                    part.set(axis, libe57.FloatNode(image, number))
        prototype = libe57.StructureNode(image)
        buffers = libe57.VectorSourceDestBuffer()
        for name, (make, values) in fields.items():
            prototype.set(name, make(image))
            buffers.append(libe57.SourceDestBuffer(image, name, values, len(values), True, True))
        if extra is not None:
            prototype.set(extra, libe57.FloatNode(image, 0.0))
        points = libe57.CompressedVectorNode(image, prototype, libe57.VectorNode(image, True))
        scan.set("points", points)
        file.data3d.append(scan)
        writer = points.writer(buffers)
        writer.write(len(values))
        writer.close()
    return path


def double(image):
    return libe57.FloatNode(image, 0.0, libe57.E57_DOUBLE, -1e7, 1e7)


def state(image):
    return libe57.IntegerNode(image, 0, 0, 2)


def cartesian(points, node=double):
    columns = np.ascontiguousarray(points.T)
    return {f"cartesian{name}": (node, column) for name, column in zip("XYZ", columns, strict=True)}


def test_pose_and_station(tmp_path):
    own = turn().inv().apply(wall() + SURVEY - STATION)
    path = write_simple(tmp_path / "a.e57", [(own, turn(), STATION, {})])
    raw = read_e57(path)
    # float32 up to 16 m: half a step of 2**-20 m along each axis of the scanner.
    assert np.abs(raw.points - (wall() + SURVEY)).max() <= 3 * 2.0**-21
    assert np.allclose(raw.scanners, [STATION], rtol=0, atol=1e-9)
    assert (raw.station == 0).all()
    assert raw.units is Units.M


def test_as_pye57_reads_it(tmp_path):
    own = turn().inv().apply(wall() + SURVEY - STATION)
    path = write_simple(tmp_path / "a.e57", [(own, turn(), STATION, {})])
    with pye57.E57(str(path)) as file:
        data = file.read_scan(0, ignore_missing_fields=True)
        position = file.scan_position(0)
    other = np.column_stack([data[f"cartesian{name}"] for name in "XYZ"])
    raw = read_e57(path)
    assert np.allclose(raw.points, other, rtol=0, atol=1e-8)
    assert np.allclose(raw.scanners, position, rtol=0, atol=1e-8)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.integers(4, 60))
def test_any_pose_comes_back_in_double_precision(tmp_path_factory, seed, count):
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(random_state=rng)
    world = STATION + rng.normal(scale=10.0, size=(count, 3))
    quaternion = dict(zip("xyzw", map(float, 2.5 * rotation.as_quat()), strict=True))  # of any length
    path = write_fields(
        tmp_path_factory.mktemp("any") / "a.e57",
        cartesian(rotation.inv().apply(world - STATION)),
        pose={"rotation": quaternion, "translation": dict(zip("xyz", map(float, STATION), strict=True))},
    )
    raw = read_e57(path)
    assert np.allclose(raw.points, world, rtol=0, atol=1e-8)  # doubles near 5e6 have steps of 1e-9
    assert np.allclose(raw.scanners, [STATION], rtol=0, atol=0)


def test_several_scans(tmp_path):
    positions = [STATION + np.array([3.0 * k, 0.5, 0.125]) for k in range(3)]
    scans = [
        (turn(50 * k).inv().apply(wall(100 + k, k) + SURVEY - position), turn(50 * k), position, {})
        for k, position in enumerate(positions)
    ]
    cloud = read_scan(write_simple(tmp_path / "a.e57", scans))
    assert np.bincount(cloud.station).tolist() == [100, 101, 102]
    assert np.allclose(cloud.scanners, positions, rtol=0, atol=1e-9)
    # Each wall is where it was, and 5 x 12 m.
    assert np.abs(cloud.points[cloud.station == 2] - wall(102, 2) - SURVEY).max() < 1e-5


def test_scaled_integers(tmp_path):
    # As most scanners write: steps of 0.1 mm.
    steps = np.rint(wall() * 1e4)
    fields = cartesian(
        steps / 1e4,
        lambda image: libe57.ScaledIntegerNode(image, 0, -(2**31), 2**31, 1e-4, 0.0),
    )
    raw = read_e57(write_fields(tmp_path / "a.e57", fields))
    assert np.allclose(raw.points, steps / 1e4, rtol=0, atol=1e-12)


def test_spherical_coordinates(tmp_path):
    own = wall() + np.array([-2.0, 9.0, -1.5])
    distance = np.linalg.norm(own, axis=1)
    fields = {
        "sphericalRange": (double, distance),
        "sphericalAzimuth": (double, np.arctan2(own[:, 1], own[:, 0])),
        "sphericalElevation": (double, np.arcsin(own[:, 2] / distance)),
        "sphericalInvalidState": (state, (np.arange(300) % 10 == 0).astype(np.int8)),
    }
    raw = read_e57(write_fields(tmp_path / "a.e57", fields))
    back = np.arange(300) % 10 != 0
    assert np.allclose(raw.points, own[back], rtol=0, atol=1e-12)
    assert raw.no_returns == 30
    assert raw.scanners.tolist() == [[0.0, 0.0, 0.0]]  # ranges are from the scanner


def test_rays_without_a_return_and_intensity(tmp_path):
    own = wall() + np.array([-2.0, 9.0, -1.5])
    own[5] = own[7] = 0.0
    states = np.zeros(300, dtype=np.int8)
    states[[0, 4]], states[9] = 1, 2
    strength = np.linspace(0.0, 1.0, 300)
    path = write_simple(
        tmp_path / "a.e57",
        [(own, turn(), STATION, {"intensity": strength, "cartesianInvalidState": states})],
    )
    raw = read_e57(path)
    back = np.setdiff1d(np.arange(300), [0, 4, 5, 7, 9])
    assert raw.no_returns == 5
    assert np.abs(raw.points - turn().apply(own[back]) - STATION).max() < 1e-5
    assert np.abs(raw.intensity - strength[back]).max() <= 2.0**-24


def test_large_scans_are_read_in_pieces(tmp_path, monkeypatch):
    path = write_simple(
        tmp_path / "a.e57", [(wall(), turn(), STATION, {"intensity": np.linspace(0, 1, 300)})]
    )
    whole = read_e57(path)
    monkeypatch.setattr("fd2fem.scans.e57.CHUNK", 7)
    pieces = read_e57(path)
    assert np.array_equal(pieces.points, whole.points)
    assert np.array_equal(pieces.intensity, whole.intensity)


IDENTITY = Rotation.identity()
AWAY = np.array([-2.0, 9.0, -1.5])


@pytest.mark.parametrize(
    ("points", "rotation", "translation", "known"),
    [
        (wall() + AWAY, IDENTITY, [0, 0, 0], True),  # one scan, not registered
        (wall() + SURVEY, IDENTITY, [0, 0, 0], False),  # the world's origin is no place for a scanner
        (wall(20000), IDENTITY, [0, 0, 0], False),  # the origin lies in the wall
        (wall() + AWAY, IDENTITY, [674300, 5403200, 0], False),  # an offset, as CloudCompare writes it
        (wall() + AWAY, IDENTITY, [4.25, -9.0, 1.6], True),
        (wall() + AWAY, turn(), [0, 0, 0], True),
    ],
)
def test_poses_that_are_no_positions(tmp_path, points, rotation, translation, known):
    fields = cartesian(points)
    quaternion = dict(zip("xyzw", map(float, rotation.as_quat()), strict=True))
    pose = {"rotation": quaternion, "translation": dict(zip("xyz", map(float, translation), strict=True))}
    raw = read_e57(write_fields(tmp_path / "a.e57", fields, pose=pose))
    assert np.allclose(raw.points, rotation.apply(points) + translation, rtol=0, atol=1e-8)
    assert np.isfinite(raw.scanners).all() == known


def test_without_a_pose(tmp_path):
    cloud = read_scan(write_fields(tmp_path / "a.e57", cartesian(wall() + AWAY)))
    assert len(cloud.scanners) == 0
    assert len(cloud.station) == 0


def test_half_a_pose(tmp_path):
    pose = {"translation": dict(zip("xyz", STATION.tolist(), strict=True))}
    raw = read_e57(write_fields(tmp_path / "a.e57", cartesian(wall() + AWAY), pose=pose))
    assert np.allclose(raw.points, wall() + AWAY + STATION, rtol=0, atol=1e-8)
    pose = {"rotation": {"w": 1.0, "x": 0.0, "y": 0.0, "z": 1.0}}  # a quarter turn
    raw = read_e57(write_fields(tmp_path / "b.e57", cartesian(wall()), pose=pose))
    assert np.allclose(raw.points, wall() @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], rtol=0, atol=1e-12)


def test_float32_survey_coordinates_are_refused(tmp_path):
    path = write_simple(tmp_path / "a.e57", [(wall() + SURVEY, IDENTITY, [0, 0, 0], {})])
    with pytest.raises(InputError, match=r"has lost precision: float32 coordinates .* 500 mm apart"):
        read_scan(path)


def test_metres_by_definition(tmp_path):
    low = wall() * [1, 1, 0.1]
    assert read_scan(write_fields(tmp_path / "a.e57", cartesian(low))).points[:, 2].max() < 1.2
    wrong = write_fields(tmp_path / "b.e57", cartesian(wall() * 1000))
    with pytest.raises(InputError, match=r"b\.e57 is 1.*e\+04 m high .* say --units"):
        read_scan(wrong)
    assert np.allclose(read_scan(wrong, units=Units.MM).points, wall(), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("pose", "message"),
    [({"rotation": dict.fromkeys("wxyz", 0.0)}, r"the rotation \[0\.0, 0\.0, 0\.0, 0\.0\]: export it anew")],
)
def test_a_pose_that_is_none(tmp_path, pose, message):
    path = write_fields(tmp_path / "a.e57", cartesian(wall()), pose=pose)
    with pytest.raises(InputError, match=message):
        read_e57(path)


def test_what_is_no_scan(tmp_path):
    with pye57.E57(str(tmp_path / "a.e57"), mode="w"):
        pass
    with pytest.raises(InputError, match="holds no scan"):
        read_e57(tmp_path / "a.e57")
    path = write_fields(tmp_path / "b.e57", {"intensity": (double, np.ones(5))})
    with pytest.raises(InputError, match="scan 1 has no coordinates, only intensity"):
        read_e57(path)
    fields = cartesian(wall())
    fields["cartesianY"][1][3] = np.nan
    path = write_fields(tmp_path / "c.e57", fields)
    with pytest.raises(InputError, match="1 of 300 points have a coordinate that is NaN"):
        read_e57(path)


@settings(max_examples=60, deadline=None)
@given(place=st.integers(0, 2**30), value=st.integers(0, 255), kept=st.floats(0.1, 1.0))
def test_damage_is_refused_or_does_no_harm(tmp_path_factory, place, value, kept):
    folder = tmp_path_factory.mktemp("any")
    write_simple(folder / "whole.e57", [(wall(), turn(), STATION, {})])
    content = bytearray((folder / "whole.e57").read_bytes())
    content[place % len(content)] = value
    (folder / "a.e57").write_bytes(content[: int(kept * len(content))])
    try:
        raw = read_e57(folder / "a.e57")
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
        assert "a.e57" in str(error)  # noqa: PT017
    else:
        assert len(raw.points) == 300


def test_without_pye57(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pye57", None)
    (tmp_path / "a.e57").write_bytes(b"ASTM-E57")
    with pytest.raises(InputError, match=r"a\.e57 needs pye57 to be read: pip install pye57, or convert"):
        read_e57(tmp_path / "a.e57")
