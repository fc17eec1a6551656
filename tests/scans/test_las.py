"""LAS and LAZ against files that laspy itself writes."""

import struct

import laspy
import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import PointCloud
from fd2fem.scans.las import read_las, write_las

SURVEY = np.array([1674321.0, 5403210.0, 512.0])


def wall(n=500):
    return np.random.default_rng(3).uniform([0, -0.01, 0], [5, 0.01, 12], (n, 3)) + SURVEY


def laspy_file(path, *, point_format, version):
    """A file by laspy: coordinates on a grid of 1/1024 m, which a LAS scale can hold exactly."""
    header = laspy.LasHeader(point_format=point_format, version=version)
    header.scales, header.offsets = np.full(3, 1 / 1024), SURVEY
    las = laspy.LasData(header)
    counts = np.random.default_rng(4).integers(0, 10000, (300, 3))
    las.X, las.Y, las.Z = counts.T
    las.intensity = np.linspace(0, 65535, 300).astype(np.uint16)
    las.write(path)
    return counts / 1024 + SURVEY, np.linspace(0, 65535, 300).astype(np.uint16) / 65535


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize(
    ("point_format", "version"), [(0, "1.2"), (3, "1.2"), (1, "1.3"), (6, "1.4"), (7, "1.4")]
)
def test_files_written_by_laspy(tmp_path, suffix, point_format, version):
    path = tmp_path / f"a.{suffix}"
    points, intensity = laspy_file(path, point_format=point_format, version=version)
    raw = read_las(path)
    assert np.array_equal(raw.points, points)
    assert np.array_equal(raw.intensity, intensity)
    assert raw.scanners.shape == (0, 3)


@pytest.mark.parametrize(("suffix", "compressed"), [("las", False), ("LAZ", True)])
def test_written_file_read_by_laspy(tmp_path, suffix, compressed):
    points, intensity = wall(), np.linspace(0, 1, 500)
    write_las(PointCloud(points, "", intensity), tmp_path / f"a.{suffix}")
    with laspy.open(tmp_path / f"a.{suffix}") as file:
        assert file.header.are_points_compressed is compressed
        las = file.read()
    assert np.abs(las.xyz - points).max() <= 0.5001e-4  # half a step
    assert np.abs(las.intensity / 65535 - intensity).max() <= 0.5001 / 65535
    assert (las.header.scales == 1e-4).all()


def test_round_trip_with_scanners(tmp_path):
    scanners = SURVEY + np.array([[2.123456789, -8.0, 1.6], [9.0, -12.5, 1.1]])
    write_las(PointCloud(wall(), "", scanners=scanners), tmp_path / "a.laz")
    raw = read_las(tmp_path / "a.laz")
    assert np.array_equal(raw.scanners, scanners)
    assert len(raw.intensity) == 0


def test_scanners_survive_another_program(tmp_path):
    write_las(PointCloud(wall(), "", scanners=SURVEY[np.newaxis]), tmp_path / "a.laz")
    laspy.read(tmp_path / "a.laz").write(tmp_path / "b.las")
    assert np.array_equal(read_las(tmp_path / "b.las").scanners, SURVEY[np.newaxis])


@pytest.mark.parametrize(
    "payload",
    [b"{", b'{"scanners": 3, "x": "y"', b"[]", b'{"scanners": [["a", 1, 2]]}', b'{"scanners": [[1, 2]]}'],
)
def test_damaged_scanner_record(tmp_path, payload):
    las = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    las.xyz = np.eye(3)
    las.header.vlrs.append(laspy.VLR("fd2fem", 1, "", payload))
    las.write(tmp_path / "a.las")
    with pytest.raises(InputError, match="record of scanner positions is damaged"):
        read_las(tmp_path / "a.las")


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("kept", [3, 100, 300, 0.5, 0.99])
def test_cut_short(tmp_path, suffix, kept):
    path = tmp_path / f"a.{suffix}"
    write_las(PointCloud(wall(), ""), path)
    data = path.read_bytes()
    path.write_bytes(data[: kept if kept > 1 else int(kept * len(data))])
    with pytest.raises(InputError, match=r"cut short|damaged|does not begin with LASF") as caught:
        read_las(path)
    assert "\n" not in str(caught.value)


def test_counts_of_points_in_the_message(tmp_path):
    path = tmp_path / "a.las"
    write_las(PointCloud(wall(), ""), path)
    path.write_bytes(path.read_bytes()[: 375 + 30 * 123 + 7])  # header 1.4, point format 6: 30 bytes each
    with pytest.raises(InputError, match="its header says 500 points, the file holds 123"):
        read_las(path)


@pytest.mark.parametrize(
    ("offset", "layout", "value"),
    [(94, "<H", 65535), (96, "<I", 2**31), (100, "<I", 2**32 - 1), (105, "<H", 0), (247, "<Q", 2**60)],
)
def test_damaged_header_takes_no_memory(tmp_path, offset, layout, value):
    path = tmp_path / "a.las"
    write_las(PointCloud(wall(), ""), path)
    data = bytearray(path.read_bytes())
    struct.pack_into(layout, data, offset, value)
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"damaged|cut short"):
        read_las(path)


@pytest.mark.parametrize(
    ("points", "name", "message"),
    [
        (wall(), "a.ply", r"must end in \.las or \.laz"),
        (np.empty((0, 3)), "a.las", "the cloud has no points"),
        (np.array([[0, 0, 0], [3e5, 0, 0]]), "a.las", r"points are 300000 m apart"),
        (wall(), "missing/a.las", "cannot be written: No such file"),
    ],
)
def test_what_is_not_written(tmp_path, points, name, message):
    with pytest.raises(InputError, match=message):
        write_las(PointCloud(points, ""), tmp_path / name)
    assert not (tmp_path / name).exists()
